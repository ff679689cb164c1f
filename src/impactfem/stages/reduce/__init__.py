"""The stage `reduce`: the 3D building in few coordinates, for all that comes after it."""
