import numpy as np
import pytest
import scipy.io
import xarray as xr

from impactfem.coupling.contact import kelvin_voigt
from impactfem.coupling.force_history import (
    ForceHistory,
    PairEnds,
    check_forces,
    read_forces,
    write_forces,
    write_forces_csv,
)
from impactfem.coupling.pounding import End, Pair, System, simulate
from impactfem.sticks.stick import build_stick
from impactfem.system.errors import InputError

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
    dataset.to_netcdf(path, engine="h5netcdf")
    return path


def test_netcdf_there_and_back(response, tmp_path):
    path = tmp_path / "forces.nc"
    write_forces(path, response, "abc123", "key")
    history = read_forces(path)
    assert np.array_equal(history.force, response.force)
    assert np.array_equal(history.time, response.time)
    assert history.pairs == ("a1-b1", "a2-b2") and history.case_hash == "abc123"
    assert [p.name for p in tmp_path.iterdir()] == ["forces.nc"]


def test_what_the_file_says(response, tmp_path):
    path = tmp_path / "forces.nc"
    write_forces(path, response, "abc123", "key")
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert data["force"].dims == ("time", "pair") and data["force"].attrs["units"] == "N"
        assert data["time"].attrs["units"] == "s"
        assert list(data["building_a"].values) == ["a", "a"]
        assert list(data["building_b"].values) == ["b", "b"]
        assert list(data["floor_a"].values) == [1, 2]
        assert np.isnan(data["relative_height_a"].values).all()
        assert data["offset_b"].sel(axis="y").values == pytest.approx([-6.0, -6.0])
        assert data["offset_a"].sel(axis="x").values == pytest.approx([1.5, 1.5])
        assert data["offset_a"].attrs["units"] == "m" and data["gap"].attrs["units"] == "m"
        assert data["gap"].values == pytest.approx([0.003, 0.003])
        assert data["normal"].values == pytest.approx(np.tile(Y, (2, 1)))
        assert data["law"].size == 2
        assert data.attrs["case_hash"] == "abc123" and data.attrs["inputs"] == "key"


def test_a_storey_point_and_a_wall(floors, tmp_path):
    stick = build_stick("a", floors(2), storey_points=[(2, 0.25)])
    end = End("a", stick.storey_points[2, 0.25], (0.0, 6.0, 0.0), 2, 0.25)
    pair = Pair("wall", end, None, Y, 0.01, kelvin_voigt(1e9, 0.1, 1e5))
    path = tmp_path / "forces.nc"
    write_forces(path, simulate(System((stick,), (pair,)), np.zeros((5, 3)), DT), "")
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert data["relative_height_a"].values == pytest.approx([0.25])
        assert data["floor_a"].values == [2]
        assert data["building_b"].values == [""] and data["floor_b"].values == [0]
        assert np.isnan(data["relative_height_b"].values).all()
    history = read_forces(path)
    assert history.pairs == ("wall",)
    assert history.ends.relative_height_a == pytest.approx([0.25])
    assert (history.ends.building_b, history.ends.floor_b) == (("",), (0,))


def test_ends_there_and_back(response, tmp_path):
    path = tmp_path / "forces.nc"
    write_forces(path, response, "abc123", "key")
    history = read_forces(path)
    assert history.inputs == "key"
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


def test_no_pairs(response, tmp_path):
    path = tmp_path / "forces.nc"
    write_forces(path, simulate(response.system.without_contact(), np.zeros((5, 3)), DT), "")
    history = read_forces(path)
    assert history.pairs == () and history.force.shape == (5, 0)
    assert history.impulse.shape == (0,)
    assert history.ends.building_a == () and history.ends.normal.shape == (0, 3)


def test_csv_there_and_back(response, tmp_path):
    path = tmp_path / "forces.csv"
    history = ForceHistory(response.time, ("a1-b1", "a2-b2"), response.force, "abc")
    write_forces_csv(path, history)
    assert path.read_text().splitlines()[0] == "time [s],a1-b1 [N],a2-b2 [N]"
    found = read_forces(path)
    assert found.pairs == history.pairs and found.case_hash == ""
    assert found.ends == PairEnds() and found.of([1]).ends == PairEnds()
    assert found.time == pytest.approx(history.time, abs=1e-12)
    assert np.abs(found.force - history.force).max() < 1e-8 * history.force.max()
    assert history.force.max() > 0.0


def test_csv_of_another_program(tmp_path):
    path = tmp_path / "Foreign.CSV"
    path.write_text("time [s], north [N] , south [N]\r\n0,0,1\r\n0.5, 1e6,2\r\n1,-3.5E5,3\r\n")
    history = read_forces(path)
    assert history.pairs == ("north", "south")
    assert history.force[:, 0] == pytest.approx([0.0, 1e6, -3.5e5])


def test_csv_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "forces.csv"
    path.write_text("time [s],a [N]\n0,1\n0.5,2\n", encoding="utf-8-sig")
    assert path.read_bytes().startswith(b"\xef\xbb\xbf")
    assert read_forces(path).pairs == ("a",)
    path.write_text("\ufeff\ufefftime [s],a [N]\n0,1\n0.5,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="expected the first column"):
        read_forces(path)


def test_a_first_time_of_about_zero_is_zero(tmp_path):
    path = tmp_path / "forces.csv"
    path.write_text("time [s],a [N]\n1e-12,1\n0.5,2\n1,3\n")
    assert read_forces(path).time.size == 3


def test_csv_of_a_long_run_there_and_back(tmp_path):
    """A step that decimals do not end for, over 20 s: nine digits would not be uniform any more."""
    time = np.arange(60_001) / 3000.0
    history = ForceHistory(time, ("a-b",), 1e6 * np.sin(time)[:, None])
    write_forces_csv(tmp_path / "own.csv", history)
    found = read_forces(tmp_path / "own.csv")
    assert np.array_equal(found.time, time)
    assert found.force == pytest.approx(history.force, rel=1e-8)
    rounded = tmp_path / "rounded.csv"
    values = np.column_stack([time, history.force])
    np.savetxt(rounded, values, "%.9g", ",", header="time [s],a-b [N]", comments="")
    with pytest.raises(InputError, match="time: expected a uniform time step"):
        read_forces(rounded)


def test_impulse():
    history = ForceHistory(
        np.array([0, 0.1, 0.2]), ("a", "b"), np.array([[0, 1], [2, 1], [0, 1.0]])
    )
    assert history.impulse == pytest.approx([0.2, 0.2])


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
    minimal[name] = (dims, values)
    with pytest.raises(InputError, match=message):
        read_forces(write(minimal, tmp_path / "foreign.nc"))


def test_faults_of_the_ends_at_once(minimal, tmp_path):
    minimal["floor_a"] = ("pair", [1.5, 2.0])
    minimal["normal"] = ("pair", [1.0, 1.0])
    with pytest.raises(InputError) as caught:
        read_forces(write(minimal, tmp_path / "foreign.nc"))
    assert [fault.key for fault in caught.value.faults] == ["floor_a", "normal"]


def broken(minimal, fault):
    time, force = minimal["time"], minimal["force"]
    values = force.values.astype(float)
    if fault == "no force":
        return minimal.drop_vars("force")
    if fault == "no time":
        return minimal.drop_vars("time")
    if fault == "no pair":
        return minimal.drop_vars("pair")
    if fault == "wrong unit":
        force.attrs["units"] = "kN"
    if fault == "no unit":
        del time.attrs["units"]
    if fault == "milliseconds":
        return minimal.assign_coords(time=("time", [0.0, 100.0, 200.0], {"units": "ms"}))
    if fault == "transposed":
        return minimal.transpose("pair", "time")
    if fault == "nan":
        values[1, 1] = np.nan
    if fault == "infinite":
        values[1, 1] = np.inf
    if fault in ("nan", "infinite"):
        minimal["force"] = (("time", "pair"), values, {"units": "N"})
    if fault == "words":
        minimal["force"] = (("time", "pair"), values.astype(str).astype(object), {"units": "N"})
        minimal["force"].values[1, 1] = "much"
    times = {"uneven": [0.0, 0.1, 0.3], "descending": [0.2, 0.1, 0.0], "twice": [0.0, 0.1, 0.1]}
    if fault in times:
        return minimal.assign_coords(time=("time", times[fault], {"units": "s"}))
    if fault == "late":
        return minimal.assign_coords(time=("time", [0.1, 0.2, 0.3], {"units": "s"}))
    if fault == "one time":
        return minimal.isel(time=[0])
    if fault == "duplicate":
        return minimal.assign_coords(pair=["left", "left"])
    return minimal


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("no force", r"forces\.nc: force: expected a variable of this name in N"),
        ("no time", r"forces\.nc: time: expected a variable of this name in s"),
        ("no pair", r"pair: expected the names of the contact pairs"),
        ("wrong unit", r"force\.units = 'kN': expected the unit 'N'"),
        ("no unit", r"time\.units: expected the unit 's'"),
        ("milliseconds", r"time\.units = 'ms': expected the unit 's'"),
        ("transposed", r"force = \('pair', 'time'\): expected the dimensions \(time, pair\)"),
        ("nan", r"force = 'nan': expected finite values only"),
        ("infinite", r"finite values only"),
        ("words", r"a readable force history \(NetCDF or CSV\): .*much"),
        ("uneven", r"time: expected a uniform time step"),
        ("descending", r"time: expected at least two times, ascending"),
        ("twice", r"time: expected at least two times, ascending"),
        ("one time", r"time: expected at least two times, ascending"),
        ("late", r"time = 0.1: expected a first time of 0 s"),
        ("duplicate", r"pair = \['left', 'left'\]: expected a unique name for each pair"),
    ],
)
def test_faults_of_a_netcdf_file(minimal, tmp_path, fault, message):
    path = write(broken(minimal, fault), tmp_path / "forces.nc")
    with pytest.raises(InputError, match=message):
        read_forces(path)


def test_several_faults_at_once(minimal, tmp_path):
    minimal["force"].attrs["units"] = "lbf"
    minimal["time"].attrs["units"] = "h"
    with pytest.raises(InputError) as caught:
        read_forces(write(minimal, tmp_path / "forces.nc"))
    assert [fault.key for fault in caught.value.faults] == ["time.units", "force.units"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"line 1: expected the first column 'time \[s\]'"),
        ("t,a [N]\n0,1\n1,2\n", r"line 1 = 't': expected the first column 'time \[s\]'"),
        ("time [ms],a [N]\n0,1\n1,2\n", r"line 1 = 'time \[ms\]': expected the first column"),
        (
            "time [s],a [kN]\n0,1\n1,2\n",
            r"line 1 = \['a \[kN\]'\]: expected a column '<pair name> \[N\]'",
        ),
        ("time [s]\n0\n1\n", r"line 1: expected a column '<pair name> \[N\]' for each pair"),
        ("time [s],a [N]\n0,1,5\n1,2,5\n", "2 columns in the header, 3 below"),
        ("time [s],a [N]\n0,1\n1\n", "a readable force history"),
        ("time [s],a [N]\n0,much\n1,2\n", "a readable force history.*much"),
        ("time [s],a [N]\n0,nan\n1,2\n", "finite values only"),
        (
            "time [s],a [N]\n0,1\n",
            "forces.csv: expected at least two lines of values below the header",
        ),
        ("time [s],a [N]\n", "forces.csv: expected at least two lines of values below the header"),
        ("time [s],a [N]\n\n \n\n", "at least two lines of values below the header"),
        ("time [s],a [N]\n0.5,1\n1,2\n", r"time = 0.5: expected a first time of 0 s"),
        ("time [s],a [N]\n-1,1\n0,2\n1,3\n", r"time = -1.0: expected a first time of 0 s"),
        pytest.param(f"time [s],{'a' * 200_000}\n0,1\n", "a readable force history.*field larger"),
        pytest.param(f"{'a' * 200_000}", "a readable force history.*field larger"),
        pytest.param(f"time [s],a [N]\n0,{'a' * 200_000}\n1,2\n", "a readable force history"),
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
@pytest.mark.parametrize("content", ["missing", "folder", "junk", "half"])
def test_files_that_are_none(response, tmp_path, ending, content):
    path = tmp_path / f"forces.{ending}"
    if content == "folder":
        path.mkdir()
    elif content == "junk":
        path.write_bytes(np.random.default_rng(0).bytes(4000))
    elif content == "half":
        write_forces(path, response, "")
        path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InputError, match=rf"forces\.{ending}: "):
        read_forces(path)


def test_an_empty_netcdf_file(tmp_path):
    path = tmp_path / "forces.nc"
    path.touch()
    with pytest.raises(InputError, match="a readable force history"):
        read_forces(path)


def test_classic_netcdf_is_refused(tmp_path):
    path = tmp_path / "forces.nc"
    with scipy.io.netcdf_file(path, "w") as file:
        file.createDimension("time", 2)
    with pytest.raises(InputError, match="a readable force history"):
        read_forces(path)


def test_a_given_file_is_tried_before_it_is_read(minimal, tmp_path):
    path = write(minimal, tmp_path / "foreign.nc")
    check_forces(path)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InputError, match="a readable force history") as caught:
        check_forces(path)
    assert caught.value.faults[0].file == path
    (tmp_path / "forces.csv").write_text("time [s],a [N]\n0,1\n1\n")
    with pytest.raises(InputError, match="a readable force history"):
        check_forces(tmp_path / "forces.csv")
