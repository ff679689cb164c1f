"""The figures of a stage: which are drawn, from which data, and in which process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import ModuleType
from typing import Self

import xarray as xr

from impactfem.case import Building3D, Case
from impactfem.plot.figure import Figure, declared
from impactfem.stages.inputs import published_values
from impactfem.stages.stores import open_stores
from impactfem.system.executor import in_own_process
from impactfem.system.parallel import meanwhile


class FigureData:
    """The data of the figures of a stage: an attribute for each name, None for missing data.

    A stage derives its own class from this one.
    """

    def __init__(
        self, subject: Case | Building3D, folder: Path, opened: Callable[[str], xr.Dataset]
    ) -> None:
        self.subject, self.folder, self.opened = subject, folder, opened
        self.case = subject.case if isinstance(subject, Building3D) else subject

    @classmethod
    @contextmanager
    def of(cls, subject: Case | Building3D, folder: Path) -> Iterator[Self]:
        """Give the data of the folder of a run or of a further building, open in the block."""
        with open_stores(folder) as opened:
            yield cls(subject, folder, opened)

    def optional(self, name: str) -> xr.Dataset | None:
        """Open a results file of the folder itself; None if it has none."""
        return self.opened(name) if (self.folder / name).is_file() else None

    @cached_property
    def published(self) -> Mapping[str, float]:
        """Published values in SI by the name of the result."""
        return published_values(self.subject)


@dataclass(frozen=True)
class Figures:
    """The declared figures of a stage and their data."""

    data: type[FigureData] = FigureData
    declared: tuple[Figure, ...] = ()

    @classmethod
    def of(cls, data: type[FigureData], *modules: ModuleType) -> Figures:
        """Return the figures of the modules of a stage, in the order of the report."""
        return cls(data, declared(*modules))

    def draw(self, subject: Case | Building3D, folder: Path) -> list[Path]:
        """Draw the default figures and the requested ones into `figures/`, if there is data.

        Args:
            subject: The case, or one of its buildings.
            folder: The folder of its results.

        Returns:
            The files.

        Raises:
            ImpactfemError: A file cannot be written, or OpenGL is missing.
        """
        flat, in_3d = (
            Figures(self.data, tuple(one for one in self.declared if one.in_3d is kind))
            for kind in (False, True)
        )
        (folder / "figures").mkdir(exist_ok=True)
        # A process costs seconds: none is started for figures that nobody requests.
        with self.data.of(subject, folder) as data:
            some = any(True for _ in in_3d.chosen(data))
        if not some:
            return flat.draw_here(subject, folder)
        pictures = partial(in_own_process, in_3d.draw_here, subject, folder)
        with meanwhile(pictures) as drawn_meanwhile:
            return sorted([*flat.draw_here(subject, folder), *drawn_meanwhile()])

    def draw_here(self, subject: Case | Building3D, folder: Path) -> list[Path]:
        """As `draw`, all in this process."""
        files = []
        with self.data.of(subject, folder) as data:
            for one, label in self.chosen(data):
                if (arguments := one.arguments(data, label)) is None:
                    continue
                path = folder / "figures" / one.file(label)
                if one.writes:
                    arguments["path"] = path
                if (curves := one.function(**arguments)) is not None:
                    curves.write(path)
                files.append(path)
        return sorted(files)

    def chosen(self, data: FigureData) -> Iterator[tuple[Figure, str]]:
        """Yield the default and the requested figures with their subjects."""
        report = data.case.report
        for one in self.declared:
            for subject, default in one.subjects(data):
                if default or report.requests(one.name, one.file(subject)):
                    yield one, subject
