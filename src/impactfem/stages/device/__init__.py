"""The stage `device`: devices in the 3D building and by response spectra."""
