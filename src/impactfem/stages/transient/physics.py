"""What the paper says of the response of the 3D building, as numbers of this run.

Functions of arrays, and `physics_scalars` of the stores. None stands for what does not
exist in a run, such as the crossing time of a wave where nothing touches.
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy import signal

from impactfem.coupling.force_history import around_peak
from impactfem.spectra.response_spectrum import upsample
from impactfem.stages.stores import time_step
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
    shown,
    transfer,
    wave_floor,
)
from impactfem.system.arrays import Array
from impactfem.system.scalar import Scalar, values_of

Row = tuple[str, float | None, str, str]
"""Name of a scalar without that of the stage, value, unit and note."""

IMPACT_CONTENT = 100.0
"""Up to where the main impacts have most of their content, section 4.3.2 of the paper [Hz]."""
HALF = 0.5
"""Part of its peak at which a wave's arrival is read, in addition to the peak itself."""
FIRST = 0.45
"""Part of the largest peak in the window that the first peak of a wave reaches at least: what comes
back to a free edge is up to twice as large."""
NOTHING = 0.01
"""Part of the largest acceleration of all that counts as none."""
LATEST = 1.5
"""Crossings by hand after its peak at the first point up to which a wave is looked for: in the near
half of the line, until its reflection comes back."""
FINER = 20
"""Steps of the interpolated histories in one of the response."""
QUIET_STEPS = 6
"""Steps before the impact where resampled forces are zero to 0.04 %."""
SEGMENT = 1.0
"""Length of the segments of a record [s]."""
SILENT = 1e-6
"""Part of the largest force below which nothing acts any more."""
RESOLUTION = 0.5
"""Spacing of the frequencies of an impact's spectrum, which is smooth [Hz]."""


def far_highest_below(near: Array, far: Array, frequency: Array) -> float | None:
    """The frequency at which the spectrum near the impact overtakes that far from it [Hz].

    Upwards from the frequency at which the far one is ahead the most, linear in log f between two
    frequencies; the highest frequency where it is never overtaken, None when the far one is nowhere
    higher. Of both halves of the line it takes the envelopes, shape (n_f,).
    """
    ahead = np.log(far / near)
    most = int(np.argmax(ahead))
    if not ahead[most] > 0.0:
        return None
    behind = np.flatnonzero(ahead[most:] <= 0.0)
    if not behind.size:
        return float(frequency[-1])
    return _zero(frequency, ahead, most + int(behind[0]) - 1)


def longest_above(first: Array, second: Array, frequency: Array) -> tuple[float, float] | None:
    """The widest interval, in octaves, in which the first spectrum is above the second [Hz].

    Its ends are linear in log f between two frequencies; None when it is nowhere above.
    """
    ahead = np.log(first / second)
    above = np.concatenate([[False], ahead > 0.0, [False]])
    starts = np.flatnonzero(~above[:-1] & above[1:])
    ends = np.flatnonzero(above[:-1] & ~above[1:])
    found = []
    for start, end in zip(starts, ends, strict=True):
        low = _zero(frequency, ahead, start - 1) if start else float(frequency[0])
        high = _zero(frequency, ahead, end - 1) if end < len(ahead) else float(frequency[-1])
        found.append((low, high))
    return max(found, key=lambda ends: ends[1] / ends[0]) if found else None


def _zero(frequency: Array, values: Array, k: int) -> float:
    """Where values change their sign between k and k + 1, linear in log f."""
    a, b = values[k], values[k + 1]
    share = a / (a - b) if a != b else 0.0
    return float(frequency[k] * (frequency[k + 1] / frequency[k]) ** share)


@dataclass(frozen=True, eq=False)
class Arrivals:
    """When the wave of an impact arrives at points, nan where nothing does."""

    peak: Array  #: of its peak, shape (n_points,) [s]
    half: Array  #: of half of its peak, before it, shape (n_points,) [s]


def arrivals(
    time: Array,
    acceleration: Array,
    sense: float,
    impact: tuple[float, float],
    crossing: float | None = None,
) -> Arrivals:
    """When the wave of an impact arrives at points, by its peak and by half of it.

    Read from histories that are made finer by band-limited interpolation, as the acceleration along
    the push beyond its value shortly before the impact. The peak is the first one that comes near
    the largest in the window: a later one is that of a reflection. The window ends when the impact
    has been over for as long as it lasted; at the points after the first one it ends one and a half
    crossings after the peak there, where the speed is known by hand. The foot of the wave says
    nothing of its speed: damping that grows with the frequency has no front, and resampled forces
    push before an impact.

    Args:
        time: Equidistant, shape (n_t,) [s].
        acceleration: Shape (n_points, n_t) [m/s2].
        sense: 1 or −1, the sense in which the impact pushes.
        impact: Its start and end [s].
        crossing: By hand, of a wave from the first point to the last [s]; None if not known.
    """
    step = float(time[1] - time[0])
    start = int(np.searchsorted(time, impact[0] - 1e-9 * step))
    quiet = max(0, start - QUIET_STEPS)
    end = impact[1] + max(impact[1] - impact[0], step)
    peak, half = (np.full(len(acceleration), math.nan) for _ in range(2))
    pushed = upsample(sense * (acceleration - acceleration[:, quiet : quiet + 1]), FINER)
    first = FINER * quiet
    for k, history in enumerate(pushed):
        if k == 1 and crossing and math.isfinite(peak[0]):
            end = peak[0] + LATEST * crossing
        last = FINER * (int(np.searchsorted(time, end, side="right")) - 1)
        values = history[first : last + 1]
        inner = values[1:-1]
        tops = 1 + np.flatnonzero((inner > values[:-2]) & (inner >= values[2:]))
        largest = float(values[tops].max(initial=0.0))
        # What interpolation makes of a wave that comes after the window is no arrival.
        if not largest > NOTHING * float(np.abs(acceleration).max()):
            continue
        tops = tops[values[tops] >= FIRST * largest]
        top = int(tops[0])
        after = int(np.argmax(values >= HALF * values[top]))
        peak[k] = time[0] + step * (first + top) / FINER
        half[k] = time[0] + step * (first + after) / FINER
    return Arrivals(peak, half)


def crossing_time(distance: Array, arrival: Array) -> float | None:
    """The time a wave takes from the first point of a line to the last [s].

    The length of the line times the slope of the straight line through the arrivals, by least
    squares; nan is no arrival. None with fewer than two, or when they do not come later farther
    away.
    """
    known = np.isfinite(arrival)
    if np.count_nonzero(known) < 2:
        return None
    d, t = distance[known] - distance[known].mean(), arrival[known] - arrival[known].mean()
    spread = float(d @ d)
    slope = float(d @ t) / spread if spread > 0.0 else 0.0
    return slope * float(distance[-1] - distance[0]) if slope > 0.0 else None


def line_arrivals(response: xr.Dataset) -> Arrivals | None:
    """Arrivals of the main impact's wave along the line; None where there is no such wave."""
    impact, sense = main_impact(response), inward(response)
    if impact is None or sense == 0.0:
        return None
    histories = of_kind(response, "line")["acceleration"].transpose("probe", "time").values
    crossing = values_of(response).get("transient.loaded_wave_crossing")
    return arrivals(response["time"].values, histories, sense, impact, crossing)


@dataclass(frozen=True, eq=False)
class ForceSpectra:
    """Power spectral densities of the main impacts."""

    frequency: Array  #: shape (n_f,) [Hz]
    density: Array  #: one-sided, shape (n_forces, n_f) [N²/Hz]
    duration: float  #: over which the power is taken [s]


def power_spectrum(record: Array, time_step: float) -> tuple[Array, Array]:
    """One-sided power spectral density by Welch's method, Hann windows that overlap by half.

    Of records of shape (..., n): frequencies [Hz] and densities [their unit squared per Hz].
    """
    frequency, density = signal.welch(
        record,
        fs=1.0 / time_step,
        window="hann",
        nperseg=min(record.shape[-1], round(SEGMENT / time_step)),
        detrend=False,
    )
    return np.asarray(frequency), np.asarray(density)


def force_spectra(force: Array, time_step: float) -> ForceSpectra:
    """Spectra of the main impact of each force, alone and over the same duration.

    S(f) = 2 |Δt Σ_n F_n e^(−2πi f n Δt)|² / T, with the duration T for which the longest of the
    impacts presses: so the densities of the forces, shape (n_t, n_forces) [N], can be compared. The
    samples before and after it, in which resampling rings, belong to its impulse and not to T.
    """
    # Each ends where nothing acts: tension at its end belongs to it.
    impacts = [around_peak(np.abs(column), SILENT) for column in force.T]
    longest = max(last - first for first, last in impacts)
    T = time_step * max(behind - first for first, behind in map(around_peak, force.T))
    count = max(longest, round(1.0 / (RESOLUTION * time_step)))
    densities = []
    frequency = np.fft.rfftfreq(count, time_step)
    for (first, last), column in zip(impacts, force.T, strict=True):
        alone = np.zeros(longest)
        alone[: last - first] = column[first:last]
        frequency, density = signal.periodogram(
            alone, fs=1.0 / time_step, window="boxcar", nfft=count, detrend=False
        )
        densities.append(density * (longest * time_step / T))
    return ForceSpectra(np.asarray(frequency), np.array(densities), T)


def physics_scalars(store: xr.Dataset, sticks: xr.Dataset) -> list[Scalar]:
    """All numbers that `transient.nc` and `pounding.nc` have, by the names of `summary.json`."""
    response = shown(store)
    good, top, rows = known(response), wave_floor(response), list[Row]()
    other = of_pounding(sticks, "psa", response)
    # A 3D model that pounds is the same model.
    if other is not None and pounded(sticks, response) == "sticks":
        ours = at_floor(good, "centre", top)["psa"]
        theirs = other.isel(frequency=(other["frequency"] <= _highest(response)).values)
        peak, stick_peak = ours.isel(ours.argmax(...)), theirs.isel(theirs.argmax(...))
        ratio = float(peak["frequency"]) / float(stick_peak["frequency"])
        name, note = f"frs.floor_{top}", "mass centre, 3D model over sticks"
        rows = [
            (f"{name}.peak_over_sticks", float(peak) / float(stick_peak), "-", note),
            (f"{name}.peak_frequency_over_sticks", ratio, "-", note),
        ]
    rows += _along_line(response)
    # Where the floor below the one with the line is above it, at the impact edges.
    floors = [f for f in floors_of(response, "edge") if f <= top]
    if len(floors) > 1:
        lower, upper = floors[-2:]
        below, above = (at_floor(good, "edge", floor)["psa"].values for floor in (lower, upper))
        ends = longest_above(below, above, good["frequency"].values) or (None, None)
        note = "impact edges, ends of the widest interval"
        rows += [
            (f"frs.floor_{lower}_above_floor_{upper}.{which}", end, "Hz", note)
            for which, end in zip(("lowest", "highest"), ends, strict=True)
        ]
    rows += [*_of_forces(response), *_of_wave(response)]
    return [Scalar(f"transient.{name}", value, unit, note) for name, value, unit, note in rows]


def _highest(response: xr.Dataset) -> float:
    """The highest frequency that the model is meant for, and what rounding adds [Hz]."""
    return float(response.attrs["maximum_frequency"]) * (1.0 + 1e-9)


def _along_line(response: xr.Dataset) -> list[Row]:
    """How spectra and peak accelerations change from the impact edge to the opposite one."""
    line = of_kind(known(response), "line")
    if line.sizes["probe"] < 3:
        return []
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
        float((one.max("probe") - one.min("probe")).max() / one.max())
        for one in (line["sd"], on_floor["sd"])
    )
    overtaken, at_edge = far_highest_below(near, far, frequency), int(np.argmax(psa[0]))
    inside = float(min(pfa[0], pfa[-1]) / pfa[1:-1].max())
    floor = f"floor {wave_floor(response)}"
    of_line = f"line on {floor}: largest difference of displacement spectra over the largest"
    of_floor = f"the same of all probes on {floor}: turning about the vertical is in it"
    both_ends = f"{floor}: the lower of both ends of the line over the highest between them"
    to_far = f"line on {floor}: the end far from the impact over the one that is hit"
    upto = f"{floor}: up to there the far half of the line is higher than the near one"
    at_impact = f"{floor}: peak of the spectrum at the impact edge"
    return [
        ("frs.far_highest_below", overtaken, "Hz", upto),
        ("frs.near_highest_at", float(frequency[at_edge]), "Hz", at_impact),
        ("frs.displacement_spread", spread, "-", of_line),
        ("frs.displacement_spread_floor", spread_floor, "-", of_floor),
        ("pfa.edges_over_inside", inside, "-", both_ends),
        ("pfa.far_over_near", float(pfa[-1] / pfa[0]), "-", to_far),
    ]


def _of_forces(response: xr.Dataset) -> list[Row]:
    """Transfer functions at the edges, and the content of the forces on the two upper ones."""
    rows: list[Row] = []
    floors = response["transfer_load_floor"].values if "transfer_load" in response.dims else ()
    note = "largest acceleration over force at the edge that the force acts on"
    upto = IMPACT_CONTENT
    for floor in dict.fromkeys(floors):
        if floor not in floors_of(response, "edge"):
            continue
        size, _ = transfer(at_floor(response, "edge", floor), floor)
        size = size.sel(transfer_frequency=slice(None, _highest(response)))
        largest = float(size.sel(transfer_frequency=slice(None, upto)).max())
        name = f"transfer.floor_{floor}"
        rows += [
            (name, float(size.max()), "1/kg", note),
            (f"{name}_frequency", float(size.idxmax()), "Hz", note),
            (f"{name}_to_{upto:g}hz", largest, "1/kg", f"{note}, up to {upto:g} Hz"),
        ]
    side = main_side(response)
    if side.sizes["edge"] > 1:
        force = side["impact_force"].isel(edge=[-2, -1]).transpose("time", "edge")
        spectra = force_spectra(force.values, time_step(response))
        below, above = spectra.density[:, spectra.frequency <= upto].mean(axis=1)
        lower, upper = force["edge"].values
        note = f"main impacts, {upper} over {lower}, mean up to {upto:g} Hz"
        rows.append(("psd_ratio", float(above / below) if below > 0.0 else None, "-", note))
    return rows


def _of_wave(response: xr.Dataset) -> list[Row]:
    """Crossing times and speeds of the main impact's wave, and what happens at both ends."""
    found, impact = line_arrivals(response), main_impact(response)
    if found is None or impact is None:
        return []
    rows: list[Row] = []
    line = of_kind(response, "line")
    distance = line["distance"].values
    for name, arrival, what in (
        ("", found.peak, "the peak"),
        ("_half", found.half, f"{100 * HALF:g} % of the peak"),
    ):
        crossing = crossing_time(distance, arrival)
        speed = None if crossing is None else float(distance[-1]) / crossing
        note = f"main impact, slope of the arrival of {what} along the line"
        rows += [
            (f"wave_crossing{name}", crossing, "s", note),
            (f"measured_wave_speed{name}", speed, "m/s", note),
        ]
    first, last = found.peak[[0, -1]]
    across = float(last - first) if last > first else None
    turned = None
    if math.isfinite(first):
        start, end = impact
        time = response["time"].values
        after = (time > first) & (time <= end + max(end - start, time_step(response)))
        pushed = inward(response) * line["acceleration"].isel(probe=0).values[after]
        if pushed.min(initial=0.0) < 0.0:
            turned = float(time[after][np.argmin(pushed)] - first)
    note = "main impact, from the peak at the impact edge to"
    opposite = "the largest acceleration there in the opposite sense"
    return [
        *rows,
        ("wave_far_edge", across, "s", f"{note} that at the opposite edge"),
        ("wave_reversal", turned, "s", f"{note} {opposite}"),
    ]
