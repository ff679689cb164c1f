"""What the paper says of the response of the 3D building, as numbers of this run.

Functions of arrays, and `physics_scalars`, which asks them of the stores. None stands for what does
not exist in a run, such as the crossing time of a wave where nothing touches.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.spectra.sampling import upsample
from impactfem.stages.transient.power import force_spectra
from impactfem.stages.transient.view import TransientView, stick_psa, stick_station
from impactfem.system.scalar import Scalar

Array = NDArray[np.float64]

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


def far_highest_below(near: Array, far: Array, frequency: Array) -> float | None:
    """The frequency at which the spectrum near the impact overtakes that far from it [Hz].

    Upwards from the frequency at which the far one is ahead the most, linear in log f between two
    frequencies; the highest frequency where it is never overtaken.

    Args:
        near: Envelope of the spectra in the near half of the line, shape (n_f,).
        far: That of the far half, same shape.
        frequency: Ascending, shape (n_f,) [Hz].

    Returns:
        None when the far one is nowhere higher.
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
    """The widest interval, in octaves, in which one spectrum is above another [Hz].

    Args:
        first: The spectrum that is above, shape (n_f,).
        second: The other one, same shape.
        frequency: Ascending, shape (n_f,) [Hz].

    Returns:
        Its ends, linear in log f between two frequencies; None when it is nowhere above.
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


def displacement_spread(sd: Array) -> float:
    """Largest difference of displacement spectra over the largest of all values.

    Args:
        sd: Of several points, shape (n_points, n_f) [m].
    """
    return float(np.ptp(sd, axis=0).max() / sd.max())


@dataclass(frozen=True, eq=False)
class Arrivals:
    """When the wave of an impact arrives at points, nan where nothing does.

    Args:
        peak: Of its peak, shape (n_points,) [s].
        half: Of half of its peak, before it, shape (n_points,) [s].
    """

    peak: Array
    half: Array


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
        crossing: Time by hand that a wave takes from the first point to the last [s]; None where
            it is not known.
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
    squares.

    Args:
        distance: Of the points from the first, shape (n,) [m].
        arrival: At the points, nan where nothing arrived, shape (n,) [s].

    Returns:
        None with fewer than two arrivals, or when they do not come later farther away.
    """
    known = np.isfinite(arrival)
    if np.count_nonzero(known) < 2:
        return None
    d, t = distance[known] - distance[known].mean(), arrival[known] - arrival[known].mean()
    spread = float(d @ d)
    slope = float(d @ t) / spread if spread > 0.0 else 0.0
    return slope * float(distance[-1] - distance[0]) if slope > 0.0 else None


def line_arrivals(view: TransientView) -> Arrivals | None:
    """Arrivals of the main impact's wave along the line; None where there is no such wave."""
    if view.main_impact is None or view.inward == 0.0:
        return None
    histories = np.array([view.acceleration(probe) for probe in view.line])
    crossing = view.values.get("transient.loaded_wave_crossing")
    return arrivals(view.time, histories, view.inward, view.main_impact, crossing)


def force_ratio(upper: Array, lower: Array, time_step: float) -> float | None:
    """Ratio of the mean power spectral densities of two main impacts up to 100 Hz.

    Args:
        upper: Force on the upper floor, shape (n_t,) [N].
        lower: Force on the lower floor, same shape [N].
        time_step: Δt [s].

    Returns:
        None when the lower force is zero.
    """
    spectra = force_spectra(np.stack([upper, lower], axis=1), time_step)
    content = spectra.density[:, spectra.frequency <= IMPACT_CONTENT].mean(axis=1)
    return float(content[0] / content[1]) if content[1] > 0.0 else None


def physics_scalars(view: TransientView, sticks: xr.Dataset) -> list[Scalar]:
    """All numbers that the stores have, by the names of `summary.json`.

    Args:
        view: The store `transient.nc`.
        sticks: The store `pounding.nc`.
    """
    return [
        *_against_sticks(view, sticks),
        *_along_line(view),
        *_edges(view),
        *_transfer(view),
        *_impacts(view),
        *_wave(view),
    ]


def _against_sticks(view: TransientView, sticks: xr.Dataset) -> list[Scalar]:
    top = view.top
    station = stick_station(sticks, view.building, top)
    other = stick_psa(sticks, station, view.direction) if station is not None else None
    if other is None:
        return []
    frequency = sticks["frequency"].values
    known = frequency <= view.maximum_frequency * (1.0 + 1e-9)
    ours, theirs = view.psa(view.centres[top])[view.known], other[known]
    k, s = int(np.argmax(ours)), int(np.argmax(theirs))
    ratio = float(view.frequency[view.known][k] / frequency[known][s])
    name = f"transient.frs.floor_{top}"
    note = "mass centre, 3D model over sticks"
    return [
        Scalar(f"{name}.peak_over_sticks", float(ours[k] / theirs[s]), "-", note),
        Scalar(f"{name}.peak_frequency_over_sticks", ratio, "-", note),
    ]


def _along_line(view: TransientView) -> list[Scalar]:
    if len(view.line) < 3:
        return []
    frequency = view.frequency[view.known]
    psa = np.array([view.psa(probe) for probe in view.line])[:, view.known]
    sd = np.array([view.sd(probe) for probe in view.line])[:, view.known]
    sd_floor = np.array([view.sd(probe) for probe in _on_top_floor(view)])[:, view.known]
    middle = 0.5 * view.distance[-1]
    slack = 1e-6 * view.distance[-1]
    near = psa[view.distance < middle - slack].max(axis=0)
    far = psa[view.distance > middle + slack].max(axis=0)
    pfa = np.array([view.pfa(probe) for probe in view.line])
    top = view.top
    return [
        Scalar(
            "transient.frs.far_highest_below",
            far_highest_below(near, far, frequency),
            "Hz",
            f"floor {top}: up to there the far half of the line is higher than the near one",
        ),
        Scalar(
            "transient.frs.near_highest_at",
            float(frequency[int(np.argmax(psa[0]))]),
            "Hz",
            f"floor {top}: peak of the spectrum at the impact edge",
        ),
        Scalar(
            "transient.frs.displacement_spread",
            displacement_spread(sd),
            "-",
            f"line on floor {top}: largest difference of displacement spectra over the largest",
        ),
        Scalar(
            "transient.frs.displacement_spread_floor",
            displacement_spread(sd_floor),
            "-",
            f"the same of all probes on floor {top}: turning about the vertical is in it",
        ),
        Scalar(
            "transient.pfa.edges_over_inside",
            float(min(pfa[0], pfa[-1]) / pfa[1:-1].max()),
            "-",
            f"floor {top}: the lower of both ends of the line over the highest between them",
        ),
        Scalar(
            "transient.pfa.far_over_near",
            float(pfa[-1] / pfa[0]),
            "-",
            f"line on floor {top}: the end far from the impact over the one that is hit",
        ),
    ]


def _on_top_floor(view: TransientView) -> list[int]:
    """All probes at the level of the line."""
    z = view.position[:, 2]
    level = z[view.line[0]]
    return [int(k) for k in np.flatnonzero(np.abs(z - level) < 1e-6 * max(1.0, abs(level)))]


def _edges(view: TransientView) -> list[Scalar]:
    """Where the floor below the one with the line is above it, at the impact edges."""
    floors = [floor for floor in view.edges if floor <= view.top]
    if len(floors) < 2:
        return []
    lower, upper = floors[-2:]
    frequency = view.frequency[view.known]
    below, above = (view.psa(view.edges[floor])[view.known] for floor in (lower, upper))
    ends = longest_above(below, above, frequency)
    name = f"transient.frs.floor_{lower}_above_floor_{upper}"
    note = "impact edges, ends of the widest interval"
    low, high = ends if ends is not None else (None, None)
    return [
        Scalar(f"{name}.lowest", low, "Hz", note),
        Scalar(f"{name}.highest", high, "Hz", note),
    ]


def _transfer(view: TransientView) -> list[Scalar]:
    scalars = []
    if view.transfer_loads:
        known = view.transfer_frequency <= view.maximum_frequency * (1.0 + 1e-9)
        content = known & (view.transfer_frequency <= IMPACT_CONTENT)
    for floor in view.transfer_loads:
        if floor not in view.edges:
            continue
        values = view.transfer(floor, view.edges[floor])
        k = int(np.argmax(np.where(known, values, 0.0)))
        name = f"transient.transfer.floor_{floor}"
        note = "largest acceleration over force at the edge that the force acts on"
        scalars += [
            Scalar(name, float(values[k]), "1/kg", note),
            Scalar(f"{name}_frequency", float(view.transfer_frequency[k]), "Hz", note),
            Scalar(
                f"{name}_to_{IMPACT_CONTENT:g}hz",
                float(np.where(content, values, 0.0).max()),
                "1/kg",
                f"{note}, up to {IMPACT_CONTENT:g} Hz",
            ),
        ]
    return scalars


def _impacts(view: TransientView) -> list[Scalar]:
    if len(view.loads) < 2:
        return []
    lower, upper = list(view.loads)[-2:]
    note = f"main impacts, floor {upper} over floor {lower}, mean up to {IMPACT_CONTENT:g} Hz"
    ratio = force_ratio(
        view.force[:, view.loads[upper]], view.force[:, view.loads[lower]], view.time_step
    )
    return [Scalar("transient.psd_ratio", ratio, "-", note)]


def _wave(view: TransientView) -> list[Scalar]:
    found = line_arrivals(view)
    if found is None:
        return []
    scalars = []
    for name, arrival, what in (
        ("", found.peak, "the peak"),
        ("_half", found.half, f"{100 * HALF:g} % of the peak"),
    ):
        crossing = crossing_time(view.distance, arrival)
        speed = None if crossing is None else float(view.distance[-1]) / crossing
        note = f"main impact, slope of the arrival of {what} along the line"
        scalars += [
            Scalar(f"transient.wave_crossing{name}", crossing, "s", note),
            Scalar(f"transient.measured_wave_speed{name}", speed, "m/s", note),
        ]
    return [*scalars, *_edge_instants(view, found)]


def _edge_instants(view: TransientView, found: Arrivals) -> list[Scalar]:
    """What happens at both ends of the line after the peak at the impact edge."""
    first, last = found.peak[[0, -1]]
    across = float(last - first) if last > first else None
    turned = None
    if math.isfinite(first) and view.main_impact is not None:
        start, end = view.main_impact
        shown = (view.time > first) & (view.time <= end + max(end - start, view.time_step))
        pushed = view.inward * view.acceleration(view.line[0])[shown]
        if pushed.min(initial=0.0) < 0.0:
            turned = float(view.time[shown][np.argmin(pushed)] - first)
    return [
        Scalar(
            "transient.wave_far_edge",
            across,
            "s",
            "main impact, from the peak at the impact edge to that at the opposite edge",
        ),
        Scalar(
            "transient.wave_reversal",
            turned,
            "s",
            "main impact, from the peak at the impact edge to the largest acceleration there in "
            "the opposite sense",
        ),
    ]
