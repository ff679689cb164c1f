"""The section [wave_passage] of a case file."""

import pytest

from impactfem.case import load_case
from impactfem.case.plausibility import implausible

from .faults import all_faults, check_fault
from .sections import BLAST, LOADS, MOTION
from .test_soil import HALF_SPACE

WAVES = """
[wave_passage]
apparent_velocity = "500 m/s"
direction = [0, -2]
"""
AXIS = 'axis = ["23.1 m", "23.41 m"]'  # of B2


def test_delays_are_the_way_along_the_waves(broken):
    """B2 stands 15.61 m beyond B1 along y; waves that go against y reach it first."""
    case = load_case(broken(more=WAVES))
    assert case.delays == pytest.approx({"B1": 15.61 / 500.0, "B2": 0.0})
    oblique = load_case(broken(more=WAVES.replace("[0, -2]", "[3, 4]")))
    assert oblique.delays == pytest.approx({"B1": 0.0, "B2": 0.8 * 15.61 / 500.0})
    assert load_case(broken()).delays == {}


@pytest.mark.parametrize(
    ("edits", "old", "new", "key", "kind"),
    [
        ((), "[0, -2]", "[0, 0]", "direction", "zero"),
        ((), "[0, -2]", "[0, 1, 0]", "direction", "too_long"),
        ((), '"500 m/s"', '"0 m/s"', "apparent_velocity", "greater_than 0"),
        ((), '"500 m/s"', "500", "apparent_velocity", "unit_missing"),
        ((), "direction = [0, -2]\n", "", "direction", "missing"),
        (((None, AXIS, 'axis = ["23.1 m", "7.8 m"]'),), "", "", "", "of_motions"),
        (((None, MOTION, LOADS),), "", "", "", "of_motions"),
    ],
)
def test_refused(broken, edits, old, new, key, kind):
    path = broken(*edits, more=WAVES.replace(old, new) if old else WAVES)
    for name, text in BLAST.items():
        (path.parent / name).write_text(text, encoding="utf-8")
    check_fault(all_faults(path), ".".join(filter(None, ("wave_passage", key))), kind)


@pytest.mark.parametrize(
    ("old", "new", "more", "key", "words"),
    [
        (
            '"500',
            '"50',
            "",
            "apparent_velocity = '50 m/s'",
            "outside the usual range, 500 to 5000 m/s",
        ),
        ('"500', '"360', HALF_SPACE, None, None),
    ],
)
def test_implausible(broken, old, new, more, key, words):
    path = broken(more=more + WAVES.replace(old, new))
    found = [str(one) for one in implausible(load_case(path), 10.0) if "wave_passage" in str(one)]
    assert len(found) == (key is not None)
    assert all(key in line and words in line for line in found)
