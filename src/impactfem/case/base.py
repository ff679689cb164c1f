"""The base of the models of a case, and of the annotations of their fields."""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, ClassVar

from pydantic import (
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
    field_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

LISTED = 300  # letters of the names that a message lists
UNREADABLE, REPORTED = "unreadable", "reported"
"""Errors of a file that a key names: of the key itself, and of what is in the file, whose faults
are collected elsewhere."""


def refuse(expected: str, *inside: int | str, kind: str = "refused") -> PydanticCustomError:
    """Make the error that a validator raises.

    Args:
        expected: What is expected, in words.
        inside: Keys and indices from the checked value to what is at fault in it, if not all of it.
        kind: Kind of the fault.
    """
    return PydanticCustomError(kind, "{expected}", {"expected": expected, "inside": inside})


def nearest(name: str, known: list[str], above: str = "") -> str:
    """Return words that name the nearest known name, or some known ones when none is near.

    Args:
        name: The unknown name.
        known: The known names.
        above: Text before the nearest name, such as the table of a key with its dot.
    """
    close = get_close_matches(name, known, n=1, cutoff=0.6)
    folded = {other.lower(): other for other in known}
    if not close:
        close = [folded[c] for c in get_close_matches(name.lower(), list(folded), 1, cutoff=0.6)]
    if close:
        return f"did you mean '{above}{close[0]}'?"
    # As many as a line can hold.
    ends = itertools.accumulate(len(one) + 2 for one in known)
    listed = [one for one, end in zip(known, ends, strict=True) if end <= LISTED]
    more = f" and {len(known) - len(listed)} others" if len(listed) < len(known) else ""
    return f"known: {', '.join(listed)}{more}" if known else "none is defined"


class Leaf(ABC):
    """Base of the annotations: checks a value and describes what it accepts."""

    @property
    @abstractmethod
    def phrase(self) -> str:
        """Expectation in words that complete 'expected ...'."""

    def check(self, value: Any, info: ValidationInfo) -> Any:
        """Give the value as the program uses it, or raise the error of ``refuse``."""
        return value

    @abstractmethod
    def schema(self) -> dict[str, Any]:
        """The JSON schema of what a case file may say."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.check)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return self.schema()


@dataclass(frozen=True)
class Written:
    """A field whose value is written in another form in the case file."""

    form: Any  #: the type of what is written
    finish: Callable[[Any], Any]  #: makes the value of it

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        written = handler.generate_schema(self.form)
        finished = core_schema.no_info_after_validator_function(self.finish, written)
        # What is serialised is the value, by the schema that counts where pydantic is strict.
        return core_schema.lax_or_strict_schema(finished, handler.generate_schema(source))


class Section(BaseModel):
    """A table of the case file: frozen, and a key it does not know is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    MAY_BE_EMPTY: ClassVar[tuple[str, ...]] = ()
    """Columns of a row of a table whose cells may be empty: not known."""
    TOGETHER: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of columns of a table that has all of them or none."""


def rule(
    field: str, *others: str, sited: bool = False, kind: str = ""
) -> Callable[[Callable[..., Iterator[Any]]], Any]:
    """A rule of a field of a section, by itself or with fields declared before it.

    It is applied where all of these are free of faults, to their values, and yields what was
    expected instead, in words, or a tuple of these with keys and indices of what inside of the
    field is at fault. A `sited` one also takes the information of the validation, which
    leads to the rest of the case file. The kind of its faults is by default its name.
    """

    def decorate(wrong: Callable[..., Iterator[Any]]) -> Any:
        name = kind or wrong.__name__.strip("_")

        def validate(cls: Any, value: Any, info: ValidationInfo) -> Any:
            if all(name in info.data for name in others):
                further = (info,) if sited else ()
                for found in wrong(value, *(info.data[name] for name in others), *further):
                    raise refuse(*([found] if isinstance(found, str) else found), kind=name)
            return value

        return field_validator(field)(classmethod(validate))

    return decorate


def together(first: str, second: str, words: str = "", *others: str) -> Any:
    """The rule that two fields are given both or not at all; the fault is the second one's.

    It is applied where the other fields are free of faults as well.
    """

    def wrong(value: Any, other: Any, *_: Any) -> Iterator[str]:
        if (value is None) != (other is None):
            yield f"expected {words or f'{first} and {second}'} together"

    return rule(second, first, *others, kind="together")(wrong)


def either(first: str, second: str, words: str, *others: str, apart: bool = False) -> Any:
    """The rule that one of two fields is given, and not both; the fault is the second one's.

    It is applied where the other fields are free of faults as well. Where neither or both are
    given, the messages differ with `apart`, and are the same without.
    """

    def wrong(value: Any, other: Any, *_: Any) -> Iterator[str]:
        if value is None and other is None:
            yield f"{'missing; ' if apart else ''}expected either {words}"
        if value is not None and other is not None:
            yield f"expected either {words}{', not both' if apart else ''}"

    return rule(second, first, *others, kind="either")(wrong)


def ascending(field: str, expected: str) -> Any:
    """The rule that the values of a field, where it has any, increase."""

    def wrong(values: Any) -> Iterator[str]:
        if isinstance(values, tuple) and any(b <= a for a, b in itertools.pairwise(values)):
            yield expected

    return rule(field, kind="ascending")(wrong)


def once(field: str, what: str) -> Any:
    """The rule that none of the values of a field, each a `what`, stands twice."""

    def wrong(values: Any) -> Iterator[str]:
        if values is not None and len(set(values)) < len(values):
            yield f"expected each {what} once"

    return rule(field, kind="once")(wrong)


def step_within(duration: str, share: float = 1.0) -> Any:
    """The rule that a `time_step` is less than the duration of its section, or half of it."""

    def wrong(step: float, longest: float | None) -> Iterator[str]:
        if longest is not None and share == 1.0 and step >= longest:
            yield f"expected a time below the duration, {longest:g} s"
        if longest is not None and share < 1.0 and step > share * longest:
            yield f"expected at most half of the duration, {longest:g} s"

    return rule("time_step", duration, kind="step_within")(wrong)
