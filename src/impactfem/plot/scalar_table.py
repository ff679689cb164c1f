"""A table of scalar results beside the published ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from impactfem.plot.table import Cell, Table
from impactfem.system.scalar import Scalar


def beside_published(
    name: str, title: str, scalars: Iterable[Scalar], published: Mapping[str, float]
) -> Table:
    """Name, value, published value where one is known, their ratio, unit and note.

    Args:
        name: File name without ending.
        title: What the table shows.
        scalars: The results.
        published: Published values in SI by the name of the result.
    """
    rows: list[tuple[Cell, ...]] = []
    for scalar in scalars:
        theirs = published.get(scalar.name)
        ratio = scalar.value / theirs if scalar.value is not None and theirs else None
        rows.append((scalar.name, scalar.value, theirs, ratio, scalar.unit, scalar.note))
    columns = (
        *(("name", ""), ("value", ""), ("published", "")),
        *(("over published", ""), ("unit", ""), ("note", "")),
    )
    return Table(name, title, columns, tuple(rows)).comparing(
        {"published", "over published"}, ", beside the published values"
    )
