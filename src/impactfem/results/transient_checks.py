"""The checks of the stage `transient` in words: samples, loads, basis, band."""

from __future__ import annotations

from pathlib import Path

from impactfem.results.check import Check, log_checks
from impactfem.results.open_store import open_store
from impactfem.scalar import from_json

IMPULSE = 1e-9
ENERGY = 1e-9
POINTS = 10.0
"""Points in a cycle of the highest frequency of the response below which it is told."""


def log_samples(step: float, highest: float) -> None:
    """Log how finely a step samples the response, as a warning where it is too coarse.

    Args:
        step: Time step [s].
        highest: Highest frequency of the response [Hz].
    """
    points = 1.0 / (highest * step)
    line = f"{points:.1f} points in a cycle of {highest:g} Hz at the step of {1e3 * step:g} ms"
    log_checks([(points >= POINTS, f"transient: {line}")])


def transient_checks(folder: Path) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `transient.nc`.
    """
    with open_store(folder / "transient.nc") as store:
        values = {s.name: s.value for s in from_json(store.attrs["scalars"]) if s.value is not None}
    lines: list[Check] = [
        (
            values["transient.impulse_error"] < IMPULSE,
            f"transient: impulses kept to {values['transient.impulse_error']:.1e}",
        ),
    ]
    if "transient.band_max" in values:
        share = 100.0 * values["transient.band_max"]
        lines.append((share < 5.0, f"transient: error band of the spectra at most {share:.2g} %"))
    if "transient.energy_residual" in values:
        residual = values["transient.energy_residual"]
        lines.append((residual < ENERGY, f"transient: energy identity to {residual:.1e}"))
    if "transient.reduced_against_full" in values:
        error = 100.0 * values["transient.reduced_against_full"]
        lines.append(
            (error < 0.5, f"transient: spectra of reduced and full differ by {error:.2g} %")
        )
    return lines
