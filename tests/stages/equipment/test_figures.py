"""The figure of the equipment list."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.device.selection import WITH, WITHOUT
from impactfem.stages.equipment.figures import equipment_ratios


@pytest.mark.parametrize("count", [1, 3])
def test_each_item_has_room_in_the_figure(count):
    """A single item does not stand on the axis."""
    ratio = np.linspace(0.5, 1.5, count)
    store = xr.Dataset(
        {"ratio": (("item", "impact"), np.stack([0.5 * ratio, ratio], axis=1))},
        {"item": [f"cabinet_{k}" for k in range(count)], "impact": [WITHOUT, WITH]},
    )
    hit, quiet, capacity = equipment_ratios(store).panels[0].curves
    assert hit.y.tolist() == sorted(ratio, reverse=True)
    assert quiet.y == pytest.approx(0.5 * hit.y)
    assert capacity.x[0] < hit.x.min() and capacity.x[-1] > hit.x.max()
