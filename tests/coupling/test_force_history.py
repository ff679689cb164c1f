import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import xarray as xr

from impactfem.coupling.force_history import (
    ForceHistory,
    PairEnds,
    check_forces,
    read_forces,
    write_forces,
)
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.pounding import End, Pair, System, simulate
from impactfem.system.errors import InputError

from ..sticks.conftest import damped_stick

DT = 2.5e-4
# Debian's h5py on the NumPy 1.26 of the virtual environment.
pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")
Y = np.array([0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def response(row, shake):
    return simulate(row(0.003, x=1.5), shake(), DT)


@pytest.fixture
def minimal():
    """What a foreign program has to write, and nothing more."""
    return xr.Dataset(
        {"force": (("time", "pair"), np.array([[0, 1], [2, 0], [3, 5]]), {"units": "N"})},
        coords={"time": ("time", [0.0, 0.1, 0.2], {"units": "s"}), "pair": ["left", "right"]},
    )


def write(dataset, path):
    dataset.to_netcdf(path, engine="netcdf4")
    return path


def test_sides_that_pairs_push(response):
    """Both pairs of the row are on floors of their own; a third joins the first, a fourth not."""
    first, second = response.system.pairs
    turned = replace(first, name="back", normal=-first.normal)
    inside = replace(first, name="inside", a=replace(first.a, relative_height=0.5))
    pairs = (first, second, replace(first, name="corner"), turned, inside)
    for building, end, sign in (("a", first.a, 1.0), ("b", first.b, -1.0)):
        sides = PairEnds.of_pairs(pairs).sides(building)
        joined = [0, 2] if building == "a" else [0, 2, 4]
        assert list(sides.values())[:3] == [joined, [1], [3]]
        side = next(iter(sides))
        other = "b" if building == "a" else "a"
        assert (side.floor, side.relative_height, side.other) == (end.floor, None, other)
        assert side.outward == tuple(sign * first.normal)
    assert [one.relative_height for one in PairEnds.of_pairs(pairs).sides("a")][3:] == [0.5]
    with pytest.raises(ValueError, match="not known"):
        PairEnds().sides("a")


def test_netcdf_there_and_back(response, tmp_path):
    path = tmp_path / "forces.nc"
    write_forces(path, response, "abc123", "key")
    assert [p.name for p in tmp_path.iterdir()] == ["forces.nc"]
    with xr.open_dataset(path, engine="netcdf4") as data:
        assert data["force"].dims == ("time", "pair")
        units = {"force": "N", "time": "s", "offset_a": "m", "offset_b": "m", "gap": "m"}
        assert {name: data[name].attrs["units"] for name in units} == units
        assert data["offset_b"].sel(axis="y").values == pytest.approx([-6.0, -6.0])
        assert data["offset_a"].sel(axis="x").values == pytest.approx([1.5, 1.5])
        assert data["gap"].values == pytest.approx([0.003, 0.003]) and data["law"].size == 2
    history = read_forces(path)
    assert np.array_equal(history.force, response.force)
    assert np.array_equal(history.time, response.time)
    assert history.pairs == ("a1-b1", "a2-b2")
    assert (history.case_hash, history.inputs) == ("abc123", "key")
    ends = history.ends
    assert (ends.building_a, ends.building_b) == (("a", "a"), ("b", "b"))
    assert (ends.floor_a, ends.floor_b) == ((1, 2), (1, 2))
    assert np.isnan(ends.relative_height_a).all() and np.isnan(ends.relative_height_b).all()
    assert ends.normal == pytest.approx(np.tile(Y, (2, 1)))
    second = history.of([1])
    assert (second.pairs, second.ends.floor_a) == (("a2-b2",), (2,))
    assert np.array_equal(second.force[:, 0], response.force[:, 1])
    assert second.ends.normal.shape == (1, 3) and second.inputs == "key"
    assert history.of([1, 0]).ends.floor_b == (2, 1)


def test_a_storey_point_and_a_wall(floors, tmp_path):
    stick = damped_stick("a", floors(2), storey_points=[(2, 0.25)])
    end = End("a", stick.storey_points[2, 0.25], (0.0, 6.0, 0.0), 2, 0.25)
    pair = Pair("wall", end, None, Y, 0.01, KelvinVoigt(1e9, 0.1, mass=1e5))
    path = tmp_path / "forces.nc"
    write_forces(path, simulate(System((stick,), (pair,)), np.zeros((5, 3)), DT), "")
    with xr.open_dataset(path, engine="netcdf4") as data:
        assert data["relative_height_a"].values == pytest.approx([0.25])
        assert data["floor_a"].values == [2]
        assert data["building_b"].values == [""] and data["floor_b"].values == [0]
        assert np.isnan(data["relative_height_b"].values).all()
    history = read_forces(path)
    assert history.pairs == ("wall",)
    assert history.ends.relative_height_a == pytest.approx([0.25])
    assert (history.ends.building_b, history.ends.floor_b) == (("",), (0,))


def test_no_pairs(response, tmp_path):
    path = tmp_path / "forces.nc"
    write_forces(path, simulate(response.system.without_contact(), np.zeros((5, 3)), DT), "")
    history = read_forces(path)
    assert history.pairs == () and history.force.shape == (5, 0)
    assert history.ends.building_a == () and history.ends.normal.shape == (0, 3)


def test_csv_there_and_back(response, tmp_path):
    path = tmp_path / "forces.csv"
    history = ForceHistory(response.time, ("a1-b1", "a2-b2"), response.force, "abc")
    history.write_csv(path)
    assert path.read_text().splitlines()[0] == "time [s],a1-b1 [N],a2-b2 [N]"
    found = read_forces(path)
    assert found.pairs == history.pairs and found.case_hash == ""
    assert found.ends == PairEnds() and found.of([1]).ends == PairEnds()
    assert found.time == pytest.approx(history.time, abs=1e-12)
    assert np.abs(found.force - history.force).max() < 1e-8 * history.force.max()
    assert history.force.max() > 0.0


def test_csv_of_another_program(tmp_path):
    path = tmp_path / "Foreign.CSV"
    # A first time of about zero is zero.
    path.write_text("time [s], north [N] , south [N]\r\n1e-12,0,1\r\n0.5, 1e6,2\r\n1,-3.5E5,3\r\n")
    history = read_forces(path)
    assert history.pairs == ("north", "south") and history.time.tolist() == [1e-12, 0.5, 1.0]
    assert history.force.tolist() == [[0.0, 1.0], [1e6, 2.0], [-3.5e5, 3.0]]


def test_csv_in_other_units(tmp_path):
    path = tmp_path / "forces.csv"
    path.write_text("sep=,\ntime [ms],a [kN],b [tf],\n0,1,0,\n5,-2,1,\n")
    history = read_forces(path)
    assert history.pairs == ("a", "b") and history.time == pytest.approx([0.0, 5e-3])
    assert history.force == pytest.approx(np.array([[1e3, 0.0], [-2e3, 9806.65]]))


@pytest.mark.parametrize("name", ["forces.csv", "forces.nc"])
def test_a_file_that_is_too_large(tmp_path, name):
    with (tmp_path / name).open("wb") as stream:
        stream.truncate(10**12)  # sparse
    with pytest.raises(InputError, match="at most 500 MB"):
        read_forces(tmp_path / name)


def test_csv_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "forces.csv"
    path.write_text("time [s],a [N]\n0,1\n0.5,2\n", encoding="utf-8-sig")
    assert path.read_bytes().startswith(b"\xef\xbb\xbf")
    assert read_forces(path).pairs == ("a",)
    path.write_text("\ufeff\ufefftime [s],a [N]\n0,1\n0.5,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="the first column"):
        read_forces(path)


def test_csv_of_a_long_run_there_and_back(tmp_path):
    """A step that decimals do not end for, over 20 s: nine digits would not be uniform any more."""
    time = np.arange(60_001) / 3000.0
    history = ForceHistory(time, ("a-b",), 1e6 * np.sin(time)[:, None])
    history.write_csv(tmp_path / "own.csv")
    found = read_forces(tmp_path / "own.csv")
    assert np.array_equal(found.time, time)
    assert found.force == pytest.approx(history.force, rel=1e-8)
    rounded = tmp_path / "rounded.csv"
    values = np.column_stack([time, history.force])
    np.savetxt(rounded, values, "%.9g", ",", header="time [s],a-b [N]", comments="")
    with pytest.raises(InputError, match="uniform time step"):
        read_forces(rounded)


def test_minimal_file_of_another_program(minimal, tmp_path):
    minimal["remark"] = ("time", [1.0, 2.0, 3.0])
    history = read_forces(write(minimal, tmp_path / "foreign.nc"))
    assert history.pairs == ("left", "right") and history.case_hash == ""
    assert history.force.dtype == float and history.force[2, 1] == 5.0
    assert history.time == pytest.approx([0.0, 0.1, 0.2])
    assert history.ends == PairEnds() and history.inputs == ""


def test_ends_of_another_program(minimal, tmp_path):
    """Floors as decimals, and no coordinate along the axis; what is missing is not known."""
    minimal["floor_a"] = ("pair", [3.0, 4.0])
    minimal["building_a"] = ("pair", ["left house", "right house"])
    minimal["normal"] = (("pair", "axis"), [[0.6, 0.8, 0.0], [0.0, -1.0, 0.0]])
    ends = read_forces(write(minimal, tmp_path / "foreign.nc")).ends
    assert ends.floor_a == (3, 4) and ends.building_a == ("left house", "right house")
    assert ends.normal[0] == pytest.approx([0.6, 0.8, 0.0])
    assert ends.building_b is None and ends.relative_height_a is None


@pytest.mark.parametrize(
    ("name", "dims", "values", "message"),
    [
        ("floor_a", "pair", [1.5, 2.0], r"floor_a = \[1\.5, 2\.0\]: whole numbers"),
        ("floor_b", "pair", [np.nan, 2.0], r"floor_b = \[nan, 2\.0\]: whole numbers"),
        ("floor_b", "pair", ["one", "two"], r"a readable force history.*one"),
        ("floor_a", "time", [1, 2, 3], r"floor_a = \('time',\): expected the dimensions \(pair\)"),
        ("building_a", (), "house", r"building_a = \(\): expected the dimensions \(pair\)"),
        ("relative_height_a", "pair", [0.5, 1.5], "relative_height_a = .*: 0 to 1, or nan"),
        ("relative_height_b", "pair", [-0.1, np.nan], "relative_height_b = .*: 0 to 1, or nan"),
        ("normal", ("pair", "axis"), [[0, 1, 0], [0, 2, 0]], "normal = .*: a unit vector"),
        ("normal", ("pair", "axis"), [[0, 1, 0], [0, np.nan, 0]], "normal = .*: a unit vector"),
        ("normal", ("pair", "axis"), [[0, 1], [1, 0]], r"normal = .*\(pair, axis\), of x, y, z"),
        ("normal", ("axis", "pair"), [[0, 0], [1, 1], [0, 0]], r"normal = \('axis', 'pair'\)"),
        ("normal", "pair", [1.0, 1.0], r"normal = \('pair',\): expected the dimensions"),
        ("axis", "axis", ["y", "x", "z"], r"axis = \['y', 'x', 'z'\]: x, y, z"),
    ],
)
def test_faults_of_the_ends(minimal, tmp_path, name, dims, values, message):
    """Each is told, another one as well."""
    minimal["floor_a"] = ("pair", [0.5, 2.0])
    minimal[name] = (dims, values)
    with pytest.raises(InputError, match=message) as caught:
        read_forces(write(minimal, tmp_path / "foreign.nc"))
    words = isinstance(values[0], str) and name.startswith("floor")
    assert len(caught.value.faults) == (1 if name == "floor_a" or words else 2)


def at_times(*times, units="s"):
    return lambda data: data.assign_coords(time=("time", list(times), {"units": units}))


def with_force(value, **attributes):
    """With one of the forces replaced."""

    def changed(data):
        force = data["force"].values.astype(object if isinstance(value, str) else float)
        force[1, 1] = value
        force = force.astype(str).astype(object) if isinstance(value, str) else force
        return data.assign(force=(("time", "pair"), force, {"units": "N"} | attributes))

    return changed


@pytest.mark.parametrize(
    ("change", "messages"),
    [
        (
            lambda data: data.drop_vars(["force", "pair"]),
            [
                r"forces\.nc: force: expected a variable of this name in N",
                "pair: expected the names of the contact pairs",
            ],
        ),
        (lambda data: data.drop_vars("time"), ["time: expected a variable of this name in s"]),
        (with_force(1.0, units="kN"), [r"force\.units = 'kN': expected the unit 'N'"]),
        (
            at_times(0.0, 1.0, 2.0, units=""),
            [r"time\.units(: expected| = '': expected) the unit 's'"],
        ),
        (at_times(0.0, 100.0, 200.0, units="ms"), [r"time\.units = 'ms': expected the unit 's'"]),
        (
            lambda data: data.transpose("pair", "time"),
            [r"force = \('pair', 'time'\): expected the dimensions \(time, pair\)"],
        ),
        (with_force(np.nan), ["force = 'nan': expected finite values only"]),
        (with_force(np.inf), ["finite values only"]),
        (with_force("much"), [r"a readable force history \(NetCDF or CSV\): .*much"]),
        (at_times(0.0, 0.1, 0.3), ["time, between .* s: expected a uniform time step, 0.15 s"]),
        (at_times(0.2, 0.1, 0.0), ["time: expected at least two times, ascending"]),
        (at_times(0.0, 0.1, 0.1), ["time: expected at least two times, ascending"]),
        (lambda data: data.isel(time=[0]), ["time: expected at least two times, ascending"]),
        (at_times(0.1, 0.2, 0.3), ["time = 0.1: expected a first time of 0 s"]),
        (
            lambda data: data.assign_coords(pair=["left", "left"]),
            [r"pair = \['left', 'left'\]: expected a unique name for each pair"],
        ),
    ],
)
def test_faults_of_a_netcdf_file(minimal, tmp_path, change, messages):
    with pytest.raises(InputError) as caught:
        read_forces(write(change(minimal), tmp_path / "forces.nc"))
    found = str(caught.value)
    assert all(re.search(message, found) for message in messages), found


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"the file is empty; expected a force history \(CSV\) with the header time \[s\]"),
        ("t,a [N]\n0,1\n1,2\n", r"line 1 = 't': expected the first column 'time \[s\]'"),
        ("time,a [N]\n0,1\n1,2\n", r"line 1, column time: no unit; .* 'time \[s\]'"),
        ("time [s],a\n0,1\n1,2\n", r"line 1, column a: no unit; .* 'a \[N\]'"),
        ("time [s],a [kg]\n0,1\n1,2\n", r"column a \[kg\]: 'kg' is a mass; write 'kgf'"),
        ("time [s]\n0\n1\n", r"line 1: expected a column '<pair name> \[N\]' for each pair"),
        ("time [s],a [N]\n0,1,5\n1,2,5\n", "line 2: expected 2 cells as in the header, found 3"),
        ("time [s],a [N]\n0,1\n1\n", "line 3: expected 2 cells as in the header, found 1"),
        ("time [s],a [N]\n0,much\n1,2\n", r"line 2, column a \[N\] = 'much': expected a fin"),
        ("time [s],a [N]\n0,nan\n1,2\n", r"line 2, column a \[N\] = 'nan': expected a finite"),
        ("time [s],a [N]\n0,1\n0.005,100#5\n", r"line 3, column a \[N\] = '100#5': expected a f"),
        ("time [s];a [N]\n0;1\n1;2\n", "separated by semicolons; expected commas"),
        ("time [s],a [N]\n0,1,5\n1,2,5\n", "line 3: expected 2 cells"),
        (
            "time [s],a [N]\n0,1\n",
            "forces.csv: expected at least two lines of values below the header",
        ),
        ("time [s],a [N]\n", "forces.csv: the table has no row below its header"),
        ("time [s],a [N]\n\n \n,\n", "forces.csv: the table has no row below its header"),
        ("time [s],a [N]\n0.5,1\n1,2\n", r"time = 0.5: expected a first time of 0 s"),
        ("time [s],a [N]\n-1,1\n0,2\n1,3\n", r"time = -1.0: expected a first time of 0 s"),
        pytest.param(f"time [s],{'a' * 200_000}\n0,1\n", "line 1: not a line .*field larger"),
        pytest.param(f"{'a' * 200_000}", "line 1: not a line .*field larger"),
        pytest.param(f"time [s],a [N]\n0,{'a' * 200_000}\n1,2\n", "line 2: not a line of a CSV"),
        ("time [s],a [N]\n1,1\n0,1\n", "at least two times, ascending"),
        ("time [s],a [N]\n0,1\n1,1\n3,1\n", "a uniform time step"),
        ("time [s],a [N],a [N]\n0,1,1\n1,1,1\n", "a unique name for each pair"),
    ],
)
def test_faults_of_a_csv_file(tmp_path, text, message):
    path = tmp_path / "forces.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_forces(path)


@pytest.mark.parametrize("ending", ["nc", "csv"])
@pytest.mark.parametrize("content", ["missing", "folder", "junk", "half", "empty", "classic"])
def test_files_that_are_none(response, tmp_path, ending, content):
    path = tmp_path / f"forces.{ending}"
    if content == "folder":
        path.mkdir()
    elif content == "junk":
        path.write_bytes(np.random.default_rng(0).bytes(4000))
    elif content == "half":
        write_forces(path, response, "")
        path.write_bytes(path.read_bytes()[:3000])
    elif content == "empty":
        path.touch()
    elif content == "classic":
        with scipy.io.netcdf_file(path, "w") as file:
            file.createDimension("time", 2)
    with pytest.raises(InputError, match=rf"forces\.{ending}: "):
        read_forces(path)


def test_a_given_file_is_tried_before_it_is_read(minimal, tmp_path):
    path = write(minimal, tmp_path / "foreign.nc")
    check_forces(path)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InputError, match="a readable force history") as caught:
        check_forces(path)
    assert caught.value.faults[0].file == path
    (tmp_path / "forces.csv").write_text("time [s],a [N]\n0,1\n1\n")
    with pytest.raises(InputError, match="line 3: expected 2 cells"):
        check_forces(tmp_path / "forces.csv")
