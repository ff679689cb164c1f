"""The stage `transient`: ground motion and impacts on the 3D building."""
