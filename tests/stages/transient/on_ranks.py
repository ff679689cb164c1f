"""The frame in time on the ranks of this program, for test_ranks.py."""

import logging

from mpi4py import MPI

from impactfem.building.links import Displacements
from impactfem.building.model import assemble_building
from impactfem.stages.transient.full_run import FullModel, Resumption, run_full
from impactfem.system.log import LOGGER


class KilledError(Exception):
    """The end of a run, from outside."""


class Lines(logging.Handler):
    """What the log says on this rank."""

    def __init__(self):
        super().__init__(logging.INFO)
        self.lines = []

    def emit(self, record):
        self.lines.append(record.getMessage())


def numbers(run):
    """What must not depend on ranks."""
    return {
        "displacement": run.response.displacement,
        "acceleration": run.response.acceleration,
        "kinetic": run.energy.kinetic,
        "elastic": run.energy.elastic,
        "damped": run.energy.damped,
        "input": run.energy.input,
        "residual": run.energy.residual,
    }


def responses(comm, given, folder):
    """The full model, on several ranks interrupted as well; one rank leaves a checkpoint."""
    model = assemble_building(comm, given["parts"])
    K = model.stiffness(given["storey_factor"])
    loads, nodes, damping = given["loads"], given["nodes"], given["damping"]
    patterns = loads.patterns(model, given["parts"].mesh)

    def full(name, until=2.0):
        def progress(part):
            if part > until:
                raise KilledError

        try:
            return run_full(
                FullModel(model, K, damping),
                loads,
                patterns,
                Displacements(model, nodes),
                Resumption(folder / name, "key", 25),
                progress,
            )
        except KilledError:
            return None

    if comm.size == 1:
        full("left for others", 0.6)
        return {"full": numbers(full("alone"))}
    found, log, level = {}, Lines(), LOGGER.level
    LOGGER.addHandler(log)
    LOGGER.setLevel(logging.INFO)
    # What another number of ranks has left here is of no use.
    found["full"] = numbers(full("left"))
    found["log of what was left"] = list(log.lines)
    log.lines.clear()
    full("interrupted", 0.6)
    found["resumed"] = numbers(full("interrupted"))
    found["log of the resumed"] = list(log.lines)
    log.lines.clear()
    full("damaged", 0.6)
    if comm.rank == comm.size - 1:
        (path,) = (folder / "damaged").glob(f"rank_{comm.rank}_*.npz")
        path.write_bytes(path.read_bytes()[:-1000])
    comm.barrier()
    found["again"] = numbers(full("damaged"))
    # Each rank reads its own file.
    found["log of the damaged"] = [line for lines in comm.allgather(log.lines) for line in lines]
    LOGGER.removeHandler(log)
    LOGGER.setLevel(level)
    return found


def results(given, folder):
    return responses(MPI.COMM_WORLD, given, folder)
