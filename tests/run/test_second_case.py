"""The shipped cases are good; the second one runs through all stages, on a coarser mesh."""

import math
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import xarray as xr

from impactfem import study
from impactfem.run import loop
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"
CASES = sorted(
    path.name
    for path in GEOMETRY.glob("*.toml")
    if not path.stem.endswith("_report")
    and {"buildings", "extends"} & set(tomllib.loads(path.read_text(encoding="utf-8")))
)
# gmsh in a process of its own, as its command does; the command itself needs 'python' on the PATH.
GMSH = """
import sys
import gmsh
gmsh.initialize(["gmsh", "-setnumber", "size", "2"])
gmsh.open(sys.argv[1])
gmsh.model.mesh.generate(2)
gmsh.write(sys.argv[2])
gmsh.finalize()
"""
SMALL = """
extends = "{case}"
title = "Two frame buildings, coarse"
damping_cases = []
sensitivity = {{ parameters = ["gap"] }}
[buildings.A.structure]
modes = 8
[buildings.A.structure.mesh]
type = "file"
file = "{mesh}"
[wall_impact]
time_step = "0.4 ms"
[transient]
time_step = "1 ms"
duration = "6.8 s"
maximum_frequency = "60 Hz"
tolerance = "1 %"
fields = []
snapshots = false
probes = []
[device_analysis]
time_step = "1 ms"
combination = ["srss"]
rotations = false
broadening = 0
[pounding]
duration = "6.8 s"
time_step = "0.3 ms"
[spectra]
damping = ["5 %"]
frequencies = {{ minimum = "0.5 Hz", maximum = "100 Hz", per_decade = 10 }}
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_shipped_cases_are_good(name, caplog):
    """Also their gaps are those of their plans. The fine mesh has a test of its own."""
    study.check(GEOMETRY / name, mesh=name != "npp_pair_fine.toml")
    assert not [line for line in caplog.messages if line.startswith("warning: contacts: ")]


def test_all_shipped_cases_are_found():
    assert {"npp_pair.toml", "frame.toml", "two_frames.toml"} <= set(CASES)


def test_a_mesh_without_an_edge_is_not_good(edited, tmp_path):
    for path in GEOMETRY.glob("two_frames*"):
        shutil.copy(path, tmp_path)
    edited(tmp_path / "two_frames.msh", ('"edge_5"', '"edge_9"'))
    with pytest.raises(InputError, match="edge_9"):
        study.check(tmp_path / "two_frames.toml", mesh=True)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """All stages, without tables and pictures; not to be changed."""
    folder = tmp_path_factory.mktemp("second")
    mesh = folder / "coarse.msh"
    command = [sys.executable, "-c", GMSH, str(GEOMETRY / "two_frames.geo"), str(mesh)]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    case = folder / "coarse.toml"
    case.write_text(SMALL.format(case=GEOMETRY / "two_frames.toml", mesh=mesh), encoding="utf-8")
    return loop.run(case, out=folder / "run", draw=False, bar=False)


@pytest.fixture(scope="module")
def found(done):
    return {scalar.name: scalar.value for scalar in done.scalars}


@pytest.fixture(scope="module")
def store(done):
    with xr.open_dataset(done.folder / "pounding.nc", engine="netcdf4") as sticks_store:
        return sticks_store.load()


def test_its_forces_are_its_own(done):
    """Sticks from the 3D model and laws from the wall are filled in after the pounding is keyed."""
    assert "another case" not in (done.folder / "run.log").read_text(encoding="utf-8")


@pytest.mark.slow
def test_frequencies_are_those_of_shear_frames(found):
    """Half of the hand formula's stiffness: k = G A_v / h between the beams, which stay level."""
    G = 33e9 / 2.4
    A = ([0.0702, *[0.0843] * 5], [3.71, *[2.8] * 5], [242e3, *[238e3] * 4, 211e3])
    B = ([0.134, *[0.166] * 3], [4.525, *[3.4] * 3], [225e3, 225e3, 225e3, 190e3])
    for (A_v, h, m), computed in (
        (A, found["building.frequency.1"]),
        (B, found["sticks.B.frequency.1"]),
    ):
        k = 0.5 * G * np.array(A_v) / np.array(h)
        K = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
        first = math.sqrt(float(scipy.linalg.eigh(K, np.diag(m))[0][0])) / (2.0 * math.pi)
        assert computed == pytest.approx(first, rel=0.07)
    # The stick of A is fitted to its 3D model; cracked columns have half of their stiffness.
    assert found["sticks.stiffness_factor"] == pytest.approx(0.5, rel=0.15)
    assert found["sticks.A.frequency.1"] == pytest.approx(found["building.frequency.1"], rel=0.01)


@pytest.mark.slow
def test_they_pound_along_y_alone(store, found):
    assert store.attrs["shown_direction"] == "y"
    both = [store[name].sel(component=["x", "y"]) for name in ("displacement", "displacement_free")]
    with_contact, free = both
    largest = abs(free).max(("time", "station"))
    difference = abs(with_contact - free).max(("time", "station"))
    assert float(largest.sel(component="x")) > 0.01 and float(largest.sel(component="y")) > 0.01
    assert float(difference.sel(component="x")) < 1e-9
    assert float(difference.sel(component="y")) > 0.01
    assert found["pounding.impacts"] >= 3
    # A's first floor and B's column beside it never meet.
    assert found["pounding.peak_force.floor_1"] == 0.0
    assert found["pounding.peak_force.floor_5"] > 1e6


@pytest.mark.slow
def test_action_is_reaction(store):
    """What floor 5 of A loses in the hardest impact, the roof of B gains."""
    hardest = int(np.argmax(store["impact_peak_force"].values))
    assert str(store["impact_pair"][hardest].values) == "A.floor_5-B.floor_4"
    ends = [float(store[name][hardest]) for name in ("impact_first_contact", "impact_end")]
    change = {}
    for name in ("A.floor_5", "B.floor_4"):
        at = list(store["station"].values).index(name)
        v = store["velocity"].isel(station=at).sel(component="y").interp(time=ends).values
        change[name] = float(store["floor_mass"][at]) * (v[1] - v[0])
    impulse = float(store["impact_impulse"][hardest])
    # The storeys push, too, in these 6 ms: the rest.
    assert change["A.floor_5"] == pytest.approx(-impulse, rel=0.25)
    assert change["B.floor_4"] == pytest.approx(impulse, rel=0.25)


@pytest.mark.slow
def test_hardest_impact_is_that_of_two_masses(store):
    """Impulse and force of Kelvin-Voigt contact of free masses with this approach."""
    hardest = int(np.argmax(store["impact_peak_force"].values))
    pair = list(store["pair"].values).index(str(store["impact_pair"][hardest].values))
    v = float(store["impact_approach"][hardest])
    e, xi, K = (
        float(store[name][pair])
        for name in ("pair_restitution", "pair_damping_ratio", "pair_stiffness")
    )
    M = float(store["pair_effective_mass"][pair])
    mass = {n: float(m) for n, m in zip(store["station"].values, store["floor_mass"], strict=True)}
    a, b = mass["A.floor_5"], mass["B.floor_4"]
    assert pytest.approx(a * b / (a + b), rel=1e-9) == M
    impulse = float(store["impact_impulse"][hardest])
    assert impulse == pytest.approx(M * v * (1.0 + e), rel=0.05)
    root = math.sqrt(1.0 - xi**2)
    turn = math.atan2(root * (1.0 - 4.0 * xi**2), xi * (3.0 - 4.0 * xi**2))
    force = math.sqrt(K * M) * v * math.exp(-xi / root * turn)
    assert float(store["impact_peak_force"][hardest]) == pytest.approx(force, rel=0.05)


@pytest.mark.slow
def test_spectra_end_at_the_peak_acceleration(store):
    """Along x, where nothing pounds, at 100 Hz; where slabs hit each other, far above."""
    last = store["psa"].isel(damping=0, frequency=-1)
    ratio = last / store["pfa"]
    assert ratio.sel(direction="x").values == pytest.approx(np.ones(10), abs=0.03)
    struck = list(store["station"].values).index("A.floor_5")
    assert float(ratio.isel(station=struck).sel(direction="y")) > 1.2


@pytest.mark.slow
def test_3d_model_is_struck_on_the_floor_that_is_looked_at(done):
    with xr.open_dataset(done.folder / "transient.nc", engine="netcdf4") as response:
        names = [str(name) for name in response["probe"].values]
        line = [k for k, name in enumerate(names) if name.startswith("line_")]
        assert response["probe_position"].values[line, 2] == pytest.approx(np.full(9, 17.8))
        pfa = response["pfa"].values
        forces = {
            str(e): float(abs(response["edge_force"][:, k]).max())
            for k, e in enumerate(response["edge"].values)
        }
        ground = abs(response["ground_acceleration"]).max("time").values
    assert forces["floor 5"] > 3.0 * max(f for name, f in forces.items() if name != "floor 5")
    assert ground[0] > 1.0 and ground[1] > 1.0 and ground[2] == 0.0
    struck, roof = (names.index(f"centre_{k}") for k in (5, 6))
    assert pfa[struck, 1] > 3.0 * pfa[roof, 1]
    assert pfa[struck, 0] < 2.0 * pfa[roof, 0]


@pytest.mark.slow
def test_devices_from_a_table_and_a_body(found, done):
    with xr.open_dataset(done.folder / "device.nc", engine="netcdf4") as devices:
        names = [str(name) for name in devices["device"].values]
        assert float(devices["imbalance"].max()) < 1e-8
        along_x = devices["peak_force"].sel(component="x", case="own", analysis="detailed").values
    assert names == ["cabinet_2", "cabinet_5", "pipe_rack", "chiller"]
    for name in ("device", *(f"device.{name}" for name in names[1:])):
        assert found[f"{name}.fy.detailed.impact"] > 1.5 * found[f"{name}.fy.detailed.no_impact"]
    # The force along x hardly knows of the impacts but for the slab that turns and bends.
    assert along_x[1] == pytest.approx(along_x[0], rel=0.5)
