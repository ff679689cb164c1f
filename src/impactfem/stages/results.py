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

ROTATIONS = {"rx", "ry", "rz", "mx", "my", "mz"}
"""Labels of rotations and moments."""


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
    """Return the values of instances of a dataclass, a list for each output.

    Lists of instances give nested lists, for outputs along several dimensions.
    """
    rows = list(items)
    return {name: _column(rows, attribute) for name, attribute, _ in _variables(kind, prefix)}


def value(item: Any, prefix: str = "", *, known_only: bool = True) -> dict[str, Any]:
    """Return the values of one instance of a dataclass, by output.

    Those that are None are left out if `known_only`, else nan.
    """
    return {
        name: math.nan if result is None else result
        for name, attribute, _ in _variables(type(item), prefix)
        if (result := getattr(item, attribute)) is not None or not known_only
    }


def _column(items: Sequence[Any], attribute: str) -> list[Any]:
    """Return an attribute of instances in lists of any depth; nan for None."""
    column = []
    for item in items:
        nested = isinstance(item, list | tuple)
        result = _column(item, attribute) if nested else getattr(item, attribute)
        column.append(math.nan if result is None else result)
    return column


def scalars(
    store: xr.Dataset, pattern: str, variables: str, *, detail: bool = False
) -> list[Scalar]:
    """Select scalars from the variables of a store, one for each combination of labels.

    Args:
        store: The results, with single labels selected in the dimensions that `pattern` does not
            name.
        pattern: Name of a scalar with "{variable}" and the dimensions in braces:
            "frs.floor_{floor}.{variable}".
        variables: Names of the variables, separated by blanks; "word=variable" prints the word for
            "{variable}". Those not in the store are left out.
        detail: Whether `summary.json` has them only if they have a published value.

    Raises:
        ValueError: A variable has a dimension that the pattern does not name.
    """
    named = {field for _, field, _, _ in Formatter().parse(pattern) if field} - {"variable"}
    selected = []
    for entry in variables.split():
        word, _, name = entry.rpartition("=")
        if name not in store.variables:
            continue
        variable = store[name]
        if unnamed := set(variable.dims) - named:
            raise ValueError(f"{name}: no label of {', '.join(map(str, unnamed))} is selected")
        labels = [_labels(store, str(dim)) for dim in variable.dims]
        for place in product(*map(enumerate, labels)):
            at = {str(d): label for d, (_, label) in zip(variable.dims, place, strict=True)}
            number = float(variable.values[tuple(k for k, _ in place)])
            selected.append(
                Scalar(
                    pattern.format(variable=word or name, **at),
                    number if math.isfinite(number) else None,
                    _unit(variable, at.values()) or "-",
                    variable.attrs.get("long_name", ""),
                    detail,
                )
            )
    return selected


def _labels(store: xr.Dataset, dim: str) -> list[Any]:
    """The labels of a dimension; numbers from 1 if it has none."""
    return (
        store[dim].values.tolist() if dim in store.coords else list(range(1, store.sizes[dim] + 1))
    )


def _unit(variable: xr.DataArray, labels: Iterable[object]) -> str:
    """Unit of an entry: of two units the second one is that of rotations and moments."""
    units: str = variable.attrs.get("units", "-")
    first, _, second = units.partition(", ")
    selected = (label.item() for label in variable.coords.values() if label.ndim == 0)
    return second if second and ROTATIONS & {*map(str, labels), *map(str, selected)} else first


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
