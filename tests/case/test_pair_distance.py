"""Distance of the points of a contact by axis and offset."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.contact_checks import pair_distance
from impactfem.system.errors import InputError

AXES = 'axis = ["23.1 m", "7.8 m"]', 'axis = ["23.1 m", "23.41 m"]'
NORMAL = "normal = [0, 1, 0]"
Broken = Callable[..., Path]


@pytest.mark.parametrize(
    ("edits", "distance"),
    [
        ([], 0.01),
        ([(None, AXES[1], 'axis = ["23.1 m", "24.4 m"]')], 1.0),
        # Within what counts as rounding, to either side.
        ([(None, AXES[1], 'axis = ["23.1 m", "23.3995 m"]')], -0.0005),
        # 45 degrees: the same points are nearer along it.
        ([(None, NORMAL, "normal = [1, 1, 0]")], 0.01 / math.sqrt(2.0)),
        # No plan, and a normal along which heights count, too.
        ([(None, AXES[1], AXES[0])], math.nan),
        ([(None, NORMAL, "normal = [0, 1, 0.01]")], math.nan),
    ],
)
def test_distance(broken: Broken, edits: list[tuple[None, str, str]], distance: float) -> None:
    case = load_case(broken(*edits))
    found = [pair_distance(contact, case) for contact in case.contacts]
    assert found == pytest.approx([distance] * 8, abs=1e-12, nan_ok=True)


def test_a_normal_from_b_to_a_is_refused(broken: Broken) -> None:
    path = broken((None, NORMAL, "normal = [0, -1, 0]"))
    text = (
        r"contacts\[0\].normal = \[0.*-1.*\]: expected the direction from a to b: by axis and "
        r"offset the points of B1.floor_1-B2.floor_1 are -0.01 m apart along it, and the gap is "
        r"0.01 m"
    )
    with pytest.raises(InputError, match=text) as caught:
        load_case(path)
    assert len(caught.value.faults) == 1


def test_buildings_in_one_another_are_refused(broken: Broken) -> None:
    path = broken((None, AXES[1], 'axis = ["23.1 m", "22.4 m"]'))
    text = (
        r"contacts\[0\]: expected buildings that stand side by side: by axis and offset the "
        r"points of B1.floor_1-B2.floor_1 are -1 m apart along the normal, and the gap is 0.01 m; "
        r"see axis of \[\[buildings\]\], B1 \(23.1 m, 7.8 m\) and B2 \(23.1 m, 22.4 m\), and "
        r"the offsets"
    )
    with pytest.raises(InputError, match=text) as caught:
        load_case(path)
    assert len(caught.value.faults) == 1
