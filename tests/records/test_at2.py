import numpy as np
import pytest

from impactfem.records import read_record
from impactfem.system.errors import InputError

GOOD = """PEER NGA STRONG MOTION DATABASE RECORD
Somewhere 1/1/1999, STATION, 090
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=      7, DT=   .0050 SEC
  .1234000E-02 -.5678000E-03  .1000000E+00
 -.1234000E-02-.5678000E-03 .2000000E+00
  .0000000E+00
"""
SAMPLES = 9.80665 * np.array([0.001234, -0.0005678, 0.1, -0.001234, -0.0005678, 0.2, 0.0])


def written(tmp_path, content):
    path = tmp_path / "RSN1_X.AT2"
    path.write_text(content, newline="")
    return path


def test_samples_that_touch(tmp_path):
    record = read_record(written(tmp_path, GOOD))
    assert record.time_step == 0.005
    assert record.acceleration == pytest.approx(SAMPLES)
    assert record.name == "RSN1_X"
    assert "STATION, 090" in record.origin


@pytest.mark.parametrize(
    "header",
    [
        "NPTS=  7, DT= .0050 SEC,",
        "NPTS=7,DT=0.005",
        "npts =   7 , dt = 5.0E-03 sec",
        "    7    0.0050    NPTS, DT",
        "NPTS=     7, DT=     .00500 SEC",
    ],
)
def test_variants_of_the_fourth_line(tmp_path, header):
    text = GOOD.replace("NPTS=      7, DT=   .0050 SEC", header)
    record = read_record(written(tmp_path, text))
    assert record.time_step == pytest.approx(0.005)
    assert record.acceleration == pytest.approx(SAMPLES)


@pytest.mark.parametrize(
    "line",
    [
        "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 Hz LP=46.0 Hz",
        "ACCELERATION TIME HISTORY IN UNITS OF G; Filter Point: HP=0.20 LP=23.0",
    ],
)
def test_older_third_lines(tmp_path, line):
    text = GOOD.replace("ACCELERATION TIME SERIES IN UNITS OF G", line)
    assert read_record(written(tmp_path, text)).acceleration == pytest.approx(SAMPLES)


def test_a_velocity_is_refused(tmp_path):
    line = "VELOCITY TIME HISTORY IN UNITS OF CM/S. FILTER POINTS: HP=0.1 Hz LP=46.0 Hz"
    text = GOOD.replace("ACCELERATION TIME SERIES IN UNITS OF G", line)
    with pytest.raises(InputError, match="line 3 = 'VELOCITY"):
        read_record(written(tmp_path, text))


def test_windows_lines(tmp_path):
    record = read_record(written(tmp_path, GOOD.replace("\n", "\r\n")))
    assert record.acceleration == pytest.approx(SAMPLES)


def test_other_units_are_read(tmp_path):
    text = GOOD.replace("UNITS OF G", "UNITS OF CM/SEC/SEC")
    assert read_record(written(tmp_path, text)).acceleration == pytest.approx(
        SAMPLES / 9.80665 * 0.01
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("a\nb\nc\n", "ends early"),
        (GOOD.replace("IN UNITS OF G", ""), "line 3 .* expected 'ACCELERATION TIME SERIES"),
        (GOOD.replace("UNITS OF G", "UNITS OF CM/S"), "line 3 .* another unit of acceleration"),
        (GOOD.replace("NPTS", "POINTS"), "line 4 .* expected the number of samples"),
        (GOOD.replace(".0050", "0.0"), "line 4 .* a positive time step"),
        (GOOD.replace("     7,", "     1,"), "line 4 .* at least 2 samples"),
        (GOOD.replace("     7,", "9" * 5000), "line 4 .* expected the number of samples"),
        (GOOD.replace("     7,", "     8,"), "announces 8 samples, the file has 7"),
        (GOOD.replace(".2000000E+00", "NaN"), "line 6 = 'NaN': expected finite numbers"),
        (GOOD.replace(".2000000E+00", ".2.000"), "line 6 = '.2.000': expected finite numbers"),
        (GOOD.replace(".2000000E+00", ".2E+999"), "line 6 = '.2E.999': expected finite numbers"),
        (GOOD.replace(".2000000E+00", "********"), "line 6 .* expected finite numbers"),
    ],
)
def test_faults(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        read_record(written(tmp_path, content))
    assert len(caught.value.faults) == 1


def test_all_faults_at_once(tmp_path):
    text = (
        GOOD.replace("UNITS OF G", "UNITS OF V").replace("NPTS", "N").replace(".1000000E+00", "?")
    )
    with pytest.raises(InputError) as caught:
        read_record(written(tmp_path, text))
    assert [fault.key for fault in caught.value.faults] == ["line 3", "line 4", "line 5"]


def test_it_does_not_name_its_component(tmp_path):
    with pytest.raises(InputError, match="component = '090': the file holds one component and d"):
        read_record(written(tmp_path, GOOD), component="090")
