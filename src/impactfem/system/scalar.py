"""A scalar result by name, as it travels from a stage through its store to the summary."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Scalar:
    """One scalar result.

    Args:
        name: Dotted name, for example ``pounding.peak_force.floor_8``.
        value: Its value in SI units; None when it does not exist (no impact, for example).
        unit: SI unit; "-" when it has none.
        note: What to know when reading it.
    """

    name: str
    value: float | None
    unit: str
    note: str = ""


def to_json(scalars: Iterable[Scalar]) -> str:
    """Scalars as text for a store."""
    return json.dumps([asdict(scalar) for scalar in scalars], ensure_ascii=False)


def from_json(text: str) -> list[Scalar]:
    """Scalars from a store's text."""
    return [Scalar(**entry) for entry in json.loads(text)]
