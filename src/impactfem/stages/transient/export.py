"""The motion of the whole model around the main impact, for ParaView: `transient_motion.vtkhdf`."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.case.transient import Transient
from impactfem.reduction.loads import Loads
from impactfem.reduction.probes import motion_grid
from impactfem.reduction.response import modal_histories
from impactfem.stages.transient.compute import TransientStudy, main_impact
from impactfem.stages.transient.motion_file import POINT, motion_file, write_motion_index
from impactfem.stages.transient.prepared import transient_of
from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]
Index = NDArray[np.int64]

BEFORE = 0.01
"""From the first time that is written to the main impact [s]."""
AT_ONCE = 8_000_000
"""Values of a field that are computed at once."""
NODES = 1024
"""Nodes whose vectors are copied at once."""
UNITS = {"displacement": "m", "acceleration": "m/s2"}


def exported_steps(
    transient: Transient, loads: Loads, main_impact: tuple[float, float] | None
) -> Index:
    """Numbers of the time steps that are written.

    A SolutionError where the first time that is requested is not computed.
    """
    dt, last = loads.time_step, len(loads.ground) - 1
    start = transient.export_start
    if start is None:
        event = dt * float(np.argmax(np.linalg.norm(loads.ground, axis=1)))
        if main_impact is not None:
            event = main_impact[0]
        start = max(0.0, event - BEFORE)
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
    steps = exported_steps(transient, loads, main_impact(loads))
    times: Array = np.asarray(loads.time_step * steps, dtype=np.float64)
    history = modal_histories(basis, loads, prepared.damping)
    # V (Y z): Φ = V Y of so many nodes would be as large as V.
    Y = basis.model.coordinates
    motion = {
        "displacement": (Y @ history.displacement[:, steps], np.zeros((len(steps), 3))),
        "acceleration": (Y @ history.acceleration[:, steps], loads.ground[steps]),
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
            for name, (coordinates, ground) in motion.items():
                size, field = len(coordinates), np.empty((len(steps[part]), len(at), 3), np.float32)
                for k in range(0, len(at), NODES):
                    rows = basis.vectors[at[k : k + NODES], :, :size].reshape(-1, size)
                    values = (rows @ coordinates[:, part]).T.reshape(len(field), -1, 3)
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
