"""A case file laid over those that it extends, and the file that states each key."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel

from impactfem.case.base import nearest
from impactfem.case.leaf import FileName
from impactfem.case.place import Place, dotted, field_at, read_key, value_at
from impactfem.system.errors import CONTROL, Fault, InputError
from impactfem.system.files import LARGEST_TOML, read_text

EXTENDS = "extends"
MOST_FILES = 50
"""Largest number of files that extend one another."""
MOST_KEYS = 5000
"""Largest number of keys of a file; the paper's case has 300."""

_CASE_FILE = "a case file (TOML)"


@dataclass(frozen=True)
class Source:
    """The content of a case file, with the files it extends."""

    path: Path  #: the case file
    #: The content of all files laid over one another, which may have any faults. Names of files are
    #: relative to the folder of ``path``, whichever file says them.
    raw: dict[str, Any] = field(default_factory=dict)
    #: The text of each file by its name relative to the folder of ``path``; the case file comes
    #: first and has no name.
    texts: dict[str, str] = field(default_factory=dict)
    #: The file that states a key, by the place of the key.
    stated_in: dict[Place, Path] = field(default_factory=dict)
    #: Names of files as they are written, by their place, where ``raw`` has others.
    written: dict[Place, str] = field(default_factory=dict)

    def file_of(self, place: Place) -> Path:
        """The file that says a key; of one that is missing, the last one that says its table."""
        for end in range(len(place), 0, -1):
            if place[:end] in self.stated_in:
                return self.stated_in[place[:end]]
        return self.path

    def changes(self, below: Path) -> list[str]:
        """Keys with dots that files laid over one say; a table that they say alone is one key."""
        files = [self.path.parent / name if name else self.path for name in self.texts]
        over = set(files[: files.index(below)])
        tables = {place[:end] for place in self.stated_in for end in range(len(place))}

        def of(table: Any, place: Place) -> tuple[list[str], bool]:
            """Changed keys in a table or an array; True if they are all of it."""
            found, all_of_it = list[str](), True
            for key, value in table.items() if isinstance(table, dict) else enumerate(table):
                at: Place = (*place, key)
                names, whole = of(value, at) if at in tables else ([], self.file_of(at) in over)
                found += [dotted(at)] if whole else names
                all_of_it &= whole
            return found, all_of_it

        return of(self.raw, ())[0]

    def fault(self, place: Place, value: Any, expected: str, kind: str = "") -> Fault:
        """A fault in the file that states a key, with the value written there, or None."""
        written = self.written.get(place, value)
        return Fault(self.file_of(place), dotted(place), written, expected, kind)

    def remark(self, place: Place, text: str) -> Fault:
        """A remark about a key, with the value written there."""
        return self.fault(place, value_at(place, self.raw), text)

    def as_written(self, fault: Fault) -> Fault:
        """A fault with the value that a file states, which is named; else unchanged."""
        place = read_key(fault.key) or ()
        value = value_at(place, self.raw)
        if fault.file != self.path or value is None or isinstance(value, dict):
            return fault
        return self.fault(place, value, fault.expected, fault.kind)

    def lay(self, over: dict[str, Any], file: Path, table: Place = ()) -> None:
        """Lay a table that a file says over what stands at its place, and note who says what."""
        under: dict[str, Any] = value_at(table, self.raw)
        for key, value in over.items():
            place: Place = (*table, key)
            below: Any = under.get(key)
            tables = below if isinstance(below, list) and isinstance(value, dict) else []
            names = [_name(one) if isinstance(one, dict) else None for one in tables]
            named = {name: k for k, name in enumerate(names) if isinstance(name, str)}
            all_named = named and len(named) == len(names)
            if all_named and value and all(isinstance(entry, dict) for entry in value.values()):
                for name, entry in value.items():
                    if name not in named:
                        hint = nearest(name, list(named))
                        expected = f"no table of this name is extended; {hint}"
                        raise InputError(
                            [Fault(file, dotted((*place, name)), None, expected, "source")]
                        )
                    inside = (*place, named[name])
                    self._note(below[named[name]], inside, self.stated_in[place])
                    self.lay(entry, file, inside)
                continue  # the array is still that of the file below
            # A table of another type has other keys: it replaces the one below.
            merged = (
                isinstance(value, dict)
                and isinstance(below, dict)
                and ("type" not in value or below.get("type") == value["type"])
            )
            if not merged:
                for old in [one for one in self.stated_in if one[: len(place)] == place]:
                    del self.stated_in[old]
                under[key] = {} if isinstance(value, dict) else value
            if isinstance(value, dict):
                self.lay(value, file, place)
            self.stated_in[place] = file

    def _note(self, table: dict[str, Any], place: Place, file: Path) -> None:
        """Note which file states the keys of a table of an array, where that is not noted yet."""
        for key, value in table.items():
            self.stated_in.setdefault((*place, key), file)
            if isinstance(value, dict):
                self._note(value, (*place, key), self.stated_in[*place, key])


def _name(table: dict[str, Any]) -> Any:
    """Name of a table of an array: its name, or kind and number, as ``"figure 1"``."""
    kind, number = table.get("kind"), table.get("number")
    return table.get("name") or (kind if number is None else f"{kind} {number}")


def read_source(path: Path, model: type[BaseModel], what: str = _CASE_FILE) -> Source:
    """Read a case file and those it extends, and lay it over them; or another file that can extend.

    Tables are laid over one another key by key; a list and any other value replaces what the
    extended file says, and so does a table of another ``type``. A table in the place of an array of
    tables with names is laid over those of its keys: ``[buildings.B1]``. By the model of the file
    names of files differ from other texts. InputError where a file cannot be read or is not
    TOML, or a file extends itself.
    """
    source = Source(path)
    folders: dict[Path, Path] = {}  # of each file, relative to that of the first one
    contents: list[tuple[Path, dict[str, Any]]] = []  # what each file says itself
    file, name = path, Path()
    hint = "; 'impactfem new NAME' writes one to start from" if what == _CASE_FILE else ""
    text = read_text(path, what + hint, LARGEST_TOML)
    if isinstance(text, Fault):
        raise InputError([text])
    while True:
        content = parse(file, text)
        source.texts["" if file == path else str(name)] = text
        folders[file] = name.parent
        extended = content.pop(EXTENDS, None)
        contents.append((file, content))
        if extended is None:
            break
        if not isinstance(extended, str) or not extended.strip() or CONTROL.search(extended):
            raise InputError(
                [Fault(file, EXTENDS, extended, f"expected {FileName().phrase}", "file_name")]
            )
        below, expected = file.parent / extended, ""
        text = read_text(below, what, LARGEST_TOML)
        if isinstance(text, Fault):
            raise InputError([Fault(file, EXTENDS, extended, text.expected, text.kind)])
        if len(contents) == MOST_FILES:
            expected = f"expected at most {MOST_FILES} files that extend one another"
        elif any(below.samefile(one) for one in folders):
            names = " > ".join(one.name for one in [*folders, below])
            expected = f"expected a file that does not extend this one in turn: {names}"
        if expected:
            raise InputError([Fault(file, EXTENDS, extended, expected, "source")])
        file, name = below, name.parent / extended
    try:
        for one, content in reversed(contents):
            if isinstance(content.get("devices"), str):
                # A file in place of the tables of devices is an equipment list.
                content.setdefault("equipment", content.pop("devices"))
            source.lay(content, one)
        files = list(file_names(source.raw, (), source.raw, model))
    except RecursionError as error:
        raise InputError([Fault(path, "", None, "tables nested too deeply", "source")]) from error
    for place, written in files:
        folder = folders[source.file_of(place)]
        if folder != Path() and not Path(written).is_absolute():
            source.written[place] = written
            value_at(place[:-1], source.raw)[place[-1]] = str(folder / written)
    return source


def parse(path: Path, text: str) -> dict[str, Any]:
    """The content of a TOML file; `InputError` where it is not TOML, or too much of it."""
    try:
        content = tomllib.loads(text)
        count = _keys(content)
        if count > MOST_KEYS:
            expected = f"{count} keys; expected at most {MOST_KEYS}"
            raise InputError([Fault(path, "", None, expected, "source")])
        return content
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        reason = re.sub(r"\s*\(at .*\)$", "", str(error))
        if path.suffix.lower() == ".csv":
            expected = "expected a case file (TOML): this is a table (CSV)"
            raise InputError([Fault(path, "", None, expected, "toml")]) from error
        if reason.startswith("Illegal character '\\n'"):
            reason = "the quotation mark is not closed"
        if (twice := re.match(r"Cannot declare \('(.+?)',?\) twice", reason)) is not None:
            name = re.escape(twice[1])
            table = rf"\s*\[\s*{name}\s*\]"
            lines = [str(k) for k, row in enumerate(text.splitlines(), 1) if re.match(table, row)]
            reason = f"[{twice[1]}] appears twice (lines {' and '.join(lines)}): remove one"
        key = f"line {place[1]}, column {place[2]}" if place else "the end of the file"
        line = text.splitlines()[int(place[1]) - 1].strip() if place else None
        if line is not None and (written := re.search(r'"([^"]*\\[^"]*)"', line)):
            turned = written[1].replace("\\\\", "/").replace("\\", "/")
            reason += f'; in double quotes \\ begins an escape: write / in paths, "{turned}", or '
            reason += "\\\\ for a backslash, or single quotes"
        raise InputError([Fault(path, key, line, f"not valid TOML: {reason}", "toml")]) from error
    except (ValueError, RecursionError) as error:
        reason = "tables nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError([Fault(path, "", None, f"not valid TOML: {reason}", "toml")]) from error


def _keys(content: Any) -> int:
    """Number of keys in a content, those of its tables included."""
    if isinstance(content, dict):
        return len(content) + sum(map(_keys, content.values()))
    return sum(map(_keys, content)) if isinstance(content, list) else 0


def file_names(
    current: Any, place: Place, raw: dict[str, Any], model: type[BaseModel]
) -> Iterator[tuple[Place, str]]:
    """The names of files in a content, with their places.

    By the model of a case file they differ from other texts.
    """
    if isinstance(current, dict):
        for key, value in current.items():
            yield from file_names(value, (*place, key), raw, model)
    elif isinstance(current, list):
        for index, value in enumerate(current):
            yield from file_names(value, (*place, index), raw, model)
    elif isinstance(current, str) and current.strip() and "\0" not in current:
        _, info = field_at(model, place, raw)
        if info is not None and _has_file_name(info.annotation, info.metadata):
            yield place, current


def _has_file_name(annotation: Any, metadata: Any) -> bool:
    """Return True if a field holds the name of a file, required or optional."""
    if any(isinstance(item, FileName) for item in metadata):
        return True
    return any(
        _has_file_name(arg, getattr(arg, "__metadata__", ())) for arg in get_args(annotation)
    )
