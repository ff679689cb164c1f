"""What the system refuses becomes a message."""

import errno
import os

import numpy as np
import pytest

from impactfem.system.errors import ImpactfemError
from impactfem.system.file_errors import file_errors


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


class PetscError(RuntimeError):
    ierr = 55


@pytest.mark.parametrize(
    "take",
    [
        lambda: np.zeros(10**16),
        lambda: np.arange(0.0, 1.0, 1e-30),
        lambda: np.zeros(2**62),
        lambda: bytearray(2**62),
        lambda: (_ for _ in ()).throw(PetscError("error code 55\n[0] ...")),
    ],
    ids=["_ArrayMemoryError", "size", "dimension", "bytes", "PETSc"],
)
def test_memory_that_there_is_not(take):
    expected = "^not enough memory.*'impactfem check'"
    with pytest.raises(ImpactfemError, match=expected), file_errors():
        take()
    with pytest.raises((MemoryError, ValueError, RuntimeError)):  # without the block
        take()
