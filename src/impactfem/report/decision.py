"""The decision report: the chapters of part 1 of the page, with their tables and figures."""

import html
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from impactfem.plot.figure import BETWEEN, Figure, declared
from impactfem.report import governing_figure
from impactfem.report.buildings import buildings, in_3d
from impactfem.report.caveats import flags
from impactfem.report.devices import anchors_table
from impactfem.report.facts import Facts
from impactfem.report.floors import pounding_spectra, structure_spectra
from impactfem.report.governing import Spectrum, bands_table, spectra_table
from impactfem.report.impacts import impacts_table, laws_table
from impactfem.report.motion import motion_table
from impactfem.report.picture import Picture, picture, read
from impactfem.report.run_files import SCENE, RunFiles
from impactfem.report.sections import Rows, anchor, file_table
from impactfem.report.verdicts import verdicts_table
from impactfem.stages.manifest import Label
from impactfem.stages.stage import Stage

SENSITIVITY = "sensitivity"
"""The stage with the table of the chapter on uncertainty, and the name of its figure."""
FIGURES = {
    "verdict": ("decision_spectra",),
    "elevation": ("elevation",),
    "model": ("case",),
    "impacts": ("impact_forces",),
    "floors": ("pounding_spectra",),
    "equipment": ("equipment_ratios", "device_map", "anchor_spectra"),
    "uncertainty": (SENSITIVITY, "ensemble_spectra", "design_device_force"),
}
"""Names of the figures of each chapter by its anchor, in order."""
MOST_DEVICES = 1
"""Number of devices with figures in a chapter; those of the others are in the appendix."""
CHAIN = (
    "The impact forces come from sticks: stick models pound, and their forces load the 3D model. "
    "One study compares this chain with direct pounding of two 3D models, for one pair of "
    "buildings and one motion (docs/coupled-study.md). The impulse and the required gap agree "
    "within 1.1 %. The largest force of the chain is 1.34 times that of direct pounding. The chain "
    "overestimates the spectrum of the struck top floor by a factor of 2. It underestimates floors "
    "4 and 5 by 1.8 and 1.7, because these floors collide only as 3D models. The anchor force of "
    "the pump is 110 kN by the chain and 54 kN by direct pounding."
)


@dataclass
class Chapter:
    """A chapter of the decision report."""

    anchor: str
    title: str
    texts: list[str] = field(default_factory=list)  #: paragraphs
    tables: list[Facts] = field(default_factory=list)
    files: list[Rows] = field(default_factory=list)  #: tables of files
    pictures: list[Picture] = field(default_factory=list)
    scene: str = ""  #: the page with the buildings in 3D, as the text of an attribute

    @property
    def paths(self) -> list[Path]:
        """Figures and tables of files that the chapter shows."""
        return [*(one.path for one in self.pictures), *(one.path for one in self.files)]


def chapters(
    run: RunFiles, known: Mapping[str, Stage], spectra: list[Spectrum], numbers: Iterator[int]
) -> list[Chapter]:
    """Return the chapters with content, in the order of the page.

    Args:
        run: The files of the run.
        known: All stages by their names.
        spectra: The governing spectra.
        numbers: Numbers of the figures, in their order.
    """
    pounding, verdicts = run.ran("pounding"), verdicts_table(run.verdicts)
    dynamic = [one for one in run.models.values() if one.ran("transient")]
    floors = [structure_spectra(one) for one in dynamic]
    if pounding:
        chained = (one["name"] for one in run.case["buildings"])
        floors += [pounding_spectra(run, name, shown=True) for name in chained]
    anchors, spreads = anchors_table(run), flags(run, spectra)
    if pounding and set(run.models) - in_3d(run.case) and run.values.get("pounding.impacts"):
        spreads.insert(0, CHAIN)
    sensitivity = run.files_of(SENSITIVITY, "tables") if run.ran(SENSITIVITY) else []
    made = [
        Chapter("verdict", "Verdict", tables=_some(verdicts, spectra_table(spectra))),
        Chapter("elevation", "Peak accelerations, impacts and gap"),
        Chapter(
            "model",
            "Model and motion",
            tables=_some(buildings(run), motion_table(run), laws_table(run) if pounding else None),
        ),
        Chapter("impacts", "Impacts", tables=[impacts_table(run)] if pounding else []),
        Chapter(
            "floors",
            "Floor spectra with and without impact",
            tables=_some(bands_table(spectra), *floors),
        ),
        Chapter("equipment", "Equipment", tables=_some(anchors)),
        Chapter(
            "uncertainty",
            "Uncertainty",
            texts=spreads,
            files=[file_table(run, path) for path in sensitivity],
        ),
    ]
    drawn = list(_drawn(run, known))
    for chapter in made:
        for name in FIGURES[chapter.anchor]:
            chosen = [(one, path) for one, path in drawn if one.name == name]
            chapter.pictures += _pictures(run, chosen[:MOST_DEVICES], numbers)
        if chapter.anchor == "elevation" and (path := run.folder / "figures" / SCENE).is_file():
            chapter.scene = html.escape(read(path).decode(), quote=True)
    return [one for one in made if one.texts or one.tables or one.files or one.pictures]


def _some(*tables: Facts | None) -> list[Facts]:
    return [one for one in tables if one is not None and one.rows]


def _drawn(run: RunFiles, known: Mapping[str, Stage]) -> Iterator[tuple[Figure, Path]]:
    """Yield the figures of the run with their declarations: of the whole run, then by stage."""
    (whole,) = declared(governing_figure)
    path = run.folder / "figures" / whole.file()
    if path.is_file():
        yield whole, path
    for label in run.stages:
        of_stage = {one.name: one for one in known[Label.of(label).stage].figures.declared}
        for path in run.files_of(label, "figures"):
            name = path.stem.partition(BETWEEN)[0]
            if name in of_stage:
                yield of_stage[name], path


def _pictures(
    run: RunFiles, chosen: Iterable[tuple[Figure, Path]], numbers: Iterator[int]
) -> Iterator[Picture]:
    for one, path in chosen:
        subject = path.stem.partition(BETWEEN)[2]
        title = f"{one.title}: {subject}" if subject else one.title
        yield picture(path, title, anchor(run, path), next(numbers))
