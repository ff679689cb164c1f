"""The checks of the stage `transient`: id, value, limits."""

import logging

import numpy as np
import pytest
import xarray as xr

from impactfem.spectra import response_spectra
from impactfem.stages.building import store as building_store
from impactfem.stages.check import end_check, log_checks
from impactfem.stages.pounding import store as pounding_store
from impactfem.stages.pounding.model_checks import stick_against_model
from impactfem.stages.stores import dataset
from impactfem.stages.transient.checks import SPECTRUM_END, samples_check, transient_checks
from impactfem.stages.transient.tables import transient_tables
from impactfem.system.files import write_netcdf

from ..figure_file import rows

GOOD = {
    "impulse_error": 1e-14,
    "band_max": 0.004,
    "energy_residual": 1e-13,
    "reduced_against_full": 0.002,
    "upsampling_factor": 10.0,
}
IDS = [
    "transient.points_per_cycle",
    "transient.spectrum_end",
    "transient.impulse_error",
    "transient.error_estimate",
    "transient.energy_residual",
    "transient.reduced_against_full",
]


@pytest.fixture
def checked(transient_folder):
    """The checks of a store with other numbers, highest frequency [Hz] or ratios of peaks."""

    def check(highest=100.0, end=1.02, between=1.0, **changes):
        path = transient_folder() / "transient.nc"
        store = xr.load_dataset(path, engine="netcdf4")
        numbers = {name: x for name, x in {**GOOD, **changes}.items() if x is not None}
        store = store.assign(numbers).assign_attrs(maximum_frequency=highest)
        # At one point the spectrum ends elsewhere, or a peak is between the samples.
        last = store["psa"].values[0][..., store["frequency"].values <= highest][..., -1]
        store["pfa_interpolated"][:] = last
        store["pfa_interpolated"][2, 1] /= end
        store["pfa"][:] = store["pfa_interpolated"].values
        store["pfa"][2, 1] /= between
        path.unlink()
        write_netcdf(path, store)
        return transient_checks(path.parent)

    return check


def test_all_is_well(checked):
    checks = checked()
    assert [check.id for check in checks] == IDS
    assert all(check.passed for check in checks)
    assert [check.value for check in checks] == pytest.approx([10, 1.02, 1e-14, 4e-3, 1e-13, 2e-3])


def test_one_solver_alone(checked):
    nothing = dict.fromkeys(("energy_residual", "reduced_against_full"))
    assert [check.id for check in checked(**nothing)] == IDS[:4]


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"impulse_error": 1e-3}, "impulse_error"),
        ({"band_max": 0.2}, "error_estimate"),
        ({"energy_residual": 1e-6}, "energy_residual"),
        ({"reduced_against_full": 0.01}, "reduced_against_full"),
        *(({"end": end}, "spectrum_end") for end in (1.12, 0.89, 2.3)),
    ],
)
def test_what_fails_is_a_warning(checked, caplog, change, name):
    checks = checked(**change)
    (failed,) = (check for check in checks if check.passed is False)
    assert failed.id == f"transient.{name}" and len(checks) == len(IDS)
    assert failed.value == pytest.approx(next(iter(change.values())))
    if name == "spectrum_end":
        assert failed.place == "centre_3, y, 88.91 Hz" and "1 of 12 points" in failed.detail
    with caplog.at_level(logging.DEBUG, "impactfem"):
        log_checks("B1/transient", checks)
    levels = [record.levelname for record in caplog.records]
    assert levels == ["DEBUG" if check.passed else "WARNING" for check in checks]
    assert any(message.startswith("warning: B1/transient: ") for message in caplog.messages)


@pytest.mark.parametrize(
    ("change", "value", "passed"),
    [
        ({"between": 1.25}, 0.2, False),
        ({"between": 1.04}, 0.0385, True),
        # The method "in-step" keeps the samples of the histories themselves.
        ({"upsampling_factor": 1.0}, None, None),
    ],
)
def test_too_few_samples(checked, change, value, passed):
    samples, peaks, *rest = checked(highest=450.0, **change)
    assert (samples.id, samples.passed) == (IDS[0], False)
    assert samples.value == pytest.approx(2.22, rel=1e-2) and "100 Hz" in samples.detail
    assert (peaks.id, peaks.passed) == ("transient.sampled_peaks", passed)
    assert peaks.value == (None if value is None else pytest.approx(value, rel=1e-2))
    assert value is None or "10 times finer" in peaks.detail
    assert len(rest) == len(IDS) - 1


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5])
def test_a_peak_between_ten_samples(phase):
    """The 4.9 % that the line names are never exceeded with ten samples, and with nine they are."""

    def lost(points):
        samples = np.cos(2.0 * np.pi * (np.arange(40) + phase) / points)
        return float(1.0 - samples.max())

    assert lost(10.0) <= 0.049
    assert (lost(9.0) > 0.049) == (phase == 0.5)


@pytest.mark.parametrize(("content", "ended"), [(25.0, True), (35.0, False)])
def test_where_a_spectrum_ends(content, ended):
    """A sine that rises slowly, below and above 0.3 of the last frequency of 100 Hz."""
    time = np.arange(0.0, 4.0, 1e-4)
    record = np.sin(2.0 * np.pi * content * time) * np.sin(np.pi * time / 4.0) ** 2
    found = response_spectra(record, 1e-4, [100.0], [0.0])
    ratio = found.psa[0, :, -1:] / found.zpa_interpolated[:, None]
    assert ratio[0, 0] == pytest.approx(1.0 / (1.0 - (content / 100.0) ** 2), rel=0.01)
    assert end_check(SPECTRUM_END, ["p"], ["y"], ratio, 100.0).passed is ended


def test_the_end_of_nothing():
    assert end_check(SPECTRUM_END, ["p"], ["y"], np.array([[np.nan]]), 100.0).passed is None


@pytest.mark.parametrize(("step", "points"), [(1e-3, 20.0), (2e-3, 10.0), (4e-3, 5.0)])
def test_samples(step, points):
    found = samples_check(step, 50.0)
    assert found.value == pytest.approx(points) and found.passed is (points >= 10.0)
    assert ("25 Hz" in found.detail) is (points < 10.0)


@pytest.fixture
def against_model(tmp_path):
    """The check of a stick with this frequency along y against a 3D model of 2 Hz."""

    def check(frequency, direction="y", **further):
        # Mode 1 of the 3D model twists and moves a twentieth of the mass along y.
        building = {
            "frequency": [1.5, 2.0, 3.0, 7.0],
            "effective_mass": [[0.0, 5.0], [0.0, 70.0], [80.0, 0.0], [0.0, 15.0]],
            "direction": ["x", "y"],
        }
        # The tower, which has one mode fewer, stands before the wing.
        none = np.nan
        sticks = {
            "building": ["tower", "wing"],
            "mode_frequency": [[9.0, 9.5, none], [frequency, 3.0, 5.0 * frequency]],
            "mode_effective_mass": [
                [[90.0, 0.0, none], [0.0, 90.0, none]],
                [[0.0, 80.0, 0.0], [75.0, 0.0, 20.0]],
            ],
            "mode_direction": ["x", "y"],
        } | further
        for name, outputs, values, attributes in (
            ("building", building_store.OUTPUTS, building, {"building": "wing"}),
            ("pounding", pounding_store.OUTPUTS, sticks, {"shown_direction": direction}),
        ):
            store = dataset(outputs, values, attributes=attributes)
            write_netcdf(tmp_path / f"{name}.nc", store)
        return stick_against_model(tmp_path)

    return check


@pytest.mark.parametrize(
    ("frequency", "off"),
    [(2.1, 0.05), (1.62, 0.19), (2.38, 0.19), (5.66, 1.83), (2.42, 0.21), (1.41, 0.295)],
)
def test_the_frequency_of_the_stick(against_model, frequency, off):
    (found,) = against_model(frequency)
    assert found.value == pytest.approx(off) and found.passed is (off < 0.2)
    assert found.place == "wing along y" and f"stick {frequency:.3g} Hz" in found.detail


def test_along_the_direction_that_is_shown(against_model):
    (found,) = against_model(5.66, "x")
    assert found.passed is True and found.value == 0.0 and found.place == "wing along x"
    assert against_model(5.66, "z") == []


def test_tables(transient_folder):
    folder = transient_folder()
    published = {"transient.wave_crossing": 0.006, "transient.wave_speed": 1250.0}
    probes, physics, sides = transient_tables(folder, published)
    struck = rows(sides)
    assert [row["side"] for row in struck] == ["floor 2", "floor 3"]
    assert [float(row["largest force [MN]"]) for row in struck] == pytest.approx([10.0, 20.0])
    found = {row["probe"]: row for row in rows(probes)}
    assert set(found) == {
        *(f"{kind}_{k}" for kind in ("centre", "edge") for k in (1, 2, 3)),
        *(f"line_{k}" for k in range(1, 6)),
        "corner",
    }
    row = found["edge_3"]
    assert float(row["band [m/s2]"]) == pytest.approx(0.02 * float(row["spectral peak [m/s2]"]))
    assert float(row["peak acceleration [m/s2]"]) == pytest.approx(50.0)
    assert float(row["largest displacement [cm]"]) == pytest.approx(1.0)
    assert (row["y [m]"], row["z [m]"]) == ("6.0", "12.0")
    numbers = {row["name"]: row for row in rows(physics)}
    crossing = numbers["transient.wave_crossing"]
    assert float(crossing["over published"]) == pytest.approx(0.5, rel=0.03)
    assert crossing["unit"] == "s"
    # Of the stage's own scalars those that are published.
    assert float(numbers["transient.wave_speed"]["over published"]) == 1.0
    assert "transient.plate_wave_speed" not in numbers
    assert "transient.loaded_wave_speed" not in numbers
    assert numbers["transient.psd_ratio"]["published"] == ""


def test_without_impact(transient_folder):
    probes, physics = transient_tables(transient_folder(loads=(), solver="full", maps=False), {})
    assert {row["band [m/s2]"] for row in rows(probes)} == {"0.0"}
    assert "transient.wave_crossing" not in {row["name"] for row in rows(physics)}
