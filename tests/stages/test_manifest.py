"""Manifests of stages: what is read back, what is none, and what another run has finished."""

import json
import platform
import sys
from importlib.metadata import PackageNotFoundError

import numpy as np
import pytest

from impactfem import __version__
from impactfem.stages import manifest
from impactfem.stages.manifest import (
    PACKAGES,
    changed_file,
    file_digest,
    further_buildings,
    is_finished,
    manifest_file,
    mark_finished,
    provenance,
    read_manifest,
    remove_drawings,
    take_over,
)
from impactfem.system.errors import ImpactfemError, InputError

GOOD = {"inputs": "key", "seconds": {"roof: laid": 1}, "peak_memory": None, "files": {}}


def written(folder, **changes):
    manifest_file(folder, "roof").write_text(json.dumps(GOOD | changes))
    return folder


def test_read_back(tmp_path):
    found = read_manifest(written(tmp_path), "roof")
    assert found.inputs == "key" and found.seconds == {"roof: laid": 1.0}


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
def test_what_is_none(tmp_path, changes):
    with pytest.raises(ValueError, match=next(iter(changes))):
        read_manifest(written(tmp_path, **changes), "roof")


OUTSIDE = ["/etc/a", "../a", "figures/../../a", "figures//a", "./a", "", "figures/a\x1b", "a/.."]


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize("of", ["files", "drawings"])
def test_names_outside_of_the_folder_are_refused(tmp_path, of, name):
    with pytest.raises(ValueError, match=of):
        read_manifest(written(tmp_path, **{of: {name: "hash"}}), "roof")


def test_drawings_of_a_foreign_manifest_are_not_removed(tmp_path):
    folder = tmp_path / "run"
    (folder / "B2" / "figures").mkdir(parents=True)
    (folder / "figures").mkdir()
    kept = [tmp_path / "a.txt", folder / "notes.txt", folder / "case.toml"]
    drawn = [folder / "figures" / "a.svg", folder / "B2" / "figures" / "a.svg"]
    for path in (*kept, *drawn):
        path.write_text("words")
    for names in (["../a.txt"], [str(kept[0])], ["notes.txt"], ["figures/../case.toml"]):
        written(folder, drawings=dict.fromkeys(["figures/a.svg", *names], "hash"))
        remove_drawings(folder, "roof")
        assert all(path.exists() for path in (*kept, *drawn))
    written(folder, drawings=dict.fromkeys(["figures/a.svg", "B2/figures/a.svg"], "hash"))
    remove_drawings(folder, "roof")
    assert all(path.exists() for path in kept) and not any(path.exists() for path in drawn)


@pytest.mark.parametrize("name", ["../B2", "/B2", "B2/..", "", "..", "B2\n", 3, None])
def test_further_buildings_name_folders_of_the_run(tmp_path, name):
    assert further_buildings({"further_structures": [{"building": "B-2_x"}]}, tmp_path) == ["B-2_x"]
    with pytest.raises(InputError, match=r"further_structures\.building"):
        further_buildings({"further_structures": [{"building": name}]}, tmp_path)


def test_changed_files(tmp_path):
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


@pytest.fixture
def other(tmp_path):
    """A run that has finished the stage `roof` with the inputs `key`."""
    folder = tmp_path / "other"
    (folder / "figures").mkdir(parents=True)
    files = [folder / "roof.nc", folder / "figures" / "roof.png"]
    for file in files:
        file.write_text(file.name)
    mark_finished(folder, "roof", "key", files, {"roof": 1.0})
    return folder


def test_a_stage_is_copied(other, tmp_path):
    mine = tmp_path / "mine"
    assert take_over(mine, [tmp_path / "absent", other], "roof", "key") == other
    assert is_finished(mine, "roof", "key") and read_manifest(mine, "roof").seconds == {"roof": 1.0}
    assert (mine / "figures" / "roof.png").read_text() == "roof.png"
    (mine / "roof.nc").write_text("mine alone")
    assert (other / "roof.nc").read_text() == "roof.nc"


def test_other_inputs_or_another_stage_are_not(other, tmp_path):
    for stage, key in (("roof", "changed"), ("floor", "key")):
        assert take_over(tmp_path / "mine", [other], stage, key) is None
    assert not (tmp_path / "mine").exists()


@pytest.mark.parametrize("file", ["roof.nc", "roof.stage.json"])
def test_a_stage_that_is_not_whole_is_not(other, tmp_path, file):
    (other / file).write_text("{")
    assert take_over(tmp_path / "mine", [other], "roof", "key") is None


def test_what_is_finished_stays(other, tmp_path):
    mine = tmp_path / "mine"
    take_over(mine, [other], "roof", "key")
    (mine / "roof.nc").unlink()
    assert take_over(mine, [other], "roof", "key") is None
    assert not is_finished(mine, "roof", "key")


def test_a_file_that_cannot_be_written(other, tmp_path):
    (tmp_path / "mine" / "roof.nc").mkdir(parents=True)
    (tmp_path / "mine" / "roof.nc" / "file").touch()
    with pytest.raises(ImpactfemError, match=r"cannot write .*roof\.nc"):
        take_over(tmp_path / "mine", [other], "roof", "key")


def test_versions_and_facts(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["/usr/bin/impactfem", "run", "a b.toml"])
    found = provenance(case="a.toml", seeds={"motions[0].seed": 1})
    assert found["impactfem"] == __version__ and found["packages"]["numpy"] == np.__version__
    assert set(found["packages"]) == set(PACKAGES)
    assert found["python"] == platform.python_version()
    assert found["command"] == ["impactfem", "run", "a b.toml"]
    assert found["case"] == "a.toml" and found["seeds"] == {"motions[0].seed": 1}
    assert platform.node() not in str(found)


def test_a_package_that_is_not_installed(monkeypatch):
    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(manifest, "version", absent)
    assert set(provenance()["packages"].values()) == {"unknown"}
