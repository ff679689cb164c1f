"""Devices on a floor: their models, the force on their anchors, and response spectrum analysis."""
