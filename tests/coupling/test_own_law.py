"""User-defined laws: laws of the program written again, with a closed form, with memory, faulty."""

import math
import pickle
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import xarray as xr
from numba.core.errors import TypingError

from impactfem.case.base import Section
from impactfem.case.load import section_adapter
from impactfem.case.model import Case, CaseFile
from impactfem.case.quantity import HertzStiffness
from impactfem.coupling import restitution as relations
from impactfem.coupling.from_case import system_of
from impactfem.coupling.impacts import impacts
from impactfem.coupling.law import LAWS, Law, effective_mass
from impactfem.coupling.law_function import law_force
from impactfem.coupling.laws import Hertz, HertzDamp, Jankowski, KelvinVoigt
from impactfem.coupling.pounding import simulate
from impactfem.stages.pounding.compute import run_sticks
from impactfem.stages.pounding.store import write_sticks
from impactfem.system.errors import InputError
from impactfem.verify.contact import collision

M1, M2 = 1574e3, 3014e3
MASS = effective_mass(M1, M2)
SPEED = 0.3
BETA = 1.4e12


@dataclass(frozen=True)
class SpringDashpot(Law):
    """F = K p + C v."""

    jumps = True
    per_area = ("stiffness", "c")

    c: float = 0.0

    @staticmethod
    def force(q, p, v, state):
        return q[0] * p + q[1] * v, q[0], q[1]


@dataclass(frozen=True)
class SoftStart(Law):
    """F = K p (1 + χ v / v₀): the relation of `exact_chi` holds for any power of p."""

    chi: float

    @staticmethod
    def force(q, p, v, state):
        K, chi = q
        v0 = state[0]
        factor = 1.0 + chi * v / v0
        return K * p * factor, K * factor, K * p * chi / v0


@dataclass(frozen=True)
class Again(Law):
    """A damped law of Hertz with one loop more."""

    chi: float
    slowest: float

    @staticmethod
    def force(q, p, v, state):
        elastic = q[0] * p * math.sqrt(p)
        factor = 1.0 + q[1] * v / max(state[0], q[2])
        if factor <= 0.0:
            return 0.0, 0.0, 0.0
        slope = elastic * q[1] / max(state[0], q[2])
        return elastic * factor, 1.5 * q[0] * p**0.5 * factor, slope


@dataclass(frozen=True)
class Approaching(Law):
    """Jankowski's law: its slope has a kink at rest."""

    c: float

    @staticmethod
    def force(q, p, v, state):
        elastic, slope = q[0] * p**1.5, 1.5 * q[0] * p**0.5
        if v <= 0.0:
            return elastic, slope, 0.0
        root = p**0.25
        return elastic + q[1] * root * v, slope + 0.25 * q[1] * root / p * v, q[1] * root


@dataclass(frozen=True)
class Crushing(Law):
    """Loading with K, unloading and reloading with K₂ > K from the largest penetration.

    Closed form: the energy K p_max²/2 is stored, K² p_max²/(2 K₂) returned, so that ε = √(K/K₂).
    """

    type = "test-crushing"
    n_state = 1

    unloading: float

    @staticmethod
    def force(q, p, v, state):
        K, K_2, largest = q[0], q[1], state[1]
        if p >= largest:
            return K * p, K, 0.0
        F = K * largest - K_2 * (largest - p)
        return (F, K_2, 0.0) if F > 0.0 else (0.0, 0.0, 0.0)

    @staticmethod
    def advance(q, p, v, state):
        state[1] = 0.0 if p <= 0.0 else max(state[1], p)


def under(law, other):
    """The same collision under another law."""
    system = other.system.with_laws(lambda pair: law)
    return simulate(system, other.ground, other.time_step, v0=other.v[0])


@pytest.mark.parametrize(
    ("known", "make"),
    [
        (KelvinVoigt(1e11, 0.12, mass=MASS), SpringDashpot),
        (HertzDamp(BETA, 0.5, "exact", mass=MASS), Again),
        (Jankowski(BETA, 0.5, mass=MASS), Approaching),
    ],
)
@pytest.mark.parametrize("steps", [7.3, 50.3])
def test_a_law_of_the_program_written_again(known, make, steps):
    count = 3 if make is Again else 2
    law = make(*known.parameters[:count], mass=MASS)
    law.check()
    assert law.epsilon == pytest.approx(known.epsilon, rel=1e-7)
    assert law.onset_force(SPEED) == pytest.approx(known.onset_force(SPEED), abs=1e-3)
    response = collision(known, M1, M2, SPEED, known.duration(SPEED) / steps, phase=0.4)
    again = under(law, response)
    assert np.abs(response.force).max() > 0.0
    assert again.force == pytest.approx(response.force, rel=1e-9, abs=1e-9 * response.force.max())
    # Another law gives another force.
    other = under(SoftStart(2e10, 0.1, mass=MASS), response)
    assert np.abs(other.force - response.force).max() > 0.1 * response.force.max()


@pytest.mark.parametrize("epsilon", [0.2, 0.5, 0.687, 0.95])
def test_restitution_by_the_closed_form(epsilon):
    law = SoftStart(1e11, relations.exact_chi(epsilon), mass=MASS)
    assert law.epsilon == pytest.approx(epsilon, rel=1e-8)
    assert law.restitution_at(0.01) == pytest.approx(epsilon, rel=1e-8)  # at any speed
    dt = law.duration(SPEED) / 300.3
    (impact,) = impacts(collision(law, M1, M2, SPEED, dt, phase=0.4))
    assert impact.restitution == pytest.approx(epsilon, abs=5e-4)
    assert impact.duration == pytest.approx(law.duration(SPEED), rel=1e-3)
    wrong = replace(law, chi=0.9 * law.chi)
    assert abs(wrong.epsilon - epsilon) > 2e-3


@pytest.mark.parametrize("ratio", [1.0, 2.0, 6.0])
def test_a_law_with_memory(ratio):
    """Restitution, energy and a second contact that knows nothing of the first."""
    law = Crushing(1e11, ratio * 1e11, mass=MASS)
    law.check()
    expected = math.sqrt(1.0 / ratio)
    assert law.epsilon == pytest.approx(expected, rel=1e-4)
    dt = 2.0 * math.pi * math.sqrt(MASS / 1e11) / 2000.0
    (impact,) = impacts(collision(law, M1, M2, SPEED, dt, phase=0.4))
    assert impact.restitution == pytest.approx(expected, abs=2e-3)
    assert impact.penetration == pytest.approx(SPEED * math.sqrt(MASS / 1e11), rel=1e-4)
    assert impact.dissipated == pytest.approx(
        0.5 * MASS * SPEED**2 * (1.0 - expected**2), abs=2e-3 * MASS * SPEED**2
    )
    assert abs(impact.defect) < 2e-3 * MASS * SPEED**2
    phase = np.linspace(-0.1 * np.pi, 1.1 * np.pi, 401)
    gap, rate = -0.01 * np.sin(phase), -np.cos(phase)
    once = law.dissipated(gap, rate)
    twice = law.dissipated(np.tile(gap, 2), np.tile(rate, 2))
    assert twice == pytest.approx(2.0 * once, abs=1.0)
    assert once == pytest.approx(5e6 * (1.0 - 1.0 / ratio), abs=5e3)


@pytest.fixture
def open_case():
    """Take the keys of further laws out of the case file again."""
    before = {model: model.model_fields["contact_laws"].annotation for model in (CaseFile, Case)}
    yield
    for model, annotation in before.items():
        model.model_fields["contact_laws"].annotation = annotation
        model.model_rebuild(force=True)
    section_adapter.cache_clear()
    LAWS.pop("test-soft")


@pytest.mark.usefixtures("open_case")
def test_a_law_of_its_own_in_the_case_file(small_case):
    @dataclass(frozen=True)
    class Soft(SoftStart):
        type = "test-soft"

        class Keys(Section):
            type: Literal["test-soft"]
            stiffness: HertzStiffness
            chi: float

    edits = (
        (
            'type = "kelvin-voigt"\nstiffness = "1.2e10 N/m"',
            'type = "test-soft"\nchi = 0.2\nstiffness = "2e10 N/m^1.5"',
        ),
        ("restitution = 0.65", "# "),
    )
    pair = system_of(small_case(*edits), None).pairs[0]
    assert pair.law == Soft(2e10, 0.2, mass=pair.law.mass)


def test_an_elastic_one_lasts_half_a_period():
    law = SpringDashpot(1e11, mass=MASS)
    assert (law.epsilon, law.target_restitution) == pytest.approx((1.0, 1.0), rel=1e-8)
    assert law.duration(SPEED) == pytest.approx(math.pi * math.sqrt(MASS / 1e11), rel=1e-8)
    assert law.duration(0.0) == math.inf
    elastic = Again(BETA, 0.0, 1e-3, mass=MASS)
    assert elastic.duration(SPEED) == pytest.approx(Hertz(BETA, mass=MASS).duration(SPEED), 1e-5)
    assert elastic.duration(0.1) > elastic.duration(0.4)


def test_what_a_law_has():
    law = SpringDashpot(2e9, 1e5, mass=3e5)
    assert math.isnan(law.xi) and math.isnan(law.dashpot)
    assert (law.stiffness, law.mass, law.parameters) == (2e9, 3e5, (2e9, 1e5))
    assert law.part(0.5) == SpringDashpot(1e9, 5e4, mass=1.5e5)
    assert pickle.loads(pickle.dumps(law)) == law
    assert LAWS["test-crushing"] is Crushing and SpringDashpot not in LAWS.values()


def test_the_stage_and_its_store(study, tmp_path):
    again = study.system.with_laws(
        lambda pair: SpringDashpot(*pair.law.parameters[:2], mass=pair.law.mass)
    )
    results = run_sticks(study.case, ready=(study.calibration, again))
    assert results.main_impact.peak_force == pytest.approx(study.main_impact.peak_force, rel=1e-6)
    assert results.floors.pfa == pytest.approx(study.floors.pfa, rel=1e-6)
    assert results.steps_per_impact_min == pytest.approx(study.steps_per_impact_min, rel=1e-6)
    write_sticks(tmp_path / "pounding.nc", results, "")
    with xr.open_dataset(tmp_path / "pounding.nc", engine="netcdf4") as store:
        assert set(store.pair_stiffness_unit.values) == {"N/m"}
        expected = [pair.law.epsilon for pair in study.system.pairs]
        assert store.pair_restitution.values == pytest.approx(expected, rel=1e-6)
        assert np.isnan(store.pair_dashpot).all()
    mixed = study.system.with_laws(
        lambda pair: pair.law if pair.a.floor == 1 else Hertz(BETA, mass=pair.law.mass)
    )
    write_sticks(tmp_path / "mixed.nc", run_sticks(study.case, ready=(None, mixed)), "")
    with xr.open_dataset(tmp_path / "mixed.nc", engine="netcdf4") as store:
        assert store.pair_stiffness.attrs["units"] == "N/m, N/m^1.5"


def test_a_function_is_compiled_once():
    laws = [SpringDashpot(K, mass=MASS) for K in (1e10, 2e10)]
    assert laws[0].addresses == laws[1].addresses
    assert laws[0].addresses[0] > 1000 and laws[0].addresses[1] == 0


def falls(q, p, v, state):
    K, v0 = q[0], state[0]
    return K * p - 0.1 * K * p * v / v0, K - 0.1 * K * v / v0, -0.1 * K * p / v0


@pytest.mark.parametrize(
    ("force", "expected"),
    [
        (falls, "F falls with v"),
        (lambda q, p, v, s: (q[0] * p, 2.0 * q[0], 0.0), r"dF/dp = 2e\+11"),
        (lambda q, p, v, s: (q[0] * p + q[1] * v, q[0], 0.0), "dF/dv = 0"),
        (lambda q, p, v, s: (0.0, 0.0, 0.0), "separates"),
        (lambda q, p, v, s: (q[0] * v, 0.0, q[0]), "separates"),  # the masses stick together
        (lambda q, p, v, s: (math.log(-p), 0.0, 0.0), "separates"),  # no number
        (lambda q, p, v: q[0] * p, r"\(parameters, p, v, state\)"),
        (lambda q, p, v, s: q[0] * p, r"\(parameters, p, v, state\)"),
        (lambda q, p, v, s: (Path.cwd(), 0.0, 0.0), r"\(parameters, p, v, state\)"),
        ("F = K p", r"\(parameters, p, v, state\)"),
    ],
)
def test_faulty_forces(force, expected):
    @dataclass(frozen=True)
    class Faulty(SpringDashpot):
        pass

    Faulty.force = staticmethod(force) if callable(force) else force
    with pytest.raises(InputError, match=expected):
        Faulty(1e11, 1e6, mass=MASS).check()


@pytest.mark.parametrize(
    ("law", "speed", "keys"),
    [
        (SpringDashpot(math.nan, mass=MASS), 0.3, ["parameters"]),
        (SpringDashpot(1e11, mass=0.0), -1.0, ["mass", "speed"]),
        (SpringDashpot(1e11, mass=math.inf), 0.3, ["mass"]),
    ],
)
def test_faulty_numbers(law, speed, keys):
    with pytest.raises(InputError) as raised:
        law.check(speed)
    assert [fault.key for fault in raised.value.faults] == keys


def test_only_rows_without_gaps_are_called():
    address, state = SpringDashpot(1.0, mass=1.0).addresses[0], np.zeros(1)
    with pytest.raises(TypingError, match="call"):
        law_force(address, np.zeros(8)[::2], 1e-3, 0.1, state)
