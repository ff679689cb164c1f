"""Notebooks from their text, run from top to bottom in a separate kernel."""

import ast
import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import jupytext
import pytest
from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell

STRICT = (str(Path(__file__).with_name("kernel.py")),)
FILM = (*STRICT, "--film")
"""A kernel whose runs draw the film of the main impact."""
NOTEBOOKS = Path(__file__).parents[2] / "notebooks"
TIME_LIMIT = 300  # s, of a cell, on a machine that is busy
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "MPLBACKEND": "module://matplotlib_inline.backend_inline"}


class _ThisPython(KernelSpecManager):
    """Knows one kernel: this Python. None need be installed, none of another Python is taken."""

    program: tuple[str, ...]

    def get_kernel_spec(self, kernel_name):
        return KernelSpec(
            argv=[sys.executable, *self.program, "-f", "{connection_file}"],
            display_name="this Python",
            language="python",
        )


def with_parameters(notebook, parameters):
    """Other values behind the cell that is tagged `parameters` and sets all of them."""
    tagged = [
        k for k, cell in enumerate(notebook.cells) if "parameters" in cell.metadata.get("tags", [])
    ]
    if len(tagged) != 1:
        raise ValueError(f"expected one cell that is tagged 'parameters', found {len(tagged)}")
    statements = ast.parse(notebook.cells[tagged[0]].source).body
    targets = [t for one in statements if isinstance(one, ast.Assign) for t in one.targets]
    unknown = sorted(set(parameters) - {t.id for t in targets if isinstance(t, ast.Name)})
    if unknown:
        raise ValueError(f"{', '.join(unknown)}: no parameter of the notebook")
    lines = [f"{name} = {value!r}" for name, value in parameters.items()]
    notebook.cells.insert(tagged[0] + 1, new_code_cell("\n".join(lines)))
    return notebook


@pytest.fixture(scope="session")
def notebooks():
    """The folder of the notebooks."""
    return NOTEBOOKS


@pytest.fixture(scope="session")
def execute():
    """Run a notebook by its name or path, in a working folder, with values of its parameters."""

    def execute(name, workplace, limit=TIME_LIMIT, film=False, **parameters):
        path = name if isinstance(name, Path) else NOTEBOOKS / f"{name}.py"
        notebook = with_parameters(jupytext.read(path, fmt="py:percent"), parameters)
        with TemporaryDirectory(prefix="kernel") as own:
            # Through sockets in a separate folder, whose name is short enough for them: nobody
            # else can reach the kernel, and nothing is written to the home of the user.
            known = _ThisPython()
            known.program = FILM if film else STRICT
            manager = AsyncKernelManager(
                kernel_spec_manager=known,
                transport="ipc",
                ip=f"{own}/socket",
                connection_file=f"{own}/connection.json",
            )
            place = {"metadata": {"path": str(workplace)}}
            client = NotebookClient(notebook, km=manager, timeout=limit, resources=place)
            client.execute(env={**os.environ, **ENVIRONMENT, "IPYTHONDIR": own}, cleanup_kc=True)
        return notebook

    return execute
