"""Fields over the floors of the frame, and the waves on its top floor."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.reduction.probes import floor_vertices, recorded_nodes, wave_slab
from impactfem.reduction.response import modal_histories, node_response, node_spectra
from impactfem.stages.transient.maps import AT_ONCE, floor_maps, membrane_force
from impactfem.stages.transient.reduced_run import ReducedRun

from .conftest import HIGHEST

IMPACT = (0.3, 0.32)


@pytest.fixture(scope="module")
def make(frame, loads, basis, spectra):
    def made(**changes):
        run = ReducedRun(basis, loads, frame.damping, spectra, HIGHEST)
        return floor_maps(frame.parts, run, **{"main_impact": IMPACT, "direction": 1} | changes)

    return made


@pytest.fixture(scope="module")
def maps(make):
    return make()


@pytest.fixture(scope="module")
def at(frame, loads, basis):
    """The response at nodes."""
    return partial(node_response, basis, modal_histories(basis, loads, frame.damping), loads)


def test_nodes(frame, maps):
    """Corners of the slabs' triangles, and all nodes of the top slab."""
    mesh = frame.parts.mesh
    z = mesh.nodes[:, 2]
    corners = np.zeros(len(z), dtype=bool)
    corners[mesh.triangles[:, :3]] = True
    assert np.array_equal(maps.node_number.values, np.flatnonzero(corners & np.isin(z, [3.0, 6.0])))
    assert np.array_equal(maps.wave_node_number.values, np.flatnonzero(z == 6.0))
    waves = maps.wave_node_number.values
    slab = mesh.triangles[mesh.triangles_of("floor", 2)]
    assert np.array_equal(waves[maps.wave_triangle_node.values], slab[:, :6])
    every = recorded_nodes(mesh, frame.nodes)
    assert {*frame.nodes, *maps.node_number.values, *waves} == set(every.tolist())
    assert np.array_equal(floor_vertices(mesh), maps.node_number.values)


def test_low_walls_on_the_wave_slab_make_no_waves(frame):
    """The wall of storey 2 as a part of floor 2: it has spectra, and no membrane force along y."""
    mesh = frame.parts.mesh
    names = [str(part) for part in mesh.shell_parts]
    parts = list(mesh.shell_parts)
    wall = next(k for k, part in enumerate(parts) if (part.family, part.level) == ("storey", 2))
    parts[wall] = Part("floor", 2, "parapet")
    other = replace(mesh, shell_parts=tuple(parts))
    assert [str(part) for part in other.shell_parts] != names
    for before, after in zip(wave_slab(mesh), wave_slab(other), strict=True):
        assert np.array_equal(before, after)
    added = np.setdiff1d(floor_vertices(other), floor_vertices(mesh))
    assert len(added) and np.all((mesh.nodes[added, 2] > 3.0) & (mesh.nodes[added, 2] < 6.0))


def test_spectra_are_those_of_the_nodes(at, spectra, maps):
    """More nodes than are taken at once; at the first damping, from the records as they are."""
    found = maps
    assert found.sizes["node"] > 80 and found.psa.dtype == np.float32
    assert found.damping == 0.05 and found.sizes["frequency"] > 60
    chosen = np.array([0, 7, found.sizes["node"] - 1])
    response = at(found.node_number.values[chosen])
    asked = spectra.model_copy(
        update={"frequencies": tuple(found.frequency.values), "points_per_cycle": 2}
    )
    expected = node_spectra(response, asked)
    psa = expected.psa[0].reshape(3, 3, -1)
    assert found.psa.values[chosen] == pytest.approx(psa, rel=1e-5)
    assert found.pfa.values[chosen] == pytest.approx(expected.zpa.reshape(3, 3), rel=1e-12)
    assert found.points_per_cycle == expected.points_per_cycle == 10.0  # 200 Hz at 0.5 ms


def test_nodes_come_in_their_order_across_blocks(maps, make, monkeypatch):
    assert maps.sizes["node"] < AT_ONCE
    monkeypatch.setattr("impactfem.stages.transient.maps.AT_ONCE", 7)
    told = []
    again = make(progress=told.append)
    assert again.psa.values == pytest.approx(maps.psa.values, rel=1e-5)
    assert again.pfa.values == pytest.approx(maps.pfa.values, rel=1e-9)
    assert told == sorted(told) and told[-1] == 1.0 and len(told) == -(-maps.sizes["node"] // 7)


def test_snapshots(frame, at, maps):
    """At the beginning, in the middle and at the end of the impact."""
    assert maps.snapshot.values == pytest.approx([0.30, 0.31, 0.32])
    response = at(maps.wave_node_number.values)
    steps = [600, 620, 640]
    assert maps.wave_displacement.values == pytest.approx(response.displacement[steps], abs=1e-12)
    assert maps.wave_acceleration.values == pytest.approx(response.acceleration[steps], abs=1e-8)
    late = response.acceleration[[601, 621, 641]]
    assert np.abs(maps.wave_acceleration.values - late).max() > 1e-3
    # The impact presses the slab at its edge.
    edge = np.argmax(frame.parts.mesh.nodes[maps.wave_node_number.values, 1])
    assert maps.wave_acceleration.values[1, edge, 1] < maps.wave_acceleration.values[0, edge, 1]
    assert maps.membrane_force.values[1].mean() < 0.0


@pytest.mark.parametrize(
    ("impact", "times"), [((0.3, 0.3004), [0.3, 0.3005]), ((0.799, 0.9), [0.799, 0.8])]
)
def test_snapshots_of_a_short_impact_and_at_the_end(make, impact, times):
    assert make(main_impact=impact).snapshot.values == pytest.approx(times)


def test_frames(at, maps):
    """Slow motion from 10 ms before the impact to 30 ms after it: every fourth step of 0.5 ms.

    Before and after it, each 20 ms.
    """
    slow = np.arange(580, 701, 4)
    steps = np.array([*range(20, 580, 40), *slow, *range(slow[-1] + 40, slow[-1] + 601, 40)])
    assert maps.frame.values == pytest.approx(steps * 0.0005)
    response = at(maps.node_number.values)
    for name, expected in (
        ("frame_acceleration", response.acceleration[steps, :, 1]),
        ("frame_displacement", response.displacement[steps]),
    ):
        assert maps[name].dtype == np.float32
        assert maps[name].values == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("impact", "first", "last"), [((0.002, 0.3), 0.0, 0.6245), ((0.7, 0.79), 0.39, 0.8)]
)
def test_frames_are_few_and_inside_of_the_record(make, impact, first, last):
    times = make(main_impact=impact).frame.values
    assert len(times) <= 70
    slow = times[(times > impact[0] - 0.01) & (times < impact[1])]
    assert np.diff(slow) == pytest.approx(np.diff(slow)[0])
    assert np.diff(times).min() > 0.0 and np.diff(times).max() == pytest.approx(0.02)
    assert times[0] == pytest.approx(first) and last - 0.02 <= times[-1] <= last


def test_without_impact(frame, maps, make):
    none = make(main_impact=None)
    assert none.snapshot.values.shape == (0,)
    assert none.wave_displacement.shape == none.wave_acceleration.shape == (0, 245, 3)
    assert none.frame.values.shape == (0,) and none.frame_displacement.shape[0] == 0
    assert none.membrane_force.shape == (0, maps.sizes["wave_triangle"])
    assert np.array_equal(none.pfa.values, maps.pfa.values)


def test_membrane_force_of_a_known_displacement(frame):
    """N_y = E t (a + ν b) / (1 − ν²) for u_y = a y and u_x = b x, whatever else the slab does."""
    mesh = frame.parts.mesh
    triangles, nodes = wave_slab(mesh)
    x, y, _ = mesh.nodes[nodes].T
    a, b, shear, turn = 1e-4, -3e-5, 2e-5, 7e-5

    def force(ux, uy):
        u = np.stack([ux, uy, np.sin(3 * x)], axis=-1)
        return membrane_force(frame.parts, triangles, nodes, u[None])[0]

    plane = 33e9 * 0.2 / (1.0 - 0.2**2)
    straight = force(b * x, a * y)
    assert straight == pytest.approx(np.full(len(triangles), plane * (a + 0.2 * b)), rel=1e-9)
    moved = force(b * x + (shear - turn) * y + 0.3, a * y + (shear + turn) * x - 0.2)
    assert moved == pytest.approx(straight, rel=1e-7)
    # x and y are not the same, and the force is along y.
    assert force(a * x, b * y) == pytest.approx(
        np.full(len(triangles), plane * (b + 0.2 * a)), rel=1e-9
    )
    # Of a bent field it is that at the centres: six-node triangles hold it exactly.
    centre = mesh.nodes[mesh.triangles[triangles, :3]].mean(axis=1)
    bent = force(1e-4 * x * y, 1e-4 * (y**2 + x * y))
    strain = 1e-4 * (2 * centre[:, 1] + centre[:, 0]), 1e-4 * centre[:, 1]
    assert bent == pytest.approx(plane * (strain[0] + 0.2 * strain[1]), rel=1e-9)
