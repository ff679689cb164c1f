"""Reduces both buildings of a case on the ranks of this program; rank 0 computes their pounding."""

from pathlib import Path

import numpy as np

from impactfem.building.model import assemble_building
from impactfem.building.read_mesh import read_mesh
from impactfem.case import load_case
from impactfem.coupling.from_case import system_of
from impactfem.reduction.contact_line import contact_lines
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.pounding_3d import Pounding3D
from impactfem.reduction.reduced_building import reduce_building
from impactfem.stages.building.compute import mesh_of_run
from impactfem.stages.reduce.compute import prepare
from impactfem.stages.reduce.stage import storey_factor
from impactfem.system.parallel import communicator


def results(path, out, ground, step):
    """Forces of the points and accelerations of the floors."""
    case, out = load_case(Path(path)), Path(out)
    files = {name: mesh_of_run(one, one.folder(out)) for name, one in case.modelled.items()}
    models = {}
    for name, one in case.modelled.items():
        prepared = prepare(one, files[name], storey_factor(one.folder(out)), files)
        building = assemble_building(communicator(), prepared.parts)
        factor = prepared.storey_factor
        made = reduce_building(building, prepared.parts.mesh, factor, prepared.plan)
        models[name] = made.complete
    if communicator().rank > 0:
        return None
    lines = contact_lines(case, {name: read_mesh(file) for name, file in files.items()})
    pounding = Pounding3D(case, system_of(case, None), Models3D(lines, models))
    response = pounding.respond(np.asarray(ground), step)
    return response.point_force, response.acceleration
