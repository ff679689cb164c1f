"""Inputs of the stages: hashes that tell whether one changed, and the published values.

The sources of the program count, too: a changed program may change a result.
"""

import ast
import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import impactfem
from impactfem.case import Case, motion_files
from impactfem.case.buildings import structure_files

ROOT = Path(impactfem.__file__).parent
MATRICES = ("materials", "buildings", "structure")
"""Sections that the matrices of the 3D model depend on."""


@cache
def program_key(modules: tuple[str, ...]) -> str:
    """Hash of the program's version, of modules by dotted names, and of all that they import.

    Imports count wherever they stand, in functions too. Comments, docstrings and layout do not
    count. Sources are read once: their changes during a run are not seen. ValueError where there is
    no such module.
    """
    digest = hashlib.sha256(impactfem.__version__.encode())
    for module in sorted(imported_by(modules)):
        digest.update(f"{module} {_statements(module)}".encode())
    return digest.hexdigest()


def imported_by(modules: tuple[str, ...]) -> set[str]:
    """Modules of the program that these import, directly or not, and these themselves."""
    found: set[str] = set()
    ahead = list(modules)
    while ahead:
        module = ahead.pop()
        if module not in found:
            found.add(module)
            ahead += _imports(module)
    return found


def _file(module: str) -> Path | None:
    """The file of a dotted name; None where it is no module, but a name within one."""
    path = ROOT.joinpath(*module.split("."))
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in files if module and file.is_file()), None)


@cache
def _tree(module: str) -> ast.Module:
    file = _file(module)
    if file is None:
        raise ValueError(f"impactfem has no module {module}")
    return ast.parse(file.read_bytes())


@cache
def _imports(module: str) -> tuple[str, ...]:
    names = set()
    for node in ast.walk(_tree(module)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    below = {name.removeprefix("impactfem.") for name in names if name.startswith("impactfem.")}
    return tuple(sorted(name for name in below if _file(name) is not None))


@cache
def _statements(module: str) -> str:
    """Hash of a module's statements."""
    tree = _tree(module)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # Without texts that stand alone, as docstrings do.
            body[:] = [
                line
                for line in body
                if not (isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant))
                or not isinstance(line.value.value, str)
            ]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


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
        digest.update(file.read_bytes())
    return digest.hexdigest()


def matrices_key(case: Case, modules: tuple[str, ...], own: str) -> str:
    """Hash of the inputs of the matrices of the 3D model and of a text."""
    files = structure_files(case.structure) if case.structure is not None else ()
    rest = inputs_key(case, MATRICES, modules, files)
    return hashlib.sha256(f"{own}{rest}".encode()).hexdigest()


def published_values(case: Case) -> dict[str, float]:
    """Published values in SI by the name of the result; they change no result."""
    return {name: entry.value for name, entry in case.published.items()}


def tolerances(case: Case) -> dict[str, float]:
    """Largest relative difference from a published value that the case's reference allows."""
    reference = case.report.reference
    items = () if reference is None else reference.items
    return {value.name: value.tolerance for item in items for value in item.values}
