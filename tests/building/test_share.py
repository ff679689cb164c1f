"""A rank's share of a building."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from impactfem.building.assembly import shared_out
from impactfem.building.model import assemble_building
from impactfem.building.parts import BeamCells, BuildingParts


@dataclass(frozen=True)
class OneOf:
    """Stands for a rank of several, where nothing is sent."""

    rank: int
    size: int


def test_each_cell_on_one_rank(house: BuildingParts) -> None:
    shares = [shared_out(OneOf(rank, 3), house) for rank in range(3)]
    for k, kind in enumerate(shares[0].kinds):
        cells = np.concatenate([share.mine[k] for share in shares])
        assert np.array_equal(np.sort(cells), np.arange(len(kind.cells)))
    owned = np.concatenate([share.numbering.owned for share in shares])
    assert np.array_equal(np.sort(owned), np.arange(len(house.mesh.nodes)))
    assert all(share.mine[0].size for share in shares)


def test_free_rows(house: BuildingParts) -> None:
    share = shared_out(MPI.COMM_SELF, house)
    model = assemble_building(MPI.COMM_SELF, house)
    assert share.free.sum() == model.n_free < 6 * len(house.mesh.nodes)
    nodes = share.numbering.owned[share.free[::6]]
    assert np.array_equal(nodes, model.nodes)
    assert not np.isin(nodes, house.mesh.base).any()


def test_parts_of_the_cells(house: BuildingParts) -> None:
    mesh = house.mesh
    for kind in shared_out(MPI.COMM_SELF, house).kinds:
        parts = mesh.beam_parts if isinstance(kind, BeamCells) else mesh.shell_parts
        assert {parts[p].scaled for p in np.unique(kind.part)} == {kind.storey}
        cells, of_cell = (
            (mesh.lines, mesh.line_part)
            if isinstance(kind, BeamCells)
            else (mesh.triangles, mesh.triangle_part)
        )
        known = {tuple(cell): part for cell, part in zip(cells, of_cell, strict=True)}
        assert [known[tuple(cell)] for cell in kind.cells] == list(kind.part)
