"""Design spectra of the 3D building, of one motion and of an ensemble of motions."""
