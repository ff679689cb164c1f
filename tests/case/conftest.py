"""A case in a folder of its own, which a test may break."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from .texts import replaced

DATA = Path(__file__).parent / "data"

STRUCTURE = """
[buildings.structure]
storey_stiffness_factor = 0.13
calibration = { frequency = "1.80 Hz", direction = "y" }

[buildings.structure.mesh]
type = "generated"
length = "46.20 m"
width = "15.60 m"
slab_thickness = "30 cm"
walls = "pair_walls.csv"
bays = "pair_bays.csv"
beams = "pair_beams.csv"
columns = "pair_columns.csv"
acroterion = { height = "63 cm", thickness = "30 cm" }
impact_edge = "y+"
size = "0.9 m"
"""

TABLES = {
    "pair_walls.csv": """\
wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [cm]
south,1-8,0,0,46.2,0,60
north,1 3-8,0,15.6,46.2,15.6,60
gable,2,0,0,0,15.6,60
""",
    "pair_bays.csv": """\
bay,wall,storey,centre [m],sill [m],width [m],height [m]
6,south,5,10,0,2,2.7
6,south,5,10,2.7,3.3,0.9
1,gable,2,2,2.05,3.3,57e-2
""",
    "pair_beams.csv": """\
beam,floors,x1 [m],y1 [m],x2 [m],y2 [m],width [m],depth [m],offset [m]
row_1,1-8,5.775,0,5.775,15.6,0.75,0.85,-0.575
along,1-8,0,7.8,46.2,7.8,0.2,0.28,-0.29
""",
    "pair_columns.csv": """\
column,storeys,x [m],y [m],width_x [m],width_y [m]
row_1,2-8,5.775,7.8,0.8,1.2
""",
}

# A file, or the case file when None; the text to be replaced there; the text in its place.
Edit = tuple[str | None, str, str]


@pytest.fixture
def pair() -> Path:
    """A case file without faults."""
    return DATA / "pair.toml"


@pytest.fixture
def broken(tmp_path: Path) -> Callable[..., Path]:
    """Copy the case, replace texts in it, and give its path."""

    def copy(*edits: Edit) -> Path:
        for source in DATA.glob("pair*"):
            shutil.copy(source, tmp_path)
        _edit(tmp_path, edits)
        return tmp_path / "pair.toml"

    return copy


@pytest.fixture
def structured(tmp_path: Path) -> Callable[..., Path]:
    """As ``broken``, for the case with a structure."""

    def copy(*edits: Edit) -> Path:
        for source in DATA.glob("pair*"):
            shutil.copy(source, tmp_path)
        path = tmp_path / "pair.toml"
        text = path.read_text(encoding="utf-8")
        # B1 comes last, so that what is added at the end of the file is its own.
        first = text[text.index("[[buildings]]") : text.rindex("[[buildings]]")]
        text = text.replace(first, "").replace("[calibration]", f"{first}[calibration]")
        path.write_text(text + STRUCTURE, encoding="utf-8")
        for name, text in TABLES.items():
            (tmp_path / name).write_text(text, encoding="utf-8")
        _edit(tmp_path, edits)
        return tmp_path / "pair.toml"

    return copy


def _edit(folder: Path, edits: tuple[Edit, ...]) -> None:
    for file, old, new in edits:
        path = folder / (file or "pair.toml")
        text = path.read_text(encoding="utf-8")
        path.write_text(replaced(text, (old, new)), encoding="utf-8")
