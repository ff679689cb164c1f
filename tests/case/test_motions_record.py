"""Keys of a record motion: format, component, treatment."""

from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import ValidationError

from impactfem.case import RecordMotion, load_case
from impactfem.system.errors import InputError

BASE = {"direction": "x", "type": "record", "file": "a.csv"}
TEXT = '[[motions]]\ndirection = "x"\ntype = "record"\nfile = "motion.csv"\n'


def record(**keys: object) -> RecordMotion:
    return RecordMotion.model_validate(BASE | keys)


@pytest.fixture
def with_record(broken: Callable[..., Path]) -> Callable[[str], Path]:
    """The case with a record in place of its synthetic motion, and more keys of it."""

    def make(keys: str) -> Path:
        path = broken()
        (path.parent / "motion.csv").write_text("time [s],NS [g],EW [g]\n0,0,0\n1,1,2\n")
        text = path.read_text(encoding="utf-8")
        begin, end = text.index("[[motions]]"), text.index("[contact_laws")
        path.write_text(text[:begin] + TEXT + keys + "\n\n" + text[end:], encoding="utf-8")
        return path

    return make


def test_nothing_is_done_unless_asked() -> None:
    plain = record()
    assert (plain.baseline, plain.taper, plain.filter, plain.resample) == ("none", None, None, None)
    assert plain.component is None


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("a.CSV", "csv"),
        ("a.at2", "at2"),
        ("a.V2C", "cosmos"),
        ("AOM.EW", "knet"),
        ("AOM.ud2", "knet"),
        ("a.ASC", None),
        ("a.txt", None),
        ("a.v2", None),
    ],
)
def test_format_by_the_ending(file: str, expected: str | None) -> None:
    assert record(file=file).format == expected


def test_ending_of_no_format() -> None:
    message = "missing; expected 'csv' or 'at2' or 'esm' or 'cosmos' or 'csmip' or 'knet', the end"
    with pytest.raises(ValidationError, match=message):
        record(file="a.dat")
    assert record(file="a.dat", format="esm").format == "esm"


@pytest.mark.parametrize(("given", "held"), [("NS", "NS"), (2, "2"), (" 90 deg ", "90 deg")])
def test_component_by_name_or_number(given: object, held: str) -> None:
    assert record(component=given).component == held


def test_treatment_with_units(with_record: Callable[[str], Path]) -> None:
    keys = (
        'component = "NS"\nbaseline = "rest"\ntaper = "500 ms"\nresample = "2 ms"\n'
        'filter = ["0.1 Hz", "0.04 kHz"]\npga = "0.2 g"'
    )
    (motion,) = load_case(with_record(keys)).motions
    assert isinstance(motion, RecordMotion)
    assert (motion.baseline, motion.taper, motion.resample) == ("rest", 0.5, 0.002)
    assert motion.filter == (0.1, 40.0)
    assert motion.component == "NS"


@pytest.mark.parametrize(
    ("keys", "key", "words"),
    [
        ("component = 0", "component", "expected the name of a component in quotes, or its number"),
        ('component = " "', "component", "expected the name of a component"),
        ('filter = ["40 Hz", "0.1 Hz"]', "filter", "the low corner frequency before the high"),
        ('filter = ["1 Hz", "1 Hz"]', "filter", "the low corner frequency before the high"),
        ('bandpass = ["1 Hz", "2 Hz"]', "bandpass", "unknown key"),
        ('scale = 2\npga = "1 m/s2"', "pga", "expected either scale or pga, not both"),
    ],
)
def test_refused_in_words(
    with_record: Callable[[str], Path], keys: str, key: str, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        load_case(with_record(keys))
    (fault,) = caught.value.faults
    assert fault.key == f"motions[0].{key}"
    assert words in fault.expected
