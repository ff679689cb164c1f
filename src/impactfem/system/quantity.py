"""Units and descriptions of results, declared on the fields and properties that hold them.

    @results
    class Impact:
        impulse: float = si("N s", "impulse, ∫ F dt", shown="kN s")

        @property
        @quantity("s", "duration", shown="ms")
        def duration(self) -> float: ...

Results files, scalars and table columns are derived from these declarations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, TypeVar, dataclass_transform

_Class = TypeVar("_Class")
_Method = TypeVar("_Method", bound=Callable[..., Any])
_DECLARATION = "quantity"


@dataclass(frozen=True)
class Quantity:
    """The declaration of a result."""

    #: SI unit; "-" for a number without a unit; "" for texts, counts and flags.
    unit: str
    #: Description; its part before the first comma is the heading of a table column.
    text: str = ""
    shown: str = ""  #: unit in tables; "" for the SI unit
    dims: str = ""  #: dimensions of an array, separated by blanks; "" for a single value
    name: str = ""  #: name in the results file; "" for the name of the field

    @property
    def heading(self) -> str:
        """The heading of a table column."""
        return self.text.partition(",")[0]


def si(unit: str, text: str = "", *, shown: str = "", dims: str = "", name: str = "") -> Any:
    """Declare a field as a result; the arguments are those of `Quantity`."""
    return field(metadata={_DECLARATION: Quantity(unit, text, shown, dims, name)})


def quantity(
    unit: str, text: str = "", *, shown: str = "", dims: str = "", name: str = ""
) -> Callable[[_Method], _Method]:
    """Declare a property as a result, as the decorator below `@property`."""

    def declare(method: _Method) -> _Method:
        setattr(method, _DECLARATION, Quantity(unit, text, shown, dims, name))
        return method

    return declare


@dataclass_transform(field_specifiers=(si, field), frozen_default=True, eq_default=False)
def results(kind: type[_Class]) -> type[_Class]:
    """Make a class a frozen dataclass whose fields may be declared by `si`."""
    return dataclass(frozen=True, eq=False)(kind)


@cache
def quantities(kind: type) -> dict[str, Quantity]:
    """The results that a class declares, by attribute: fields first, then properties."""
    declared = {one.name: one.metadata.get(_DECLARATION) for one in fields(kind)}
    declared |= {
        name: getattr(member.fget, _DECLARATION, None)
        for base in reversed(kind.__mro__)
        for name, member in vars(base).items()
        if isinstance(member, property)
    }
    return {name: one for name, one in declared.items() if one is not None}
