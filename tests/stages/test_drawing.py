"""The declared figures: names, sections, counts, and which of them are drawn."""

from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
import xarray as xr

from impactfem.case import load_case
from impactfem.case.report import Report
from impactfem.plot.figure import BETWEEN, declared, figure
from impactfem.report import comparison, governing_figure, scene_page
from impactfem.run.stages import STAGES, needed_stages
from impactfem.stages.drawing import FigureData, Figures
from impactfem.system.files import write_netcdf

OF_REPORT = declared(governing_figure, scene_page)
MOST = 40
PAPER = {
    "building": ["B1", "B2"],
    "undesigned": {"B2"},
    "device": ["pump"],
    "mode": ["1", "2", "3"],
    "first_mode": ["1"],
    "spectrum": ["x_5pct", "y_5pct", "z_5pct"],
    "shown_spectrum": ["y_5pct"],
    "frequency": ["10hz", "72hz", "85hz", "91hz"],
}
"""Subjects of the figures of the paper's case."""
ABSENT = {"film", "loads"}
"""Data of buildings that both pound in 3D."""


def every():
    return [one for stage in STAGES for one in stage.figures.declared]


def test_each_figure_has_a_name_a_section_and_a_heading():
    figures = [*every(), *OF_REPORT, *declared(comparison)]
    assert len(figures) > 50
    names = [one.name for one in figures]
    assert len(set(names)) == len(names)
    for one in figures:
        assert one.name.isidentifier() and BETWEEN not in one.name
        assert one.section and one.title[0].isupper() and not one.title.endswith(".")


def paper_files(**requested):
    """The files of the figures of the paper's case, by the declarations alone."""
    case = load_case(Path(__file__).parents[2] / "geometry" / "npp_pair.toml")
    case = case.model_copy(update={"report": case.report.model_copy(update=requested)})
    data = SimpleNamespace(case=case, **PAPER)
    return [
        one.file(subject)
        for stage in needed_stages(case, None)
        for one, subject in stage.figures.chosen(data)
        if not ABSENT & set(one.needs)
    ]


def test_the_default_figures_of_the_papers_case():
    files = paper_files()
    assert 30 < len(files) + len(OF_REPORT) <= MOST
    assert len(set(files)) == len(files)
    assert {"impact_forces.svg", "device_force-pump.svg", "device_map-pump.png"} <= set(files)
    assert not {"damping.svg", "wall_energy.svg", "bending_mode-2.png"} & set(files)


def test_every_published_figure_is_drawn():
    case = load_case(Path(__file__).parents[2] / "geometry" / "npp_pair.toml")
    shown = [name for name in case.report.shown_files if name.startswith("figures/")]
    written = [f"figures/{file}" for file in paper_files()]
    for pattern in shown:
        assert any(Path(name).match(pattern) for name in written), pattern


def test_all_figures_of_the_papers_case():
    assert len(paper_files(figures=("all",))) > MOST + 15


def one_file(path, text="drawn"):
    path.write_text(text)


@pytest.fixture
def figures():
    """Declarations of a module: one of each kind."""
    module = ModuleType("declarations")
    made = {
        "plain": figure("plain", "A", "Plain"),
        "spare": figure("spare", "A", "Spare", default=False),
        "needy": figure("needy", "B", "Needy"),
        "bound": figure("bound", "B", "Bound", when=lambda numbers: len(numbers) > 2),
        "each": figure("each", "B", "Each", each="numbers", default="even", ending="png"),
    }
    functions = {
        "plain": lambda path: one_file(path),
        "spare": lambda path: one_file(path),
        "needy": lambda path, missing: one_file(path),
        "bound": lambda path: one_file(path),
        "each": lambda path, numbers: one_file(path, numbers),
    }
    for name, declare in made.items():
        function = declare(functions[name])
        function.__module__ = "declarations"
        setattr(module, name, function)

    class Data(FigureData):
        numbers, even, missing = ["1", "2"], {"2"}, None

    return Figures.of(Data, module)


@pytest.mark.parametrize(
    ("requested", "expected"),
    [
        ((), ["each-2.png", "plain.svg"]),
        (("spare",), ["each-2.png", "plain.svg", "spare.svg"]),
        (("each",), ["each-1.png", "each-2.png", "plain.svg"]),
        (("all",), ["each-1.png", "each-2.png", "plain.svg", "spare.svg"]),
    ],
)
def test_requested_figures(figures, tmp_path, requested, expected):
    case = SimpleNamespace(report=Report.model_construct(figures=requested))
    drawn = figures.draw(case, tmp_path)
    assert [path.name for path in drawn] == expected
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == expected
    assert (tmp_path / "figures" / "each-2.png").read_text() == "2"


def test_a_figure_that_the_reference_shows(figures, tmp_path):
    items = [SimpleNamespace(shows=("figures/spare*", "figures/each-1.png"))]
    report = Report.model_construct(reference=SimpleNamespace(items=items))
    drawn = figures.draw(SimpleNamespace(report=report), tmp_path)
    assert [path.stem for path in drawn] == ["each-1", "each-2", "plain", "spare"]


def test_a_further_building_takes_no_file_of_the_first_one(tmp_path):
    folder = tmp_path / "B2"
    folder.mkdir()
    write_netcdf(tmp_path / "transient_maps.nc", xr.Dataset())
    with FigureData.of(SimpleNamespace(), folder) as data:
        assert data.optional("transient_maps.nc") is None
    with FigureData.of(SimpleNamespace(), tmp_path) as data:
        assert data.optional("transient_maps.nc") is not None
