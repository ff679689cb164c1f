"""Arrays in one file."""

from __future__ import annotations

import gc
import logging
import resource
from pathlib import Path

import numpy as np
import pytest

from impactfem.system.archive import read_archive, write_archive
from impactfem.system.errors import ImpactfemError

CONTENT = {"a": np.arange(2000.0), "b": np.array(["x", "yz"]), "n": 3}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "some.npz"
    write_archive(path, "key", CONTENT)
    return path


def test_comes_back_as_it_was(path: Path) -> None:
    found = read_archive(path, "key")
    assert found is not None and int(found["n"]) == 3
    assert np.array_equal(found["a"], CONTENT["a"]) and found["b"].tolist() == ["x", "yz"]
    assert list(path.parent.iterdir()) == [path]


def test_another_key_and_no_file(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert read_archive(path, "other") is None
    assert read_archive(path.with_name("none.npz"), "key") is None
    assert caplog.records == []


@pytest.mark.parametrize("size", [0, 3, 60, 1000, -200, -1])
def test_cut_short(path: Path, size: int, caplog: pytest.LogCaptureFixture) -> None:
    path.write_bytes(path.read_bytes()[:size])
    with caplog.at_level(logging.WARNING, "impactfem"):
        assert read_archive(path, "key") is None
    (record,) = caplog.records
    assert "some.npz is damaged" in record.getMessage()


@pytest.mark.parametrize("seed", range(30))
def test_other_bytes(path: Path, seed: int) -> None:
    """Damage is found by the checksums; whatever is read is as it was."""
    rng = np.random.default_rng(seed)
    content = bytearray(path.read_bytes())
    content[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
    path.write_bytes(content)
    found = read_archive(path, "key")
    if found is not None:
        assert np.array_equal(found["a"], CONTENT["a"]) and found["b"].tolist() == ["x", "yz"]


def test_another_file(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with path.open("wb") as stream:
        np.savez(stream, a=1.0)
    assert read_archive(path, "key") is None
    path.write_text("no archive")
    assert read_archive(path, "key") is None
    with path.open("wb") as stream:
        np.save(stream, np.arange(3.0))
    assert read_archive(path, "key") is None
    assert [record.getMessage().endswith("computed again") for record in caplog.records] == [
        True
    ] * 3


@pytest.mark.parametrize("room", [0, 100, 10_000, 16_700])
def test_full_disk(path: Path, room: int) -> None:
    """The old file stays; nothing fails a second time, when it is collected."""
    infinite = resource.RLIM_INFINITY
    before = path.read_bytes()
    changed = CONTENT | {"n": 4}
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, infinite))
        with pytest.raises(ImpactfemError, match=r"cannot write .*some\.npz: File too large"):
            write_archive(path, "key", changed)
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before), infinite))
        gc.collect()
        assert path.read_bytes() == before and list(path.parent.iterdir()) == [path]
        write_archive(path, "key", changed)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (infinite, infinite))
    found = read_archive(path, "key")
    assert found is not None and int(found["n"]) == 4


def test_no_place(tmp_path: Path) -> None:
    with pytest.raises(ImpactfemError, match=r"cannot write .*none/some\.npz"):
        write_archive(tmp_path / "none" / "some.npz", "key", CONTENT)
