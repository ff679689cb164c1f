"""The base of the models of a case."""

from __future__ import annotations

from collections.abc import Iterable

from pydantic import BaseModel, ConfigDict, ValidationInfo


class Section(BaseModel):
    """A table of the case file: frozen, and a key it does not know is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def present(info: ValidationInfo, names: Iterable[str]) -> bool:
    """True when all these fields, declared before the one at hand, were free of faults."""
    return all(name in info.data for name in names)
