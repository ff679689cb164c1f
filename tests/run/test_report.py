"""The overview of a report, and runs that cannot be compared; test_chain has those that can."""

import shutil

import pytest

from impactfem import study
from impactfem.report.run_files import FLOWCHART, SCENE
from impactfem.system.errors import InputError


def test_runs_without_a_3d_stage(finished, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(finished.folder, other)
    with pytest.raises(InputError) as error:
        study.compare_runs(finished.folder, other, 100.0)
    told = [str(fault) for fault in error.value.faults]
    assert len(told) == 2 and all("expected a run with the stage transient" in t for t in told)
    with pytest.raises(InputError, match="expected the folder of another run"):
        study.compare_runs(other, tmp_path / "." / "other", 100.0)


@pytest.mark.parametrize("highest", [0.0, -1.0, float("nan"), float("inf")])
def test_a_frequency_that_is_none(finished, highest):
    with pytest.raises(InputError, match=r"command line: --to = .*expected a positive frequency"):
        study.compare_runs(finished.folder, finished.folder, highest)


def test_no_run(finished, tmp_path):
    with pytest.raises(InputError, match="the folder holds no run"):
        study.compare_runs(tmp_path, finished.folder, 100.0)
    assert not list(tmp_path.iterdir())


def test_the_overview_of_a_run_before_goes(finished, tmp_path):
    """This run has no 3D building any more."""
    shutil.copytree(finished.folder, tmp_path / "run")
    figures = tmp_path / "run" / "figures"
    for name in (FLOWCHART, SCENE):
        (figures / name).write_text("of a run before")
    study.make_report(tmp_path / "run")
    assert not (figures / SCENE).exists()
    assert (figures / FLOWCHART).read_bytes().startswith(b"\x89PNG")
