"""The buildings of a run and their models."""

import re
from collections.abc import Mapping
from typing import Any

from impactfem.report.facts import Facts, table
from impactfem.report.run_files import RunFiles

BENDING = r"building\.frequency\.(\d+)"
"""Names of the frequencies of the modes of a 3D model that bend."""


def in_3d(case: Mapping[str, Any]) -> set[str]:
    """Names of the buildings whose 3D models pound."""
    return {name for name, model in case["pounding"]["models"].items() if model == "structure"}


def wall_is_used(case: Mapping[str, Any]) -> bool:
    """Whether a contact law of a case takes a value from the impact on the rigid wall."""
    laws = case["contact_laws"].values()
    return any("calibrated" in (law.get("stiffness"), law.get("restitution")) for law in laws)


def at_wall(run: RunFiles) -> float | None:
    """The restitution of the building that hits the rigid wall; None without one."""
    found = (one.values.get("calibration.epsilon") for one in run.models.values())
    return next((value for value in found if value is not None), None)


def buildings(run: RunFiles) -> Facts:
    """The buildings of the case and their models."""
    rows = []
    models, pounding = run.models, in_3d(run.case)
    for building in run.case["buildings"]:
        name, floors = building["name"], building["floors"]
        mass, height = (sum(floor[key] for floor in floors) for key in ("mass", "storey_height"))
        # Of the model that pounds.
        known = _modes(models[name], BENDING) if name in pounding else ""
        modes = known or _modes(run, rf"sticks\.{re.escape(name)}\.frequency\.(\d+)")
        if name in pounding:
            model = "3D model, which pounds"
        else:
            model = "stick and 3D model" if name in models else "stick"
        rows.append((name, len(floors), 1e-3 * mass, height, modes or "not computed", model))
    clamped = ", clamped" if any(one.get("soil") for one in run.case["buildings"]) else ""
    columns = (
        "building {}; floors {}; mass of floors [t] {:,.0f}; height [m] {:.2f}; "
        f"first bending modes{clamped} [Hz] {{}}; model {{}}"
    )
    notes = [
        f"3D model of {name}: {one.values['building.elements']:,.0f} shells and beams, "
        f"{one.values['building.dofs']:,.0f} degrees of freedom; modes that bend at "
        f"{_modes(one, BENDING)} Hz."
        for name, one in models.items()
        if "building.dofs" in one.values
    ]
    return table("The buildings", columns, rows, " ".join(notes))


def _modes(run: RunFiles, pattern: str) -> str:
    """The first three frequencies [Hz] whose names match."""
    return ", ".join(f"{f:.2f}" for f in list(_series(run.values, pattern).values())[:3])


def _series(values: dict[str, Any], pattern: str) -> dict[int, float]:
    """Values whose names end in a number, by that number and in its order."""
    found = {int(m[1]): v for name, v in values.items() if (m := re.fullmatch(pattern, name))}
    return dict(sorted(found.items()))
