"""Every notebook from top to bottom on a small case, and what makes these tests fail."""

import base64
import hashlib
import io
import re
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread
from nbclient.exceptions import CellExecutionError, CellTimeoutError

from frame_case import pump
from impactfem.run.folder import open_run

pytestmark = pytest.mark.slow
ALL = ("first_steps", "read_a_run", "own_building", "damping_study", "contact_law")
# A small mesh for a short time: its numbers are of no use.
SHORT = {"mesh_size": 1.2, "duration": 2.0, "highest": 60.0}
DEVICE = """
extends = "own_building.toml"

[[damping_cases]]
name = "light"
ratio = "2 %"
frequencies = ["1 Hz", "20 Hz"]
restitution = 0.8

""" + pump('["4.5 m", "5 m", "9.5 m"]', "1 m")
NOT_RUN = '# %% tags=["parameters"]\nfolder = "x"\n\n# %%\n'


def printed(notebook, stream="stdout"):
    """What the cells printed."""
    outputs = [one for cell in notebook.cells for one in cell.get("outputs", [])]
    return "".join(one.text for one in outputs if one.get("name") == stream)


def pictures(notebook):
    """The figures that the cells showed."""
    outputs = [one for cell in notebook.cells for one in cell.get("outputs", [])]
    shown = [one.data["image/png"] for one in outputs if "image/png" in one.get("data", {})]
    return [imread(io.BytesIO(base64.b64decode(one))) for one in shown]


def check(notebook, figures):
    """Every code cell ran, figures were shown, nothing warned; gives what was printed."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    shown = pictures(notebook)
    assert len(shown) == figures
    assert all(np.ptp(picture[..., :3]) > 0.5 for picture in shown)  # no empty ones
    assert not re.search(r"Warning\b|Traceback", printed(notebook, "stderr"))
    return printed(notebook)


def digests(folder):
    """The files of a folder with what is in them."""
    return {
        path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture(scope="module")
def built(execute, tmp_path_factory):
    """The folder of the notebook `own_building` after it ran, and the notebook."""
    folder = tmp_path_factory.mktemp("built")
    ran = execute("own_building", folder, folder="own", **SHORT)
    return SimpleNamespace(folder=folder / "own", notebook=ran)


def test_first_steps(execute, new_case, tmp_path):
    case = new_case(tmp_path)
    told = check(execute("first_steps", tmp_path, case_file=str(case), folder="out"), 2)
    # The two mistakes of the wrong case, each in a line.
    assert "pounding.time_step = '0.3 kg': 'kg' is a mass" in told
    assert "spectra.damping[0] = '500 %'" in told
    with open_run(tmp_path / "out" / "run") as run:
        force = 1e-6 * max(run.value(f"pounding.peak_force.floor_{k}") for k in (1, 2, 3))
        assert f"largest force {force:.1f} MN between west.floor_" in told
        assert f"{run.value('motion.pga'):.4g}" in told


def test_own_building(built):
    told = check(built.notebook, 2)
    assert "no fault found" in told and "stand_in.AT2" in told
    with open_run(built.folder / "run") as run:
        stores = "building reduce pounding motion forces transient maps"
        assert run.stores == tuple(stores.split())
        assert run.value("pounding.peak_force.floor_3") > 1e5
        first = run.value("building.frequency.1")
        assert float(run.pounding.calibrated_frequency[0]) == pytest.approx(first, rel=1e-3)
        # Low on, the stick and the 3D model are one: the floor moves as a rigid body.
        stick = run.pounding.psa.sel(station="mine.floor_3", direction="y")[0]
        centre = run.transient.psa.sel(probe="centre_3", component="y")[0]
        low = stick.frequency.values < 0.8 * first
        assert stick.values[low] == pytest.approx(centre.values[low], rel=0.05)


def test_read_a_run(execute, built, tmp_path):
    run = built.folder / "run"
    before = digests(run)
    notebook = execute("read_a_run", tmp_path, folder=str(run), figures="drawn")
    told = check(notebook, 3)
    assert digests(run) == before
    drawn = sorted(path.name for path in (tmp_path / "drawn").iterdir())
    assert drawn == ["figure_15.png", "figure_19.png", "peak_floor_accelerations.png"]
    with open_run(run) as opened:
        at_edge = opened.transient.psa.sel(probe="edge_3", component="y")[0]
        assert f"edge_3: peak {float(at_edge.max()):5.1f} m/s²" in told
        slab = np.unique(opened.maps.floor_triangle_node)
        largest = float(opened.maps.pfa.sel(component="y")[slab].max())
        assert f"largest: {largest:.1f} m/s² at " in told


def test_damping_study(execute, built, tmp_path):
    shutil.copytree(built.folder, tmp_path, dirs_exist_ok=True)
    case = tmp_path / "pump.toml"
    case.write_text(DEVICE)
    names = {"case_file": str(case), "run_folder": "run", "sweep_folder": "sweep"}
    told = check(execute("damping_study", tmp_path, **names, ratios=["3 %", "7 %"]), 4)
    assert "damping cases: own, light" in told
    with open_run(tmp_path / "run") as run:
        rows = re.findall(r"(own|light) +(?:law|[\d.]+) +(without|with) +([\d.]+) +([\d.]+)", told)
        assert len(rows) == 4
        for one, impact, detailed, spectrum in rows:
            there = {"case": one, "impact": impact, "component": "y", "device": "pump"}
            expected = 1e-3 * float(run.device.largest_force.sel(there))
            assert float(detailed) == pytest.approx(expected, abs=0.006)
            there["choice"] = run.device.attrs["headline"]
            expected = 1e-3 * float(run.device.spectrum_force.sel(there))
            assert float(spectrum) == pytest.approx(expected, abs=0.006)
    forces = [float(row) for row in re.findall(r"^ +0\.0[37] +([\d.e+]+)", told, re.MULTILINE)]
    assert len(forces) == 2 and forces[0] > forces[1] > 0.0  # more damping, less force


def test_contact_law(execute, new_case, tmp_path):
    case = new_case(tmp_path)
    told = check(execute("contact_law", tmp_path, case_file=str(case), epsilon=0.5), 3)
    found = re.findall(r"restitution requested 0\.5, found ([\d.]+)", told)
    assert [float(value) for value in found] == pytest.approx([0.5, 0.5], abs=2e-3)
    errors = [float(e) for e in re.findall(r"steps an impact: largest difference (\S+)", told)]
    assert len(errors) == 4 and errors[-1] < 1e-4 and errors[0] > 100.0 * errors[-1]
    assert "contact law 'wrong': force = " in told
    (forces,) = re.findall(r"largest force +MN +([\d.]+) +([\d.]+)", told)
    assert forces[0] != forces[1] and float(forces[1]) == pytest.approx(float(forces[0]), rel=0.4)


@pytest.mark.parametrize("name", ALL)
def test_form(name, notebooks):
    """What it teaches comes first; a reader finds it in the documentation."""
    text = (notebooks / f"{name}.py").read_text(encoding="utf-8")
    assert text.count("# %% tags=") == text.count('# %% tags=["parameters"]') == 1
    first = text.split("# %%")[1]
    assert "[markdown]" in first and "What this notebook teaches: " in first
    listed = (notebooks.parent / "docs" / "notebooks.md").read_text(encoding="utf-8")
    assert f"`notebooks/{name}.py`" in listed


def test_all_are_tested_and_no_output_is_kept(notebooks):
    assert sorted(path.stem for path in notebooks.glob("*.py")) == sorted(ALL)
    ignored = (notebooks.parent / ".gitignore").read_text(encoding="utf-8").splitlines()
    assert "*.ipynb" in ignored


PLOT = "plt.plot([1, 2])\nplt.xlabel('time [s]')\nplt.show()\n"


@pytest.mark.parametrize(
    ("cell", "options", "error", "message"),
    [
        (
            'raise ValueError(f"a cell that fails with {folder}")\n',
            *({"plain": True, "folder": "y"}, CellExecutionError, "a cell that fails with y"),
        ),
        (
            f"import matplotlib.pyplot as plt\n{PLOT}",
            *({}, CellExecutionError, "an axis of a figure is labelled '', without a"),
        ),
        (
            "while True:\n    pass\n",
            *({"plain": True, "limit": 1}, CellTimeoutError, "executed, after 1 seconds"),
        ),
    ],
)
def test_a_cell_that_fails(execute, tmp_path, cell, options, error, message):
    notebook = tmp_path / "fails.py"
    notebook.write_text(NOT_RUN + cell)
    with pytest.raises(error, match=message):
        execute(notebook, tmp_path, **options)


def test_parameters_that_are_none(execute, tmp_path):
    notebook = tmp_path / "one.py"
    notebook.write_text(NOT_RUN)
    with pytest.raises(ValueError, match="foldr: no parameter of the notebook"):
        execute(notebook, tmp_path, foldr="y")
    notebook.write_text("# %%\nfolder = 'x'\n")
    with pytest.raises(ValueError, match="expected one cell that is tagged 'parameters', found 0"):
        execute(notebook, tmp_path, folder="y")
