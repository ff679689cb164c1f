"""A heavy device on the shipped frame: the reduced study against the full order."""

import re
from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI
from scipy.sparse.linalg import splu

from impactfem.building.links import linked
from impactfem.building.model import assemble_building
from impactfem.case import load_case
from impactfem.case.damping import RayleighCase
from impactfem.coupling.body import reduced_body
from impactfem.device.mounted import MountedDevice, mounted_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.reduction.wall import Wall
from impactfem.stages.device.compute import damped_case

from .conftest import FACTOR, STEP, plan_of, reduced_frame, scipy_matrix, shaken_and_hit


@pytest.fixture(scope="module")
def plan(frame, base_plate):
    return plan_of(frame, [base_plate], wall=Wall((1, 2), 2, "whole_floor"))


@pytest.fixture(scope="module")
def whole(frame, plan):
    return reduced_frame(frame, plan)


@pytest.fixture(scope="module")
def reduced(whole):
    return whole.complete


def mounted(reduced, device, damping):
    force, ground = shaken_and_hit()
    load = np.column_stack(
        [reduced.ground[:, 1], reduced.edges[:, list(reduced.names).index("floor 2")]]
    )
    return mounted_response(
        [reduced_body("building", reduced.eigenvalue, damping, {"anchor": reduced.anchors[0]})],
        [MountedDevice("pump", device, (("building", "anchor"),))],
        np.column_stack([ground[:, 1], force]) @ load.T,
        ground,
        STEP,
    ).devices[0]


def test_detailed_analysis_against_full_order(frame, reduced, device, full):
    damping = frame[0].building("F").damping.rayleigh
    found = mounted(reduced, device, damping).force
    largest = np.abs(full).max(axis=1)
    for c in (0, 1, 2, 3):
        if largest[c] > 1e-3 * largest[:3].max():
            assert np.abs(found[c]).max() == pytest.approx(largest[c], rel=5e-3)
    assert np.abs(found[1] - full[1]).max() < 5e-3 * largest[1]
    # Half of the mass is another device.
    other = Rayleigh(damping.alpha, damping.beta / 5)
    light = np.abs(mounted(reduced, device, other).force[1]).max()
    assert abs(light / largest[1] - 1.0) > 0.01


def test_anchors_yield_as_in_full_order(frame, base_plate, reduced):
    building, _ = linked(
        assemble_building(MPI.COMM_SELF, frame[1]), [base_plate.link], frame[1].mesh.nodes
    )
    K = scipy_matrix(building.stiffness(FACTOR)).tocsc()
    row = int(building.rows(np.array([base_plate.master]))[0])
    S = np.zeros((6, K.shape[0]))
    S[:, row : row + 6] = base_plate.carried
    exact = S @ splu(K).solve(S.T)
    found = (reduced.anchors[0] / reduced.eigenvalue) @ reduced.anchors[0].T
    assert np.diag(found) == pytest.approx(np.diag(exact), rel=2e-3)
    assert np.all(np.diag(found) <= np.diag(exact) * (1.0 + 1e-9))  # Galerkin is too stiff


def test_wall_of_the_study(reduced, frame):
    """The same experiment as that of the wall's own model."""
    wall = reduced.wall
    assert wall is not None and wall.contact.shape == (len(reduced.eigenvalue), 18)
    z = wall.start(-0.01)
    assert z @ wall.seen[:, -1] == pytest.approx(-0.01)
    # The device's rigid plate lies in the floor that is held, and moves with it.
    assert wall.uneven < 1e-9


def test_archive(whole, tmp_path):
    path = tmp_path / "model.npz"
    whole.write(path, "key")
    again = ReducedBuilding.read(path, "key")
    assert again is not None and ReducedBuilding.read(path, "other") is None
    assert np.array_equal(again.complete.anchors, whole.complete.anchors)
    assert np.array_equal(again.complete.wall.contact, whole.complete.wall.contact)
    assert np.array_equal(again.complete.wall.eigenvalue, again.complete.eigenvalue)
    assert np.array_equal(again.basis.vectors, whole.basis.vectors)
    assert again.basis.loads == ("ground y", "floor 2", "push", "floor 1")
    for one, other in zip(again.basis.models, whole.basis.models, strict=True):
        assert np.array_equal(one.tail, other.tail) and one.shift == other.shift


def test_plans_that_it_serves(whole, plan, frame):
    own = frame[0].building("F").damping.rayleigh
    heavier = replace(plan, accuracies=(Accuracy(Rayleigh(own.alpha, 2 * own.beta), 300.0, 0.002),))
    same, _ = whole.serving(plan)
    assert same.errors == pytest.approx(whole.errors, rel=1e-6)
    other, _ = whole.serving(heavier)
    assert other.basis.difference == other.errors[0] < whole.basis.difference
    light = Accuracy(Rayleigh(own.alpha, own.beta / 100.0), 600.0, 0.002)
    for change, why in (
        ({"accuracies": (light,)}, "with an error of .* for this damping"),
        ({"accuracies": (*plan.accuracies, light)}, "with an error of .* for this damping"),
        ({"edges": (EdgeForce("floor 1 y-", 1, (0.0, 1.0, 0.0), "y-"),)}, "without floor 1 y-"),
        ({"directions": (0, 1)}, "without ground x"),
        ({"nodes": np.arange(12)}, "without some of the nodes whose motion is wanted"),
        ({"larger": True}, "without the larger models that give its error band"),
    ):
        none, lack = whole.serving(replace(plan, **change))
        assert none is None and re.fullmatch(why, lack)


def test_total_ground_load(reduced, frame):
    """Rigid-body part of the load: bᵀ b is the effective mass of the modes, below the total."""
    total = assemble_building(MPI.COMM_SELF, frame[1]).total[1, 1]
    effective = reduced.ground[:, 1] @ reduced.ground[:, 1]
    assert 0.8 * total < effective < total


LIGHT = RayleighCase(name="light", mass_coefficient=0.2, stiffness_coefficient=1e-4)


@pytest.fixture
def case(new_case, tmp_path):
    found = load_case(new_case(tmp_path))
    law = found.contact_laws["floor"]
    return found.model_copy(update={"contact_laws": {"floor": law, "column": law}})


def restitutions(case):
    return {name: law.restitution for name, law in case.contact_laws.items()}


def test_all_buildings_take_the_damping(case):
    found = damped_case(case, LIGHT, None)
    assert {b.damping.rayleigh for b in found.buildings} == {Rayleigh(0.2, 1e-4)}
    assert found.contact_laws == case.contact_laws


@pytest.mark.parametrize(
    ("laws", "changed"), [((), {"floor", "column"}), ({"floor"}, {"floor"}), ({"other"}, set())]
)
def test_the_restitution_is_for_those_that_asked(case, laws, changed):
    found, before = restitutions(damped_case(case, LIGHT, 0.31, laws)), restitutions(case)
    assert {name for name in found if found[name] == 0.31} == changed
    assert {name for name in found if found[name] == before[name]} == set(before) - changed
