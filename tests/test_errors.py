import pickle
from pathlib import Path

import pytest

from impactfem.errors import Fault, ImpactfemError, InputError, SolutionError


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        (Fault("a.toml", "gap", "1 kg", "a length"), "a.toml: gap = '1 kg': a length"),
        (Fault(Path("a.toml"), "gap", -1.0, "at least 0"), "a.toml: gap = -1.0: at least 0"),
        (Fault("a.toml", "gap", None, "missing"), "a.toml: gap: missing"),
        (Fault("a.toml", "", None, "no such file"), "a.toml: no such file"),
        (Fault("a.toml", "gap", 0, "above 0"), "a.toml: gap = 0: above 0"),
        (Fault("a.toml", "gap", "", "a length"), "a.toml: gap = '': a length"),
    ],
)
def test_a_fault_says_where_what_and_what_was_expected(fault, text):
    assert str(fault) == text


def test_a_long_value_is_cut():
    text = str(Fault("a.toml", "gap", "x" * 1000, "a length"))
    assert len(text) < 120 and "..." in text and text.endswith(": a length")
    assert "..." not in str(Fault("a.toml", "gap", "x" * 70, "a length"))


def test_a_long_key_is_cut():
    text = str(Fault("a.csv", f"line 1, column {'x' * 100_000}", None, "unknown column"))
    assert len(text) < 200 and text.endswith("...: unknown column")


def test_an_input_error_keeps_every_fault():
    faults = [Fault("a.toml", key, None, "missing") for key in ("gap", "law")]
    error = InputError(fault for fault in faults)
    assert error.faults == tuple(faults)
    assert str(error).splitlines() == ["a.toml: gap: missing", "a.toml: law: missing"]


def test_one_base_for_all():
    for error in (InputError([]), SolutionError("no result")):
        assert isinstance(error, ImpactfemError)
    assert not issubclass(SolutionError, InputError)


def test_an_input_error_comes_whole_from_another_process():
    error = InputError([Fault("a.csv", "line 2", "nan", "a number"), Fault("b", "", None, "text")])
    again = pickle.loads(pickle.dumps(error))
    assert again.faults == error.faults and str(again) == str(error)
