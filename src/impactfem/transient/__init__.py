"""The stage transient: impacts and ground motion on the 3D building."""
