"""The motion of the whole model around the main impact, for ParaView: `transient_motion.vtkhdf`.

A file in the layout VTKHDF of HDF5. ParaView from 5.12 on and pyvista open it as a time series;
older ones need its index in XDMF, which says where in it grid, times and fields are. The cells
stay, and each field is an array of 32-bit floats, shape (n_times n_points, 3): all points at one
time, then all at the next.

HDF5 ends the process when its own writing meets a full disk. So it makes the file in memory, all
but the fields, and gives where they begin; what goes to the disk are plain bytes.
"""

import errno
import math
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import h5py
import numpy as np
from numpy.typing import NDArray

from impactfem.case.transient import Transient
from impactfem.reduction.loads import Loads
from impactfem.reduction.probes import MotionGrid, motion_grid
from impactfem.reduction.response import modal_histories
from impactfem.stages.transient.compute import TransientStudy, main_impact
from impactfem.stages.transient.prepared import transient_of
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

Values = NDArray[np.float32]
Write = Callable[[str, int, Values], None]

BEFORE = 0.01
"""From the first time that is written to the main impact [s]."""
AT_ONCE = 8_000_000
"""Values of a field that are computed at once."""
NODES = 1024
"""Nodes whose vectors are copied at once."""
UNITS = {"displacement": "m", "acceleration": "m/s2"}
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
    before anything is computed. Times have the shape (n_times,) [s], units are those of the fields.
    What it gives writes a field: its name, the index of a time, and the values at this and the
    following times, shape (m, n_points, 3).
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


def exported_steps(transient: Transient, loads: Loads, event: tuple[float, float] | None) -> Index:
    """Numbers of the time steps that are written, by default about an event.

    A SolutionError where the first time that is requested is not computed.
    """
    dt, last = loads.time_step, len(loads.ground) - 1
    start = transient.export_start
    if start is None:
        shaken = dt * float(np.argmax(np.linalg.norm(loads.ground, axis=1)))
        start = max(0.0, (shaken if event is None else event[0]) - BEFORE)
    first = math.ceil(start / dt - 1e-6)
    if first > last:
        raise SolutionError(
            f"transient.export_start of {start:g} s: the last time that is computed is "
            f"{dt * last:g} s"
        )
    end = min(last, math.floor((start + transient.export_duration) / dt + 1e-6))
    every = max(1, round((transient.export_step or dt) / dt))
    return np.arange(first, max(first, end) + 1, every, dtype=np.int64)


def write_motion(
    path: Path,
    study: TransientStudy,
    key: str,
    progress: Callable[[float], None] = lambda part: None,
) -> list[Path]:
    """Write displacements relative to the ground and absolute accelerations of the whole model.

    They are those of the reduced model, at the nodes and times that the case asks for: the file,
    VTKHDF, and last of all its index, XDMF.

    Raises:
        KeyError: The basis was not made for one of the nodes.
        SolutionError: The first time that is requested is not computed.
        ImpactfemError: A file cannot be written.
    """
    transient, prepared, basis = transient_of(study.case), study.prepared, study.basis
    loads = prepared.loads
    if basis is None:
        raise ValueError("only a case with a reduced basis has the motion of the whole model")
    grid = motion_grid(prepared.parts.mesh, transient.export_nodes)
    at = np.searchsorted(basis.nodes, grid.nodes)
    if not np.array_equal(basis.nodes.take(at, mode="clip"), grid.nodes):
        raise KeyError("a node that the basis was not made for")
    steps = exported_steps(
        transient, loads, main_impact(loads) or main_impact(loads, external=True)
    )
    times: Array = np.asarray(loads.time_step * steps, dtype=np.float64)
    history = modal_histories(basis, loads, prepared.damping)
    # V (Y z): Φ = V Y of so many nodes would be as large as V.
    Y = basis.model.coordinates
    r = Y.shape[1]
    motion = {
        "displacement": (history.displacement[:, steps], np.zeros((len(steps), 3))),
        "acceleration": (history.acceleration[:, steps], loads.ground[steps]),
    }
    attributes = {
        "title": study.case.title,
        "inputs": key,
        "case_hash": study.case.content_hash(),
        "note": "displacement relative to the ground, absolute acceleration; SI",
    }
    at_once = max(1, AT_ONCE // (3 * len(grid.nodes)))
    with motion_file(path, grid, times, UNITS, attributes) as write:
        for first in range(0, len(steps), at_once):
            part = slice(first, first + at_once)
            for name, (modal, ground) in motion.items():
                coordinates, base = Y @ modal[:r, part], modal[r:, part]
                size, field = len(coordinates), np.empty((len(steps[part]), len(at), 3), np.float32)
                for k in range(0, len(at), NODES):
                    rows = basis.vectors[at[k : k + NODES], :, :size].reshape(-1, size)
                    moved = rows @ coordinates
                    if len(base):
                        moved += basis.carried(grid.nodes[k : k + NODES]).reshape(-1, 6) @ base
                    values = moved.T.reshape(len(field), -1, 3)
                    field[:, k : k + NODES] = values + ground[part][:, None]
                write(name, first, field)
            progress(min(1.0, (first + at_once) / len(steps)))
    index = path.with_suffix(".xdmf")
    write_motion_index(index, path, grid, times, tuple(UNITS))
    LOGGER.debug(
        "transient: motion of %d nodes at %d times, %g to %g s, written for ParaView: %.0f MB",
        len(grid.nodes),
        len(steps),
        times[0],
        times[-1],
        1e-6 * len(UNITS) * len(steps) * len(grid.nodes) * POINT,
    )
    return [path, index]
