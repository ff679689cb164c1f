"""Where packages come from: not from the user's own folder, and said where from elsewhere."""

import site
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from impactfem.system.packages import DEBIAN

# As Python starts where the user's folder is in use: it comes before that of Debian's packages.
STARTED = """
import site, sys
site.ENABLE_USER_SITE = True
user = site.getusersitepackages()
site.addsitedir(user)
sys.path.remove(user)
sys.path.insert(0, user)
"""
BROKEN = ("h5py", "netCDF4", "ufl", "numpy", "platformdirs", "typer", "bottleneck")


@pytest.fixture
def user(tmp_path, monkeypatch):
    """A user's folder of packages that cannot be imported; one is installed where it is made."""
    monkeypatch.setenv("PYTHONUSERBASE", str(tmp_path / "base"))
    monkeypatch.delenv("PYTHONNOUSERSITE", raising=False)
    folder = Path(site._get_path(str(tmp_path / "base")))
    folder.mkdir(parents=True)
    for name in BROKEN:
        (folder / f"{name}.py").write_text(f"raise OSError('{name} of the user')\n")
    elsewhere = tmp_path / "made here"
    elsewhere.mkdir()
    (elsewhere / "basix.py").write_text("raise OSError('basix of the user')\n")
    (folder / "basix.pth").write_text(f"# where it is made\n\n{elsewhere}\n")
    return folder


def said(code, *words):
    """What Python prints for a code, both outputs; it must end well."""
    command = [sys.executable, "-c", code, *map(str, words)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout, ended.stderr


def test_packages_of_the_user_are_left_out(user):
    code = f"{STARTED}\nimport impactfem.cli, h5py, netCDF4, ufl, basix\n"
    assert said(code + "print(user in sys.path)") == ("False\n", "")


def test_they_are_left_out_of_new_processes(user):
    code = f"""{STARTED}
from impactfem.system.executor import in_own_process, workers
import importlib.util
if __name__ == "__main__":
    print(in_own_process(importlib.util.find_spec, "bottleneck"))
    with workers(1) as executor:
        print(executor.submit(importlib.util.find_spec, "bottleneck").result())
"""
    assert said(code) == ("None\nNone\n", "")


def test_the_users_folder_stays_where_the_program_is_in_it(user):
    import impactfem

    (user / "impactfem.pth").write_text(f"{Path(impactfem.__file__).parents[1]}\n")
    for name in BROKEN:
        (user / f"{name}.py").unlink()
    assert said(f"{STARTED}\nimport impactfem\nprint(user in sys.path)") == ("True\n", "")


def test_a_package_that_is_imported_before_is_named(user):
    (user / "h5py.py").write_text("")
    out, errors = said(f"{STARTED}\nimport h5py\nimport impactfem\nprint('goes on')")
    assert out == "goes on\n" and errors.count("\n") == 1
    assert "h5py" in errors and str(user) in errors and "PYTHONNOUSERSITE=1" in errors


@pytest.mark.skipif(
    not (find_spec("dolfinx").origin or "").startswith(DEBIAN), reason="FEniCSx is not Debian's"
)
@pytest.mark.parametrize("name", ["h5py", "mpi4py", "ufl"])
def test_a_package_from_elsewhere_is_named(tmp_path, monkeypatch, name):
    """By PYTHONPATH, as modules of a cluster set it."""
    code = "import sys\nfrom impactfem.cli import main\nsys.argv[1:] = ['new', sys.argv[1]]\nmain()"
    assert said(code, tmp_path / "first")[1] == ""
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / f"{name}.py").write_text("raise OSError('foreign')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "foreign"))
    errors = said(code, tmp_path / "second")[1]
    assert errors.count("\n") == 1 and name in errors and str(tmp_path / "foreign") in errors


def test_the_environment_of_bootstrap_has_none(user):
    """Not even for scripts that do not import impactfem."""
    if not list(Path(sys.prefix).glob("lib/python3*/site-packages/no_user_site.pth")):
        pytest.skip("this environment was not made by scripts/bootstrap")
    code = "import site, sys\nprint(site.ENABLE_USER_SITE)\nimport h5py"
    assert said(code) == ("False\n", "")
