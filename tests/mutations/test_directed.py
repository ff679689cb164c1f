"""Bad inputs that someone thought of, each with what becomes of it: refused, warned or accepted.

An attack is a case that extends a good one, or a change of one of its files.
"""

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from impactfem.run.check import checked
from impactfem.system.errors import InputError
from impactfem.system.log import collected_warnings

from .mutation import outcome

Change = Callable[[Path], object]


@dataclass(frozen=True)
class Attack:
    """A bad input."""

    name: str  # what it is
    case: str  # the good case, relative to the folders of `good`
    text: str  # what a case says that extends it; or, with `old`, what takes the place of that
    words: str  # of a message that tells it
    verdict: str = "refused"  # or "warned", or "accepted"
    old: str = ""  # what is replaced
    file: str = ""  # where; the case when empty
    change: Change | None = None  # any other change of the folder
    mesh: bool = False  # whether the mesh is read


PAPER, FRAME, RECORD = "paper/npp_pair.toml", "frame/device.toml", "records/csv.toml"


def values(section, key, *pairs):
    """One key with several values, in an extension of the paper's case."""
    return [
        Attack(f"{section}.{key} = {value}", PAPER, f"[{section}]\n{key} = {value}\n", words)
        for value, words in pairs
    ]


def replaced(case, *triples, file=""):
    """Texts of a file, each replaced by another."""
    return [
        Attack(f"{file or case}: {old} -> {new[:60]}", case, new, words, old=old, file=file)
        for old, new, words in triples
    ]


# What a key or a table by itself refuses is in tests/case.
SIZES = [
    *values("pounding", "time_step", ('"1e-9 s"', "of memory"), ('"1 us"', "of memory")),
    *values("pounding", "time_step", ('"9 s"', "half of what is computed")),
    *values("pounding", "duration", ('"1e9 s"', "at most 100000 s"), ('"1 ms"', "at most")),
    *values("pounding", "points_per_impact", ("0", "at least 1"), ("1000000", "at most 100000")),
    *values("transient", "time_step", ('"1e-8 s"', "of memory"), ('"6 s"', "half of the duration")),
    *values("transient", "largest_basis", ("2000000", "at most 100000")),
    *values("wall_impact", "duration", ('"1 ms"', "less than")),
    *values("buildings.B1.structure", "modes", ("1000000", "at most 10000")),
    *values("buildings.B1.structure.mesh", "size", ('"2 cm"', "of memory")),
    *values("buildings.B1.structure.mesh", "length", ('"4.62 m"', "the plan")),
    *values("ensemble", "structure_motions", ("101", "all members, 100")),
    *values("spectra", "points_per_cycle", ("1", "at least 2"), ("1000000", "at most 1000")),
]
TYPES = [
    *values("buildings.B1.structure", "building", ('"B1"', "no key building")),
    *values("structure", "building", ('"B1"', "unknown table")),
    *values("buildings.B1.structure", "modes", ("true", "a whole number"), ("9" * 5000, "TOML")),
    *values("report", "reference", ('"none.toml"', "no such file"), ("1", "file name")),
    Attack("a section as a value", PAPER, "pounding = 3\n", "expected a table"),
    Attack("not TOML", PAPER, "[pounding\n", "not valid TOML"),
    Attack("nested 500 deep", PAPER, "a = " + "[" * 500 + "]" * 500, "too deeply"),
    Attack("extends itself", PAPER, 'extends = "attack.toml"\n', "does not extend this one"),
]
NAMES = [
    *replaced(
        PAPER,
        ('name = "B2"', 'name = "../B2"', "a name of letters"),
        ('name = "B2"', 'name = "B2\\u2028"', "a name of letters"),
        ('name = "damped" ', 'name = "OVER-damped" ', "upper and lower case alike"),
        ('name = "corner_far_east"', 'name = "CORNER_FAR_WEST"', "unique names"),
        ('title = "Two', f'title = "{"T" * 1001}', "at most 1000"),
        ("[materials.concrete]", '[materials."con\\ncrete"]', "visible characters"),
        ("[contact_laws.floor]", '[contact_laws."fl\\u001b[2Joor"]', "visible characters"),
        ('published = "npp_', 'published = "a\\nb', "a file name"),
    ),
    Attack("an unknown key with an escape", PAPER, '"\\u001b[31m" = 1\n', "unknown key"),
]
ANCHOR = 'point = ["23.1 m", "12.0 m", "30.3 m"]'
TOGETHER = [
    *replaced(
        PAPER,
        (ANCHOR, 'point = ["23.1 m", "12 m", "28 m"]', "no floor"),
        (ANCHOR, 'point = ["99 m", "12 m", "30.3 m"]', "outside"),
        ("iterations = 1 ", "iterations = 1000000000 ", "at most 10000"),
        ('time_step = "5 ms"', 'time_step = "1e-9 s"', "of memory"),
        ('time_step = "5 ms"', 'time_step = "7 ms"', "a whole number of at least 16"),
        ('damping = ["5 %"]\nfreq', 'damping = ["5 %"]\ndamping = ["5 %"]\nfreq', "TOML"),
        ("structure_motions = 12", 'structure_motions = 12\nrecords = "."', "either"),
    ),
    Attack(
        "forces beside members in 3D", PAPER, '[transient]\nforces = "npp_pair_floors.csv"\n', "0"
    ),
]
TABLES = [
    *replaced(PAPER, ("\n8,", "\n9,", "without a gap"), file="npp_pair_floors.csv"),
    *replaced(*(PAPER, ("\n", "\n\x1b[31m,1,0,0,1,1,0.2\n", "")), file="npp_building_walls.csv"),
    Attack(
        *("no wall in storey 1", PAPER, "", "no wall and no column stands in storey 1"),
        change=lambda f: _storeys(f / "npp_building_walls.csv"),
    ),
]


def _storeys(path):
    """Take storey 1 out of a wall table."""
    lines = path.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if ",1," not in line]
    path.write_text("\n".join(kept).replace(",1-8,", ",2-8,").replace(",1 ", ",") + "\n")


def _rows(path, count):
    """Repeat the last row of a table."""
    text = path.read_text(encoding="utf-8").rstrip("\n")
    path.write_text(text + ("\n" + text.rpartition("\n")[2]) * count + "\n", encoding="utf-8")


def _fifo(path):
    path.unlink(missing_ok=True)
    os.mkfifo(path)


def _chain(folder):
    for k in range(100):
        (folder / f"c{k}.toml").write_text(f'extends = "c{k + 1}.toml"\n')
    (folder / "c100.toml").write_text('extends = "npp_pair.toml"\n')


KEYS = "[pounding]\n" + "".join(f"unknown_{k} = 1\n" for k in range(4900))
MORE = "\n".join(f"a{k}=1" for k in range(200))
FLOORS, PUBLISHED = "npp_pair_floors.csv", "npp_pair_published.csv"
FILES = [
    ("a table that is a FIFO", PAPER, "ordinary file", lambda f: _fifo(f / FLOORS)),
    ("20,000 published rows", PAPER, "10000", lambda f: _rows(f / PUBLISHED, 20_000)),
    ("a chain of 100 cases", "paper/c0.toml", "at most 50 files", _chain),
    ("a FIFO as record", RECORD, "ordinary file", lambda f: _fifo(f / "record.csv")),
    ("a FIFO among records", "records/ensemble.toml", "3.csv", lambda f: _fifo(f / "many/3.csv")),
    ("a folder among records", "records/ensemble.toml", "old", lambda f: (f / "many/old").mkdir()),
    ("one record", "records/ensemble.toml", "two records", lambda f: (f / "many/1.csv").unlink()),
    ("a record of zeros", RECORD, "cannot be scaled", lambda f: _zeros(f / "record.csv")),
    ("a short record", RECORD, "", lambda f: _lines(f / "record.csv", 4)),
    ("forces that are too short", FRAME, "to be computed", lambda f: _short(f)),
    ("a force that is no pair", FRAME, "F.floor_9", lambda f: _head(f / "forces.csv", "F.floor_9")),
    ("forces without contacts", FRAME, "no contacts", lambda f: _no_contacts(f / "device.toml")),
]


def _zeros(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([lines[0], *(f"{0.01 * k},0" for k in range(400))]) + "\n")


def _lines(path, count):
    path.write_text("\n".join(path.read_text(encoding="utf-8").splitlines()[:count]) + "\n")


def _half(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _short(folder):
    case, forces = folder / "device.toml", folder / "forces.csv"
    text = case.read_text(encoding="utf-8")
    case.write_text(text.replace("[transient]\n", '[transient]\nduration = "2 s"\n'))
    _lines(forces, 52)


def _head(path, name):
    path.write_text(path.read_text(encoding="utf-8").replace("F.floor_1", name, 1))


def _no_contacts(path):
    text = path.read_text(encoding="utf-8")
    start = text.index("[[contacts]]")
    path.write_text(text[:start] + text[text.index("[transient]") :], encoding="utf-8")


MADE = [Attack(name, case, "", words, change=change) for name, case, words, change in FILES]
MADE += [
    Attack(
        *("a mesh that is a script", FRAME, "", "no $MeshFormat"),
        change=lambda f: (f / "frame.msh").write_text("Exit;"),
        mesh=True,
    ),
    Attack(
        *("half a mesh", FRAME, "", "frame.msh"), change=lambda f: _half(f / "frame.msh"), mesh=True
    ),
    Attack("4,900 unknown keys", PAPER, KEYS, "further faults"),
    Attack("6,000 keys", PAPER, f"{KEYS.replace('un', 'n')}[x]\n{MORE}", "5000"),
]
DAYS = """
[device_analysis]
time_step = "10 us"
[transient]
solver = "full"
time_step = "10 us"
[ensemble]
structure_motions = 0
"""
TWICE = '{ building = "B2", floor = [1, 2, '
ONCE = TWICE.replace("2, ", "1, ")
LONG = '[pounding]\ntime_step = "5 s"\n'
TAKEN = [
    Attack("a long step", PAPER, LONG, "at least 16 are required", "refused"),
    Attack("a long step, allowed", PAPER, f'allow = ["steps"]\n{LONG}', "at least 16", "warned"),
    Attack(*("one floor in two pairs", PAPER, ONCE, "at one level", "refused"), old=TWICE),
    Attack("letters of other languages", PAPER, 'title = "Bâtiments α 梁"\n', "", "accepted"),
    Attack("64 letters", PAPER, f'name = "{"B" * 64}"', "unknown building", old='name = "B2"'),
    Attack(*("days of steps", PAPER, DAYS, "a run of this case takes about", "warned")),
]
ATTACKS = [*SIZES, *TYPES, *NAMES, *TOGETHER, *TABLES, *MADE, *TAKEN]


def verdict_of(attack, folder):
    """What becomes of an attack in the folder of its good case, which is changed; what is said."""
    case = folder / Path(attack.case).name
    if attack.change is not None:
        attack.change(folder)
    elif attack.old:
        path = folder / attack.file if attack.file else case
        text = path.read_text(encoding="utf-8")
        assert attack.old in text, f"{attack.old!r} is not in {path.name}: nothing is attacked"
        path.write_text(text.replace(attack.old, attack.text), encoding="utf-8")
    elif attack.text:
        name, case = case.name, folder / "attack.toml"
        extends = "" if attack.text.startswith("extends") else f'extends = "{name}"\n'
        case.write_text(extends + attack.text, encoding="utf-8")
    said = []

    def check():
        try:
            checked(case, mesh=attack.mesh)
        except InputError as error:
            said.extend(map(str, error.faults))
            raise

    with collected_warnings("progress") as warnings:
        found = outcome(check, folder, InputError)
    warned = sorted(line for line in warnings if line.startswith("warning: "))
    verdict = "warned" if found == "good" and warned else {"good": "accepted"}.get(found, found)
    return verdict, "\n".join([*said, *warned])


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name[:70])
def test_an_attack(attack, good, tmp_path):
    folder = tmp_path / "attacked"
    shutil.copytree(good / Path(attack.case).parent, folder)
    verdict, said = verdict_of(attack, folder)
    assert (verdict, attack.words in said) == (attack.verdict, True), f"{verdict}: {said[:600]}"


def test_each_attack_is_another():
    assert len({attack.name for attack in ATTACKS}) == len(ATTACKS) >= 60
