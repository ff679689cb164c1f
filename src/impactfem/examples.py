"""The shipped cases, for `impactfem examples`: their list, and copies to start from."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from pydantic import BaseModel

from impactfem.case.base import nearest
from impactfem.case.load import load_case
from impactfem.case.model import CaseFile
from impactfem.case.report import Reference
from impactfem.case.source import Source, file_names, parse, read_source
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import in_source_tree

GEOMETRY = "geometry"
SCHEMA = re.compile(r"(?m)\A#:schema .*\n")
"""First line of a shipped case, which names a file of the documentation."""


@dataclass(frozen=True)
class Example:
    """A shipped case."""

    name: str  #: its path below the folder of cases, without ``.toml``
    title: str
    size: str  #: its buildings, 3D models and motions in words


def examples() -> list[Example]:
    """Return the shipped cases, those against other programs last."""
    folder = in_source_tree(GEOMETRY)
    return [_example(name, read_source(path, CaseFile)) for name, path in _cases(folder).items()]


def copy_example(name: str, folder: Path | None = None) -> list[Path]:
    """Copy a shipped case with all files that it names, and those that it extends.

    Args:
        name: Name of the case.
        folder: Folder of the copy, which is made where it does not exist; that of the name of the
            case if None.

    Returns:
        The files, the case first.

    Raises:
        InputError: There is no such case, a file exists already (nothing is overwritten), or the
            folder cannot be written to.
    """
    root = in_source_tree(GEOMETRY)
    cases = _cases(root)
    wanted = name.removesuffix(".toml")
    wanted = next((one for one in cases if wanted in (one, one.rpartition("/")[2])), wanted)
    if wanted not in cases:
        expected = f"no shipped case of this name; {nearest(wanted, list(cases))}"
        raise InputError([Fault("command line", "NAME", name, expected)])
    case = cases[wanted]
    folder = Path(PurePosixPath(wanted).name) if folder is None else folder
    if os.path.lexists(folder) and not folder.is_dir():
        raise InputError([Fault(folder, "", None, "this is a file, not a folder")])
    files = list(dict.fromkeys(_files(case)))
    above = Path(os.path.commonpath([path.parent for path in files]))
    targets = {path: folder / path.relative_to(above) for path in files}
    if existing := [path for path in targets.values() if os.path.lexists(path)]:
        expected = "this file exists already and is not overwritten; name another folder"
        raise InputError([Fault(path, "", None, expected) for path in existing])
    for source, target in targets.items():
        content = source.read_bytes()
        if source.suffix == ".toml":
            content = SCHEMA.sub("", content.decode()).encode()
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("xb") as stream:
                stream.write(content)
        except OSError as error:
            reason = f"cannot be written ({error.strerror or error})"
            raise InputError([Fault(target, "", None, reason)]) from error
    return list(targets.values())


def _cases(folder: Path) -> dict[str, Path]:
    """The case files of the folder by name; other TOML files are of fits and of references."""
    paths = [*sorted(folder.glob("*.toml")), *sorted(folder.glob("validation/*.toml"))]
    named = {path.relative_to(folder).with_suffix("").as_posix(): path for path in paths}
    return {name: path for name, path in named.items() if _kind(path) is CaseFile}


def _kind(path: Path) -> type[BaseModel]:
    """The model of a TOML file."""
    from impactfem.fit.fit_file import FitFile

    content = parse(path, path.read_text(encoding="utf-8"))
    if "free" in content:
        return FitFile
    if {"items", "assumptions"} & set(content):
        return Reference
    return CaseFile


def _example(name: str, source: Source) -> Example:
    """The line of a case in the list."""
    raw: dict[str, Any] = source.raw
    buildings = raw["buildings"]
    models = sum("structure" in one for one in buildings)
    words = [f"{len(buildings)} building{'s' if len(buildings) > 1 else ''}"]
    words += [f"{models} in 3D"] if models else []
    if motions := len(raw.get("motions", ())):
        words.append(f"{motions} motion{'s' if motions > 1 else ''}")
    return Example(name, str(raw["title"]), ", ".join(words))


def _files(path: Path) -> Iterator[Path]:
    """A TOML file, those that it extends, and all files that they name; fits of a case, too."""
    model = _kind(path)
    if model is CaseFile or model is Reference:
        source = read_source(path, model)
        raw = source.raw
        yield from (_normal(path.parent / name) if name else path for name in source.texts)
    else:
        raw = parse(path, path.read_text(encoding="utf-8"))
        yield path
    for _, name in file_names(raw, (), raw, model):
        file = _normal(path.parent / name)
        if file.suffix == ".toml":
            yield from _files(file)
        elif file.is_dir():
            yield from sorted(one for one in file.rglob("*") if one.is_file())
        else:
            yield file
    if model is CaseFile:
        # Files that tables name, as the spectra of an equipment list.
        yield from (_normal(path.parent / name) for name in load_case(path).input_files)
        stems = {one.stem for one in path.parent.glob("*.toml") if _kind(one) is CaseFile}
        for fit in sorted(path.parent.glob(f"{path.stem}_*fit.toml")):
            owners = [stem for stem in stems if fit.stem.startswith(f"{stem}_")]
            if max(owners, key=len) == path.stem:
                yield from _files(fit)


def _normal(path: Path) -> Path:
    """The path without ``..``."""
    return Path(os.path.normpath(path))
