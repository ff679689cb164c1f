"""The end of a stage: its store, then what is read off it."""

from __future__ import annotations

from pathlib import Path

import pytest

from impactfem.stages.stored import stored
from impactfem.system.log import Steps

NAMES = {"stores": 1.0, "tables and figures": 1.0}


def test_order_and_files(tmp_path: Path) -> None:
    done: list[str] = []
    store, table = tmp_path / "x.nc", tmp_path / "x.csv"

    def write(path: Path, study: str) -> None:
        done.append(f"{study} in {path.name}")

    def shown() -> list[Path]:
        done.append("shown")
        return [table]

    steps = Steps(NAMES, quiet=True)
    assert stored("results", store, write, shown, steps) == [store, table]
    assert done == ["results in x.nc", "shown"]
    assert set(steps.times) == set(NAMES)


def test_nothing_is_shown_of_what_is_not_written(tmp_path: Path) -> None:
    def write(path: Path, study: str) -> None:
        raise OSError("full")

    def shown() -> list[Path]:
        raise AssertionError("shown")

    with pytest.raises(OSError, match="full"):
        stored("results", tmp_path / "x.nc", write, shown, Steps(NAMES, quiet=True))


def test_first_rank_without_results(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="rank 0 has no results"):
        stored(None, tmp_path / "x.nc", lambda *_: None, list, Steps(NAMES, quiet=True))
