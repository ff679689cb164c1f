"""The page that leads from a mesh to a solution: its code runs, and gives what it says."""

import numpy as np
import pytest

from .pages import ROOT, blocks

PAGE = ROOT / "docs" / "from-a-mesh.md"


@pytest.fixture(scope="module")
def names():
    """What the code of the page leaves, run from the folder of the program."""
    left = {}
    code = [block.text for block in blocks(PAGE) if block.language == "python"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        for text in code:
            exec(compile(text, str(PAGE), "exec"), left)
    assert len(code) == 4
    return left


def test_the_strip_weighs_and_bends_as_by_hand(names):
    """Strip and beam as one section: EI, the load of weight and pressure, and that of the tip."""
    model, tip, u = names["model"], names["tip"], names["u"]
    A, B = 33e9 * 0.2, 210e9 * 0.02  # E A of the slab, of the beam
    own = 1.0 * 0.2 * 2500.0 + 100.0 + 0.02 * 7850.0  # kg/m
    assert -names["weight"][:, 2].sum() == pytest.approx(9.81 * (4.0 * own + 20.0 * 5), rel=1e-9)
    EI = 33e9 * 0.2**3 / 12.0 + 210e9 * 0.1 * 0.2**3 / 12.0 + A * B / (A + B) * 0.2**2
    q, P = 9.81 * own + 2e3, 5e3 + 9.81 * 100.0
    deflection = q * 4.0**4 / (8.0 * EI) + P * 4.0**3 / (3.0 * EI)
    # Shear, the width of the strip and a tip mass that is spread over it: some per cent.
    assert -u[tip, 2].mean() == pytest.approx(deflection, rel=0.03)
    assert names["frequency"][0] == pytest.approx(
        np.sqrt(3.0 * EI / (4.0**3 * (33.0 / 140.0 * 4.0 * own + 100.0))) / (2.0 * np.pi), rel=0.03
    )
    assert not u[model.held].any()


def test_the_blow_balances(names):
    assert names["history"].energy.residual < 1e-9
    assert names["deflection"].shape == (501, 5)
    assert names["deflection"].min() < 0.0


def test_the_frame_of_the_file(names):
    first = names["frame"].modes(1)[0][0]
    assert 1.0 < first < 20.0
    assert (names["pushed"][names["mesh"].nodes["centre_2"], 1] < 0.0).all()
