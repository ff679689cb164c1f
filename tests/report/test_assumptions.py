"""What the report says is assumed."""

from __future__ import annotations

from typing import Any

import pytest

from impactfem.report.page import assumptions

GIVEN = {"type": "kelvin-voigt", "stiffness": 1e11, "restitution": None, "damping_ratio": 0.12}


def texts(laws: dict[str, dict[str, Any]], *, wall: bool = True) -> str:
    case = {
        "structure": {"building": "B1"},
        "wall_impact": {"floors": [8]} if wall else None,
        "transient": None,
        "devices": [],
        "contact_laws": laws,
        "report": {"assumptions": [], "reference": None},
    }
    return "\n".join(one["text"] for _, group in assumptions(case) for one in group)


@pytest.mark.parametrize("key", ["stiffness", "restitution"])
def test_a_law_takes_values_from_the_wall(key: str) -> None:
    found = texts({"beam": GIVEN, "floor": GIVEN | {key: "calibrated"}})
    assert "Restitution and contact stiffness come from one impact of the 3D model" in found
    assert "are not used" not in found


def test_the_laws_have_their_own_values() -> None:
    found = texts({"floor": GIVEN, "corner": {"type": "hertz", "stiffness": 3e11}})
    assert "those of the impact on a rigid wall are not used" in found
    assert "come from one impact" not in found


def test_no_wall() -> None:
    assert "rigid wall" not in texts({"floor": GIVEN}, wall=False)
