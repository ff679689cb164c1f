"""Equipment on the 3D building: devices in it, against response spectrum analysis."""
