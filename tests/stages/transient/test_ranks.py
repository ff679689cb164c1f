"""Responses, checkpoints and the whole stage do not depend on the number of ranks."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from .conftest import STOREY_FACTOR
from .on_ranks import responses

pytestmark = pytest.mark.slow
SCRIPT = Path(__file__).with_name("on_ranks.py")


@pytest.fixture(scope="module")
def found(frame, begun, on_ranks, tmp_path_factory):
    """By number of ranks; two find what three have left, and run the whole stage, too."""
    folder = tmp_path_factory.mktemp("ranks")
    given = {
        "parts": frame.parts,
        "storey_factor": STOREY_FACTOR,
        "loads": frame.loads(2e-3, 110),
        "nodes": frame.nodes,
        "damping": frame.damping,
        "case": None,
    }
    made = {1: responses(MPI.COMM_SELF, given, folder / "1")}
    for ranks in (3, 2):
        work = folder / str(ranks)
        work.mkdir()
        if ranks == 2:
            shutil.copytree(folder / "3" / "left for others", work / "left")
            given["case"] = shutil.copytree(begun, folder / "case") / "frame.toml"
        made[ranks] = on_ranks(SCRIPT, given=given, folder=work)(ranks)
    made[2]["case"] = given["case"]
    return made


def apart(one, other):
    """Largest difference of any history over its largest value."""
    names = [name for name, value in one.items() if np.ndim(value)]
    assert len(names) >= 2
    return max(
        float(np.abs(one[name] - other[name]).max() / np.abs(other[name]).max()) for name in names
    )


@pytest.mark.parametrize("ranks", [2, 3])
def test_responses_are_those_of_one_rank(found, ranks):
    many, one = found[ranks], found[1]
    assert 0.0 < apart(many["full"], one["full"]) < 1e-8
    assert many["full"]["residual"] < 1e-9
    assert many["basis"]["vectors"] == one["basis"]["vectors"]
    assert many["basis"]["larger"] == one["basis"]["larger"] != "[]"
    assert 0.0 < apart(many["basis"], one["basis"]) < 1e-8


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_interrupted_run_goes_on(found, ranks):
    many = found[ranks]
    assert many["log of the resumed"] == ["transient: going on from 0.100 s"]
    assert apart(many["resumed"], many["full"]) <= (0.0 if ranks == 1 else 1e-10)


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_damage_on_one_rank_starts_all_again(found, ranks):
    many = found[ranks]
    (line,) = many["log of the damaged"]
    assert f"state_{ranks - 1}_50.npz is damaged" in line
    assert apart(many["again"], many["full"]) <= (0.0 if ranks == 1 else 1e-10)


def test_checkpoint_of_another_number_of_ranks_is_left_alone(found):
    assert found[2]["log of what was left"] == []


def test_whole_stage(found, reduced):
    """On two ranks the stores are those of one."""
    folder = found[2]["case"].parent / "run"
    assert (folder / "transient.stage.json").is_file()
    for name, variables in {
        "transient.nc": ("acceleration", "displacement", "psa", "transfer_re", "edge_force"),
        "transient_maps.nc": ("psa", "pfa", "wave_displacement", "membrane_force"),
    }.items():
        places = (folder / name, reduced[1].folder / name)
        two, one = (xr.load_dataset(path, engine="netcdf4") for path in places)
        assert two.attrs["inputs"] == one.attrs["inputs"]
        for variable in variables:
            difference = np.abs(two[variable] - one[variable]).max()
            assert float(difference / np.abs(one[variable]).max()) < 1e-6, variable
