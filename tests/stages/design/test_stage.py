"""The stage `design` on the shipped frame: one motion, and an ensemble through the 3D model."""

import shutil
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
import xarray as xr

from frame_case import LIGHT, QUICK, SOFT_NEIGHBOUR, pump
from impactfem import study
from impactfem.run import loop
from impactfem.stages.design import members as design_members
from impactfem.system.errors import InputError
from no_pictures import no_pictures

pytestmark = pytest.mark.slow
GEOMETRY = Path(__file__).parents[3] / "geometry"
# The first member has the seed of the case's own motion. Only later ones close the gap of floor 1,
# so that its load is in no basis of the case's own.
REST = (
    """
[contact_laws.floor]
type = "kelvin-voigt"
stiffness = "1e8 N/m"
restitution = 0.6

[[contacts]]
a = { building = "F", floor = [2], offset = ["0 m", "2 m", "0 m"] }
b = { building = "G", floor = [2], offset = ["0 m", "-2 m", "0 m"] }
normal = [0, 1, 0]
gap = "0.2 mm"
law = "floor"

[[contacts]]
a = { building = "F", floor = [1], offset = ["0 m", "2 m", "0 m"] }
b = { building = "G", floor = [1], offset = ["0 m", "-2 m", "0 m"] }
normal = [0, 1, 0]
gap = "0.4 mm"
law = "floor"

[transient]
time_step = "1 ms"
maximum_frequency = "100 Hz"

[[transient.probes]]
name = "between"
point = ["6 m", "0 m", "1.125 m"]

"""
    + pump('["2 m", "2.2 m", "6 m"]', "0.8 m")
    + """
[ensemble]
motions = 4
first_seed = 8
structure_motions = 3
"""
)


@pytest.fixture(scope="module")
def case(edited, tmp_path_factory):
    folder = tmp_path_factory.mktemp("design")
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, folder)
    path = edited(
        folder / "frame.toml", ("seed = 1\n", "seed = 8\n"), *QUICK, LIGHT, SOFT_NEIGHBOUR
    )
    path.write_text(path.read_text() + REST)
    return path


@pytest.fixture(scope="module")
def done(case):
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        return loop.run(case, out=case.parent / "run", stage="design")


@pytest.fixture
def copied_run(case, done, tmp_path):
    """A copy of the finished case and its run, to be changed."""
    shutil.copytree(case.parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / "frame.toml"


def opened(folder, name):
    return xr.load_dataset(folder / name, engine="netcdf4")


def values(run):
    return {scalar.name: scalar.value for scalar in run.scalars}


def test_a_member_with_the_seed_of_the_case(done):
    """The same motion has the same spectra, impact forces and forces on the anchor."""
    found, own = opened(done.folder, "design.nc"), opened(done.folder, "transient.nc")
    one = found.isel(motion=0)
    assert str(one["motion"].values) == "seed_8"
    moving = found["psa"].values > 1e-6 * found["psa"].values.max()
    # The vertices that govern are sought among fewer frequencies, so that others may be found: both
    # have 98 % of one envelope, with the same probes, and the same vertices for most of it.
    ratio = (one["member_psa"].values / found["psa"].values)[moving]
    assert ratio.min() > 0.98 and ratio.max() < 1.0 / 0.98
    assert np.mean(np.abs(ratio - 1.0) < 1e-9) > 0.8
    probes = found["probes_psa"].values
    assert np.all(one["member_psa"].values >= probes * (1.0 - 1e-9))
    devices = opened(done.folder, "device.nc")
    force = devices["peak_force"].isel(case=0, impact=1, device=0, analysis=0).values
    np.testing.assert_allclose(one["member_device_force"].values[0], force[:6], rtol=1e-9, atol=1.0)
    scalars = values(done)
    rsa = float(one["member_device_spectrum"].values[0, 1])
    assert rsa == pytest.approx(scalars["device.fy.rsa.impact"], rel=1e-9)
    for floor in (1, 2):
        peak = scalars[f"pounding.peak_force.floor_{floor}"]
        assert float(one["member_impact_force"].sel(edge=floor)) == peak
    # Other seeds differ.
    others = found["member_psa"].isel(motion=1).values / found["psa"].values
    assert np.abs(others[moving] - 1.0).max() > 0.05
    assert own.attrs["building"] == "F"


def test_envelope_of_the_points(done):
    found, own = opened(done.folder, "design.nc"), opened(done.folder, "transient.nc")
    points = found["probe"].values[found["station_probes"].values[-1] == 1].tolist()
    assert {"centre_2", "edge_2", "line_1"} <= set(points) and "between" not in points
    assert found["elsewhere"].values.tolist() == ["between"]
    top = found.isel(station=-1).sel(direction="y")
    probes = own["psa"].sel(probe=points, component="y").max("probe").values
    np.testing.assert_allclose(top["probes_psa"].values, probes)
    assert np.all(top["psa"].values >= probes)
    single = own["psa"].sel(probe="centre_2", component="y").values
    assert np.any(probes > 1.05 * single)


def test_envelope_of_the_vertices(done):
    """Of all vertices, against the fields of the stage before; the probes alone have less."""
    found, maps = opened(done.folder, "design.nc"), opened(done.folder, "transient_maps.nc")
    names = found["direction"].values.tolist()
    for s, height in enumerate(found["elevation"].values):
        on = np.abs(maps["node_position"].values[:, 2] - height) < 0.05
        for x, direction in enumerate(names):
            field = maps["psa"].values[on, "xyz".index(direction)]
            chosen = (found["vertex_station"] == s) & (found["vertex_direction"] == direction)
            nodes = found["vertex_node"].values[chosen.values]
            assert np.isin(nodes, maps["node_number"].values[on]).all() and 0 < len(nodes) <= 24
            of_them = field[np.isin(maps["node_number"].values[on], nodes)].max(axis=0)
            assert np.all(of_them >= 0.979 * field.max(axis=0))
            largest = maps["pfa"].values[on, "xyz".index(direction)].max()
            assert found["zpa"].values[s, x] >= 0.979 * largest
    alone, peak = (found[name].values[0].max(axis=-1) for name in ("probes_psa", "psa"))
    assert (alone / peak).min() < 0.9
    coverage = [c for c in done.checks["design"] if c.id == "design.coverage"]
    assert len(coverage) == len(names) and all(check.passed for check in coverage)


def test_a_floor_that_the_case_does_not_hit(done):
    """Members hit floor 1, the case's own motion does not: the reduced building has that load."""
    found = opened(done.folder, "design.nc")
    force = found["member_impact_force"].values
    first = found["edge"].values.tolist().index(1)
    assert force[0, first] == 0.0 and force[1:, first].max() > 0.0
    (same,) = (c for c in done.checks["design"] if c.id == "design.force_difference")
    assert same.passed


def test_statistics_of_the_members(done):
    found, scalars = opened(done.folder, "design.nc"), values(done)
    top = found.isel(damping=0, station=-1).sel(direction="y")
    anchor = found.isel(device=0, component=1)
    peaks, force = top["member_psa"].max("frequency").values, anchor["member_device_force"].values
    assert (scalars["ensemble3d.members"], scalars["ensemble3d.failed"]) == (3.0, 0.0)
    for members, over in (
        (peaks, top["statistic_peak"]),
        (force, anchor["statistic_device_force"]),
    ):
        assert float(over.sel(statistic="mean")) == pytest.approx(members.mean())
        assert float(over.sel(statistic="p84")) > float(over.sel(statistic="median"))
    assert scalars["design.frs.floor_2.peak"] == pytest.approx(float(peaks[0]), rel=1e-9)


def test_reused(case, done):
    again = loop.run(case, out=done.folder, stage="design")
    assert again.reused[-1] == "design" and values(again) == values(done)


def test_an_interrupted_ensemble_goes_on(copied_run, edited, done, monkeypatch):
    """One member is lost and one is added: these alone are computed, the sticks of none again."""
    no_pictures(monkeypatch)
    edited(copied_run, ("structure_motions = 3", "structure_motions = 4"))
    folder, seeds = copied_run.parent / "run", []
    archive = folder / "design" / "members.zip"
    assert not archive.with_suffix("").exists()
    with ZipFile(archive) as whole:
        kept = {name: whole.read(name) for name in whole.namelist()}
    assert sorted(kept) == ["seed_10.npz", "seed_8.npz", "seed_9.npz"]
    with ZipFile(archive, "w") as written:
        for name in sorted(kept.keys() - {"seed_9.npz"}):
            written.writestr(name, kept[name])
    real = design_members.motion_loads

    def recorded(case, *given):
        seeds.append(case.motions[0].seed)
        return real(case, *given)

    monkeypatch.setattr(design_members, "motion_loads", recorded)
    again = loop.run(copied_run, out=folder, stage="design")
    assert seeds == [9, 11]
    with ZipFile(archive) as whole:
        assert len(whole.namelist()) == 4
    assert "ensemble" in again.reused and "design" not in again.reused
    assert values(again)["ensemble3d.members"] == 4.0
    found, known = opened(folder, "design.nc"), opened(done.folder, "design.nc")
    for name in (name for name in known if name.startswith("member_")):
        np.testing.assert_allclose(found[name].values[:3], known[name].values, rtol=1e-9)


def test_probes_alone(copied_run, edited, monkeypatch):
    """Without fields over the floors the probes stand alone: that is told, and the check fails."""
    no_pictures(monkeypatch)
    fields = 'maximum_frequency = "100 Hz"\nfields = []\nsnapshots = false\n'
    edited(copied_run, ('maximum_frequency = "100 Hz"\n', fields))
    folder = copied_run.parent / "run"
    again = loop.run(copied_run, out=folder, stage="design")
    assert "design.vertices" in {c.id for c in again.checks["design"] if c.passed is False}
    found = opened(folder, "design.nc")
    np.testing.assert_array_equal(found["psa"].values, found["probes_psa"].values)
    assert not found["member_vertices"].values.any() and "vertex" not in found.dims
    assert "PROBES ALONE" in (folder / "products" / "design_spectra.csv").read_text()


def test_without_an_ensemble(copied_run, edited, monkeypatch):
    no_pictures(monkeypatch)
    edited(copied_run, ("structure_motions = 3", "structure_motions = 0"))
    folder = copied_run.parent / "run"
    again = loop.run(copied_run, out=folder, stage="design")
    assert again.reused == ["building", "reduce", "pounding", "transient"]
    assert "motion" not in opened(folder, "design.nc").dims
    assert not any(name.startswith("ensemble3d") for name in values(again))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("structure_motions = 3", "structure_motions = 1", "expected 0, or at least 2"),
        ("structure_motions = 3", "structure_motions = 5", "at most all members, 4"),
        ("structure_motions = 3", "structure_motions = -1", "structure_motions = -1"),
        ('time_step = "1 ms"\nmax', 'time_step = "1 ms"\nsolver = "full"\nmax', "reduced model"),
    ],
)
def test_refused(case, edited, tmp_path, old, new, message):
    shutil.copytree(case.parent, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("run"))
    with pytest.raises(InputError, match=message):
        study.check(edited(tmp_path / "frame.toml", (old, new)))
