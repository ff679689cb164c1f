"""Folders for compiled code and fonts, which later runs use again."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

import platformdirs

from impactfem.system.errors import ImpactfemError


def cache_folder(name: str) -> Path:
    """A folder for what may be made again: in the user's cache, or else among temporary files.

    Args:
        name: Its name; what it holds is bound to the versions in it.

    Raises:
        ImpactfemError: No place for it can be written.
    """
    temporary = Path(tempfile.gettempdir(), f"impactfem-{os.getuid()}")
    places = [platformdirs.user_cache_path(), temporary]
    for place in places:
        folder = place / "impactfem" / name
        shared = place != places[0]  # a folder where anyone may make folders
        try:
            if shared:
                place.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "lock").touch()
            # Code is loaded from here: nobody else may have put it there, or may change it.
            if all(_is_mine(one, shared) for one in (place, folder.parent, folder)):
                return folder
        except OSError:
            continue
    raise ImpactfemError(
        f"no folder for compiled code can be written: {', '.join(map(str, places))}; "
        "XDG_CACHE_HOME names another place"
    )


def _is_mine(folder: Path, shared: bool) -> bool:
    """Whether a folder is this user's; where others may make folders, no link, and only theirs."""
    found = folder.lstat() if shared else folder.stat()
    return found.st_uid == os.getuid() and not (
        shared and (stat.S_ISLNK(found.st_mode) or found.st_mode & 0o022)
    )


def place_caches() -> None:
    """Say where numba and matplotlib keep their caches, where they would find no place themselves.

    numba refuses to start when it can write neither beside a module nor in the home folder;
    matplotlib looks for all fonts again in each process. What the environment says stays.

    Raises:
        ImpactfemError: No place can be written.
    """
    if not os.access(Path(__file__).parent, os.W_OK):
        _place("NUMBA_CACHE_DIR", "kernels")
    if not _can_be_made(platformdirs.user_config_path("matplotlib")):
        _place("MPLCONFIGDIR", "matplotlib")


def _place(variable: str, name: str) -> None:
    if not os.environ.get(variable):
        os.environ[variable] = str(cache_folder(name))


def _can_be_made(folder: Path) -> bool:
    """Whether a folder can be written, or made where there is none."""
    nearest = next((path for path in (folder, *folder.parents) if path.exists()), folder)
    return nearest.is_dir() and os.access(nearest, os.W_OK | os.X_OK)
