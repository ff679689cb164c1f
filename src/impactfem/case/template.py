"""A new case file to start from: complete, commented, and accepted as it is."""

from __future__ import annotations

import os
import re
from importlib.resources import files
from pathlib import Path

from impactfem.system.errors import Fault, InputError


def write_new_case(target: str | Path) -> list[Path]:
    """Write a commented case file and the floor table beside it, and give their paths.

    The target is the name of the case, with or without ``.toml``, in a folder that exists, or an
    existing folder, which gets ``case.toml``.

    Raises:
        InputError: A file is there already (nothing is overwritten), the name cannot be used, or
            the folder cannot be written to. Nothing is left behind then.
    """
    if str(target) == "":
        expected = "expected the name of a case; a folder gets 'case.toml', this one is '.'"
        raise InputError([Fault("command line", "NAME", "", expected)])
    target = Path(target)
    if os.path.isdir(target):  # noqa: PTH112 - false for a name that is too long, no OSError
        target = target / "case.toml"
    name = target.name.removesuffix(".toml")
    if re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name) is None:
        expected = "expected a name of letters, digits, '_', '-' and '.', for example 'my_case'"
        raise InputError([Fault(target, "", None, expected)])
    folder = target.parent
    if not os.path.isdir(folder):  # noqa: PTH112
        raise InputError([Fault(folder, "", None, "no such folder; make it first")])
    templates = {"case.toml": f"{name}.toml", "floors.csv": f"{name}_floors.csv"}
    paths = [folder / file for file in templates.values()]
    existing = [path for path in paths if os.path.lexists(path)]
    if existing:
        expected = "this file exists already and is not overwritten; choose another name"
        raise InputError([Fault(path, "", None, expected) for path in existing])
    written: list[Path] = []
    for template, path in zip(templates, paths, strict=True):
        text = (files("impactfem.case") / "templates" / template).read_text(encoding="utf-8")
        try:
            with path.open("x", encoding="utf-8") as stream:
                written.append(path)
                stream.write(text.replace("@NAME@", name))
        except OSError as error:
            for half in written:
                half.unlink(missing_ok=True)
            reason = error.strerror or str(error)
            raise InputError([Fault(path, "", None, f"cannot be written ({reason})")]) from error
    return paths
