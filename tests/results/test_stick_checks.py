import logging

import pytest
import xarray as xr

from impactfem.results.check import log_checks
from impactfem.results.stick_checks import stick_checks
from impactfem.scalar import Scalar, from_json, to_json


@pytest.fixture
def told(finished, tmp_path, caplog):
    """What is logged for the finished run with scalars changed: the level by the line."""

    def log(asked=16, **changes):
        with xr.open_dataset(finished.folder / "sticks.nc", engine="h5netcdf") as dataset:
            store = dataset.load()
        scalars = {s.name: s for s in from_json(store.attrs["scalars"])}
        for name, value in changes.items():
            full = name.replace("__", ".")
            assert full in scalars
            scalars[full] = Scalar(full, value, scalars[full].unit)
        store.attrs["scalars"] = to_json(scalars.values())
        store.to_netcdf(tmp_path / "sticks.nc", engine="h5netcdf")
        caplog.clear()
        with caplog.at_level(logging.INFO, "impactfem"):
            log_checks(stick_checks(tmp_path, asked))
        return {record.getMessage(): record.levelno for record in caplog.records}

    return log


def level(told, words):
    found = [kind for line, kind in told.items() if words in line]
    assert len(found) == 1, words
    return found[0]


GOOD, WARNED = logging.INFO, logging.WARNING


@pytest.mark.parametrize(
    ("words", "change", "limits"),
    [
        ("discrete identity", "pounding__energy_residual", (1e-9, 2e-9)),
        ("shortest impact", "pounding__steps_per_impact_min", (16.0, 15.9)),
        ("points in a cycle", "frs__peak_error_bound", (0.05, 0.06)),
        ("of the gap", "pounding__penetration_over_gap", (0.5, 0.51)),
        ("bearing pressure", "pounding__bearing_ratio_max", (1.0, 1.01)),
        ("storey shear", "pounding__cracking_ratio_max", (1.0, 1.01)),
    ],
)
def test_a_limit(told, words, change, limits):
    for value, expected in zip(limits, (GOOD, WARNED), strict=True):
        lines = told(**{change: value})
        assert level(lines, words) == expected
        marked = [line for line, kind in lines.items() if kind == WARNED]
        assert all(line.startswith("warning: ") for line in marked)


def test_the_steps_asked_are_those_of_the_case(told):
    assert level(told(asked=16), "16 asked") == GOOD
    assert level(told(asked=100), "100 asked") == WARNED


def test_the_numbers_are_those_of_the_run(told, finished):
    values = {scalar.name: scalar.value for scalar in finished.run.scalars}
    text = "\n".join(told())
    assert f"{values['pounding.impacts']:.0f} impacts" in text
    assert f"{values['pounding.peak_force.floor_3'] / 1e6:.4g} MN" in text
    assert f"a gap of {100 * values['pounding.required_separation']:.3g} cm" in text


def test_without_an_impact(told):
    lines = told(pounding__main_impact_time=None)
    assert any("no impact" in line for line in lines)


def test_without_an_impact_or_a_pair(told):
    lines = told(pounding__main_impact_time=None, pounding__required_separation=None)
    assert "pounding: no impact" in lines
