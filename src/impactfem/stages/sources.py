"""Sources of the program as inputs of a stage: a changed program may change a result."""

from __future__ import annotations

import ast
import hashlib
from functools import cache
from pathlib import Path

import impactfem

ROOT = Path(impactfem.__file__).parent


@cache
def program_key(modules: tuple[str, ...]) -> str:
    """Hash of the program's version, of modules by dotted names, and of all that they import.

    Imports count wherever they stand, in functions too. Comments, docstrings and layout do not
    count. Sources are read once: their changes during a run are not seen.

    Raises:
        ValueError: There is no such module.
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
