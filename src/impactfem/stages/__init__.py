"""The stages, and what they share: declaration, keys of inputs, stores, checks."""
