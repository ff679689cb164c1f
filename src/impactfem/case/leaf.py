"""Whole numbers, words, names and file names of a case file, as annotations for fields.

A leaf knows what it accepts, says so in plain words (``phrase``) for messages and the reference
page, and gives its part of the JSON schema.
"""

# The methods of the leaves are described once, in their base.
# ruff: noqa: D102

import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from impactfem.case.base import Leaf, nearest, refuse
from impactfem.system.errors import CONTROL
from impactfem.system.files import LARGEST_FILE

MOST_FLOORS = 200
"""Largest number of floors of a building."""
_RANGE = re.compile(r"(\d{1,4})(?:-(\d{1,4}))?")
_ESCAPES = dict(zip("\b\t\n\f\r", "btnfr", strict=True))  # of TOML
_LARGEST = 2**31 - 1  # what every library that counts steps or takes a seed can hold
LONGEST_NAME = 64  # letters; file names are made of names, two at a time
_RESERVED = re.compile("con|prn|aux|nul|com[0-9]|lpt[0-9]", re.IGNORECASE)  # by Windows, for files


@dataclass(frozen=True)
class Whole(Leaf):
    """A whole number between bounds."""

    least: int
    most: int = _LARGEST

    @property
    def phrase(self) -> str:
        words = f"a whole number of at least {self.least}"
        return words if self.most == _LARGEST else f"{words} and at most {self.most}"

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.int_schema(strict=True, ge=self.least, le=self.most)

    def schema(self) -> dict[str, Any]:
        bounds = {"minimum": self.least, "maximum": self.most}
        return {"type": "integer", "x-accepts": self.phrase} | bounds


@dataclass(frozen=True)
class OneOrMore:
    """A value, or a list of such values; held as a tuple."""

    count: int = 1  #: length of the list that a single value makes

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._listed, handler(source))

    def _listed(self, value: Any) -> tuple[Any, ...]:
        return tuple(value) if isinstance(value, list | tuple) else (value,) * self.count

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        array = handler(schema)
        item = array["items"] if "items" in array else array["prefixItems"][0]
        return {"anyOf": [item, array]}


@dataclass(frozen=True)
class Words(Leaf):
    """A text that is not empty and shows unchanged; with ``pattern`` it must match."""

    words: str = "a text in quotes"  #: what is expected, in words
    pattern: str | None = None  #: a regular expression for all of it, or None
    longest: int = 1000  #: largest number of characters
    lines: bool = False  #: whether it may have several lines
    file: bool = False  #: whether files are named by it: what some systems reserve is refused

    @property
    def phrase(self) -> str:
        return self.words

    def check(self, value: Any, info: ValidationInfo) -> str:
        matches = isinstance(value, str) and value.strip() != ""
        if not matches or (self.pattern and re.fullmatch(self.pattern, value) is None):
            raise refuse(f"expected {self.phrase}", kind="text")
        if len(value) > self.longest:
            expected = f"expected at most {self.longest} characters, not {len(value)}"
            raise refuse(expected, kind="text_too_long")
        if CONTROL.search(re.sub(r"[\r\n\t]", "", value) if self.lines else value):
            one = "" if self.lines else "one line "
            expected = f"expected {one}without control characters: {self.phrase}"
            raise refuse(expected, kind="control_character")
        if self.file and _RESERVED.fullmatch(value):
            expected = "expected another name: files are named by it, and Windows reserves it"
            raise refuse(expected, kind="reserved")
        return str(value)

    def schema(self) -> dict[str, Any]:
        pattern = {"pattern": f"^(?:{self.pattern})$"} if self.pattern else {"minLength": 1}
        return {"type": "string", "x-accepts": self.phrase, "maxLength": self.longest} | pattern


@dataclass(frozen=True)
class NameOf(Leaf):
    """The name of a table defined elsewhere in the case file."""

    group: str  #: where the names are: ``materials``, ``buildings`` or ``contact_laws``
    word: str  #: what one of them is called in a message

    @property
    def phrase(self) -> str:
        return f"the name of a {self.word} of this file"

    def check(self, value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, str):
            raise refuse(f"expected {self.phrase}", kind="text")
        known = info.context.names(self.group) if info.context is not None else None
        if known is not None and value not in known:
            raise refuse(f"unknown {self.word}; {nearest(value, list(known))}", kind="unknown_name")
        return value

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "minLength": 1, "x-accepts": self.phrase}


@dataclass(frozen=True)
class ModelledBuilding(NameOf):
    """The name of a building with a 3D model; left out, that of the only one."""

    group: str = "buildings"
    word: str = "building"
    whose: str = ""  #: what is of it, for messages; "" where it may be left out of several

    @property
    def phrase(self) -> str:
        return f"{super().phrase} that has a 3D model"

    def check(self, value: Any, info: ValidationInfo) -> Any:
        models = [] if info.context is None else list(info.context.three_d)
        known = " or ".join(repr(name) for name in models)
        if value is None and len(models) > 1 and self.whose:
            raise refuse(f"missing; expected the building of {self.whose}: {known}", kind="missing")
        if value is None:
            return models[0] if len(models) == 1 else ""
        name = super().check(value, info)
        if models and name not in models:
            raise refuse(f"expected a building with a 3D model: {known}", kind="no_3d_model")
        return name


@dataclass(frozen=True)
class FileName(Leaf):
    """A file or folder, relative to the working folder; in a case file to that of the file."""

    what: str = ""  #: what the file is to be, for messages, where it is to be read: ``a record``
    largest: float = field(default=LARGEST_FILE, kw_only=True)  #: its size [byte]
    #: whether a file that cannot be read is a fault where it is used, and not where it is named
    deferred: bool = field(default=False, kw_only=True)

    phrase = "a file name in quotes, relative to the folder of the case file"

    def check(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, Path):
            return value
        if isinstance(value, str) and (found := CONTROL.search(value)):
            letter = _ESCAPES.get(found[0])
            words = f"; \\{letter} in double quotes is a control character: write / in paths"
            raise refuse(f"expected {self.phrase}{words if letter else ''}", kind="file_name")
        if not isinstance(value, str) or not value.strip():
            raise refuse(f"expected {self.phrase}", kind="file_name")
        if info.context is None:
            return Path(value)
        if not self.what:
            return info.context.path(value)
        return info.context.open(value, self.what, self.largest, self.deferred)

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "minLength": 1, "x-accepts": self.phrase}


@dataclass(frozen=True)
class Levels(Leaf):
    """Numbers in a cell of a table, ``1``, ``2-8`` or ``1 3 5-7``; held as a tuple of all."""

    word: str  #: what is numbered: ``storeys`` or ``floors``

    @property
    def phrase(self) -> str:
        return f"numbers of {self.word}, ascending from 1: '3', '2-8' or '1 3 5-7'"

    def check(self, value: Any, info: ValidationInfo) -> tuple[int, ...]:
        levels = list(value) if isinstance(value, list | tuple) else []
        for part in value.split() if isinstance(value, str) else ():
            match = _RANGE.fullmatch(part)
            first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
            if last > MOST_FLOORS:
                expected = f"expected numbers of {self.word} up to {MOST_FLOORS}, found {last}"
                raise refuse(expected, kind="too_high")
            levels += range(first, last + 1) or [0]  # which is no number
        if not levels or any(a >= b for a, b in itertools.pairwise((0, *levels))):
            raise refuse(f"expected {self.phrase}", kind="levels")
        return tuple(levels)

    @staticmethod
    def written(levels: tuple[int, ...]) -> str:
        """The shortest way to write ascending numbers: ``1 3 5-7``."""
        runs = itertools.groupby(enumerate(levels), lambda one: one[1] - one[0])
        ends = ([k for _, k in run] for _, run in runs)
        return " ".join(str(k[0]) if len(k) == 1 else f"{k[0]}-{k[-1]}" for k in ends)

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "pattern": r"^\s*[0-9-]+(\s+[0-9-]+)*\s*$"}


Storeys = Annotated[tuple[int, ...], Levels("storeys")]
Floors = Annotated[tuple[int, ...], Levels("floors")]
FloorNumbers = Annotated[tuple[Annotated[int, Whole(1)], ...], Field(min_length=1), OneOrMore()]
Text = Annotated[str, Words()]
Prose = Annotated[str, Words(longest=10_000, lines=True)]
Key = Annotated[str, Words("a name of visible characters", longest=LONGEST_NAME)]
Name = Annotated[
    str,
    Words(
        "a name of letters, digits, '_' and '-' that begins with a letter, for example 'B1'",
        "[A-Za-z][A-Za-z0-9_-]*",
        longest=LONGEST_NAME,
        file=True,
    ),
]
BuildingName = Annotated[str, NameOf("buildings", "building")]
LawName = Annotated[str, NameOf("contact_laws", "contact law")]
File = Annotated[Path, FileName()]
