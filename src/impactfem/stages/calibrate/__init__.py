"""The stage `calibrate`: impact of the 3D building on a rigid wall, and of the stick."""
