"""The index of a motion file: every array that it names is there, and means what it says."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest

from impactfem.reduction.probes import MotionGrid
from impactfem.stages.transient.motion_file import (
    mixed_topology,
    motion_file,
    write_motion_index,
)
from impactfem.system.errors import ImpactfemError

from .test_motion_file import GRIDS, TIMES, UNITS, values, write_all

# Nodes by XDMF's number of the type: triangles; polylines, which tell it; those of second order.
NODES = {4: 3, 2: None, 36: 6, 34: 3}


@pytest.fixture(params=list(GRIDS))
def written(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[MotionGrid, Path]:
    """A grid, and the index of its motion."""
    grid = GRIDS[request.param]
    write_all(tmp_path / "motion.vtkhdf", grid, ((0, 4),))
    write_motion_index(
        tmp_path / "motion.xdmf", tmp_path / "motion.vtkhdf", grid, TIMES, tuple(UNITS)
    )
    return grid, tmp_path / "motion.xdmf"


def array(item: Any, folder: Path) -> Any:
    """The values of a DataItem, read as XDMF means them."""
    shape = tuple(map(int, item.get("Dimensions").split()))
    if item.get("ItemType") == "HyperSlab":
        where, source = item.findall("DataItem")
        start, stride, count = np.array(where.text.split(), dtype=int).reshape(3, -1)
        whole = array(source, folder)
        chosen = whole[
            tuple(slice(s, s + c * d, d) for s, c, d in zip(start, count, stride, strict=True))
        ]
        assert chosen.shape == shape
        return chosen
    name, place = item.text.split(":")
    with h5py.File(folder / name) as file:
        found = file[place][...]
    assert found.shape == shape
    kind = {("Float", "4"): "<f4", ("Float", "8"): "<f8", ("Int", "8"): "<i8"}
    assert found.dtype.str == kind[item.get("NumberType"), item.get("Precision")]
    return found


def cells_of(topology: Any) -> list[list[int]]:
    entries, cells = topology.tolist(), []
    while entries:
        count = NODES[entries.pop(0)]
        count = entries.pop(0) if count is None else count
        cells.append(entries[:count])
        del entries[:count]
    return cells


def test_every_time_is_whole(written: tuple[MotionGrid, Path]) -> None:
    grid, path = written
    root = ElementTree.parse(path).getroot()
    times = root.findall("Domain/Grid/Grid")
    assert [float(one.find("Time").get("Value")) for one in times] == list(TIMES)
    for k, one in enumerate(times):
        topology = one.find("Topology")
        cells = cells_of(array(topology.find("DataItem"), path.parent))
        assert cells == [*grid.triangles.tolist(), *grid.lines.tolist()]
        assert int(topology.get("NumberOfElements")) == len(cells)
        points = array(one.find("Geometry/DataItem"), path.parent)
        assert np.array_equal(points, grid.points)
        fields = one.findall("Attribute")
        assert [field.get("Name") for field in fields] == list(UNITS)
        for shift, field in enumerate(fields):
            found = array(field.find("DataItem"), path.parent)
            assert np.array_equal(found, values(grid, shift)[k])
            assert not np.array_equal(found, values(grid, shift)[k - 1])


def test_topology_by_hand() -> None:
    assert mixed_topology(GRIDS["vertices"]).tolist() == [4, 0, 1, 2, 4, 0, 2, 3, 2, 2, 0, 4]
    assert mixed_topology(GRIDS["all"]).tolist() == [
        *(36, 0, 1, 2, 5, 6, 7, 36, 0, 2, 3, 7, 8, 9),
        *(34, 0, 4, 10),
    ]


def test_no_place(tmp_path: Path) -> None:
    with motion_file(tmp_path / "m.vtkhdf", GRIDS["all"], TIMES, UNITS, {}):
        pass
    with pytest.raises(ImpactfemError, match=r"cannot write .*none/m\.xdmf"):
        write_motion_index(
            tmp_path / "none" / "m.xdmf", tmp_path / "m.vtkhdf", GRIDS["all"], TIMES, ("u",)
        )
