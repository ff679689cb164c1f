"""Floor response spectra of two runs of a 3D building, point by point."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.spectra.frequency_list import SAME, interpolate_frequency, merged_frequencies
from impactfem.stages.transient.selection import QUIET
from impactfem.system.errors import Fault, InputError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STORE = "comparison.nc"
ALIKE = 0.05
"""Part of the height, length and width of a building by which another one may differ from it."""
LEAST = 20
"""Least number of frequencies that are compared, where neither run has fewer itself."""


@dataclass(frozen=True)
class Side:
    """One of the two runs.

    Args:
        response: Its `transient.nc`.
        building: Its `building.nc`.
        case_file: Name of its case file.
        folder: Its folder, as the user wrote it.
    """

    response: xr.Dataset
    building: xr.Dataset
    case_file: str
    folder: Path

    @property
    def frequency(self) -> Array:
        """Frequencies of its spectra, shape (n_f,) [Hz]."""
        return np.asarray(self.response["frequency"].values, dtype=np.float64)

    @property
    def probes(self) -> list[str]:
        """Names of its points."""
        return [str(name) for name in self.response["probe"].values]

    @property
    def element(self) -> float:
        """Mean side of its triangles [m]."""
        nodes, triangles = (self.building[n].values for n in ("node_position", "triangle_node"))
        vertices = nodes[triangles[:, :3]]
        return float(np.linalg.norm(vertices - np.roll(vertices, -1, axis=1), axis=2).mean())

    @property
    def levels(self) -> Array:
        """Heights of the mass centres of its floors, shape (n_floors,) [m]."""
        nodes, centres = (self.building[name].values for name in ("node_position", "centre"))
        return np.asarray(nodes[centres, 2], dtype=np.float64)

    @property
    def plan(self) -> Array:
        """Length and width of the box around its nodes, shape (2,) [m]."""
        nodes = self.building["node_position"].values[:, :2]
        return np.asarray(nodes.max(axis=0) - nodes.min(axis=0), dtype=np.float64)

    @property
    def shape(self) -> str:
        """Floors, height and plan in words."""
        length, width = self.plan
        count = len(self.levels)
        floors = f"{count} floor{'' if count == 1 else 's'} up to {self.levels[-1]:.4g} m"
        return f"{floors}, {length:.4g} m x {width:.4g} m in plan"


class Comparison:
    """Spectra of one run and of another one, the reference, and their difference.

        δ(f)      = |PSa(f) − PSa_other(f)| / PSa_other(f)
        δ_peak(f) = |PSa(f) − PSa_other(f)| / max PSa_other

    The first is large, too, where a spectrum is small; the second tells what matters to a design.

    Args:
        store: What `compare` makes, or the open `comparison.nc`.
    """

    def __init__(self, store: xr.Dataset) -> None:
        self.store = store
        self.highest = float(store.attrs["highest_frequency"])
        self.probes = [str(name) for name in store["probe"].values]
        self.components = [str(name) for name in store["component"].values]
        self.damping = float(store.attrs["damping"])
        self.frequency: Array = np.asarray(store["frequency"].values, dtype=np.float64)
        self.counts: Flags = store["counts"].values.astype(bool)
        self.distance: Array = np.asarray(store["distance"].values, dtype=np.float64)

    def words(self, *, other: bool = False) -> str:
        """Title, case file and folder of the run, or of the other."""
        kind = "other_" if other else ""
        title, case_file, folder = (
            self.store.attrs[f"{kind}{name}"] for name in ("title", "case_file", "folder")
        )
        return f"'{title}' ({case_file}, {folder})"

    @property
    def range(self) -> str:
        """The frequencies that are compared: how many, from where to where."""
        f = self.frequency[self.known]
        return f"{len(f)} frequencies from {f[0]:.4g} to {f[-1]:.4g} Hz"

    def spectrum(self, probe: int, component: int, *, other: bool = False) -> Array:
        """PSa of a point along an axis, shape (n_f,) [m/s2]."""
        name = "psa_other" if other else "psa"
        return np.asarray(self.store[name].values[probe, component], dtype=np.float64)

    def peaks(self, probe: int, component: int) -> tuple[float, float]:
        """Largest PSa up to the highest frequency, of the run and of the other [m/s2]."""
        both = (self.spectrum(probe, component, other=other) for other in (False, True))
        ours, theirs = (float(psa[self.known].max()) for psa in both)
        return ours, theirs

    def differences(self, *, of_peak: bool = False) -> Array:
        """δ, or δ_peak, of the spectra that count, shape (n_counts, n_f) [-].

        Args:
            of_peak: Over the peak of the spectrum up to the highest frequency.
        """
        found, reference = (self.store[n].values[self.counts] for n in ("psa", "psa_other"))
        over = reference
        if of_peak:
            over = reference[:, self.known].max(axis=1, keepdims=True)
        return np.asarray(np.abs(found - reference) / over, dtype=np.float64)

    @property
    def names(self) -> list[tuple[int, int]]:
        """Point and axis, by number, of each spectrum that counts."""
        return [(int(k), int(c)) for k, c in np.argwhere(self.counts)]

    @property
    def known(self) -> Flags:
        """Frequencies up to the highest one that is compared."""
        return np.asarray(self.frequency <= self.highest * (1.0 + SAME))

    def worst(self, *, of_peak: bool = False) -> tuple[float, int, int, float]:
        """Largest δ, or δ_peak, up to the highest frequency; its point, axis and frequency [Hz].

        Args:
            of_peak: As of `differences`.
        """
        apart = self.differences(of_peak=of_peak)[:, self.known]
        spectrum, at = np.unravel_index(int(apart.argmax()), apart.shape)
        k, c = self.names[int(spectrum)]
        return float(apart[spectrum, at]), k, c, float(self.frequency[self.known][at])


def compare(one: Side, other: Side, highest: float) -> xr.Dataset:
    """Compare the spectra of two runs of one building, at the points that both have.

    One building is one with as many floors, at the same heights, over the same plan, to `ALIKE`;
    its name, mesh, materials, damping, contacts and motion may differ. A point is one of the same
    name in both runs, at places no farther apart than the elements of the coarser mesh are long.

    Args:
        one: The run.
        other: The run that it is compared with.
        highest: Highest frequency that is compared [Hz].

    Returns:
        PSa of both by point, axis and frequency, at the first damping that both have; what counts:
        where the peak acceleration of both is more than `QUIET` of the largest one along the axis;
        elsewhere the spectrum is that of the mesh.

    Raises:
        InputError: They are of different buildings, share no point or damping, or too few
            frequencies up to the highest; or nothing moves.
    """
    _refuse_other_building(one, other)
    both = (one, other)
    apart_most = max(side.element for side in both)
    shared = [name for name in one.probes if name in other.probes]
    here, there = (side.response["probe_position"].sel(probe=shared).values for side in both)
    distance = np.linalg.norm(here - there, axis=1)
    near = distance <= apart_most
    dampings = [d for d in _damping(one) if np.isclose(d, _damping(other)).any()]
    # The widest gap depends on the damping; without one in common the fault below says so.
    frequency = common_frequencies(one.frequency, other.frequency, dampings[0] if dampings else 0.0)
    count = int(np.sum(frequency <= highest * (1.0 + SAME)))
    least = min(LEAST, *(int(np.sum(s.frequency <= highest * (1.0 + SAME))) for s in both))
    faults = []
    if not near.any():
        told = "none of its names" if not shared else f"all are {distance.min():.3g} m away or more"
        expected = (
            f"expected points of {one.folder} by name, within {apart_most:.3g} m of their "
            f"places there; found {told}"
        )
        faults.append(Fault(other.folder, "probe", None, expected))
    if not dampings:
        expected = f"expected a damping of the spectra of {one.folder}, {_percent(_damping(one))}"
        faults.append(Fault(other.folder, "damping", _percent(_damping(other)), expected))
    elif count < max(1, least):
        expected = (
            f"expected at least {max(1, least)} of the frequencies up to {highest:g} Hz known, or "
            f"near enough to interpolate, here and in {one.folder}; found {count}"
        )
        faults.append(Fault(other.folder, "frequency", None, expected))
    if faults:
        raise InputError(faults)
    damping, kept = dampings[0], [name for name, keep in zip(shared, near, strict=True) if keep]
    psa = [_psa(side, damping, kept, frequency) for side in both]
    peak = [side.response["pfa"].sel(probe=kept).values for side in both]
    counts = np.logical_and(*(p > QUIET * p.max(axis=0) for p in peak))
    if not counts.any():
        expected = f"expected a point that moves in {one.folder}, too"
        raise InputError([Fault(other.folder, "pfa", None, expected)])
    axes = ("probe", "component")
    return xr.Dataset(
        {
            "psa": ((*axes, "frequency"), psa[0], {"units": "m/s2"}),
            "psa_other": ((*axes, "frequency"), psa[1], {"units": "m/s2"}),
            "counts": (axes, counts.astype(np.int8)),
            "distance": ("probe", distance[near], {"units": "m"}),
        },
        coords={
            "probe": kept,
            "component": [str(name) for name in one.response["component"].values],
            "frequency": ("frequency", frequency, {"units": "Hz"}),
        },
        attrs={
            "damping": damping,
            "highest_frequency": highest,
            "farthest": apart_most,
            "moved": ", ".join(
                f"{name} ({d:.3g} m apart)"
                for name, d, keep in zip(shared, distance, near, strict=True)
                if not keep
            ),
            "interpolated_low": _resonance_low(one, other, frequency, damping, highest),
            **_named(one, other, "", highest),
            **_named(other, one, "other_", highest),
        },
    )


def common_frequencies(one: Array, other: Array, damping: float) -> Array:
    """Frequencies of either list at which both spectra are known, or may be interpolated.

    A spectrum may be interpolated between two neighbours f₁ < f₂ of its list with
    ln(f₂/f₁) ≤ ξ. The sharpest peak that oscillators of the damping ξ can have, that of a steady
    sine, is within 1 − 1/√(1 + ¼) = 11 % of the larger neighbour then (`resonance_low`); the peaks
    of a building, which has a damping of its own, are wider.

    Args:
        one: Of one run, ascending, shape (n,) [Hz].
        other: Of the other, ascending, shape (m,) [Hz].
        damping: ξ of the spectra [-].

    Returns:
        Ascending; may be empty [Hz].
    """
    merged = merged_frequencies(one, other)
    return np.asarray(merged[np.all([_gap(f, merged) <= damping for f in (one, other)], axis=0)])


def resonance_low(gap: float, damping: float) -> float:
    """How much lower the line between two neighbours may be than a peak between them.

    The amplitude of an oscillator of the damping ξ under a sine of its frequency times
    exp(±Δ/2), over that in resonance, is 1/√(1 + (Δ/2ξ)²) for small Δ and ξ.

    Args:
        gap: Δ = ln(f₂/f₁) [-].
        damping: ξ [-].
    """
    return 0.0 if gap == 0.0 else 1.0 - 1.0 / float(np.hypot(1.0, gap / (2.0 * damping)))


def _gap(f: Array, wanted: Array) -> Array:
    """ln(f₂/f₁) of the neighbours in f of each frequency: 0 where f has it, inf outside of f."""
    k = np.clip(np.searchsorted(f, wanted), 1, max(1, len(f) - 1))
    below, above = f[k - 1], f[np.minimum(k, len(f) - 1)]
    gap = np.where((wanted > below) & (wanted < above), np.log(above / below), np.inf)
    has = np.minimum(np.abs(wanted / below - 1.0), np.abs(wanted / above - 1.0)) <= SAME
    return np.where(has, 0.0, gap)


def _resonance_low(
    one: Side, other: Side, frequency: Array, damping: float, highest: float
) -> float:
    """Of the widest gap that was interpolated, up to the highest frequency."""
    known = frequency[frequency <= highest * (1.0 + SAME)]
    gaps = [_gap(side.frequency, known).max() for side in (one, other)]
    return resonance_low(float(max(gaps)), damping)


def _refuse_other_building(one: Side, other: Side) -> None:
    alike = len(one.levels) == len(other.levels)
    if alike:
        height = np.abs(one.levels - other.levels).max() / np.abs(one.levels).max()
        alike = max(height, *np.abs(other.plan / one.plan - 1.0)) <= ALIKE
    if not alike:
        expected = f"expected a run of the building of {one.folder}, {one.shape}; it has "
        raise InputError([Fault(other.folder, "", None, f"{expected}{other.shape}")])


def _named(side: Side, against: Side, kind: str, highest: float) -> dict[str, object]:
    """What tells a run from the other, as attributes of the store."""
    store, f = side.response, side.frequency
    return {
        f"{kind}inputs": str(store.attrs["inputs"]),
        f"{kind}title": str(store.attrs["title"]),
        f"{kind}case_file": side.case_file,
        f"{kind}folder": str(side.folder),
        f"{kind}case_hash": str(store.attrs["case_hash"]),
        f"{kind}building": str(store.attrs["building"]),
        f"{kind}shape": side.shape,
        f"{kind}element": side.element,
        f"{kind}frequencies": int(np.sum(f <= highest * (1.0 + SAME))),
        f"{kind}points": len(side.probes),
        f"{kind}alone": ", ".join(name for name in side.probes if name not in against.probes),
    }


def _damping(side: Side) -> Array:
    return np.asarray(side.response["damping"].values, dtype=np.float64)


def _percent(dampings: Array) -> str:
    return ", ".join(f"{100.0 * d:g} %" for d in dampings)


def _psa(side: Side, damping: float, probes: list[str], frequency: Array) -> Array:
    """Of the points along all axes, shape (n_probes, 3, n_f) [m/s2]."""
    psa = side.response["psa"].sel(damping=damping, method="nearest").sel(probe=probes)
    values = psa.transpose("probe", "component", "frequency").values
    return interpolate_frequency(side.frequency, values, frequency)
