"""Folders for what later runs use again: compiled code and fonts."""

import os
import shutil
import stat
import tempfile
from pathlib import Path

import platformdirs

from impactfem.system.errors import ImpactfemError

LEAST_SPACE = 20_000_000  # for the forms and kernels of a run [byte]


def cache_folder(name: str) -> Path:
    """The folder of that name in the user's cache, or else among temporary files.

    ImpactfemError where no place for it can be written, or has `LEAST_SPACE`.
    """
    temporary = Path(tempfile.gettempdir(), f"impactfem-{os.getuid()}")
    places = [platformdirs.user_cache_path(), temporary]
    for place in places:
        folder = place / "impactfem" / name
        shared = place == temporary  # where anyone may make folders
        try:
            if shared:
                place.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "lock").touch()
            if shutil.disk_usage(folder).free < LEAST_SPACE:
                continue
            # Code is loaded from here: nobody else may have put it there, or may change it.
            for path in (place, folder.parent, folder):
                state = path.lstat() if shared else path.stat()
                if state.st_uid != os.getuid() or (
                    shared and (stat.S_ISLNK(state.st_mode) or state.st_mode & 0o022)
                ):
                    break
            else:
                return folder
        except OSError:
            continue
    raise ImpactfemError(
        f"no folder for compiled code can be written: {', '.join(map(str, places))}; expected "
        f"{LEAST_SPACE / 1e6:.0f} MB of space in one of them. XDG_CACHE_HOME names another place"
    )


def place_caches() -> None:
    """Set where numba caches, and matplotlib where it could not; the user's choice stays.

    numba loads compiled code from its cache: no other setting may name the folder. Without a cache
    matplotlib looks for all fonts again in each process. ImpactfemError where no place can be
    written.
    """
    config = platformdirs.user_config_path("matplotlib")
    nearest = next((path for path in (config, *config.parents) if path.exists()), config)
    fonts_kept = nearest.is_dir() and os.access(nearest, os.W_OK | os.X_OK)
    for variable, name, kept in (
        ("NUMBA_CACHE_DIR", "kernels", False),
        ("MPLCONFIGDIR", "matplotlib", fonts_kept),
    ):
        if not kept and not os.environ.get(variable):
            os.environ[variable] = str(cache_folder(name))
