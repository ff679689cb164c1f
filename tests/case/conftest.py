"""A case in a folder of its own, which a test may break."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

DATA = Path(__file__).parent / "data"

# A file, or the case file when None; the text to be replaced there; the text in its place.
Edit = tuple[str | None, str, str]


@pytest.fixture
def pair() -> Path:
    """A case file without faults."""
    return DATA / "pair.toml"


@pytest.fixture
def broken(tmp_path: Path) -> Callable[..., Path]:
    """Copy the case, replace texts in it, and give its path."""

    def copy(*edits: Edit) -> Path:
        for source in DATA.glob("pair*"):
            shutil.copy(source, tmp_path)
        for file, old, new in edits:
            path = tmp_path / (file or "pair.toml")
            text = path.read_text(encoding="utf-8")
            if old not in text:
                raise ValueError(f"{old!r} is not in {path.name}: the test does not test")
            path.write_text(text.replace(old, new), encoding="utf-8")
        return tmp_path / "pair.toml"

    return copy
