import pytest

from impactfem.errors import InputError
from impactfem.motion import read_record

CSV = "time [s],acceleration [m/s2]\n0,0\n0.01,1.5\n"


def test_the_format_may_be_named(tmp_path):
    path = tmp_path / "record.txt"
    path.write_text(CSV)
    assert read_record(path, "csv").acceleration[1] == 1.5
    assert read_record(str(path), fmt="csv").time_step == pytest.approx(0.01)
    with pytest.raises(
        InputError, match=r"the ending '.txt' is not known; expected 'csv' or 'at2'"
    ):
        read_record(path)
    with pytest.raises(InputError, match="the format 'xls' is not known"):
        read_record(path, "xls")


def test_paths_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="No such file or directory"):
        read_record(tmp_path / "missing.csv")
    folder = tmp_path / "folder.csv"
    folder.mkdir()
    with pytest.raises(InputError, match="cannot be read"):
        read_record(folder)
