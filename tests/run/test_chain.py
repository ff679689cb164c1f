"""Every stage on the shipped frame: from the wall experiment to the force of a pump."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from frame_case import LIGHT, QUICK, SOFT_NEIGHBOUR, floors_meet, pump
from impactfem import study
from impactfem.run import loop
from no_pictures import no_pictures

pytestmark = pytest.mark.slow
GEOMETRY = Path(__file__).parents[2] / "geometry"
REST = (
    """
[wall_impact]
gap = "2 mm"
displacement = "-5 mm"
pull = "even_load"
duration = "0.4 s"
time_step = "0.25 ms"

[[damping_cases]]
name = "light"
ratio = "0.5 %"
frequencies = ["1 Hz", "20 Hz"]

[contact_laws.floor]
type = "kelvin-voigt"
stiffness = "calibrated"
restitution = "calibrated"
"""
    + floors_meet("0.2 mm")
    + """
[transient]
time_step = "1 ms"
maximum_frequency = "100 Hz"

"""
    + pump('["2 m", "2.2 m", "6 m"]', "0.8 m")
    + """
[ensemble]
motions = 2
structure_motions = 2

[sensitivity]
parameters = ["gap"]
"""
)


@pytest.fixture(scope="module")
def case(edited, tmp_path_factory):
    folder = tmp_path_factory.mktemp("chain")
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, folder)
    path = edited(folder / "frame.toml", *QUICK, LIGHT, SOFT_NEIGHBOUR)
    path.write_text(path.read_text() + REST)
    return path


@pytest.fixture(scope="module")
def done(case):
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        return loop.run(case, out=case.parent / "run")


def values(run):
    return {scalar.name: scalar.value for scalar in run.scalars}


def test_calibrated_values_reach_the_contact(done):
    found = values(done)
    assert 0.0 < found["calibration.epsilon"] < 1.0
    assert found["calibration.epsilon.light"] > found["calibration.epsilon"]
    with xr.open_dataset(done.folder / "forces.nc", engine="netcdf4") as forces:
        laws = [str(law) for law in forces["law"].values]
    with xr.open_dataset(done.folder / "calibrate.nc", engine="netcdf4") as store:
        assert float(store["epsilon"][0]) == pytest.approx(found["calibration.epsilon"])
        assert float(store["complementarity"].max()) < 1e-9
    assert f"{found['calibration.K_Ceq']:.4g}"[:4] in laws[0]
    assert found["pounding.impacts"] > 0


def test_the_pump(done):
    found = values(done)
    for name in ("detailed", "rsa"):
        assert found[f"device.fy.{name}.impact"] > found[f"device.fy.{name}.no_impact"] > 0.0
    assert abs(found["device.relative_difference.no_impact"]) < 0.6
    assert found["device.fy.detailed.impact.light"] > found["device.fy.detailed.impact"]
    with xr.open_dataset(done.folder / "device.nc", engine="netcdf4") as store:
        assert store["case"].values.tolist() == ["own", "light"]
        assert float(store["epsilon"][1]) == found["calibration.epsilon.light"]  # one value
        assert float(store["imbalance"].max()) < 1e-8
        largest = float(abs(store["force"].isel(case=0, impact=1, device=0, component=1)).max())
    assert largest == pytest.approx(found["device.fy.detailed.impact"], rel=1e-5)


def test_beside_another_run(case, done, tmp_path, caplog):
    """The report shows the comparison until it is damaged, or of other results."""
    folder, title = tmp_path / "run", "Comparison with another run"
    shutil.copytree(done.folder, folder)
    table, page = study.compare_runs(folder, done.folder, 100.0)
    assert {row[4] for row in table.rows} <= {1.0, None} and len(table.rows) > 50
    assert (folder / "figures" / "comparison_spectra.svg").is_file()
    for name in (str(folder), str(done.folder)):
        assert name in page.read_text(encoding="utf-8")
    assert title in page.read_text(encoding="utf-8")
    assert title not in (done.folder / "report.html").read_text(encoding="utf-8")
    assert title in study.make_report(folder).read_text(encoding="utf-8") and not caplog.messages
    listed = json.loads((folder / "comparison.stage.json").read_text())
    (folder / "comparison.stage.json").write_text(json.dumps(listed | {"inputs": "of others"}))
    assert title not in study.make_report(folder).read_text(encoding="utf-8")
    assert "'impactfem compare' makes" in caplog.messages[0]


def test_a_part_of_the_stages(case, done, tmp_path):
    """`device` needs no `transient`: a run up to it keeps its results, where they are whole."""
    folder = tmp_path / "run"
    shutil.copytree(done.folder, folder)
    again = loop.run(case, out=folder, stage="device")
    assert list(again.checks) == list(done.checks) and values(again) == values(done)
    (folder / "transient.nc").unlink()
    again = loop.run(case, out=folder, stage="device")
    # Nor does what needs it stand without it.
    gone = ("transient", "design", "sensitivity")
    assert list(again.checks) == [k for k in done.checks if k not in gone]


def test_a_wider_wall_gap_calibrates_again(case, done, edited, tmp_path, monkeypatch):
    """The reduced model serves again; what follows from the restitution does not."""
    no_pictures(monkeypatch)
    shutil.copytree(case.parent, tmp_path, dirs_exist_ok=True)
    other = edited(tmp_path / "frame.toml", ('gap = "2 mm"', 'gap = "3 mm"'))
    again = loop.run(other, out=tmp_path / "run", stage="pounding")
    assert again.reused == ["building", "reduce"]
    assert values(again)["calibration.epsilon"] != values(done)["calibration.epsilon"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('gap = "2 mm"', 'gap = "20 mm"', "no impact: floor 2 does not touch the wall"),
        ('duration = "0.4 s"', 'duration = "0.07 s"', "(still going on|no impact)"),
    ],
)
def test_refused(case, done, edited, tmp_path, monkeypatch, old, new, message):
    """What cannot be evaluated is told, and leaves the stores of the run as they were."""
    no_pictures(monkeypatch)
    shutil.copytree(case.parent, tmp_path, dirs_exist_ok=True)
    before = {path.name: path.read_bytes() for path in (tmp_path / "run").glob("*.nc")}
    other = edited(tmp_path / "frame.toml", (old, new))
    with pytest.raises(Exception, match=message):
        loop.run(other, out=tmp_path / "run")
    for name, content in before.items():
        if name in ("calibrate.nc", "device.nc"):
            assert (tmp_path / "run" / name).read_bytes() == content


@pytest.fixture
def copied(case, done, tmp_path, monkeypatch):
    """A copy of the case with its run, by name."""
    no_pictures(monkeypatch)
    return lambda name: Path(shutil.copytree(case.parent, tmp_path / name)) / "frame.toml"


@pytest.mark.parametrize(
    ("old", "new", "kept"),
    [
        ('gap = "0.2 mm"', 'gap = "0.21 mm"', True),
        ("floor = [1, 2], offset", "floor = [1], offset", False),
    ],
)
def test_reduced_model_of_the_devices(copied, done, edited, old, new, kept):
    """It serves other gaps; other floors that may be hit have another floor with waves, too."""
    path = edited(copied("gap"), (old, new))
    again = loop.run(path, out=path.parent / "run", stage="device")
    assert again.reused == (["building", "reduce", "calibrate"] if kept else ["building"])
    assert values(again)["device.fy.detailed.impact"] != values(done)["device.fy.detailed.impact"]


def test_two_ranks(case, done, under_mpirun, tmp_path):
    """All stages on two ranks, an ensemble in 3D included, have the results of one rank."""
    shutil.copytree(case.parent, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("run"))
    out = tmp_path / "ranks"
    words = ("run", tmp_path / "frame.toml", "--stage", "design", "--out", out)
    ended = under_mpirun(2, sys.executable, "-c", MAIN, *words)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("checks: ") == 1
    assert json.loads((out / "provenance.json").read_text())["ranks"] == 2
    known, summary = values(done), json.loads((out / "summary.json").read_text())
    assert {entry["name"] for entry in summary} <= set(known)
    for entry in summary:
        name, value = entry["name"], entry["value"]
        if value is None or name.rsplit(".", 1)[-1] in ROUNDING or "seconds" in name:
            continue
        assert value == pytest.approx(known[name], rel=1e-5, abs=1e-9), name
    for name, variables in {
        "transient.nc": ("acceleration", "displacement", "psa", "transfer_re", "edge_force"),
        "transient_maps.nc": ("psa", "pfa", "wave_displacement", "membrane_force"),
    }.items():
        paths = (out / name, done.folder / name)
        two, one = (xr.load_dataset(path, engine="netcdf4") for path in paths)
        for variable in variables:
            difference = np.abs(two[variable] - one[variable]).max()
            assert float(difference / np.abs(one[variable]).max()) < 1e-6, variable


MAIN = f"""
import sys
import pytest
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
from no_pictures import no_pictures
from impactfem.cli import main

no_pictures(pytest.MonkeyPatch())
main()
"""
ROUNDING = {
    "complementarity",
    "energy_residual",
    "energy_gained",
    "impulse_error",
    "basis_difference",
    "basis_error",
    "contact_energy_defect",
}
"""Scalars that are rounding errors, or estimates of errors."""
