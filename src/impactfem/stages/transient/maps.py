"""Fields over the floors: peak acceleration and spectra of every node, and the waves."""

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from impactfem.building.mesh import DOFS
from impactfem.building.parts import BuildingParts
from impactfem.building.section_forces import section_forces
from impactfem.reduction.loads import Loads
from impactfem.reduction.probes import floor_vertices, wave_slab
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.spectra import logarithmic_frequencies, response_spectra, sampling_loss
from impactfem.stages.stores import Output, dataset
from impactfem.stages.transient.reduced_run import ReducedRun
from impactfem.system.arrays import Array, Index
from impactfem.system.parallel import all_blas_threads, threads

AT_ONCE = 256
AS_THEY_ARE = 2.0
"""Samples in a cycle of the highest frequency, the fewest: no more are put between those that are
there, which would take twenty times as long over all nodes."""
SNAPSHOTS = (0.0, 0.5, 1.0)
"""Times of the wave pictures, from the start to the end of the main impact."""
BEFORE, AFTER = 0.01, 0.03
"""Time before and after the main impact that the film shows in slow motion [s]."""
SWAY = 0.3
"""Time before and after it in which the film shows how the buildings move [s]."""
MOST_FRAMES = 40
"""Largest number of frames of the slow motion."""
SWAY_FRAMES = 15
"""Number of frames before the slow motion, and after it."""


_WAVE = "wave_node component"
MAP_OUTPUTS = {
    "component": Output("component"),
    "xyz": Output("xyz"),
    "node_number": Output("node", "", "number in building.nc", label=True),
    "node_position": Output("node xyz", "m", "vertices of the floors"),
    "floor_triangle_node": Output(
        "floor_triangle vertex", "", "vertices of the slabs, places in node"
    ),
    "floor_triangle_floor": Output("floor_triangle", label=True),
    "frequency": Output("frequency", "Hz"),
    "pfa": Output("node component", "m/s2", "peak acceleration"),
    "psa": Output("node component frequency", "m/s2", "pseudo-acceleration"),
    "pfa_free": Output("node component", "m/s2", "peak acceleration without impact"),
    "psa_free": Output("node component frequency", "m/s2", "pseudo-acceleration without impact"),
    "sampling_loss": Output("frequency", "-", "bound of what psa lacks of a peak between samples"),
    "wave_node_number": Output("wave_node", "", "number in building.nc", label=True),
    "wave_node_position": Output("wave_node xyz", "m", "nodes of the floor with the line"),
    "wave_triangle_node": Output("wave_triangle triangle_corner", "", "places in wave_node"),
    "snapshot": Output("snapshot", "s"),
    "wave_displacement": Output(f"snapshot {_WAVE}", "m", "relative to the ground"),
    "wave_acceleration": Output(f"snapshot {_WAVE}", "m/s2", "absolute"),
    "membrane_force": Output("snapshot wave_triangle", "N/m", "normal force along y"),
    "frame": Output("frame", "s", "times of the film"),
    "frame_displacement": Output("frame node xyz", "m", "relative to the ground"),
    "frame_acceleration": Output("frame node", "m/s2", "absolute, along the shown direction"),
}


def floor_maps(
    parts: BuildingParts,
    run: ReducedRun,
    *,
    main_impact: tuple[float, float] | None,
    direction: int = 0,
    floor: int | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> xr.Dataset:
    """Return the content of `transient_maps.nc`: fields at vertices of floors, waves on one floor.

    Spectra have the highest frequency and the first damping of the case.

    Args:
        parts: The building.
        run: Its reduced model under the loads.
        main_impact: Start and end of the main impact [s]; None without one.
        direction: Direction of the accelerations of the film, 0 to 2.
        floor: The floor with the waves; None for the highest.
        progress: Called with the completed part of the work.
    """
    mesh, loads = parts.mesh, run.loads
    nodes = floor_vertices(mesh)
    steps, frames = _times(main_impact, loads)
    slabs = {floor: mesh.triangles[mesh.slab(floor), :3] for floor in mesh.floors}
    vertices, attributes = _vertex_fields(run, nodes, frames, direction, progress)
    fields = {
        "component": ["x", "y", "z"],
        "xyz": ["x", "y", "z"],
        "node_number": nodes,
        "node_position": mesh.nodes[nodes],
        "floor_triangle_node": np.searchsorted(nodes, np.concatenate(list(slabs.values()))),
        "floor_triangle_floor": np.repeat(list(slabs), [len(slab) for slab in slabs.values()]),
        **vertices,
        "frame": np.asarray(frames * loads.time_step, dtype=np.float64),
        **_waves(parts, run, steps, floor),
    }
    return dataset(MAP_OUTPUTS, fields, attributes=attributes)


def _vertex_fields(
    run: ReducedRun,
    nodes: Index,
    frames: Index,
    direction: int,
    progress: Callable[[float], None],
) -> tuple[dict[str, Any], dict[str, float]]:
    """Return spectra and peaks of all vertices, their motion in the film, and the attributes."""
    loads, history, values = run.loads, run.history, run.spectra.frequency_values
    frequency = logarithmic_frequencies(min(values), max(values), 66)
    damping = float(run.spectra.damping[0])
    film_u = np.empty((len(frames), len(nodes), 3), dtype=np.float32)
    film_a = np.empty((len(frames), len(nodes)), dtype=np.float32)
    quiet = run.without_impact()
    psa, psa_free = np.empty((2, len(nodes), 3, len(frequency)), dtype=np.float32)
    pfa, pfa_free = np.empty((2, len(nodes), 3))
    reached = 0.0
    # Blocks of nodes, because the histories of all nodes need too much memory.
    for first in range(0, len(nodes), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        records = _accelerations(run, nodes[part])
        film_a[:, part] = records[direction::3, frames].T
        moved = _records(run.basis, history.displacement[:, frames], nodes[part])
        film_u[:, part] = moved.reshape(len(nodes[part]), 3, len(frames)).transpose(2, 0, 1)
        for spectrum, peak, motion in (
            (psa, pfa, records),
            (psa_free, pfa_free, _accelerations(quiet, nodes[part])),
        ):
            found = response_spectra(
                motion,
                loads.time_step,
                frequency,
                [damping],
                points_per_cycle=AS_THEY_ARE,
                threads=threads(),
                absolute=False,
            )
            spectrum[part] = found.psa[0].reshape(-1, 3, len(frequency))
            peak[part] = found.zpa.reshape(-1, 3)
        reached = found.points_per_cycle
        progress(min(1.0, (first + AT_ONCE) / len(nodes)))
    fields = {
        "frequency": frequency,
        "pfa": pfa,
        "psa": psa,
        "pfa_free": pfa_free,
        "psa_free": psa_free,
        "sampling_loss": sampling_loss(reached * frequency[-1] / frequency),
        "frame_displacement": film_u,
        "frame_acceleration": film_a,
    }
    return fields, {"damping": damping, "points_per_cycle": reached}


def _waves(
    parts: BuildingParts, run: ReducedRun, steps: Index, floor: int | None
) -> dict[str, Array]:
    """Return motion and membrane force of a floor at time steps of the main impact."""
    mesh, loads = parts.mesh, run.loads
    triangles, nodes = wave_slab(mesh, floor)

    def at(modal: Array) -> Array:
        """Values of the nodes at the time steps, shape (s, m, 3)."""
        shape = (len(nodes), 3, len(steps))
        return _records(run.basis, modal[:, steps], nodes).reshape(shape).transpose(2, 0, 1)

    displacement = at(run.history.displacement)
    acceleration = at(run.history.acceleration) + loads.ground[steps][:, None]
    return {
        "wave_node_number": nodes,
        "wave_node_position": mesh.nodes[nodes],
        "wave_triangle_node": np.searchsorted(nodes, mesh.triangles[triangles][:, :6]),
        "snapshot": np.asarray(steps * loads.time_step, dtype=np.float64),
        "wave_displacement": displacement,
        "wave_acceleration": acceleration,
        "membrane_force": membrane_force(parts, triangles, nodes, displacement),
    }


def _times(main_impact: tuple[float, float] | None, loads: Loads) -> tuple[Index, Index]:
    """Return the time steps of the snapshots and of the frames of the film."""
    if main_impact is None:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    start, end = main_impact
    pictures = [start + share * (end - start) for share in SNAPSHOTS]
    times = np.array([*pictures, start - BEFORE, end + AFTER])
    nearest = np.rint(times / loads.time_step).astype(np.int64)
    *chosen, begin, last = np.clip(nearest, 0, len(loads.ground) - 1)
    slow = np.arange(begin, last + 1, -(-(last - begin + 1) // MOST_FRAMES))
    step = max(1, round(SWAY / SWAY_FRAMES / loads.time_step))
    sway = step * np.arange(1, SWAY_FRAMES + 1)
    frames = np.concatenate([begin - sway[::-1], slow, slow[-1] + sway])
    return np.unique(chosen), frames[(frames >= 0) & (frames < len(loads.ground))]


def _accelerations(run: ReducedRun, nodes: Index) -> Array:
    """Absolute accelerations of nodes, shape (3 n, n_t); x y z of each node."""
    records = _records(run.basis, run.history.acceleration, nodes)
    for c in range(3):
        records[c::3] += run.loads.ground[:, c]
    return records


@all_blas_threads()
def _records(basis: ReducedBasis, modal: Array, nodes: Index) -> Array:
    """Histories of nodes, shape (3 n, n_t); x y z of each node."""
    shapes = basis.of(basis.model, nodes)
    return np.asarray(shapes.reshape(-1, shapes.shape[2]) @ modal)


def membrane_force(
    parts: BuildingParts, triangles: Index, nodes: Index, displacement: Array
) -> Array:
    """N along y at the centres of horizontal triangles, shape (s, k) [N/m].

    From displacements [m], shape (s, m, 3), of their nodes, which are ascending, shape (m,).
    """
    every = np.zeros((len(displacement), len(parts.mesh.nodes), DOFS))
    every[:, nodes, :3] = displacement
    return section_forces(parts, every, triangles).centres().membrane[..., 1]
