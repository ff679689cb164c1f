"""The 3D models of a case that pound, as bodies.

A body moves with its base: by the ground where it is clamped, by a raft on soil otherwise. Its base
coordinates are about the middle of the clamped nodes, under which the raft is centred.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from impactfem.building.mesh import DOFS, rigid_body
from impactfem.coupling.body import Body, Port
from impactfem.dynamics.damping import DampingLaw
from impactfem.dynamics.soil import Soil
from impactfem.reduction.contact_line import ContactLine
from impactfem.reduction.contact_points import Side
from impactfem.reduction.edge_force import EdgeForce, Shares
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.system.arrays import Array

MASTERS = "masters"
"""Port of a building: the mass centres of its floors; of a stick all of its masters."""
LOWEST = 200
"""Modes of a building on a clamped base that are counted for those on soil. Of the paper's pair on
soil of 400 m/s they give the first frequencies within 4e-5, their damping within 6e-5."""


@dataclass(frozen=True, eq=False)
class Models3D:
    """The 3D models that pound, and the lines along which they touch."""

    lines: tuple[ContactLine, ...]
    models: Mapping[str, CompleteModel]  #: by building; its last points are the floors' centres
    #: Outward normal of the edge, shape (3,), and patterns that push it inwards, by building and
    #: loaded floor.
    pushes: Mapping[tuple[str, int], tuple[Array, Shares]] = field(default_factory=dict)

    def body(
        self,
        name: str,
        floors: int,
        damping: DampingLaw,
        soil: Soil | None,
        ports: Mapping[str, Port],
    ) -> Body:
        """Return a building as a body, with further ports.

        Args:
            name: Its name.
            floors: Number of its floors.
            damping: Its damping.
            soil: Raft and soil about the middle of the base; None where it is clamped.
            ports: Further ports.
        """
        model, to_origin = self.models[name], self._to_origin(name)
        Φ, R = (x[-floors:] for x in (model.points, model.points_carried))
        masters = Port(Φ.reshape(-1, Φ.shape[-1]), R.reshape(-1, DOFS) @ to_origin)
        raft = 0.0 if soil is None else soil.raft
        return Body(
            name=name,
            eigenvalue=model.eigenvalue,
            damping=damping,
            participation=-model.ground @ to_origin,
            rigid_mass=to_origin.T @ model.rigid_mass @ to_origin + raft,
            ports={MASTERS: masters, **ports},
            free_base=soil is not None,
            soil=soil,
        )

    def touched(self, side: Side) -> Port:
        """Return the motion of the points of a side along its normal."""
        port = self.along(side.at.building, side.end.forces)
        # Forces push inwards, on the first building against the normal.
        share = side.sign * side.share.T
        return Port(share @ port.shapes, share @ port.rigid)

    def pushed(self, name: str, floor: int) -> tuple[Array, Port]:
        """Return the outward normal of a loaded edge, and the motion on which its load works."""
        outward, shares = self.pushes[name, floor]
        port = self.along(name, [force for force, _ in shares])
        share = -np.array([[share for _, share in shares]])
        return outward, Port(share @ port.shapes, share @ port.rigid)

    def along(self, name: str, forces: Sequence[EdgeForce]) -> Port:
        """Return the motion of a building along patterns of forces."""
        model = self.models[name]
        column = {str(known): k for k, known in enumerate(model.names)}
        at = [column[force.name] for force in forces]
        return Port(model.edges[:, at].T, model.wrench[at] @ self._to_origin(name))

    def _to_origin(self, name: str) -> Array:
        """From a motion of the base to that of the origin of the mesh, shape (6, 6)."""
        return np.asarray(rigid_body(np.zeros((1, 3)), self.models[name].base))


def lowest(body: Body) -> Body:
    """Return a body with its `LOWEST` modes; the others follow its base."""
    kept = np.argsort(body.eigenvalue)[:LOWEST]
    mass = None if body.mass is None else body.mass[kept]
    return Body(
        name=body.name,
        eigenvalue=body.eigenvalue[kept],
        damping=body.damping,
        participation=body.participation[kept],
        rigid_mass=body.rigid_mass,
        mass=mass,
        free_base=body.free_base,
        soil=body.soil,
    )
