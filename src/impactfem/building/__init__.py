"""The 3D model of one building: mesh, shells and beams, matrices."""
