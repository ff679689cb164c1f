"""The cases that come with the source tree."""

from __future__ import annotations

from pathlib import Path

import impactfem
from impactfem.system.errors import ImpactfemError


def shipped_case(name: str) -> Path:
    """A case of the source tree's folder `geometry`.

    Raises:
        ImpactfemError: The program runs without its source tree.
    """
    path = Path(impactfem.__file__).parents[2] / "geometry" / name
    if not path.is_file():
        raise ImpactfemError(f"{path} is not there: this benchmark needs the source tree")
    return path
