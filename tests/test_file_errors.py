"""What the system refuses becomes a message."""

import errno
import os

import pytest

from impactfem.errors import ImpactfemError
from impactfem.file_errors import file_errors


def test_the_file_and_the_reason_are_named(tmp_path, caplog):
    path = tmp_path / "é" / "a.txt"
    with (
        caplog.at_level("DEBUG", "impactfem"),
        pytest.raises(ImpactfemError, match=f"^cannot read or write {path}: No such file"),
        file_errors(),
    ):
        path.read_bytes()
    assert "Traceback" in caplog.text  # for the log, where it helps


def test_a_write_that_knows_no_name():
    with (
        pytest.raises(ImpactfemError, match=r"write a file: No space left on device$"),
        file_errors(),
    ):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("error", [OSError("a fault of a library"), ValueError("two"), KeyError(1)])
def test_other_errors_stay(error):
    with pytest.raises(type(error)) as raised, file_errors():
        raise error
    assert raised.value is error
