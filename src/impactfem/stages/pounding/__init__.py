"""The stage `pounding`: sticks, their impacts, floor spectra."""
