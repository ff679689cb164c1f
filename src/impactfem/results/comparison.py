"""Floor response spectra of two runs of a 3D building beside each other, point by point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.errors import Fault, InputError
from impactfem.results.transient_view import TransientView

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STORE = "comparison.nc"
QUIET = 0.01
"""Peak acceleration over the largest one along the same axis, of both runs, up to which a point is
at rest along it: its spectrum is that of the mesh."""


class Comparison:
    """Spectra of one run beside those of another one, the reference, and their difference.

        δ(f)      = |PSa(f) − PSa_other(f)| / PSa_other(f)
        δ_peak(f) = |PSa(f) − PSa_other(f)| / max PSa_other

    The first is large, too, where a spectrum is small; the second tells what matters to a design.

    Args:
        store: What `compare` makes, or the open `comparison.nc`.
    """

    def __init__(self, store: xr.Dataset) -> None:
        self.store = store
        self.highest = float(store.attrs["highest_frequency"])
        self.title = str(store.attrs["other_title"])
        self.probes = [str(name) for name in store["probe"].values]
        self.components = [str(name) for name in store["component"].values]
        self.damping = float(store.attrs["damping"])
        self.frequency: Array = np.asarray(store["frequency"].values, dtype=np.float64)
        self.counts: Flags = store["counts"].values.astype(bool)
        self.distance: Array = np.asarray(store["distance"].values, dtype=np.float64)

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
        return np.asarray(self.frequency <= self.highest * (1.0 + 1e-9))

    def worst(self, *, of_peak: bool = False) -> tuple[float, int, int, float]:
        """Largest δ, or δ_peak, up to the highest frequency; its point, axis and frequency [Hz].

        Args:
            of_peak: As of `differences`.
        """
        apart = self.differences(of_peak=of_peak)[:, self.known]
        spectrum, at = np.unravel_index(int(apart.argmax()), apart.shape)
        k, c = self.names[int(spectrum)]
        return float(apart[spectrum, at]), k, c, float(self.frequency[self.known][at])


def compare(
    one: TransientView, other: TransientView, files: tuple[Path, Path], highest: float
) -> xr.Dataset:
    """Put the spectra of two runs beside each other, at the points that both have.

    Args:
        one: The run.
        other: The run that it is compared with.
        files: Their stores, for messages.
        highest: Highest frequency that is compared [Hz].

    Returns:
        PSa of both by point, axis and frequency, at the first damping that both have; what counts:
        where the peak acceleration of both is more than `QUIET` of the largest one along the axis.

    Raises:
        InputError: They share no point, damping or frequency up to the highest, or nothing moves.
    """
    probes = [name for name in one.names if name in other.names]
    dampings = [d for d in _damping(one) if np.isclose(d, _damping(other)).any()]
    shared = [bool(np.isclose(other.frequency, f, rtol=1e-9).any()) for f in one.frequency]
    frequency = one.frequency[shared]
    faults = [
        Fault(files[0], key, None, f"expected {what} that {files[1]} has, too")
        for key, what, found in (
            ("probe", "names of points", probes),
            ("damping", "a damping of the spectra", dampings),
            ("frequency", f"frequencies up to {highest:g} Hz", frequency[frequency <= highest]),
        )
        if not len(found)
    ]
    if faults:
        raise InputError(faults)
    damping, both = dampings[0], (one, other)
    places = [[view.names.index(name) for name in probes] for view in both]
    psa = [_psa(view, damping, places[k], frequency) for k, view in enumerate(both)]
    peak = [view.store["pfa"].values[places[k]] for k, view in enumerate(both)]
    counts = np.logical_and(*(p > QUIET * p.max(axis=0) for p in peak))
    if not counts.any():
        expected = f"expected a point that moves in {files[1]}, too"
        raise InputError([Fault(files[0], "pfa", None, expected)])
    apart = one.position[places[0]] - other.position[places[1]]
    axes = ("probe", "component")
    return xr.Dataset(
        {
            "psa": ((*axes, "frequency"), psa[0], {"units": "m/s2"}),
            "psa_other": ((*axes, "frequency"), psa[1], {"units": "m/s2"}),
            "counts": (axes, counts.astype(np.int8)),
            "distance": ("probe", np.linalg.norm(apart, axis=1), {"units": "m"}),
        },
        coords={
            "probe": probes,
            "component": [str(name) for name in one.store["component"].values],
            "frequency": ("frequency", frequency, {"units": "Hz"}),
        },
        attrs={
            "damping": damping,
            "highest_frequency": highest,
            "inputs": str(one.store.attrs["inputs"]),
            "other_inputs": str(other.store.attrs["inputs"]),
            "other_title": str(other.store.attrs["title"]),
            "other_case_hash": str(other.store.attrs["case_hash"]),
        },
    )


def _damping(view: TransientView) -> Array:
    return np.asarray(view.store["damping"].values, dtype=np.float64)


def _psa(view: TransientView, damping: float, probes: list[int], frequency: Array) -> Array:
    """Of the points along all axes, shape (n_probes, 3, n_f) [m/s2]."""
    row = int(np.abs(_damping(view) - damping).argmin())
    columns = [int(np.abs(view.frequency - f).argmin()) for f in frequency]
    return np.asarray(view.store["psa"].values[row][probes][..., columns], dtype=np.float64)
