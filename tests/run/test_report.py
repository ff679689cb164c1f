"""Two runs that cannot be put beside each other; a comparison that works stands in test_chain."""

import shutil

import pytest

from impactfem import study
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
