"""Reduced bases that hold the loads of all members together.

The response is linear in the loads. A basis that lacks some of them, as one that was made for the
floors that the case's own motion hits, is used again for those that it has; a further basis has the
others, and the accelerations add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.model import assemble_building
from impactfem.case.transient import Transient
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.loads import EdgeForce, Loads
from impactfem.reduction.reduced_basis import ReducedBasis, build_basis
from impactfem.reduction.response import modal_histories
from impactfem.stages.transient.prepared import Prepared

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def shares(bases: Sequence[ReducedBasis], loads: Loads) -> list[Loads]:
    """What of the loads each basis bears: each load goes to the first one that has it.

    Args:
        bases: The bases; the first one has the ground motion in all its directions.
        loads: The loads.

    Raises:
        KeyError: No basis has one of the loads.
    """
    ground = tuple(f"ground {'xyz'[c]}" for c in loads.directions)
    lacking = [name for name in ground if name not in bases[0].loads]
    bearer: dict[str, int] = {}
    for edge in loads.edges:
        having = [k for k, basis in enumerate(bases) if edge.name in basis.loads]
        if having:
            bearer[edge.name] = having[0]
        else:
            lacking.append(edge.name)
    if lacking:
        raise KeyError(f"no reduced basis has the load {', '.join(lacking)}")
    found = []
    for k in range(len(bases)):
        columns = [j for j, edge in enumerate(loads.edges) if bearer[edge.name] == k]
        one = replace(
            loads,
            edges=tuple(loads.edges[j] for j in columns),
            force=np.ascontiguousarray(loads.force[:, columns]),
            external=None if loads.external is None else loads.external[:, columns],
        )
        still = replace(one, directions=(), ground=np.zeros_like(loads.ground))
        found.append(one if k == 0 else still)
    return found


@dataclass(frozen=True, eq=False)
class ModalShare:
    """What one basis gives of a motion.

    Args:
        basis: The basis.
        loads: Its share of the loads; the ground moves in the share of the first basis alone.
        acceleration: q'' of its finest model under them, shape (r, n_t).
    """

    basis: ReducedBasis
    loads: Loads
    acceleration: Array


def modal_shares(
    bases: Sequence[ReducedBasis], loads: Loads, damping: Rayleigh
) -> list[ModalShare]:
    """Modal accelerations of several bases that add up to a motion.

    Args:
        bases: As of `shares`.
        loads: The loads.
        damping: The damping.

    Raises:
        KeyError: No basis has one of the loads.
    """
    return [
        ModalShare(basis, share, modal_histories(basis, share, damping).acceleration)
        for basis, share in zip(bases, shares(bases, loads), strict=True)
        if share.names
    ]


def records_of(
    motion: Sequence[ModalShare], nodes: Index, components: Index, *, roughly: bool = False
) -> Array:
    """Absolute accelerations of some nodes, each along one direction, shape (n, n_t) [m/s2].

    Args:
        motion: As of `modal_shares`.
        nodes: Nodes that all bases were made for, shape (n,).
        components: 0, 1 or 2 for x, y, z, shape (n,).
        roughly: Whether single precision is enough, which takes half the time.

    Raises:
        KeyError: A basis was not made for a node.
    """
    kind = np.float32 if roughly else np.float64
    found: Array = np.zeros((len(nodes), len(motion[0].loads.ground)))
    for one in motion:
        shapes = one.basis.of(one.basis.model, nodes)[np.arange(len(nodes)), components]
        found += shapes.astype(kind) @ one.acceleration.astype(kind)
        found += one.loads.ground.T[components]
    return found


def at_nodes(basis: ReducedBasis, nodes: Index) -> ReducedBasis:
    """The finest model of a basis with its shapes at some nodes alone, for other processes."""
    kept = np.unique(nodes)
    vectors = basis.rows(kept)[..., : len(basis.model.coordinates)]
    return replace(basis, models=basis.models[:1], larger=(), nodes=kept, vectors=vectors)


def lacking(
    basis: ReducedBasis | None, loads: Sequence[Loads]
) -> tuple[list[int], list[EdgeForce]]:
    """Directions of the ground and forces on edges that members have and a basis has not.

    Args:
        basis: The basis; None when there is none.
        loads: Of the members.
    """
    known = () if basis is None else basis.loads
    directions = sorted({c for one in loads for c in one.directions})
    edges = {edge.name: edge for one in loads for edge in one.edges}
    return (
        [c for c in directions if f"ground {'xyz'[c]}" not in known],
        [edges[name] for name in sorted(edges) if name not in known],
    )


def further_basis(
    transient: Transient,
    prepared: Prepared,
    comm: Any,
    directions: Sequence[int],
    edges: Sequence[EdgeForce],
    nodes: Index,
    step: Any,
    within: Any,
) -> ReducedBasis:
    """A basis for further loads, as accurate as is asked at the probes. Collective.

    Args:
        transient: Says how accurate it is to be.
        prepared: The building and its probes.
        comm: Communicator of the matrices.
        directions: Components of the ground that it is to have.
        edges: Forces on edges that it is to have.
        nodes: Nodes that it is to be made for, the probes among them, ascending.
        step: Called with "matrices" and "basis", which run inside its context.
        within: Called with the name of a step and the part of it that is done.

    Raises:
        SolutionError: It does not reach its tolerance with the most vectors.
    """
    loads = Loads(
        time_step=transient.time_step,
        ground=np.zeros((1, 3)),
        directions=tuple(directions),
        edges=tuple(edges),
        force=np.zeros((1, len(edges))),
        impulse_error=0.0,
    )
    with step("matrices"):
        model = assemble_building(comm, prepared.parts)
        K = model.take_stiffness(prepared.storey_factor)
        patterns = loads.patterns(model, prepared.parts.mesh, transient.eccentricity)
    with step("basis"):
        return build_basis(
            model,
            K,
            patterns,
            loads.names,
            probes=np.array([probe.node for probe in prepared.probes]),
            nodes=nodes,
            damping=prepared.damping,
            maximum_frequency=transient.maximum_frequency,
            shift=transient.shift,
            tolerance=transient.tolerance,
            largest=transient.largest_basis,
            progress=lambda part: within("basis", part),
        )
