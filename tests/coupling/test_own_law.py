"""Laws of one's own: the program's laws written again, one with a closed form, and faulty ones."""

import dataclasses
import gc
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numba.core.errors import TypingError

from impactfem.coupling import restitution as relations
from impactfem.coupling.contact import (
    Law,
    compile_force,
    effective_mass,
    hertz,
    hertz_damp,
    jankowski,
    kelvin_voigt,
    law_force,
)
from impactfem.coupling.impacts import impacts
from impactfem.coupling.own_law import OwnLaw, own_law
from impactfem.coupling.pounding import Response, simulate
from impactfem.stages.pounding.compute import run_sticks
from impactfem.stages.pounding.store import write_sticks
from impactfem.system.errors import InputError
from impactfem.verify.contact import collision

M1, M2 = 1574e3, 3014e3
MASS = effective_mass(M1, M2)
SPEED = 0.3
BETA = 1.4e12


def spring_dashpot(q, p, v, v0):
    return q[0] * p + q[1] * v, q[0], q[1]


def soft_start(q, p, v, v0):
    """F = K p (1 + χ v / v₀): the relation of `exact_chi` holds for any power of p."""
    factor = 1.0 + q[1] * v / v0
    return q[0] * p * factor, q[0] * factor, q[0] * p * q[1] / v0


def damped_hertz(q, p, v, v0):
    elastic = q[0] * p * math.sqrt(p)
    factor = 1.0 + q[1] * v / max(v0, q[2])
    if factor <= 0.0:
        return 0.0, 0.0, 0.0
    return elastic * factor, 1.5 * q[0] * p**0.5 * factor, elastic * q[1] / max(v0, q[2])


def dashpot_while_approaching(q, p, v, v0):
    """Jankowski's law: its slope has a kink at rest."""
    elastic, slope = q[0] * p**1.5, 1.5 * q[0] * p**0.5
    if v <= 0.0:
        return elastic, slope, 0.0
    root = p**0.25
    return elastic + q[1] * root * v, slope + 0.25 * q[1] * root / p * v, q[1] * root


def under(law: Law, other: Response) -> Response:
    """The same collision under another law."""
    system = other.system.with_laws(lambda pair: law)
    return simulate(system, other.ground, other.time_step, v0=other.v[0])


@pytest.mark.parametrize(
    ("known", "force"),
    [
        (kelvin_voigt(1e11, 0.12, MASS), spring_dashpot),
        (hertz_damp(BETA, 0.5, MASS, exact=True), damped_hertz),
        (jankowski(BETA, 0.5, MASS), dashpot_while_approaching),
    ],
)
@pytest.mark.parametrize("steps", [7.3, 50.3])
def test_a_law_of_the_program_written_again(known, force, steps):
    law = own_law("again", force, known.parameters, MASS)
    assert law.epsilon == pytest.approx(known.epsilon, rel=1e-7)
    assert law.onset_force(SPEED) == pytest.approx(known.onset_force(SPEED), abs=1e-3)
    if known.linear:
        assert law.duration(SPEED) == pytest.approx(known.duration(SPEED), rel=1e-7)
    response = collision(known, M1, M2, SPEED, known.duration(SPEED) / steps, phase=0.4)
    again = under(law, response)
    assert np.abs(response.force).max() > 0.0
    assert again.force == pytest.approx(response.force, rel=1e-9, abs=1e-9 * response.force.max())
    # Another law gives another force.
    other = under(own_law("soft", soft_start, (2e10, 0.1), MASS), response)
    assert np.abs(other.force - response.force).max() > 0.1 * response.force.max()


@pytest.mark.parametrize("epsilon", [0.2, 0.5, 0.687, 0.95])
def test_restitution_by_the_closed_form(epsilon):
    law = own_law("soft start", soft_start, (1e11, relations.exact_chi(epsilon)), MASS)
    assert law.epsilon == pytest.approx(epsilon, rel=1e-8)
    assert law.restitution(0.01) == pytest.approx(epsilon, rel=1e-8)  # at any speed
    dt = law.duration(SPEED) / 300.3
    (impact,) = impacts(collision(law, M1, M2, SPEED, dt, phase=0.4))
    assert impact.restitution == pytest.approx(epsilon, abs=5e-4)
    assert impact.duration == pytest.approx(law.duration(SPEED), rel=1e-3)
    wrong = own_law("soft start", soft_start, (1e11, 0.9 * relations.exact_chi(epsilon)), MASS)
    assert abs(wrong.epsilon - epsilon) > 2e-3


def test_an_elastic_one_lasts_half_a_period():
    law = own_law("spring", spring_dashpot, (1e11, 0.0), MASS)
    assert (law.epsilon, law.asked) == pytest.approx((1.0, 1.0), rel=1e-8)
    assert law.duration(SPEED) == pytest.approx(math.pi * math.sqrt(MASS / 1e11), rel=1e-8)
    assert law.duration(0.0) == math.inf
    elastic = own_law("hertz", lambda q, p, v, v0: (q[0] * p**1.5, 1.5 * q[0] * p**0.5, 0.0),
                      (BETA,), MASS)  # fmt: skip
    assert elastic.duration(SPEED) == pytest.approx(hertz(BETA, MASS).duration(SPEED), rel=1e-5)
    assert elastic.duration(0.1) > elastic.duration(0.4)


def test_what_it_says_of_itself():
    law = own_law("mine", spring_dashpot, [2e9, 1e5], 3e5, asked=0.9, unit="kN/mm")
    assert isinstance(law, OwnLaw) and not law.linear and math.isnan(law.xi)
    assert (law.name, law.stiffness, law.mass, law.asked) == ("mine", 2e9, 3e5, 0.9)
    assert law.parameters.tolist() == [2e9, 1e5, 0.0, 0.0]
    assert law.describe().startswith(
        "mine: stiffness 2e+09 kN/mm, restitution requested 0.9, of two"
    )


def test_the_stage_and_its_store(study, tmp_path):
    """Everything that is told of a law of the program is told of one's own."""
    again = study.system.with_laws(
        lambda pair: own_law("again", spring_dashpot, pair.law.parameters, pair.law.mass)
    )
    found = run_sticks(study.case, ready=(study.calibration, again))
    assert found.main_impact.peak_force == pytest.approx(study.main_impact.peak_force, rel=1e-6)
    assert found.floors.pfa == pytest.approx(study.floors.pfa, rel=1e-6)
    assert found.steps_per_impact_min == pytest.approx(study.steps_per_impact_min, rel=1e-6)
    write_sticks(tmp_path / "pounding.nc", found, "")
    with xr.open_dataset(tmp_path / "pounding.nc", engine="netcdf4") as store:
        assert set(store.pair_law.values) == {"again"}
        assert set(store.pair_stiffness_unit.values) == {"N/m"}
        expected = [pair.law.epsilon for pair in study.system.pairs]
        assert store.pair_restitution.values == pytest.approx(expected, rel=1e-6)
        assert np.isnan(store.pair_dashpot).all()
    mixed = study.system.with_laws(
        lambda pair: pair.law if pair.a.floor == 1 else hertz(BETA, pair.law.mass)
    )
    write_sticks(tmp_path / "mixed.nc", run_sticks(study.case, ready=(None, mixed)), "")
    with xr.open_dataset(tmp_path / "mixed.nc", engine="netcdf4") as store:
        assert store.pair_stiffness.attrs["units"] == "N/m, N/m^1.5"


def test_a_function_is_compiled_once_and_kept():
    """The address of a function that is gone may be that of another one."""
    one, other = (own_law("spring", spring_dashpot, (K, 0.0), MASS) for K in (1e10, 2e10))
    assert one.code == other.code > 1000
    del other
    gc.collect()
    assert law_force(one.code, one.parameters, 1e-3, 0.0, 0.3)[0] == pytest.approx(1e7)
    assert dataclasses.replace(one, name="x").duration(SPEED) == one.duration(SPEED)


def falls(q, p, v, v0):
    return q[0] * p - 0.1 * q[0] * p * v / v0, q[0] - 0.1 * q[0] * v / v0, -0.1 * q[0] * p / v0


APART = "expected a force that parts two free masses"


@pytest.mark.parametrize(
    ("force", "expected"),
    [
        (falls, "F falls with v"),
        (lambda q, p, v, v0: (q[0] * p, 2.0 * q[0], 0.0), r"dF/dp = 2e\+11, expected 1e\+11, as F"),
        (lambda q, p, v, v0: (q[0] * p + q[1] * v, q[0], 0.0), r"dF/dv = 0, expected 1e\+06"),
        (lambda q, p, v, v0: (0.0, 0.0, 0.0), APART),
        (lambda q, p, v, v0: (q[0] * v, 0.0, q[0]), APART),  # sticks together
        (lambda q, p, v, v0: (math.log(-p), 0.0, 0.0), APART),  # no number
        (lambda q, p, v: q[0] * p, r"expected a function \(parameters, p, v, v0\)"),
        (lambda q, p, v, v0: q[0] * p, r"expected a function \(parameters, p, v, v0\)"),
        (lambda q, p, v, v0: (Path.cwd(), 0.0, 0.0), r"expected a function \(parameters"),
        ("F = K p", r"expected a function \(parameters, p, v, v0\)"),
    ],
)
def test_forces_that_are_none(force, expected):
    with pytest.raises(InputError, match=f"contact law 'mine': force.*{expected}"):
        own_law("mine", force, (1e11, 1e6), MASS)


@pytest.mark.parametrize(
    ("parameters", "mass", "speed", "faults"),
    [
        ((), MASS, 0.3, ["parameters = (): expected one to 4 finite numbers"]),
        ((1.0,) * 5, MASS, 0.3, ["expected one to 4 finite numbers"]),
        ((math.nan,), MASS, 0.3, ["expected one to 4 finite numbers"]),
        ((1e11,), 0.0, -1.0, ["mass = 0.0: expected", "speed = -1.0: expected a number above 0"]),
        ((1e11,), math.inf, 0.3, ["mass = inf: expected a number above 0"]),
    ],
)
def test_numbers_that_are_none(parameters, mass, speed, faults):
    with pytest.raises(InputError) as raised:
        own_law("mine", spring_dashpot, parameters, mass, speed=speed)
    told = str(raised.value)
    assert told.count("\n") == len(faults) - 1 and all(fault in told for fault in faults)


def test_only_rows_without_gaps_are_called():
    compiled = compile_force("spring", spring_dashpot)
    strided = np.zeros(8)[::2]
    with pytest.raises(TypingError, match="_call"):
        law_force(compiled.address, strided, 1e-3, 0.1, 0.3)
