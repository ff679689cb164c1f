"""Envelopes of the spectra over the points of each floor, and statistics over an ensemble."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from impactfem.case import Case
from impactfem.dynamics.damping import UNDAMPED, DampingLaw
from impactfem.spectra.resolved import ZPA
from impactfem.spectra.statistics import STATISTICS, over_members
from impactfem.stages.design.floors import WholeFloors, counted, enveloped, probe_points
from impactfem.stages.stores import names_of
from impactfem.system.arrays import Array, Index
from impactfem.system.quantity import results, si

_CURVE = "damping station direction frequency"
_PEAK = "damping station direction"
_PLACE = "station direction"


@dataclass(frozen=True, eq=False)
class ResolvedSpectra:
    """Spectra of n points, each along one direction."""

    psa: Array  #: pseudo-acceleration, shape (n_dampings, n, n_frequencies) [m/s2]
    zpa: Array  #: peak acceleration, shape (n,) [m/s2]
    resolved_zpa: Array  #: ZPA in the resolved band, shape (n,) [m/s2]


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """The results of the stage; on rank 0."""

    case: Case
    probes: xr.Dataset  #: of `read_probes`
    whole: WholeFloors | None  #: spectra over whole floors; None without fields over the floors
    vertices: ResolvedSpectra | None  #: of the vertices that govern; None without fields
    #: Results over an ensemble by their names in the store; empty without one.
    members: Mapping[str, Any] = field(default_factory=dict)
    analysis: str = ""  #: response spectrum analysis of the devices; "" without devices
    free_vertices: ResolvedSpectra | None = None  #: `vertices` without impact
    law: DampingLaw = UNDAMPED  #: of the building

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Frequencies up to the highest one of the 3D model, shape (n_frequencies,)."""
        highest = float(self.probes.attrs["maximum_frequency"])
        return np.asarray(self.probes["frequency"].values <= highest * (1.0 + 1e-9))


@results
class FloorEnvelopes:
    """Envelopes over the points of each floor under the case's own motion, along x, y, z."""

    point: list[str] = si("", "probe or node", dims="point")
    psa: Array = si("m/s2", "envelope of the points under the case's own motion", dims=_CURVE)
    psa_peak: Array = si("m/s2", "peak of psa, up to maximum_frequency", dims=_PEAK)
    psa_peak_frequency: Array = si("Hz", "frequency of psa_peak", dims=_PEAK)
    zpa: Array = si("m/s2", "envelope of their peak accelerations", dims=_PLACE)
    resolved_zpa: Array = si("m/s2", f"envelope of their {ZPA}", dims=_PLACE)
    #: None for the full model, which has no run without impact.
    psa_free: Array | None = si("m/s2", "envelope of the points without impact", dims=_CURVE)
    resolved_zpa_free: Array | None = si(
        "m/s2", f"envelope of their {ZPA}, without impact", dims=_PLACE
    )
    governing: Index = si("", "point with the largest ordinate, from 0", dims=_CURVE)
    probes_psa: Array = si("m/s2", "envelope of the probes alone", dims=_CURVE)
    probe_count: Index = si("", "number of probes", dims="station")
    vertex_count: Index = si("", "number of vertices that govern", dims=_PLACE)

    @classmethod
    def of(cls, study: DesignStudy) -> FloorEnvelopes:
        """Envelope the probes, and the vertices that govern if there are fields."""
        probes, whole, spectra = study.probes, study.whole, study.vertices
        free = study.free_vertices
        floors, names = probes.sizes["station"], names_of(probes, "probe")
        # Each point along one direction: the probes first, then the vertices.
        points = probe_points(probes)
        along = points["point"].to_numpy(), points["component"].to_numpy()
        psa, pfa = probes["psa"].values[:, along[0], along[1]], probes["pfa"].values[along]
        probes_psa = enveloped(points, psa, floors, axis=1)
        zpa = probes["zpa"].values[along]
        psa_free = zpa_free = None
        if "psa_free" in probes:
            psa_free = probes["psa_free"].values[:, along[0], along[1]]
            zpa_free = probes["zpa_free"].values[along]
        vertex_count = np.zeros((floors, 3), dtype=np.int64)
        if whole is not None and spectra is not None:
            number = len(names) + np.arange(len(whole.governing))
            points = pd.concat([points, whole.governing.assign(point=number)], ignore_index=True)
            psa = np.concatenate([psa, spectra.psa], axis=1)
            pfa = np.concatenate([pfa, spectra.zpa])
            zpa = np.concatenate([zpa, spectra.resolved_zpa])
            if psa_free is not None and zpa_free is not None and free is not None:
                psa_free = np.concatenate([psa_free, free.psa], axis=1)
                zpa_free = np.concatenate([zpa_free, free.resolved_zpa])
            names += [f"node {node}" for node in whole.governing["node"]]
            vertex_count = counted(whole.governing, floors)
        governing = np.zeros(probes_psa.shape, dtype=np.int64)
        for (floor, component), rows in points.groupby(["floor", "component"]).indices.items():
            largest = psa[:, rows].argmax(axis=1)
            governing[:, floor, component] = points["point"].to_numpy()[rows[largest]]
        envelope, valid = enveloped(points, psa, floors, axis=1), study.valid
        return cls(
            point=names,
            psa=envelope,
            psa_peak=envelope[..., valid].max(axis=-1),
            psa_peak_frequency=probes["frequency"].values[envelope[..., valid].argmax(axis=-1)],
            zpa=enveloped(points, pfa, floors),
            resolved_zpa=enveloped(points, zpa, floors),
            psa_free=None if psa_free is None else enveloped(points, psa_free, floors, axis=1),
            resolved_zpa_free=None if zpa_free is None else enveloped(points, zpa_free, floors),
            governing=governing,
            probes_psa=probes_psa,
            probe_count=probes["on_floor"].values.sum(axis=0),
            vertex_count=vertex_count,
        )


@results
class RotationEnvelopes:
    """Envelopes of the rotations of the probes of each floor, about x, y, z."""

    psa: Array = si(
        "rad/s2", "envelope of rotations of probes", dims="damping station rotation frequency"
    )
    pfa: Array = si("rad/s2", "envelope of their peak accelerations", dims="station rotation")
    probes: Index = si("", "1 for a probe in the envelope of the floor", dims="station probe")

    @classmethod
    def of(cls, probes: xr.Dataset) -> RotationEnvelopes:
        """Envelope the probes with recorded rotations, at least the mass centre of each floor."""
        turning = np.isin(probes["probe"], probes["turning"])
        on = probes["on_floor"].sel(probe=probes["turning"].values).values.T
        order = ("damping", "turning", "rotation", "frequency")
        psa = probes["rotational_psa"].transpose(*order).values
        pfa = probes["rotational_pfa"].transpose("turning", "rotation").values
        return cls(
            psa=np.stack([psa[:, floor].max(axis=1) for floor in on], axis=1),
            pfa=np.stack([pfa[floor].max(axis=0) for floor in on]),
            probes=(probes["on_floor"].values.T & turning).astype(np.int64),
        )


def member_statistics(study: DesignStudy) -> dict[str, Array]:
    """Return the statistics over the motions of an ensemble by their names in the store.

    The difference of the analyses of a device is nan if a motion has no force on it.
    """
    members = study.members
    found = {
        "peak": members["member_psa"][..., study.valid].max(axis=-1),
        "zpa": members["member_zpa"],
        "centre_peak": members["member_centre_peak"],
        "impact_force": largest_impact(members["member_impact_force"]),
    }
    if "member_device_force" in members:
        force, by_spectrum = members["member_device_force"], members["member_device_spectrum"]
        known = (force > 0.0).all(axis=0)
        ratio = np.divide(by_spectrum, force, out=np.full_like(force, np.nan), where=known)
        found |= {"device_force": force, "device_spectrum": by_spectrum}
        found["device_difference"] = 1.0 - ratio
    return {f"statistic_{name}": statistics(values) for name, values in found.items()}


def statistics(values: Array) -> Array:
    """Take all `STATISTICS` over the first axis, shape (n_statistics, ...).

    A lognormal fractile of values that are not all above zero is nan.
    """

    def of(column: Array) -> list[float]:
        return [
            float(over_members(column, name))
            if name != "p84_lognormal" or np.all(column > 0.0)
            else np.nan
            for name in STATISTICS
        ]

    return np.asarray(np.apply_along_axis(of, 0, values))


def largest_impact(force: Array) -> Array:
    """Largest impact force on the building, shape (n_m,) [N]; 0 without contact pairs.

    From `member_impact_force`, shape (n_m, n_edges).
    """
    return np.asarray(force.max(axis=1, initial=0.0))
