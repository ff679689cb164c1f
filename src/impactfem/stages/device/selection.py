"""What figures, tables and checks select from `device.nc`: loads, analyses, modes and names."""

import math
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case.damping import OWN
from impactfem.device.anchor_force import ring_tension
from impactfem.stages.stores import names_of
from impactfem.system.arrays import Array

WITHOUT, WITH = "without", "with"
"""Labels of the dimension `impact`."""
LOADS = {WITHOUT: "without impact", WITH: "with impacts"}
IN_NAMES = {WITHOUT: "no_impact", WITH: "impact"}
"""The same in the names of scalars."""
DETAILED = "detailed"
"""Analysis of the equipment in the 3D model, over time; the others are by response spectra."""
LABELS = ("combination", "rigid", "source", "supports")
"""Labels of the analyses, in texts."""
FLAGS = ROTATIONS, BROADENED = ("rotations", "broadened")
"""Labels of the analyses that are true or false."""
GUPTA, LINDLEY_YOW = "gupta", "lindley-yow"
RIGID = {GUPTA: "Gupta", LINDLEY_YOW: "Lindley-Yow"}
"""Methods of the rigid part of the modes."""
RIGID_WORDS = {"none": "no rigid part"} | {
    key: f"rigid part by {who}" for key, who in RIGID.items()
}
INPUTS = {
    ("source", "computed"): "computed spectra",
    ("source", "envelope"): "envelope with further points",
    ("source", "envelope-dampings"): "envelope over all dampings",
    ("source", "given"): "given spectra",
    ("supports", "srss"): "supports by root of squares",
    ("supports", "abs"): "supports by absolute sum",
    ("supports", "algebraic"): "supports in step",
    ("supports", "envelope"): "supports in step by their envelope",
}
"""Inputs of an analysis in words, by label and value."""
ALL = "All devices"
"""Section of the report."""
MOVES = 1e-6
"""A mode moves along an axis that has more than this part of the mass of all modes along it."""


def loaded(store: xr.Dataset) -> xr.Dataset:
    """The store with all but its histories in memory: single values are selected often."""
    for name, variable in store.variables.items():
        if "time" not in variable.dims:
            store[name].load()
    return store


def direction(store: xr.Dataset) -> str:
    """The direction that is shown: "x", "y" or "z"."""
    return str(store.attrs["shown_direction"])


def headline(store: xr.Dataset) -> str:
    """The response spectrum analysis as the paper does it."""
    return str(store.attrs["headline"])


def scalar_start(store: xr.Dataset, device: str) -> str:
    """How the names of a device's scalars begin; published values have the same names."""
    return "device" if device == names_of(store, "device")[0] else f"device.{device}"


@dataclass(frozen=True, eq=False)
class Load:
    """A device with one damping of the buildings, without or with impacts.

    Forces are those on the floor along the direction that is shown, where nothing else is said.
    """

    store: xr.Dataset
    device: str
    impact: str
    case: str = OWN

    def of(self, name: str, **labels: Any) -> xr.DataArray:
        """A variable of the store under this load."""
        at = {"device": self.device, "impact": self.impact, "case": self.case}
        return self.store[name].sel(at | labels)

    def scalar(self, quantity: str) -> str:
        """Name of a scalar, such as of "fy.detailed"."""
        end = "" if self.case == OWN else f".{self.case}"
        return f"{scalar_start(self.store, self.device)}.{quantity}.{IN_NAMES[self.impact]}{end}"

    def components(self, analysis: str = DETAILED) -> xr.DataArray:
        """Largest force or moment by component [N, N m]; nan if not computed."""
        return self.of("peak_force", analysis=analysis)

    @property
    def detailed(self) -> float:
        """Largest force of the detailed analysis [N]."""
        return self.by_spectrum(DETAILED)

    def by_spectrum(self, analysis: str = "") -> float:
        """Largest force by an analysis, by default the headline [N]; nan if not computed."""
        found = self.components(analysis or headline(self.store))
        return float(found.sel(component=direction(self.store)))

    def was_done(self, analysis: str) -> bool:
        """Whether an analysis was done: not all devices have envelopes or given spectra."""
        return math.isfinite(self.by_spectrum(analysis))

    def difference(self, analysis: str = "") -> float | None:
        """(detailed - RSA) / detailed by an analysis, by default the headline [-].

        Positive if RSA is too low; None if nothing moves the device or it was not computed.
        """
        found = float(self.of("relative_difference", analysis=analysis or headline(self.store)))
        return found if math.isfinite(found) else None

    @property
    def weight(self) -> float:
        """Its weight at this anchor [N]; nan where it is not known."""
        return float(self.store["weight"].sel(device=self.device))

    def uplift(self, analysis: str = DETAILED) -> float:
        """Largest force upward less the weight [N]; nan where that is not known."""
        return float(self.of("net_uplift", analysis=analysis))

    def tension(self, analysis: str = DETAILED) -> float:
        """Net tension: n times the pull of the most loaded of n anchors on a circle [N].

        Nan where the weight is not known. By response spectrum analysis with all largest values at
        one instant.
        """
        return float(self.of("net_tension", analysis=analysis))

    def pull(self) -> float:
        """The same as of a device without weight [N], known also where no weight is given."""
        force = self.of("force").transpose("component", "time").values.astype(np.float64)
        radius = float(self.store["anchor_radius"].sel(device=self.device))
        return float(ring_tension(force, radius).max())

    def moment(self) -> tuple[str, float] | None:
        """The overturning moment by name, and by how much RSA, the headline, is low there [-].

        None where the forces that are shown are vertical, or nothing turns the device over.
        """
        axis = {"x": "y", "y": "x"}.get(direction(self.store), "")
        if not axis:
            return None
        by = self.components(headline(self.store)).sel(component=f"r{axis}")
        whole = float(self.components().sel(component=f"r{axis}"))
        return (f"M{axis}", 1.0 - float(by) / whole) if whole > 0.0 else None

    @property
    def history(self) -> xr.DataArray:
        """Force over time [N]."""
        return self.of("force", component=direction(self.store)).astype(np.float64)

    @property
    def psa(self) -> xr.DataArray:
        """Pseudo-acceleration of the anchor by the device's first damping [m/s2]."""
        return self.of("psa", axis=direction(self.store))

    @property
    def ordinates(self) -> xr.DataArray:
        """Pseudo-accelerations of the anchor at the device's modes and their dampings.

        By component and mode [m/s2, rad/s2]; nan where a component is no input.
        """
        return self.of("mode_psa").sel(mode=modes_of(self.store, self.device)["mode"])


def loads_of(store: xr.Dataset) -> list[Load]:
    """All loads: device by device, in it damping by damping, without and with impacts."""
    every = product(names_of(store, "device"), names_of(store, "case"), LOADS)
    return [Load(store, device, impact, case) for device, case, impact in every]


def variant(store: xr.Dataset, *flags: str, **labels: str) -> str | None:
    """Return the analysis that differs from the headline by these labels alone; None if none does.

    Args:
        store: The results.
        flags: Labels that are true: `ROTATIONS`, `BROADENED`.
        labels: Other labels with their values: `rigid="gupta"`.
    """
    names, wanted = names_of(store, "analysis"), dict.fromkeys(flags, True) | labels
    own, same = names.index(headline(store)), np.ones(len(names), dtype=bool)
    for label in (*LABELS, *FLAGS):
        values = store[label].values
        same &= values == wanted.get(label, values[own])
    return next((name for name, one in zip(names, same, strict=True) if one), None)


def rigid_variants(store: xr.Dataset) -> dict[str, str]:
    """Return the analyses that differ from the headline by the rigid part: method and name.

    Of these as well where the headline has one itself: "none" without any.
    """
    found = {method: variant(store, rigid=method) for method in ("none", *RIGID)}
    return {key: name for key, name in found.items() if name not in (None, headline(store))}


def input_variants(store: xr.Dataset, device: str) -> dict[str, str]:
    """Return the headline and the analyses of a device that differ from it by their input.

    Returns:
        By what they are in words: their names.
    """
    words = {variant(store, **{label: value}): text for (label, value), text in INPUTS.items()}
    load = Load(store, device, WITH)
    names = [headline(store), *names_of(store, "analysis")]
    return {words[name]: name for name in names if name in words and load.was_done(name)}


def modes_of(store: xr.Dataset, device: str) -> xr.Dataset:
    """Frequency, damping and effective masses of the modes of a device."""
    one = store[["mode_frequency", "mode_damping", "effective_mass"]].sel(device=device)
    return one.isel(mode=np.isfinite(one["mode_frequency"].values))


def shown_modes(store: xr.Dataset, device: str, axis: str | None = None) -> xr.Dataset:
    """Those of them that carry mass along an axis; along the shown direction when None."""
    modes = modes_of(store, device)
    mass = modes["effective_mass"].sel(component=axis or direction(store))
    return modes.isel(mode=(mass > MOVES * mass.sum()).values)


def anchor_of(store: xr.Dataset, device: str) -> tuple[Array, int, int]:
    """Position of the anchor (3,) [m], number of its floor, number of its nodes."""
    one = store[["anchor_position", "anchor_floor", "anchor_nodes"]].sel(device=device)
    return one["anchor_position"].values, int(one["anchor_floor"]), int(one["anchor_nodes"])


def restitution(store: xr.Dataset, case: str) -> tuple[float | None, str]:
    """Restitution of the impacts and where it comes from; None where contact laws keep theirs."""
    epsilon = float(store["epsilon"].sel(case=case))
    if not math.isfinite(epsilon):
        return None, "contact laws"
    return epsilon, "calibrated" if bool(store["epsilon_calibrated"].sel(case=case)) else "given"
