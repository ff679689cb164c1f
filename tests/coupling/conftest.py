"""Fixtures of sticks and of small matrices, and Siconos where it is installed."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ..dynamics.conftest import chain, membrane, petsc  # noqa: F401
from ..sticks.conftest import floors, row, run, section, shake, small_case, study  # noqa: F401


@pytest.fixture
def rack(chain):  # noqa: F811
    """Eight masses between springs, four of them before walls, thrown against these."""
    n = 8
    K, M = 900.0 * chain(n), np.diag(np.linspace(1.0, 2.0, n))
    G = np.zeros((n, 4))
    G[[1, 3, 5, 7], range(4)] = 1.0
    gap, v = np.array([0.02, 0.015, 0.02, 0.01]), np.linspace(1.0, 1.5, n)
    return {"K": K, "M": M, "G": G, "gap": gap, "v": v, "h": 2e-3}


@pytest.fixture
def siconos(tmp_path):
    """Step a case of a structure before walls with Siconos."""
    if importlib.util.find_spec("siconos") is None:
        pytest.skip("siconos is not installed (Debian 12: python3-siconos; Debian 13 has none)")

    def stepped(**case):
        given, out = tmp_path / "case.npz", tmp_path / "results.npz"
        np.savez(given, **case)
        script = Path(__file__).with_name("with_siconos.py")
        done = subprocess.run(
            [sys.executable, script, given, out], capture_output=True, text=True, timeout=600
        )
        assert done.returncode == 0, done.stdout + done.stderr
        with np.load(out) as results:
            return dict(results)

    return stepped
