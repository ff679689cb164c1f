"""`summary.json`: every scalar result with its unit, and the published value where there is one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from impactfem.case import Published
from impactfem.system.files import write_json
from impactfem.system.scalar import Scalar


def write_summary(
    path: Path, scalars: Iterable[Scalar], published: Mapping[str, Published]
) -> None:
    """Write the list of {name, value, unit, paper, relation, kind, note}.

    Args:
        path: The file.
        scalars: The results.
        published: Published values in SI units by name; where there is none, `paper`, `relation`
            and `kind` are null.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    entries = []
    for scalar in scalars:
        value, theirs = scalar.value, published.get(scalar.name)
        entries.append(
            {
                "name": scalar.name,
                "value": value if value is not None and math.isfinite(value) else None,
                "unit": scalar.unit,
                "paper": None if theirs is None else theirs.value,
                "relation": None if theirs is None else theirs.relation,
                "kind": None if theirs is None else theirs.kind,
                "note": scalar.note,
            }
        )
    write_json(path, entries)
