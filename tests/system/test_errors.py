import errno
import os
import pickle
from datetime import date, time
from pathlib import Path

import numpy as np
import pytest

from impactfem.system.errors import (
    MOST_FAULTS,
    Fault,
    ImpactfemError,
    InputError,
    SolutionError,
    file_errors,
    printable,
)


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        (Fault("a.toml", "gap", "1 kg", "a length"), "a.toml: gap = '1 kg': a length"),
        (Fault(Path("a.toml"), "gap", -1.0, "at least 0"), "a.toml: gap = -1.0: at least 0"),
        (Fault("a.toml", "gap", None, "missing"), "a.toml: gap: missing"),
        (Fault("a.toml", "", None, "no such file"), "a.toml: no such file"),
        (Fault("a.toml", "gap", 0, "above 0"), "a.toml: gap = 0: above 0"),
        (Fault("a.toml", "gap", "", "a length"), "a.toml: gap = '': a length"),
        (Fault("a.toml", "gap", True, "a length"), "a.toml: gap = true: a length"),
        (Fault("a.toml", "gap", "True", "a length"), "a.toml: gap = 'True': a length"),
        (Fault("a.toml", "gap", date(2024, 1, 2), "text"), "a.toml: gap = 2024-01-02: text"),
        (Fault("a.toml", "gap", time(10, 11, 12), "text"), "a.toml: gap = 10:11:12: text"),
        (Fault("a.toml", "gap", "x" * 70, "a length"), f"a.toml: gap = '{'x' * 70}': a length"),
        (Fault("a", "gap", "x" * 1000, "a length"), f"a: gap = '{'x' * 76}...: a length"),
        (Fault("a", "x" * 100_000, None, "unknown"), f"a: {'x' * 157}...: unknown"),
    ],
)
def test_a_fault_says_where_what_and_what_was_expected(fault, text):
    assert str(fault) == text


def test_an_input_error_keeps_every_fault_also_from_another_process():
    faults = [Fault("a.csv", "line 2", "nan", "a number"), Fault("b", "", None, "text")]
    error = InputError(fault for fault in faults)
    again = pickle.loads(pickle.dumps(error))
    assert again.faults == error.faults == tuple(faults)
    assert str(again).splitlines() == ["a.csv: line 2 = 'nan': a number", "b: text"]
    assert isinstance(error, ImpactfemError) and not issubclass(SolutionError, InputError)


@pytest.mark.parametrize("sign", ["\n", "\r", "\x1b[31m", "\x85", "\u2028", "\u202e", "\udc80"])
def test_a_fault_is_one_line_that_commands_no_terminal(sign):
    for fault in (
        Fault(f"a{sign}.toml", "gap", None, "missing"),
        Fault("a.toml", f"ga{sign}p", None, "missing"),
        Fault("a.toml", "gap", f"1{sign}", "missing"),
        Fault("a.toml", "gap", None, f"missing{sign}"),
    ):
        text = str(fault)
        assert len(text.splitlines()) == 1 and text.isprintable() and "\\" in text


def test_letters_of_any_language_stay():
    text = "Bâtiment α, 梁 \u200c"
    assert printable(text) == text


def test_more_faults_than_anyone_reads():
    error = InputError(Fault("a.toml", f"key_{k}", None, "unknown") for k in range(1000))
    assert len(error.faults) == MOST_FAULTS
    assert "801 further faults" in error.faults[-1].expected
    assert pickle.loads(pickle.dumps(error)).faults == error.faults
    whole = InputError(Fault("a.toml", f"key_{k}", None, "unknown") for k in range(MOST_FAULTS))
    assert whole.faults[-1].key == f"key_{MOST_FAULTS - 1}"


def test_the_file_and_the_reason_are_named(tmp_path, caplog):
    path = tmp_path / "é" / "a.txt"
    refused = pytest.raises(ImpactfemError, match=f"{path}: No such file")
    with caplog.at_level("DEBUG", "impactfem"), refused, file_errors():
        path.read_bytes()
    assert "Traceback" in caplog.text  # for the log, where it helps


def test_a_write_that_knows_no_name():
    refused = pytest.raises(ImpactfemError, match=r"left on device$")
    with refused, file_errors():
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
