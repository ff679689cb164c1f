"""A small store of the stage `calibrate` that no solver made, in the layout of its `store.py`.

Floors go to a wall and away from it at known speeds, under half sines of force.
"""

from dataclasses import dataclass, field

import numpy as np

from impactfem.stages.calibrate.store import OUTPUTS, calibration_scalars
from impactfem.stages.stores import dataset
from impactfem.system.scalar import with_scalars

Hits = dict[int, tuple[tuple[float, float, float], ...]]
WALL_STEP = 0.5e-3
GAP, APPROACH, REBOUND = 0.01, 0.16, 0.1
FLOOR_MASS = 3e6
EDGE = np.array([0.0, 3.0, 6.0, 9.0, 12.0])
MODEL_HITS = {6: (), 7: ((0.2013, 0.014, 300e3),), 8: ((0.2003, 0.016, 800e3),)}
STICK_HITS = {
    6: (),
    7: ((0.2064, 0.012, 310e3),),
    8: ((0.2054, 0.0165, 780e3), (0.4502, 0.016, 37e3)),
}
DAMPINGS = {"own": (0.838, 1.06e-3), "under-damped": (0.838, 2.12e-4), "over-damped": (0.559, 3e-3)}
WALL_NUMBERS = {
    "stick_delay": 5.1e-3,
    "stick_impulse_ratio": 0.975,
    "stick_duration_ratio": 1.03,
    "complementarity": 1e-14,
    "energy_residual": 1e-13,
    "energy_gained": 0.0,
    "penetration": 8e-5,
    "basis_error": 0.003,
    "start_unevenness": 2e-11,
    "second_impulse": 37e3,
}


@dataclass(frozen=True)
class WantedWall:
    """What a store of the stage `calibrate` is to have."""

    #: Start [s], duration [s] and impulse [N s] of each impact of the 3D model, by floor.
    hits: Hits = field(default_factory=lambda: MODEL_HITS)
    stick_hits: Hits = field(default_factory=lambda: STICK_HITS)
    steps: int = 1201
    separation: float = 5e-3  #: shortest time without force between two impacts [s]
    dampings: int = 3  #: number of damping cases
    durations: tuple[float, ...] = (0.016, 0.015, 0.017)  #: of their first impacts [s]
    numerical: float = 0.0  #: what the time stepping takes of the energy [J]
    #: Single results that differ from `WALL_NUMBERS`.
    numbers: dict[str, float] = field(default_factory=dict)
    pull: str = "whole_floor"  #: how the floor was drawn aside


def calibrate_store(asked):
    """The store."""
    time = WALL_STEP * np.arange(asked.steps)
    floors = sorted(asked.hits)
    start, lasts, _ = asked.hits[floors[-1]][0]
    near = (time > start - 5 * WALL_STEP) & (time < start + lasts + 6 * WALL_STEP)
    histories = _histories(time, asked.hits, "") | _histories(time, asked.stick_hits, "stick_")
    length = np.array([1.5, 3.0, 3.0, 3.0, 1.5])
    kinetic = 60e3 * np.sin(10.0 * time) ** 2
    damped, contact = 50e3 * time, -8e3 * (time > start)
    numerical = asked.numerical * time / time[-1]
    names = list(DAMPINGS)[: asked.dampings]
    by_case = {
        "mass_coefficient": [DAMPINGS[name][0] for name in names],
        "stiffness_coefficient": [DAMPINGS[name][1] for name in names],
        "epsilon": [2.0 / 3.0, 0.9, 0.4],
        "xi_c": [0.128, 0.03, 0.28],
        "K_Ceq": [1.2e11, 1.1e11, 1.3e11],
        "impact_time": [start] * 3,
        "impact_duration": asked.durations,
        "impulse": [800e3, 912e3, 672e3],
        "approach_velocity": [APPROACH] * 3,
    }
    numbers = WALL_NUMBERS | asked.numbers
    residual = numbers.pop("complementarity")
    values = {
        **histories,
        "time": time,
        "step": time[near],
        "floor": floors,
        "case": names,
        "floor_mass": np.full(len(floors), FLOOR_MASS),
        "kinetic_energy": kinetic,
        "elastic_energy": 170e3 - kinetic - damped - numerical + contact,
        "damped_energy": damped,
        "numerical_energy": numerical,
        "contact_work": contact,
        "complementarity": np.full(len(time), residual),
        "impacts": [len(asked.hits[floor]) for floor in floors],
        **numbers,
        "constraint_floor": np.repeat(floors, len(EDGE)),
        "constraint_position": np.tile(EDGE, len(floors)),
        "constraint_length": np.tile(length, len(floors)),
        "constraint_force": np.kron(histories["force"][near], length / EDGE[-1]),
        **{name: values[: len(names)] for name, values in by_case.items()},
    }
    attributes = {
        "building": "one",
        "side": "y+",
        "gap": GAP,
        "separation": asked.separation,
        "stick_contact_update": "implicit",
        "displaced_floor": 8,
        "displacement_at_start": -0.02,
        "pull": asked.pull,
        "unilateral_scheme": "moreau",
    }
    store = dataset(OUTPUTS, values, attributes=attributes)
    return with_scalars(store, calibration_scalars(store))


def _histories(time, hits, prefix):
    columns = zip(*(_at_wall(time, hits[floor]) for floor in sorted(hits)), strict=True)
    names = ("displacement", "velocity", "force", "opening")
    return {f"{prefix}{n}": np.column_stack(of) for n, of in zip(names, columns, strict=True)}


def _at_wall(time, hits):
    """Straight to the wall, at rest while the force acts, straight away from it, and so on."""
    force = np.zeros_like(time)
    if not hits:
        distance = np.full_like(time, 1e-3)
        return GAP - distance, np.zeros_like(time), force, distance
    distance, velocity = np.zeros_like(time), np.zeros_like(time)
    end = -np.inf
    for start, lasts, impulse in hits:
        middle = 0.5 * (end + start)
        leaves, comes = (time > end) & (time < middle), (time >= middle) & (time < start)
        rebound = APPROACH if np.isfinite(end) else 0.0
        distance[leaves], velocity[leaves] = rebound * (time[leaves] - end), -rebound
        distance[comes], velocity[comes] = APPROACH * (start - time[comes]), APPROACH
        end = start + lasts
        inside = (time > start) & (time < end)
        amplitude = 0.5 * np.pi * impulse / lasts
        force[inside] = amplitude * np.sin(np.pi * (time[inside] - start) / lasts)
    after = time >= end
    distance[after], velocity[after] = REBOUND * (time[after] - end), -REBOUND
    return GAP - distance, velocity, force, distance
