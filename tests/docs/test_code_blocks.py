"""Blocks of code say what the program does: commands, options, imports, keys of a case."""

import ast
import copy
import importlib
import subprocess
import tomllib

import jsonschema
import pytest

from docs._ext.case_reference import json_schema

from .commands import faults
from .pages import PAGES, ROOT, blocks, language_of, spans

BLOCKS = [block for page in PAGES for block in blocks(page)]
SHELL = [block for block in BLOCKS if block.language in ("sh", "bash", "shell", "console")]
PYTHON = [block for block in BLOCKS if block.language == "python"]
TABLES = [block for block in BLOCKS if block.language == "toml"]
SPANS = [span for page in PAGES for span in spans(page)]
SCRIPTS = sorted((ROOT / "docs" / "slurm").glob("*.sh"))


def place(block):
    return f"{block.page.relative_to(ROOT)}:{block.line}"


def fragments():
    """The schema of a part of a case: nothing is required."""

    def loosened(entry):
        if isinstance(entry, list):
            return [loosened(item) for item in entry]
        if not isinstance(entry, dict):
            return entry
        new = {k: loosened(v) for k, v in entry.items() if k not in ("required", "oneOf")}
        if "oneOf" in entry:
            new["anyOf"] = [*new.get("anyOf", []), *loosened(entry["oneOf"])]
        return new

    return loosened(copy.deepcopy(json_schema()))


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
        ("mpirun -n 3 impactfem sweep c.toml --set a.b=1,2 --processes 4  # --wrong", None),
        ("run() { impactfem sweep c.toml \\\n  --zip --set 'a=1' \"$@\"; }", None),
        ("impactfem bench building transient --json=a.json", None),
        ("impactfem --verbose check a.toml", None),
        ("impactfem runn case.toml", "no such command"),
        ("impactfem run case.toml --ressume", "no option --ressume"),
        ("impactfem --quiet run case.toml", "no option --quiet"),
        ("impactfem run case.toml --stage stick", "no such stage"),
        ("impactfem verify --only roof_of", "no benchmark"),
        ("impactfem run", "an argument is missing"),
        ("impactfem run a.toml b.toml", "an argument too many"),
        ("python -m impactfem.run.loo docs", "no module impactfem.run.loo"),
        ("python -m impactfem.run.loop docs", None),
        ("sbatch docs/slurm/gone.sh", "there is no docs/slurm/gone.sh"),
        ("impactfem run 'a.toml", "No closing quotation"),
    ],
)
def test_faults_of_commands(text, found):
    got = list(faults(text))
    assert got == [] if found is None else len(got) == 1 and found in got[0], got


@pytest.mark.parametrize("block", PYTHON, ids=place)
def test_python_compiles_and_imports(block):
    compile(block.text, place(block), "exec")
    assert list(wrong_imports(block.text)) == []


def test_wrong_imports_are_found():
    text = "import numpyy\nfrom impactfem import study, sudy\nfrom impactfem.study import run, runn"
    assert list(wrong_imports(text)) == ["numpyy", "impactfem sudy", "impactfem.study runn"]


@pytest.mark.parametrize("block", TABLES, ids=place)
def test_toml_is_part_of_a_case(block):
    jsonschema.validate(tomllib.loads(block.text), fragments())


@pytest.mark.parametrize(
    ("text", "valid"),
    [
        ('[damping]\nratio = "5 %"', True),
        ('[[contacts]]\ngap = "1 cm"', True),
        ('extends = "a.toml"\n[[buildings]]\n[buildings.structure]\nmodes = 8', True),
        ('[damping]\nratioo = "5 %"', False),
        ('[[contacts]]\ngap = "1"', False),
        ("[dampings]\na = 1", False),
    ],
)
def test_keys_that_do_not_exist_are_found(text, valid):
    content = tomllib.loads(text)
    assert jsonschema.Draft202012Validator(fragments()).is_valid(content) is valid


@pytest.mark.parametrize(
    ("text", "language"),
    [
        ("impactfem run a.toml", "sh"),
        ("ls a > b\nsbatch --array=1-2 a.sh", "sh"),
        (".venv/bin/impactfem new towers  # writes", "sh"),
        ("from a import b", "python"),
        ('[damping]\nratio = "5 %"', "toml"),
        ("Mesh.ElementOrder = 2;", ""),
        ("#:schema ../docs/case.schema.json", ""),
        ("F = K p + C v", ""),
        ("w = 2P/(ρ A L)", ""),
        ("steps = 50", "toml"),
    ],
)
def test_languages_are_guessed(text, language):
    assert language_of(text) == language


def test_there_is_something_to_check():
    assert len(SHELL) > 5 and len(SPANS) > 5 and len(SCRIPTS) > 3
    assert len(PYTHON) > 2 and len(TABLES) > 1
