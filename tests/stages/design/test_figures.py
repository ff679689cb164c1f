"""Figures and the table of members of the stage `design`."""

import numpy as np
import pytest

from impactfem.stages.design.figures import design_figures
from impactfem.stages.design.products import member_table

from .design_store import WantedDesign

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


@pytest.fixture
def drawn(made, tmp_path):
    """Draw all figures; gives the store and the names of the files."""

    def make(asked=None):
        products, _ = made(asked, (0.1, 0.15))
        files = design_figures(tmp_path, products)
        assert all(path.stat().st_size > 10_000 for path in files)
        return products.store, {path.name for path in files}

    return make


def test_a_page_for_each_direction_and_damping(drawn):
    _, files = drawn(WantedDesign(still=True))
    assert files == {
        "design_device_force.svg",
        *(
            f"design_{kind}_{direction}_{damping}pct.svg"
            for kind in ("spectra", "ensemble")
            for direction in "yz"
            for damping in (2, 5)
        ),
    }


def test_no_page_of_an_ensemble_that_is_not_there(drawn):
    _, files = drawn(WantedDesign(motions=0))
    assert len(files) == 6 and not any("ensemble" in name or "force" in name for name in files)


@pytest.mark.parametrize("devices", [(), ("pump", "rack_1", "rack_2", "cabinet")])
def test_members(drawn, devices):
    store, files = drawn(WantedDesign(devices=devices, still=True))
    assert ("design_device_force.svg" in files) == bool(devices)
    table = member_table(store)
    assert len(table.rows) == 5 + 4 and len(table.columns) == 2 + 2 + 2 * len(devices)
    assert [row[0] for row in table.rows[-4:]] == [
        *("median", "mean", "84 % fractile", "lognormal 84 % fractile"),
    ]


def test_statistics_of_members(made):
    store = made()[0].store
    table = member_table(store)
    names = [name for name, _ in table.columns]
    column = names.index("Fy of pump, 3D model")
    force = store["member_device_force"].values[:, 0, 1]
    np.testing.assert_allclose([row[column] for row in table.rows[:5]], force, rtol=1e-5)
    assert table.rows[6][column] == pytest.approx(force.mean(), rel=1e-5)
    # A force that one member does not have has no logarithm.
    store["member_device_force"].values[2, 0, 1] = 0.0
    assert member_table(store).rows[-1][column] is None
