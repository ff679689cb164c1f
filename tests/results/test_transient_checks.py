"""The checks of the stage `transient` in words."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
import xarray as xr

from impactfem.results.check import log_checks
from impactfem.results.transient_checks import log_samples, transient_checks
from impactfem.scalar import Scalar, to_json

GOOD = {
    "impulse_error": 1e-14,
    "band_max": 0.004,
    "energy_residual": 1e-13,
    "reduced_against_full": 0.002,
}
LINES = [
    "transient: impulses kept to 1.0e-14",
    "transient: error band of the spectra at most 0.4 %",
    "transient: energy identity to 1.0e-13",
    "transient: spectra of reduced and full differ by 0.2 %",
]


def logged(
    folder: Path, caplog: pytest.LogCaptureFixture, **changes: float | None
) -> list[tuple[str, str]]:
    scalars = [Scalar(f"transient.{name}", x, "-") for name, x in {**GOOD, **changes}.items()]
    store = xr.Dataset(attrs={"scalars": to_json(scalars)})
    store.to_netcdf(folder / "transient.nc", engine="h5netcdf")
    with caplog.at_level(logging.INFO, "impactfem"):
        log_checks(transient_checks(folder))
    return [(record.levelname, record.getMessage()) for record in caplog.records]


def test_all_is_well(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert logged(tmp_path, caplog) == [("INFO", line) for line in LINES]


def test_one_solver_alone(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    nothing = dict.fromkeys(("energy_residual", "reduced_against_full"))
    assert [line for _, line in logged(tmp_path, caplog, **nothing)] == LINES[:2]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"impulse_error": 1e-3}, "impulses kept to 1.0e-03"),
        ({"band_max": 0.2}, "error band of the spectra at most 20 %"),
        ({"energy_residual": 1e-6}, "energy identity to 1.0e-06"),
        ({"reduced_against_full": 0.01}, "spectra of reduced and full differ by 1 %"),
    ],
)
def test_what_fails_is_a_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, change: dict[str, float], line: str
) -> None:
    found = logged(tmp_path, caplog, **change)
    assert [text for level, text in found if level == "WARNING"] == [f"warning: transient: {line}"]
    assert len(found) == len(LINES)


@pytest.mark.parametrize(
    ("step", "level", "line"),
    [
        (1e-3, "INFO", "transient: 20.0 points in a cycle of 50 Hz at the step of 1 ms"),
        (2e-3, "INFO", "transient: 10.0 points in a cycle of 50 Hz at the step of 2 ms"),
        (4e-3, "WARNING", "warning: transient: 5.0 points in a cycle of 50 Hz at the step of 4 ms"),
    ],
)
def test_samples(caplog: pytest.LogCaptureFixture, step: float, level: str, line: str) -> None:
    with caplog.at_level(logging.INFO, "impactfem"):
        log_samples(step, 50.0)
    assert [(record.levelname, record.getMessage()) for record in caplog.records] == [(level, line)]
