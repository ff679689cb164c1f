"""The motion of the floors of a 3D model at the items of an equipment list."""

from __future__ import annotations

import numpy as np

from impactfem.building.mesh import BuildingMesh, side_lengths
from impactfem.case import BuildingInTime
from impactfem.case.equipment import Equipment
from impactfem.case.facade import axis_in_plan
from impactfem.case.transient import OUTSIDE
from impactfem.reduction.response import node_response
from impactfem.stages.equipment.motion import FloorMotions
from impactfem.stages.transient.reduced_run import ReducedRun
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError


def model_motions(
    building: BuildingInTime, mesh: BuildingMesh, run: ReducedRun, end: float
) -> FloorMotions:
    """Return the motions of the floors of a 3D model, at the vertex nearest to an item.

    Args:
        building: The building.
        mesh: Its mesh.
        run: Its reduced model under ground motion and impacts.
        end: End of the resolved band [Hz].
    """
    quiet, nodes = run.without_impact(), item_nodes(building, mesh)

    def samples(item: Equipment, impacts: bool) -> Array:
        used = run if impacts else quiet
        node = np.array([nodes[item.tag]])
        response = node_response(used.basis, used.history, used.loads, node)
        return np.ascontiguousarray(response.acceleration[:, 0].T)

    return FloorMotions(
        model="structure",
        end=end,
        mass={one.floor: one.mass for one in building.entry.floors},
        step=run.loads.time_step,
        samples=samples,
    )


def item_nodes(building: BuildingInTime, mesh: BuildingMesh) -> dict[str, int]:
    """Return the vertex of the slab nearest to each item of a building, by tag.

    Raises:
        InputError: With a fault for each item that is off its floor.
    """
    items = [one for one in building.case.equipment if one.building == building.name]
    farthest = max(OUTSIDE, 0.5 * float(side_lengths(mesh.nodes, mesh.triangles).mean()))
    plan = mesh.nodes[np.unique(mesh.triangles)][:, :2]
    low, high = plan.min(axis=0), plan.max(axis=0)
    axis = building.entry.axis
    shift = np.array(axis_in_plan(axis, tuple(low), tuple(high))) - axis
    found: dict[str, int] = {}
    faults = []
    for item in items:
        vertices = _slab_vertices(mesh, item.floor)
        at = np.array([item.x, item.y]) + shift
        distance = np.linalg.norm(mesh.nodes[vertices, :2] - at, axis=1)
        nearest = int(distance.argmin())
        found[item.tag] = int(vertices[nearest])
        if distance[nearest] > farthest:
            expected = (
                f"expected x and y on floor {item.floor} of {building.name}: the nearest vertex of "
                f"its mesh is {distance[nearest]:.3g} m away"
            )
            faults.append(Fault(building.case.path, "equipment", item.tag, expected))
    if faults:
        raise InputError(faults)
    return found


def _slab_vertices(mesh: BuildingMesh, floor: int) -> Index:
    return np.asarray(np.unique(mesh.triangles[mesh.slab(floor), :3]), dtype=np.int64)
