from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from impactfem.coupling.laws import Hertz, Jankowski
from impactfem.stages.pounding.store import OUTPUTS, stick_scalars, write_motion, write_sticks
from impactfem.system.scalar import scalars_of

from .conftest import CALIBRATION

# Debian's h5py on the NumPy 1.26 of the virtual environment.
pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


def stored(write, study, folder):
    path = folder / "store.nc"
    write(path, study, "key-of-the-inputs")
    assert [file.name for file in folder.iterdir()] == ["store.nc"]
    return xr.load_dataset(path, engine="netcdf4")


@pytest.fixture(scope="module")
def sticks(study, tmp_path_factory):
    return stored(write_sticks, study, tmp_path_factory.mktemp("sticks"))


def test_motion(study, tmp_path):
    data = stored(write_motion, study, tmp_path)
    accelerogram = study.motions[0].accelerogram
    assert np.array_equal(data["acceleration"], [accelerogram.acceleration])
    assert data["acceleration"].attrs["units"] == "m/s2"
    assert data["time"].attrs["units"] == "s" and data["frequency"].attrs["units"] == "Hz"
    assert np.array_equal(data["spectrum"], [study.motions[0].spectrum.psa[0, 0]])
    assert np.array_equal(data["target"], [study.motions[0].target])
    assert (data["direction"].values, data["damping"].values) == (["y"], [0.05])
    assert data.attrs["inputs"] == "key-of-the-inputs" and data.attrs["title"] == study.case.title


def test_two_motions_and_a_record_without_a_target(study, tmp_path):
    first = study.motions[0]
    record = replace(first, direction="x", target=None, misfit=None)
    data = stored(write_motion, replace(study, motions=(first, record)), tmp_path)
    assert list(data["direction"].values) == ["y", "x"]
    assert list(data["target"].isnull().all("oscillator").values) == [False, True]


def test_motions_of_unequal_length(study, tmp_path):
    first = study.motions[0]
    shorter = replace(first.accelerogram, acceleration=first.accelerogram.acceleration[:-100])
    both = (first, replace(first, direction="x", accelerogram=shorter))
    data = stored(write_motion, replace(study, motions=both), tmp_path)
    lengths = data["acceleration"].notnull().sum("sample")
    assert list(lengths.values) == [len(m.accelerogram.acceleration) for m in both]
    assert np.array_equal(data["time"].notnull(), data["acceleration"].notnull())


def test_histories(study, sticks):
    assert list(sticks["station"].values[[0, 5]]) == ["west.floor_1", "east.floor_3"]
    assert list(sticks["station_floor"].values) == [1, 2, 3, 1, 2, 3]
    # Central pounding along y: nothing else moves than these two.
    assert list(sticks["component"].values) == ["y", "rx"]
    top = sticks.isel(station=5).sel(component="y")
    assert np.array_equal(top["displacement"], study.response.u[:, 31])
    assert np.array_equal(top["velocity"], study.response.v[:, 31])
    assert np.array_equal(top["acceleration"], study.response.absolute_acceleration[:, 31])
    assert np.array_equal(top["displacement_free"], study.free.u[:, 31])
    assert np.array_equal(top["acceleration_free"], study.free.absolute_acceleration[:, 31])
    assert not np.array_equal(top["displacement"], top["displacement_free"])
    assert sticks["ground"].dims == ("time", "axis")
    assert sticks["elevation"].values == pytest.approx([3.5, 7.0, 10.5] * 2)
    assert sticks["floor_mass"].values == pytest.approx([240e3, 240e3, 192e3] * 2)


def test_units(sticks):
    for name, variable in sticks.variables.items():
        if variable.dtype.kind == "f":
            assert variable.attrs["units"], name
            assert name not in OUTPUTS or variable.attrs["units"] == OUTPUTS[name].unit


def test_spectra(study, sticks):
    assert sticks["psa"].dims == ("damping", "station", "direction", "frequency")
    assert np.array_equal(sticks["psa"], study.floors.psa)
    assert np.array_equal(sticks["sd_free"], study.floors_free.sd)
    assert np.array_equal(sticks["pfa"], study.floors.pfa)
    assert list(sticks["damping"].values) == [0.02, 0.05]
    assert list(sticks["direction"].values) == ["y"]


def test_modes(study, sticks):
    east = study.modes[1]
    assert np.array_equal(sticks["mode_frequency"][1], east.frequency)
    assert list(sticks["mode_family"].values[1]) == list(east.family)
    assert np.array_equal(sticks["mode_effective_mass"][1], east.effective_mass)
    # Floor 2 of east is station 4: components 6 to 11 of its modes.
    assert np.array_equal(sticks["mode_shape"][4], east.shape[6:12].T)


def test_impacts_and_pairs(study, sticks):
    main = int(np.argmax(sticks["impact_peak_force"].values))
    found = study.impacts[main]
    assert found is study.main_impact
    assert sticks["impact_pair"].values[main] == found.pair.name
    for name in ("peak_force", "impulse", "duration", "approach", "separation", "steps"):
        assert sticks[f"impact_{name}"].values[main] == getattr(found, name)
    assert sticks["impact_first_contact"].values[main] == found.start
    assert sticks["impact_storey_shear"].values[main] == study.checks[main].storey_shear
    assert list(sticks["pair"].values) == [pair.name for pair in study.system.pairs]
    assert np.array_equal(sticks["gap"], study.response.gap)
    assert sticks["pair_restitution"].values == pytest.approx([0.65] * 3)
    assert sticks["pair_effective_mass"].values == pytest.approx([120e3, 120e3, 96e3])
    margins = [separation.margin for separation in study.separations]
    assert sticks["pair_margin"].values == pytest.approx(margins)
    # The plan of the small case has 2 cm between the buildings, of which it takes 5 mm.
    assert sticks["pair_distance"].values == pytest.approx(0.02)


def test_what_the_summary_needs(study, sticks):
    assert [s.name for s in scalars_of(sticks)] == [s.name for s in stick_scalars(study)]
    assert sticks.attrs["case_hash"] == study.case.content_hash()
    assert sticks.attrs["inputs"] == "key-of-the-inputs"
    assert sticks.attrs["studied_building"] == "west" and sticks.attrs["shown_direction"] == "y"


def test_calibration_only_where_there_is_one(study, sticks, tmp_path):
    assert "target_frequency" not in sticks
    (tmp_path / "fitted").mkdir()
    data = stored(write_sticks, replace(study, calibration=CALIBRATION), tmp_path / "fitted")
    assert list(data["target_building"].values) == ["west", "east"]
    assert list(data["target_mode"].values) == [1, 2]
    assert data["target_frequency"].values == pytest.approx([2.0, 8.0])
    assert data["calibrated_frequency"].values == pytest.approx([2.1, 7.0])
    masses = data["target_effective_mass"].values
    assert masses[0] == 500e3 and np.isnan(masses[1])


def test_an_impact_that_begins_at_rest(study, tmp_path):
    """The main impact alone."""
    k = study.impacts.index(study.main_impact)
    impact = replace(study.main_impact, approach=0.0)
    checks = (replace(study.checks[k], impact=impact),)
    resting = replace(study, impacts=(impact,), checks=checks)
    data = stored(write_sticks, resting, tmp_path)
    assert data["impact_approach"].values == [0.0]
    values = {scalar.name: scalar.value for scalar in stick_scalars(resting)}
    assert values["pounding.main_impact_restitution"] is None
    assert values["pounding.main_impact_approach_velocity"] == 0.0
    assert values["pounding.main_impact_duration"] == study.main_impact.duration


def test_laws_in_the_store(study, tmp_path):
    """Each pair with a law of its own, as far as it is known."""
    pairs = study.system.pairs
    others = (pairs[0].law, Hertz(3e11, mass=120e3), Jankowski(3e11, 0.4, mass=96e3))
    changed = tuple(replace(pair, law=law) for pair, law in zip(pairs, others, strict=True))
    system = replace(study.system, pairs=changed)
    data = stored(write_sticks, replace(study, system=system), tmp_path)
    assert list(data["pair_law"].values) == ["kelvin-voigt", "hertz", "jankowski"]
    assert data["pair_stiffness"].values == pytest.approx([1.2e10, 3e11, 3e11])
    assert list(data["pair_stiffness_unit"].values) == ["N/m", "N/m^1.5", "N/m^1.5"]
    assert data["pair_asked"].values == pytest.approx([0.65, 1.0, 0.4])
    assert data["pair_restitution"].values == pytest.approx([0.65, 1.0, 0.393], abs=1e-4)
    assert list(np.isnan(data["pair_dashpot"].values)) == [False, True, True]
    assert list(np.isnan(data["pair_damping_ratio"].values)) == [False, True, False]
    fastest = [
        max((i.approach for i in study.impacts if i.pair.name == pair.name), default=np.nan)
        for pair in pairs
    ]
    onset, duration = data["pair_onset_force"].values, data["pair_law_duration"].values
    touched = np.isfinite(fastest)
    expected = np.where(touched, [others[0].parameters[1] * fastest[0], 0.0, 0.0], np.nan)
    assert onset == pytest.approx(expected, abs=1e-30, nan_ok=True)
    # That of the first law, which is linear, is known without an impact.
    lasts = [others[0].duration(1.0)]
    lasts += [
        law.duration(v) if known else np.nan
        for law, v, known in zip(others[1:], fastest[1:], touched[1:], strict=True)
    ]
    assert duration == pytest.approx(lasts, nan_ok=True) and np.isfinite(duration[2])


def test_a_pair_that_never_touches_has_no_onset(study, tmp_path):
    """Its dashpot times a speed that nothing had is no result; a linear law's duration is one."""
    pairs = study.system.pairs
    laws = (pairs[0].law, Hertz(3e11, mass=120e3), pairs[2].law)
    changed = tuple(replace(pair, law=law) for pair, law in zip(pairs, laws, strict=True))
    system = replace(study.system, pairs=changed)
    only_last = tuple(impact for impact in study.impacts if impact.pair.name == pairs[2].name)
    alone = replace(study, system=system, impacts=only_last, checks=study.checks[: len(only_last)])
    data = stored(write_sticks, alone, tmp_path)
    assert only_last
    assert list(np.isnan(data["pair_onset_force"].values)) == [True, True, False]
    assert list(np.isnan(data["pair_law_duration"].values)) == [False, True, False]


def test_no_contacts(no_contacts, tmp_path):
    data = stored(write_sticks, no_contacts, tmp_path)
    assert data.sizes["pair"] == 0 == data.sizes["impact"]
    assert data["gap"].shape == (8001, 0)
    assert np.array_equal(data["displacement"], data["displacement_free"])


def test_buildings_of_different_height(small_case, run, tmp_path):
    """A lower building: its missing modes are nan, and the storey of the other one is hit."""
    contacts = """
[[contacts]]
a = { building = "west", floor = 3, offset = ["0 m", "6 m", "0 m"] }
b = { building = "east", level = "10.5 m", offset = ["0 m", "-6 m", "0 m"] }
normal = [0, 1, 0]
gap = "0.5 cm"
law = "floor"
"""
    low = "floor,mass [t],Jx [t m2],Jy [t m2],Jz [t m2],Ix [m4],Iy [m4],Iz [m4],A [m2],"
    low += "Avy [m2],Avx [m2],storey_height [m]\n1,240,2880,8000,10880,0.9,0.9,1.8,3.4,1,1,12\n"
    case = small_case(
        ('floors = "small_floors.csv"          # the same', 'floors = "low.csv" #'),
        ('floor = [1, 2, 3], offset = ["0 m", "6 m"', 'floor = 1, offset = ["0 m", "6 m"'),
        ('floor = [1, 2, 3], offset = ["0 m", "-6', 'level = "3.5 m", offset = ["0 m", "-6'),
        extra=contacts,
        files={"low.csv": low},
    )
    study = run(case)
    data = stored(write_sticks, study, tmp_path)
    assert data.sizes["station"] == 4 and data.sizes["mode"] == 18
    assert np.isfinite(data["mode_frequency"].values[1]).sum() == 6
    assert list(data["mode_family"].values[1][6:]) == [""] * 12
    assert np.array_equal(data["mode_shape"][3, :6], study.modes[1].shape[:6].T)
    assert data["displacement"].shape == (8001, 4, 2)
    assert study.response.u.shape[1] == 18 + 6 + 2 * 6  # two points in the storey
    names = [scalar.name for scalar in stick_scalars(study)]
    assert "pounding.peak_force.floor_3" in names and "pounding.peak_force.floor_2" not in names
