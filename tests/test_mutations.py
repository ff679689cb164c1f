"""Mutated case files, tables and records: refused with exit code 2 and plain words, or still good.

A seeded generator, so that a failure can be made again from its number.
"""

import random
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from impactfem import cli
from impactfem.motion import Accelerogram, write_csv
from impactfem.verify import record_files

DATA = Path(__file__).parent / "case" / "data"
COUNT = 480
REFUSED = 200
FORMATS = {
    "record.csv": "csv",
    "record.at2": "at2",
    "record.esm": "esm",
    "record.v2c": "cosmos",
    "record.v2": "csmip",
    "record.NS": "knet",
}
WORDS = (
    "nan",
    "inf",
    "-1",
    "0",
    "1e999",
    "3 parsecs",
    "'",
    '"',
    "]",
    "=",
    "\x00",
    "é",
    "-",
    "1 cm",
)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A folder with a case of two buildings and a record for each format."""
    folder = tmp_path_factory.mktemp("good")
    for file in DATA.iterdir():
        shutil.copy(file, folder)
    t = np.arange(400) * 0.01
    a = np.sin(9.0 * t) * np.exp(-t)
    write_csv(Accelerogram(0.01, a, "record", "made"), folder / "record.csv")
    channels = [("360", 100.0 * a)]
    for name, text in {
        "record.at2": record_files.at2_text(a / 9.80665, 0.01),
        "record.esm": record_files.esm_text(100.0 * a, 0.01),
        "record.v2c": record_files.cosmos_text([("360", "HNN", 100.0 * a)], 0.01),
        "record.v2": record_files.csmip_text(channels, 0.01),
        "record.NS": record_files.knet_text([round(1e5 * x) for x in a], 100),
    }.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def call(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["impactfem", *map(str, words)])
    try:
        cli.main()
        code = 0
    except SystemExit as error:
        code = error.code or 0
    return code, capsys.readouterr()


def mutated(rng, content):
    """One change to a text: a line or a word lost, doubled, cut, replaced; bytes flipped."""
    lines = content.decode("utf-8").split("\n")
    number = rng.randrange(len(lines))
    kind = rng.choice(["drop", "double", "word", "cut", "swap", "digit", "key", "bytes", "end"])
    if kind == "drop":
        del lines[number]
    elif kind == "double":
        lines.insert(number, lines[number])
    elif kind == "word":
        parts = lines[number].split(",") if "," in lines[number] else lines[number].split(" ")
        parts[rng.randrange(len(parts))] = rng.choice(WORDS)
        lines[number] = ("," if "," in lines[number] else " ").join(parts)
    elif kind == "cut":
        lines[number] = lines[number][: len(lines[number]) // 2]
    elif kind == "swap":
        other = rng.randrange(len(lines))
        lines[number], lines[other] = lines[other], lines[number]
    elif kind == "digit":
        lines[number] = "".join(
            rng.choice("0123456789-.eE") if c.isdigit() and rng.random() < 0.4 else c
            for c in lines[number]
        )
    elif kind == "key":
        lines[number] = lines[number].replace("e", "", 1)
    elif kind == "end":
        lines = lines[:number]
    text = "\n".join(lines).encode("utf-8")
    if kind == "bytes" and text:
        where = rng.randrange(len(text))
        text = text[:where] + bytes(rng.randrange(256) for _ in range(3)) + text[where + 3 :]
    return text


def test_mutated_inputs(good, tmp_path, monkeypatch, capsys):
    case = next(good.glob("*.toml"))
    text = case.read_text(encoding="utf-8")
    start, end = text.index("[[motions]]"), text.index("[contact_laws")
    recorded = '[[motions]]\ndirection = "y"\ntype = "record"\nfile = "{}"\nformat = "{}"\n\n'
    files = {path.name: path.read_bytes() for path in good.iterdir()}
    cases = {}
    for name, fmt in FORMATS.items():
        cases[name] = f"{fmt}.toml"
        whole = text[:start] + recorded.format(name, fmt) + text[end:]
        files[cases[name]] = whole.encode("utf-8")
    targets = sorted({*files} - {f"{fmt}.toml" for fmt in FORMATS.values() if fmt != "csv"})
    refused = 0
    for number in range(COUNT):
        rng = random.Random(number)
        name = rng.choice(targets)
        folder = tmp_path / str(number)
        folder.mkdir()
        for other, content in files.items():
            (folder / other).write_bytes(mutated(rng, content) if other == name else content)
        checked = folder / (name if name == "csv.toml" else cases.get(name, case.name))
        before = sorted(path.name for path in folder.iterdir())
        code, shown = call(monkeypatch, capsys, "check", checked)
        assert code in (0, 2), (number, name, shown)
        assert "Traceback" not in shown.err + shown.out, (number, name, shown)
        assert sorted(path.name for path in folder.iterdir()) == before
        if code == 2:
            refused += 1
            lines = shown.err.splitlines()
            assert lines and all(line.startswith("error: ") for line in lines), (number, shown)
            assert str(folder) in shown.err, (number, shown)
        shutil.rmtree(folder)
    assert refused >= REFUSED, refused


def test_the_good_ones_are_good(good, tmp_path, monkeypatch, capsys):
    case = next(good.glob("*.toml"))
    assert call(monkeypatch, capsys, "check", case)[0] == 0
    for name, fmt in FORMATS.items():
        shutil.copytree(good, tmp_path / fmt)
        text = case.read_text(encoding="utf-8")
        start, end = text.index("[[motions]]"), text.index("[contact_laws")
        motion = (
            f'[[motions]]\ndirection = "y"\ntype = "record"\nfile = "{name}"\nformat = "{fmt}"\n'
        )
        (tmp_path / fmt / "case.toml").write_text(text[:start] + motion + text[end:])
        code, shown = call(monkeypatch, capsys, "check", tmp_path / fmt / "case.toml")
        assert code == 0, (fmt, shown)


def test_a_refused_case_leaves_no_folder(good, tmp_path, monkeypatch, capsys):
    case = tmp_path / "bad.toml"
    case.write_text("title = 3\n", encoding="utf-8")
    code, shown = call(monkeypatch, capsys, "run", case, "--out", tmp_path / "out")
    assert code == 2 and not (tmp_path / "out").exists()
    assert "title" in shown.err
