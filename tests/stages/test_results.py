"""Declared results: fields and properties, and what is derived from them."""

import math

import pytest
import xarray as xr

from impactfem.stages.results import item_cells, outputs, scalars, value, values
from impactfem.stages.stores import Output, dataset
from impactfem.system.quantity import quantities, quantity, results, si


@results
class Impact:
    pair: str
    impulse: float = si("N s", "impulse, time integral of the force", shown="kN s")
    end: float | None = si("s", "end of the impact", name="impact_end")

    @property
    @quantity("-", "restitution")
    def restitution(self) -> float:
        return 0.5


ITEMS = (Impact("a", 2000.0, 1.5), Impact("b", 4000.0, None))


def test_declarations_of_fields_and_properties():
    assert list(quantities(Impact)) == ["impulse", "end", "restitution"]
    assert quantities(Impact)["impulse"].heading == "impulse"


def test_outputs_and_values_have_the_same_names():
    names = ["impulse", "impact_end", "restitution"]
    declared = outputs(Impact, "impact", "main_")
    assert list(declared) == list(values(Impact, ITEMS, "main_")) == [f"main_{n}" for n in names]
    assert (declared["main_impulse"].dims, declared["main_impulse"].unit) == ("impact", "N s")
    assert values(Impact, ITEMS)["impact_end"] == [1.5, pytest.approx(math.nan, nan_ok=True)]
    assert value(ITEMS[1]) == {"impulse": 4000.0, "restitution": 0.5}


@pytest.fixture
def store():
    content = values(Impact, ITEMS) | {"impact": ["first", "second"]}
    declared = outputs(Impact, "impact") | {"impact": outputs(Impact, "impact")["impulse"]}
    return dataset(declared, content, attributes={})


def test_scalars_are_selected_entries(store: xr.Dataset):
    found = scalars(store, "pounding.{impact}.{variable}", "impulse impact_end unknown")
    assert [(s.name, s.value, s.unit) for s in found] == [
        ("pounding.first.impulse", 2000.0, "N s"),
        ("pounding.second.impulse", 4000.0, "N s"),
        ("pounding.first.impact_end", 1.5, "s"),
        ("pounding.second.impact_end", None, "s"),
    ]
    (alone,) = scalars(store.isel(impact=0), "pounding.{variable}", "impulse")
    assert (alone.name, alone.value) == ("pounding.impulse", 2000.0)


def test_a_dimension_without_a_selected_label(store: xr.Dataset):
    with pytest.raises(ValueError, match="impact"):
        scalars(store, "pounding.{variable}", "impulse")


def test_cells_of_a_table():
    heads, rows = item_cells(Impact, ITEMS, {"kN s": 1e-3})
    assert heads == (("impulse", "kN s"), ("end of the impact", "s"), ("restitution", "-"))
    assert rows == [(2.0, 1.5, 0.5), (4.0, None, 0.5)]


def test_nested_items_and_units_of_components():
    """Of two units the second one is that of rotations."""
    nested = values(Impact, [ITEMS, ITEMS])["impulse"]
    assert nested == [[2000.0, 4000.0]] * 2
    declared = {"mass": Output("component", "kg, kg m2"), "component": Output("component")}
    masses = dataset(declared, {"mass": [1.0, 2.0], "component": ["x", "rx"]}, attributes={})
    assert [one.unit for one in scalars(masses, "{variable}.{component}", "mass")] == [
        "kg",
        "kg m2",
    ]
    (one,) = scalars(masses.sel(component="rx"), "{variable}", "mass")
    assert one.unit == "kg m2"
