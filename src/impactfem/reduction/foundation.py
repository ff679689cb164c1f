"""A reduced building on soil: its base moves, and shakes the rest as the ground does.

With the motion b of the base about the origin, relative to the ground, the building moves by
Φ z + R b, and z obeys the modal equations under the acceleration g̈ + b̈ of its base. b comes first:
z, b and the soil together by the average acceleration rule, in sub-steps of the samples. With b̈
known, z is integrated as on a clamped base. The reduced building knows its loads under six motions
of the base, its rigid mass and the resultants of its load patterns; any soil can stand below it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from impactfem.coupling.base import BaseHistory, base_histories
from impactfem.coupling.body import Body, Port
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.links import Assembly
from impactfem.dynamics.damping import DampingLaw
from impactfem.dynamics.soil import Soil
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import ModalHistory, modal_response
from impactfem.reduction.reduced import ReducedModel
from impactfem.system.arrays import Array

SUBSTEPS = 5
"""Steps of the integration of the base in one sample. Odd: what the rule leaves of very stiff soil
changes its sign from sample to sample, and moves nothing."""
GROUND = tuple(f"ground {component}" for component in ("x", "y", "z", "rx", "ry", "rz"))
"""Names of the load patterns of the motions of the base."""


@dataclass(frozen=True, eq=False)
class Foundation:
    """Raft and soil below a reduced building."""

    soil: Soil  #: with the raft, about the origin of the mesh
    rigid_mass: Array  #: of the building about the origin, shape (6, 6) [kg, kg m, kg m2]
    wrench: Mapping[str, Array]  #: resultant of each pattern of forces about it, shape (6,)

    def body(
        self,
        eigenvalue: Array,
        ground: Array,
        damping: DampingLaw,
        ports: Mapping[str, tuple[Array, Array]],
    ) -> Body:
        """The building on its soil.

        By λ, shape (r,) [1/s2], modal loads of unit accelerations of the base, shape (r, 6), and
        of each port Φ, shape (k, r), and its motion with the base, shape (k, 6).
        """
        return Body(
            name="building",
            eigenvalue=eigenvalue,
            damping=damping,
            participation=-ground,
            rigid_mass=self.rigid_mass + self.soil.raft,
            ports={name: Port(Φ, R) for name, (Φ, R) in ports.items()},
            free_base=True,
            soil=self.soil,
        )

    def loads(self, body: Body, edges: Array, loads: Loads) -> Array:
        """Forces on all coordinates of the body, shape (n_t, r + 6).

        By the modal loads of the patterns of forces of the loads, shape (r, n_edges).
        """
        ground = Assembly([body]).ground
        wrench = np.array([self.wrench[edge.name] for edge in loads.edges]).reshape(-1, 6)
        pattern = np.concatenate([edges, (wrench @ Assembly.base_motion(body)).T])
        return np.asarray(loads.ground @ ground.T + loads.force @ pattern.T)

    def history(
        self,
        model: ReducedModel,
        names: Sequence[str],
        loads: Loads,
        damping: DampingLaw,
        scheme: str = "exact",
    ) -> ModalHistory:
        """Modal coordinates, and after them the six of the base, (r + 6, n_t) each.

        Raises:
            KeyError: The model has no pattern of one of the loads, or of a motion of the base.
        """
        lacking = [name for name in (*GROUND, *(e.name for e in loads.edges)) if name not in names]
        if lacking:
            raise KeyError(f"the reduced basis has no load {lacking[0]}")
        base = _base_motion(self, model, tuple(names), loads, damping)
        amplitudes = np.zeros((len(loads.ground), len(names)))
        shaken = base.a + np.pad(loads.ground, ((0, 0), (0, 3)))
        amplitudes[:, [names.index(name) for name in GROUND]] = shaken
        amplitudes[:, [names.index(edge.name) for edge in loads.edges]] = loads.force
        own = modal_response(model, amplitudes, loads.time_step, damping, scheme=scheme)
        return ModalHistory(
            np.concatenate([own.displacement, base.u.T]),
            np.concatenate([own.velocity, base.v.T]),
            np.concatenate([own.acceleration, base.a.T]),
        )


@lru_cache(maxsize=8)
def _base_motion(
    below: Foundation,
    model: ReducedModel,
    names: tuple[str, ...],
    loads: Loads,
    damping: DampingLaw,
) -> BaseHistory:
    # Kept: histories of displacements, of rotations and of their bands need the same.
    column = {name: k for k, name in enumerate(names)}
    body = below.body(
        model.eigenvalue, model.load[:, [column[name] for name in GROUND]], damping, {}
    )
    edges = model.load[:, [column[edge.name] for edge in loads.edges]]
    assembly = Assembly([body])
    forces, none = below.loads(body, edges, loads), np.zeros(0, dtype=np.int64)
    motion = respond(
        assembly,
        forces,
        loads.ground,
        loads.time_step,
        substeps=SUBSTEPS,
        start=Start(recorded=none),
    )
    return base_histories(assembly, motion.attached, loads.time_step)[body.name]
