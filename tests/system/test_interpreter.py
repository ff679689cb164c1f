"""An interpreter that cannot run impactfem is refused in one line with the remedy."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from impactfem.case.template import write_new_case
from impactfem.system import interpreter
from impactfem.system.errors import ImpactfemError
from impactfem.system.packages import require_packages

ROOT = Path(__file__).parents[2]
# Modules of these names are not found, as in an environment without them.
WITHOUT = """
import sys
names = {names!r}
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in names:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Finder())
"""
PROGRAM = "from impactfem.cli import main\nsys.argv[1:] = {words!r}\nmain()"


def ended(folder, names, code):
    """The ended process of some code without modules of some names."""
    command = [sys.executable, "-c", WITHOUT.format(names=names) + code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def program(folder, names, *words):
    return ended(folder, names, PROGRAM.format(words=list(words)))


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """The template without and with a 3D model."""
    folder = tmp_path_factory.mktemp("cases")
    write_new_case(folder / "sticks")
    write_new_case(folder / "solid", ("structure",))
    return folder


def assert_one_line(done, *words):
    lines = done.stderr.splitlines()
    assert done.returncode != 0 and len(lines) == 1, done.stderr
    assert all(word in lines[0] for word in (*words, sys.executable, "docs/install.md")), lines[0]


@pytest.mark.parametrize("name", ["typer", "numpy", "PIL"])
def test_a_missing_dependency(tmp_path, name):
    assert_one_line(program(tmp_path, (name,), "--version"), name)
    assert_one_line(ended(tmp_path, (name,), "import impactfem"), name)


def test_an_error_of_a_script_keeps_its_traceback(tmp_path):
    code = "try:\n    import impactfem\nexcept ImportError:\n    print('caught')\n1 / 0"
    done = ended(tmp_path, ("typer",), code)
    assert done.stdout == "caught\n" and "Traceback" in done.stderr


def test_packages_of_a_run(cases):
    assert_one_line(program(cases, ("netCDF4",), "check", "sticks.toml"), "netCDF4")
    names, out = ("dolfinx", "ufl"), cases / "run"
    assert_one_line(program(cases, names, "run", "solid.toml", "--out", str(out)), *names)
    assert not out.exists()


def test_sticks_need_no_fenicsx(cases):
    done = program(cases, interpreter.FENICSX, "check", "sticks.toml")
    assert done.returncode == 0 and done.stderr == ""


def test_require_packages(monkeypatch):
    require_packages(three_d=True)
    monkeypatch.setattr(interpreter, "find_spec", lambda name: None)
    monkeypatch.delitem(sys.modules, "dolfinx", raising=False)
    with pytest.raises(ImpactfemError, match="dolfinx"):
        require_packages(three_d=True)


def test_faults():
    fault = interpreter.interpreter_fault
    assert fault((3, 11), []) is None and fault((3, 14), []) is None
    assert "3.11" in fault((3, 10), []) and "3.10" in fault((3, 10), [])
    many = [f"name{k}" for k in range(9)]
    text = fault((3, 12), many)
    assert "name4" in text and "name5" not in text and "4 more" in text


def test_all_dependencies_are_checked():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = [Requirement(text).name for text in project["dependencies"]]
    assert sorted(names) == sorted(interpreter.PACKAGES)
    assert project["requires-python"] == ">=" + ".".join(map(str, interpreter.OLDEST))
    assert interpreter.missing_modules(*interpreter.PACKAGES.values()) == []
    assert interpreter.missing_modules("no_such_module") == ["no_such_module"]
