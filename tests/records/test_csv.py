import numpy as np
import pytest

from impactfem.records import read_record
from impactfem.records.accelerogram import Accelerogram
from impactfem.records.csv import write_csv
from impactfem.system.errors import InputError

HEADER = "time [s],NS [g],Up [cm/s2]"
SEVERAL = f"{HEADER}\n0,0,1\n0.01,1.5,2\n0.02,-2,3\n"
GOOD = "time [s],acceleration [m/s2]\n0,0\n0.01,1.5\n0.02,-2\n"


def written(tmp_path, content):
    path = tmp_path / "north.csv"
    path.write_text(content, encoding="utf-8", newline="")
    return path


def test_round_trip(tmp_path):
    samples = np.random.default_rng(0).standard_normal(300) * 1e-3
    path = tmp_path / "motion.csv"
    write_csv(Accelerogram(0.3358e-3, samples), path)
    back = read_record(path)
    assert np.array_equal(back.acceleration, samples)
    assert back.time_step == pytest.approx(0.3358e-3, rel=1e-14)
    assert (back.name, back.origin) == ("motion", "record motion.csv")


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        *((unit, 1.0) for unit in ("m/s2", "m/s^2", "m/s**2", "m/s²", "m s-2")),
        *((unit, 0.01) for unit in ("cm/s2", "cm/sec^2", "cm/s/s", "gal", "Gal")),
        ("mm/s2", 0.001),
        ("g", 9.80665),
    ],
)
def test_units_of_acceleration(tmp_path, unit, factor):
    record = read_record(written(tmp_path, GOOD.replace("m/s2", unit)))
    assert record.acceleration == pytest.approx(factor * np.array([0.0, 1.5, -2.0]))


def test_other_layouts(tmp_path):
    text = "\ufeff# station X\r\n\r\nAcceleration [g], Time [ms]\r\n1, 0\r\n 2.5e-1 ,5\r\n.5,10\r\n"
    record = read_record(written(tmp_path, text))
    quoted = '"time [s]","acceleration [g]"\n"0","1"\n0.005, ".25"\n0.01,0.5\n,\n'
    assert np.array_equal(record.acceleration, read_record(written(tmp_path, quoted)).acceleration)
    assert record.time_step == pytest.approx(0.005)
    assert record.acceleration == pytest.approx(9.80665 * np.array([1.0, 0.25, 0.5]))


@pytest.mark.parametrize(
    "text",
    [
        f"sep=,\n{GOOD}",
        f'"sep=,",,\n{GOOD}',
        GOOD.replace("\n", ",\n"),
        GOOD.replace("\n", ",,\n"),
        f"# x,,\n{GOOD.replace('[m/s2]', '[m/s2],')},,\n",
    ],
)
def test_what_spreadsheets_add(tmp_path, text):
    record = read_record(written(tmp_path, text))
    assert record.acceleration.tolist() == [0.0, 1.5, -2.0]
    with pytest.raises(InputError, match="semicolons"):
        read_record(written(tmp_path, "sep=;\n" + GOOD.replace(",", ";")))
    with pytest.raises(InputError, match="3 = '': expected a finite number"):
        read_record(written(tmp_path, GOOD.replace("0.01,1.5", "0.01,")))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("# only a comment\n", "no header"),
        (GOOD.replace(" [m/s2]", ""), "line 1 = 'acceleration': expected a unit of acceleration"),
        (GOOD.replace("m/s2", "m/s"), "expected a unit of acceleration in brackets, one of m/s2"),
        (GOOD.replace("[s]", "[m]"), "expected a unit of time in brackets"),
        (GOOD.replace("time", "tme"), "line 1 = 'tme .s.': no such column"),
        (GOOD.replace("time [s],", ""), "no column of time"),
        (GOOD.replace(",", ";"), "line 1 = 'time .*: the columns are separated by semicolons; "),
        (GOOD.replace(",", "\t"), "separated by tabs; expected commas"),
        (
            GOOD.replace("acceleration [m/s2]", "acc [m/s]"),
            "= 'acc .m/s.': no such column, as 'm/s' is no unit of acceleration .m/s2, cm/s2",
        ),
        ("0.1,0.2,0.3\n" * 9, "line 1 = '0.1,0.2,0.3': this is no header; expected a CSV"),
        (GOOD.replace("time [s]", "acceleration [g]"), "a second column of acceleration"),
        (GOOD.splitlines()[0], "at least 2 samples"),
        (GOOD.replace("1.5", "nan"), "line 3 = 'nan': expected a finite number"),
        (GOOD.replace("1.5", "1.5 m/s2"), "line 3 = '1.5 m/s2': expected a finite number"),
        (GOOD.replace("1.5", "1e999"), "line 3 = '1e999': expected a finite number"),
        (GOOD.replace("1.5", ""), "line 3 = '': expected a finite number"),
        (GOOD.replace("1.5", "1,5"), "line 3 = '0.01,1,5': expected 2 cells .* got 3"),
        (GOOD.replace("0.02", "0.01"), "line 4 = '0.01 s': expected times that ascend"),
        (GOOD.replace("0.02", "0.005"), "line 4 = '0.005 s': expected times that ascend"),
        (GOOD + "0.04,0\n0.05,0\n", "line 5 = '0.04 s': expected a uniform time step, 0.01 s"),
        ("time [s],acceleration [m/s2]\n1,0\n2,0\n", "line 2 = '1 s': .* first sample at time 0"),
        *(
            (SEVERAL.replace(HEADER, header), words)
            for header, words in (
                ("time [s],NS [g],ns [g]", "a second column of ns"),
                ("time [s],NS [g],velocity [m/s]", "'velocity .m/s.': no such column"),
                ("NS [g],EW [g],Up [g]", "no column of time"),
                ("time [s],NS [g],[g]", "no such column"),
            )
        ),
        (
            GOOD.replace("acceleration [m/s2]", "velocity [g]"),
            "'velocity .g.': no such column, as its name",
        ),
    ],
)
def test_faults(tmp_path, content, message):
    path = written(tmp_path, content)
    with pytest.raises(InputError, match=message) as caught:
        read_record(path)
    assert len(caught.value.faults) == 1
    assert str(path) in str(caught.value)


def test_all_faults_at_once(tmp_path):
    text = GOOD + "0.03,x\n0.04\n0.05,1,2\n0.06,inf\n"
    with pytest.raises(InputError) as caught:
        read_record(written(tmp_path, text))
    assert [fault.key for fault in caught.value.faults] == [f"line {i}" for i in (5, 6, 7, 8)]


def test_many_faults_are_counted(tmp_path):
    with pytest.raises(InputError, match="and 180 more faults") as caught:
        read_record(written(tmp_path, GOOD + "a,b\n" * 100))
    assert len(caught.value.faults) == 21


def test_a_component_by_its_column(tmp_path):
    path = written(tmp_path, SEVERAL)
    assert read_record(path, component="ns").acceleration == pytest.approx([0, 14.709975, -19.6133])
    up = read_record(path, component="Up")
    assert up.acceleration == pytest.approx([0.01, 0.02, 0.03])
    assert (up.name, up.origin) == ("north_Up", "record north.csv, column Up")


def test_several_components_and_none_chosen(tmp_path):
    path = written(tmp_path, SEVERAL)
    with pytest.raises(InputError, match=r"2 components, .* component: 'NS',"):
        read_record(path)
    with pytest.raises(InputError, match=r"component; .* 'NS', 'Up'"):
        read_record(path, component="EW")


def test_one_acceleration_of_any_name(tmp_path):
    path = written(tmp_path, GOOD.replace("acceleration", "N-S of X"))
    assert read_record(path).acceleration == pytest.approx([0.0, 1.5, -2.0])
    assert read_record(path, component="n-s of x").name == "north"
