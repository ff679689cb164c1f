"""Dotted keys, and whether a case has them."""

import re

import pytest

from impactfem.case.model import CaseFile
from impactfem.case.place import key_fault, read_key

RAW = {
    "damping": {"ratio": "5 %"},
    "materials": {"concrete": {"young_modulus": "30 GPa"}},
    "buildings": [{"name": "A"}, {"name": "B"}],
    "structure": {"mesh": {"type": "generated", "slab_thickness": "25 cm"}},
}


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("title", ("title",)),
        (" damping.ratio ", ("damping", "ratio")),
        ("buildings[0].stiffness_factor", ("buildings", 0, "stiffness_factor")),
        ("a[1][12].b-c", ("a", 1, 12, "b-c")),
    ],
)
def test_a_key(text: str, place: tuple[int | str, ...]) -> None:
    assert read_key(text) == place


@pytest.mark.parametrize("text", ["", ".", "a.", "a..b", "[0]", "a[-1]", "a[x]", "a b", "a[0", "é"])
def test_no_key(text: str) -> None:
    assert read_key(text) is None


@pytest.mark.parametrize(
    "text",
    [
        "damping.ratio",
        "damping.frequencies",  # left to its default
        "materials.concrete.density",
        "buildings[1].stiffness_factor",
        "structure.mesh.slab_thickness",
        "wall_impact",
    ],
)
def test_a_case_has_a_key(text: str) -> None:
    assert key_fault(read_key(text) or (), RAW, CaseFile) is None


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("dampin.ratio", "unknown key; did you mean 'damping'?"),
        ("damping.rato", "unknown key; did you mean 'ratio'?"),
        ("materials.concret.density", "unknown key; did you mean 'concrete'?"),
        ("materials.concrete.densit", "unknown key; did you mean 'density'?"),
        ("structure.mesh.slab", "unknown key; known: type, "),
        ("buildings[2].name", "an index below 2"),
        ("buildings.name", r"an index: buildings\[0\]"),
        ("damping[0].ratio", "no index: damping is no list"),
        ("damping.ratio.x", "no key below damping.ratio"),
        ("wall_impact.gap", "a table or list wall_impact in this case; it has none"),
    ],
)
def test_a_case_lacks_a_key(text: str, expected: str) -> None:
    fault = key_fault(read_key(text) or (), RAW, CaseFile)
    assert fault is not None and re.search(expected, fault)
