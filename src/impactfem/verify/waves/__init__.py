"""Waves, and the 3D building in time."""
