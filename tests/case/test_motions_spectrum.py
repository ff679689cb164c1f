"""The design spectra of a synthetic motion, and the table of one."""

import pickle
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest

from docs._ext.case_reference import json_schema
from impactfem.case import (
    DecreeSpectrum,
    DesignSpectrum,
    EurocodeSpectrum,
    SyntheticMotion,
    TableSpectrum,
    load_case,
    motion_files,
)
from impactfem.case.design_spectrum import read_spectrum
from impactfem.system.errors import Fault

from .faults import by_file as faults_of
from .faults import refused

EC8 = 'type = "ec8"\nspectrum_type = 1\nground = "B"\nreference_acceleration = "2 m/s2"\n'
DECREE = 'type = "french-decree"\nzone = 4\nground = "B"\n'
TABLE = 'type = "table"\nfile = "target.csv"\n'
POINTS = "frequency [Hz],acceleration [g]\n0.2,0.1\n10,0.5\n50,0.2\n"

With = Callable[..., Path]


@pytest.fixture
def with_spectrum(broken: Callable[..., Path]) -> With:
    """The case with another spectrum of its motion."""

    def make(keys: str, points: str = POINTS, damping: str = "5 %") -> Path:
        path = broken()
        (path.parent / "target.csv").write_text(points)
        text = path.read_text(encoding="utf-8").replace(
            'strong_phase = ["2 s", "5 s"]\ndamping = "5 %"',
            f'strong_phase = ["2 s", "5 s"]\ndamping = "{damping}"',
        )
        begin, end = text.index("[motions.spectrum]"), text.index("[contact_laws")
        path.write_text(f"{text[:begin]}[motions.spectrum]\n{keys}\n{text[end:]}", encoding="utf-8")
        return path

    return make


def spectrum_of(path: Path) -> object:
    (motion,) = load_case(path).motions
    assert isinstance(motion, SyntheticMotion)
    return motion.spectrum


@pytest.mark.parametrize("type_line", ["", 'type = "corner-periods"\n'])
def test_corner_periods_with_and_without_type(with_spectrum: With, type_line: str) -> None:
    keys = 'ground_acceleration = "2 m/s2"\ncorner_periods = ["0.1 s", "0.2 s", "2 s"]\n'
    spectrum = spectrum_of(with_spectrum(type_line + keys))
    assert isinstance(spectrum, DesignSpectrum)
    assert (spectrum.amplification, spectrum.type) == (2.5, "corner-periods")


def test_eurocode(with_spectrum: With) -> None:
    spectrum = spectrum_of(with_spectrum(EC8))
    assert isinstance(spectrum, EurocodeSpectrum)
    assert (spectrum.importance_factor, spectrum.vertical) == (1.0, False)
    more = spectrum_of(with_spectrum(EC8 + "importance_factor = 1.4\nvertical = true\n"))
    assert isinstance(more, EurocodeSpectrum)
    assert (more.importance_factor, more.vertical) == (1.4, True)


def test_decree(with_spectrum: With) -> None:
    spectrum = spectrum_of(with_spectrum(DECREE))
    assert isinstance(spectrum, DecreeSpectrum)
    assert (spectrum.text, spectrum.importance_factor) == ("ordinary", 1.0)
    special = spectrum_of(with_spectrum(DECREE + 'text = "special"\nimportance_factor = 2.2\n'))
    assert isinstance(special, DecreeSpectrum)
    assert special.importance_factor == 2.2


def test_table(with_spectrum: With) -> None:
    path = with_spectrum(TABLE)
    spectrum = spectrum_of(path)
    assert isinstance(spectrum, TableSpectrum)
    assert spectrum.file == path.parent / "target.csv"
    (motion,) = load_case(path).motions
    assert motion_files(motion) == (path.parent / "target.csv",)
    assert motion_files(load_case(with_spectrum(EC8)).motions[0]) == ()


def test_hash_covers_the_table(with_spectrum: With) -> None:
    first = load_case(with_spectrum(TABLE)).content_hash()
    assert load_case(with_spectrum(TABLE, POINTS + "# one more\n")).content_hash() != first


@pytest.mark.parametrize(
    ("keys", "key", "words"),
    [
        (EC8.replace('"ec8"', '"ec9"'), "type",
         "expected 'corner-periods' or 'ec8' or 'french-decree' or 'table'"),
        (EC8.replace("spectrum_type = 1\n", ""), "spectrum_type",
         "missing; expected a whole number of at least 1 and at most 2: Type of spectrum"),
        (EC8 + "amplification = 2.5", "amplification",
         "unknown key; known: type, spectrum_type, ground, reference_acceleration"),
        (EC8 + "importance_facto = 1", "importance_facto", "did you mean 'importance_factor'?"),
        (DECREE + 'text = "special"', "importance_factor",
         "missing; expected the acceleration of the special-risk text over the zone's a_gr"),
        (TABLE.replace("target", "none"), "file", "no such file; expected a table of a design"),
        (TABLE + "damping = 0.05", "damping", "unknown key; known: type, file"),
    ],
)  # fmt: skip
def test_refused_in_words(with_spectrum: With, keys: str, key: str, words: str) -> None:
    refused(with_spectrum(keys), f"pair.toml: motions[0].spectrum.{key}", words)


@pytest.mark.parametrize("value", ["3", '"ec8"', "[]", "true", "{}", "{ type = [1] }"])
def test_any_value_is_refused_in_words(broken: Callable[..., Path], value: str) -> None:
    path = broken()
    text = path.read_text(encoding="utf-8")
    begin, end = text.index("[motions.spectrum]"), text.index("[contact_laws")
    path.write_text(f"{text[:begin]}spectrum = {value}\n\n{text[end:]}", encoding="utf-8")
    faults = faults_of(path)
    assert all(key.startswith("pair.toml: motions[0].spectrum") for key in faults)
    assert all(faults.values())


def test_every_fault_at_once(with_spectrum: With) -> None:
    keys = 'type = "ec8"\nspectrum_type = 7\nground = "b"\nimportance_factor = -1\n'
    assert list(faults_of(with_spectrum(keys))) == [
        f"pair.toml: motions[0].spectrum.{key}"
        for key in ("spectrum_type", "ground", "reference_acceleration", "importance_factor")
    ]


def test_schema_agrees_with_the_loader(with_spectrum: With) -> None:
    validator = jsonschema.Draft202012Validator(json_schema())
    for keys in (EC8, DECREE, TABLE):
        raw = tomllib.loads(with_spectrum(keys).read_text(encoding="utf-8"))
        assert validator.is_valid(raw), keys
        raw["motions"][0]["spectrum"]["zz"] = 1
        assert not validator.is_valid(raw)


def read(tmp_path: Path, text: str) -> tuple[object, list[Fault]]:
    path = tmp_path / "target.csv"
    path.write_text(text)
    faults: list[Fault] = []
    return read_spectrum(path, faults), faults


def test_periods_and_dampings(tmp_path: Path) -> None:
    text = "period [ms],acceleration [g],damping [%]\n100,1,2\n1000,0.5,2\n100,2,5\n10,1,5\n"
    table, faults = read(tmp_path, text)
    assert not faults
    assert table.dampings == "2 %, 5 %"  # type: ignore[attr-defined]
    frequency, acceleration = table.at(0.02)  # type: ignore[attr-defined]
    assert frequency == pytest.approx((1.0, 10.0))
    assert acceleration == pytest.approx((4.903325, 9.80665))
    assert table.at(0.05)[0] == pytest.approx((10.0, 100.0))  # type: ignore[attr-defined]
    assert table.at(0.03) is None  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        ("", "", "the file is empty"),
        ("frequency [Hz],acceleration [g]\n", "", "no row below its header"),
        ("frequency [Hz],acceleration [g]\n1,1\n", "line 2", "at least 2 points of each damping"),
        ("acceleration [g]\n1\n2\n", "header", "either a column frequency .* found none of them"),
        ("frequency [Hz],period [s],acceleration [g]\n1,1,1\n2,2,2\n", "header", "found both"),
        ("frequency [Hz]\n1\n2\n", "line 1", "missing column; expected 'acceleration .m/s2.'"),
        ("frequency [Hz],acceleration [m]\n1,1\n2,1\n", "line 1, column acceleration [m]",
         "'m' is a length"),
        ("frequency [s],acceleration [g]\n1,1\n2,1\n", "line 1, column frequency [s]",
         "'s' is a time"),
        ("frequency [Hz],acceleration [g]\n1,1\n1,2\n", "line 3, column frequency [Hz]",
         "expected values in order, each once; before: 1"),
        ("frequency [Hz],acceleration [g]\n1,1\n3,2\n2,2\n", "line 4, column frequency [Hz]",
         "expected values in order, each once; before: 3"),
        ("frequency [Hz],acceleration [g]\n0,1\n3,2\n", "line 2, column frequency [Hz]",
         "expected a frequency above 0"),
        ("frequency [Hz],acceleration [g]\n1,0\n3,2\n", "line 2, column acceleration [g]",
         "expected an acceleration above 0"),
        ("frequency [Hz],acceleration [g]\n1,nan\n3,2\n", "line 2, column acceleration [g]",
         "expected a finite number"),
        ("frequency [Hz],acceleration [g],damping [%]\n1,1,100\n3,2,5\n",
         "line 2, column damping [%]", "below 1"),
    ],
)  # fmt: skip
def test_tables_refused(tmp_path: Path, text: str, key: str, words: str) -> None:
    table, faults = read(tmp_path, text)
    assert table is None
    assert key in [fault.key for fault in faults]
    assert re.search(words, " | ".join(fault.expected for fault in faults))


def test_damping_that_the_table_does_not_have(with_spectrum: With) -> None:
    points = "frequency [Hz],acceleration [g],damping [%]\n1,1,2\n9,1,2\n1,1,5\n9,1,5\n"
    assert spectrum_of(with_spectrum(TABLE, points, "2 %"))
    faults = faults_of(with_spectrum(TABLE, points, "3 %"))
    words = faults["pair.toml: motions[0].damping"]
    assert words == "expected a damping of target.csv: 2 %, 5 %"
    assert spectrum_of(with_spectrum(TABLE, POINTS, "3 %"))  # a table without dampings has any


def test_a_broken_table_is_told_by_its_line(with_spectrum: With) -> None:
    faults = faults_of(with_spectrum(TABLE, POINTS.replace("0.5", "x")))
    assert list(faults) == ["target.csv: line 3, column acceleration [g]"]


@pytest.mark.parametrize("keys", [EC8, DECREE, TABLE])
def test_a_case_with_any_spectrum_can_be_written_and_travels(
    with_spectrum: With, keys: str
) -> None:
    case = load_case(with_spectrum(keys))
    assert f'"type":"{case.motions[0].spectrum.type}"' in case.model_dump_json()  # type: ignore[union-attr]
    assert pickle.loads(pickle.dumps(case)) == case
