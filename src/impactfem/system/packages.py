"""Where Python packages come from: Debian's FEniCSx goes with Debian's HDF5, MPI and PETSc alone.

A second copy of such a library in one process ends it, often without a word. It comes from packages
of the user (`pip install --user`), which Python takes before Debian's, or from PYTHONPATH.
"""

import logging
import os
import site
import sys
from importlib.machinery import PathFinder
from pathlib import Path

from impactfem.system.errors import ImpactfemError, printable
from impactfem.system.interpreter import FENICSX, STORES, interpreter_fault, missing_modules

_LOGGER = logging.getLogger("impactfem")  # as in `impactfem.system.log`
DEBIAN = "/usr/lib/"
"""Where Debian has Python packages; those of an administrator's pip are in /usr/local."""
OF_DEBIAN = tuple(sorted((*FENICSX, *STORES)))
"""Packages that must come from one source, as they share compiled libraries or formats."""


def leave_out_user_site() -> None:
    """Leave packages of the user's site folder out, in this process and in those that it starts.

    Call it before other packages are imported. Nothing is changed where impactfem itself is
    installed in that folder. Modules that are imported already stay; a warning names those of
    `OF_DEBIAN` and NumPy.
    """
    folder = Path(site.getusersitepackages())
    if not (site.ENABLE_USER_SITE and folder.is_dir()):
        return
    places = {str(folder)}
    for listing in folder.glob("*.pth"):  # packages that are installed where they are developed
        lines = listing.read_text(encoding="utf-8", errors="replace").splitlines()
        places |= {
            str(folder / line.strip()) for line in lines if not line.startswith(("#", "import"))
        }
    own = Path(__file__).resolve()
    if any(own.is_relative_to(Path(place).resolve()) for place in places):
        return
    os.environ["PYTHONNOUSERSITE"] = "1"
    sys.path[:] = [place for place in sys.path if place not in places]
    sys.meta_path[:] = [
        finder for finder in sys.meta_path if not _inside(finder.__module__, folder)
    ]
    early = [name for name in ("numpy", *OF_DEBIAN) if _inside(name, folder)]
    if early:
        _LOGGER.warning(
            "warning: %s came from %s before impactfem was imported. Debian's FEniCSx is built for "
            "Debian's packages: another copy of HDF5, MPI or PETSc may end the process without a "
            "message. Set PYTHONNOUSERSITE=1, or import impactfem first",
            ", ".join(early),
            printable(str(folder)),
        )


def _inside(name: str, folder: Path) -> bool:
    """Whether a module of this name is imported, and its file is in a folder."""
    file = getattr(sys.modules.get(name), "__file__", None)
    return file is not None and Path(file).is_relative_to(folder)


def warn_of_foreign_packages() -> None:
    """Warn of packages of `OF_DEBIAN` from elsewhere, where FEniCSx is Debian's."""
    files = {
        name: spec.origin
        for name in OF_DEBIAN
        if (spec := PathFinder.find_spec(name)) is not None and spec.origin is not None
    }
    if not files.get("dolfinx", "").startswith(DEBIAN):
        return
    for name, file in files.items():
        if not file.startswith(DEBIAN):
            _LOGGER.warning(
                "warning: %s comes from %s, FEniCSx from Debian. Two copies of HDF5, MPI or PETSc "
                "in one process may end it without a message. Remove this copy, or its folder from "
                "PYTHONPATH",
                name,
                printable(file),
            )


def require_packages(*, three_d: bool) -> None:
    """Check that the packages of a run can be found, before anything is computed.

    Args:
        three_d: Whether the run needs FEniCSx, for a 3D model.

    Raises:
        ImpactfemError: Packages are missing; the message names them and the remedy.
    """
    missing = missing_modules(*STORES, *(FENICSX if three_d else ()))
    fault = interpreter_fault(tuple(sys.version_info[:2]), missing)
    if fault is not None:
        raise ImpactfemError(fault)
