"""Spectra over whole floors under the case's own motion, from `transient_maps.nc`.

The fields have every vertex of the floors, but their records are taken as they are: few samples in
a cycle of the highest frequencies. They say which vertices govern; the spectra of these are then
computed as finely as those of the probes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.stages.design.fewest import MISSED, fewest
from impactfem.stages.design.floor_points import LEVEL, FloorPoints
from impactfem.stages.design.records import Records
from impactfem.system.errors import ImpactfemError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

STILL = 1e-9
"""Along a direction a floor is still where no ordinate is above this part of the largest of all."""
LARGEST = 80
"""So many vertices of a floor with the largest ordinates, at any one frequency along any one
direction, are looked at under other motions."""


@dataclass(frozen=True, eq=False)
class WholeFloors:
    """The largest ordinates of all vertices of each floor, and which vertices have them.

    Args:
        frequency: Shape (n_f,) [Hz].
        damping: Of the oscillators [-].
        psa: Pseudo-acceleration along x, y, z, shape (n_floors, 3, n_f) [m/s2]; zero for a floor
            without a vertex.
        pfa: Peak acceleration, shape (n_floors, 3) [m/s2].
        vertices: Number of vertices of each floor, shape (n_floors,).
        points_per_cycle: Samples of the records in a cycle of the highest frequency.
        governing: The fewest vertices that come near `psa` and `pfa` (see `fewest`).
        position: Of each of them, shape (n_governing, 3) [m].
        governing_psa: Their envelope, from the same fields, shaped as `psa` [m/s2].
        governing_pfa: The same of their peak accelerations, shaped as `pfa` [m/s2].
        candidates: Those among which the governing ones of other motions are sought: these, and
            the `LARGEST` of each floor at each frequency at which not the whole floor moves alike.
    """

    frequency: Array
    damping: float
    psa: Array
    pfa: Array
    vertices: Index
    points_per_cycle: float
    governing: Records
    position: Array
    governing_psa: Array
    governing_pfa: Array
    candidates: Records


@dataclass(frozen=True, eq=False)
class _Fields:
    """The fields of `transient_maps.nc`.

    Args:
        node: Shape (n,).
        position: Shape (n, 3) [m].
        frequency: Shape (n_f,) [Hz].
        curves: Pseudo-acceleration at the frequencies, and peak acceleration as the last one, shape
            (n, 3, n_f + 1) [m/s2].
        damping: Of the oscillators [-].
        points_per_cycle: Samples in a cycle of the highest frequency.
    """

    node: Index
    position: Array
    frequency: Array
    curves: NDArray[np.float32]
    damping: float
    points_per_cycle: float


def read_whole_floors(path: Path, floors: Sequence[FloorPoints]) -> WholeFloors | None:
    """Read `transient_maps.nc`, and choose the vertices that govern.

    Args:
        path: The file.
        floors: The floors of the building.

    Returns:
        The spectra; None where the case asks for no fields, and the file is not there.

    Raises:
        ImpactfemError: The file cannot be read.
    """
    if not path.is_file():
        return None
    try:
        with xr.open_dataset(path, engine="h5netcdf") as store:
            psa = store["psa"].transpose("node", "component", "frequency").values
            pfa = store["pfa"].transpose("node", "component").values
            fields = _Fields(
                node=np.asarray(store["node_number"].values, dtype=np.int64),
                position=np.asarray(store["node_position"].values, dtype=np.float64),
                frequency=np.asarray(store["frequency"].values, dtype=np.float64),
                curves=np.concatenate([psa, pfa[..., None].astype(np.float32)], axis=2),
                damping=float(store.attrs["damping"]),
                points_per_cycle=float(store.attrs["points_per_cycle"]),
            )
    except (OSError, ValueError, KeyError) as error:
        raise ImpactfemError(f"cannot read fields over the floors from {path}: {error}") from error
    return _whole(fields, floors)


def _whole(fields: _Fields, floors: Sequence[FloorPoints]) -> WholeFloors:
    on_floor = [
        np.flatnonzero(np.abs(fields.position[:, 2] - one.elevation) <= LEVEL) for one in floors
    ]
    # The curves are of single precision in the file; all that follows is in double.
    envelope = np.stack(
        [fields.curves[there].max(axis=0, initial=0.0).astype(np.float64) for there in on_floor]
    )
    governing, candidates = [], []
    reached = np.zeros_like(envelope)
    for floor, there in enumerate(on_floor):
        for component in range(3):
            if envelope[floor, component].max() <= STILL * envelope.max():
                continue
            curves = fields.curves[there, component].astype(np.float64)
            chosen = np.array(fewest(curves), dtype=np.int64)
            reached[floor, component] = curves[chosen].max(axis=0, initial=0.0)
            governing.append(_records(floor, component, fields.node[there[chosen]]))
            looked_at = np.union1d(chosen, _largest(curves))
            candidates.append(_records(floor, component, fields.node[there[looked_at]]))
    every = Records.joined(governing)
    place = np.argsort(fields.node)
    at = place[np.searchsorted(fields.node, every.node, sorter=place)]
    return WholeFloors(
        frequency=fields.frequency,
        damping=fields.damping,
        psa=envelope[..., :-1],
        pfa=envelope[..., -1],
        vertices=np.array([len(there) for there in on_floor], dtype=np.int64),
        points_per_cycle=fields.points_per_cycle,
        governing=every,
        position=fields.position[at],
        governing_psa=reached[..., :-1],
        governing_pfa=reached[..., -1],
        candidates=Records.joined(candidates),
    )


def _records(floor: int, component: int, node: Index) -> Records:
    return Records(np.full(len(node), floor), np.full(len(node), component), node)


def _largest(curves: Array) -> Index:
    """The curves that are among the `LARGEST` anywhere, ascending.

    Places where more than so many are near the envelope ask for none: any of these curves will do.
    """
    near = curves >= (1.0 - MISSED) * curves.max(axis=0)
    told = curves[:, near.sum(axis=0) <= LARGEST]
    first = max(0, len(told) - LARGEST)
    return np.asarray(np.unique(np.argpartition(told, first, axis=0)[first:]), dtype=np.int64)
