"""Devices in full order on the ranks of this program; rank 0 writes what it found.

Run by test_full_order.py: `mpirun -n 2 python full_on_ranks.py GIVEN FOLDER`.
"""

import pickle
import sys
import traceback
from pathlib import Path

from mpi4py import MPI

from impactfem.building.model import assemble_building
from impactfem.device.mounted import MountedDevice
from impactfem.stages.device.full_order import full_histories, full_system


def histories(comm, given, folder, **options):
    """Matrices and both runs, on all ranks."""
    with full_system(
        assemble_building(comm, given["parts"]),
        given["parts"].mesh,
        given["factor"],
        given["base_plates"],
        [MountedDevice(one.name, one) for one in given["devices"]],
        given["loads"],
        damping=given["damping"],
    ) as system:
        return full_histories(
            system,
            given["loads"],
            given["damping"],
            given["substeps"],
            folder,
            key="key",
            every=100,
            **options,
        )


def main(given, folder):
    made = histories(MPI.COMM_WORLD, pickle.loads(given.read_bytes()), folder)
    if MPI.COMM_WORLD.rank == 0:
        (folder / "found").write_bytes(pickle.dumps(made))


if __name__ == "__main__":
    try:
        main(*map(Path, sys.argv[1:]))
    except Exception:
        # `-m mpi4py` aborts too late: PETSc's end waits for the other ranks before.
        traceback.print_exc()
        MPI.COMM_WORLD.Abort(1)
