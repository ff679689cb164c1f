"""The end of a stage that all ranks run: rank 0 has its results, and writes them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from impactfem.system.log import Steps
from impactfem.system.parallel import on_root

Study = TypeVar("Study")


def stored(
    study: Study | None,
    store: Path,
    write: Callable[[Path, Study], None],
    shown: Callable[[], list[Path]],
    steps: Steps,
) -> list[Path]:
    """Write a store, then the tables and figures that are read off it. Collective.

    Args:
        study: The results; None on all ranks but the first.
        store: Its file.
        write: Writes it.
        shown: Writes tables and figures, and gives their files.
        steps: Of the stage; "stores" and "tables and figures" are done here.

    Returns:
        All files.

    Raises:
        ImpactfemError: A file cannot be written.
    """

    def action() -> list[Path]:
        if study is None:
            raise ValueError("rank 0 has no results")
        with steps.step("stores"):
            write(store, study)
        with steps.step("tables and figures"):
            return [store, *shown()]

    return on_root(action)
