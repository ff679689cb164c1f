"""What step, contact stiffness and contact law do to the paper's case (docs/contact-study.md).

    python geometry/contact_study.py

The motion and the sticks stay; each row changes one thing.
"""

from pathlib import Path

import numpy as np

from impactfem.case import Case, load_case
from impactfem.coupling import contact
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.pounding import System
from impactfem.coupling.restitution import kelvin_voigt
from impactfem.plot.table import Cell, Table
from impactfem.stages.pounding.compute import run_sticks
from impactfem.stages.pounding.scalars import stick_scalars

STEPS = (1.3432, 0.6716, 0.3358, 0.1679, 0.08395)  # ms
STIFFNESSES = (1e10, 3e10, 1e11, 3e11, 1e12)  # N/m
APPROACH = 0.36  # m/s: the main impact's, where the Hertz laws are as soft as Kelvin-Voigt
XI = 0.12
SHOWN = (
    ("pounding.peak_force.floor_8", "peak force", "MN", 1e-6),
    ("pounding.main_impact_impulse", "impulse", "kN s", 1e-3),
    ("pounding.main_impact_duration", "duration", "ms", 1e3),
    ("pounding.main_impact_restitution", "restitution", "-", 1.0),
    ("pounding.peak_displacement.B1", "top B1", "cm", 1e2),
    ("pounding.peak_displacement.B2", "top B2", "cm", 1e2),
    ("frs.floor_8.pfa", "PFA floor 8", "m/s2", 1.0),
    ("frs.floor_8.peak", "FRS peak", "m/s2", 1.0),
    ("pounding.steps_per_impact_min", "steps", "-", 1.0),
)


def main() -> None:
    """Print one table for each of step, stiffness and law."""
    case = load_case(Path(__file__).with_name("npp_pair.toml"))
    system = system_of(case, calibration_of(case))
    steps = [
        (f"{step:g} ms, {update}", _stepped(case, step, update), system)
        for update in ("implicit", "lagged")
        for step in STEPS
    ]
    stiffness = [
        (f"{K:g} N/m", case, _with_law(system, lambda m, K=K: contact.kelvin_voigt(K, XI, m)))
        for K in STIFFNESSES
    ]
    epsilon = kelvin_voigt(XI)
    makers = {
        "kelvin-voigt, tension": lambda m: contact.kelvin_voigt(1e11, XI, m),
        "kelvin-voigt, no tension": lambda m: contact.kelvin_voigt(1e11, XI, m, tension=False),
        "hertz": lambda m: contact.hertz(_hertz(m), m),
        "hertz-damp, exact": lambda m: contact.hertz_damp(_hertz(m), epsilon, m, exact=True),
        "jankowski, exact": lambda m: contact.jankowski(_hertz(m), epsilon, m, exact=True),
    }
    laws = [(name, case, _with_law(system, make)) for name, make in makers.items()]
    for title, rows in (("step", steps), ("stiffness", stiffness), ("law", laws)):
        table = Table(
            title,
            f"What the {title} does",
            ((title, ""), *((name, unit) for _, name, unit, _ in SHOWN)),
            tuple(_row(name, one, changed) for name, one, changed in rows),
        )
        print(table.as_text(), "\n")


def _row(name: str, case: Case, system: System) -> tuple[Cell, ...]:
    study = run_sticks(case, ready=(None, system), buildings=1)
    found = {scalar.name: scalar.value for scalar in stick_scalars(study)}
    cells: list[Cell] = [name]
    for key, _, _, factor in SHOWN:
        value = found.get(key)
        cells.append(None if value is None else factor * value)
    return tuple(cells)


def _stepped(case: Case, step: float, update: str) -> Case:
    changed = case.pounding.model_copy(update={"time_step": 1e-3 * step, "update": update})
    return case.model_copy(update={"pounding": changed})


def _with_law(system: System, make) -> System:
    return system.with_laws(lambda pair: make(pair.law.mass))


def _hertz(mass: float) -> float:
    """Stiffness with the largest elastic penetration of 1e11 N/m at the approach speed."""
    penetration = APPROACH * np.sqrt(mass / 1e11)
    return float(1.25 * 1e11 / np.sqrt(penetration))


if __name__ == "__main__":
    main()
