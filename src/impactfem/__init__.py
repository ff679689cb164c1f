"""Earthquake pounding of adjacent buildings, and what it does to the equipment inside."""

from importlib.metadata import version

__version__ = version("impactfem")
