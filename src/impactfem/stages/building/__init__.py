"""The stage `building`: mesh, matrices and modes of the 3D building."""
