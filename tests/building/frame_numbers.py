"""Numbers of the shipped frame: frequencies, mass, and the displacement under a load on an edge.

On any number of ranks; the first argument is the file that rank 0 writes.
"""

import json
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from impactfem.building.floor import edge_load
from impactfem.building.from_case import read_parts
from impactfem.building.model import assemble_building
from impactfem.case import load_case
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.modes import modes

GEOMETRY = Path(__file__).parents[2] / "geometry"


def frame_numbers(comm):
    """The numbers as a dictionary of lists. Collective."""
    case = load_case(GEOMETRY / "frame.toml")
    parts = read_parts(case.modelled["F"], GEOMETRY / "frame.msh")[0] if comm.rank == 0 else None
    parts = comm.bcast(parts)
    model = assemble_building(comm, parts)
    K = model.stiffness(0.5)
    load = edge_load(parts.mesh, 2).vector(model, (0.0, 1.0, 0.0))
    with Factorisation(K) as factor:
        u = factor.solve_block(load[:, None])[:, 0]
    everywhere = comm.allgather((model.nodes, u.reshape(-1, 6)))
    field = np.zeros((model.n_nodes, 6))
    for nodes, values in everywhere:
        field[nodes] = values
    return {
        "frequency": modes(K, model.mass, 20).frequency.tolist(),
        "mass": [float(model.total[0, 0])],
        "displacement": field[parts.mesh.centres[2]].tolist(),
    }


if __name__ == "__main__":
    found = frame_numbers(MPI.COMM_WORLD)
    if MPI.COMM_WORLD.rank == 0:
        Path(sys.argv[1]).write_text(json.dumps(found, indent=1), encoding="utf-8")
