"""Stages that another run has finished with the same inputs."""

from pathlib import Path

import pytest

from impactfem.run.finished import is_finished, mark_finished, seconds_of, take_over
from impactfem.system.errors import ImpactfemError


@pytest.fixture
def other(tmp_path: Path) -> Path:
    """A run that has finished the stage `roof` with the inputs `key`."""
    folder = tmp_path / "other"
    (folder / "figures").mkdir(parents=True)
    files = [folder / "roof.nc", folder / "figures" / "roof.png"]
    for file in files:
        file.write_text(file.name)
    mark_finished(folder, "roof", "key", files, {"roof": 1.0})
    return folder


def test_a_stage_is_copied(other: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    assert take_over(mine, [tmp_path / "absent", other], "roof", "key") == other
    assert is_finished(mine, "roof", "key") and seconds_of(mine, "roof") == {"roof": 1.0}
    assert (mine / "figures" / "roof.png").read_text() == "roof.png"
    (mine / "roof.nc").write_text("mine alone")
    assert (other / "roof.nc").read_text() == "roof.nc"


def test_other_inputs_or_another_stage_are_not(other: Path, tmp_path: Path) -> None:
    for stage, key in (("roof", "changed"), ("floor", "key")):
        assert take_over(tmp_path / "mine", [other], stage, key) is None
    assert not (tmp_path / "mine").exists()


@pytest.mark.parametrize("file", ["roof.nc", "roof.stage.json"])
def test_a_stage_that_is_not_whole_is_not(other: Path, tmp_path: Path, file: str) -> None:
    (other / file).write_text("{")
    assert take_over(tmp_path / "mine", [other], "roof", "key") is None


def test_what_is_finished_stays(other: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    take_over(mine, [other], "roof", "key")
    (mine / "roof.nc").unlink()
    assert take_over(mine, [other], "roof", "key") is None
    assert not is_finished(mine, "roof", "key")


def test_a_file_that_cannot_be_written(other: Path, tmp_path: Path) -> None:
    (tmp_path / "mine" / "roof.nc").mkdir(parents=True)
    (tmp_path / "mine" / "roof.nc" / "file").touch()
    with pytest.raises(ImpactfemError, match=r"cannot write .*roof\.nc"):
        take_over(tmp_path / "mine", [other], "roof", "key")
