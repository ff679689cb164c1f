import json
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

from impactfem.building.mesh import Part
from impactfem.building.section import BeamSection

SCRIPT = Path(__file__).with_name("on_ranks.py")
HOUSE, TINY = 0, 1
RANKS = (2, 4)


@pytest.fixture(scope="module")
def of_ranks(house, new_panels, on_ranks):
    """The house, and two triangles with a beam, on a number of ranks."""
    panels = new_panels()
    panels.panel((0, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1), Part("floor", 1), 0.3)
    panels.line((0, 1, 0), (2, 1, 0), 1, Part("beam", 1), BeamSection.beam(0.3, 0.5, -0.4))
    tiny = panels.parts(base=panels.at((0, 0.0)), edges={1: panels.sides_at((1, 1.0))})
    end, corner = panels.at((0, 2.0), (1, 1.0))[0], panels.at((0, 2.0), (1, 0.0))[0]
    # On the house a slab's corner follows a node of the other slab, far from it.
    high = house.mesh.edges[2][0, 0], house.mesh.edges[1][-1, 1]
    return on_ranks(SCRIPT, buildings=[(house, high), (tiny, (end, corner))])


def first_eigenvalue(result):
    K, M = result["K"].tocsc(), result["M"].tocsc()
    return eigsh(K, 1, M, sigma=0.0, v0=np.ones(K.shape[0]), return_eigenvectors=False)[0]


@pytest.mark.parametrize("building", [HOUSE, TINY])
@pytest.mark.parametrize("ranks", RANKS)
def test_same_numbers(of_ranks, ranks, building):
    one, many = of_ranks(1)[building], of_ranks(ranks)[building]
    for name in ("K", "M", "linked K"):
        assert abs(many[name] - one[name]).max() < 1e-14 * abs(one[name]).max(), name
    for name in ("ground", "linked ground", "load", "total", "orientation"):
        assert many[name] == pytest.approx(one[name], rel=1e-13, abs=1e-9), name
    u = one["displacement"]
    assert np.abs(many["displacement"] - u).max() < 1e-9 * np.abs(u).max() > 0.0
    # Signs included.
    assert many["shapes"] == pytest.approx(one["shapes"], abs=1e-6 * np.abs(one["shapes"]).max())
    assert first_eigenvalue(many) == pytest.approx(first_eigenvalue(one), rel=1e-9)


@pytest.mark.parametrize("ranks", RANKS)
def test_ranks_share_the_work(of_ranks, ranks):
    rows = of_ranks(ranks)[HOUSE]["rows of a rank"]
    total = sum(of_ranks(1)[HOUSE]["rows of a rank"])
    assert len(rows) == ranks and sum(rows) == total and min(rows) > 0.5 * total / ranks


def test_more_ranks_than_cells(of_ranks):
    rows = of_ranks(4)[TINY]["rows of a rank"]
    assert len(rows) == 4 and 0 in rows


FRAME_SCRIPT = Path(__file__).with_name("frame_numbers.py")
KNOWN = json.loads(FRAME_SCRIPT.with_suffix(".json").read_text(encoding="utf-8"))


def test_numbers_of_the_frame(under_mpirun, tmp_path):
    """Four ranks reproduce the stored numbers of one rank."""
    out = tmp_path / "numbers.json"
    ended = under_mpirun(4, sys.executable, "-m", "mpi4py", FRAME_SCRIPT, out)
    assert ended.returncode == 0, ended.stderr
    found = json.loads(out.read_text(encoding="utf-8"))
    np.testing.assert_allclose(found["frequency"], KNOWN["frequency"], rtol=1e-9)
    np.testing.assert_allclose(found["mass"], KNOWN["mass"], rtol=1e-12)
    largest = np.abs(KNOWN["displacement"]).max()
    np.testing.assert_allclose(found["displacement"], KNOWN["displacement"], atol=1e-8 * largest)
