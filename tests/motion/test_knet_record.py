import logging

import numpy as np
import pytest

from impactfem.motion import read_record
from impactfem.system.errors import InputError
from impactfem.verify.record_files import knet_text

COUNTS = [int(c) for c in np.random.default_rng(3).integers(-12000, -9000, 200)]
GOOD = knet_text(COUNTS, 100)
GAL = np.array(COUNTS) * 3920.0 / 6182761.0


def read(tmp_path, text, component=None, name="MADE010301020304.NS"):
    path = tmp_path / name
    path.write_text(text)
    return read_record(path, component=component)


def test_layout(tmp_path, caplog):
    assert GOOD.splitlines()[17][:9] == f"{COUNTS[0]:9d}"
    with caplog.at_level(logging.INFO, logger="impactfem"):
        record = read(tmp_path, GOOD)
    assert record.time_step == 0.01
    assert record.acceleration == pytest.approx(0.01 * (GAL - GAL.mean()), rel=1e-12)
    assert record.acceleration.mean() == pytest.approx(0.0, abs=1e-15)
    assert f"mean of {GAL.mean():.4g} gal taken out" in record.origin
    assert "MADE01 N-S, first sample 2003-01-02 03:04:30 JST" in record.origin
    assert "offset of the instrument" in caplog.text


def test_the_published_example_of_the_scale(tmp_path):
    # NIED's page: 8009 counts at 3920(gal)/6182761 are 5.078 gal.
    record = read(tmp_path, knet_text([8009, -8009] * 50, 100))
    assert record.acceleration[:2] == pytest.approx([0.05078, -0.05078], abs=5e-6)


@pytest.mark.parametrize(
    ("direction", "names"), [("N-S", ["N-S", "ns"]), ("4", ["4", "NS2", "ns2"])]
)
def test_its_component_may_be_asked_for(tmp_path, direction, names):
    text = knet_text(COUNTS, 100, direction=direction)
    for name in names:
        assert read(tmp_path, text, name).acceleration.size == 200
    with pytest.raises(InputError, match="component = 'EW': the file holds one component, N"):
        read(tmp_path, text, "EW")


def test_a_peak_that_is_not_the_header_s_is_warned_of(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, logger="impactfem"):
        read(tmp_path, GOOD)
        assert not caplog.records
        read(tmp_path, GOOD.replace("3920(gal)", "2000(gal)"))
    assert "warning: " in caplog.text and "the largest sample is" in caplog.text


def test_the_english_page_has_other_keys(tmp_path):
    text = GOOD.replace("Long.", "Lon. ").replace("Max. Acc.", "Max Acc. ")
    assert read(tmp_path, text).acceleration.size == 200


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
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
)
def test_faults(tmp_path, old, new, message):
    assert old in GOOD
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, GOOD.replace(old, new, 1))
    assert "MADE010301020304.NS" in str(caught.value)
