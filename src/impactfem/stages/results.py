"""Outputs, values, scalars and table columns, derived from the dataclasses that hold results.

A field or property that is declared by `si` or `quantity` (impactfem.system.quantity) is a variable
of the results file. A scalar is a selected entry of a variable; its name follows from a pattern:

    scalars(store, "calibration.{variable}.{case}", "epsilon K_Ceq")
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from string import Formatter
from typing import Any

import xarray as xr

from impactfem.stages.stores import Output
from impactfem.system.quantity import Quantity, quantities
from impactfem.system.scalar import Scalar


def _variables(kind: type, prefix: str) -> Iterator[tuple[str, str, Quantity]]:
    """Name in the results file, attribute, and declaration of each result of a dataclass."""
    for attribute, declared in quantities(kind).items():
        yield f"{prefix}{declared.name or attribute}", attribute, declared


def outputs(kind: type, dims: str = "", prefix: str = "") -> dict[str, Output]:
    """Return the outputs of the instances of a dataclass, along the dimensions `dims`.

    An array in a field has the dimensions of its declaration in addition.
    """
    return {
        name: Output(f"{dims} {one.dims}".strip(), one.unit, one.text, shown=one.shown)
        for name, _, one in _variables(kind, prefix)
    }


def values(kind: type, items: Iterable[Any], prefix: str = "") -> dict[str, list[Any]]:
    """Return the values of instances of a dataclass, a list for each output."""
    rows = list(items)
    return {
        name: [_number(getattr(row, attribute)) for row in rows]
        for name, attribute, _ in _variables(kind, prefix)
    }


def value(item: Any, prefix: str = "") -> dict[str, Any]:
    """Return the values of one instance of a dataclass, by output; those that are None missing."""
    return {
        name: result
        for name, attribute, _ in _variables(type(item), prefix)
        if (result := getattr(item, attribute)) is not None
    }


def _number(result: Any) -> Any:
    return math.nan if result is None else result


def scalars(
    store: xr.Dataset, pattern: str, variables: str, notes: Mapping[str, str] | None = None
) -> list[Scalar]:
    """Select scalars from the variables of a store, one for each combination of labels.

    Args:
        store: The results, with single labels selected in the dimensions that `pattern` does not
            name.
        pattern: Name of a scalar with "{variable}" and the dimensions in braces:
            "frs.floor_{floor}.{variable}".
        variables: Names of the variables, separated by blanks; those not in the store are left out.
        notes: Notes by variable; without one, the description of the variable.

    Raises:
        ValueError: A variable has a dimension that the pattern does not name.
    """
    named = {field for _, field, _, _ in Formatter().parse(pattern) if field} - {"variable"}
    found = []
    for name in variables.split():
        if name not in store.variables:
            continue
        variable = store[name]
        if unnamed := set(variable.dims) - named:
            raise ValueError(f"{name}: no label of {', '.join(map(str, unnamed))} is selected")
        note = (notes or {}).get(name, variable.attrs.get("long_name", ""))
        labels = [store[dim].values.tolist() for dim in variable.dims]
        for place in product(*(range(len(of_dim)) for of_dim in labels)):
            of = {
                str(d): names[k] for d, names, k in zip(variable.dims, labels, place, strict=True)
            }
            number = float(variable.values[place])
            found.append(
                Scalar(
                    pattern.format(variable=name, **of),
                    number if math.isfinite(number) else None,
                    variable.attrs.get("units", "-"),
                    note,
                )
            )
    return found


def item_cells(kind: type, items: Sequence[Any], factors: Mapping[str, float]) -> Any:
    """Return heads and rows of a table of instances of a dataclass, a row for each."""
    declared = quantities(kind)
    heads = tuple((one.heading, one.shown or one.unit) for one in declared.values())
    rows = [
        tuple(
            _cell(getattr(item, name), factors.get(one.shown, 1.0))
            for name, one in declared.items()
        )
        for item in items
    ]
    return heads, rows


def _cell(result: Any, factor: float) -> Any:
    if isinstance(result, bool):
        return "yes" if result else "no"
    if isinstance(result, float):
        return factor * result if math.isfinite(result) else None
    return result
