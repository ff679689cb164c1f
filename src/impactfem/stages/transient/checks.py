"""The checks of the stage `transient` in words: samples, loads, basis, band."""

import math
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.given_forces import AGREES, largest_disagreement
from impactfem.stages.check import POINTS, Check, end_check, limited, resolved_frequency
from impactfem.stages.pounding.checks import begins_with_jump
from impactfem.stages.stores import names_of, of_run, open_store, time_step
from impactfem.stages.transient.selection import between, ends, known
from impactfem.system.scalar import values_of

NUMBERS = (
    ("impulse_error", 1e-9, "", "error of the impulses"),
    ("band_max", 0.05, "%", "error band of the spectra"),
    ("energy_residual", 1e-9, "", "energy identity"),
    ("reduced_against_full", 0.005, "%", "difference of the spectra, reduced from full"),
)
"""Scalar, its limit, unit and name."""
LOST = 1.0 - math.cos(math.pi / POINTS)
"""What so many samples lose of a peak between them at most, 4.9 %."""


def transient_checks(folder: Path) -> list[Check]:
    """The checks of `transient.nc`."""
    with open_store(folder / "transient.nc") as store:
        step, values = time_step(store), values_of(store)
        samples = [samples_check(step, float(store.attrs["maximum_frequency"]))]
        if samples[0][0] is False:
            # The samples that the spectra had in a cycle, over those of the histories.
            points = values["transient.points_per_cycle"]
            finer, over = round(points * step * float(store["frequency"].max())), between(store)
            if finer > 1 and over.notnull().any():
                largest = over.isel(over.argmax(...))
                low = 1.0 - 1.0 / float(largest)
                met, text = limited("transient: peak accelerations, samples low by", low, LOST, "%")
                samples.append(
                    (
                        met,
                        f"{text} at {largest['probe'].item()}, {largest['component'].item()}: "
                        "printed peak accelerations and ZPA are sampled values; "
                        f"spectra at the probes are those of histories made {finer} times finer "
                        "by band-limited interpolation",
                    )
                )
            else:
                text = f"peak accelerations may be more than {100.0 * LOST:.2g} % low"
                samples.append((None, f"transient: {text} between the samples"))
        last = float(known(store)["frequency"][-1])
        probes, ratio = names_of(store, "probe"), ends(store).values
        jumps, pounding = True, of_run(folder, "pounding.nc")  # assumed where it was not computed
        if pounding.is_file():
            with open_store(pounding) as sticks:
                jumps = begins_with_jump(sticks)
        ended = end_check("transient", probes, "xyz", ratio, last, jumps=jumps)
        numbers: list[Check] = [
            limited(f"transient: {text}", value, limit, unit)
            for name, limit, unit, text in NUMBERS
            if (value := values.get(f"transient.{name}")) is not None
        ]
        return [*samples, ended, *numbers, *_pulling(store)]


def _pulling(store: xr.Dataset) -> Iterator[Check]:
    """Whether the uniform line loads press on the whole of their sides, at their largest forces."""
    if store.attrs["spread"] != "uniform" or not store.sizes["edge"]:
        return
    floors = store.isel(edge=[not side.startswith("storey") for side in store["edge_side"].values])
    largest = floors.isel(time=abs(floors["edge_force"]).argmax("time"))
    beside = abs(largest["edge_moment"] / largest["edge_force"])
    if not (beside > 0.0).any():
        return
    worst = (beside / largest["edge_length"]).argmax("edge")
    sixth = float(largest["edge_length"].isel(edge=worst)) / 6.0
    # Beyond a sixth of the length from the middle the line load pulls at the far end.
    edge = largest["edge"].isel(edge=worst).item()
    text = f"transient: largest force on {edge}, spread uniform, distance from the middle"
    yield limited(text, float(beside.isel(edge=worst)), sixth, "m")


def impulse_check(given: ForceHistory, own: ForceHistory, name: str) -> list[Check]:
    """Compare the impulses of each pair in a file of forces with those of the sticks of the run."""
    worst = largest_disagreement(given, own)
    if worst is None:
        return []
    pair, theirs, ours = worst
    factor = max(theirs, ours) / min(theirs, ours) if min(theirs, ours) > 0.0 else math.inf
    text = f"transient: impulses of {name} and of the sticks of this run, largest factor"
    met, text = limited(text, factor, AGREES)
    text += f" at {pair}: {theirs:.3g} and {ours:.3g} N s"
    if not met:
        text += "; floor spectra change with it: check the order of the columns, signs and units"
    return [(met, text)]


def samples_check(step: float, highest: float) -> Check:
    """Whether a step [s] samples the response finely enough up to its highest frequency [Hz]."""
    # Of whole numbers, the quotient may be a rounding error below one.
    points = 1.0 / (highest * step) * (1.0 + 1e-9)
    text = f"transient: step {1e3 * step:g} ms, points in a cycle of {highest:g} Hz"
    met, text = limited(text, points, POINTS, least=True)
    return (
        met,
        text if met else f"{text}: resolved up to {resolved_frequency(step, highest):.4g} Hz",
    )
