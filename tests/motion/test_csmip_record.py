import numpy as np
import pytest

from impactfem.motion import read_record
from impactfem.system.errors import InputError
from impactfem.verify.record_files import csmip_text

A = np.round(100.0 * np.random.default_rng(3).standard_normal(43), 5)
THREE = csmip_text([("90 Deg", A), ("Up", 0.5 * A), ("360 Deg", -A)], 0.02)
ONE = csmip_text([("90 Deg", A)], 0.02)


def read(tmp_path, text, component=None):
    path = tmp_path / "MADE.V2"
    path.write_text(text)
    return read_record(path, "csmip", component)


def test_one_channel(tmp_path):
    record = read(tmp_path, ONE)
    assert record.time_step == 0.02
    assert record.acceleration == pytest.approx(0.01 * A)
    assert "channel 1 (90 Deg): Made Up Station Rcrd of Thu Jan 2, 2003" in record.origin


@pytest.mark.parametrize("component", ["3", "360 Deg", "360deg"])
def test_a_channel_by_its_names(tmp_path, component):
    assert read(tmp_path, THREE, component).acceleration == pytest.approx(-0.01 * A)


def test_several_channels_and_none_chosen(tmp_path):
    with pytest.raises(InputError, match=r"3 components, .* 1 \(90 Deg\); 2 \(Up\); 3 \(360 Deg\)"):
        read(tmp_path, THREE)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "43 points of accel",
            "44 points of accel",
            "line 46 .* 44 samples are announced, 43 foll",
        ),
        ("43 points of accel", "42 points of accel", "42 samples are announced, 43 follow"),
        ("43 points of accel data", "43 points of veloc data", "line 46 .* the header ends other"),
        ("in cm/sec2.", "in cm/sec.", "line 46 = 'cm/sec': expected a unit of acceleration"),
        (".02 sec", ".00 sec", "line 46 = '.00': expected a time step"),
        (".02 sec", "NaN sec", "line 46 = 'NaN': expected a time step"),
        ("/&", "--", "the channel that begins on line 1 does not end"),
        ("Corrected acc", "Corrupted acc", "line 1 .* expected a CSMIP V2 record"),
        ("-999.00000-999", "-999.00000\n-999", "line 46 .* the header ends otherwise"),
        (
            f"{A[0]:10.5f}",
            "       NaN",
            "line 47 = 'NaN': expected finite numbers in columns of 10",
        ),
    ],
)
def test_faults(tmp_path, old, new, message):
    assert old in ONE
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, ONE.replace(old, new, 1))
    assert "MADE.V2" in str(caught.value)
