"""What is hardly meant, as `check` and `run` say it."""

import logging
from types import SimpleNamespace

import pytest

from impactfem import study
from impactfem.run import loop
from impactfem.system.scalar import Scalar

LINE = "materials.concrete.young_modulus = '30 Pa': usual is concrete 20 to 45 GPa"


def lines(caplog):
    return [r.getMessage() for r in caplog.records if r.levelno == logging.WARNING]


def test_check_warns_of_a_value(new_case, tmp_path, caplog):
    path = new_case(tmp_path, ('"30 GPa"', '"30 Pa"'))
    with caplog.at_level(logging.INFO, "impactfem"):
        study.check(path, mesh=True)
    (line,) = lines(caplog)
    assert line.startswith(f"warning: {path}: {LINE}")
    caplog.clear()
    study.check(path)
    assert lines(caplog) == []


@pytest.mark.usefixtures("no_figures")
def test_a_run_warns_once(new_case, tmp_path):
    axis = 'axis = ["10 m", "18.02 m"]'
    path = new_case(tmp_path, (axis, f'{axis}\nlength = "4 km"'))
    study.run(path, out=tmp_path / "run", stage="pounding", bar=False)
    text = (tmp_path / "run/run.log").read_text(encoding="utf-8")
    assert text.count("buildings[1].length = '4 km': usual is 5 to 200 m") == 1


def test_published_values_that_no_result_has(caplog):
    def value(unit):
        return SimpleNamespace(unit=unit)

    published = {
        "frs.floor_8.peak": value("m/s2"),
        "frs.floor_8.pfa": value("m"),
        "frs.flor_8.pfa": value("m/s2"),
        "sticks.nobody": value("Hz"),
        "calibration.epsilon.damped.printed": value("-"),
    }
    found = {
        "frs.floor_8.peak": "m/s2",
        "frs.floor_8.pfa": "m/s2",
        "calibration.epsilon.damped": "-",
    }
    scalars = [Scalar(name, 1.0, unit) for name, unit in found.items()]
    loop._warn_of_published(SimpleNamespace(published=published), scalars)
    assert lines(caplog) == [
        "warning: published value frs.floor_8.pfa: a unit of m, and the result has m/s2",
        "warning: published value frs.flor_8.pfa: no result of this run; did you mean "
        "'frs.floor_8.pfa'?",
        "warning: published value sticks.nobody: no result of this run",
    ]


def test_a_whole_run_has_what_is_published(finished):
    text = (finished.folder / "run.log").read_text(encoding="utf-8")
    assert "published value" not in text
