"""The motion of the whole model as a file for viewers, in the layout VTKHDF of HDF5.

ParaView from 5.12 on and pyvista open it as a time series; older ones need its index in XDMF, which
says where in it grid, times and fields are. The cells stay, and each field is an array of 32-bit
floats, shape (n_times n_points, 3): all points at one time, then all at the next.

HDF5 ends the process when its own writing meets a full disk. So it makes the file in memory, all
but the fields, of which it tells where they begin; what goes to the disk are plain bytes.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import h5py
import numpy as np
from numpy.typing import NDArray

from impactfem.reduction.probes import MotionGrid
from impactfem.system.files import atomic

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Values = NDArray[np.float32]
Write = Callable[[str, int, Values], None]

POINT = 12
"""Size of one point of a field at one time: three 32-bit floats [B]."""
OTHERS = 1_000_000
"""Room for names, shapes and texts, far more than they take [B]."""
TRIANGLES = {3: 5, 6: 22}
LINES = {2: 3, 3: 21}
"""VTK's types of cells by their number of nodes."""
XDMF_TRIANGLES = {3: (4,), 6: (36,)}
XDMF_LINES = {2: (2, 2), 3: (34,)}
"""What comes before the nodes of each cell in XDMF: the type; of a polyline their number, too."""
TOPOLOGY = "XDMF/Topology"
POINTS = "VTKHDF/Points"
FIELDS = "VTKHDF/PointData"
"""Where arrays are in the motion file."""
INDEX = """\
<?xml version='1.0' encoding='utf-8'?>
<Xdmf Version="3.0">
 <Domain>
  <Grid Name="motion" GridType="Collection" CollectionType="Temporal">
{times}
  </Grid>
 </Domain>
</Xdmf>
"""
TIME = """\
   <Grid Name="building" GridType="Uniform">
    <Time Value="{time:.12g}" />
    <Topology TopologyType="Mixed" NumberOfElements="{cells}">{topology}</Topology>
    <Geometry GeometryType="XYZ">{points}</Geometry>
{fields}
   </Grid>"""
FIELD = """\
    <Attribute Name="{name}" AttributeType="Vector" Center="Node">
     <DataItem ItemType="HyperSlab" Dimensions="{n} 3">
      <DataItem Dimensions="3 2" NumberType="Int" Format="XML">{first} 0 1 1 {n} 3</DataItem>
      {values}
     </DataItem>
    </Attribute>"""
"""First row and column of the field at a time, strides, numbers of rows and columns."""


@contextmanager
def motion_file(
    path: Path,
    grid: MotionGrid,
    times: Array,
    units: Mapping[str, str],
    attributes: Mapping[str, str],
) -> Iterator[Write]:
    """A file to write fields into, moved to its place when the block ends without an error.

    Its room on the disk is taken at the beginning: a full disk ends it, as an ImpactfemError,
    before anything is computed. What it gives writes a field: its name, the index of a time, and
    the values at this and the following times, shape (m, n_points, 3).

    Args:
        path: The file.
        grid: The cells.
        times: Shape (n_times,) [s].
        units: Unit of each field, by its name.
        attributes: What else the file says of itself.
    """
    fields = len(units) * len(times) * len(grid.nodes) * POINT
    cells = 64 * (len(grid.nodes) + grid.triangles.size + grid.lines.size + len(times))
    with atomic(path) as temporary, temporary.open("wb") as stream:
        os.posix_fallocate(stream.fileno(), 0, fields + cells + OTHERS)
        # All but the fields; a file in memory, whose holes, where these are to be, take none.
        with os.fdopen(os.memfd_create("motion"), "w+b") as memory:
            with h5py.File(memory, "w") as file:
                file.attrs.update(attributes)
                file[TOPOLOGY] = mixed_topology(grid)
                begins = _describe(file, grid, times, units)
            memory.flush()
            stream.truncate(memory.seek(0, os.SEEK_END))
            end = 0
            while True:
                try:
                    start = os.lseek(memory.fileno(), end, os.SEEK_DATA)
                except OSError as error:
                    if error.errno == errno.ENXIO:  # nothing but a hole
                        break
                    raise
                end = os.lseek(memory.fileno(), start, os.SEEK_HOLE)
                stream.seek(start)
                stream.write(os.pread(memory.fileno(), end - start, start))

        def write(name: str, first: int, values: Values) -> None:
            stream.seek(begins[name] + first * len(grid.nodes) * POINT)
            stream.write(np.ascontiguousarray(values, dtype="<f4").data)

        yield write


def _describe(
    file: Any, grid: MotionGrid, times: Array, units: Mapping[str, str]
) -> dict[str, int]:
    """The group VTKHDF: one unstructured grid, times, fields without values; where these begin."""
    n, n_times = len(grid.nodes), len(times)
    kinds = [(grid.triangles, TRIANGLES), (grid.lines, LINES)]
    sizes = np.concatenate([np.full(len(cells), cells.shape[1]) for cells, _ in kinds])
    types = [np.full(len(cells), known[cells.shape[1]], np.uint8) for cells, known in kinds]
    file[POINTS] = grid.points
    group = file["VTKHDF"]
    group.attrs["Version"] = (2, 0)
    group.attrs["Type"] = np.bytes_("UnstructuredGrid")
    group["NumberOfPoints"], group["NumberOfCells"] = [n], [grid.cells]
    group["NumberOfConnectivityIds"] = [int(sizes.sum())]
    group["Connectivity"] = np.concatenate([cells.ravel() for cells, _ in kinds])
    group["Offsets"] = np.concatenate([[0], np.cumsum(sizes)])
    group["Types"] = np.concatenate(types)
    steps = group.create_group("Steps")
    steps.attrs["NSteps"] = n_times
    steps["Values"] = times
    # At every time the one part, and its points and cells, are those of the first.
    same = np.zeros(n_times, dtype=np.int64)
    steps["PartOffsets"], steps["NumberOfParts"], steps["PointOffsets"] = same, same + 1, same
    steps["CellOffsets"], steps["ConnectivityIdOffsets"] = same[:, None], same[:, None]
    # The fields are arrays of 32-bit floats that have their places in the file, and no values.
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    properties.set_obj_track_times(False)  # the same motion makes the same file
    space, parent = h5py.h5s.create_simple((n_times * n, 3)), file.require_group(FIELDS)
    begins = {}
    for name, unit in units.items():
        steps[f"PointDataOffsets/{name}"] = n * np.arange(n_times, dtype=np.int64)
        kind = h5py.h5t.IEEE_F32LE
        made = h5py.h5d.create(parent.id, name.encode(), kind, space, properties)
        begins[name] = int(made.get_offset())
        parent[name].attrs["units"] = unit
    return begins


def mixed_topology(grid: MotionGrid) -> Index:
    """All cells in one row, each with its type before its nodes."""
    rows = []
    for cells, kinds in ((grid.triangles, XDMF_TRIANGLES), (grid.lines, XDMF_LINES)):
        before = np.tile(kinds[cells.shape[1]], (len(cells), 1))
        rows.append(np.hstack([before, cells]).ravel())
    return np.concatenate(rows)


def write_motion_index(
    path: Path, motion: Path, grid: MotionGrid, times: Array, fields: tuple[str, ...]
) -> None:
    """Write the index of a motion file in the same folder, with the names of its fields."""

    def item(place: str, shape: str, kind: str, precision: int) -> str:
        where = escape(f"{motion.name}:/{place}")
        look = f'Format="HDF" NumberType="{kind}" Precision="{precision}" Dimensions="{shape}"'
        return f"<DataItem {look}>{where}</DataItem>"

    n = len(grid.nodes)
    topology = item(TOPOLOGY, str(len(mixed_topology(grid))), "Int", 8)
    points = item(POINTS, f"{n} 3", "Float", 8)
    values = {name: item(f"{FIELDS}/{name}", f"{len(times) * n} 3", "Float", 4) for name in fields}
    every = []
    for k, time in enumerate(times):
        here = [FIELD.format(name=f, n=n, first=k * n, values=values[f]) for f in fields]
        place = {"topology": topology, "points": points, "fields": "\n".join(here)}
        every.append(TIME.format(time=time, cells=grid.cells, **place))
    with atomic(path) as temporary:
        temporary.write_text(INDEX.format(times="\n".join(every)), encoding="utf-8")
