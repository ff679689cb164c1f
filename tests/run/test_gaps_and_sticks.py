"""What `check` and the stages say of gaps, of the stick beside the 3D model, and of seeds."""

import json
import logging
from pathlib import Path
from types import SimpleNamespace

import pytest

from impactfem import study
from impactfem.case import load_case
from impactfem.run import loop
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.transient import stage as transient
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"


def told(caplog, path, *, mesh=True):
    caplog.clear()
    with caplog.at_level(logging.INFO, "impactfem"):
        study.check(path, mesh=mesh)
    return [r.getMessage() for r in caplog.records if r.levelno == logging.WARNING]


def test_check_tells_of_a_gap_that_is_another(new_case, tmp_path, caplog):
    path = new_case(tmp_path, ('gap = "2 cm"', 'gap = "20 cm"'))
    (line,) = told(caplog, path)
    assert "0.02 m apart along the normal" in line and "its gap is 0.2 m; the gap counts" in line
    assert "so it is for 2 more" in line
    # A run says it at the end of its stage, once.
    assert told(caplog, path, mesh=False) == []


def test_check_is_quiet_where_they_agree(new_case, tmp_path, caplog):
    assert told(caplog, new_case(tmp_path)) == []


def test_check_refuses_a_normal_from_b_to_a(new_case, tmp_path):
    path = new_case(tmp_path, ("normal = [0, 1, 0]", "normal = [0, -1, 0]"))
    with pytest.raises(InputError, match=r"are -0.02 m apart along it, and the gap is 0.02 m"):
        study.check(path)


@pytest.mark.parametrize("name", ["npp_pair", "two_frames", "frame"])
def test_the_shipped_cases_have_the_gaps_of_their_plans(caplog, name):
    assert told(caplog, GEOMETRY / f"{name}.toml", mesh=False) == []
    loop._warn_of_gaps(load_case(GEOMETRY / f"{name}.toml"))
    assert not [r for r in caplog.records if r.levelno == logging.WARNING]


def test_it_is_one_of_the_checks_of_a_run(finished):
    checks = json.loads((finished.folder / "checks.json").read_text(encoding="utf-8"))
    (found,) = (one for one in checks if "axes and offsets" in one["text"])
    assert found == {
        "stage": "pounding",
        "good": True,
        "text": "contact: 3 gaps are those of axes and offsets",
    }
    case = load_case(finished.case)
    assert (True, found["text"]) in POUNDING.checks(case, finished.folder)


@pytest.mark.parametrize("forces", [None, Path("forces.csv")])
def test_the_stick_is_checked_where_its_forces_are_taken(monkeypatch, forces):
    own, stick = (True, "of the stage"), (False, "of the stick")
    monkeypatch.setattr(transient, "transient_checks", lambda folder: [own])
    monkeypatch.setattr(transient, "stick_against_model", lambda folder: [stick])
    case = SimpleNamespace(transient=SimpleNamespace(forces=forces))
    found = transient.TRANSIENT.checks(case, Path())
    assert found == ([own, stick] if forces is None else [own])


def test_seeds_by_their_keys():
    assert loop._seeds(load_case(GEOMETRY / "npp_pair.toml")) == {
        "motions[0].seed": 127,
        "calibration.seed": 0,
        "ensemble.first_seed": 0,
    }


def test_seeds_of_what_is_computed_alone(new_case, tmp_path):
    """Without an ensemble and without a fit."""
    assert loop._seeds(load_case(new_case(tmp_path))) == {"motions[0].seed": 1}
