"""The 3D building in few coordinates: Krylov basis, error band, loads, response."""
