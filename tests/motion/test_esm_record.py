import logging

import numpy as np
import pytest

from impactfem.motion import read_record
from impactfem.system.errors import InputError
from impactfem.verify.record_files import esm_text

A = np.round(np.random.default_rng(3).standard_normal(50), 6)
GOOD = esm_text(A, 0.005)


def read(tmp_path, text, component=None):
    path = tmp_path / "XX.MADE..HNN.D.ASC"
    path.write_text(text)
    return read_record(path, component=component)


def test_layout(tmp_path):
    assert GOOD.splitlines()[63] == "USER5: "
    record = read(tmp_path, GOOD)
    assert record.time_step == 0.005
    assert record.acceleration == pytest.approx(0.01 * A, rel=1e-14)
    assert record.name == "XX.MADE..HNN.D"
    assert "XX.MADE.HNN, NOWHERE 20030102, baseline removed" in record.origin


def test_windows_lines_and_other_units(tmp_path):
    text = GOOD.replace("UNITS: cm/s^2", "UNITS: m/s^2").replace("\n", "\r\n")
    assert read(tmp_path, text).acceleration == pytest.approx(A)


def test_its_component_may_be_asked_for(tmp_path):
    assert read(tmp_path, GOOD, "hnn").acceleration.size == 50
    with pytest.raises(InputError, match=r"component = 'HNE': the file holds one component, HNN;"):
        read(tmp_path, GOOD, "HNE")


def test_a_peak_that_is_not_the_header_s_is_warned_of(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, logger="impactfem"):
        read(tmp_path, GOOD)
        assert not caplog.records
        read(tmp_path, GOOD.replace("PGA_CM/S^2: ", "PGA_CM/S^2: 9"))
    assert "warning: " in caplog.text and "the largest sample is" in caplog.text


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("NDATA: 50", "NDATA: 51", r"line 30 = 'NDATA: 51': the header announces 51 samples, the"),
        ("NDATA: 50", "NDATA: many", "line 30 = 'many': expected the number of samples as NDATA"),
        ("NDATA: 50\n", "N: 50\n", "the header has no NDATA; expected the number of samples"),
        ("S: 0.005", "S: -0.005", "line 29 = '-0.005000': expected the time step in seconds"),
        ("UNITS: cm/s^2", "UNITS: cm/s", "line 33 = 'cm/s': expected a unit of acceleration"),
        ("UNITS: cm/s^2", "UNIT: cm/s^2", "the header has no UNITS"),
        ("DATA_TYPE: ACC", "DATA_TYPE: DISPLACEMENT ACC", "expected DATA_TYPE: ACCELERATION"),
        ("USER3: \n", "", "line 64 = '-?[0-9.]+': the header ends early"),
        (f"\n{A[7]:.6f}\n", "\nnan\n", "line 72 = 'nan': expected one finite number"),
        (f"\n{A[7]:.6f}\n", "\n1 2\n", "line 72 = '1 2': expected one finite number"),
        (f"\n{A[7]:.6f}\n", "\n", "announces 50 samples, the file has 49"),
    ],
)
def test_faults(tmp_path, old, new, message):
    assert old in GOOD
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, GOOD.replace(old, new))
    assert "XX.MADE..HNN.D.ASC" in str(caught.value)


def test_all_faults_at_once(tmp_path):
    text = GOOD.replace("UNITS: cm/s^2", "UNITS: V").replace("NDATA: 50", "NDATA: x")
    with pytest.raises(InputError) as caught:
        read(tmp_path, text + "oops\n")
    assert [fault.key for fault in caught.value.faults] == ["line 30", "line 33", "line 115"]
