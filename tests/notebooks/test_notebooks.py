"""Notebooks from top to bottom on a small case; `render_notebooks.py` runs all of them."""

import base64
import hashlib
import io
import re
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread
from nbclient.exceptions import CellExecutionError

from impactfem.run.folder import open_run

pytestmark = pytest.mark.slow(10)
ALL = (
    "ensemble_percentiles",
    "film_of_both_buildings",
    "first_steps",
    "own_building",
    "read_a_run",
    "three_contact_laws",
)
# Small meshes and short times: the numbers are of no use.
SHORT = {"mesh_size": 1.5, "duration": 2.0, "highest": 60.0}
STICKS = {
    "motions[0].duration": "4 s",
    "motions[0].strong_phase": ["0.5 s", "3 s"],
    "spectra.frequencies": {"minimum": "0.5 Hz", "maximum": "100 Hz", "per_decade": 10},
}
PAIR = {
    **{f"buildings[{k}].structure.mesh.size": "2 m" for k in (0, 1)},
    "motions[0].duration": "3 s",
    "motions[0].strong_phase": ["0.3 s", "2 s"],
    "pounding.duration": "3 s",
    "pounding.time_step": "1 ms",
    "pounding.contact_spacing": "6 m",
    "transient.time_step": "2 ms",
    "transient.maximum_frequency": "30 Hz",
    "spectra.frequencies": {"minimum": "0.5 Hz", "maximum": "30 Hz", "per_decade": 10},
}
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
def filmed(execute, notebooks, tmp_path_factory):
    """The folder of the notebook `film_of_both_buildings` after it ran, and the notebook."""
    folder = tmp_path_factory.mktemp("filmed")
    case = notebooks.parent / "geometry" / "tower_pair.toml"
    names = {"case_file": str(case), "folder": str(folder / "run"), "changes": PAIR}
    ran = execute("film_of_both_buildings", folder, film=True, **names)
    return SimpleNamespace(folder=folder / "run", notebook=ran)


def test_first_steps(execute, tmp_path):
    text = check(execute("first_steps", tmp_path, folder="out", changes=STICKS), 2)
    assert "= '0.3 kg': 'kg'" in text
    assert "spectra.damping[0] = '500 %'" in text
    with open_run(tmp_path / "out" / "run") as run:
        force = 1e-6 * run.value("pounding.main_impact_force")
    assert force > 0.0 and f"largest impact force: {force:.2f} MN" in text


def test_own_building(execute, tmp_path):
    text = check(execute("own_building", tmp_path, folder="own", **SHORT), 2)
    assert ": valid" in text and "stand_in.AT2" in text
    with open_run(tmp_path / "own" / "run") as run:
        assert run.value("pounding.main_impact_force") > 1e5
        first = run.value("building.frequency.1")
        assert float(run.pounding.calibrated_frequency[0]) == pytest.approx(first, rel=1e-3)
        # At low frequencies the floor of the 3D model moves as a rigid body, as the stick.
        stick = run.pounding.psa.sel(station="mine.floor_3", direction="y")[0]
        centre = run.transient.psa.sel(probe="centre_3", component="y")[0]
        low = stick.frequency.values < 0.8 * first
        assert stick.values[low] == pytest.approx(centre.values[low], rel=0.1)


def test_film_of_both_buildings(filmed):
    text = check(filmed.notebook, 2)
    assert "pounding.main_impact_force" in text
    outputs = [one for cell in filmed.notebook.cells for one in cell.get("outputs", [])]
    (film,) = [one.data["image/gif"] for one in outputs if "image/gif" in one.get("data", {})]
    assert base64.b64decode(film).startswith(b"GIF8")


def test_read_a_run(execute, filmed, tmp_path):
    before = digests(filmed.folder)
    text = check(execute("read_a_run", tmp_path, folder=str(filmed.folder)), 3)
    assert digests(filmed.folder) == before
    with open_run(filmed.folder) as run:
        maps, direction = run.maps, run.transient.attrs["shown_direction"]
        slab = maps.floor_triangle_node.values[maps.floor_triangle_floor.values == 4]
        largest = float(maps.pfa.sel(component=direction)[np.unique(slab)].max())
    (found,) = re.findall(r"floor 4: +([\d.]+) m/s²", text)
    assert float(found) == pytest.approx(largest, abs=0.06)


@pytest.mark.parametrize("name", ALL)
def test_form(name, notebooks):
    """What it teaches comes first; a reader finds it in the documentation."""
    text = (notebooks / f"{name}.py").read_text(encoding="utf-8")
    assert text.count("# %% tags=") == text.count('# %% tags=["parameters"]') == 1
    first = text.split("# %%")[1]
    assert "[markdown]" in first and "notebook teaches: " in first
    listed = (notebooks.parent / "docs" / "notebooks" / "index.md").read_text(encoding="utf-8")
    assert f"({name}.md)" in listed


def test_all_are_listed_and_no_output_is_kept(notebooks):
    assert sorted(path.stem for path in notebooks.glob("*.py")) == sorted(ALL)
    ignored = (notebooks.parent / ".gitignore").read_text(encoding="utf-8").splitlines()
    assert "*.ipynb" in ignored


PLOT = "plt.plot([1, 2])\nplt.xlabel('time [s]')\nplt.show()\n"


def test_an_axis_without_a_unit_fails(execute, tmp_path):
    notebook = tmp_path / "fails.py"
    notebook.write_text(f"{NOT_RUN}import matplotlib.pyplot as plt\n{PLOT}")
    with pytest.raises(CellExecutionError, match="axis of a figure"):
        execute(notebook, tmp_path)


def test_parameters_that_are_none(execute, tmp_path):
    notebook = tmp_path / "one.py"
    notebook.write_text(NOT_RUN)
    with pytest.raises(ValueError, match="foldr: no parameter"):
        execute(notebook, tmp_path, foldr="y")
    notebook.write_text("# %%\nfolder = 'x'\n")
    with pytest.raises(ValueError, match="tagged 'parameters', found 0"):
        execute(notebook, tmp_path, folder="y")
