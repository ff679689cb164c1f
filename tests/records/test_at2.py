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


SIZE, UNIT = "NPTS=      7, DT=   .0050 SEC", "SERIES IN UNITS OF G"
FILTERED = "HISTORY IN UNITS OF G"
VELOCITY = "OF CM/S. FILTER POINTS: HP=0.1 Hz LP=46.0 Hz"


@pytest.mark.parametrize(
    ("old", "new", "factor"),
    [
        (SIZE, "NPTS=  7, DT= .0050 SEC,", 1.0),
        (SIZE, "NPTS=7,DT=0.005", 1.0),
        (SIZE, "npts =   7 , dt = 5.0E-03 sec", 1.0),
        (SIZE, "    7    0.0050    NPTS, DT", 1.0),
        (SIZE, "NPTS=     7, DT=     .00500 SEC", 1.0),
        (UNIT, f"{FILTERED}. FILTER POINTS: HP=0.1 Hz LP=46.0 Hz", 1.0),
        (UNIT, f"{FILTERED}; Filter Point: HP=0.20 LP=23.0", 1.0),
        (UNIT, "SERIES IN UNITS OF CM/SEC/SEC", 0.01 / 9.80665),
        ("\n", "\r\n", 1.0),
    ],
)
def test_variants(tmp_path, old, new, factor):
    assert old in GOOD
    record = read_record(written(tmp_path, GOOD.replace(old, new)))
    assert record.time_step == pytest.approx(0.005)
    assert record.acceleration == pytest.approx(SAMPLES * factor)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("a\nb\nc\n", "ends early"),
        (GOOD.replace("IN UNITS OF G", ""), "line 3 .* expected 'ACCELERATION TIME SERIES"),
        (
            GOOD.replace("ACCELERATION TIME SERIES", "VELOCITY").replace("OF G", VELOCITY),
            "line 3 = 'VELOCITY",
        ),
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
