"""The invalid inputs of a first user: what `check` names, by key and kind."""

import re
from typing import get_args

import pytest

from impactfem import study
from impactfem.case.model import Condition
from impactfem.case.template import write_new_case
from impactfem.run.check import checked
from impactfem.system.errors import InputError

STOREYS = "stiffness_factor = 0.5 "
SECOND = 'name = "east"'
RECORD = '[[motions]]\ndirection = "y"\ntype = "record"\nfile = "{}"\n'
SYNTHETIC = re.compile(r'(?s)\[\[motions\]\]\ndirection = "y".*?(?=# In place of that table)')
ROWS = [
    ("restitution = 0.65", "restituton = 0.65", "contact_laws.floor.restituton", "extra_forbidden"),
    ("[[motions]]", "[[motion]]", "motion", "extra_forbidden"),
    ('b = { building = "east", floor = [1, 2, 3]', 'b = { building = "east", floor = [2, 3, 1]',
     "contacts[0]", "of_alignment"),
    (', offset = ["0 m", "6 m", "0 m"] }', " }", "contacts[0].gap", "of_contacts"),
    ('young_modulus = "30 GPa"', 'young_modulus = "0.3 GPa"', "buildings[0].floors", "period"),
    ('axis = ["10 m", "18.02 m"]', 'axis = ["10 m", "6 m"]', "buildings[1].axis", "overlap"),
    ('gap = "2 cm"', 'gap = "0 cm"', "contacts[0].gap", "of_contacts"),
    ('time_step = "0.25 ms"', 'time_step = "25 ms"', "pounding.time_step", "steps"),
    ('[[motions]]\ndirection = "y"', '[[motions]]\ndirection = "x"', "motions[0].direction",
     "direction"),
    ('gap = "2 cm"', 'gap = "20 m"', "contacts[0].gap", "of_contacts"),
    ('[damping]\nratio = "5 %"', '[damping]\nratio = "5 rad/s"', "damping.ratio", "quantity"),
    ('b = { building = "east", floor = [1, 2, 3]', 'b = { building = "east", floor = [1, 2]',
     "contacts[0].b", "pairs"),
    ('type = "hunt-crossley"', 'type = "hunt crossley"', "contact_laws.floor.type",
     "union_tag_invalid"),
    ('young_modulus = "30 GPa"', 'young_modulus = "-30 GPa"', "materials.concrete.young_modulus",
     "greater_than"),
    ('frequencies = ["1 Hz", "20 Hz"]', 'frequencies = ["1 rad/s", "20 Hz"]',
     "damping.frequencies[0]", "unit"),
    ('gap = "2 cm"', 'gap = "2 cm', "line", "toml"),
    ("[pounding]", '[damping]\nratio = "2 %"\n[pounding]', "line", "toml"),
    ('gap = "2 cm"', "gap = 2", "contacts[0].gap", "unit_missing"),
    ('gap = "2 cm"', 'gap = "2,5 cm"', "contacts[0].gap", "decimal_comma"),
    ('floor = [1, 2, 3], offset = ["0 m", "6 m"', 'floor = [1, 2, 4], offset = ["0 m", "6 m"',
     "contacts[0].a.floor", "no_floor"),
    ("normal = [0, 1, 0]", "normal = [0, -1, 0]", "contacts[0].normal", "of_contacts"),
    (STOREYS, f'periods = {{ x = "1 s" }}\n{STOREYS}', "buildings[0].stiffness_factor",
     "scaled_once"),
    ('"@_floors.csv"', '"absent.csv"', "buildings[0].floors", "unreadable"),
    ('law = "floor"', 'law = "flor"', "contacts[0].law", "unknown_name"),
]  # fmt: skip
HEAVY = "buildings.west.structure.floor_masses"
SIDES = r"width_x \[m\],width_y \[m\]"
#: Cases with a 3D model: end of the name of a file, changes by regular expressions, key and kind.
MODELS = [
    ("_columns.csv", [(SIDES, "profile"), (",0.32,0.32", ",HEB 300")], "line 2, column profile",
     "column"),
    ("_columns.csv", [(SIDES, "section"), (",0.32,0.32", ",HEB 300"), ("HEB 300", "HEB 301")],
     "line 3, column section", "unknown_name"),
    ("_floors.csv", [("\n1,240,", "\n1,50,")], HEAVY, ""),
    (".toml", [('slab_thickness = "25 cm"', 'slab_thickness = "25 m"')], HEAVY, ""),
]  # fmt: skip
WARNED = [
    ('frequencies = { minimum = "0.5 Hz", maximum = "200 Hz", per_decade = 50 }',
     'frequencies = ["1 Hz"]', "spectra.frequencies"),
]  # fmt: skip
RECORDS = [
    ("r.VT2", "PEER\n", "motions[0].format"),
    ("r.txt", "0 0.1\n0.01 0.2\n", ""),
    ("r.csv", "time,acceleration\n0,0.1\n0.01,0.2\n", "line 1"),
    ("r.AT2", "PEER\nEVENT\nUNITS OF CM\nNPTS= 2, DT= .01 SEC\n 0.1 0.2\n", "line 3"),
]


@pytest.fixture
def case(tmp_path):
    return write_new_case(tmp_path / "new")[0]


def faults(path):
    with pytest.raises(InputError) as error:
        checked(path)
    return error.value.faults


@pytest.mark.parametrize(("old", "new", "key", "kind"), ROWS)
def test_one_fault_names_the_key(case, old, new, key, kind):
    """One message for one error, none of its consequences."""
    text = case.read_text(encoding="utf-8")
    old = old.replace("@", case.stem)
    assert old in text
    case.write_text(text.replace(old, new, 1), encoding="utf-8")
    found = faults(case)
    assert {fault.kind for fault in found} == {kind}
    assert found[0].key.startswith(key) and len({fault.key for fault in found}) <= 2


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The text of the files of a case with a 3D model of few elements and a device."""
    path = write_new_case(tmp_path_factory.mktemp("model") / "new", ["devices"])[0]
    texts = {one.name[3:]: one.read_text(encoding="utf-8") for one in path.parent.iterdir()}
    texts[".toml"], count = re.subn(r'(?m)^size = "0.9 m"', 'size = "2.5 m"', texts[".toml"])
    assert count == 1
    return texts


def written(model, folder, ending, changes):
    """The case file with changes of one of its files, each made once or, from the second, often."""
    text = model[ending]
    for k, (old, new) in enumerate(changes):
        text, count = re.subn(old, new, text, count=int(old == "HEB 300"))
        assert count == 1 or k
    for name, content in {**model, ending: text}.items():
        (folder / f"new{name}").write_text(content, encoding="utf-8")
    return folder / "new.toml"


@pytest.mark.parametrize(("ending", "changes", "key", "kind"), MODELS)
def test_one_fault_of_a_3d_model(model, tmp_path, ending, changes, key, kind):
    """Heavy floors are one fault, not one for each; a column in the header, not in each row."""
    with pytest.raises(InputError) as error:
        checked(written(model, tmp_path, ending, changes), mesh=True)
    assert [(fault.key, fault.kind) for fault in error.value.faults] == [(key, kind)]


def test_the_radius_to_type_reaches_a_node(model, tmp_path):
    def case(radius):
        change = 'radius = "1 m"', f'radius = "{radius} cm"'
        return written(model, tmp_path, ".toml", [change])

    with pytest.raises(InputError) as error:
        checked(case(5), mesh=True)
    (fault,) = error.value.faults
    assert fault.key == "devices[0].point"
    checked(case(re.search(r"at least (\d+) cm", fault.expected)[1]), mesh=True)


@pytest.mark.parametrize(("old", "new", "key"), WARNED)
def test_a_warning_names_the_key(case, caplog, old, new, key):
    text = case.read_text(encoding="utf-8")
    for changed, count in ((text, 0), (text.replace(old, new, 1), 1)):
        case.write_text(changed, encoding="utf-8")
        caplog.clear()
        checked(case, mesh=True)
        assert len([one for one in caplog.messages if f": {key}: " in one]) == count


def test_texts_as_paths(case, monkeypatch):
    monkeypatch.chdir(case.parent)
    assert study.check(case.name).title == study.check(case).title
    with pytest.raises(InputError) as error:
        study.check("absent.toml")
    assert str(error.value.faults[0].file) == "absent.toml"


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [(old, new, kind) for old, new, _, kind in ROWS if kind in get_args(Condition)],
)
def test_a_condition_is_allowed_by_name(case, old, new, kind):
    text = case.read_text(encoding="utf-8").replace(old, new, 1)
    case.write_text(f'allow = ["{kind}"]\n{text}', encoding="utf-8")
    assert checked(case)[0].allow == (kind,)
    other = next(one for one in get_args(Condition) if one != kind)
    case.write_text(f'allow = ["{other}"]\n{text}', encoding="utf-8")
    (fault,) = {fault.kind: fault for fault in faults(case)}.values()
    assert fault.kind == kind and f'"{kind}"]' in fault.expected


def test_a_stick_stiffer_than_its_3d_model(tmp_path):
    """Storeys of 10 GN/mm beside walls and columns of concrete."""
    path = write_new_case(tmp_path / "new", ["structure"])[0]
    table = ["floor,mass [t],kx [kN/mm],ky [kN/mm],storey_height [m]"]
    table += [f"{k},400,90000,90000,3.5" for k in (1, 2, 3)]
    (tmp_path / "new_floors.csv").write_text("\n".join(table), encoding="utf-8")
    text = path.read_text(encoding="utf-8")
    text = text.replace("storey_stiffness_factor = 0.5", "", 1)
    text = text.replace('name = "west"', 'name = "west"\nstick = "own"', 1)
    path.write_text(f'allow = ["period"]\n{text}', encoding="utf-8")
    assert [(one.key, one.kind) for one in faults(path)] == [("buildings[0].floors", "stick")]


@pytest.mark.parametrize(("name", "content", "key"), RECORDS)
def test_a_record_that_is_none(case, name, content, key):
    text = SYNTHETIC.sub(RECORD.format(name), case.read_text(encoding="utf-8"), count=1)
    case.write_text(text, encoding="utf-8")
    (case.parent / name).write_text(content, encoding="utf-8")
    assert any(fault.key.startswith(key) for fault in faults(case))


@pytest.mark.parametrize(
    ("words", "codes"),
    [
        (("check", "@_floors.csv"), 2),
        (("sweep", "@.toml"), 2),
        (("verify", "--only", "nonsense"), 2),
        (("explian",), 2),
        (("sweep", "@.toml", "--set", "damping.ration=0.05"), 2),
        (("run", "@.toml", "--out", "@_floors.csv/x"), 2),
    ],
)
def test_commands(program, case, monkeypatch, words, codes):
    monkeypatch.chdir(case.parent)
    ended = program(*(word.replace("@", case.stem) for word in words))
    assert ended.code == codes and "Traceback" not in ended.err
    assert ended.err.count("\n") <= 3


def test_the_three_outcomes(program, case, monkeypatch):
    """Valid; valid with warnings, which --strict does not accept; invalid, unless allowed."""
    monkeypatch.chdir(case.parent)
    file, text = case.name, case.read_text(encoding="utf-8")
    plain = program("check", file, "--strict")
    assert (plain.code, plain.out.splitlines()[-1]) == (0, f"{file}: valid")
    coarse = text.replace('time_step = "0.25 ms"', 'time_step = "25 ms"')
    case.write_text(coarse, encoding="utf-8")
    refused = program("check", file)
    assert (refused.code, refused.err.splitlines()[-1]) == (2, f"{file}: invalid, 1 error")
    case.write_text(f'allow = "steps"\n{coarse}', encoding="utf-8")
    for option, code in ((), 0), (("--strict",), 3):
        allowed = program("check", file, *option)
        assert allowed.code == code
        assert re.fullmatch(rf"{file}: valid, \d+ warnings?", allowed.out.splitlines()[-1])
