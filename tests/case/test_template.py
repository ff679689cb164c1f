import re
import tomllib
from pathlib import Path

import pytest

from docs._ext.case_reference import json_schema
from impactfem.case import load_case
from impactfem.case.motions import RecordMotion
from impactfem.case.plausibility import implausible
from impactfem.case.template import EXCLUSIVE, PARTS, write_new_case
from impactfem.system.errors import InputError

TARGETS = "building,mode,frequency [Hz],effective_mass [t]\nwest,1,2.2,500\neast,1,1.5,500\n"
RECORD = "time [s],acceleration [m/s2]\n0,0\n1,1\n"
EQUIPMENT = """\
tag,building,floor,x [m],y [m],mass [kg],mass_height [m]
MCC-1,west,1,0,0,600,1
"""
PUBLISHED = "name,value,unit,source\nmotion.pga,3,m/s2,here\n"
TOGETHER = [
    tuple(part for part in PARTS if part not in without)
    for without in ({"steel_frame", "record"}, {"calibration", "ensemble", "design"})
]
# A key for the other of two ways.
OTHER_WAY = "not both|together|Cannot overwrite|a key of type"


@pytest.fixture
def template(tmp_path):
    path = write_new_case(tmp_path / "new")[0]
    (tmp_path / "new_targets.csv").write_text(TARGETS)
    (tmp_path / "new_record.csv").write_text(RECORD)
    (tmp_path / "new_published.csv").write_text(PUBLISHED)
    (tmp_path / "new_equipment.csv").write_text(EQUIPMENT)
    return path


def test_new_case_is_accepted(tmp_path):
    paths = write_new_case(tmp_path / "my-case.v2")
    assert [path.name for path in paths] == ["my-case.v2.toml", "my-case.v2_floors.csv"]
    case = load_case(paths[0])
    assert [building.name for building in case.buildings] == ["west", "east"]
    assert len(case.contacts) == 3
    assert all("@" not in path.read_text(encoding="utf-8") for path in paths)


@pytest.mark.parametrize("minimal", [False, True])
@pytest.mark.parametrize("parts", [(), *((part,) for part in PARTS), *TOGETHER], ids="-".join)
def test_parts_are_good_together(tmp_path, parts, minimal):
    paths = write_new_case(tmp_path / "new", parts, minimal=minimal)
    case = load_case(paths[0])
    assert [str(one) for one in implausible(case, 10.0)] == []
    has = {
        "structure": case.structure,
        "steel_frame": case.structure is not None and case.structure.materials,
        "calibration": case.calibration,
        "wall_impact": case.wall_impact,
        "transient": case.transient,
        "devices": case.devices,
        "damping_cases": case.damping_cases,
        "loads": case.loads,
        "ensemble": case.ensemble,
        "design": case.ensemble is not None and case.ensemble.structure_motions,
        "equipment": case.equipment,
        "contact_search": case.contact_search,
        "record": isinstance(case.motions[0], RecordMotion),
    }
    needed = set(parts)
    while more := {need for part in needed for need in PARTS[part].needs} - needed:
        needed |= more
    assert {part for part, content in has.items() if content} == needed
    texts = [path.read_text(encoding="utf-8") for path in paths]
    assert not minimal or not any(re.search(r"(?m)^#|  # |\n\n\n|\A\n", text) for text in texts)
    assert not any("@" in text for text in texts)


def test_unknown_parts(tmp_path):
    with pytest.raises(InputError) as caught:
        write_new_case(tmp_path / "new", ["structre", "roof"])
    assert "you mean 'structure'?" in str(caught.value)
    assert "known: structure, calibration" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("both", [sorted(both) for both, _ in EXCLUSIVE], ids="-".join)
def test_exclusive_parts(tmp_path, both):
    with pytest.raises(InputError) as caught:
        write_new_case(tmp_path / "new", tuple(both))
    (fault,) = caught.value.faults
    assert fault.value == ",".join(sorted(both))
    assert list(tmp_path.iterdir()) == []


def test_a_part_that_needs_an_exclusive_one(tmp_path):
    """`design` needs `ensemble`, which excludes a record."""
    with pytest.raises(InputError, match="ensemble,record"):
        write_new_case(tmp_path / "new", ("design", "record"))


def test_the_contact_search_finds_the_pairs_of_the_table(tmp_path):
    pairs = []
    for name, parts in (("listed", ()), ("searched", ("contact_search",))):
        case = load_case(write_new_case(tmp_path / name, parts)[0])
        pairs.append({(pair.a.floor, pair.b.floor, pair.gap) for pair in case.contacts})
    assert pairs[0] == pairs[1] == {(k, k, 0.02) for k in (1, 2, 3)}


@pytest.mark.parametrize("target", ["", "new.toml"])
def test_folder_or_file_name(tmp_path, target):
    names = [path.name for path in write_new_case(tmp_path / target)]
    stem = target.removesuffix(".toml") or "case"
    assert names == [f"{stem}.toml", f"{stem}_floors.csv"]


def test_every_key_is_in_the_template(template):
    text = template.read_text(encoding="utf-8")
    schema = json_schema()
    for table in (schema, *schema["$defs"].values()):
        for key in table["properties"]:
            assert re.search(rf"\b{key}\b", text), key


def test_every_optional_key_may_be_used(template):
    text = template.read_text(encoding="utf-8")
    lines = text.splitlines()
    # Of the blocks behind a '#', which are tested below, only the lines outside of them count.
    blocks = [i for i, line in enumerate(lines) if re.match(r"# \[", line)]
    inside = {j for i in blocks for j in range(i, _end_of_block(lines, i))}
    optional = [i for i, line in enumerate(lines)
                if re.match(r"# [a-z_]+ = ", line) and i not in inside]  # fmt: skip
    assert len(optional) > 12
    for index in optional:
        changed = [*lines]
        changed[index] = changed[index].removeprefix("# ")
        template.write_text("\n".join(changed), encoding="utf-8")
        try:
            load_case(template)
        except InputError as error:
            assert re.search(OTHER_WAY, str(error)), str(error)


def _end_of_block(lines, begin):
    end = begin
    while end < len(lines) and lines[end].startswith("# "):
        end += 1
    return end


def test_nothing_is_overwritten(tmp_path):
    floors = tmp_path / "new_floors.csv"
    floors.write_text("mine")
    with pytest.raises(InputError, match="file exists already"):
        write_new_case(tmp_path / "new")
    assert floors.read_text() == "mine"
    assert not (tmp_path / "new.toml").exists()


@pytest.mark.parametrize("name", ['a"b', "a b", "-x", ".toml", ".hidden"])
def test_name_refused(tmp_path, name):
    with pytest.raises(InputError, match="name of letters,"):
        write_new_case(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_folder_missing(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        write_new_case(tmp_path / "none" / "new")


def test_nothing_half_written(tmp_path, monkeypatch):
    opened = Path.open

    def full(self, *args, **options):
        if self.suffix == ".csv" and args == ("x",):
            raise OSError(28, "No space left on device")
        return opened(self, *args, **options)

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(InputError, match=r"\(No space left"):
        write_new_case(tmp_path / "new")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("parts", [(), ("structure", "devices"), ("ensemble",)])
def test_a_short_case_has_the_keys_of_a_minimal_one(tmp_path, parts):
    """With comments, and without parts within 80 lines."""
    texts = []
    for kind in ("short", "minimal"):
        (tmp_path / kind).mkdir()
        path = write_new_case(tmp_path / kind / "new", parts, **{kind: True})[0]
        load_case(path)
        texts.append(path.read_text(encoding="utf-8"))
    short, minimal = texts
    assert tomllib.loads(short) == tomllib.loads(minimal)
    assert short.count("  # ") > 15 and not re.search(r"(?m)^# [a-z_]+ = ", short)
    assert parts or len(short.splitlines()) <= 80
