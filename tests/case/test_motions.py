"""The motions of a case file: records, synthetic ones with their design spectra, ensembles."""

import tomllib

import jsonschema
import pytest
from pydantic import ValidationError

from docs._ext.case_reference import json_schema
from impactfem.case import RecordMotion, SyntheticMotion, load_case, motion_files
from impactfem.case.design_spectrum import (
    DecreeSpectrum,
    DesignSpectrum,
    EurocodeSpectrum,
    TableSpectrum,
    read_spectrum,
)

from .faults import by_file as faults_of
from .faults import check_fault
from .sections import DECREE, EC8, POINTS, RECORDED, SPECTRUM, TABLE, with_spectrum


def record(**keys):
    return RecordMotion.model_validate({"direction": "x", "type": "record", "file": "a.csv"} | keys)


def test_nothing_is_done_unless_requested():
    plain = record()
    assert (plain.baseline, plain.taper, plain.filter, plain.resample) == ("none", None, None, None)
    assert plain.component is None


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        *(("a.CSV", "csv"), ("a.at2", "at2"), ("a.V2C", "cosmos"), ("AOM.EW", "knet")),
        *(("AOM.ud2", "knet"), ("a.ASC", None), ("a.txt", None), ("a.v2", None)),
    ],
)
def test_format_by_the_ending(file, expected):
    assert record(file=file).format == expected


def test_ending_of_no_format():
    message = "missing; expected 'csv' or 'at2' or 'esm' or 'cosmos' or 'csmip' or 'knet': the end"
    with pytest.raises(ValidationError, match=message):
        record(file="a.dat")
    assert record(file="a.dat", format="esm").format == "esm"


@pytest.mark.parametrize(("given", "held"), [("NS", "NS"), (2, "2"), (" 90 deg ", "90 deg")])
def test_component_by_name_or_number(given, held):
    assert record(component=given).component == held


def test_treatment_with_units(written):
    keys = (
        'component = "NS"\nbaseline = "rest"\ntaper = "500 ms"\nresample = "2 ms"\n'
        'filter = ["0.1 Hz", "0.04 kHz"]\npga = "0.2 g"\n'
    )
    file = 'file = "motion.csv"\n'
    (motion,) = load_case(written(RECORDED, (None, file, file + keys))).motions
    assert isinstance(motion, RecordMotion)
    assert (motion.baseline, motion.taper, motion.resample) == ("rest", 0.5, 0.002)
    assert motion.filter == (0.1, 40.0)
    assert motion.component == "NS"


def spectrum_of(path):
    (motion,) = load_case(path).motions
    assert isinstance(motion, SyntheticMotion)
    return motion.spectrum


@pytest.mark.parametrize("type_line", ["", 'type = "corner-periods"\n'])
def test_corner_periods_with_and_without_type(written, type_line):
    keys = 'ground_acceleration = "2 m/s2"\ncorner_periods = ["0.1 s", "0.2 s", "2 s"]\n'
    spectrum = spectrum_of(written(with_spectrum(type_line + keys)))
    assert isinstance(spectrum, DesignSpectrum)
    assert (spectrum.amplification, spectrum.type) == (2.5, "corner-periods")


def test_standards(written):
    for keys, kind, more, values in (
        (EC8, EurocodeSpectrum, "importance_factor = 1.4\nvertical = true\n", (1.4, True)),
        (DECREE, DecreeSpectrum, 'text = "special"\nimportance_factor = 2.2\n', (2.2, False)),
    ):
        spectrum = spectrum_of(written(with_spectrum(keys)))
        assert isinstance(spectrum, kind)
        assert (spectrum.importance_factor, spectrum.vertical) == (1.0, False)
        spectrum = spectrum_of(written(with_spectrum(keys + more)))
        assert (spectrum.importance_factor, spectrum.vertical) == values
    assert spectrum_of(written(with_spectrum(DECREE))).text == "ordinary"


def test_table(written):
    path = written(with_spectrum(TABLE))
    spectrum, case = spectrum_of(path), load_case(path)
    assert isinstance(spectrum, TableSpectrum)
    assert motion_files(case.motions[0]) == (spectrum.file,) == (path.parent / "target.csv",)
    assert motion_files(load_case(written(with_spectrum(EC8))).motions[0]) == ()


@pytest.mark.parametrize("value", ["3", '"ec8"', "[]", "true", "{}", "{ type = [1] }"])
def test_any_value_is_refused_in_words(broken, value):
    faults = faults_of(broken((None, SPECTRUM, f"spectrum = {value}\n\n")))
    assert all(key.startswith("pair.toml: motions[0].spectrum") for key in faults)
    assert all(faults.values())


@pytest.mark.parametrize("keys", [EC8, DECREE, TABLE])
def test_any_spectrum_agrees_with_the_schema_and_travels(written, keys):
    validator = jsonschema.Draft202012Validator(json_schema())
    path = written(with_spectrum(keys))
    raw = tomllib.loads(path.read_text(encoding="utf-8"))
    assert validator.is_valid(raw)
    raw["motions"][0]["spectrum"]["zz"] = 1
    assert not validator.is_valid(raw)
    case = load_case(path)
    assert f'"type":"{spectrum_of(path).type}"' in case.model_dump_json()


def read(tmp_path, text):
    path = tmp_path / "target.csv"
    path.write_text(text)
    faults = []
    return read_spectrum(path, faults), faults


def test_periods_and_dampings(tmp_path):
    text = "period [ms],acceleration [g],damping [%]\n100,1,2\n1000,0.5,2\n100,2,5\n10,1,5\n"
    table, faults = read(tmp_path, text)
    assert not faults
    assert table.dampings == "2 %, 5 %"
    frequency, acceleration = table.at(0.02)
    assert frequency == pytest.approx((1.0, 10.0))
    assert acceleration == pytest.approx((4.903325, 9.80665))
    assert table.at(0.05)[0] == pytest.approx((10.0, 100.0))
    assert table.at(0.03) is None


HEADER = "frequency [Hz],acceleration [g]\n"
F, A = "column frequency [Hz]", "column acceleration [g]"


@pytest.mark.parametrize(
    ("text", "key", "kind"),
    [
        (f"{HEADER}1,1\n", "line 2", "points"),
        ("acceleration [g]\n1\n2\n", "header", "one_abscissa"),
        ("frequency [Hz],period [s],acceleration [g]\n1,1,1\n2,2,2\n", "header", "one_abscissa"),
        (f"{HEADER}1,1\n1,2\n", f"line 3, {F}", "order"),
        (f"{HEADER}1,1\n3,2\n2,2\n", f"line 4, {F}", "order"),
        (f"{HEADER}0,1\n3,2\n", f"line 2, {F}", "greater_than 0"),
        (f"{HEADER}1,0\n3,2\n", f"line 2, {A}", "greater_than 0"),
        ("frequency [Hz],acceleration [g],damping [%]\n1,1,100\n3,2,5\n",
         "line 2, column damping [%]", "less_than 1"),
    ],
)  # fmt: skip
def test_tables_refused(tmp_path, text, key, kind):
    table, faults = read(tmp_path, text)
    assert table is None
    check_fault(faults, key, kind)


def test_damping_that_the_table_does_not_have(written):
    points = "frequency [Hz],acceleration [g],damping [%]\n1,1,2\n9,1,2\n1,1,4\n9,1,4\n"
    line, words = 'damping = "5 %"\n', "expected a damping of target.csv: 2 %, 4 %"
    for new, expected in (('damping = "3 %"\n', words), ("", f"{words}, not the default 5 %")):
        path = written(with_spectrum(TABLE, points), (None, f"{line}\n[", f"{new}\n["))
        assert faults_of(path) == {"pair.toml: motions[0].damping": expected}
        # A table without dampings has any.
        path.with_name("target.csv").write_text(POINTS)
        assert spectrum_of(path)
    path.with_name("target.csv").write_text(points.replace(",4", ",5"))
    assert spectrum_of(path)


def test_a_broken_table_is_reported_by_its_line(written):
    faults = faults_of(written(with_spectrum(TABLE, POINTS.replace("0.5", "x"))))
    assert list(faults) == ["target.csv: line 3, column acceleration [g]"]


def test_synthetic_ensemble(broken):
    ensemble = load_case(broken(more="\n[ensemble]\nmotions = 5\nfirst_seed = 3\n")).ensemble
    assert (ensemble.motions, ensemble.first_seed, ensemble.files()) == (5, 3, ())
    assert ensemble.structure_motions == 0
