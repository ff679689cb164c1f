"""Blocks of code say what the program does: commands, options, imports, keys of a case."""

import ast
import copy
import importlib
import subprocess
import tomllib

import jsonschema
import numpy as np
import pytest

from docs._ext.case_reference import json_schema
from impactfem.fit.fit_file import FitFile

from .commands import faults
from .pages import PAGES, ROOT, blocks, spans

BLOCKS = [block for page in PAGES for block in blocks(page)]
SHELL = [block for block in BLOCKS if block.language in ("sh", "bash", "shell", "console")]
PYTHON = [block for block in BLOCKS if block.language == "python"]
TABLES = [block for block in BLOCKS if block.language == "toml"]
SPANS = [span for page in PAGES for span in spans(page)]
SCRIPTS = sorted((ROOT / "docs" / "slurm").glob("*.sh"))


def place(block):
    return f"{block.page.relative_to(ROOT)}:{block.line}"


def fragments(schema=None):
    """The schema of a part of a case, or of another file: nothing is required."""

    def loosened(entry):
        if isinstance(entry, list):
            return [loosened(item) for item in entry]
        if not isinstance(entry, dict):
            return entry
        new = {k: loosened(v) for k, v in entry.items() if k not in ("required", "oneOf")}
        if "oneOf" in entry:
            new["anyOf"] = [*new.get("anyOf", []), *loosened(entry["oneOf"])]
        return new

    return loosened(copy.deepcopy(schema or json_schema()))


def arrays(content):
    """A variant with its named tables, `[buildings.west]`, as the array that the schema knows."""
    if "extends" not in content:
        return content
    named = {k: v for k, v in content.items() if k in ("buildings", "devices")}
    tables = {k: list(v.values()) for k, v in named.items() if isinstance(v, dict)}
    return content | tables


def wrong_imports(text):
    """Imports of a text in Python that do not exist."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names = [(alias.name, None) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [(node.module, alias.name) for alias in node.names]
        else:
            continue
        for module, name in names:
            try:
                found = importlib.import_module(module)
                if name is not None and not hasattr(found, name):
                    importlib.import_module(f"{module}.{name}")
            except ImportError:
                yield f"{module} {name or ''}".strip()


@pytest.mark.parametrize("block", SHELL, ids=place)
def test_commands(block):
    assert list(faults(block.text)) == []


def test_commands_in_lines_of_text():
    wrong = [
        f"{place(span)}: {fault}" for span in SPANS for fault in faults(span.text, whole=False)
    ]
    assert wrong == []


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_batch_scripts(script):
    done = subprocess.run(["bash", "-n", str(script)], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    text = script.read_text(encoding="utf-8")
    assert list(faults(text)) == []
    assert "impactfem" in text and script.stat().st_mode & 0o111
    lines = text.splitlines()
    assert lines[0] == "#!/bin/bash"
    # Slurm reads no option after the first command.
    last = max(i for i, line in enumerate(lines) if line.startswith("#SBATCH"))
    assert all(line.startswith("#") for line in lines[:last])


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("impactfem run case.toml --out a --stage pounding --resume", None),
        ("a/b/impactfem run 'my case.toml' > log; ls --wrong", None),
        ("impactfem runn case.toml", "no such command"),
        ("impactfem run case.toml --ressume", "no option --ressume"),
    ],
)
def test_faults_of_commands(text, found):
    got = list(faults(text))
    assert got == [] if found is None else len(got) == 1 and found in got[0], got


@pytest.mark.parametrize("block", PYTHON, ids=place)
def test_python_compiles_and_imports(block):
    compile(block.text, place(block), "exec")
    assert list(wrong_imports(block.text)) == []


@pytest.mark.parametrize("block", TABLES, ids=place)
def test_toml_is_part_of_a_case(block):
    of_fits = FitFile.model_json_schema() if block.page.name == "fit.md" else None
    jsonschema.validate(arrays(tomllib.loads(block.text)), fragments(of_fits))


PAGE = ROOT / "docs" / "from-a-mesh.md"


@pytest.fixture(scope="module")
def names():
    """What the code of the page leaves, run from the folder of the program."""
    left = {}
    code = [block.text for block in blocks(PAGE) if block.language == "python"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        for text in code:
            exec(compile(text, str(PAGE), "exec"), left)
    assert len(code) == 4
    return left


def test_the_strip_weighs_and_bends_as_by_hand(names):
    """Strip and beam as one section: EI, the load of weight and pressure, and that of the tip."""
    model, tip, u = names["model"], names["tip"], names["u"]
    A, B = 33e9 * 0.2, 210e9 * 0.02  # E A of the slab, of the beam
    own = 1.0 * 0.2 * 2500.0 + 100.0 + 0.02 * 7850.0  # kg/m
    assert -names["weight"][:, 2].sum() == pytest.approx(9.81 * (4.0 * own + 20.0 * 5), rel=1e-9)
    EI = 33e9 * 0.2**3 / 12.0 + 210e9 * 0.1 * 0.2**3 / 12.0 + A * B / (A + B) * 0.2**2
    q, P = 9.81 * own + 2e3, 5e3 + 9.81 * 100.0
    deflection = q * 4.0**4 / (8.0 * EI) + P * 4.0**3 / (3.0 * EI)
    # Shear, the width of the strip and a tip mass that is spread over it: some per cent.
    assert -u[tip, 2].mean() == pytest.approx(deflection, rel=0.03)
    assert names["frequency"][0] == pytest.approx(
        np.sqrt(3.0 * EI / (4.0**3 * (33.0 / 140.0 * 4.0 * own + 100.0))) / (2.0 * np.pi), rel=0.03
    )
    assert not u[model.held].any()


def test_the_blow_balances(names):
    assert names["history"].energy.residual < 1e-9
    assert names["deflection"].shape == (501, 5)
    assert names["deflection"].min() < 0.0


def test_the_frame_of_the_file(names):
    first = names["frame"].modes(1)[0][0]
    assert 1.0 < first < 20.0
    assert (names["pushed"][names["mesh"].nodes["centre_2"], 1] < 0.0).all()
