"""Models made from Python: derived values and their checks."""

import math
from dataclasses import astuple

import numpy as np
import pytest
from pydantic import ValidationError

from impactfem.case import (
    Damping,
    FrequencyGrid,
)
from impactfem.case.contacts import ContactEntry, expand


def test_rayleigh_coefficients_of_the_paper() -> None:
    α_R, β_R = astuple(Damping(ratio=0.07, frequencies=(1.0, 20.0)).rayleigh)
    assert α_R == pytest.approx(0.8378, abs=5e-5)  # section 3.2.2
    assert β_R == pytest.approx(1.06e-3, abs=5e-6)  # Table 8


@pytest.mark.parametrize(("ξ", "f1", "f2"), [(0.07, 1.0, 20.0), (0.02, 30.0, 80.0)])
def test_rayleigh_damping_reaches_its_ratio(ξ: float, f1: float, f2: float) -> None:
    α_R, β_R = astuple(Damping(ratio=ξ, frequencies=(f1, f2)).rayleigh)

    def ratio(f: float) -> float:
        ω = 2.0 * math.pi * f
        return (α_R / ω + β_R * ω) / 2.0

    damping = Damping(mass_coefficient=α_R, stiffness_coefficient=β_R)
    for f in (f1, f2, 450.0):
        assert damping.rayleigh.ratio(f) == pytest.approx(ratio(f), rel=1e-14)
    assert ratio(f1) == pytest.approx(ξ, rel=1e-14)
    assert ratio(f2) == pytest.approx(ξ, rel=1e-14)
    assert ratio(math.sqrt(f1 * f2)) < 0.99 * ξ


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "expected ratio and frequencies, or mass_coefficient and"),
        ({"ratio": 0.05}, "expected ratio and frequencies together"),
        ({"frequencies": (1.0, 2.0)}, "expected ratio and frequencies together"),
        ({"ratio": 0.05, "frequencies": (2.0, 1.0)}, "the lower one first"),
        ({"mass_coefficient": 1.0}, "mass_coefficient and stiffness_coefficient together"),
        (
            {"ratio": 0.05, "frequencies": (1.0, 2.0), "mass_coefficient": 1.0},
            "not both",
        ),
    ],
)
def test_damping_refused(values: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Damping.model_validate(values)


def test_grid_is_logarithmic_with_its_ends() -> None:
    grid = FrequencyGrid(minimum=0.5, maximum=500.0, per_decade=100)
    assert len(grid.values) == 301
    np.testing.assert_allclose(grid.values, np.geomspace(0.5, 500.0, 301), rtol=1e-13)
    assert (grid.values[0], grid.values[-1]) == (0.5, 500.0)


def test_grid_has_at_least_the_density_asked() -> None:
    values = FrequencyGrid(minimum=1.0, maximum=15.0, per_decade=10).values
    ratios = np.diff(np.log10(values))
    assert ratios.max() <= 0.1 + 1e-12
    assert len(FrequencyGrid(minimum=1.0, maximum=1.1, per_decade=1).values) == 2


def entry(a: dict[str, object], b: dict[str, object], **more: object) -> ContactEntry:
    values = {"normal": (0, 3, 4), "gap": 0.01, "law": "floor"} | more
    return ContactEntry.model_validate(
        {"a": {"building": "B1"} | a, "b": {"building": "B2"} | b} | values
    )


def test_contacts_expand_to_pairs() -> None:
    first = entry({"floor": [7, 8]}, {"floor": [6, 7]}, bearing_area=2.0)
    second = entry({"floor": 8}, {"storey": 7, "relative_height": 0.5, "offset": (1, 2, 3)})
    contacts = expand((first, second))
    assert [contact.name for contact in contacts] == [
        "B1.floor_7-B2.floor_6",
        "B1.floor_8-B2.floor_7",
        "B1.floor_8-B2.storey_7_at_0.5",
    ]
    assert contacts[0].normal == pytest.approx((0.0, 0.6, 0.8))
    assert (contacts[0].bearing_area, contacts[2].bearing_area) == (2.0, None)
    assert contacts[2].b.offset == (1.0, 2.0, 3.0)
    assert (contacts[2].b.floor, contacts[2].b.storey) == (None, 7)


def test_contacts_of_the_same_floors_have_names_of_their_own() -> None:
    corners = [entry({"floor": 8, "offset": (x, 0, 0)}, {"floor": 8}) for x in (-1, 1, 2)]
    names = [contact.name for contact in expand(tuple(corners))]
    assert names == [
        "B1.floor_8-B2.floor_8",
        "B1.floor_8-B2.floor_8#2",
        "B1.floor_8-B2.floor_8#3",
    ]


@pytest.mark.parametrize("length", [1e-200, 1.0, 1e200])
def test_normal_is_normalised(length: float) -> None:
    contact = entry({"floor": 1}, {"floor": 1}, normal=(0, -length, 0))
    assert contact.normal == (0.0, -1.0, 0.0)


@pytest.mark.parametrize(
    ("a", "b", "message"),
    [
        ({"floor": [1, 2]}, {"floor": 1}, "lists of the same length in a and b, found 2 and 1"),
        ({"floor": 1}, {"floor": 1, "building": "B1"}, "another building than 'B1'"),
        ({}, {"floor": 1}, "expected either floor, or storey with relative_height"),
        ({"floor": 1, "storey": 1, "relative_height": 0.5}, {"floor": 1}, "not both"),
        ({"storey": 1}, {"floor": 1}, "expected a number between 0 and 1 beside storey"),
        ({"floor": 1, "relative_height": 0.5}, {"floor": 1}, "no relative_height beside floor"),
        *(
            ({"storey": 1, "relative_height": s}, {"floor": 1}, "a number above 0 and below 1")
            for s in (-0.1, 0.0, 1.0, 1.5, "0 %")
        ),
    ],
)
def test_contact_refused(a: dict[str, object], b: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        entry(a, b)
