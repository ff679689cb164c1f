"""gmsh's session, inside a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """The module gmsh between `initialize` and `finalize`; the same for every user and machine.

    To be used inside `in_own_process`.
    """
    import gmsh

    # The user's own options are not read: they would change the mesh.
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield gmsh
    finally:
        gmsh.finalize()
