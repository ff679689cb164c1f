"""Fixtures of small matrices and of a frame, and slabs without walls."""

import numpy as np
import pytest

from impactfem.building.mesh import BuildingMesh, Part
from impactfem.reduction.krylov import KrylovBasis

from ..coupling.conftest import siconos  # noqa: F401
from ..dynamics.conftest import chain, membrane, petsc  # noqa: F401
from ..stages.transient.conftest import basis, csc, frame, full_runs, loads, spectra  # noqa: F401

SHIFT = (2.0 * np.pi * 60.0) ** 2


@pytest.fixture
def krylov(membrane, petsc):  # noqa: F811
    """Make a Krylov basis of some block steps of the membrane with its loads."""

    def make(steps, model=None, *, loads=None, shift=SHIFT):  # noqa: F811
        model = model or membrane()
        made = KrylovBasis(petsc(model.K), petsc(model.M), shift)
        made.add(model.loads if loads is None else loads)
        made.grow(steps - 1)
        return made

    return make


def slabs(sides, side="y+", turn=0.0, edges=None, shift=None):
    """Slabs of 6 m by 4 m, two triangles each, so many or with an edge on each of these sides.

    The plan is turned about z, some slabs are shifted; only some may have edges.
    """
    every = (side,) * sides if isinstance(sides, int) else sides
    floors = len(every)
    square = np.array([[0, 0], [6, 0], [6, 4], [0, 4]], dtype=float)
    middles = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (2, 3): 7, (0, 3): 8}
    plan = np.vstack([square, [(square[a] + square[b]) / 2 for a, b in middles]])
    c, s = np.cos(turn), np.sin(turn)
    plan = plan @ np.array([[c, s], [-s, c]])
    nodes, triangles, lines = [], [], {}
    for k in range(1, floors + 1):
        first = 9 * (k - 1)
        moved = plan + (shift or {}).get(k, (0.0, 0.0))
        nodes.append(np.column_stack([moved, np.full(9, 3.0 * k)]))
        ends = {"y-": (0, 1), "x+": (1, 2), "y+": (2, 3), "x-": (0, 3)}[every[k - 1]]
        triangles.append(np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 6, 7, 8]]) + first)
        lines[k] = np.array([[*ends, middles[ends]]]) + first
    return BuildingMesh(
        nodes=np.vstack(nodes),
        triangles=np.vstack(triangles),
        triangle_part=np.repeat(np.arange(floors, dtype=np.int32), 2),
        lines=np.zeros((0, 3), dtype=np.int64),
        line_part=np.zeros(0, dtype=np.int32),
        shell_parts=tuple(Part("floor", k) for k in range(1, floors + 1)),
        beam_parts=(),
        edges={k: line for k, line in lines.items() if edges is None or k in edges},
        centres={k: 9 * (k - 1) + 6 for k in range(1, floors + 1)},
        base=np.zeros(0, dtype=np.int64),
    )
