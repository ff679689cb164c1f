"""The table of published values: what the paper gives for a result of ours."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.leaf import Text, read_number
from impactfem.case.table import column_key, read_table
from impactfem.case.unit import UnitError, to_si
from impactfem.system.errors import Fault

Relation = Literal["=", ">", "<"]
Kind = Literal["result", "input", "fitted", "scaled", "selected", "derived"]


class PublishedRow(Section):
    """One row of the table of published values, in the units of the publication."""

    name: Text = Field(description="Name of the result, as in summary.json.")
    value: Text = Field(
        description="The published value; '> 110' or '< 110' where an inequality is published, "
        "which then holds or does not, whatever the tolerance."
    )
    unit: Text = Field(description="Unit of the value; '-' when it has none.")
    source: Text = Field(description="Where it is published: table, figure or section.")


class Published(Section):
    """A published value in SI, with its SI unit and where it is published.

    Args:
        value: The value, or the bound of an inequality.
        relation: What the publication says of its own result: "=", or ">" or "<" the bound.
        unit: SI unit.
        source: Where it is published.
        kind: What ours is beside it: a result, or (`GivenValues`) no test of ours.
    """

    value: float
    relation: Relation = "="
    unit: str
    source: str
    kind: Kind = "result"


def read_published(path: Path, faults: list[Fault]) -> dict[str, Published] | None:
    """Read a table of published values; what is wrong with it is appended to ``faults``.

    Args:
        path: A CSV file with the columns of ``PublishedRow``.
        faults: Every fault of the table is appended here.

    Returns:
        The values in SI by name, or None when there were faults.
    """
    table = read_table(path, PublishedRow, faults)
    if table is None:
        return None
    values: dict[str, Published] = {}
    before = len(faults)
    for line, row in zip(table.lines, table.rows, strict=True):
        relation: Relation = "="
        if row.value[0] in "<>":
            relation = "<" if row.value[0] == "<" else ">"
        number = read_number(row.value if relation == "=" else row.value[1:])
        if number is None:
            key = column_key(line, table.headers["value"])
            expected = "expected a finite number (its unit is in the column 'unit'), or '> 110'"
            faults.append(Fault(path, key, row.value, expected))
            continue
        try:
            value, unit = to_si(number, row.unit)
        except UnitError as error:
            key = column_key(line, table.headers["unit"])
            faults.append(Fault(path, key, row.unit, f"{error}; expected a unit, or '-'"))
            continue
        if row.name in values:
            key = column_key(line, table.headers["name"])
            faults.append(Fault(path, key, row.name, "duplicate name"))
            continue
        values[row.name] = Published(value=value, relation=relation, unit=unit, source=row.source)
    return values if len(faults) == before else None
