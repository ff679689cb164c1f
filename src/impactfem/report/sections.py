"""The sections of the page: a stage each, its figures and tables by building, device or topic."""

import base64
import csv
import html
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from markupsafe import Markup
from PIL import Image

from impactfem.plot.figure import BETWEEN, declared
from impactfem.plot.words import as_html, read_words
from impactfem.report import comparison, scene_page
from impactfem.report.overview import (
    Facts,
    carried,
    device_verdict,
    impacts,
    in_3d,
    stick_spectra,
    structure_spectra,
)
from impactfem.report.run_files import COMPARISON, DRAWING, SCENE, RunFiles
from impactfem.stages.manifest import Label
from impactfem.stages.stage import Stage
from impactfem.stages.stores import names_of
from impactfem.system.errors import ImpactfemError

CSS_DOTS = 96.0
"""Pixels of a page in an inch."""
QUALITY = 85
"""Of the pictures in the page, of 100."""
_NAMED = re.compile(r'(\bid="|url\(#|href="#)')
"""Where an SVG names one of its parts."""
ELEMENTS = frozenset(
    {
        "circle",
        "clipPath",
        "defs",
        "desc",
        "ellipse",
        "g",
        "image",
        "line",
        "linearGradient",
        "marker",
        "metadata",
        "path",
        "pattern",
        "polygon",
        "polyline",
        "radialGradient",
        "rect",
        "stop",
        "svg",
        "symbol",
        "text",
        "title",
        "tspan",
        "use",
    }
)
"""Elements of an SVG that draw or describe; others, as a script, have no place in a figure."""
_COMMENT = re.compile(r"<!-- (?:(?!--|>).)* -->", re.S)
_OUTSIDE = re.compile(r"url\(\s*[\"']?(?!#)|@import|expression\(", re.I)
ORDER = (
    "pounding",
    "transient",
    "device",
    "design",
    "ensemble",
    COMPARISON,
    "calibrate",
    "building",
    "reduce",
)
"""The stages in the order of their use for a decision."""


@dataclass(frozen=True)
class Picture:
    """A figure of the page."""

    path: Path
    anchor: str  #: id of its place in the page
    number: int  #: in the order of the page
    title: str  #: its heading
    markup: Markup  #: the picture itself
    caption: Markup  #: below it

    @property
    def zooms(self) -> bool:
        """Whether the page's script may enlarge it."""
        return self.path.suffix == ".svg"

    @property
    def film(self) -> bool:
        """Whether it moves, and is nothing for paper."""
        return self.path.suffix == ".mp4"


def picture(path: Path, title: str, anchor: str, number: int) -> Picture:
    """A file as a figure of the page; ImpactfemError where it cannot be read."""
    if path.suffix == ".mp4":
        markup = Markup('<video controls muted loop playsinline aria-label="{}" src="{}"></video>')
        film = markup.format(title, data(read(path), "video/mp4"))
        return Picture(path, anchor, number, title, film, Markup())
    words = read_words(path)
    if path.suffix == ".svg":
        # Figures of several buildings may be alike, parts of a page have different names.
        markup = Markup(_NAMED.sub(rf"\g<1>p{number}", passive(path, read(path))))
    else:
        with Image.open(path) as image:
            dots, packed = image.info.get("dpi", (CSS_DOTS,))[0], io.BytesIO()
            width, height = (round(CSS_DOTS * size / dots) for size in image.size)
            # A third of the PNG, which stays in the folder.
            image.convert("RGB").save(packed, "WEBP", quality=QUALITY)
        markup = Markup('<img loading="lazy" width="{}" height="{}" alt="{}" src="{}">').format(
            width, height, words.seen or title, data(packed.getvalue(), "image/webp")
        )
    return Picture(path, anchor, number, title, markup, Markup(as_html(words.caption)))


def passive(path: Path, content: bytes) -> str:
    """Return the text of an SVG that only draws, without comments.

    The folder may come from somebody else. ImpactfemError where the file is no SVG, or would run
    or load something.
    """
    try:
        text = _COMMENT.sub("", content.decode())
        if "<!" in text or "<?" in text:  # HTML reads them in another way than XML
            raise ValueError("a declaration")
        for element in ElementTree.fromstring(text).iter():
            name = element.tag.rpartition("}")[2]
            if name not in ELEMENTS:
                raise ValueError(f"<{name}>")
            own = "data:image/png;" if name == "image" else "#"
            for attribute, value in element.attrib.items():
                kind = attribute.rpartition("}")[2].lower()
                outside = kind in ("href", "src") and not value.startswith(own)
                if kind.startswith("on") or outside or _OUTSIDE.search(value):
                    raise ValueError(f"{kind} of <{name}>")
    except (ValueError, ElementTree.ParseError) as error:
        raise ImpactfemError(
            f"cannot show {path}: expected an SVG that only draws, not {error}; "
            "'impactfem run' draws it again"
        ) from error
    return text


def data(content: bytes, kind: str) -> str:
    """The content of a file as an address."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def read(path: Path) -> bytes:
    """The bytes of a file; ImpactfemError where it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error.strerror or error}") from error


ROWS = 60
"""Rows of a table that a page has; a longer one is in its file alone."""
PRINTED = 12
"""Rows and columns at most of a table that is open on paper."""
TEMPLATES = files("impactfem.report") / "templates"
_NUMBER = re.compile(r"[-+±×]?\d[\d.,eE+-]*")


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
    scenes: list[str] = field(default_factory=list)  #: pages, as the text of an attribute


@dataclass(frozen=True)
class Section:
    """A stage of the run."""

    name: str
    anchor: str
    title: str
    about: str
    checks: Sequence[Mapping[str, Any]]
    groups: Sequence[Group]
    tables: Sequence[Rows]
    files: Sequence[str]  #: its figures and tables, relative to the run's folder


def sections(run: RunFiles, known: Mapping[str, Stage], numbers: Iterator[int]) -> list[Section]:
    """The stages of a run and a comparison with another one, as they matter to a decision.

    `known` are all stages by their names, `numbers` those of the figures in their order.
    """
    names = [*run.stages, *([COMPARISON] if run.compared else [])]
    names.sort(key=lambda name: ORDER.index(Label.of(name).stage))
    return [_section(run, name, known, numbers) for name in names]


def anchor(run: RunFiles, path: Path | str) -> str:
    """Where the page shows a file: figures of several buildings have the same names."""
    inside = Path(path)
    if inside.is_relative_to(run.folder):
        inside = inside.relative_to(run.folder)
    return "_".join([inside.suffix[1:], *inside.parts[:-2], inside.stem])


def _section(
    run: RunFiles,
    name: str,
    known: Mapping[str, Stage],
    numbers: Iterator[int],
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
    figures = (*figures, *declared(scene_page))
    titles = list(dict.fromkeys(one.section for one in figures))
    topics = {title: Group(title, f"{place}_{k}") for k, title in enumerate(titles, 1)}
    shown = [*groups, *topics.values()]
    if own == "pounding":
        shown = [*groups[:1], *topics.values(), *groups[1:]]
    chosen: dict[str, list[tuple[str, Path]]] = {group.anchor: [] for group in shown}
    for one in figures:
        for path in drawn:
            known_as, _, subject = path.stem.partition(BETWEEN)
            if known_as == one.name and path.stem != DRAWING:
                heading = f"{one.title}: {subject}" if subject else one.title
                into = named.get(subject, topics[one.section])
                chosen[into.anchor].append((heading, path))
    for group in shown:
        for heading, path in chosen[group.anchor]:
            if path.name == SCENE:
                # A page as the text of an attribute, for a frame within this one.
                group.scenes.append(html.escape(read(path).decode(), quote=True))
            else:
                group.pictures.append(picture(path, heading, anchor(run, path), next(numbers)))
    return Section(
        name,
        place,
        run.named(title, name),
        about,
        [check for check in run.checks if check["stage"] == name],
        [group for group in shown if group.facts or group.pictures or group.scenes],
        [_table(run, path) for path in tables],
        [str(path.relative_to(run.folder)) for path in (*drawn, *tables)],
    )


def _groups(run: RunFiles, stage: str, place: str) -> list[Group]:
    """The buildings and devices of a stage, with what was found of them."""
    groups = []
    if stage == "pounding":
        groups.append(Group("What hits what", f"{place}_0", facts=[impacts(run)]))
    elif stage == "transient":
        groups.append(Group("Largest ordinates", f"{place}_0", facts=[structure_spectra(run)]))
    elif stage == "design" and "ensemble3d.members" in run.values:
        groups.append(Group("Spread over the motions", f"{place}_0", facts=[carried(run)]))
    if stage == "pounding":
        for name in (building["name"] for building in run.case["buildings"]):
            title = f"{'3D model' if name in in_3d(run.case) else 'Stick'} {name}"
            groups.append(Group(title, f"building_{name}", name, [stick_spectra(run, name)]))
    elif stage == "device":
        with run.store("device.nc") as store:
            devices = names_of(store, "device")
        for name in devices:
            facts = [device_verdict(run, name)]
            groups.append(Group(f"Device {name}", f"device_{name}", name, facts))
    return groups


def _table(run: RunFiles, path: Path) -> Rows:
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
    """Whether all cells of a column are numbers or empty."""
    return [
        all(not c or _NUMBER.fullmatch(c) for c in column) for column in zip(*rows, strict=True)
    ]
