"""Earthquake pounding of adjacent buildings, and its effect on the equipment inside.

    import impactfem

    run = impactfem.run("towers.toml")
    run.value("pounding.main_impact_force")

The public functions are those of `impactfem.study`; they are loaded at their first use.
"""

import sys

# `python -m` puts the working folder first among the folders of modules. Python sets this word
# while it looks for the module that -m names.
if sys.argv[:1] == ["-m"] and not getattr(sys.flags, "safe_path", False):
    del sys.path[0]


from impactfem.system.interpreter import check_interpreter

check_interpreter()  # before any import that an old Python or a missing package breaks

from importlib import import_module
from importlib.metadata import version
from types import ModuleType
from typing import TYPE_CHECKING, Any

from impactfem.system.packages import leave_out_user_site

leave_out_user_site()  # before any package is imported that is not Python's own

from impactfem.system.cache import place_caches
from impactfem.system.parallel import act_alone_in_a_step, settle_threads
from impactfem.system.settings import ignore_settings_files

if TYPE_CHECKING:
    from impactfem.study import check as check
    from impactfem.study import compare_runs as compare_runs
    from impactfem.study import fit as fit
    from impactfem.study import load as load
    from impactfem.study import make_report as make_report
    from impactfem.study import open as open
    from impactfem.study import run as run
    from impactfem.study import sweep as sweep

__version__ = version("impactfem")
__all__ = ["check", "compare_runs", "fit", "load", "make_report", "open", "run", "sweep"]

ignore_settings_files()  # before anything imports numba, matplotlib, PETSc or netCDF
place_caches()  # before anything imports numba or matplotlib
act_alone_in_a_step()  # before anything starts MPI
settle_threads()  # before anything imports NumPy, SciPy or PETSc


class _Package(ModuleType):
    """A package with the name of a function: `impactfem.run` is both, so it can be called."""

    def __call__(self, *args: Any, **options: Any) -> Any:
        study = import_module("impactfem.study")
        return getattr(study, self.__name__.rpartition(".")[2])(*args, **options)


for _name in ("run", "fit"):
    import_module(f"impactfem.{_name}").__class__ = _Package


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'impactfem' has no attribute '{name}'")
    return getattr(import_module("impactfem.study"), name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
