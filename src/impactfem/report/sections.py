"""The appendix of the page: a section for each stage, with its figures and tables by topic."""

import csv
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from impactfem.plot.figure import BETWEEN, declared
from impactfem.report import comparison
from impactfem.report.buildings import in_3d
from impactfem.report.facts import Facts
from impactfem.report.floors import carried, pounding_spectra
from impactfem.report.picture import Picture, picture, read
from impactfem.report.run_files import COMPARISON, RunFiles
from impactfem.stages.manifest import Label
from impactfem.stages.stage import Stage
from impactfem.stages.stores import names_of

ORDER = (
    "pounding",
    "transient",
    "device",
    "equipment",
    "design",
    "ensemble",
    "sensitivity",
    COMPARISON,
    "calibrate",
    "building",
    "reduce",
)
"""The stages in the order of their use for a decision."""
ROWS = 60
"""Rows of a table that a page has; a longer one is in its file alone."""
PRINTED = 12
"""Rows and columns at most of a table that is open on paper."""
TEMPLATES = files("impactfem.report") / "templates"
_NUMBER = re.compile(r"[-+±×]?\d[\d.,eE+-]*( [a-zA-Zµ%][\w/²^.]{0,7})?")
"""A number with or without a unit."""


@dataclass(frozen=True)
class Rows:
    """A table of a file."""

    path: Path
    anchor: str
    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]  #: none of a table that is too long
    count: int  #: how many rows the file has

    @property
    def printed(self) -> bool:
        """Whether it is open on paper."""
        return 0 < len(self.rows) <= PRINTED and len(self.head) <= PRINTED


@dataclass
class Group:
    """A building, a device or a topic of a stage."""

    title: str
    anchor: str
    subject: str = ""  #: name of the building or the device; "" for a topic
    facts: list[Facts] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)


@dataclass(frozen=True)
class Section:
    """A stage of the run."""

    name: str
    anchor: str
    title: str
    about: str
    groups: Sequence[Group]
    tables: Sequence[Rows]
    files: Sequence[str]  #: its figures and tables, relative to the run's folder


def sections(
    run: RunFiles, known: Mapping[str, Stage], numbers: Iterator[int], shown: Container[Path]
) -> list[Section]:
    """Return the stages of a run and a comparison with another run, in the order of a decision.

    Args:
        run: The files of the run.
        known: All stages by their names.
        numbers: Numbers of the figures, in their order.
        shown: Figures that the page shows elsewhere.
    """
    names = [*run.stages, *([COMPARISON] if run.compared else [])]
    names.sort(key=lambda name: ORDER.index(Label.of(name).stage))
    return [_section(run, name, known, numbers, shown) for name in names]


def anchor(run: RunFiles, path: Path | str) -> str:
    """Return the id of a file in the page: figures of several buildings have the same names."""
    inside = Path(path)
    if inside.is_relative_to(run.folder):
        inside = inside.relative_to(run.folder)
    return "_".join([inside.suffix[1:], *inside.parts[:-2], inside.stem])


def _section(
    run: RunFiles,
    name: str,
    known: Mapping[str, Stage],
    numbers: Iterator[int],
    shown: Container[Path],
) -> Section:
    building, own = Label.of(name)
    stage = known.get(own)
    if stage is not None:
        title, about, figures = stage.title, stage.about, stage.figures.declared
    else:
        figures = declared(comparison)
        title, about = "Comparison with another run", "Scalar results and floor spectra of both."
    place = f"stage_{name}"
    drawn, tables = run.files_of(name, "figures"), run.files_of(name, "tables")
    groups = _groups(run.of(building) if building else run, own, place)
    named = {group.subject: group for group in groups if group.subject}
    titles = list(dict.fromkeys(one.section for one in figures))
    topics = {title: Group(title, f"{place}_{k}") for k, title in enumerate(titles, 1)}
    every = [*groups, *topics.values()]
    chosen: dict[str, list[tuple[str, Path]]] = {group.anchor: [] for group in every}
    for one in figures:
        for path in drawn:
            known_as, _, subject = path.stem.partition(BETWEEN)
            if known_as == one.name and path not in shown:
                heading = f"{one.title}: {subject}" if subject else one.title
                into = named.get(subject, topics[one.section])
                chosen[into.anchor].append((heading, path))
    for group in every:
        for heading, path in chosen[group.anchor]:
            group.pictures.append(picture(path, heading, anchor(run, path), next(numbers)))
    return Section(
        name,
        place,
        run.named(title, name),
        about,
        [group for group in every if group.facts or group.pictures],
        [file_table(run, path) for path in tables],
        [str(path.relative_to(run.folder)) for path in (*drawn, *tables)],
    )


def _groups(run: RunFiles, stage: str, place: str) -> list[Group]:
    """Return the buildings and devices of a stage with their tables."""
    groups = []
    if stage == "design" and "ensemble3d.members" in run.values:
        groups.append(Group("Spread over the motions", f"{place}_0", facts=[carried(run)]))
    elif stage == "pounding":
        for name in (building["name"] for building in run.case["buildings"]):
            title = f"{'3D model' if name in in_3d(run.case) else 'Stick'} {name}"
            others = pounding_spectra(run, name, shown=False)
            groups.append(Group(title, f"building_{name}", name, [others] if others.rows else []))
    elif stage == "device":
        with run.store("device.nc") as store:
            devices = names_of(store, "device")
        for name in devices:
            groups.append(Group(f"Device {name}", f"device_{name}", name))
    return groups


def file_table(run: RunFiles, path: Path) -> Rows:
    """Return the table of a file."""

    def cell(text: str) -> str:
        """Numbers have five digits."""
        try:
            return text if len(text) <= 6 else f"{float(text):.5g}"
        except ValueError:
            return text

    head, *rows = list(csv.reader(read(path).decode().splitlines())) or [[]]
    shown = [[cell(text) for text in row] for row in rows] if len(rows) <= ROWS else []
    title = path.stem.replace("_", " ")
    return Rows(path, anchor(run, path), title, head, shown, len(rows))


def numeric(rows: Sequence[Sequence[str]]) -> list[bool]:
    """Return for each column whether its cells are numbers, with or without a unit, or empty."""
    return [
        all(not c or _NUMBER.fullmatch(c) for c in column) for column in zip(*rows, strict=True)
    ]
