import numpy as np
import pytest

from impactfem.motion import read_record
from impactfem.system.errors import InputError
from impactfem.verify.record_files import cosmos_text

A = np.round(100.0 * np.random.default_rng(3).standard_normal(43), 5)
CHANNELS = [("90 deg", "HNE", A), ("Up", "HNZ", 0.5 * A), ("360 deg", "HNN", -A)]
THREE = cosmos_text(CHANNELS, 0.01)
ONE = cosmos_text(CHANNELS[:1], 0.01, integrals=False)


def read(tmp_path, text, component=None):
    path = tmp_path / "record.V2c"
    path.write_text(text)
    return read_record(path, component=component)


@pytest.mark.parametrize("columns", ["(8F10.5)", "(1E15.6)"])
def test_one_channel(tmp_path, columns):
    record = read(tmp_path, cosmos_text(CHANNELS[:1], 0.01, columns=columns))
    assert record.time_step == 0.01
    assert record.acceleration == pytest.approx(0.01 * A, rel=1e-6, abs=1e-9)
    assert record.name == "record_HNE"
    assert (
        "record.V2c, channel 1 (90 deg, HNE): corrected acceleration, Record of No" in record.origin
    )


@pytest.mark.parametrize("component", ["3", "HNN", "hnn", "360 deg", "360Deg"])
def test_a_channel_by_any_of_its_names(tmp_path, component):
    assert read(tmp_path, THREE, component).acceleration == pytest.approx(-0.01 * A)


def test_several_channels_and_none_chosen(tmp_path):
    known = r"1 \(90 deg, HNE\); 2 \(Up, HNZ\); 3 \(360 deg, HNN\)"
    with pytest.raises(InputError, match=f"component: the file holds 3 components, .* {known}"):
        read(tmp_path, THREE)
    with pytest.raises(InputError, match=f"component = 'EW': no such component; .* {known}"):
        read(tmp_path, THREE, "EW")


def test_the_same_name_twice(tmp_path):
    text = cosmos_text([("Up", "HNZ", A), ("Up", "HNE", 2.0 * A)], 0.01)
    assert read(tmp_path, text, "HNE").acceleration == pytest.approx(0.02 * A)
    with pytest.raises(InputError, match="component = 'Up': 2 components are called so"):
        read(tmp_path, text, "Up")


def test_channels_without_number_are_counted(tmp_path):
    text = THREE.replace("Sta Chan   1:", "Sta Chan   ?:")
    assert read(tmp_path, text, "1").acceleration == pytest.approx(0.01 * A)


def test_columns_that_touch(tmp_path):
    a = np.array([-123.45678, -100.5, 1000.00001, 2000.25])
    text = cosmos_text([("Up", "HNZ", a)], 0.01, integrals=False)
    assert read(tmp_path, text).acceleration == pytest.approx(0.01 * a)


@pytest.mark.parametrize(
    ("unit", "code", "factor"),
    [("cm/sec2", 4, 0.01), ("cm/s^2 ", 4, 0.01), ("g", 2, 9.80665), ("", 10, 0.01)],
)
def test_units(tmp_path, unit, code, factor):
    text = cosmos_text(CHANNELS[:1], 0.01, unit=unit, unit_code=code, integrals=False)
    assert read(tmp_path, text).acceleration == pytest.approx(factor * A)


def test_uncorrected_is_named_so(tmp_path):
    assert ": uncorrected acceleration" in read(tmp_path, ONE.replace("Corr", "Uncorr")).origin


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("43 acceleration", "44 acceleration", "line 49 .* 44 samples are announced, 43 follow"),
        ("43 acceleration", "42 acceleration", "42 samples are announced, 43 follow"),
        ("43 acceleration", "many acceleration", "line 49 .* expected '  n acceleration pts"),
        ("units=cm/sec2(04)", "units=counts(50)", "line 49 .* found counts and unit 50 of COSMOS"),
        (
            "units=cm/sec2(04)",
            "units=g(04)",
            "expected one unit of acceleration, found g and cm/s2",
        ),
        ("units=cm/sec2(04)", "units=cm/sec(04)", "found cm/s and cm/s2"),
        ("       4     120", "       2     120", "found cm/s2 and g"),
        ("acceleration pts", "velocity pts", "the file holds no acceleration"),
        ("End-of-data", "Begin-of-data", "43 samples are announced on line 49; expected 'End-of-d"),
        ("       0.010000", "       0.000000", "positive time step .s. as real-header value 34"),
        ("       0.010000", "            nan", "expected 100 numbers of the real header on 20"),
        (" 100 Integer", "  99 Integer", "line 14 .* 99 numbers are announced, 100 follow"),
        (" 100 Integer", "     Integer", "line 14 .* expected ' 100 Integer-header values"),
        (" 100 Real", " 100 Imaginary", "line 25 .* expected ' 100 Real-header values"),
        ("2 Comment line(s)", "2 Remarks", "line 46 .* expected '  n Comment line"),
        ("2 Comment line(s)", "3 Comment line(s)", "expected '  n acceleration pts"),
        ("with 13 text", "with 12 text", "line 13 .* expected ' 100 Integer-header"),
        ("with 13 text", "with some text", "line 1 .* expected a COSMOS record"),
        ("Corrected acceleration", "# Corrected\nCorrected acceleration", "line 1 = '# Corrected'"),
        ("(8F10.5)", "(8F0.5)", "line 49 .* expected '  n acceleration pts"),
        (
            f"{A[0]:10.5f}",
            "       NaN",
            "line 50 = 'NaN': expected finite numbers in columns of 10",
        ),
        (f"{A[0]:10.5f}", "**********", "line 50 = '[*]{10}': expected finite numbers"),
        (f"{A[0]:10.5f}", "          ", "line 50 = '': expected finite numbers"),
    ],
)
def test_faults(tmp_path, old, new, message):
    assert old in ONE
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, ONE.replace(old, new, 1))
    assert "record.V2c" in str(caught.value)
