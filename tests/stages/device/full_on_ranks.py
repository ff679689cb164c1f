"""Devices in full order on the ranks of this program, for test_full_order.py."""

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


def results(given, folder):
    return histories(MPI.COMM_WORLD, given, folder)
