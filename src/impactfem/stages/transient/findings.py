"""Findings on the response of the 3D building: floors, edges, transfer functions, waves.

They are read from the content of `transient.nc` and `pounding.nc`, and stored in `transient.nc`.
A finding that does not exist in a run, such as the crossing time without an impact, is nan, or has
no variable.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from impactfem.dynamics.damping import DampingLaw
from impactfem.stages.results import outputs, scalars, value, values
from impactfem.stages.stores import time_step
from impactfem.stages.transient.physics import (
    crossing_time,
    far_highest_below,
    force_spectra,
    line_arrivals,
    longest_above,
)
from impactfem.stages.transient.selection import (
    at_floor,
    floors_of,
    inward,
    known,
    main_impact,
    main_side,
    of_kind,
    of_pounding,
    pounded,
    resolved,
    shown,
    struck,
    transfer,
    wave_floor,
)
from impactfem.system.quantity import results, si
from impactfem.system.scalar import Scalar

IMPACT_CONTENT = 100.0
"""End of the main content of the main impacts (paper, section 4.3.2) [Hz]."""


@results
class LargestOrdinate:
    """Largest ordinate of the floor spectra in the resolved band, first damping."""

    psa: float = si("m/s2", "largest ordinate in the resolved band", name="largest_psa")
    frequency: float = si("Hz", "frequency of largest_psa", name="largest_psa_frequency")
    floor: int = si("", "floor of largest_psa", name="largest_psa_floor")
    direction: str = si("", "direction of largest_psa", name="largest_psa_direction")
    damping_ratio: float = si(
        "-", "damping ratio of the building at this frequency", name="largest_psa_damping"
    )
    resolved_frequency: float = si("Hz", "end of the resolved band")

    @classmethod
    def values(
        cls, store: xr.Dataset, floor: str, direction: str, law: DampingLaw
    ) -> dict[str, Any]:
        """Return its values from `psa` of a store, with the names of the labels of the place.

        The law of damping is that of the building.
        """
        psa = resolved(store)["psa"].isel(damping=0)
        if not psa.size:
            return {}
        at = psa.isel(psa.argmax(...))
        frequency = float(at["frequency"])
        place = frequency, int(at[floor]), str(at[direction].item()), float(law.ratio(frequency))
        return value(cls(float(at), *place, float(store.attrs["resolved_frequency"])))


@results
class Findings:
    """Comparison of floors, of points along the line, of edges and of forces; waves."""

    peak_over_sticks: float = si("-", "spectral peak, floor with the line, 3D model / sticks")
    peak_frequency_over_sticks: float = si("-", "frequency of this peak, 3D model / sticks")
    far_highest_below: float = si(
        "Hz", "frequency below which the far half of the line is higher than the near half"
    )
    near_highest_at: float = si("Hz", "frequency of the spectral peak at the impact edge")
    displacement_spread: float = si(
        "-", "largest difference of displacement spectra along the line, over the largest"
    )
    displacement_spread_floor: float = si(
        "-", "largest difference of displacement spectra on the floor, over the largest"
    )
    edges_over_inside: float = si(
        "-", "peak acceleration, lower of both ends of the line / highest between them"
    )
    far_over_near: float = si("-", "peak acceleration, end far from the impact / impact edge")
    exceeding_floor: int = si("", "floor of the lower of two impact edges")
    exceeded_floor: int = si("", "floor of the upper one")
    exceeds_from: float = si(
        "Hz", "lower end of the widest interval in which the lower edge has the higher spectrum"
    )
    exceeds_to: float = si("Hz", "upper end of this interval")
    psd_ratio: float = si(
        "-", "power spectral density of the main impacts, upper / lower floor, mean up to 100 Hz"
    )
    wave_crossing: float = si("s", "crossing time, by the slope of the arrivals of the peak")
    measured_wave_speed: float = si("m/s", "speed by wave_crossing")
    wave_crossing_half: float = si("s", "crossing time, by the arrivals of half of the peak")
    measured_wave_speed_half: float = si("m/s", "speed by wave_crossing_half")
    wave_far_edge: float = si("s", "time from the peak at the impact edge to that at the far edge")
    wave_reversal: float = si(
        "s", "time from the peak at the impact edge to the largest opposite acceleration there"
    )


@results
class TransferPeak:
    """Largest acceleration over force at the edge on which the force acts."""

    floor: int = si("", "floor of the edge")
    largest: float = si("1/kg", "largest acceleration / force", name="peak")
    frequency: float = si("Hz", "frequency of this peak", name="peak_frequency")
    below_100hz: float = si(
        "1/kg", "largest acceleration / force up to 100 Hz", name="peak_to_100hz"
    )


FINDINGS = {
    **outputs(LargestOrdinate),
    **outputs(Findings),
    **outputs(TransferPeak, "transfer_floor", "transfer_"),
}


def findings(store: xr.Dataset, sticks: xr.Dataset, law: DampingLaw) -> dict[str, Any]:
    """Return the values of `FINDINGS` from the contents of `transient.nc` and `pounding.nc`.

    The law of damping is that of the building.
    """
    response = shown(store)
    peaks = list(_transfer_peaks(response))
    return {
        **LargestOrdinate.values(of_kind(store, "centre"), "probe_floor", "component", law),
        **_over_sticks(response, sticks),
        **_along_line(response),
        **_between_edges(response),
        **_psd_ratio(response),
        **_wave(response),
        **(values(TransferPeak, peaks, "transfer_") if peaks else {}),
    }


def _over_sticks(response: xr.Dataset, sticks: xr.Dataset) -> dict[str, Any]:
    """Compare with the sticks, unless another model pounds, or they lack this floor."""
    other = of_pounding(sticks, "psa", response)
    if other is None or pounded(sticks, response) != "sticks":
        return {}
    ours = at_floor(known(response), "centre", wave_floor(response))["psa"]
    theirs = other.isel(frequency=(other["frequency"] <= _highest(response)).values)
    peak, stick_peak = ours.isel(ours.argmax(...)), theirs.isel(theirs.argmax(...))
    frequency, stick_frequency = float(peak["frequency"]), float(stick_peak["frequency"])
    return {
        "peak_over_sticks": float(peak) / float(stick_peak),
        "peak_frequency_over_sticks": frequency / stick_frequency,
    }


def _highest(response: xr.Dataset) -> float:
    """Highest frequency for which the model is valid, with an allowance for rounding [Hz]."""
    return float(response.attrs["maximum_frequency"]) * (1.0 + 1e-9)


def _along_line(response: xr.Dataset) -> dict[str, Any]:
    """Compare the points of the line, at least three."""
    line = of_kind(known(response), "line")
    if line.sizes["probe"] < 3:
        return {}
    z = response["probe_position"].sel(xyz="z")
    level = float(line["probe_position"].sel(xyz="z")[0])
    on_floor = known(response).isel(probe=(abs(z - level) < 1e-6 * max(1.0, abs(level))).values)
    frequency, distance, pfa = (line[n].values for n in ("frequency", "distance", "pfa"))
    psa = line["psa"].transpose("probe", "frequency").values
    middle, slack = 0.5 * distance[-1], 1e-6 * distance[-1]
    near = psa[distance < middle - slack].max(axis=0)
    far = psa[distance > middle + slack].max(axis=0)
    # Largest difference of displacement spectra over the largest of all.
    spread, spread_floor = (
        float((sd.max("probe") - sd.min("probe")).max() / sd.max())
        for sd in (line["sd"], on_floor["sd"])
    )
    return {
        "far_highest_below": _number(far_highest_below(near, far, frequency)),
        "near_highest_at": float(frequency[int(np.argmax(psa[0]))]),
        "displacement_spread": spread,
        "displacement_spread_floor": spread_floor,
        "edges_over_inside": float(min(pfa[0], pfa[-1]) / pfa[1:-1].max()),
        "far_over_near": float(pfa[-1] / pfa[0]),
    }


def _between_edges(response: xr.Dataset) -> dict[str, Any]:
    """Compare the impact edge of the floor with the line and the edge below it."""
    floors = [f for f in floors_of(response, "edge") if f <= wave_floor(response)]
    if len(floors) < 2:
        return {}
    lower, upper = floors[-2:]
    good = known(response)
    below, above = (at_floor(good, "edge", floor)["psa"].values for floor in (lower, upper))
    ends = longest_above(below, above, good["frequency"].values) or (math.nan, math.nan)
    names = ("exceeding_floor", "exceeded_floor", "exceeds_from", "exceeds_to")
    return dict(zip(names, (lower, upper, *ends), strict=True))


def _transfer_peaks(response: xr.Dataset) -> Iterator[TransferPeak]:
    """Find the peak of the transfer function at each loaded edge with a probe."""
    floors = response["transfer_load_floor"].values if "transfer_load" in response.dims else ()
    for floor in dict.fromkeys(floors):
        if floor not in floors_of(response, "edge"):
            continue
        size, _ = transfer(at_floor(response, "edge", floor), floor)
        size = size.sel(transfer_frequency=slice(None, _highest(response)))
        low = size.sel(transfer_frequency=slice(None, IMPACT_CONTENT))
        yield TransferPeak(int(floor), float(size.max()), float(size.idxmax()), float(low.max()))


def _psd_ratio(response: xr.Dataset) -> dict[str, Any]:
    """Compare the main impacts on the two upper struck floors of a side."""
    side = main_side(response)
    if side.sizes["edge"] < 2:
        return {}
    force = side["impact_force"].isel(edge=[-2, -1]).transpose("time", "edge")
    spectra = force_spectra(force.values, time_step(response))
    below, above = spectra.density[:, spectra.frequency <= IMPACT_CONTENT].mean(axis=1)
    return {"psd_ratio": float(above / below) if below > 0.0 else math.nan}


def _wave(response: xr.Dataset) -> dict[str, Any]:
    """Follow the wave of the main impact along the line."""
    arrivals, impact = line_arrivals(response), main_impact(response)
    if arrivals is None or impact is None:
        return {}
    line = of_kind(response, "line")
    distance = line["distance"].values
    first, last = (float(one) for one in arrivals.peak[[0, -1]])
    reversal = math.nan
    if math.isfinite(first):
        start, end = impact
        time = response["time"].values
        after = (time > first) & (time <= end + max(end - start, time_step(response)))
        pushed = inward(response) * line["acceleration"].isel(probe=0).values[after]
        if pushed.min(initial=0.0) < 0.0:
            reversal = float(time[after][np.argmin(pushed)] - first)
    by_peak = _number(crossing_time(distance, arrivals.peak))
    by_half = _number(crossing_time(distance, arrivals.half))
    return {
        "wave_crossing": by_peak,
        "measured_wave_speed": float(distance[-1]) / by_peak,
        "wave_crossing_half": by_half,
        "measured_wave_speed_half": float(distance[-1]) / by_half,
        "wave_far_edge": last - first if last > first else math.nan,
        "wave_reversal": reversal,
    }


def _number(result: float | None) -> float:
    return math.nan if result is None else result


def transient_scalars(store: xr.Dataset) -> list[Scalar]:
    """Select the scalars of the stage: floors at the first damping, along the shown direction."""
    response = shown(store)
    centres, edges = (
        of_kind(response, kind).swap_dims(probe="probe_floor") for kind in ("centre", "edge")
    )
    hit = edges.sel(probe_floor=np.isin(edges["probe_floor"], struck(response)["edge_floor"]))
    return [
        *scalars(store, "transient.{variable}", "basis_vectors wave_speed"),
        *scalars(store, "transient.frs.{variable}", "largest=largest_psa resolved_frequency"),
        *scalars(
            centres,
            "transient.frs.floor_{probe_floor}.{variable}",
            "peak=psa_peak peak_frequency=psa_peak_frequency",
        ),
        *scalars(centres, "transient.pfa.floor_{probe_floor}", "pfa"),
        *scalars(hit, "transient.pfa.edge_{probe_floor}", "pfa"),
        *finding_scalars(store),
    ]


def finding_scalars(store: xr.Dataset) -> list[Scalar]:
    """Select the scalars that compare floors, edges, forces and waves with each other."""
    top = f"transient.frs.floor_{wave_floor(store)}"
    found = [
        *scalars(store, f"{top}.{{variable}}", "peak_over_sticks peak_frequency_over_sticks"),
        *scalars(store, "transient.frs.{variable}", "far_highest_below near_highest_at"),
        *scalars(store, "transient.pfa.{variable}", "far_over_near"),
        *scalars(store, "transient.transfer.floor_{transfer_floor}", "transfer_peak"),
        *scalars(store, "transient.{variable}", "psd_ratio wave_crossing wave_far_edge"),
        *scalars(store, "transient.{variable}", "wave_reversal"),
    ]
    if "exceeding_floor" in store:
        lower, upper = int(store["exceeding_floor"]), int(store["exceeded_floor"])
        pair = f"transient.frs.floor_{lower}_above_floor_{upper}"
        found += scalars(store, f"{pair}.{{variable}}", "lowest=exceeds_from highest=exceeds_to")
    return found
