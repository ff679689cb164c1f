"""A case in a folder of its own, which a test may break."""

import shutil

import pytest

from .sections import DATA, STRUCTURE, TABLES, Base
from .texts import added, replaced


@pytest.fixture
def pair():
    """A case file without faults."""
    return DATA / "pair.toml"


@pytest.fixture
def written(tmp_path, edited):
    """Write a case with texts replaced, and give its path."""

    def write(base, *edits):
        for source in DATA.glob("pair*"):
            shutil.copy(source, tmp_path)
        path = tmp_path / "pair.toml"
        if base.structure:
            text = path.read_text(encoding="utf-8")
            # B1 comes last, so that what is added at the end of the file is its own.
            first = text[text.index("[[buildings]]") : text.rindex("[[buildings]]")]
            text = replaced(text, (first, ""), ("[calibration]", f"{first}[calibration]"))
            path.write_text(text + STRUCTURE, encoding="utf-8")
        added(path, base.more)
        for name, content in (TABLES | base.files if base.structure else base.files).items():
            text = content.encode() if isinstance(content, str) else content
            (tmp_path / name).write_bytes(text)
        for file, old, new in (*base.edits, *edits):
            edited(tmp_path / (file or "pair.toml"), (old, new))
        return path

    return write


@pytest.fixture
def broken(written):
    """The case, with something at its end, texts replaced, and further files."""

    def write(*edits, more="", **base):
        return written(Base(more, structure=False, **base), *edits)

    return write


@pytest.fixture
def structured(written):
    """The same of the case with a 3D model."""

    def write(*edits, more="", **base):
        return written(Base(more, **base), *edits)

    return write
