"""Points beside the anchors that envelopes of spectra cover: probes of the stage `transient`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.links import BasePlate
from impactfem.building.mesh import DOFS, BuildingMesh, rigid_body
from impactfem.building.model import BuildingModel
from impactfem.case import Case
from impactfem.case.devices import chosen
from impactfem.reduction.probes import checked_probes
from impactfem.system.errors import Fault, InputError

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class CoveredPoints:
    """Points of the mesh."""

    names: tuple[str, ...]  #: Of the probes.
    nodes: tuple[int, ...]  #: Their nodes.
    #: Of each anchor of the devices, numbers of the points that it covers.
    of_anchor: tuple[tuple[int, ...], ...]


def covered_points(case: Case, mesh: BuildingMesh) -> CoveredPoints:
    """Find the points that the devices of a case ask for.

    Raises:
        InputError: The mesh has none of the probes that a name or a pattern stands for, or a probe
            of the case is not in the mesh.
    """
    patterns = [
        (f"devices[{index}]", anchor.envelope)
        for index, device in case.numbered_devices
        for anchor in device.anchors
    ]
    if case.transient is None or not any(wanted for _, wanted in patterns):
        return CoveredPoints((), (), tuple(() for _ in patterns))
    probes = {one.name: one.node for one in checked_probes(case, mesh)}
    faults = [
        Fault(case.path, f"{key}.envelope", pattern, "expected a probe that is in the mesh")
        for key, wanted in patterns
        for pattern in wanted
        if not chosen(list(probes), [pattern])
    ]
    if faults:
        raise InputError(faults)
    names = chosen(list(probes), [p for _, wanted in patterns for p in wanted])
    return CoveredPoints(
        names=tuple(names),
        nodes=tuple(probes[name] for name in names),
        of_anchor=tuple(
            tuple(names.index(name) for name in chosen(names, wanted)) for _, wanted in patterns
        ),
    )


def point_rows(
    model: BuildingModel, mesh: BuildingMesh, nodes: Sequence[int], base_plates: Sequence[BasePlate]
) -> scipy.sparse.csr_matrix:
    """What takes the motion of points from the degrees of freedom, at this rank's rows.

    Args:
        model: The building with the base plates.
        mesh: Its mesh.
        nodes: The points' nodes; one that follows a base plate moves as it does, one of the base
            does not move.
        base_plates: The base plates.

    Returns:
        Shape (n_local, 6 n).
    """
    rows = scipy.sparse.lil_matrix((DOFS * len(model.nodes), DOFS * len(nodes)))
    for k, node in enumerate(nodes):
        master = moving_node(node, base_plates)
        row = int(model.rows(np.array([master]))[0])
        if row >= 0:
            motion = rigid_body(mesh.nodes[node : node + 1], mesh.nodes[master])
            rows[row : row + DOFS, DOFS * k : DOFS * (k + 1)] = motion.T
    return scipy.sparse.csr_matrix(rows)


def moving_node(node: int, base_plates: Sequence[BasePlate]) -> int:
    """The master of the base plate that a node follows, or the node."""
    return next((one.master for one in base_plates if node in one.followers), node)
