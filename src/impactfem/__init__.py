"""Earthquake pounding of adjacent buildings, and what it does to the equipment inside."""

from importlib.metadata import version

from impactfem.system.cache import place_caches
from impactfem.system.parallel import settle_threads

__version__ = version("impactfem")

place_caches()  # before anything imports numba or matplotlib
settle_threads()  # before anything imports NumPy, SciPy or PETSc
