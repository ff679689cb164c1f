"""Leaves that accept what another leaf accepts, or in its place a word, or two values."""

# The methods of the leaves are described once, in their base.
# ruff: noqa: D102

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

from impactfem.case.leaf import Leaf, Quantity, Ratio, refuse


@dataclass(frozen=True)
class OrWord(Leaf):
    """What another leaf accepts, or a word, which is kept as it is.

    Args:
        value: The leaf of the values.
        word: The word.
    """

    value: Quantity | Ratio
    word: str

    @property
    def phrase(self) -> str:
        return f"{self.value.phrase}; or '{self.word}'"

    def check(self, value: Any, info: ValidationInfo) -> float | str:
        if value == self.word:
            return self.word
        try:
            return self.value.check(value, info)
        except PydanticCustomError as error:
            raise refuse(f"{error.message()}; or '{self.word}'") from error

    def schema(self) -> dict[str, Any]:
        value, about = _accepting(self.value, f', or `"{self.word}"`')
        return {"anyOf": [*value.get("anyOf", [value]), {"const": self.word}]} | about


@dataclass(frozen=True)
class OneOrMore(Leaf):
    """A word of several, or a list of them, each once; held as a tuple.

    Args:
        words: The words.
    """

    words: tuple[str, ...]

    @property
    def phrase(self) -> str:
        return f"{' or '.join(repr(word) for word in self.words)}, or a list of them, each once"

    def check(self, value: Any, info: ValidationInfo) -> tuple[str, ...]:
        found = tuple(value) if isinstance(value, list | tuple) else (value,)
        if not found or any(found.count(one) > 1 or one not in self.words for one in found):
            raise refuse(f"expected {self.phrase}")
        return found

    def schema(self) -> dict[str, Any]:
        one = {"type": "string", "enum": list(self.words)}
        many = {"type": "array", "items": one, "minItems": 1, "uniqueItems": True}
        return {"anyOf": [one, many], "x-accepts": self.phrase}


@dataclass(frozen=True)
class OneOrTwo(Leaf):
    """One value for both, or a list of two; held as a tuple of two.

    Args:
        value: The leaf of a value.
    """

    value: Quantity | OrWord

    @property
    def phrase(self) -> str:
        return f"{self.value.phrase}; or a list of two of them"

    def check(self, value: Any, info: ValidationInfo) -> tuple[Any, Any]:
        if isinstance(value, list | tuple):
            if len(value) != 2:
                raise refuse(f"expected {self.phrase}")
            return self.value.check(value[0], info), self.value.check(value[1], info)
        try:
            one = self.value.check(value, info)
        except PydanticCustomError as error:
            raise refuse(f"{error.message()}; or a list of two of them") from error
        return one, one

    def schema(self) -> dict[str, Any]:
        value, about = _accepting(self.value, ", or a list of two of them")
        one = value.get("anyOf", [value])
        both = {"type": "array", "items": value, "minItems": 2, "maxItems": 2}
        return {"anyOf": [*one, both]} | about


def _accepting(leaf: Leaf, more: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The schema of a leaf, and what stands beside it in words: its example, and what more."""
    value = leaf.schema()
    about = {key: value.pop(key) for key in ("x-unit", "x-accepts")}
    example = value.get("examples")
    if example:
        about["x-accepts"] += f', as `"{example[0]}"`'
    about["x-accepts"] += more
    return value, about
