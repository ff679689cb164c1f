"""Earthquake pounding of adjacent buildings, and what it does to the equipment inside."""

import sys

# `python -m` puts the working folder first among the folders of modules. Python sets this word
# while it looks for the module that -m names.
if sys.argv[:1] == ["-m"] and not sys.flags.safe_path:
    del sys.path[0]

from importlib.metadata import version

from impactfem.system.packages import leave_out_user_site

leave_out_user_site()  # before any package is imported that is not Python's own

from impactfem.system.cache import place_caches  # noqa: E402
from impactfem.system.parallel import act_alone_in_a_step, settle_threads  # noqa: E402
from impactfem.system.settings import ignore_settings_files  # noqa: E402

__version__ = version("impactfem")

ignore_settings_files()  # before anything imports numba, matplotlib, PETSc or netCDF
place_caches()  # before anything imports numba or matplotlib
act_alone_in_a_step()  # before anything starts MPI
settle_threads()  # before anything imports NumPy, SciPy or PETSc
