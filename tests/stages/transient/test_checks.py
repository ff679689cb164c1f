"""The checks of the stage `transient` in words."""

import logging

import numpy as np
import pytest
import xarray as xr

from impactfem.spectra import response_spectra
from impactfem.stages.building import store as building_store
from impactfem.stages.check import end_check, log_checks
from impactfem.stages.pounding import store as pounding_store
from impactfem.stages.pounding.checks import stick_against_model
from impactfem.stages.stores import dataset
from impactfem.stages.transient.checks import samples_check, transient_checks
from impactfem.stages.transient.tables import transient_tables
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

from ..figure_file import rows

GOOD = {
    "impulse_error": 1e-14,
    "band_max": 0.004,
    "energy_residual": 1e-13,
    "reduced_against_full": 0.002,
    "points_per_cycle": 20.0,
}
LINES = [
    "transient: step 1 ms, points in a cycle of 100 Hz 10 (at least 10)",
    "transient: spectra at 88.91 Hz over the peak acceleration 1.02 (limit 1.1 or 1/1.1) at "
    "centre_3, y",
    "transient: error of the impulses 1e-14 (limit 1e-9)",
    "transient: error band of the spectra 0.4 % (limit 5 %)",
    "transient: energy identity 1e-13 (limit 1e-9)",
    "transient: difference of the spectra, reduced from full 0.2 % (limit 0.5 %)",
]


@pytest.fixture
def logged(transient_folder, caplog):
    """What is logged for a store with other scalars, highest frequency [Hz] or ratios of peaks."""

    def log(highest=100.0, end=1.02, between=1.0, **changes):
        path = transient_folder() / "transient.nc"
        store = xr.load_dataset(path, engine="netcdf4")
        scalars = [Scalar(f"transient.{name}", x, "-") for name, x in {**GOOD, **changes}.items()]
        store = with_scalars(store, scalars).assign_attrs(maximum_frequency=highest)
        # At one point the spectrum ends elsewhere, or a peak is between the samples.
        last = store["psa"].values[0][..., store["frequency"].values <= highest][..., -1]
        store["pfa_interpolated"][:] = last
        store["pfa_interpolated"][2, 1] /= end
        store["pfa"][:] = store["pfa_interpolated"].values
        store["pfa"][2, 1] /= between
        path.unlink()
        write_netcdf(path, store)
        with caplog.at_level(logging.DEBUG, "impactfem"):
            log_checks(transient_checks(path.parent))
        return [(record.levelname, record.getMessage()) for record in caplog.records]

    return log


def test_all_is_well(logged):
    assert logged() == [("DEBUG", line) for line in LINES]


def test_one_solver_alone(logged):
    nothing = dict.fromkeys(("energy_residual", "reduced_against_full"))
    assert [line for _, line in logged(**nothing)] == LINES[:4]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"impulse_error": 1e-3}, "error of the impulses 0.001 (limit 1e-9)"),
        ({"band_max": 0.2}, "error band of the spectra 20 % (limit 5 %)"),
        ({"energy_residual": 1e-6}, "energy identity 1e-6 (limit 1e-9)"),
        (
            {"reduced_against_full": 0.01},
            "difference of the spectra, reduced from full 1 % (limit 0.5 %)",
        ),
        *(
            (
                {"end": end},
                f"spectra at 88.91 Hz over the peak acceleration {end:g} (limit 1.1 or 1/1.1) at "
                "centre_3, y; so it is at 1 of 12 points: raise the highest frequency of "
                "[spectra]; under a law whose force begins with a jump (kelvin-voigt) they may end "
                "nowhere, and what is there depends on the time step",
            )
            for end in (1.12, 0.89, 2.3)
        ),
    ],
)
def test_what_fails_is_a_warning(logged, change, line):
    found = logged(**change)
    assert [text for level, text in found if level == "WARNING"] == [f"warning: transient: {line}"]
    assert len(found) == len(LINES)


SAMPLES = (
    "transient: step 1 ms, points in a cycle of 450 Hz 2.22 (at least 10): resolved up to 100 Hz"
)


@pytest.mark.parametrize(
    ("change", "level", "line"),
    [
        (
            {"between": 1.25},
            "WARNING",
            "warning: transient: peak accelerations, samples low by 20 % (limit 4.89 %) at "
            "centre_3, y: printed peak accelerations and ZPA are sampled values; spectra at the "
            "probes are those of histories made 10 times finer by band-limited interpolation",
        ),
        (
            {"between": 1.04},
            "DEBUG",
            "transient: peak accelerations, samples low by 3.85 % (limit 4.89 %) at "
            "centre_3, y: printed peak accelerations and ZPA are sampled values; spectra at the "
            "probes are those of histories made 10 times finer by band-limited interpolation",
        ),
        (
            # As the method "in-step" leaves it: the samples of the histories themselves.
            {"points_per_cycle": 2.0},
            "DEBUG",
            "transient: peak accelerations may be more than 4.9 % low between the samples",
        ),
    ],
)
def test_too_few_samples(logged, change, level, line):
    found = logged(highest=450.0, **change)
    assert found[:2] == [("WARNING", f"warning: {SAMPLES}"), (level, line)]
    assert len(found) == len(LINES) + 1


def test_how_much_finer_is_what_the_spectra_did():
    record = np.sin(np.arange(64.0))
    spectra = response_spectra(record, 1e-3, [0.5, 500.0], [0.05], points_per_cycle=20)
    assert spectra.upsampling_factor == round(spectra.points_per_cycle * 1e-3 * 500.0) == 10


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
    assert end_check("any", ["p"], ["y"], ratio, 100.0)[0] is ended


def test_the_end_of_nothing():
    assert end_check("any", ["p"], ["y"], np.array([[np.nan]]), 100.0)[0] is None


@pytest.mark.parametrize(
    ("step", "points", "more"),
    [(1e-3, "20", ""), (2e-3, "10", ""), (4e-3, "5", ": resolved up to 25 Hz")],
)
def test_samples(step, points, more):
    text = f"transient: step {1e3 * step:g} ms, points in a cycle of 50 Hz {points} (at least 10)"
    assert samples_check(step, 50.0) == (not more, f"{text}{more}")


@pytest.fixture
def checked(tmp_path):
    """The check of a stick with this frequency along y beside a 3D model of 2 Hz."""

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


@pytest.mark.parametrize(("frequency", "off"), [(2.1, "5 %"), (1.62, "19 %"), (2.38, "19 %")])
def test_near_enough(checked, frequency, off):
    ((good, text),) = checked(frequency)
    assert good is True
    assert text == (
        f"transient: wing along y, stick {frequency:.3g} Hz, 3D model 2 Hz: difference {off} "
        "(limit 20 %)"
    )


@pytest.mark.parametrize("frequency", [5.66, 2.42, 1.41])
def test_another_building(checked, frequency):
    ((good, text),) = checked(frequency)
    assert good is False
    assert f"stick {frequency:.3g} Hz, 3D model 2 Hz" in text and "from_structure" in text
    assert "the stick is that of another building" in text  # nothing pounds
    ((_, text),) = checked(frequency, impact_peak_force=[1e6])
    assert "the impact forces are those of another building" in text


def test_along_the_direction_that_is_shown(checked):
    ((good, text),) = checked(5.66, "x")
    assert good is True and "along x, stick 3 Hz, 3D model 3 Hz: difference 0 %" in text
    assert checked(5.66, "z") == []


def test_tables(transient_folder):
    folder = transient_folder()
    published = {"transient.wave_crossing": 0.006, "transient.wave_speed": 1250.0}
    probes, physics, sides, *densities = transient_tables(folder, published)
    assert [path.stem for path in densities] == [
        "transient_edge_density",
        "transient_force_density",
    ]
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
    probes, physics, edges = transient_tables(
        transient_folder(loads=(), solver="full", maps=False), {}
    )
    assert {row["band [m/s2]"] for row in rows(probes)} == {"0.0"}
    assert "transient.wave_crossing" not in {row["name"] for row in rows(physics)}
    assert edges.stem == "transient_edge_density"
