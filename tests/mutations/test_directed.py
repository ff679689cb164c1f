"""Bad inputs that someone thought of, each with what becomes of it: refused, warned or accepted.

An attack is a case that extends a good one, or a change of one of its files.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from impactfem.run.check import checked
from impactfem.system.errors import InputError
from impactfem.system.log import in_file_only

from .outcome import outcome

Change = Callable[[Path], object]


@dataclass(frozen=True)
class Attack:
    """A bad input.

    Args:
        name: What it is.
        case: The good case, relative to the folders of `good`.
        text: What a case says that extends it; or, with `old`, what takes the place of that.
        words: Words of a message that tells it.
        verdict: "refused", "warned" or "accepted".
        old: What is replaced.
        file: Where; the case when empty.
        change: Any other change of the folder.
        mesh: Whether the mesh is read.
    """

    name: str
    case: str
    text: str
    words: str
    verdict: str = "refused"
    old: str = ""
    file: str = ""
    change: Change | None = None
    mesh: bool = False


PAPER, FRAME, RECORD = "paper/npp_pair.toml", "frame/device.toml", "records/csv.toml"


def values(section: str, key: str, *pairs: tuple[str, str]) -> list[Attack]:
    """One key with several values, in an extension of the paper's case."""
    return [
        Attack(f"{section}.{key} = {value}", PAPER, f"[{section}]\n{key} = {value}\n", words)
        for value, words in pairs
    ]


def replaced(case: str, *triples: tuple[str, str, str], file: str = "") -> list[Attack]:
    """Texts of a file, each replaced by another."""
    return [
        Attack(f"{file or case}: {old} -> {new[:60]}", case, new, words, old=old, file=file)
        for old, new, words in triples
    ]


SIZES = [
    *values(
        *("pounding", "time_step"),
        ('"1e-9 s"', "of memory"),
        ('"1e-30 s"', "at least 1e-09 s"),
        ('"1 us"', "of memory"),
        ('"9 s"', "half of what is computed"),
        ('"0 s"', "at least 1e-09 s"),
        ('"-1 ms"', "at least 1e-09 s"),
    ),
    *values(
        *("pounding", "duration"),
        ('"1e9 s"', "at most 100000 s"),
        ('"0 s"', "above 0"),
        ('"1 ms"', "at most"),
    ),
    *values("pounding", "points_per_impact", ("0", "at least 1"), ("1000000", "at most 100000")),
    *values(
        *("transient", "time_step"),
        ('"1e-12 s"', "at least 1e-09 s"),
        ('"1e-8 s"', "of memory"),
        ('"6 s"', "half of the duration"),
    ),
    *values(
        "transient", "duration", ('"1e9 s"', "at most 100000 s"), ('"20 s"', "sticks, 16.79 s")
    ),
    *values("transient", "largest_basis", ("0", "at least 1"), ("2000000", "at most 100000")),
    *values(
        "transient",
        "maximum_frequency",
        ('"0 Hz"', "above 0"),
        ('"1 rad/s"', "no unit for"),
    ),
    *values("transient", "tolerance", ("0", "above 0"), ("1", "below 1"), ("nan", "a number")),
    *values("transient", "eccentricity", ('"30 m"', "within the edge"), ("1", "unit")),
    *values("transient", "field_frequencies", ('["2 Hz", "1 Hz"]', "increasing")),
    *values("wall_impact", "time_step", ('"1e-12 s"', "at least 1e-09 s"), ('"1 s"', "half")),
    *values("wall_impact", "duration", ('"1e9 s"', "at most 100000 s"), ('"1 ms"', "less than")),
    *values("wall_impact", "floors", ("[6, 9]", "no floor 9"), ("[]", "empty"), ("[6, 6]", "once")),
    *values("wall_impact", "displaced_floor", ("0", "at least 1"), ("9", "no floor 9")),
    *values("wall_impact", "displacement", ('"0 m"', "not zero"), ('"2 cm"', "less than the gap")),
    *values("wall_impact", "theta", ("0.4", "at least 0.5"), ("1.1", "at most 1")),
    *values("buildings.B1.structure", "modes", ("0", "at least 1"), ("1000000", "at most 10000")),
    *values(
        "buildings.B1.structure.mesh",
        "size",
        ('"1 um"', "at least 0.01 m"),
        ('"2 cm"', "of memory"),
    ),
    *values(
        "buildings.B1.structure.mesh",
        "floor_size",
        ('"1 mm"', "at least 0.01 m"),
        ('"-1 m"', "at least"),
    ),
    *values(
        "buildings.B1.structure.mesh",
        "length",
        ('"46200 m"', "at most 2000 m"),
        ('"4.62 m"', "the plan"),
    ),
    *values("calibration", "starts", ("0", "at least 1"), ("1000000000", "at most 1000")),
    *values("calibration", "height", ('"60 m"', "the storeys"), ('"3 kg"', "length")),
    *values("calibration", "stiffness_factor", ("[1.0, 0.02]", "in order"), ("[1]", "2 values")),
    *values("ensemble", "motions", ("1", "at least 2"), ("1000000000", "at most 100000")),
    *values("ensemble", "structure_motions", ("1", "at least 2"), ("101", "all members, 100")),
    *values("ensemble", "first_seed", ("-1", "at least 0"), ("2147483648", "at most")),
    *values("device_analysis", "time_step", ('"1e-12 s"', "at least 1e-09"), ('"2 ms"', "at most")),
    *values("device_analysis", "combination", ("[]", "not empty"), ('["sum"]', "'abs' or 'srss'")),
    *values("spectra", "points_per_cycle", ("1", "at least 2"), ("1000000", "at most 1000")),
    *values("spectra", "damping", ("[]", "not empty"), ('["100 %"]', "below 1"), ('"5 %"', "list")),
    *values("spectra.frequencies", "per_decade", ("0", "at least 1"), ("1000000", "100000")),
    *values("spectra.frequencies", "maximum", ('"0.1 Hz"', "above minimum"), ('"nan Hz"', "freq")),
]
TYPES = [
    *values("pounding", "update", ('"explicit"', "'implicit' or 'lagged'"), ("1", "'implicit'")),
    *values("transient", "solver", ('"fast"', "'reduced' or"), ("[]", "'reduced' or")),
    *values("transient", "export", ('"yes"', "true or false"), ("1", "true or false")),
    *values("transient", "fields", ('["pfa", "pfa"]', "once"), ('"pfa"', "a list")),
    *values("buildings.B1.structure", "building", ('"B1"', "no key building")),
    *values("structure", "building", ('"B1"', "moved; expected [buildings.structure]")),
    *values("buildings.B2.structure", "mesh", ("1", "one building with a 3D model")),
    *values(
        "buildings.B1.structure",
        "calibration",
        ('{ frequency = "1 s" }', "a time"),
        ("1", "a table"),
    ),
    *values("buildings.B1.structure.mesh", "impact_edge", ('"z+"', "'x-' or"), ("1", "'x-' or")),
    *values("materials.concrete", "poisson_ratio", ("0.5", "below"), ("nan", "number")),
    *values("materials.concrete", "young_modulus", ('"33 GPA"', "stress"), ('"0 Pa"', "above 0")),
    *values("materials.concrete", "density", ('"-1 kg/m3"', "above 0"), ("2400", "unit")),
    *values("damping", "ratio", ("-0.1", "above 0"), ('"5 % of critical"', "percentage")),
    *values("damping", "frequencies", ('["20 Hz", "1 Hz"]', "lower one first"), ('["1 Hz"]', "2")),
    *values("damping", "mass_coefficient", ('"1 1/s"', "either")),
    *values("contact_laws.floor", "stiffness", ('"1e11 N"', "stiffness"), ('"inf N/m"', "stiff")),
    *values("contact_laws.floor", "damping_ratio", ("1", "below 1"), ('"a"', "number")),
    *values("contact_laws.floor", "type", ('"spring"', "'kelvin-voigt' or"), ("1", "'kelvin-")),
    *values("contact_laws.floor", "restitution", ("0.5", "not both")),
    *values("report", "reference", ('"none.toml"', "no such file"), ("1", "file name")),
    Attack("a section as a value", PAPER, "pounding = 3\n", "expected a table"),
    Attack("a list as a table", PAPER, "[contacts]\ngap = 1\n", "one or more tables"),
    Attack("no section", PAPER, "extends_ = 1\n", "unknown key"),
    Attack("the title as a number", PAPER, "title = 1\n", "a text"),
    Attack("a date", PAPER, "[pounding]\ntime_step = 1979-05-27\n", "a time"),
    Attack(
        "a truth value for a number",
        PAPER,
        "[buildings.B1.structure]\nmodes = true\n",
        "a whole number",
    ),
    Attack("not TOML", PAPER, "[pounding\n", "not valid TOML"),
    Attack("nested 500 deep", PAPER, "a = " + "[" * 500 + "]" * 500, "too deeply"),
    Attack(
        "a number of 5,000 digits",
        PAPER,
        f"[buildings.B1.structure]\nmodes = {'9' * 5000}\n",
        "TOML",
    ),
    Attack("extends itself", PAPER, 'extends = "attack.toml"\n', "does not extend this one"),
]
NAMES = [
    *replaced(
        PAPER,
        ('name = "B2"', 'name = "b1"', "upper and lower case alike"),
        ('name = "B2"', 'name = "B1"', "duplicate name"),
        ('name = "B2"', 'name = "CON"', "reserves"),
        ('name = "B2"', f'name = "{"B" * 300}"', "at most 64"),
        ('name = "B2"', 'name = "B 2"', "a name of letters"),
        ('name = "B2"', 'name = "../B2"', "a name of letters"),
        ('name = "B2"', 'name = "B2\\u2028"', "a name of letters"),
        ('name = "pump"', f'name = "{"p" * 300}"', "at most 64"),
        ('name = "pump"', 'name = "nul"', "reserves"),
        ('name = "damped" ', 'name = "OVER-damped" ', "upper and lower case alike"),
        ('name = "damped" ', 'name = "own" ', "another name"),
        ('name = "corner_far_east"', 'name = "line_1"', "always there"),
        ('name = "corner_far_east"', 'name = "CORNER_FAR_WEST"', "unique names"),
        ('title = "Two', 'title = "Two\\n', "one line without control"),
        ('title = "Two', 'title = "Two\\u0085', "one line without control"),
        ('title = "Two', 'title = "\\u001b[31mTwo', "one line without control"),
        ('title = "Two', 'title = "\\u202eTwo', "one line without control"),
        ('title = "Two', f'title = "{"T" * 1001}', "at most 1000"),
        ("[materials.concrete]", f'[materials."{"c" * 65}"]', "at most 64"),
        ("[materials.concrete]", '[materials."con\\ncrete"]', "visible characters"),
        ("[contact_laws.floor]", '[contact_laws."fl\\u001b[2Joor"]', "visible characters"),
        ('published = "npp_', 'published = "a\\nb', "a file name"),
        ('published = "npp_', 'published = "\\u0000', "a file name"),
        ('law = "floor"', 'law = "flor"', "did you mean 'floor'"),
    ),
    Attack("an unknown key with an escape", PAPER, '"\\u001b[31m" = 1\n', "unknown key"),
]
TOGETHER = [
    *replaced(
        PAPER,
        (
            'point = ["23.1 m", "12.0 m", "30.3 m"]',
            'point = ["23.1 m", "12 m", "28 m"]',
            "no floor",
        ),
        ('point = ["23.1 m", "12.0 m", "30.3 m"]', 'point = ["99 m", "12 m", "30.3 m"]', "outside"),
        ('radius = "0.5 m"', 'radius = "-1 m"', "above 0"),
        ('mass = "1500 kg"', 'mass = "0 kg"', "above 0"),
        ('mass_height = "0.46 m"', "", "together"),
        (
            'point = ["46.2 m", "0 m", "30.3 m"]',
            'point = ["46.2 m", "0 m", "90 m"]',
            "the building",
        ),
        (
            'direction = "y"\ntype = "synthetic"',
            'direction = "w"\ntype = "synthetic"',
            "'x' or 'y'",
        ),
        ('type = "synthetic"', 'type = "measured"', "'synthetic' or 'record'"),
        ("seed = 127", "seed = -1", "at least 0"),
        ("iterations = 1 ", "iterations = 1000000000 ", "at most 10000"),
        ('time_step = "5 ms"', 'time_step = "1e-9 s"', "of memory"),
        ('time_step = "5 ms"', 'time_step = "1e-12 s"', "at least 1e-09 s"),
        ('time_step = "5 ms"', 'time_step = "7 ms"', "a whole number of at least 16"),
        ('strong_phase = ["2 s", "5 s"]', 'strong_phase = ["5 s", "2 s"]', "before its end"),
        ('strong_phase = ["2 s", "5 s"]', 'strong_phase = ["2 s", "50 s"]', "within the duration"),
        ('corner_periods = ["0.05 s", ', 'corner_periods = ["0.5 s", ', "periods"),
        ('pga = "2.32 m/s2"', 'pga = "0 g"', "above 0"),
        ("normal = [0, 1, 0]", "normal = [0, 0, 0]", "vector"),
        ("normal = [0, 1, 0]", "normal = [0, 1]", "3 values"),
        ("normal = [0, 1, 0]", "normal = [0, -1, 0]", "-1"),
        ('{ building = "B2", floor = [1, 2, ', '{ building = "B1", floor = [1, 2, ', "building"),
        (
            '{ building = "B2", floor = [1, 2, ',
            '{ building = "B2", floor = [2, ',
            "same length",
        ),
        ('{ building = "B2", floor = [1, 2, ', '{ building = "B2", storey = [1, 2, ', "relative"),
        ('rigid_above = "0.79 m"', 'rigid_above = "79 m"', "less than that of its rigid zones"),
        ("floor_masses = true", 'floor_masses = "yes"', "true or false"),
        ('displacement = "-2 cm"', 'displacement = "-2"', "unit is missing"),
        ('damping = ["5 %"]\nfreq', 'damping = ["5 %"]\ndamping = ["5 %"]\nfreq', "TOML"),
        ("structure_motions = 12", 'structure_motions = 12\nrecords = "."', "either"),
    ),
    Attack(
        "forces beside members in 3D", PAPER, '[transient]\nforces = "npp_pair_floors.csv"\n', "0"
    ),
]
TABLES = [
    *replaced(
        PAPER,
        ("mass [t]", "mass [m]", "a length"),
        ("mass [t]", "mass", "no unit"),
        ("mass [t]", "weight [t]", "unknown column"),
        ("\n8,", "\n7,", "duplicate floor"),
        ("\n8,", "\n9,", "without a gap"),
        ("\n8,", "\n8.5,", "whole number"),
        ("\n8,", "\n8,,", "cells"),
        ("\n8,", "\n8,nan", "finite number"),
        file="npp_pair_floors.csv",
    ),
    *replaced(
        PAPER,
        ("storeys", "storey", "unknown column"),
        ("\n", "\n\x1b[31m,1,0,0,1,1,0.2\n", ""),
        file="npp_building_walls.csv",
    ),
    *replaced(PAPER, ("name,value", "name;value", "column"), file="npp_pair_published.csv"),
    Attack(
        *("no wall in storey 1", PAPER, "", "no wall and no column stands in storey 1"),
        change=lambda f: _storeys(f / "npp_building_walls.csv"),
    ),
]


def _storeys(path: Path) -> None:
    """Take storey 1 out of a wall table."""
    lines = path.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if ",1," not in line]
    path.write_text("\n".join(kept).replace(",1-8,", ",2-8,").replace(",1 ", ",") + "\n")


def _rows(path: Path, count: int) -> None:
    """Repeat the last row of a table."""
    text = path.read_text(encoding="utf-8").rstrip("\n")
    path.write_text(text + ("\n" + text.rpartition("\n")[2]) * count + "\n", encoding="utf-8")


def _fifo(path: Path) -> None:
    path.unlink(missing_ok=True)
    os.mkfifo(path)


def _chain(folder: Path) -> None:
    for k in range(100):
        (folder / f"c{k}.toml").write_text(f'extends = "c{k + 1}.toml"\n')
    (folder / "c100.toml").write_text('extends = "npp_pair.toml"\n')


KEYS = "[pounding]\n" + "".join(f"unknown_{k} = 1\n" for k in range(4900))
CASE, FLOORS, PUBLISHED = "npp_pair.toml", "npp_pair_floors.csv", "npp_pair_published.csv"
FILES: list[tuple[str, str, str, Change]] = [
    ("an empty table", PAPER, "is empty", lambda f: (f / FLOORS).write_text("")),
    ("a table of bytes", PAPER, "not a text", lambda f: (f / FLOORS).write_bytes(b"\xff\xfe\0")),
    ("a table that is a folder", PAPER, "directory", lambda f: _folder(f / FLOORS)),
    ("a table that is a FIFO", PAPER, "ordinary file", lambda f: _fifo(f / FLOORS)),
    ("no table", PAPER, "no such file", lambda f: (f / FLOORS).unlink()),
    ("300 floors", PAPER, "at most 200", lambda f: _rows(f / FLOORS, 300)),
    ("20,000 published rows", PAPER, "10000", lambda f: _rows(f / PUBLISHED, 20_000)),
    ("a chain of 100 cases", "paper/c0.toml", "at most 50 files", _chain),
    ("a cell of 200,000 letters", PAPER, "field limit", lambda f: _cell(f / FLOORS)),
    (
        "a case of 2 MB",
        PAPER,
        "at most 1 MB",
        lambda f: _append(f / "npp_pair.toml", "#" * 2_000_000),
    ),
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


def _append(path: Path, text: str) -> None:
    with path.open("a", encoding="utf-8") as stream:
        stream.write(text)


def _folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def _cell(path: Path) -> None:
    _append(path, '"' + "x" * 200_000 + '"\n')


def _zeros(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([lines[0], *(f"{0.01 * k},0" for k in range(400))]) + "\n")


def _lines(path: Path, count: int) -> None:
    path.write_text("\n".join(path.read_text(encoding="utf-8").splitlines()[:count]) + "\n")


def _half(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _short(folder: Path) -> None:
    case, forces = folder / "device.toml", folder / "forces.csv"
    text = case.read_text(encoding="utf-8")
    case.write_text(text.replace("[transient]\n", '[transient]\nduration = "2 s"\n'))
    _lines(forces, 52)


def _head(path: Path, name: str) -> None:
    path.write_text(path.read_text(encoding="utf-8").replace("F.floor_1", name, 1))


def _no_contacts(path: Path) -> None:
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
        *("half a mesh", FRAME, "", "frame.msh"),
        change=lambda f: _half(f / "frame.msh"),
        mesh=True,
    ),
    Attack("4,900 unknown keys", PAPER, KEYS, "further faults"),
    Attack(
        "6,000 keys",
        PAPER,
        KEYS.replace("un", "n") + "[x]\n" + "\n".join(f"a{k}=1" for k in range(200)),
        "5000",
    ),
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
TAKEN = [
    Attack("a long step", PAPER, '[pounding]\ntime_step = "5 s"\n', "", "accepted"),
    Attack("one floor in two pairs", PAPER, TWICE.replace("2, ", "1, "), "", "accepted", TWICE),
    Attack("letters of other languages", PAPER, 'title = "Bâtiments α 梁"\n', "", "accepted"),
    Attack("64 letters", PAPER, f'name = "{"B" * 64}"', "unknown building", old='name = "B2"'),
    Attack(
        *("days of steps", PAPER, DAYS, "a run of this case takes about", "warned"),
    ),
]
ATTACKS = [*SIZES, *TYPES, *NAMES, *TOGETHER, *TABLES, *MADE, *TAKEN]


def verdict_of(attack: Attack, folder: Path) -> tuple[str, str]:
    """What becomes of an attack, and what is said of it.

    Args:
        attack: The attack.
        folder: The folder of its good case, which is changed.
    """
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
    said: list[str] = []

    def check() -> None:
        try:
            checked(case, mesh=attack.mesh)
        except InputError as error:
            said.extend(map(str, error.faults))
            raise

    with in_file_only() as warnings:
        found = outcome(check, folder, InputError)
    warned = sorted(line for line in warnings if line.startswith("warning: "))
    verdict = "warned" if found == "good" and warned else {"good": "accepted"}.get(found, found)
    return verdict, "\n".join([*said, *warned])


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name[:70])
def test_an_attack(attack: Attack, good: Path, tmp_path: Path) -> None:
    folder = tmp_path / "attacked"
    shutil.copytree(good / Path(attack.case).parent, folder)
    verdict, said = verdict_of(attack, folder)
    assert (verdict, attack.words in said) == (attack.verdict, True), f"{verdict}: {said[:600]}"


def test_about_as_many_as_before() -> None:
    assert len(ATTACKS) >= 190 and len({attack.name for attack in ATTACKS}) == len(ATTACKS)
