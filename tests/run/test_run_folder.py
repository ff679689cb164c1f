"""A run opened for reading: scalars by name, stores by attribute, and what is not there."""

import csv
import json
import math
import subprocess
import sys

import numpy as np
import pytest

from impactfem.device.models import TableMode, from_modes
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.run.folder import STORES, open_run
from impactfem.system.errors import ImpactfemError, InputError


def test_scalars(finished):
    with open_run(finished.folder) as run:
        told = {scalar.name: scalar for scalar in finished.run.scalars if not scalar.detail}
        assert list(run.summary) == list(told)
        assert run.value("motion.pga") == told["motion.pga"].value
        (detail,) = (s for s in finished.run.scalars if s.name == "motion.pgd")
        assert detail.detail and run.value("motion.pgd") == detail.value
        entry = run.summary["motion.pga"]
        assert (entry.unit, entry.paper) == ("m/s2", pytest.approx(3.0))
        table = run.table("pounding.peak_force.*", "motion.pga")
        assert len(table.rows) == 4
        assert table.rows[0] == ("motion.pga", entry.value, "m/s2", entry.paper)
        assert len(run.table().rows) == len(told)


def test_stores(finished):
    with open_run(str(finished.folder)) as run:
        assert run.stores == ("pounding", "motion", "forces")
        assert run.pounding is run.pounding
        pfa = run.pounding.pfa.sel(station="west.floor_3", direction="y")
        assert float(pfa) == pytest.approx(run.value("frs.floor_3.pfa"))
        assert run.forces.force.dims == ("time", "pair") and "acceleration" in run.motion


def test_a_store_that_is_not_there(finished):
    absent = set(STORES) - {"pounding", "motion", "forces"}
    assert {"building", "reduce", "calibrate", "ensemble", "maps", "device", "design"} <= absent
    with open_run(finished.folder) as run:
        for name in absent:
            words = rf"{STORES[name]}: missing; the stores of this run are: pounding, motion, forc"
            with pytest.raises(InputError, match=words):
                getattr(run, name)


def test_stores_of_a_further_building(tmp_path):
    """Its own ones and those of the whole run; what the first alone has is not taken for its."""
    (tmp_path / "B").mkdir()
    for name in ("building.nc", "calibrate.nc", "device.nc", "pounding.nc", "B/building.nc"):
        (tmp_path / name).touch()
    (tmp_path / "summary.json").write_text("[]")
    models = {"structure": {"building": "A"}, "further_structures": [{"building": "B"}]}
    (tmp_path / "case.json").write_text(json.dumps(models))
    with open_run(tmp_path) as run:
        assert run.stores == ("building", "calibrate", "pounding", "device")
        assert run.of("B").stores == ("building", "pounding")
        with pytest.raises(InputError, match=r"calibrate\.nc: missing"):
            _ = run.of("B").calibrate


def test_results_that_are_not_there(finished, tmp_path):
    with open_run(finished.folder) as run:
        expected = r"summary.json: motion\.pgaa: .*did you mean 'motion\.pga'\?"
        with pytest.raises(InputError, match=expected):
            run.value("motion.pgaa")
    entry = {"name": "x", "value": None, "unit": "-", "paper": None, "note": "no impact"}
    (tmp_path / "summary.json").write_text(json.dumps([entry]))
    (tmp_path / "motion.nc").write_text("nothing")
    with (
        pytest.raises(ImpactfemError, match=r"cannot read .*motion\.nc"),
        open_run(tmp_path) as run,
    ):
        _ = run.motion
    (tmp_path / "motion.nc").unlink()
    with open_run(tmp_path) as run:
        assert run.stores == ()
        with pytest.raises(InputError, match=r"run\. no impact"):
            run.value("x")
        with pytest.raises(InputError, match="stores of this"):
            _ = run.pounding


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (None, "missing; expected the folder of a run"),
        ("[", "cannot be read"),
        ("[{}]", "cannot be read"),
        ("3", "cannot be read"),
        ('[{"name": "x"}]', "cannot be read"),
    ],
)
def test_no_run(tmp_path, content, expected):
    if content is not None:
        (tmp_path / "summary.json").write_text(content)
    with pytest.raises(InputError, match=rf"summary\.json: {expected}"):
        open_run(tmp_path)


def test_neither_fenicsx_nor_vtk_is_loaded():
    """They crash beside each other: who reads a run may load either."""
    program = (
        "import sys; from impactfem.run.folder import open_run; "
        "print([n for n in ('dolfinx', 'petsc4py', 'vtkmodules', 'pyvista') if n in sys.modules])"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert ended.stdout == "[]\n", ended.stderr


def test_a_device_on_a_stick(finished):
    """One mode has m S(f), with the broadened ordinate of its floor in the table of products."""
    path = finished.folder / "products" / "floor_spectra.csv"
    with path.open(encoding="utf-8") as lines:
        place = {"building": "east", "floor": "2"}
        rows = [row for row in csv.DictReader(lines) if place.items() <= row.items()]
    row = rows[len(rows) // 2]
    mode = TableMode(float(row["frequency [Hz]"]), "y", 300.0, height=1.5)
    device = from_modes("cabinet", [mode], damping=float(row["damping [-]"]))
    with open_run(finished.folder) as run:
        found = spectrum_analysis(device, run.anchor_spectra("east", 2))
        assert found.value("force y") == pytest.approx(300.0 * float(row["broadened [m/s2]"]))
        assert found.value("moment x") == pytest.approx(1.5 * found.value("force y"))
        other = spectrum_analysis(device, run.anchor_spectra("east", 3))
        assert other.value("force y") != pytest.approx(found.value("force y"), rel=0.01)
        with pytest.raises(InputError, match="spectrum of floor 9"):
            run.anchor_spectra("east", 9)


def test_a_device_on_a_stick_that_rocks(finished):
    """The rotation moves its mass by height times angle; left out, nothing is other than before."""
    with open_run(finished.folder) as run:
        straight, both = (run.anchor_spectra("east", 2, rotations=r) for r in (False, True))
        psa = run.pounding["rotational_psa"].sel(station="east.floor_2", rotation="rx")
    assert [one.component for one in both] == ["y", "rx"] and len(straight) == 1
    ordinates = both[0].psa, both[1].psa
    assert np.array_equal(ordinates[0], straight[0].psa)
    assert ordinates[1].max(axis=1) == pytest.approx(psa.max("frequency").values)
    k = len(both[1].frequency) // 2
    mode = TableMode(float(both[1].frequency[k]), "y", 300.0, height=1.5)
    device = from_modes("cabinet", [mode], damping=float(both[1].damping[0]))
    turned = spectrum_analysis(device, both[1:]).value("force y")
    assert turned == pytest.approx(300.0 * 1.5 * ordinates[1][0, k])
    alone, whole = (spectrum_analysis(device, one).value("force y") for one in (straight, both))
    assert whole == pytest.approx(math.hypot(alone, turned)) and turned > 0.001 * alone
