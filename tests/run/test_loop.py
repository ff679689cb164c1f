"""A run that is killed: what was written is whole, and `--resume` gives the same results."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray as xr

PROGRAM = Path(sys.executable).parent / "impactfem"


def results(folder, names):
    """Scalars, and the content of stores."""
    stores = {}
    for name in names:
        with xr.open_dataset(folder / name, engine="h5netcdf") as store:
            stores[name] = store.load()
    return json.loads((folder / "summary.json").read_text(encoding="utf-8")), stores


@pytest.mark.slow
def test_kills_at_random_moments(finished, tmp_path):
    """The process and all that it started, somewhere after its folder is open."""
    random_numbers, folder = random.Random(8), tmp_path / "run"
    command = [PROGRAM, "run", finished.case, "--out", folder, "--stage", "pounding"]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    for kill in range(2):
        again = ["--resume"] if kill else []
        with subprocess.Popen([*command, *again], **silent, start_new_session=True) as run:
            # The lock of the run before stays when it was killed: this one has its own number.
            mine = f"process {run.pid} on "
            while run.poll() is None and not _says(folder / ".lock", mine):
                time.sleep(0.01)
            time.sleep(random_numbers.uniform(0.0, 2.0))
            os.killpg(run.pid, signal.SIGKILL)
    last = subprocess.run(
        [*command, "--resume"], capture_output=True, text=True, check=False, timeout=300
    )
    assert last.returncode == 0, last.stderr
    assert not list(folder.rglob(".*"))
    stores = [path.name for path in folder.glob("*.nc")]
    assert {"pounding.nc", "motion.nc", "forces.nc"} <= set(stores)
    scalars, found = results(folder, stores)
    expected_scalars, expected = results(finished.folder, stores)
    assert scalars == expected_scalars
    for name in stores:
        xr.testing.assert_identical(found[name], expected[name])


def _says(path, words):
    try:
        return path.read_text(encoding="utf-8").startswith(words)
    except FileNotFoundError:
        return False
