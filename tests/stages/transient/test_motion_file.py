"""A motion file as VTK reads it, on full disks and after kills, and its index."""

import signal
import subprocess
import sys
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest

from impactfem.reduction.probes import MotionGrid
from impactfem.stages.transient.export import mixed_topology, motion_file, write_motion_index
from impactfem.system.errors import ImpactfemError

from .conftest import seen_by_vtk

UNITS = {"displacement": "m", "acceleration": "m/s2"}
TIMES = np.array([0.25, 0.5, 0.75, 1.5])
# A square of two triangles with a post, and their mid nodes behind their vertices.
POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
SIDES = [(0, 1), (1, 2), (0, 2), (2, 3), (0, 3), (0, 4)]
ALL = np.vstack([POINTS, [(POINTS[a] + POINTS[b]) / 2 for a, b in SIDES]])
TRIANGLES = np.array([[0, 1, 2, 5, 6, 7], [0, 2, 3, 7, 8, 9]])
LINES = np.array([[0, 4, 10]])
GRIDS = {
    "vertices": MotionGrid(np.arange(5), POINTS, TRIANGLES[:, :3], LINES[:, :2]),
    "all": MotionGrid(np.arange(11), ALL, TRIANGLES, LINES),
}
TYPES = {"vertices": [5, 5, 3], "all": [22, 22, 21]}
BIG = """
import os, resource, signal, sys
from pathlib import Path
import numpy as np
from impactfem.system.errors import (ImpactfemError)
from impactfem.stages.transient.export import (motion_file)
from impactfem.reduction.probes import (MotionGrid)
grid = MotionGrid(
    np.arange(1000), np.zeros((1000, 3)), np.array([[0, 1, 2]]), np.zeros((0, 2), dtype=np.int64)
)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
try:
    with motion_file(Path(sys.argv[1]), grid, np.arange(50.0), {"u": "m"}, {}) as write:
        print("begun", flush=True)
        write("u", 0, np.ones((25, 1000, 3), dtype=np.float32))
        if len(sys.argv) > 3:
            os.kill(os.getpid(), signal.SIGKILL)
        write("u", 25, np.ones((25, 1000, 3), dtype=np.float32))
except ImpactfemError as error:
    print(error)
    sys.exit(7)
"""
FIELD = 1000 * 50 * 12


def values(grid, shift):
    n = len(TIMES) * len(grid.nodes) * 3
    return (np.arange(n, dtype=np.float32) + np.float32(shift)).reshape(len(TIMES), -1, 3)


def write_all(path, grid, order):
    with motion_file(path, grid, TIMES, UNITS, {"title": "Équilibre"}) as write:
        for first, count in order:
            for shift, name in enumerate(UNITS):
                write(name, first, values(grid, shift)[first : first + count])


@pytest.mark.parametrize("which", GRIDS)
def test_vtk_reads_what_was_written(tmp_path, which):
    grid = GRIDS[which]
    path = tmp_path / "motion.vtkhdf"
    write_all(path, grid, ((0, 3), (3, 1)))
    found = seen_by_vtk(path, tmp_path / "found")
    assert found["times"] == list(TIMES) == list(found["told"])
    assert np.array_equal(found["points"], grid.points)
    assert found["types"].tolist() == TYPES[which]
    cells = (*grid.triangles.tolist(), *grid.lines.tolist())
    assert found["cells"].tolist() == [k for cell in cells for k in (len(cell), *cell)]
    assert np.array_equal(found["displacement"], values(grid, 0.0))
    assert np.array_equal(found["acceleration"], values(grid, 1.0))
    assert not np.array_equal(found["acceleration"], values(grid, 0.0))


def test_order_of_writing_is_free(tmp_path):
    for name, order in (("one", ((0, 4),)), ("other", ((2, 2), (0, 1), (1, 1)))):
        write_all(tmp_path / name, GRIDS["all"], order)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()
    with h5py.File(tmp_path / "one") as file:
        assert file.attrs["title"] == "Équilibre"
        fields = file["VTKHDF/PointData"]
        assert {name: field.attrs["units"] for name, field in fields.items()} == UNITS
        assert {field.dtype.str for field in fields.values()} == {"<f4"}
        assert np.array_equal(
            fields["acceleration"][...].reshape(4, 11, 3), values(GRIDS["all"], 1)
        )


def test_long_motion_takes_no_memory(tmp_path):
    """Holes stay holes: the file in memory is smaller than a field at one time."""
    n = 100_000
    grid = MotionGrid(
        np.arange(n), np.zeros((n, 3)), np.array([[0, 1, 2]]), np.zeros((0, 2), dtype=np.int64)
    )
    code = (
        "import resource, sys, numpy as np; from pathlib import Path\n"
        "from impactfem.stages.transient.export import motion_file\n"
        "from impactfem.reduction.probes import MotionGrid\n"
        f"n = {n}\n"
        "grid = MotionGrid(np.arange(n), np.zeros((n, 3)), np.array([[0, 1, 2]]),\n"
        "    np.zeros((0, 2), dtype=np.int64))\n"
        "used = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "before = used()\n"
        "with motion_file(Path(sys.argv[1]), grid, np.arange(200.0), {'u': 'm'}, {}): pass\n"
        "print(used() - before)"
    )
    path = tmp_path / "motion.vtkhdf"
    ended = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    assert path.stat().st_size > 200 * 12 * len(grid.nodes)
    assert int(ended.stdout) * 1024 < 0.1 * path.stat().st_size


def in_process(path, room, *more):
    command = [sys.executable, "-c", BIG, str(path), str(room), *more]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("room", [1000, FIELD // 2, FIELD, FIELD + 1_100_000])
def test_full_disk(tmp_path, room):
    """It is told at the beginning, HDF5's own arrays included, and the old file stays."""
    path = tmp_path / "motion.vtkhdf"
    path.write_text("old")
    ended = in_process(path, room)
    if room > FIELD:
        assert ended.returncode == 0 and FIELD < path.stat().st_size < 1.2 * FIELD
    else:
        assert ended.returncode == 7, ended.stderr
        assert ended.stdout == f"cannot write {path}: File too large\n"
        assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_kill(tmp_path):
    path = tmp_path / "motion.vtkhdf"
    path.write_text("old")
    assert in_process(path, 10 * FIELD, "kill").returncode == -signal.SIGKILL
    assert path.read_text() == "old"
    assert in_process(path, 10 * FIELD).returncode == 0
    with h5py.File(path) as file:
        assert np.array_equal(file["VTKHDF/PointData/u"], np.ones((50_000, 3)))


def test_error_leaves_the_old_file(tmp_path):
    path = tmp_path / "motion.vtkhdf"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), motion_file(path, GRIDS["all"], TIMES, UNITS, {}):
        raise ZeroDivisionError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_no_place(tmp_path):
    """Neither for the file nor for its index."""
    none, name = tmp_path / "none", "m.vtkhdf"
    with (
        pytest.raises(ImpactfemError, match=r"cannot write .*none/m\.vtkhdf: No such file"),
        motion_file(none / name, GRIDS["all"], TIMES, UNITS, {}),
    ):
        pass
    with motion_file(tmp_path / name, GRIDS["all"], TIMES, UNITS, {}):
        pass
    with pytest.raises(ImpactfemError, match=r"cannot write .*none/m\.xdmf"):
        write_motion_index(none / "m.xdmf", tmp_path / name, GRIDS["all"], TIMES, ("u",))


# Nodes by XDMF's number of the type: triangles; polylines, which tell it; those of second order.
NODES = {4: 3, 2: None, 36: 6, 34: 3}


@pytest.fixture(params=list(GRIDS))
def written(request, tmp_path):
    """A grid, and the index of its motion."""
    grid = GRIDS[request.param]
    write_all(tmp_path / "motion.vtkhdf", grid, ((0, 4),))
    write_motion_index(
        tmp_path / "motion.xdmf", tmp_path / "motion.vtkhdf", grid, TIMES, tuple(UNITS)
    )
    return grid, tmp_path / "motion.xdmf"


def array(item, folder):
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


def cells_of(topology):
    entries, cells = topology.tolist(), []
    while entries:
        count = NODES[entries.pop(0)]
        count = entries.pop(0) if count is None else count
        cells.append(entries[:count])
        del entries[:count]
    return cells


def test_every_time_is_whole(written):
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


def test_topology_by_hand():
    assert mixed_topology(GRIDS["vertices"]).tolist() == [4, 0, 1, 2, 4, 0, 2, 3, 2, 2, 0, 4]
    assert mixed_topology(GRIDS["all"]).tolist() == [
        *(36, 0, 1, 2, 5, 6, 7, 36, 0, 2, 3, 7, 8, 9),
        *(34, 0, 4, 10),
    ]
