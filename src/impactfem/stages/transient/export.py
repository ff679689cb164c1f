"""The motion of the whole model around the main impact, for ParaView: `transient_motion.vtkhdf`.

A time series in the layout VTKHDF of HDF5, which ParaView from 5.12 on and pyvista open. The cells
stay; each field has all points at one time, then all at the next, in 32-bit floats.
"""

import io
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from impactfem.case.transient import Transient
from impactfem.reduction.loads import Loads
from impactfem.reduction.probes import MotionGrid, motion_grid
from impactfem.reduction.response import modal_histories
from impactfem.stages.transient.compute import TransientStudy, main_impact
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

BEFORE = 0.01
"""Time from the first exported step to the main impact [s]."""
NODES = 1024
"""Nodes whose motion is computed at once."""
UNITS = {"displacement": "m", "acceleration": "m/s2"}
TYPES = {"triangles": {3: 5, 6: 22}, "lines": {2: 3, 3: 21}}
"""VTK's types of cells by their number of nodes."""


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

    They are those of the reduced model, at the nodes and times of the case.

    Raises:
        KeyError: The basis lacks one of the nodes.
        SolutionError: The first requested time is not computed.
        ImpactfemError: The file cannot be written.
    """
    case, transient = study.prepared.building.case, study.prepared.building.transient
    prepared, basis = study.prepared, study.basis
    loads = prepared.loads
    if basis is None:
        raise ValueError("only a case with a reduced basis has the motion of the whole model")
    grid = motion_grid(prepared.parts.mesh, transient.export_nodes)
    at = np.searchsorted(basis.nodes, grid.nodes)
    if not np.array_equal(basis.nodes.take(at, mode="clip"), grid.nodes):
        raise KeyError("a node that the basis was not made for")
    event = main_impact(loads) or main_impact(loads, external=True)
    steps = exported_steps(transient, loads, event)
    history = modal_histories(basis, loads, prepared.damping)
    # V (Y z): Φ = V Y of so many nodes would be as large as V.
    Y = basis.model.coordinates
    r = Y.shape[1]
    modal = {"displacement": history.displacement, "acceleration": history.acceleration}
    ground = {"displacement": np.zeros(3), "acceleration": loads.ground[steps][:, None]}
    fields = {name: np.empty((len(steps), len(at), 3), np.float32) for name in UNITS}
    for k in range(0, len(at), NODES):
        part = slice(k, k + NODES)
        for name, values in modal.items():
            coordinates, base = Y @ values[:r, steps], values[r:, steps]
            rows = basis.vectors[at[part], :, : len(coordinates)].reshape(-1, len(coordinates))
            moved = rows @ coordinates
            if len(base):
                moved += basis.carried(grid.nodes[part]).reshape(-1, 6) @ base
            fields[name][:, part] = moved.T.reshape(len(steps), -1, 3) + ground[name]
        progress(min(1.0, (k + NODES) / len(at)))
    # HDF5 ends the process when it meets a full disk, therefore it writes into memory.
    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        file.attrs.update(title=case.title, inputs=key, case_hash=case.content_hash())
        _fill(file.create_group("VTKHDF"), grid, loads.time_step * steps, fields)
    # The view is released even if the disk is full; else the memory could not be freed.
    with (
        atomic(path) as temporary,
        temporary.open("wb") as stream,
        memory.getbuffer() as content,
    ):
        stream.write(content)
    LOGGER.debug(
        "transient: motion of %d nodes at %d times, %g to %g s, written for ParaView: %.0f MB",
        len(grid.nodes),
        len(steps),
        loads.time_step * steps[0],
        loads.time_step * steps[-1],
        1e-6 * memory.tell(),
    )
    return [path]


def _fill(group: Any, grid: MotionGrid, times: Array, fields: dict[str, Any]) -> None:
    """Fill the group VTKHDF with one unstructured grid, the times [s] and the fields."""
    n, cells = len(grid.nodes), {"triangles": grid.triangles, "lines": grid.lines}
    sizes = np.concatenate([np.full(len(rows), rows.shape[1]) for rows in cells.values()])
    types = [np.full(len(v), TYPES[k][v.shape[1]], np.uint8) for k, v in cells.items()]
    group.attrs["Version"] = (2, 0)
    group.attrs["Type"] = np.bytes_("UnstructuredGrid")
    group["Points"] = grid.points
    group["NumberOfPoints"], group["NumberOfCells"] = [n], [grid.cells]
    group["NumberOfConnectivityIds"] = [int(sizes.sum())]
    group["Connectivity"] = np.concatenate([rows.ravel() for rows in cells.values()])
    group["Offsets"] = np.concatenate([[0], np.cumsum(sizes)])
    group["Types"] = np.concatenate(types)
    steps = group.create_group("Steps")
    steps.attrs["NSteps"] = len(times)
    steps["Values"] = times
    # At every time the one part, and its points and cells, are those of the first.
    same = np.zeros(len(times), dtype=np.int64)
    steps["PartOffsets"], steps["NumberOfParts"], steps["PointOffsets"] = same, same + 1, same
    steps["CellOffsets"], steps["ConnectivityIdOffsets"] = same[:, None], same[:, None]
    for name, values in fields.items():
        steps[f"PointDataOffsets/{name}"] = n * np.arange(len(times), dtype=np.int64)
        group[f"PointData/{name}"] = values.reshape(-1, 3)
        group[f"PointData/{name}"].attrs["units"] = UNITS[name]
