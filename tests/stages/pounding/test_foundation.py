"""What the stage says of buildings on soil: store, scalars, tables, checks, uplift."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.records.accelerogram import STANDARD_GRAVITY
from impactfem.stages.pounding.checks import stick_checks
from impactfem.stages.pounding.foundation import foundations
from impactfem.stages.pounding.model_checks import SOIL_DAMPING, soil_checks
from impactfem.stages.pounding.store import stick_scalars, write_motion, write_sticks
from impactfem.stages.pounding.tables import stick_tables
from impactfem.stages.stores import open_store

# Debian's h5py on the NumPy 1.26 of the virtual environment.
pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

SOIL = """
[buildings.soil]
type = "half-space"
shear_velocity = "200 m/s"
density = "1900 kg/m3"
poisson_ratio = 0.3
raft = { length = "40 m", width = "30 m", thickness = "1 m", density = "2500 kg/m3" }
"""


@pytest.fixture(scope="module")
def soft(small_case, run):
    """The small case with its last building on soil."""
    return run(small_case(extra=SOIL))


def test_first_modes_and_weight(soft, study):
    (one,) = soft.foundations
    assert study.foundations == ()
    stick = soft.system.stick(one.building)
    k = [stick.name for stick in soft.system.sticks].index(one.building)
    for axis, family in enumerate("xy"):
        modes = soft.modes[k]
        assert one.clamped_frequency[axis] == pytest.approx(
            modes.frequency[modes.of_family(family)[0]], rel=1e-9
        )
    assert (one.frequency < one.clamped_frequency).all()
    mass = sum(floor.mass for floor in stick.floors) + 40.0 * 30.0 * 1.0 * 2500.0
    assert one.weight == pytest.approx(mass * STANDARD_GRAVITY)
    # At rest the whole raft is pressed by the weight.
    assert one.pressure[0] == pytest.approx(one.static_pressure)
    assert one.radiated > 0.0
    assert one.band == pytest.approx([one.frequency.min(), 2.0 * one.clamped_frequency.max()])
    assert one.stiffness_error.max() < 0.03 and one.damping_error.max() < 0.1


def test_pressure_at_the_corners(soft):
    """By the moment about the underside: that at the base and the shear times the thickness."""
    (one,) = soft.foundations
    base = soft.response.bases[one.building]
    F = np.zeros_like(base.force)
    F[:, 1], F[:, 2], F[:, 3] = 3e6, -2e6, 5e7
    moved = replace(soft.response, bases={one.building: replace(base, force=F)})
    (found,) = foundations(soft.case, moved)
    # A shear of the raft on the soil at the top turns it about x by −F_y · 1 m about the underside.
    moment = 5e7 - 3e6 * 1.0
    expected = (one.weight + 2e6) / 1200.0 - moment * 15.0 / (40.0 * 30.0**3 / 12.0)
    assert found.pressure == pytest.approx(expected, rel=1e-12)


def test_store_tables_and_checks(soft, tmp_path):
    path = tmp_path / "pounding.nc"
    write_sticks(path, soft, "key")
    write_motion(tmp_path / "motion.nc", soft, "key")
    with open_store(path) as store:
        assert store["foundation"].values.tolist() == [soft.foundations[0].building]
        assert store["base_displacement"].dims == ("time", "foundation", "foundation_component")
        assert float(store["foundation_pressure"].min()) == soft.foundations[0].pressure.min()
    tables = {file.name: file.read_text(encoding="utf-8") for file in stick_tables(tmp_path)}
    assert len(tables["foundations.csv"].splitlines()) == 3
    assert len(tables["soil.csv"].splitlines()) == 7
    values = {scalar.name: scalar.value for scalar in stick_scalars(soft)}
    name = soft.foundations[0].building
    ratio = values[f"soil.{name}.least_pressure_ratio"]
    checks = {check.id: check for check in stick_checks(path.parent, 16, {})}
    raft = checks["pounding.raft_pressure"]
    assert raft.passed is (ratio >= 0.0) and raft.value == pytest.approx(ratio)
    assert checks["pounding.soil_period"].place == name
    for of in ("stiffness", "damping"):
        check = checks[f"pounding.soil_{of}"]
        error = getattr(soft.foundations[0], f"{of}_error").max()
        assert check.passed and check.place.startswith(name)
        assert check.value == values[f"soil.{name}.{of}_error"] == error
    assert "error of the damping" in tables["soil.csv"].splitlines()[0]
    assert values[f"soil.{name}.period_ratio.y"] > 1.0


def test_an_error_of_the_damping_alone_fails():
    """The stiffness of a model may be right within a per cent, and its damping not."""
    checks = soil_checks("a", (0.01, 1.5 * SOIL_DAMPING.upper), "from 1 to 2 Hz")
    assert [(check.id, check.passed) for check in checks] == [
        ("pounding.soil_stiffness", True),
        ("pounding.soil_damping", False),
    ]
