"""Inputs of the stages: hashes that tell whether one changed, and the published values.

The sources of the program count, too: a changed program may change a result.
"""

import ast
import hashlib
import json
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import impactfem
from impactfem.case import Case, motion_files
from impactfem.system.cache import cache_folder
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_json

ROOT = Path(impactfem.__file__).parent


@cache
def program_key(modules: tuple[str, ...]) -> str:
    """Hash of the program's version, of modules by dotted names, and of all that they import.

    Imports count wherever they stand, in functions too. Comments, docstrings and layout do not
    count. Sources are read once: their changes during a run are not seen. ValueError where there is
    no such module.
    """
    path, known = _known()
    before = dict(known)
    digest = hashlib.sha256(impactfem.__version__.encode())
    for module in sorted(imported_by(modules)):
        digest.update(f"{module} {_module(module).statements}".encode())
    if path is not None and known != before:
        with suppress(ImpactfemError):  # the next run reads the sources again
            write_json(path, known)
    return digest.hexdigest()


def imported_by(modules: tuple[str, ...]) -> set[str]:
    """Modules of the program that these import, directly or not, and these themselves."""
    found: set[str] = set()
    ahead = list(modules)
    while ahead:
        module = ahead.pop()
        if module not in found:
            found.add(module)
            ahead += [name for name in _module(module).names if _file(name) is not None]
    return found


class Module(NamedTuple):
    """What counts of a module's source, kept between runs: reading all of them takes seconds."""

    digest: str  #: Hash of the file.
    names: Sequence[str]  #: Of the program, that it imports: modules, and names within them.
    statements: str  #: Hash of its statements.


@cache
def _known() -> tuple[Path | None, dict[str, Module]]:
    """The file in which sources are kept, None where none can be, and those found there."""
    # This module and Python decide what the hash of a source is.
    kind = f"{ROOT} {sys.version_info[:2]}".encode() + Path(__file__).read_bytes()
    try:
        path = cache_folder("sources") / f"{hashlib.sha256(kind).hexdigest()[:16]}.json"
    except ImpactfemError:
        return None, {}
    try:
        content = json.loads(path.read_bytes())
        return path, {module: Module(*entry) for module, entry in content.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return path, {}


@cache
def _file(module: str) -> Path | None:
    """The file of a dotted name; None where it is no module, but a name within one."""
    path = ROOT.joinpath(*module.split("."))
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in files if module and file.is_file()), None)


@cache
def _module(name: str) -> Module:
    file = _file(name)
    if file is None:
        raise ValueError(f"impactfem has no module {name}")
    text = file.read_bytes()
    digest = hashlib.sha256(text).hexdigest()
    _, known = _known()
    if name not in known or known[name].digest != digest:
        tree, names = ast.parse(text), set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
            elif isinstance(body := getattr(node, "body", None), list):
                # Without texts that stand alone, as docstrings do.
                body[:] = [
                    line
                    for line in body
                    if not (isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant))
                    or not isinstance(line.value.value, str)
                ]
        own = sorted(n.removeprefix("impactfem.") for n in names if n.startswith("impactfem."))
        statements = hashlib.sha256(ast.dump(tree).encode()).hexdigest()
        known[name] = Module(digest, own, statements)
    return known[name]


def inputs_key(
    case: Case, sections: tuple[str, ...], modules: tuple[str, ...], files: tuple[Path, ...] = ()
) -> str:
    """Hash of modules with all that they import, of sections of the case, and of files.

    With ``motions`` and ``loads`` the files that they name count too; without ``damping`` that of
    buildings and parts does not, without ``soil`` not the soil under buildings, and without
    ``contact_laws`` not the restitution of the damping cases.
    """
    digest = hashlib.sha256(program_key(modules).encode())
    # What is in a record or a mesh counts, not where it lies.
    nowhere: dict[str, Any] = {
        "motions": {"__all__": {"file"}},
        "loads": {"__all__": {"file"}},
        "structure": {"mesh": {"file"}},
        "transient": {"forces"},
        # How many members go on to the 3D model changes nothing of the members.
        "ensemble": {"structure_motions"},
    }
    nowhere["buildings"] = {"__all__": {"damping", "soil"} - set(sections)}
    if "damping" not in sections:
        nowhere["structure"]["damping"] = True
    if "contact_laws" not in sections:
        nowhere["damping_cases"] = {"__all__": {"restitution"}}
    digest.update(case.model_dump_json(include=set(sections), exclude=nowhere).encode())
    motions = case.motions if "motions" in sections else ()
    loads = case.loads if "loads" in sections else ()
    records = [file for motion in motions for file in motion_files(motion)]
    for file in (*records, *(one.file for one in loads), *files):
        # A stage that is not requested may lack a file; no finished stage has this key then.
        digest.update(file.read_bytes() if file.exists() else b"missing")
    return digest.hexdigest()


def published_values(case: Case) -> dict[str, float]:
    """Published values in SI by the name of the result; they change no result."""
    return {name: entry.value for name, entry in case.published.items()}


def tolerances(case: Case) -> dict[str, float]:
    """Largest relative difference from a published value that the case's reference allows."""
    reference = case.report.reference
    items = () if reference is None else reference.items
    return {value.name: value.tolerance for item in items for value in item.values}
