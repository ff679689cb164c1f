import logging
import re
from datetime import datetime

import numpy as np
import pytest

from impactfem.records import read_record
from impactfem.records.recording import Orientation, Recording, orientation
from impactfem.system.errors import InputError
from impactfem.verify.motion import cosmos_text, csmip_text, esm_text, knet_text

A = np.round(100.0 * np.random.default_rng(3).standard_normal(43), 5)
CSV_TEXT = "time [s],a [g]\n0,0\n0.01,1\n0.02,0\n"
COUNTS = [int(c) for c in np.random.default_rng(3).integers(-12000, -9000, 200)]
GAL = np.array(COUNTS) * 3920.0 / 6182761.0
CHANNELS = [("90 deg", "HNE", A), ("Up", "HNZ", 0.5 * A), ("360 deg", "HNN", -A)]
THREE = {
    "cosmos": cosmos_text(CHANNELS, 0.01),
    "csmip": csmip_text([("90 Deg", A), ("Up", 0.5 * A), ("360 Deg", -A)], 0.02),
}
GOOD = """PEER NGA STRONG MOTION DATABASE RECORD
Somewhere 1/1/1999, STATION, 090
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=      7, DT=   .0050 SEC
  .1234000E-02 -.5678000E-03  .1000000E+00
 -.1234000E-02-.5678000E-03 .2000000E+00
  .0000000E+00
"""
ONE = {
    "at2": GOOD,
    "esm": esm_text(A, 0.005),
    "cosmos": cosmos_text(CHANNELS[:1], 0.01, integrals=False),
    "csmip": csmip_text([("90 Deg", A)], 0.02),
    "knet": knet_text(COUNTS, 100),
}


def read(tmp_path, fmt, text, component=None):
    path = tmp_path / f"made.{fmt}"
    path.write_text(text)
    return read_record(path, fmt, component)


def test_esm(tmp_path):
    assert ONE["esm"].splitlines()[63] == "USER5: "
    record = read(tmp_path, "esm", ONE["esm"])
    assert record.time_step == 0.005
    assert record.acceleration == pytest.approx(0.01 * A, rel=1e-14)
    assert record.name == "made"
    assert "XX.MADE.HNN, NOWHERE 20030102, baseline removed" in record.origin


def test_esm_with_windows_lines_and_in_other_units(tmp_path):
    text = ONE["esm"].replace("UNITS: cm/s^2", "UNITS: m/s^2").replace("\n", "\r\n")
    assert read(tmp_path, "esm", text).acceleration == pytest.approx(A)


@pytest.mark.parametrize("columns", ["(8F10.5)", "(1E15.6)"])
def test_cosmos(tmp_path, columns):
    record = read(tmp_path, "cosmos", cosmos_text(CHANNELS[:1], 0.01, columns=columns))
    assert record.time_step == 0.01
    assert record.acceleration == pytest.approx(0.01 * A, rel=1e-6, abs=1e-9)
    assert record.name == "made_HNE"
    assert "made.cosmos, channel 1 (90 deg, HNE): corrected acceleration, Rec" in record.origin


def test_csmip(tmp_path):
    record = read(tmp_path, "csmip", ONE["csmip"])
    assert record.time_step == 0.02
    assert record.acceleration == pytest.approx(0.01 * A)
    assert "channel 1 (90 Deg): Made Up Station Rcrd of Thu Jan 2, 2003" in record.origin


def test_knet(tmp_path, caplog):
    assert ONE["knet"].splitlines()[17][:9] == f"{COUNTS[0]:9d}"
    with caplog.at_level(logging.INFO, logger="impactfem"):
        record = read(tmp_path, "knet", ONE["knet"])
    assert record.time_step == 0.01
    assert record.acceleration == pytest.approx(0.01 * (GAL - GAL.mean()), rel=1e-12)
    assert record.acceleration.mean() == pytest.approx(0.0, abs=1e-15)
    assert f"mean of {GAL.mean():.4g} gal taken out" in record.origin
    assert "MADE01 N-S, first sample 2003-01-02 03:04:30 JST" in record.origin
    assert "offset of the instrument" in caplog.text


def test_the_published_example_of_the_scale_of_knet(tmp_path):
    # NIED's page: 8009 counts at 3920(gal)/6182761 are 5.078 gal.
    record = read(tmp_path, "knet", knet_text([8009, -8009] * 50, 100))
    assert record.acceleration[:2] == pytest.approx([0.05078, -0.05078], abs=5e-6)


def test_the_english_page_of_knet_has_other_keys(tmp_path):
    text = ONE["knet"].replace("Long.", "Lon. ").replace("Max. Acc.", "Max Acc. ")
    assert read(tmp_path, "knet", text).acceleration.size == 200


@pytest.mark.parametrize(
    ("fmt", "text", "names"),
    [
        ("esm", ONE["esm"], ["hnn"]),
        ("knet", ONE["knet"], ["N-S", "ns"]),
        ("knet", knet_text(COUNTS, 100, direction="4"), ["4", "NS2", "ns2"]),
    ],
)
def test_the_only_component_may_be_requested(tmp_path, fmt, text, names):
    for name in names:
        assert read(tmp_path, fmt, text, name).time_step > 0.0
    with pytest.raises(InputError, match=r"one component, [HN]"):
        read(tmp_path, fmt, text, "EW")


@pytest.mark.parametrize(
    ("fmt", "components"),
    [("cosmos", ["3", "HNN", "hnn", "360 deg", "360Deg"]), ("csmip", ["3", "360 Deg", "360deg"])],
)
def test_a_channel_by_any_of_its_names(tmp_path, fmt, components):
    for component in components:
        record = read(tmp_path, fmt, THREE[fmt], component)
        assert record.acceleration == pytest.approx(-0.01 * A)


@pytest.mark.parametrize(
    ("fmt", "known"),
    [
        ("cosmos", r"1 \(90 deg, HNE\); 2 \(Up, HNZ\); 3 \(360 deg, HNN\)"),
        ("csmip", r"1 \(90 Deg\); 2 \(Up\); 3 \(360 Deg\)"),
    ],
)
def test_several_channels_and_none_chosen(tmp_path, fmt, known):
    with pytest.raises(InputError, match=f"component: the file holds 3 components, .* {known}"):
        read(tmp_path, fmt, THREE[fmt])
    with pytest.raises(InputError, match=f"component = 'EW': no such component; .* {known}"):
        read(tmp_path, fmt, THREE[fmt], "EW")


def test_the_same_name_twice(tmp_path):
    text = cosmos_text([("Up", "HNZ", A), ("Up", "HNE", 2.0 * A)], 0.01)
    assert read(tmp_path, "cosmos", text, "HNE").acceleration == pytest.approx(0.02 * A)
    with pytest.raises(InputError, match="component = 'Up': 2 components"):
        read(tmp_path, "cosmos", text, "Up")


def test_channels_without_number_are_counted(tmp_path):
    text = THREE["cosmos"].replace("Sta Chan   1:", "Sta Chan   ?:")
    assert read(tmp_path, "cosmos", text, "1").acceleration == pytest.approx(0.01 * A)


def test_columns_that_touch(tmp_path):
    a = np.array([-123.45678, -100.5, 1000.00001, 2000.25])
    text = cosmos_text([("Up", "HNZ", a)], 0.01, integrals=False)
    assert read(tmp_path, "cosmos", text).acceleration == pytest.approx(0.01 * a)


@pytest.mark.parametrize(
    ("unit", "code", "factor"),
    [("cm/sec2", 4, 0.01), ("cm/s^2 ", 4, 0.01), ("g", 2, 9.80665), ("", 10, 0.01)],
)
def test_units_of_cosmos(tmp_path, unit, code, factor):
    text = cosmos_text(CHANNELS[:1], 0.01, unit=unit, unit_code=code, integrals=False)
    assert read(tmp_path, "cosmos", text).acceleration == pytest.approx(factor * A)


def test_uncorrected_is_named_so(tmp_path):
    text = ONE["cosmos"].replace("Corr", "Uncorr")
    assert ": uncorrected acceleration" in read(tmp_path, "cosmos", text).origin


@pytest.mark.parametrize(
    ("fmt", "old", "new"),
    [
        ("esm", "PGA_CM/S^2: ", "PGA_CM/S^2: 9"),
        ("knet", "3920(gal)", "2000(gal)"),
        ("cosmos", f"{A[np.argmax(np.abs(A))]:15.6f}", "     100.000000"),
    ],
)
def test_a_peak_that_is_not_the_header_s_is_warned_of(tmp_path, caplog, fmt, old, new):
    with caplog.at_level(logging.WARNING, logger="impactfem"):
        read(tmp_path, fmt, ONE[fmt])
        assert not caplog.records
        read(tmp_path, fmt, ONE[fmt].replace(old, new))
    assert "warning: " in caplog.text and "the largest sample is" in caplog.text


def test_the_interval_of_cosmos_is_that_of_the_samples(tmp_path, caplog):
    """Not of the raw record, unless the header has no other; then its duration tells."""
    header = cosmos_text([("90 deg", "HNE", np.tile(A, 50))], 0.01, integrals=False)
    with caplog.at_level(logging.WARNING, logger="impactfem"):
        assert read(tmp_path, "cosmos", header).time_step == 0.01
        assert not caplog.records
        unknown = header.replace("      10.000000", "    -999.000000")
        assert read(tmp_path, "cosmos", unknown).time_step == 0.005
        said = "2150 samples at 0.005 s take 10.75 s, the header has 21.5 s"
        assert said in caplog.text
        caplog.clear()
        read(tmp_path, "cosmos", unknown.replace("      21.500000", "    -999.000000"))
        assert "10.75 s, the header has 22 s" in caplog.text
    nowhere = unknown.replace("       0.005000", "       0.000000")
    with pytest.raises(InputError, match="real-header value 62"):
        read(tmp_path, "cosmos", nowhere)


def test_channels_of_csmip_have_the_numbers_of_the_station(tmp_path):
    """Not those of recorders; where these repeat, too, the place in the file counts."""
    first = "Chan  1: 90 Deg"
    header, end = THREE["csmip"].split("\n", 8)[:8], "  (Sta Chn: 11)     Location: Roof"
    assert header[7].startswith(first)
    text = THREE["csmip"].replace(f"\n{first}\n", f"\n{first} {end}\n")
    record = read(tmp_path, "csmip", text, "11")
    assert record.acceleration == pytest.approx(0.01 * A)
    assert "channel 11 (90 Deg): Roof, Made Up Station" in record.origin
    again = text.replace("Sta Chn: 11", "Sta Chn: 3")
    assert read(tmp_path, "csmip", again, "3").acceleration == pytest.approx(-0.01 * A)
    assert read(tmp_path, "csmip", again, "1").acceleration == pytest.approx(0.01 * A)


def test_csmip_before_1990(tmp_path, caplog):
    """Without columns, in capitals, with the marks of a disk behind the end."""
    now = f"    {A.size} points of accel data equally spaced at  .02 sec, in cm/sec2. (8f10.5)"
    assert now in ONE["csmip"]
    then = f"{A.size} POINTS OF ACCEL DATA EQUALLY SPACED AT .020 SEC. (UNITS: CM/SEC/SEC)"
    record = read(tmp_path, "csmip", ONE["csmip"].replace(now, then) + "\x1a\x1a")
    assert record.time_step == 0.02 and record.acceleration == pytest.approx(0.01 * A)
    # The header has the step with more digits, and the peak.
    reals = "-999.00000" * 4 + "    .01953" + "-999.00000" * 3
    lines = ONE["csmip"].split("\n")
    lines[39], lines[17] = reals, " Peak acceleration = 2712.3 cm/sec/sec at  1.2 sec"
    assert read(tmp_path, "csmip", "\n".join(lines)).time_step == 0.01953
    assert "the header has 2712.3 cm/s2" in caplog.text
    # What is no such step, by less than its digits say, is told and left.
    lines[39] = reals.replace(".01953", ".02530")
    assert read(tmp_path, "csmip", "\n".join(lines)).time_step == 0.02
    assert "the samples have a time step of .02 s, the header has 0.0253 s" in caplog.text


@pytest.mark.parametrize("words", ["ACCELERATION IN G", "ACCELERATION IN UNITS OF G."])
def test_other_words_of_at2(tmp_path, words):
    text = f"PEER\nX\n{words}\nNPTS= 3, DT= .01 SEC\n 0.1 -0.2 0.3\n"
    record = read(tmp_path, "at2", text)
    assert record.acceleration == pytest.approx(9.80665 * np.array([0.1, -0.2, 0.3]))


def test_lines_that_end_thrice(tmp_path):
    text = ONE["knet"].replace("\n", "\r\r\n")
    path = tmp_path / "made.knet"
    path.write_bytes(text.encode())
    assert read_record(path, "knet", None).time_step == 0.01


@pytest.mark.parametrize("units", ["g.     (02)Format=", "g(02)Format=", "g. (02), Format="])
def test_cosmos_as_cgs_writes_it(tmp_path, units):
    one = cosmos_text(CHANNELS[:1], 0.01, unit="g", unit_code=2, integrals=False)
    text = one.replace("g(02),Format=", units)
    assert text.count(units) == 1
    assert read(tmp_path, "cosmos", text).acceleration == pytest.approx(9.80665 * A)


def test_raw_cosmos_is_refused_by_its_counts(tmp_path):
    one = cosmos_text(CHANNELS[:1], 0.01, unit="counts", unit_code=50, integrals=False)
    with pytest.raises(InputError, match=r"unit 50 .*: a raw record;"):
        read(tmp_path, "cosmos", one.replace("acceleration pts", "raw accel.   pts"))


def test_esm_with_the_header_of_earlier_years(tmp_path, caplog):
    """DYNA 1.0 lacks nine keys; the duration is compared."""
    lines = ONE["esm"].split("\n")
    gone = [k for k, line in enumerate(lines[:64]) if line.startswith(("USER", "DATE_TIME_FIRST"))]
    text = "\n".join(line for k, line in enumerate(lines) if k not in gone)
    assert read(tmp_path, "esm", text).acceleration == pytest.approx(0.01 * A)
    assert not caplog.records
    slower = ONE["esm"].replace("INTERVAL_S: 0.005", "INTERVAL_S: 0.05")
    assert read(tmp_path, "esm", slower).time_step == 0.05
    assert "43 samples at 0.05 s take 2.15 s, the header has 0.215 s" in caplog.text


SIZE, UNIT = "NPTS=      7, DT=   .0050 SEC", "SERIES IN UNITS OF G"
VELOCITY = "OF CM/S. FILTER POINTS: HP=0.1 Hz LP=46.0 Hz"
FAULTS = {
    "at2": [
        (GOOD, "a\nb\nc\n", "ends early"),
        ("IN UNITS OF G", "", "line 3 .* expected 'ACCELERATION TIME SERIES"),
        (f"ACCELERATION TIME {UNIT}", f"VELOCITY SERIES IN UNITS {VELOCITY}", "line 3 = 'VELOCITY"),
        ("UNITS OF G", "UNITS OF CM/S", "line 3 .* another unit of acceleration"),
        (".0050 SEC", "5.0 MSEC", "line 4 .* expected the number of samples"),
        ("NPTS", "POINTS", "line 4 .* expected the number of samples"),
        (".0050", "0.0", "line 4 .* a positive time step"),
        ("     7,", "     1,", "line 4 .* at least 2 samples"),
        ("     7,", "9" * 5000, "line 4 .* expected the number of samples"),
        ("     7,", "     8,", "announces 8 samples, the file has 7"),
        (".2000000E+00", "NaN", "line 6 = 'NaN': expected finite numbers"),
        (".2000000E+00", ".2.000", "line 6 = '.2.000': expected finite numbers"),
        (".2000000E+00", ".2E+999", "line 6 = '.2E.999': expected finite numbers"),
        (".2000000E+00", "********", "line 6 .* expected finite numbers"),
    ],
    "esm": [
        ("NDATA: 43", "NDATA: 44", r"line 30 = 'NDATA: 44': the header announces 44 samples, the"),
        ("NDATA: 43", "NDATA: many", "line 30 = 'many': expected the number of samples as NDATA"),
        ("NDATA: 43\n", "N: 43\n", "the header has no NDATA; expected the number of samples"),
        ("S: 0.005", "S: -0.005", "line 29 = '-0.005000': expected the time step in seconds"),
        ("UNITS: cm/s^2", "UNITS: cm/s", "line 33 = 'cm/s': expected a unit of acceleration"),
        ("UNITS: cm/s^2", "UNIT: cm/s^2", "the header has no UNITS"),
        ("DATA_TYPE: ACC", "DATA_TYPE: DISPLACEMENT ACC", "expected DATA_TYPE: ACCELERATION"),
        ("USER3: \n", "USER3\n", "line 62 = 'USER3': the header ends early"),
        (f"\n{A[7]:.6f}\n", "\nnan\n", "line 72 = 'nan': expected one finite number"),
        (f"\n{A[7]:.6f}\n", "\n1 2\n", "line 72 = '1 2': expected one finite number"),
        (f"\n{A[7]:.6f}\n", "\n", "announces 43 samples, the file has 42"),
    ],
    "cosmos": [
        ("43 acceleration", "44 acceleration", "line 49 .* 44 samples are announced, 43 follow"),
        ("43 acceleration", "42 acceleration", "42 samples are announced, 43 follow"),
        ("43 acceleration", "many acceleration", "line 49 .* expected '  n acceleration pts"),
        ("units=cm/sec2(04)", "units=counts(50)", "line 49 .* got counts and unit 50 of COSMOS"),
        ("units=cm/sec2(04)", "units=g(04)", "expected one unit of acceleration, got g and cm/s2"),
        ("units=cm/sec2(04)", "units=cm/sec(04)", "got cm/s and cm/s2"),
        ("       4     120", "       2     120", "got cm/s2 and g"),
        ("acceleration pts", "velocity pts", "the file holds no acceleration"),
        ("End-of-data", "Begin-of-data", "43 samples are announced on line 49; expected 'End-of-d"),
        ("      10.000000", "            nan", "expected 100 numbers of the real header on 20"),
        (" 100 Integer", "  99 Integer", "line 14 .* 99 numbers are announced, 100 follow"),
        (" 100 Integer", "     Integer", "line 14 .* expected ' 100 Integer-header values"),
        (" 100 Real", " 100 Imaginary", "line 25 .* expected ' 100 Real-header values"),
        ("2 Comment line(s)", "2 Remarks", "line 46 .* expected '  n Comment line"),
        ("2 Comment line(s)", "3 Comment line(s)", "expected '  n acceleration pts"),
        ("with 13 text", "with 12 text", "line 13 .* expected ' 100 Integer-header"),
        ("with 13 text", "with some text", "line 1 .* expected a COSMOS record"),
        ("Corrected acceleration", "# Corrected\nCorrected acceleration", "line 1 = '# Corrected'"),
        ("(8F10.5)", "(8F0.5)", "line 49 .* expected '  n acceleration pts"),
        (f"{A[0]:10.5f}", "       NaN", "line 50 = 'NaN': expected finite numbers in columns of"),
        (f"{A[0]:10.5f}", "**********", "line 50 = '[*]{10}': expected finite numbers"),
        (f"{A[0]:10.5f}", "          ", "line 50 = '': expected finite numbers"),
    ],
    "csmip": [
        ("43 points of accel", "44 points of accel", "line 46 .* 44 samples are announced, 43 "),
        ("43 points of accel", "42 points of accel", "42 samples are announced, 43 follow"),
        ("43 points of accel data", "43 points of veloc data", "line 46 .* the header ends other"),
        ("in cm/sec2.", "in cm/sec.", "line 46 = 'cm/sec': expected a unit of acceleration"),
        (".02 sec", ".00 sec", "line 46 = '.00': expected a time step"),
        (".02 sec", "NaN sec", "line 46 = 'NaN': expected a time step"),
        ("/&", "--", "the channel that begins on line 1 does not end"),
        ("Corrected acc", "Corrupted acc", "line 1 .* expected a CSMIP V2 record"),
        ("-999.00000-999", "-999.00000\n-999", "line 46 .* the header ends otherwise"),
        (f"{A[0]:10.5f}", "       NaN", "line 47 = 'NaN': expected finite numbers in columns of"),
    ],
    "knet": [
        ("100Hz", "100", "line 11 = '100': expected the sampling frequency with its unit"),
        ("100Hz", "0Hz", "line 11 = '0Hz': expected the sampling frequency"),
        ("3920(gal)", "3920(m/s2)", "line 14 .* expected the scale factor in gal"),
        ("/6182761", "/0", "line 14 .* expected the scale factor in gal"),
        ("(s)  2", "(s)  x", "line 12 = 'x': expected the duration in seconds"),
        ("(s)  2", "(s)  3", "line 12 = '3': 3 s at 100 Hz are 300 samples, the file has 200"),
        ("(s)  2", "(s)  " + "9" * 300, "are 1e.302 samples"),
        (f"{COUNTS[9]:9d}", "     nan ", "line 19 = 'nan': expected whole numbers only"),
        (f"{COUNTS[9]:9d}", "    -1.5 ", "line 19 = '-1.5': expected whole numbers only"),
        (f"{COUNTS[9]:9d}", "", "are 200 samples, the file has 199"),
        ("Station Code", "Station Cod ", "line 6 .* expected the line 'Station Code ...'"),
        ("Memo.", "", "line 17 .* expected the line 'Memo. ...'"),
    ],
}


@pytest.mark.parametrize(
    ("fmt", "old", "new", "message"), [(fmt, *row) for fmt, rows in FAULTS.items() for row in rows]
)
def test_faults(tmp_path, fmt, old, new, message):
    assert old in ONE[fmt]
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, fmt, ONE[fmt].replace(old, new, 1))
    assert f"made.{fmt}" in str(caught.value)
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize(
    ("fmt", "changes", "lines"),
    [
        ("esm", {"UNITS: cm/s^2": "UNITS: V", "NDATA: 43": "NDATA: x"}, (30, 33, 108)),
        ("at2", {"UNITS OF G": "UNITS OF V", "NPTS": "N", ".1000000E+00": "?"}, (3, 4, 5)),
    ],
)
def test_all_faults_at_once(tmp_path, fmt, changes, lines):
    text = ONE[fmt] + ("oops\n" if fmt == "esm" else "")
    for old, new in changes.items():
        text = text.replace(old, new)
    with pytest.raises(InputError) as caught:
        read(tmp_path, fmt, text)
    assert [fault.key for fault in caught.value.faults] == [f"line {k}" for k in lines]


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


FILTERED = "HISTORY IN UNITS OF G"


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


def test_its_component_is_that_of_the_title_or_of_the_name(tmp_path):
    record = read_record(written(tmp_path, GOOD), component="090")
    assert record.recording.orientation == Orientation(False, 90.0)
    with pytest.raises(InputError, match="component = '180': the file"):
        read_record(written(tmp_path, GOOD), component="180")
    unnamed = written(tmp_path, GOOD.replace("STATION, 090", "STATION"))
    with pytest.raises(InputError, match="does not name"):
        read_record(unnamed, component="090")
    for name, direction in (
        ("RSN1_X-UP", Orientation(True)),
        ("RSN1_X270", Orientation(False, 270.0)),
    ):
        path = tmp_path / f"{name}.AT2"
        path.write_text(unnamed.read_text())
        assert read_record(path).recording.orientation == direction


OLD_SIZE = "   2000     DT =      .0100 SEC  ,  AMAX =  .2000E+00 G"
OLD = {
    "peaks behind a comma": {
        UNIT: f"{FILTERED},  PGA=   .20000 G, PGV=   15.6 CM/SEC, PGD=  1.2 CM"
    },
    "peaks behind a semicolon": {UNIT: f"{FILTERED}; PGA = .2 G"},
    "poles of a filter": {SIZE: f"{SIZE},   0 POLE @    40.00000 HZ,  -5 POLE @ .05 HZ, ACAUSAL"},
    "units in brackets": {UNIT: "HISTORY (G'S): NIT =   2"},
    "g in brackets": {UNIT: "HISTORY (G)"},
    "standard gravity in brackets": {UNIT: "HISTORY (9.80665 M/S2)"},
    "gravity in words": {UNIT: "HISTORY IN UNITS OF 9.80665 M/S**2"},
    "lines of their own": {SIZE: "NPTS=      7\nDT=   .0050 SEC"},
    "numbers behind both": {SIZE: "NPTS, DT =  7, .0050"},
    "an old header before the last one": {
        f"ACCELERATION TIME {UNIT}\n{SIZE}": "****OLD HEADERS FOLLOW:****\nSPECTRUM COMPATIBLE\n"
        f"OUTPUT ACCELERATION TIME HISTORY (G'S): NIT =   2\n{OLD_SIZE}\n****END****\n{SIZE}"
    },
    "words behind the size": {SIZE: f"{SIZE}\n****END OF HEADERS****"},
}


@pytest.mark.parametrize("changes", OLD.values(), ids=OLD)
def test_old_layouts_of_at2(tmp_path, changes):
    text = GOOD
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    record = read_record(written(tmp_path, text))
    assert record.time_step == 0.005
    assert record.acceleration == pytest.approx(SAMPLES)


@pytest.mark.parametrize("unit", ["(CM/S)", "(VOLTS)", "IN UNITS OF CM, PGD= 1 CM"])
def test_another_quantity_in_an_old_layout_is_refused(tmp_path, unit):
    with pytest.raises(InputError, match="another unit"):
        read_record(written(tmp_path, GOOD.replace(UNIT, f"HISTORY {unit}")))


def test_two_units_in_a_header_are_refused(tmp_path):
    text = GOOD.replace("STATION, 090", "ACCELERATION IN UNITS OF CM/S2")
    with pytest.raises(InputError, match="one unit"):
        read_record(written(tmp_path, text))


def test_esm_of_afad_begins_with_lines_of_its_own(tmp_path):
    """Before the header, which is found by its first key; not anywhere in the file."""
    before = ["AAD_Filtered_TADAS_FILE", "AAD_FILTER_TYPE: BUTTERWORTH", "AAD_FILTER_ORDER: 1"]
    path = tmp_path / "20230206_AAD_Acc_E.asc"
    path.write_text("\n".join([*before, ONE["esm"]]))
    record = read_record(path)
    assert record.acceleration == pytest.approx(0.01 * A) and record.time_step == 0.005
    path.write_text("\n".join([*before, "", "noise", ONE["esm"].replace("EVENT_NAME:", "EVENT:")]))
    with pytest.raises(InputError, match="header ends early"):
        read_record(path)


@pytest.mark.parametrize("fmt", ["esm", "at2", "csv"])
def test_names_that_are_not_utf_8(tmp_path, fmt):
    """As of Turkish places in ISO 8859-9: numbers are the same in all of these encodings."""
    texts = ONE | {"csv": "# Şile\ntime [s],a [g]\n0,0\n0.01,1\n0.02,0\n"}
    text = texts[fmt].replace("Somewhere", "İzmir, Şişli").replace("NOWHERE", "İzmir")
    path = tmp_path / f"made.{fmt}"
    path.write_bytes(text.encode("iso-8859-9"))
    other = tmp_path / f"other.{fmt}"
    other.write_text(text, encoding="utf-8")
    assert np.array_equal(*(read_record(p, fmt).acceleration for p in (path, other)))
    path.write_bytes(text.encode("utf-16"))
    with pytest.raises(InputError, match="as UTF-8"):
        read_record(path, fmt)


@pytest.mark.parametrize("fmt", list(ONE))
def test_a_header_with_very_long_lines_is_read_quickly(tmp_path, fmt):
    """Patterns look at the beginning of a line alone: else this takes minutes."""
    lines = ONE[fmt].split("\n")
    lines[:60] = [line + 200_000 * " " + "x" for line in lines[:60]]
    with pytest.raises(InputError):
        read(tmp_path, fmt, "\n".join(lines))


def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr("impactfem.records.file.LARGEST", 100)
    with pytest.raises(InputError, match="expected at most"):
        read_record(written(tmp_path, GOOD))


@pytest.mark.parametrize("fmt", [*ONE, "csv"])
def test_cells_that_are_read_at_once_and_one_by_one_agree(tmp_path, monkeypatch, fmt):
    texts = ONE | {"csv": "time [s],a [g]\n0,1e-3\n0.01,-.5\n0.02,+2.\n"}
    at_once = read(tmp_path, fmt, texts[fmt]).acceleration
    for module in ("file", "csv"):
        monkeypatch.setattr(f"impactfem.records.{module}._PLAIN", re.compile("never"))
    assert np.array_equal(read(tmp_path, fmt, texts[fmt]).acceleration, at_once)


@pytest.mark.parametrize(
    ("fmt", "changes", "start", "event", "station", "sensor"),
    [
        ("esm", {}, "2003-01-02 03:04:10.250", "NOWHERE 2003-01-02 03:04:05", "XX.MADE", "HN"),
        ("esm", {"LOCATION: ": "LOCATION: 10", "20030102_030410.250": "2003/01/02 03:04:38.8092"},
         "2003-01-02 03:04:38.8092", "NOWHERE 2003-01-02 03:04:05", "XX.MADE", "HN 10"),
        ("knet", {}, "2003-01-01 18:04:30", "2003/01/02 03:04:05", "MADE01", ""),
        ("knet", {"N-S": "1"}, "2003-01-01 18:04:30", "2003/01/02 03:04:05", "MADE01",
         "in the borehole"),
        ("cosmos", {}, "2003-01-02 03:04:10.250", "2003/01/02 03:04:05 UTC", "XX-MADE", ""),
        ("cosmos", {"2003/01/02 03:04:10.250 UTC": "01/02/2003, 03:04: 1.5 PST",
                    "Location:": "Location: Roof"},
         "2003-01-02 11:04:01.5", "2003/01/02 03:04:05 UTC", "XX-MADE", "Roof"),
        ("csmip", {}, "2003-01-02 03:04:05", "", "Made Up Station", ""),
        ("csmip", {"Rcrd of Thu Jan  2, 2003 03:04:05.0 UTC\n\n\n\n":
                   "Rcrd of Thu Jan  2, 2003 03:04:05.0 PST\n(Origin: 1/2/03, 11:04:00 UTC)\n"
                   "1-L2  Start time:  1/ 2/03, 11:04:06.5 UTC (GPS)\nStation No. 89146  40N\n"},
         "2003-01-02 11:04:06.5", "1/2/03, 11:04:00 UTC", "89146", ""),
        ("at2", {}, None, "Somewhere 1/1/1999", "STATION", ""),
        ("at2", {"Somewhere 1/1/1999, STATION, 090": "NOWHERE VALLEY 10/15/79 2319, MADE UP, "
                 "230 (USGS STATION 5)"}, None, "NOWHERE VALLEY 10/15/79", "MADE UP", ""),
    ],
)  # fmt: skip
def test_what_a_header_says(tmp_path, fmt, changes, start, event, station, sensor):
    text = ONE[fmt]
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new, 1)
    found = read(tmp_path, fmt, text).recording
    known = start and datetime.fromisoformat(start.ljust(26, "0") if "." in start else start)
    assert known is None or found.start == known
    assert [found.event.split(), found.station, found.sensor] == [event.split(), station, sensor]


def test_what_a_csv_states(tmp_path):
    text = "# start: 2023-02-06T01:17:38.5Z\n# station: KO.ISK,,\n# component: HNZ\n" + CSV_TEXT
    found = read(tmp_path, "csv", text).recording
    assert found.start == datetime(2023, 2, 6, 1, 17, 38, 500000)
    assert (found.station, found.component, found.orientation) == (
        "KO.ISK",
        "HNZ",
        Orientation(True),
    )
    assert read(tmp_path, "csv", CSV_TEXT).recording == Recording(component="a")


@pytest.mark.parametrize(
    ("fmt", "code", "expected"),
    [
        ("cosmos", 400, Orientation(True)),
        ("cosmos", 401, Orientation(True)),
        ("cosmos", 45, Orientation(False, 45.0)),
        ("cosmos", 701, Orientation(False)),
        ("cosmos", -999, None),
        ("csmip", 500, Orientation(True)),
        ("csmip", 600, Orientation(True)),
        ("csmip", 360, Orientation(False, 0.0)),
        ("csmip", 0, None),
    ],
)
def test_the_code_of_an_orientation(tmp_path, fmt, code, expected):
    """Where the channel has no other word; the word comes first."""
    for word, first in (("Other", None), ("Up", Orientation(True))):
        if fmt == "cosmos":
            text = cosmos_text([(word, "XYZ", A)], 0.01, integrals=False)
            lines = text.split("\n")
            lines[19] = "".join(f"{x:8d}" for x in (-999, -999, -999, code, *[-999] * 6))
        else:
            lines = csmip_text([(word, A)], 0.02).split("\n")
            lines[26] = "".join(f"{code if k == 10 else -999:5d}" for k in range(16))
        assert read(tmp_path, fmt, "\n".join(lines)).recording.orientation == (first or expected)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        *((name, Orientation(True)) for name in ("HNZ", "U", "UD1", "Up", "DOWN", "VER", "acc_z")),
        *((name, Orientation(False, 0.0)) for name in ("HNN", "N-S", "NS2", "360 Deg", "North")),
        *((name, Orientation(False, 90.0)) for name in ("BNE", "E", "EW1", "090", "90 deg")),
        *((name, Orientation(False)) for name in ("H1", "HN2", "T", "Transverse")),
        ("S45W", Orientation(False, 225.0)),
        *((name, None) for name in ("version", "V1", "acc_x", "ch 003", "400", "", "Other")),
    ],
)  # fmt: skip
def test_orientations(name, expected):
    assert orientation(name) == expected
