"""Tables of the stage `calibrate`: the paper's values beside ours, impacts, damping cases."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from impactfem.plot.table import Cell, Table, beside_published
from impactfem.stages.calibrate.impact import FloorImpacts
from impactfem.stages.calibrate.view import WallView
from impactfem.stages.stores import open_store
from impactfem.system.log import LOGGER

PRINTED = "printed"
"""End of the names of published restitutions in the order in which the paper prints them."""


def wall_tables(folder: Path, published: Mapping[str, float]) -> list[Path]:
    """Write the tables of the stage into `tables/` and into the log.

    Args:
        folder: The run's folder, with `calibrate.nc`.
        published: Published values in SI by the name of the result.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    with open_store(folder / "calibrate.nc") as store:
        view = WallView(store)
        tables = [_values(view, published), _impacts(view), _dampings(view, published)]
    target = folder / "tables"
    target.mkdir(exist_ok=True)
    for table in tables:
        LOGGER.debug("\n%s", table.as_text())
    return [table.write_csv(target) for table in tables]


def _values(view: WallView, published: Mapping[str, float]) -> Table:
    """Figures 6 and 7 and table 5 of the paper: the stage's scalars, published ones first."""
    shown = sorted(view.scalars, key=lambda scalar: scalar.name not in published)
    title = f"Impact of building {view.building} on a rigid wall"
    return beside_published("wall_calibration", title, shown, published)


def _impacts(view: WallView) -> Table:
    """All impacts by floor; a floor without one has a row that says how near it came.

    The impulse is the largest on its way and that at the end, the peak that of the force; `over`
    says whether the impact ends in the window.
    """
    rows = [
        row
        for kind, found in (("3D", view.model_impacts), ("stick", view.stick_impacts))
        for floor in reversed(found)
        for row in _of_floor(view, kind, floor)
    ]
    return Table(
        "wall_impacts",
        f"Impacts of the floors of building {view.building} on the rigid wall, 3D and stick; "
        "epsilon by the largest impulse, negative where the impulse is below the momentum",
        (
            ("model", ""),
            ("floor", ""),
            ("impact", ""),
            ("start", "s"),
            ("duration", "ms"),
            ("impulse", "kN s"),
            ("at end", "kN s"),
            ("peak", "MN"),
            ("approach", "m/s"),
            ("rebound", "m/s"),
            ("epsilon", "-"),
            ("pulses", ""),
            ("steps", ""),
            ("over", ""),
            ("nearest", "mm"),
        ),
        tuple(rows),
    )


def _of_floor(view: WallView, kind: str, found: FloorImpacts) -> list[tuple[Cell, ...]]:
    closest = 1e3 * found.closest
    if not found.impacts:
        return [(kind, found.floor, 0, *[None] * 11, closest)]
    return [
        (
            kind,
            found.floor,
            number,
            one.start,
            1e3 * one.duration,
            1e-3 * one.largest_impulse,
            1e-3 * one.impulse,
            1e-6 * one.peak_force,
            one.approach,
            one.rebound,
            one.epsilon if np.isfinite(one.epsilon) else None,
            one.pulses,
            one.duration / view.time_step,
            "yes" if one.complete else "no",
            closest,
        )
        for number, one in enumerate(found.impacts, start=1)
    ]


def _dampings(view: WallView, published: Mapping[str, float]) -> Table:
    """Table 8 of the paper, whose restitutions are printed in one order and described in the other.

    The text says that ε grows as damping falls; the printed row falls with it.
    """
    store = view.store
    frequency = view.half_wave
    ratio = view.damping_ratios(frequency)
    rows: list[tuple[Cell, ...]] = []
    for k, case in enumerate(view.cases):
        name = f"calibration.epsilon.{case}" if k else "calibration.epsilon"
        described = published.get(name)
        # The middle one is the building's own, and the same in both orders.
        printed = published.get(f"{name}.{PRINTED}") if k else described
        rows.append(
            (
                case,
                float(store["mass_coefficient"].values[k]),
                float(store["stiffness_coefficient"].values[k]),
                100.0 * float(ratio[k]),
                float(store["epsilon"].values[k]),
                described,
                printed,
                float(store["xi_c"].values[k]),
                float(store["K_Ceq"].values[k]),
                float(store["impact_time"].values[k]),
                1e3 * float(store["impact_duration"].values[k]),
                1e-3 * float(store["impulse"].values[k]),
                float(store["approach_velocity"].values[k]),
            )
        )
    return Table(
        "wall_damping",
        f"First impact of floor {view.top} of building {view.building} on the rigid wall by the "
        "Rayleigh damping of the building",
        (
            ("damping", ""),
            ("alpha", "1/s"),
            ("beta", "s"),
            (f"xi at {frequency:.3g} Hz", "%"),
            ("epsilon", "-"),
            ("by the text", "-"),
            ("as printed", "-"),
            ("xi_c", "-"),
            ("K_Ceq", "N/m"),
            ("start", "s"),
            ("duration", "ms"),
            ("impulse", "kN s"),
            ("approach", "m/s"),
        ),
        tuple(rows),
    ).comparing(
        {"by the text", "as printed"},
        "; beside the published values in the order that the text describes and as printed",
    )
