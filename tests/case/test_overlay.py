"""Case files that extend another one and change some of its values."""

import math
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from impactfem.case import load_case
from impactfem.case.model import CaseFile
from impactfem.case.overlay import as_toml, overlay_text
from impactfem.case.place import Place
from impactfem.case.source import read_source
from impactfem.system.errors import InputError

DATA = Path(__file__).parent / "data"


@pytest.fixture
def base(tmp_path: Path) -> Path:
    """The case in a folder of its own."""
    (tmp_path / "base").mkdir()
    for source in DATA.glob("pair*"):
        shutil.copy(source, tmp_path / "base")
    return tmp_path / "base" / "pair.toml"


def overlay(base: Path, changes: dict[Place, Any], folder: Path) -> Path:
    text = overlay_text(read_source(base, CaseFile), changes, folder, CaseFile)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "over.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_key_outside_lists_is_all_that_is_said(base: Path, tmp_path: Path) -> None:
    path = overlay(base, {("damping", "ratio"): "3 %"}, tmp_path / "a" / "b")
    assert tomllib.loads(path.read_text()) == {
        "extends": "../../base/pair.toml",
        "damping": {"ratio": "3 %"},
    }
    case, before = load_case(path), load_case(base)
    assert case.damping.ratio == 0.03 and before.damping.ratio != 0.03
    assert case.contacts == before.contacts


def test_a_list_is_written_as_a_whole(base: Path, tmp_path: Path) -> None:
    """Its files are found from the new folder, and the other entries are as they were."""
    changes: dict[Place, Any] = {
        ("buildings", 1, "stiffness_factor"): 0.25,
        ("buildings", 0, "rigid_below"): "7 cm",
    }
    case, before = load_case(overlay(base, changes, tmp_path / "c")), load_case(base)
    assert [b.stiffness_factor for b in case.buildings][1] == 0.25
    assert case.buildings[0].rigid_below == 0.07
    changed = before.buildings[0].model_copy(update={"rigid_below": 0.07})
    first = case.buildings[0]
    assert first == changed.model_copy(update={"damping": first.damping})


def test_names_of_files_are_those_of_the_case(base: Path, tmp_path: Path) -> None:
    shutil.copy(base.with_name("pair_floors.csv"), base.with_name("other.csv"))
    for name in ("other.csv", str(base.with_name("other.csv"))):
        path = overlay(base, {("buildings", 0, "floors"): name}, tmp_path / "d")
        assert load_case(path).buildings[0].floors == load_case(base).buildings[0].floors
    path = overlay(base, {("buildings", 0, "floors"): "absent.csv"}, tmp_path / "d")
    with pytest.raises(InputError, match=r"absent\.csv.*no such file"):
        load_case(path)


def test_the_case_itself_is_not_changed(base: Path, tmp_path: Path) -> None:
    source = read_source(base, CaseFile)
    before = repr(source.raw)
    overlay_text(source, {("buildings", 0, "rigid_below"): "9 m"}, tmp_path, CaseFile)
    assert repr(source.raw) == before


@pytest.mark.parametrize(
    "value",
    [
        'a "quoted" text\\with\nlines\tand \x7f é',
        True,
        7,
        1e-05,
        1e22,
        -0.5,
        ["1 cm", "2 cm"],
        [],
        {},
        {"a key": [1, {"b": False}], "c": {"d": "é"}},
        [{"a": 1}, {"b": [[1], [2]]}],
    ],
)
def test_values_come_back(value: Any) -> None:
    for rows in (False, True):
        assert tomllib.loads(f"v = {as_toml(value, rows=rows)}")["v"] == value


def test_nan_comes_back() -> None:
    assert math.isnan(tomllib.loads(f"v = {as_toml(math.nan)}")["v"])
