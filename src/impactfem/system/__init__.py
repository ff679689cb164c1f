"""Ranks, signals, files, memory, log and errors: what knows nothing of the subject."""
