"""Floors that are in no pair: `check` warns of them, a run says how near they come."""

import csv
import json
import logging

import pytest

from impactfem import study

PAIRS = "floor = [1, 2, 3]"
LISTED = tuple(
    (f'building = "{name}", {PAIRS}', f'building = "{name}", floor = [1, 2]')
    for name in ("west", "east")
)


def warned(caplog, path):
    caplog.clear()
    with caplog.at_level(logging.INFO, "impactfem"):
        study.check(path, mesh=True)
    return [(r.levelno, r.getMessage()) for r in caplog.records]


def test_check_warns(new_case, tmp_path, caplog):
    path = new_case(tmp_path, *LISTED)
    ((level, line),) = warned(caplog, path)
    assert level == logging.WARNING
    assert line.startswith(f"warning: {path}: contacts: floors that face each other and are in no ")
    assert "pair: west.floor_3 and east.floor_3 (20 mm apart at 10.5 m); list them" in line
    assert warned(caplog, new_case(tmp_path, name="whole")) == []


def test_check_says_what_it_cannot_tell(new_case, tmp_path, caplog):
    whole = (tmp_path / "bare").with_suffix(".toml")
    path = new_case(tmp_path, name="bare")
    text = path.read_text(encoding="utf-8")
    first, last = text.index("[[contacts]]"), text.index("# A floor that meets a wall")
    path.write_text(text[:first] + text[last:], encoding="utf-8")
    ((level, line),) = warned(caplog, whole)
    assert level == logging.INFO
    assert "without the plan of west and east: length and width of [[buildings]] give it" in line


@pytest.mark.usefixtures("no_figures")
def test_a_run_reports_an_overlap(new_case, tmp_path):
    path = new_case(tmp_path, *LISTED)
    result = study.run(path, out=tmp_path / "run", stage="pounding", bar=False)
    (text,) = (text for good, text in result.checks["pounding"] if "facing" in text and not good)
    with (tmp_path / "run/tables/facing_floors.csv").open(encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert (row["floor"], row["faces"]) == ("west.floor_3", "east.floor_3")
    assert float(row["distance at rest [mm]"]) == pytest.approx(20.0)
    nearest = float(row["smallest distance [mm]"])
    assert nearest < 0.0
    assert row["overlap"] == "yes"
    assert f"west.floor_3 and east.floor_3 overlap by {-nearest:.4g} mm at" in text
    values = {scalar.name: scalar.value for scalar in result.scalars}
    assert values["pounding.facing_distance_min"] == pytest.approx(1e-3 * nearest)
    checks = json.loads((tmp_path / "run/checks.json").read_text(encoding="utf-8"))
    assert {"stage": "pounding", "good": False, "text": text} in checks


def test_a_whole_case_says_nothing(finished):
    checks = json.loads((finished.folder / "checks.json").read_text(encoding="utf-8"))
    assert not [one for one in checks if "facing" in one["text"]]
    assert not (finished.folder / "tables/facing_floors.csv").exists()
