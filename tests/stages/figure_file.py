"""What the files of figures and tables are, whatever wrote them."""

import csv
from types import SimpleNamespace

from PIL import Image

from impactfem.case.analysis import Spectra
from impactfem.case.report import Report
from impactfem.case.transient import Transient
from impactfem.plot.words import read_words
from impactfem.stages.drawing import Figures
from impactfem.system.executor import in_own_process


def assert_drawn(path, width, height):
    """Words, and of lines no more than a page can hold, of pixels a picture of such a size."""
    words = read_words(path)
    assert words.caption and words.seen
    if path.suffix == ".svg":
        assert 5_000 < path.stat().st_size < 250_000
        return
    with Image.open(path) as picture:
        assert 150 <= picture.width <= width and 100 <= picture.height <= height
        assert len(picture.convert("RGB").getcolors(maxcolors=10**6)) > 50


def draw_all(figures, folder, *, in_3d=False, **given):
    """Draw all figures of a stage from its results files: those by VTK, or those by matplotlib."""
    (folder / "figures").mkdir(exist_ok=True)
    case = SimpleNamespace(
        report=Report.model_construct(figures=("all",)),
        published={},
        in_time=(),
        devices=(),
        transient=Transient.model_construct(),
        spectra=Spectra.model_construct(),
    )
    vars(case).update(given)
    some = tuple(one for one in figures.declared if one.in_3d is in_3d)
    draw = Figures(figures.data, some).draw_here
    return in_own_process(draw, case, folder) if in_3d else draw(case, folder)


def rows(path):
    """The rows of a table, each by the heads of its columns."""
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))
