"""The patches on which contact forces act are named."""

import pytest

from impactfem.stages.patches import contact_patches

FLOOR = {"building": "A", "floor": 2, "storey": None}
STOREY = {"building": "B", "floor": None, "storey": 3}


@pytest.mark.parametrize(
    ("spread", "of", "models", "expected"),
    [
        ("uniform", ["B"], {}, ["storeys 3"]),
        ("uniform", ["A"], {}, []),
        ("patch", ["A", "B"], {}, ["floors 2", "storeys 3"]),
        ("patch", ["A", "B"], {"A": "structure", "B": "structure"}, []),
    ],
)
def test_patches(spread, of, models, expected):
    structures = [{"building": name} for name in of]
    case = {
        "transient": {"spread": spread, "patch_width": 3.0},
        "structure": structures[0],
        "further_structures": structures[1:],
        "pounding": {"models": models},
        "contacts": [{"a": FLOOR, "b": STOREY}, {"a": FLOOR, "b": None}],
    }
    found = list(contact_patches(case))
    assert len(found) == len(expected)
    for text, words in zip(found, expected, strict=True):
        assert words in text and '3 m"' in text
    assert list(contact_patches(case | {"transient": None})) == []


@pytest.mark.parametrize("depth", [None, 0.25])
def test_depth_of_a_strip(depth):
    """Without one the default is named, with the key that gives another."""
    case = {
        "transient": {"spread": "uniform", "patch_width": 3.0},
        "structure": {"building": "B"},
        "further_structures": [],
        "pounding": {},
        "contacts": [{"a": FLOOR, "b": STOREY, "length": 24.0, "depth": depth}],
    }
    (text,) = contact_patches(case)
    assert ("24 m x 0.25 m" in text) is (depth is not None)
    assert ("slab_depth" in text) is (depth is None)
