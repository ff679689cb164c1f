"""The stage `design`: floor spectra of the 3D building for design."""
