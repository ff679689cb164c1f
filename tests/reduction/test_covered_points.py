"""The probes that envelopes of spectra cover."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from impactfem.building.read_mesh import read_mesh
from impactfem.case import Probe
from impactfem.reduction.covered_points import covered_points, moving_node
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def mesh():
    return read_mesh(GEOMETRY / "frame.msh")


def asked(*envelopes):
    probes = (
        Probe(name="corner", point=(6.0, 4.0, 6.0)),
        Probe(name="rim", group="edge_2"),
    )
    anchors = [SimpleNamespace(envelope=names) for names in envelopes]
    return SimpleNamespace(
        path=Path("case.toml"),
        wave_floor=None,
        transient=SimpleNamespace(probes=probes),
        devices=[SimpleNamespace(anchors=anchors)],
    )


def test_names_and_patterns_by_anchor(mesh):
    found = covered_points(asked(("corner", "centre_*"), (), ("centre_2", "rim_1")), mesh)
    assert set(found.names) == {"centre_1", "centre_2", "corner", "rim_1"}
    names = [[found.names[k] for k in points] for points in found.of_anchor]
    assert names[0] == ["centre_1", "centre_2", "corner"] and names[1] == []
    assert set(names[2]) == {"centre_2", "rim_1"}
    node = found.nodes[found.names.index("corner")]
    assert mesh.nodes[node] == pytest.approx([6.0, 4.0, 6.0])


def test_nothing_asked(mesh):
    found = covered_points(asked((), ()), mesh)
    assert (found.nodes, found.of_anchor) == ((), ((), ()))


def test_a_probe_that_the_mesh_has_not(mesh):
    """How many nodes a group has only the mesh knows."""
    with pytest.raises(InputError, match=r"envelope = 'rim_999': expected a probe that is in the"):
        covered_points(asked(("corner", "rim_999")), mesh)


def test_a_node_that_follows_moves_with_its_master():
    plate = SimpleNamespace(master=3, followers=[4, 5])
    assert [moving_node(k, [plate]) for k in (3, 5, 9)] == [3, 3, 9]
