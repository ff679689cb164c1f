"""`summary.json`: every scalar result with its unit, and the published value where there is one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from impactfem.files import write_json
from impactfem.scalar import Scalar


def write_summary(path: Path, scalars: Iterable[Scalar], published: Mapping[str, float]) -> None:
    """Write the list of {name, value, unit, paper, note}.

    Args:
        path: The file.
        scalars: The results.
        published: Published values in SI units by name; null where there is none.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    entries = []
    for scalar in scalars:
        value = scalar.value
        entries.append(
            {
                "name": scalar.name,
                "value": value if value is not None and math.isfinite(value) else None,
                "unit": scalar.unit,
                "paper": published.get(scalar.name),
                "note": scalar.note,
            }
        )
    write_json(path, entries)
