"""Points of the floors of the 3D building: the probes, and the vertices that govern.

The probes of a floor are those that are level with its mass centre. Where `transient_maps.nc` has
fields over the floors, every vertex of them is there, but with records as they are: few samples in
a cycle of the highest frequencies. The fields say which vertices govern; the spectra of these are
then computed as finely as those of the probes.

Points, each along one direction, are rows of a table with the columns `floor` (place of the floor
from the lowest), `component` (0, 1 or 2 for x, y, z) and `node`;
those of vertices have their coordinates `x`, `y`, `z` [m], too.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from impactfem.stages.stores import open_store
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError
from impactfem.system.quantity import results, si

_PLACE = "station direction"
_WHOLE = "station direction whole_frequency"
LEVEL = 0.05
"""How far from its mass centre's level a point of a floor may be [m]."""
STILL = 1e-9
"""Along a direction a floor is still where no ordinate is above this part of the largest of all."""
LARGEST = 80
"""So many vertices of a floor with the largest ordinates, at any one frequency along any one
direction, are computed under other motions."""
MISSED = 0.02
"""Part of the envelope of all that the envelope of the chosen ones may lack anywhere."""
MOST = 24
"""The most that are chosen, of one floor along one direction."""
NO_POINTS = pd.DataFrame(
    {name: np.zeros(0, np.int64) for name in ("floor", "component", "node")}
    | {axis: np.zeros(0) for axis in "xyz"}
)


def read_probes(path: Path) -> xr.Dataset:
    """Read spectra of the probes under the case's own motion from `transient.nc`, and their floors.

    `psa`, `pfa` and `zpa`, and those without impact and of rotations if there are some, with the
    labels of the store; over `station`, the floors from the lowest, `station_floor`, `elevation`
    [m] and `centre`, the place of the probe at the mass centre; and `on_floor` over `probe` and
    `station`.
    ImpactfemError: the file cannot be read, is no such store, or has no probe at a mass centre.
    """
    with open_store(path) as store:
        try:
            further = ("psa_free", "zpa_free", "rotational_psa", "rotational_pfa")
            known = [name for name in further if name in store]
            probes = store[["psa", "pfa", "zpa", "probe_node", "probe_position", *known]].load()
            height = probes["probe_position"].sel(xyz="z").values
            centres = np.flatnonzero(probes["probe_kind"] == "centre")
            floors = probes["probe_floor"].values
            probes = probes.transpose("damping", "probe", "component", "frequency", ...)
        except KeyError as error:
            raise ImpactfemError(f"{path} holds no spectra of probes: {error.args[0]}") from error
        except (OSError, ValueError) as error:
            raise ImpactfemError(f"cannot read spectra of probes from {path}: {error}") from error
    if not centres.size:
        raise ImpactfemError("no probe at the mass centre of a floor")
    centres = centres[np.argsort(height[centres])]
    level = np.abs(height[:, None] - height[centres]) <= LEVEL
    return probes.assign(
        on_floor=(("probe", "station"), level),
        centre=("station", centres),
        station_floor=("station", floors[centres]),
        elevation=("station", height[centres]),
    )


def probe_points(probes: xr.Dataset) -> pd.DataFrame:
    """List the probes of the floors along x, y and z; `point` is the place among all probes."""
    floor, probe = np.nonzero(probes["on_floor"].values.T)
    return pd.DataFrame(
        {
            "floor": floor.repeat(3),
            "component": np.tile(np.arange(3), len(probe)),
            "node": probes["probe_node"].values[probe].repeat(3),
            "point": probe.repeat(3),
        }
    )


def enveloped(points: pd.DataFrame, values: Array, floors: int, axis: int = 0) -> Array:
    """Envelope values over the points of each floor along each direction.

    The values are not negative, with the points along `axis`, which axes of the floors and of
    x, y, z replace.
    """
    values = np.moveaxis(values, axis, 0)
    found = np.zeros((floors, 3, *values.shape[1:]))
    np.maximum.at(found, (points["floor"].to_numpy(), points["component"].to_numpy()), values)
    return np.moveaxis(found, (0, 1), (axis, axis + 1))


def counted(points: pd.DataFrame, floors: int) -> Index:
    """Count the points of each floor along x, y, z, shape (n_floors, 3)."""
    places = 3 * points["floor"].to_numpy() + points["component"].to_numpy()
    return np.bincount(places, minlength=3 * floors).reshape(floors, 3)


def fewest(curves: Array, *, missed: float = MISSED, most: int = MOST) -> list[int]:
    """Choose curves until their envelope is near that of all curves everywhere.

    A greedy choice: next is the curve that comes near the envelope e_j = max_i c_ij at most of the
    places j that no chosen one comes near to, near meaning c_ij ≥ (1 − m) e_j. The fewest in the
    strict sense take a search that grows exponentially; the greedy choice has at most about
    1 + ln n times as many for n places (V. Chvátal, Math. Oper. Res. 4 (1979) 233-235).

    Args:
        curves: c, not negative, shape (n_curves, n_places).
        missed: m.
        most: The most curves.

    Returns:
        Their numbers, in the order of the choice; places where all curves are zero ask for none.
    """
    envelope = curves.max(axis=0, initial=0.0)
    near = (curves >= (1.0 - missed) * envelope) & (envelope > 0.0)
    open_places = envelope > 0.0
    chosen: list[int] = []
    while open_places.any() and len(chosen) < most:
        chosen.append(int(np.argmax(near[:, open_places].sum(axis=1))))
        open_places &= ~near[chosen[-1]]
    return chosen


@results
class WholeFloors:
    """Envelopes over all vertices of each floor along x, y, z; zero for a floor without a vertex.

    `reached_` names the same of the vertices that govern alone.
    """

    frequency: Array = si("Hz", dims="whole_frequency", name="whole_frequency")
    damping: float = si("-", "of the oscillators of the fields", name="whole_damping")
    points_per_cycle: float  #: samples of the records in a cycle of the highest frequency
    whole_psa: Array = si("m/s2", "envelope of all vertices", dims=_WHOLE)
    whole_zpa: Array = si("m/s2", "envelope of all vertices", dims=_PLACE)
    reached_psa: Array = si("m/s2", "envelope of the vertices that govern", dims=_WHOLE)
    reached_zpa: Array = si("m/s2", "envelope of the vertices that govern", dims=_PLACE)
    vertices: Index = si("", "number of vertices", dims="station")
    governing: pd.DataFrame  #: the fewest vertices that come near the envelope (see `fewest`)
    #: Those among which the governing ones of other motions are sought: these, and the `LARGEST` of
    #: each floor at each frequency at which not the whole floor moves alike.
    candidates: pd.DataFrame


def read_whole_floors(path: Path, elevation: Array) -> WholeFloors | None:
    """Read the fields over the floors in `transient_maps.nc`, and choose the vertices that govern.

    None without the file, where the case requests no fields. `elevation` is that of the floors from
    the lowest, shape (n_floors,) [m]. ImpactfemError where the file cannot be read.
    """
    if not path.is_file():
        return None
    with open_store(path) as store:
        try:
            psa = store["psa"].transpose("node", "component", "frequency").values
            pfa = store["pfa"].transpose("node", "component").values
            node, position = store["node_number"].values, store["node_position"].values
            frequency = np.asarray(store["frequency"].values, dtype=np.float64)
            damping, samples = (float(store.attrs[k]) for k in ("damping", "points_per_cycle"))
        except (OSError, ValueError, KeyError) as error:
            raise ImpactfemError(
                f"cannot read fields over the floors from {path}: {error}"
            ) from error
    # Of single precision, as in the file, where all vertices are held; double for each floor.
    curves = np.concatenate([psa, pfa[..., None].astype(np.float32)], axis=2)
    on_floor = [np.flatnonzero(np.abs(position[:, 2] - z) <= LEVEL) for z in elevation]
    envelope = np.array([curves[there].max(axis=0, initial=0.0) for there in on_floor], np.float64)
    reached = np.zeros_like(envelope)
    governing, candidates = [NO_POINTS], [NO_POINTS]
    for floor, component in np.ndindex(*envelope.shape[:2]):
        if envelope[floor, component].max() <= STILL * envelope.max():
            continue
        there = on_floor[floor]
        here = curves[there, component].astype(np.float64)
        chosen = fewest(here)
        reached[floor, component] = here[chosen].max(axis=0, initial=0.0)
        # Where more than LARGEST vertices are near the envelope, any of them will do.
        near = here >= (1.0 - MISSED) * here.max(axis=0)
        open_places = here[:, near.sum(axis=0) <= LARGEST]
        first = max(0, len(here) - LARGEST)
        largest = np.argpartition(open_places, first, axis=0)[first:]
        for rows, table in ((chosen, governing), (np.union1d(chosen, largest), candidates)):
            at = there[np.asarray(rows, dtype=np.int64)]
            place = {"floor": floor, "component": component, "node": node[at]}
            table.append(pd.DataFrame(place | dict(zip("xyz", position[at].T, strict=True))))
    return WholeFloors(
        frequency=frequency,
        damping=damping,
        points_per_cycle=samples,
        whole_psa=envelope[..., :-1],
        whole_zpa=envelope[..., -1],
        reached_psa=reached[..., :-1],
        reached_zpa=reached[..., -1],
        vertices=np.array([len(there) for there in on_floor], dtype=np.int64),
        governing=pd.concat(governing, ignore_index=True),
        candidates=pd.concat(candidates, ignore_index=True),
    )
