"""Fields over the floors: peak acceleration and spectra of every node, and the waves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import DOFS
from impactfem.building.parts import BuildingParts
from impactfem.building.section_forces import section_forces
from impactfem.case import Spectra
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import ModalHistory
from impactfem.reduction.probes import floor_vertices, wave_slab
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.spectra import logarithmic_frequencies, response_spectra, sampling_loss
from impactfem.system.parallel import all_blas_threads, threads

Array = NDArray[np.float64]
Index = NDArray[np.int64]

AT_ONCE = 256
AS_THEY_ARE = 2.0
"""Samples in a cycle of the highest frequency, the fewest: no more are put between those that are
there, which would take twenty times as long over all nodes."""
SNAPSHOTS = (0.0, 0.5, 1.0)
"""Times of the wave pictures, from the start to the end of the main impact."""
BEFORE, AFTER = 0.01, 0.03
"""What the frames of the wave show before and after the main impact [s]."""
MOST_FRAMES = 150


@dataclass(frozen=True, eq=False)
class FloorMaps:
    """Fields at the vertices of the floors, and waves on one floor."""

    nodes: Index  #: vertices of all floors, ascending, shape (n,)
    frequency: Array  #: of the spectra, shape (n_f,) [Hz]
    damping: float  #: of the spectra, the first of the case
    psa: NDArray[np.float32]  #: pseudo-acceleration, shape (n, 3, n_f) [m/s2]
    pfa: Array  #: peak acceleration, shape (n, 3) [m/s2]
    points_per_cycle: float  #: samples in a cycle of the highest frequency
    #: How much of a resonant peak may be lost between samples, at each frequency (see
    #: `impactfem.spectra.sampling_loss`), shape (n_f,) [-].
    sampling_loss: Array
    wave_nodes: Index  #: all nodes of the floor with the waves, ascending, shape (m,)
    wave_times: Array  #: times of the snapshots, shape (s,) [s]
    wave_displacement: Array  #: relative to the ground, shape (s, m, 3) [m]
    wave_acceleration: Array  #: absolute, same shape [m/s2]
    frame_times: Array  #: evenly spaced times about the main impact, shape (f,) [s]
    frame_acceleration: NDArray[np.float32]  #: absolute, at these times, shape (f, m, 3) [m/s2]
    #: Normal force along y of each triangle of that floor, shape (s, k) [N/m].
    membrane_force: Array
    wave_triangles: Index  #: those triangles, shape (k,)


def floor_maps(
    parts: BuildingParts,
    basis: ReducedBasis,
    history: ModalHistory,
    loads: Loads,
    spectra: Spectra,
    *,
    main_impact: tuple[float, float] | None,
    floor: int | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> FloorMaps:
    """Compute all fields.

    Args:
        parts: The building.
        basis: Its reduced basis.
        history: Modal coordinates.
        loads: The loads.
        spectra: The case's spectra; their highest frequency and first damping count.
        main_impact: Start and end of the main impact [s]; None without one.
        floor: Number of the floor with the waves; the top floor when None.
        progress: Called with the part of the work that is done.
    """
    mesh = parts.mesh
    nodes = floor_vertices(mesh)
    values = spectra.frequency_values
    frequency = logarithmic_frequencies(min(values), max(values), 66)
    damping = float(spectra.damping[0])
    psa = np.empty((len(nodes), 3, len(frequency)), dtype=np.float32)
    pfa = np.empty((len(nodes), 3))
    reached = 0.0
    for first in range(0, len(nodes), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        records = _records(basis, history.acceleration, nodes[part])
        for c in range(3):
            records[c::3] += loads.ground[:, c]
        found = response_spectra(
            records,
            loads.time_step,
            frequency,
            [damping],
            points_per_cycle=AS_THEY_ARE,
            threads=threads(),
            absolute=False,
        )
        psa[part] = found.psa[0].reshape(-1, 3, len(frequency))
        pfa[part] = found.zpa.reshape(-1, 3)
        reached = found.points_per_cycle
        progress(min(1.0, (first + AT_ONCE) / len(nodes)))
    triangles, wave_nodes = wave_slab(mesh, floor)
    steps = frames = np.zeros(0, dtype=np.int64)
    if main_impact is not None:
        start, end = main_impact
        times = [
            *(start + share * (end - start) for share in SNAPSHOTS),
            start - BEFORE,
            end + AFTER,
        ]
        nearest = np.rint(np.array(times) / loads.time_step).astype(np.int64)
        *chosen, begin, last = np.clip(nearest, 0, len(loads.ground) - 1)
        steps = np.unique(chosen)
        # Evenly spaced, and no more than MOST_FRAMES.
        frames = np.arange(begin, last + 1, -(-(last - begin + 1) // MOST_FRAMES))

    def at(modal: Array, steps: Index) -> Array:
        """Values of the nodes of the wave at time steps, shape (s, m, 3)."""
        shape = (len(wave_nodes), 3, len(steps))
        return _records(basis, modal[:, steps], wave_nodes).reshape(shape).transpose(2, 0, 1)

    displacement = at(history.displacement, steps)
    snapshots, moving = (
        at(history.acceleration, some) + loads.ground[some][:, None] for some in (steps, frames)
    )
    return FloorMaps(
        nodes=nodes,
        frequency=frequency,
        damping=damping,
        psa=psa,
        pfa=pfa,
        points_per_cycle=reached,
        sampling_loss=sampling_loss(reached * frequency[-1] / frequency),
        wave_nodes=wave_nodes,
        wave_times=np.asarray(steps * loads.time_step, dtype=np.float64),
        wave_displacement=displacement,
        wave_acceleration=snapshots,
        frame_times=np.asarray(frames * loads.time_step, dtype=np.float64),
        frame_acceleration=moving.astype(np.float32),
        membrane_force=membrane_force(parts, triangles, wave_nodes, displacement),
        wave_triangles=triangles,
    )


@all_blas_threads()
def _records(basis: ReducedBasis, modal: Array, nodes: Index) -> Array:
    """Histories of nodes, shape (3 n, n_t); x y z of each node."""
    shapes = basis.of(basis.model, nodes)
    return np.asarray(shapes.reshape(-1, shapes.shape[2]) @ modal)


def membrane_force(
    parts: BuildingParts, triangles: Index, nodes: Index, displacement: Array
) -> Array:
    """N along y at the centres of horizontal triangles, shape (s, k) [N/m].

    Args:
        parts: The building.
        triangles: Their numbers, shape (k,).
        nodes: Their nodes, ascending, shape (m,).
        displacement: Of these nodes, shape (s, m, 3) [m].
    """
    every = np.zeros((len(displacement), len(parts.mesh.nodes), DOFS))
    every[:, nodes, :3] = displacement
    return section_forces(parts, every, triangles).centres().membrane[..., 1]
