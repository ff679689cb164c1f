"""Demand on devices against their capacities: bolts, qualification spectra and ZPA.

The forces are those of the detailed analysis with the damping of the buildings themselves, and the
spectra those of the anchor without the device. Both are in the results file: a changed capacity
computes no response again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
import xarray as xr

from impactfem.case import BuildingInTime, DeviceSetup
from impactfem.case.capacities import AnchorBolts, QualificationSpectrum
from impactfem.device.bolts import (
    BoltDemand,
    BoltGroup,
    bolt_demand,
    rectangular_plate,
    round_plate,
)
from impactfem.stages.device.selection import WITH, WITHOUT, Load, loaded
from impactfem.stages.qualification import SpectrumDemand, compared
from impactfem.stages.stores import open_store, time_step
from impactfem.stages.transient.selection import resolved
from impactfem.stages.verdict import Verdict
from impactfem.system.errors import SolutionError

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Place:
    """A device at one of its anchors: its setup and its results."""

    building: BuildingInTime
    store: xr.Dataset
    setup: DeviceSetup
    name: str  #: of the device in the results file
    index: int  #: of the device in the case file

    def key(self, name: str) -> str:
        """Return the key of the case for a capacity of the device."""
        return f"devices[{self.index}].{name}"

    def load(self, impact: str) -> Load:
        """Return the response with or without impacts."""
        return Load(self.store, self.name, impact)

    def both(self, of: Callable[[str], T]) -> tuple[T, T | None]:
        """Return results with and without impacts; None if those without were not computed."""
        known = WITHOUT in self.store["impact"].values
        return of(WITH), of(WITHOUT) if known else None

    @property
    def words(self) -> str:
        """The device and its floor."""
        floor = int(self.store["anchor_floor"].sel(device=self.name))
        return f"{self.name}, floor {floor} of {self.store.attrs['building']}"


def places(building: BuildingInTime, store: xr.Dataset) -> Iterator[Place]:
    """Return the anchors of all devices of a building, in the order of the results file."""
    for index, setup in building.numbered_devices:
        count = len(setup.anchor_points)
        for number in range(1, count + 1):
            name = f"{setup.name}_{number}" if count > 1 else setup.name
            yield Place(building, store, setup, name, index)


def bolt_group(anchors: AnchorBolts, radius: float) -> BoltGroup:
    """Return the bolts of a base plate of a device with a radius [m]."""
    plate = anchors.plate
    return BoltGroup(
        position=np.array(anchors.places(radius)),
        area=anchors.area,
        plate=round_plate(radius) if plate is None else rectangular_plate(plate[0], plate[1]),
        modular_ratio=anchors.modular_ratio,
        tension=anchors.tension,
        shear=anchors.shear,
        exponent=anchors.exponent,
    )


def bolts_of(place: Place, anchors: AnchorBolts, impact: str) -> BoltDemand | None:
    """Return the demand on the bolts of a device, weight included where it is known.

    None if bolts and plate cannot balance the forces, such as bolts along one edge of the plate.
    """
    radius = float(place.store["anchor_radius"].sel(device=place.name))
    force = place.load(impact).of("force").transpose("component", "time").values
    weight = place.store["weight_force"].sel(device=place.name).values
    whole = force.astype(np.float64) + weight[:, None]
    try:
        return bolt_demand(bolt_group(anchors, radius), whole, place.store["time"].values)
    except SolutionError:
        return None


def device_verdicts(building: BuildingInTime, folder: Path) -> list[Verdict]:
    """Return the verdicts of the stage, from `device.nc` of a run's folder."""
    with open_store(folder / "device.nc") as opened:
        return verdicts_of(building, loaded(opened))


def verdicts_of(building: BuildingInTime, store: xr.Dataset) -> list[Verdict]:
    """Return the verdicts of a building, from results as in `device.nc`."""
    found: list[Verdict] = []
    for place in places(building, store):
        found += _of_bolts(place)
        spectra = {
            "required_spectrum": place.setup.required_spectrum,
            "test_spectrum": place.setup.test_spectrum,
        }
        given = {name: one for name, one in spectra.items() if one is not None}
        for name, spectrum in given.items() or [("required_spectrum", None)]:
            found.append(_of_spectrum(place, name, spectrum))
        found.append(_of_zpa(place))
    return found


def _of_bolts(place: Place) -> list[Verdict]:
    anchors = place.setup.anchors
    if anchors is None:
        pulled = place.both(lambda impact: place.load(impact).tension())
        demand, least = (
            max(one, 0.0) if one is not None and math.isfinite(one) else None for one in pulled
        )
        quantity = "tension of the most highly loaded anchor, times the number of anchors"
        key = place.key("anchors")
        none = Verdict(
            "device.anchor_tension", quantity, "N", place.words, demand, None, key, least
        )
        return [none]
    hit, quiet = place.both(lambda impact: bolts_of(place, anchors, impact))
    if hit is None:
        detail = "no equilibrium was found: check the positions of the bolts and the plate"
        quantity = "interaction of tension and shear in a bolt"
        return [
            Verdict(
                "device.anchor_interaction",
                quantity,
                "-",
                place.words,
                None,
                1.0,
                place.key("anchors"),
                detail=detail,
            )
        ]
    detail = (
        f"bolt {hit.bolt} at {hit.time:.4g} s: {1e-3 * hit.bolt_tension:.3g} kN tension, "
        f"{1e-3 * hit.bolt_shear:.3g} kN shear, critical direction {hit.direction:.0f} degrees "
        f"({hit.interaction_as_computed:.3g} in the direction of the analysis)"
    )
    if math.isnan(place.load(WITH).weight):
        detail += "; the weight of the device is not known"
    every = (
        ("interaction", "interaction of tension and shear in a bolt", "-", 1.0, detail),
        ("tension", "tension of a bolt", "N", anchors.tension, ""),
        ("shear", "shear of a bolt", "N", anchors.shear, ""),
    )
    return [
        Verdict(
            f"device.anchor_{name}",
            quantity,
            unit,
            place.words,
            getattr(hit, name),
            capacity,
            place.key("anchors"),
            None if quiet is None else getattr(quiet, name),
            detail=text,
        )
        for name, quantity, unit, capacity, text in every
    ]


def spectrum_demand(
    place: Place, impact: str, spectrum: QualificationSpectrum
) -> SpectrumDemand | None:
    """Compare the floor spectrum at a device with a qualification spectrum, as `compared`.

    It is broadened as in [device_analysis].
    """
    rules = place.building.device_analysis
    motion = place.load(impact).of("anchor_acceleration").transpose("component", "time")
    return compared(
        motion.sel(component=["x", "y", "z"]).values.astype(np.float64),
        time_step(place.store),
        spectrum,
        place.building.case.spectra,
        0.0 if rules is None else rules.broadening,
        float(resolved(place.store)["frequency"][-1]),
    )


def _of_spectrum(place: Place, name: str, spectrum: QualificationSpectrum | None) -> Verdict:
    kind = f"device.{name}"
    words = name.replace("_", " ")
    if spectrum is None:
        psa = resolved(place.store)["psa"].sel(device=place.name).isel(case=0)
        most, least = place.both(lambda impact: float(psa.sel(impact=impact).max()))
        quantity = "largest ordinate of the floor spectrum at the device"
        return Verdict(kind, quantity, "m/s2", place.words, most, None, place.key(name), least)
    quantity = f"floor spectrum at the device, against the {words}"
    hit, quiet = place.both(lambda impact: spectrum_demand(place, impact, spectrum))
    if hit is None:
        detail = "the table has no frequency in the resolved band"
        key = place.key(name)
        return Verdict(kind, quantity, "m/s2", place.words, None, None, key, detail=detail)
    detail = f"{100.0 * spectrum.damping:.3g} % damping, axis {hit.axis}"
    lacking = set("xyz") - {axis for curve in spectrum.file for axis in curve.axes}
    if lacking:
        detail += f"; not compared along {', '.join(sorted(lacking))}"
    # Without impact another frequency may govern: its ratio counts, at the capacity of the first.
    free = None if quiet is None else quiet.demand / quiet.capacity * hit.capacity
    return Verdict(
        kind,
        quantity,
        "m/s2",
        place.words,
        hit.demand,
        hit.capacity,
        place.key(name),
        free,
        frequency=hit.frequency,
        band=(hit.first, hit.last),
        detail=detail,
    )


def _of_zpa(place: Place) -> Verdict:
    """The ZPA in the resolved band, along the axis with the largest ratio."""
    zpa = place.store["zpa"].sel(device=place.name, axis=["x", "y", "z"]).isel(case=0)
    limits = place.setup.zpa_limit
    hit, free = place.both(lambda impact: zpa.sel(impact=impact).values)
    k = int((hit if limits is None else hit / np.array(limits)).argmax())
    return Verdict(
        "device.zpa",
        "zero-period acceleration at the device",
        "m/s2",
        f"{place.words}, axis {'xyz'[k]}",
        float(hit[k]),
        None if limits is None else limits[k],
        place.key("zpa_limit"),
        None if free is None else float(free[k]),
        band=(0.0, float(place.store.attrs["resolved_frequency"])),
    )
