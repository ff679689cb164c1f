"""Where compiled code is kept."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest

from impactfem.system import cache
from impactfem.system.errors import ImpactfemError


@pytest.fixture
def places(monkeypatch, tmp_path):
    """The user's cache and the folder of temporary files, both empty."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path / "tmp"))
    return tmp_path / "cache", tmp_path / "tmp" / f"impactfem-{os.getuid()}"


def test_the_users_cache_comes_first_and_temporary_files_next(places):
    folder = cache.cache_folder("kernels")
    assert folder == places[0] / "impactfem" / "kernels" and folder.is_dir()
    shutil.rmtree(places[0])
    places[0].touch()
    assert cache.cache_folder("kernels") == places[1] / "impactfem" / "kernels"
    assert places[1].stat().st_mode & 0o077 == 0  # the user's alone


def test_a_full_disk_is_not_used(places, monkeypatch):
    """A library would stop there and name no file."""
    free = {places[0]: 1000, places[1]: cache.LEAST_SPACE}

    def usage(folder):
        return SimpleNamespace(
            free=next(free[place] for place in places if place in folder.parents)
        )

    monkeypatch.setattr(shutil, "disk_usage", usage)
    assert places[1] in cache.cache_folder("kernels").parents
    free[places[1]] = 1000
    with pytest.raises(ImpactfemError, match="20 MB"):
        cache.cache_folder("kernels")


def test_a_folder_of_somebody_else_is_not_used(places, monkeypatch):
    folder = cache.cache_folder("kernels")
    mine = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: mine + 1)
    with pytest.raises(ImpactfemError, match=f"can be written: {folder.parents[1]}, .*XDG_CACHE"):
        cache.cache_folder("kernels")


def test_the_cache_of_matplotlib_stays_where_it_can_be_written(places, monkeypatch, tmp_path):
    for name in ("NUMBA_CACHE_DIR", "MPLCONFIGDIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config" / "deep"))
    cache.place_caches()
    assert "MPLCONFIGDIR" not in os.environ
    # Never next to a module: numba loads code from there.
    assert os.environ["NUMBA_CACHE_DIR"] == str(places[0] / "impactfem" / "kernels")


def test_caches_are_placed_where_they_cannot(places, monkeypatch, tmp_path):
    monkeypatch.setenv("MPLCONFIGDIR", "as asked")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    cache.place_caches()
    assert os.environ["NUMBA_CACHE_DIR"] == str(places[0] / "impactfem" / "kernels")
    assert os.environ["MPLCONFIGDIR"] == "as asked"
    (tmp_path / "file").touch()
    monkeypatch.setenv("MPLCONFIGDIR", "")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "file"))
    cache.place_caches()
    assert os.environ["MPLCONFIGDIR"] == str(places[0] / "impactfem" / "matplotlib")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give up its rights")
def test_a_user_who_may_write_neither_the_program_nor_the_home_folder():
    """Numba itself refuses to start here: "no locator available"."""
    source = Path(cache.__file__)
    if source.stat().st_mode & 0o002 or not os.access(source, os.R_OK):
        pytest.skip("the program's files are everybody's")
    nobody = {"user": 65534, "group": 65534, "extra_groups": [], "cwd": "/"}
    environment = {"HOME": "/nonexistent", "PATH": os.environ["PATH"]}
    words = sys.executable, "-c", "from impactfem.spectra import oscillator"
    ended = subprocess.run(words, env=environment, capture_output=True, text=True, **nobody)
    assert ended.returncode == 0, ended.stderr


@pytest.mark.parametrize("made", ["link", "open", "link below"])
def test_a_folder_that_others_can_change_is_not_used(places, made, tmp_path):
    """Anyone may make a folder among temporary files."""
    places[0].touch()
    places[1].parent.mkdir()
    other = tmp_path / "other"
    other.mkdir()
    if made == "link":
        places[1].symlink_to(other)
    elif made == "open":
        places[1].mkdir()
        places[1].chmod(0o777)
    else:
        places[1].mkdir(mode=0o700)
        (places[1] / "impactfem").symlink_to(other)
    with pytest.raises(ImpactfemError, match="for compiled code"):
        cache.cache_folder("kernels")
