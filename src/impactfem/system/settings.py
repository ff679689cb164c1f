"""Settings files of libraries in the working folder, which are not read.

Such a folder may come from somebody else, and its settings files could run code, write files
anywhere, or change results. The user's own settings are environment variables.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from threading import Lock
from types import ModuleType
from typing import Any

FILES = frozenset({"matplotlibrc", ".numba_config.yaml", "petsc.cfg", "slepc.cfg"})
"""Names that libraries look for in the working folder while they are imported."""
LIBRARIES = frozenset({"matplotlib", "numba", "petsc4py", "slepc4py"})
_lock, _depth = Lock(), 0


def ignore_settings_files() -> None:
    """Prevent libraries that are imported later from reading settings in the working folder."""
    os.environ["NCRCENV_IGNORE"] = "1"  # netCDF: .ncrc, .daprc and .dodsrc
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())


class _Finder(MetaPathFinder):
    """Finds the modules of `LIBRARIES`; `FILES` are hidden while these are executed."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if name.partition(".")[0] not in LIBRARIES:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and spec.loader is not None:
            loader: Any = spec.loader
            loader.exec_module = partial(_execute, loader.exec_module)
        return spec


def _execute(execute: Callable[[ModuleType], None], module: ModuleType) -> None:
    with _hidden():
        if module.__name__ == "petsc4py.PETSc":  # it starts PETSc, which reads files of options
            sys.modules["petsc4py"].init(["-skip_petscrc"])
        else:
            execute(module)
    if module.__name__ == "numba.core.config":  # it looks for its file at each compilation, too
        module._config_fname = os.devnull  # type: ignore[attr-defined]


@contextmanager
def _hidden() -> Iterator[None]:
    """`os.path` says of the `FILES` of the working folder that there are none. May be nested."""
    global _depth
    with _lock:
        _depth += 1
        if _depth == 1:
            _KNOWN.update({name: getattr(os.path, name) for name in ("exists", "isfile")})
            for name, known in _KNOWN.items():
                setattr(os.path, name, partial(_seen, known))
    try:
        yield
    finally:
        with _lock:
            _depth -= 1
            if _depth == 0:
                for name, known in _KNOWN.items():
                    setattr(os.path, name, known)


_KNOWN: dict[str, Callable[[Any], bool]] = {}  # the functions of `os.path` that are replaced


def _seen(known: Callable[[Any], bool], path: Any) -> bool:
    return path not in FILES and known(path)
