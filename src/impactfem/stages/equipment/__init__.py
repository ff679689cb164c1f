"""The stage `equipment`: the items of an equipment list on floors of sticks and 3D models."""
