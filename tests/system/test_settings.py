"""Settings files and modules in the working folder, which may come from somebody else."""

import json
import os
import subprocess
import sys

import pytest

# What libraries do in a folder, without this program and with it.
PETSC = "from petsc4py import PETSc; PETSc.Vec().createSeq(3).destroy()"
NUMBA = "import numba; print(numba.config.DISABLE_JIT)"
KERNEL = f"{NUMBA}; numba.njit(lambda x: x + 1.0)(1.0); print(numba.config.DISABLE_JIT)"
FIGURE = (
    "import pathlib; from impactfem.plot.style import sheet\n"
    "with sheet(pathlib.Path('f.svg'), (1, 1), (2.0, 2.0), 'Words.') as (_, (panel,)):\n"
    "    panel.plot([0.0, 1.0], label='$x$')\n"
    "print(pathlib.Path('f.svg').read_text())"
)
FORM = (
    "from mpi4py import MPI; import ufl; from dolfinx import fem, mesh\n"
    "cells = mesh.create_unit_interval(MPI.COMM_SELF, 2)\n"
    "form = fem.Constant(cells, 1.0) * ufl.dx(domain=cells)\n"
)
AHEAD = "import impactfem\n"
EFFECT = "open('effect', 'w').close()\n"


def run_in(folder, code, *options, **variables):
    """The ended process of some code in a folder, which is empty but for what was planted."""
    return subprocess.run(
        [sys.executable, *options, "-c", code],
        cwd=folder,
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def folder(tmp_path):
    """An empty working folder."""
    made = tmp_path / "work"
    made.mkdir()
    return made


@pytest.mark.parametrize("name", [".petscrc", "petscrc"])
def test_petsc_reads_no_options_from_a_file(folder, name):
    (folder / name).write_text("-log_view :effect\n")
    assert run_in(folder, PETSC).returncode == 0
    assert (folder / "effect").exists()
    (folder / "effect").unlink()
    ended = run_in(folder, AHEAD + PETSC, "-P")
    assert ended.returncode == 0, ended.stderr
    assert not (folder / "effect").exists()


def test_petsc4py_takes_no_library_from_the_folder(folder):
    (folder / "petsc.cfg").write_text("PETSC_ARCH = /proc/self/cwd/arch\n")
    (folder / "slepc.cfg").write_text("PETSC_ARCH = /proc/self/cwd/arch\n")
    (folder / "arch").mkdir()
    for name in ("PETSc", "SLEPc"):
        (folder / "arch" / f"{name}.py").write_text(EFFECT)
    run_in(folder, PETSC, "-P")
    assert (folder / "effect").exists() or sys.version_info >= (3, 12)  # newer ones import less
    (folder / "effect").unlink(missing_ok=True)
    ended = run_in(folder, f"{AHEAD}{PETSC}; from slepc4py import SLEPc", "-P")
    assert ended.returncode == 0, ended.stderr
    assert not (folder / "effect").exists()


@pytest.mark.parametrize("content", ["disable_jit: 1\ncache_dir: kernels\n", "{", "\0"])
def test_numba_reads_no_settings(folder, content):
    (folder / ".numba_config.yaml").write_text(content)
    if content != "\0":
        assert run_in(folder, NUMBA, "-P").stdout.strip() != "0"
    ended = run_in(folder, AHEAD + KERNEL, "-P")
    assert ended.stdout.split() == ["0", "0"], ended.stderr
    assert [path.name for path in folder.iterdir()] == [".numba_config.yaml"]


def test_kernels_are_kept_in_the_cache_of_the_user(folder, tmp_path):
    code = "import os; print(os.environ['NUMBA_CACHE_DIR'], os.environ['NCRCENV_IGNORE'])"
    ended = run_in(folder, AHEAD + code, "-P", NUMBA_CACHE_DIR="", XDG_CACHE_HOME=str(tmp_path))
    assert ended.stdout.split() == [str(tmp_path / "impactfem" / "kernels"), "1"]


TEX = b"text.usetex: True\nfigure.facecolor: red\nsvg.fonttype: path\nfont.size: 30\n"
BACKEND = (
    b"savefig.format: nonsense\nbackend: module://evil\naxes.prop_cycle: cycler('color', 'r')\n"
)


@pytest.mark.parametrize(
    ("content", "own"),
    [(TEX, False), (TEX, True), (BACKEND, False), (BACKEND, True), (b"\xff\xfe\0", False)],
)
def test_settings_of_matplotlib_change_no_figure(folder, tmp_path, content, own):
    """Neither those of the folder nor the user's own, which matplotlib reads."""
    known = run_in(folder, FIGURE, "-P")
    assert known.returncode == 0, known.stderr
    place = tmp_path / "own" if own else folder
    place.mkdir(exist_ok=True)
    (place / "matplotlibrc").write_bytes(content)
    (folder / "evil.py").write_text(EFFECT)
    ended = run_in(folder, FIGURE, "-P", **({"MATPLOTLIBRC": str(place)} if own else {}))
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout == known.stdout and not ended.stderr
    assert not (folder / "effect").exists()


@pytest.mark.parametrize("protected", [False, True])
def test_the_compiler_of_forms_has_no_options_of_the_folder(folder, tmp_path, protected):
    wrapper = folder / "wrapper"
    wrapper.write_text(f'#!/bin/sh\ntouch {folder}/effect\nexec "$@"\n')
    wrapper.chmod(0o755)
    for word in ("options", "parameters"):
        options = {"cffi_extra_compile_args": ["-wrapper", str(wrapper)]}
        (folder / f"dolfinx_jit_{word}.json").write_text(json.dumps(options))
        if protected:
            (folder / f"ffcx_{word}.json").write_text("{")
    ahead = "from impactfem._fenicsx import compiled\n" if protected else ""
    code = f"{ahead}{FORM}{'compiled' if protected else 'fem.form'}(form)"
    ended = run_in(folder, code, "-P", XDG_CACHE_HOME=str(tmp_path / "cache"))
    assert ended.returncode == 0, ended.stderr
    assert (folder / "effect").exists() is not protected


WORKER = (
    "from impactfem.system.executor import workers\n"
    "if __name__ == '__main__':\n"
    "    with workers(1, logs=True) as pool:\n"
    "        print(pool.submit(abs, -1).result())\n"
)


def plant_modules(folder):
    """Modules that Python, its workers and the libraries of this program import."""
    for name in (
        "socket",
        "runpy",
        "numpy",
        "multiprocessing",
        "platformdirs",
        "selectors",
        "gmsh",
    ):
        (folder / f"{name}.py").write_text(EFFECT)


def test_no_module_of_the_folder_is_imported(folder, tmp_path):
    """Neither by the program nor by the processes that it starts."""
    script = tmp_path / "script.py"
    script.write_text(WORKER)
    plant_modules(folder)
    words = sys.executable, "-m", "platform"
    subprocess.run(words, cwd=folder, capture_output=True, check=False)
    assert (folder / "effect").exists()  # Python's own `-m` takes them
    (folder / "effect").unlink()
    ended = subprocess.run(
        [sys.executable, script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert ended.stdout == "1\n", ended.stderr
    assert not (folder / "effect").exists()


def test_the_program_as_a_module_takes_the_folder_off_its_path(folder):
    """Python itself imports a few modules before, as `runpy`: `-P` prevents that."""
    plant_modules(folder)
    for name in ("runpy", "multiprocessing", "selectors", "socket"):
        (folder / f"{name}.py").unlink()
    words = sys.executable, "-m", "impactfem", "new", "a"
    ended = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert (folder / "a.toml").exists() and not (folder / "effect").exists()
