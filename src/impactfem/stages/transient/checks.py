"""Checks of the stage `transient`: samples, loads, basis, error estimate."""

import math
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.given_forces import AGREES, largest_disagreement
from impactfem.spectra.resolved import POINTS, step_limit
from impactfem.stages.check import (
    PROGRAM_FAULT,
    Check,
    Criterion,
    end_check,
    end_of_spectra,
)
from impactfem.stages.pounding.checks import begins_with_jump
from impactfem.stages.stores import names_of, of_run, open_store, time_step
from impactfem.stages.transient.selection import between, ends, known

SAMPLES = Criterion(
    "transient.points_per_cycle",
    "time steps in a cycle of the highest frequency",
    lower=POINTS,
    consequence="Accelerations and spectra above the resolved frequency depend on the time step",
    remedy="Reduce transient.time_step, or use results up to the resolved frequency",
    concerns=("transient.pfa.*",),
)
PEAKS = Criterion(
    "transient.sampled_peaks",
    "error of peak accelerations between samples",
    "%",
    upper=1.0 - math.cos(math.pi / POINTS),  # what so many samples lose of a peak at most
    consequence="Printed peak accelerations are sampled values and are too low by this error",
    remedy="Reduce transient.time_step",
    concerns=("transient.pfa.*",),
)
SPECTRUM_END = end_of_spectra("transient", "transient.pfa.*", "design.frs.*.zpa")
NUMBERS = {
    "impulse_error": Criterion(
        "transient.impulse_error",
        "error of the impulses",
        upper=1e-9,
        severity="invalid",
        consequence="The loads of the 3D model do not have the impulses of the impacts",
        remedy=PROGRAM_FAULT,
        concerns=("transient.*", "design.*"),
    ),
    "band_max": Criterion(
        "transient.error_estimate",
        "error estimate of the spectra",
        "%",
        upper=0.05,
        consequence="Spectra may be wrong by this error",
        remedy="Raise transient.largest_basis, or lower transient.tolerance",
        concerns=("transient.frs.*", "design.frs.*"),
    ),
    "energy_residual": Criterion(
        "transient.energy_residual",
        "residual of the energy identity",
        upper=1e-9,
        severity="invalid",
        consequence="The time stepping does not conserve energy",
        remedy=PROGRAM_FAULT,
        concerns=("transient.*", "design.*"),
    ),
    "reduced_against_full": Criterion(
        "transient.reduced_against_full",
        "difference of the spectra, reduced from full model",
        "%",
        upper=0.005,
        consequence="Spectra of the reduced model are wrong by this error",
        remedy="Raise transient.largest_basis, or lower transient.tolerance",
        concerns=("transient.frs.*", "design.frs.*"),
    ),
}
"""Criterion by the variable of the store."""
LINE_LOAD = Criterion(
    "transient.line_load_distance",
    "distance of the largest force from the middle of its edge, spread uniform",
    "m",
    consequence="The uniform line load pulls at the far end of the edge",
    remedy="Set transient.spread to another value, or move the contact points",
    concerns=("transient.*", "design.*"),
)
IMPULSES = Criterion(
    "transient.impulse_ratio",
    "largest ratio of an impulse in the file of forces and in the sticks of this run",
    upper=AGREES,
    consequence="Floor spectra change with the impulses",
    remedy="Check the order of the columns, signs and units of transient.forces",
    concerns=("transient.*", "design.*", "device.*"),
)


def transient_checks(folder: Path) -> list[Check]:
    """Return the checks of `transient.nc`."""
    with open_store(folder / "transient.nc") as store:
        samples = [samples_check(time_step(store), float(store.attrs["maximum_frequency"]))]
        if samples[0].passed is False:
            finer, over = int(store["upsampling_factor"]), between(store)
            if finer > 1 and over.notnull().any():
                largest = over.isel(over.argmax(...))
                where = f"{largest['probe'].item()}, {largest['component'].item()}"
                finer_by = (
                    f"spectra at the probes are those of histories made {finer} times finer by "
                    "band-limited interpolation"
                )
                samples.append(PEAKS.check(1.0 - 1.0 / float(largest), where, finer_by))
            else:
                text = f"peak accelerations may be more than {100.0 * PEAKS.upper:.2g} % low"
                samples.append(PEAKS.check(detail=text))
        last = float(known(store)["frequency"][-1])
        probes, ratio = names_of(store, "probe"), ends(store).values
        jumps, pounding = True, of_run(folder, "pounding.nc")  # assumed where it was not computed
        if pounding.is_file():
            with open_store(pounding) as sticks:
                jumps = begins_with_jump(sticks)
        ended = end_check(SPECTRUM_END, probes, "xyz", ratio, last, jumps=jumps)
        numbers = [
            criterion.check(float(store[name]))
            for name, criterion in NUMBERS.items()
            if name in store
        ]
        return [*samples, ended, *numbers, *_pulling(store)]


def _pulling(store: xr.Dataset) -> Iterator[Check]:
    """Check that uniform line loads press on the whole of their sides, at their largest forces."""
    if store.attrs["spread"] != "uniform" or not store.sizes["edge"]:
        return
    floors = store.isel(edge=[not side.startswith("storey") for side in store["edge_side"].values])
    largest = floors.isel(time=abs(floors["edge_force"]).argmax("time"))
    distance = abs(largest["edge_moment"] / largest["edge_force"])
    if not (distance > 0.0).any():
        return
    worst = (distance / largest["edge_length"]).argmax("edge")
    # Beyond a sixth of the length from the middle the line load pulls at the far end.
    sixth = float(largest["edge_length"].isel(edge=worst)) / 6.0
    edge = str(largest["edge"].isel(edge=worst).item())
    yield LINE_LOAD.check(float(distance.isel(edge=worst)), edge, upper=sixth)


def impulse_check(given: ForceHistory, own: ForceHistory, name: str) -> list[Check]:
    """Compare the impulses of each pair in a file of forces with those of the sticks of the run."""
    worst = largest_disagreement(given, own)
    if worst is None:
        return []
    pair, theirs, ours = worst
    factor = max(theirs, ours) / min(theirs, ours) if min(theirs, ours) > 0.0 else math.inf
    return [IMPULSES.check(factor, pair, f"{theirs:.3g} N s in {name}, {ours:.3g} N s here")]


def samples_check(step: float, highest: float) -> Check:
    """Check that a step [s] samples the response up to its highest frequency [Hz]."""
    # Of whole numbers, the quotient may be a rounding error below one.
    points = 1.0 / (highest * step) * (1.0 + 1e-9)
    text = "" if points >= POINTS else f"resolved up to {step_limit(step):.4g} Hz"
    return SAMPLES.check(points, f"{highest:g} Hz, step {1e3 * step:g} ms", text)
