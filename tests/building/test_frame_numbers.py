"""The shipped mesh gives the same numbers on any number of ranks and with any dolfinx.

`frame_numbers.json` was written by dolfinx 0.5.2 on one rank, by `frame_numbers.py` itself.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).with_name("frame_numbers.py")
KNOWN = json.loads(SCRIPT.with_suffix(".json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("ranks", [1, 2, 3, 4])
def test_same_numbers(ranks, under_mpirun, tmp_path):
    out = tmp_path / "numbers.json"
    ended = under_mpirun(ranks, sys.executable, "-m", "mpi4py", SCRIPT, out)
    assert ended.returncode == 0, ended.stderr
    found = json.loads(out.read_text(encoding="utf-8"))
    np.testing.assert_allclose(found["frequency"], KNOWN["frequency"], rtol=1e-9)
    np.testing.assert_allclose(found["mass"], KNOWN["mass"], rtol=1e-12)
    largest = np.abs(KNOWN["displacement"]).max()
    np.testing.assert_allclose(found["displacement"], KNOWN["displacement"], atol=1e-8 * largest)
