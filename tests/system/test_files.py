import errno
import gc
import io
import json
import logging
import os
import resource
import signal
import subprocess
import sys
import zipfile

import numpy as np
import pytest
import xarray as xr

from impactfem.system.errors import ImpactfemError
from impactfem.system.files import (
    atomic,
    in_source_tree,
    kept_in_one_file,
    read_archive,
    remove_parts,
    write_archive,
    write_json,
    write_netcdf,
)


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "résultat 1.txt"
    path.write_text("old")
    return path


def only(path):
    return [file.name for file in path.parent.iterdir()] == [path.name]


def test_a_whole_file_takes_the_place_of_the_old_one(old):
    with atomic(old) as temporary:
        assert temporary.parent == old.parent and temporary != old
        temporary.write_text("new")
        assert old.read_text() == "old"
    assert old.read_text() == "new" and only(old)


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit, MemoryError])
def test_an_error_leaves_the_old_file_or_none(old, error):
    for path in (old, old.with_name("none.txt")):
        with pytest.raises(error), atomic(path) as temporary:
            temporary.write_text("half")
            raise error
    assert old.read_text() == "old" and only(old)


def test_a_kill_leaves_the_old_file(old):
    code = """if True:
        import os, signal, sys; from pathlib import Path
        from impactfem.system.files import atomic
        with atomic(Path(sys.argv[1])) as temporary:
            temporary.write_text('half')
            os.kill(os.getpid(), signal.SIGKILL)
    """
    ended = subprocess.run([sys.executable, "-c", code, str(old)], check=False)
    assert ended.returncode == -signal.SIGKILL
    assert old.read_text() == "old"
    # What a killed run left is in nobody's way.
    with atomic(old) as temporary:
        temporary.write_text("new")
    assert old.read_text() == "new" and not only(old)
    remove_parts(old.parent)
    assert old.read_text() == "new" and only(old)


@pytest.fixture
def other():
    """A process that lives, and one that has ended."""
    with subprocess.Popen(["cat"], stdin=subprocess.PIPE) as living:
        with subprocess.Popen(["true"]) as ended:
            pass
        yield living.pid, ended.pid


def test_what_a_kill_left_is_removed(tmp_path, other):
    living, ended = other
    folder = tmp_path / "tables" / "deep"
    folder.mkdir(parents=True)
    left = [tmp_path / f".a b.nc.{ended}.part", folder / f".é.csv.{ended}.part"]
    # In a container each run has the same number.
    left.append(folder / f".c.csv.{os.getpid()}.part")
    kept = [folder / f".a.csv.{living}.part", folder / ".a.csv.1.part"]
    kept += [folder / name for name in ("a.csv.99.part", ".part", ".a.part", ".a.0.part", "a.csv")]
    kept += [folder / f".a.csv.{ended}.part2", folder / ".a.csv.99999999999999999999.part"]
    for path in left + kept:
        path.write_text("half")
    (folder / f".folder.{ended}.part").mkdir()
    remove_parts(tmp_path)
    assert not [path for path in left if path.exists()]
    assert all(path.is_file() for path in kept)
    assert (folder / f".folder.{ended}.part").is_dir()


@pytest.mark.parametrize(
    "place", ["missing/a.txt", "file/a.txt", "folder"], ids=["no folder", "in a file", "a folder"]
)
def test_a_place_that_cannot_be_written(tmp_path, place):
    (tmp_path / "file").write_text("old")
    (tmp_path / "folder").mkdir()
    before = sorted(tmp_path.rglob("*"))
    refused = pytest.raises(ImpactfemError, match=f"cannot write .*{place}: ")
    with refused, atomic(tmp_path / place) as temporary:
        temporary.write_text("new")
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EACCES, errno.EROFS])
def test_the_message_names_the_file_and_the_reason(old, code):
    refused = pytest.raises(ImpactfemError, match=f"{old.name}: {os.strerror(code)}")
    with refused, atomic(old) as temporary:
        temporary.write_text("half")
        raise OSError(code, os.strerror(code))
    assert old.read_text() == "old" and only(old)


def test_a_block_that_writes_nothing(old):
    with pytest.raises(ImpactfemError, match="cannot write"), atomic(old):
        pass
    assert old.read_text() == "old"


def test_json(old):
    write_json(old, [{"é": 0.1, "none": None}])
    text = old.read_text(encoding="utf-8")
    assert json.loads(text) == [{"é": 0.1, "none": None}]
    assert "é" in text and text.endswith("]\n") and only(old)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_json_refuses_what_json_has_not(old, value):
    with pytest.raises((ValueError, ImpactfemError)):
        write_json(old, {"value": float(value)})
    assert old.read_text() == "old" and only(old)


def test_netcdf(tmp_path):
    path = tmp_path / "a.nc"
    rng = np.random.default_rng(0)
    written = xr.Dataset(
        {
            "long": ("t", np.round(rng.standard_normal(50000), 2), {"units": "m"}),
            "short": ("s", np.array([1.0, np.nan])),
            "words": ("s", np.array(["a", "é"], dtype=object)),
        },
        attrs={"title": "é"},
    )
    write_netcdf(path, written)
    with xr.open_dataset(path, engine="netcdf4") as found:
        xr.testing.assert_identical(found.load(), written)
        assert found["long"].encoding["zlib"] and not found["short"].encoding["zlib"]
    assert only(path)
    assert path.stat().st_size < 8 * 50000


def test_what_comes_with_the_source_tree():
    assert in_source_tree("geometry/frame.toml").is_file()
    with pytest.raises(ImpactfemError, match="source tree"):
        in_source_tree("geometry/absent.toml")


def test_an_installed_package_has_the_cases(tmp_path, monkeypatch):
    (tmp_path / "geometry").mkdir()
    (tmp_path / "geometry" / "installed.toml").touch()
    monkeypatch.setattr("impactfem.system.files._INSTALLED", tmp_path)
    assert in_source_tree("geometry/installed.toml").is_relative_to(tmp_path)
    assert not in_source_tree("geometry/frame.toml").is_relative_to(tmp_path)


CONTENT = {"a": np.arange(2000.0), "b": np.array(["x", "yz"]), "n": 3}


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "some.npz"
    write_archive(path, "key", CONTENT)
    return path


def test_comes_back_as_it_was(path):
    found = read_archive(path, "key")
    assert found is not None and int(found["n"]) == 3
    assert np.array_equal(found["a"], CONTENT["a"]) and found["b"].tolist() == ["x", "yz"]
    assert list(path.parent.iterdir()) == [path]


def test_another_key_and_no_file(path, caplog):
    assert read_archive(path, "other") is None
    assert read_archive(path.with_name("none.npz"), "key") is None
    assert caplog.records == []


def saved(save, *values, **named):
    """The content of a file of NumPy."""
    stream = io.BytesIO()
    save(stream, *values, **named)
    return stream.getvalue()


@pytest.mark.parametrize(
    "content",
    [
        *(0, 3, 60, 1000, -200, -1),
        *(b"no archive", saved(np.savez, a=1.0), saved(np.save, np.arange(3.0))),
    ],
)
def test_a_file_cut_short_or_of_another_kind(path, content, caplog):
    path.write_bytes(path.read_bytes()[:content] if isinstance(content, int) else content)
    with caplog.at_level(logging.WARNING, "impactfem"):
        assert read_archive(path, "key") is None
    (message,) = caplog.messages
    assert "some.npz is damaged" in message and message.endswith("computed again")


@pytest.mark.parametrize("seed", range(30))
def test_other_bytes(path, seed):
    """Damage is found by the checksums; whatever is read is as it was."""
    rng = np.random.default_rng(seed)
    content = bytearray(path.read_bytes())
    content[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
    path.write_bytes(content)
    found = read_archive(path, "key")
    if found is not None:
        assert np.array_equal(found["a"], CONTENT["a"]) and found["b"].tolist() == ["x", "yz"]


WRITERS = {
    "json": lambda path, values: write_json(path, values.tolist()),
    "netcdf": lambda path, values: write_netcdf(path, xr.Dataset({"a": ("t", values)})),
    "archive": lambda path, values: write_archive(path, "key", {"a": values}),
}


@pytest.mark.parametrize("room", [0, 100, 10_000, 16_700])
@pytest.mark.parametrize("kind", WRITERS)
def test_full_disk(old, kind, room):
    """The old file stays; nothing fails a second time, when it is collected."""
    infinite, values = resource.RLIM_INFINITY, np.random.default_rng(0).standard_normal(5000)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, infinite))
        with pytest.raises(ImpactfemError, match=f"cannot write {old}: File too large"):
            WRITERS[kind](old, values)
        gc.collect()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (infinite, infinite))
    assert old.read_text() == "old" and only(old)
    WRITERS[kind](old, values)
    assert old.stat().st_size > room


def test_files_of_a_folder_in_one_file(tmp_path):
    """A block that fails leaves the folder; the next one goes on with its files and the archive."""
    folder = tmp_path / "members"
    with kept_in_one_file(folder) as given:
        (given / "a.npz").write_bytes(b"first")
    assert [path.name for path in tmp_path.iterdir()] == ["members.zip"]
    with pytest.raises(KeyError), kept_in_one_file(folder) as given:
        (given / "b.npz").write_bytes(b"second")
        raise KeyError
    assert (folder / "b.npz").is_file()
    with kept_in_one_file(folder) as given:
        assert sorted(path.name for path in given.iterdir()) == ["a.npz", "b.npz"]
        assert (given / "a.npz").read_bytes() == b"first"
    assert [path.name for path in tmp_path.iterdir()] == ["members.zip"]


def test_a_damaged_archive_of_files(tmp_path, caplog):
    folder = tmp_path / "members"
    with kept_in_one_file(folder) as given:
        (given / "a.npz").write_bytes(bytes(1000))
        (given / "b.npz").write_bytes(b"whole")
    archive = tmp_path / "members.zip"
    content = bytearray(archive.read_bytes())
    content[500] ^= 1
    archive.write_bytes(content)
    with kept_in_one_file(folder) as given:
        assert [path.name for path in given.iterdir()] == ["b.npz"]
    assert "a.npz" in caplog.text


def test_names_in_an_archive_stay_in_the_folder(tmp_path):
    with zipfile.ZipFile(tmp_path / "members.zip", "w") as archive:
        archive.writestr("../../outside.npz", "x")
    with kept_in_one_file(tmp_path / "members") as given:
        assert [path.name for path in given.iterdir()] == ["outside.npz"]
    assert not (tmp_path.parent / "outside.npz").exists()
