"""Fitting keys of a case to what is known of its buildings, and how well it determines them."""
