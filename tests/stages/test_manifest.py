"""Manifests of stages: what is read back, and what is none."""

import json
from pathlib import Path

import pytest

from impactfem.stages.manifest import changed_file, file_digest, manifest_file, read_manifest

GOOD = {"inputs": "key", "seconds": {"roof: laid": 1}, "peak_memory": None, "files": {}}


def written(folder: Path, **changes: object) -> Path:
    manifest_file(folder, "roof").write_text(json.dumps(GOOD | changes))
    return folder


def test_read_back(tmp_path: Path) -> None:
    manifest = read_manifest(written(tmp_path), "roof")
    assert manifest.inputs == "key" and manifest.seconds == {"roof: laid": 1.0}


@pytest.mark.parametrize(
    "changes",
    [
        {"inputs": 3},
        {"seconds": ["x"]},
        {"seconds": {"a": "1"}},
        {"seconds": {"a": float("nan")}},
        {"files": {"a": 1}},
        {"filse": {}},
    ],
)
def test_what_is_none(tmp_path: Path, changes: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(changes))):
        read_manifest(written(tmp_path, **changes), "roof")


def test_changed_files(tmp_path: Path) -> None:
    path = tmp_path / "roof.nc"
    path.write_text("tiles")
    files = {"roof.nc": file_digest(path)}
    assert changed_file(tmp_path, files) is None
    path.write_text("slates")
    assert changed_file(tmp_path, files) == path
    path.unlink()
    assert changed_file(tmp_path, files) == path
    path.mkdir()
    assert changed_file(tmp_path, files) == path
