from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.building.assembly import number_nodes
from impactfem.system.errors import SolutionError

TRIANGLES = np.array([[0, 1, 2, 3, 4, 5], [2, 1, 6, 4, 7, 8]])
LINES = np.array([[6, 9, 10]])


def of_ranks(size, *parts, n_nodes=11):
    comms = [SimpleNamespace(rank=rank, size=size) for rank in range(size)]
    ranks = [np.array(part) for part in parts]
    return [number_nodes(comm, n_nodes, [TRIANGLES, LINES], ranks) for comm in comms]


def test_a_shared_node_is_of_the_lowest_rank():
    zero, one, two = of_ranks(3, [2, 0], [1])
    # Rank 0 has the second triangle, rank 1 the line but not its shared end.
    assert sorted(zero.owned) == [1, 2, 4, 6, 7, 8]
    assert sorted(one.owned) == [9, 10]
    assert sorted(two.owned) == [0, 3, 5]


def test_rows_follow_the_ranks():
    numberings = of_ranks(3, [2, 0], [1])
    order = np.concatenate([numbering.owned for numbering in numberings])
    for numbering in numberings:
        assert sorted(numbering.place) == list(range(11))
        assert numbering.place[order].tolist() == list(range(11))


def test_a_rank_without_cells():
    numberings = of_ranks(4, [3, 3], [1])
    assert [len(numbering.owned) for numbering in numberings] == [0, 3, 0, 8]


def test_one_rank_keeps_the_order_of_the_mesh():
    (alone,) = of_ranks(1, [0, 0], [0])
    assert alone.place.tolist() == alone.owned.tolist() == list(range(11))


def test_a_node_without_cells():
    with pytest.raises(SolutionError, match="node 11 belongs to no shell and no beam"):
        of_ranks(1, [0, 0], [0], n_nodes=13)
