"""Devices and response spectrum analysis."""
