"""Fitting keys of a case to what is known of its buildings, and what that tells about the keys."""
