"""The shipped frame before a wall: reduced against full order, on one rank."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from impactfem.building.from_case import read_parts
from impactfem.building.model import assemble_building
from impactfem.building.shell_model import csr
from impactfem.case import load_case
from impactfem.case.calibration import WallImpactSetup
from impactfem.case.damping import OWN, RayleighCase
from impactfem.dynamics.columns import product
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.galerkin import GalerkinModes
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReductionPlan, reduce_building
from impactfem.reduction.wall import Wall, WallModel, WallPatterns
from impactfem.stages.calibrate.compute import SoftPoints, prepare, released, run_reduced
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.impact import floor_impacts
from impactfem.system.errors import ImpactfemError
from impactfem.verify.full_order import FullMotion
from one_building import building_of

GEOMETRY = Path(__file__).parents[3] / "geometry"
EXPERIMENT = WallExperiment((1, 2), 2, -0.01, 0.004, 0.3, 0.25e-3, "y+")
MASS = np.array([20e3, 20e3])
FACTOR = 0.5


@pytest.fixture(scope="module")
def frame():
    case = load_case(GEOMETRY / "frame.toml")
    parts, _ = read_parts(building_of(case), GEOMETRY / "frame.msh")
    model = assemble_building(MPI.COMM_SELF, parts)
    damping = case.building("F").damping.rayleigh
    return model, model.stiffness(FACTOR), parts.mesh, damping, parts


def wall_of(frame, pull):
    """The reduced frame with its contacts."""
    mesh, damping, parts = frame[2], frame[3], frame[4]
    probes = np.array([mesh.centres[1], mesh.centres[2]])
    plan = ReductionPlan(
        probes=probes,
        nodes=probes,
        accuracies=(Accuracy(damping, 300.0, 0.005),),
        wall=Wall(EXPERIMENT.floors, 2, pull),
        largest=400,
    )
    building = assemble_building(MPI.COMM_SELF, parts)
    return reduce_building(building, mesh, FACTOR, plan).complete.wall


@pytest.fixture(scope="module")
def patterns(frame):
    model, _, mesh, _, _ = frame
    return WallPatterns.of(model, mesh, Wall(EXPERIMENT.floors, 2, "whole_floor"))


@pytest.fixture(scope="module")
def reduced(frame):
    return wall_of(frame, "whole_floor")


@pytest.fixture(scope="module")
def full(frame, patterns):
    model, K, _, damping, _ = frame
    state, _ = patterns.held(K)
    u0 = np.ascontiguousarray(EXPERIMENT.displacement * state)
    G, h, seen = patterns.contact, EXPERIMENT.time_step, patterns.seen
    with FullMotion(csr(K), csr(model.mass), G, h, damping=damping, probes=seen) as motion:
        return released(motion, EXPERIMENT, MASS, patterns.floor_of, u0, G.T @ u0)


def test_reduced_against_full(frame, reduced, full):
    run = run_reduced(reduced, EXPERIMENT, MASS, frame[3])
    fastest = np.abs(full.history.velocity).max()
    for floor in EXPERIMENT.floors:
        ours = floor_impacts(run.history, floor).first_complete()
        truth = floor_impacts(full.history, floor).first_complete()
        assert ours.start == pytest.approx(truth.start, abs=0.3 * EXPERIMENT.time_step)
        assert ours.duration == pytest.approx(truth.duration, rel=2e-3)
        assert ours.largest_impulse == pytest.approx(truth.largest_impulse, rel=2e-3)
        assert ours.approach == pytest.approx(truth.approach, rel=2e-3, abs=1e-3 * fastest)
    # With another damping they differ.
    light = run_reduced(reduced, EXPERIMENT, MASS, Rayleigh(frame[3].alpha, frame[3].beta / 5.0))
    other = floor_impacts(light.history, 2).first_complete().largest_impulse
    truth = floor_impacts(full.history, 2).first_complete().largest_impulse
    assert abs(other / truth - 1.0) > 0.02


def test_contact_points_without_mass(reduced, frame):
    """At the wall: impulse and largest force depend less on the step than by Moreau's scheme."""
    length, found = np.ones(reduced.contact.shape[1]), {}
    soft = SoftPoints((2.0 * np.pi * 3240.0) ** 2, 1.0 / (1e11 * length))
    for parts in (1, 4):
        fine = replace(EXPERIMENT, time_step=EXPERIMENT.time_step / parts)
        for name, points in (("massless", soft), ("moreau", None)):
            run = run_reduced(reduced, fine, MASS, frame[3], points)
            found[name, parts] = floor_impacts(run.history, 2).first_complete()
            assert run.contact.residual.max() < 1e-9 and run.contact.energy.residual < 1e-9
    impulse, peak = (
        {
            name: abs(getattr(found[name, 4], what) / getattr(found[name, 1], what) - 1.0)
            for name in ("massless", "moreau")
        }
        for what in ("largest_impulse", "peak_force")
    )
    assert impulse["massless"] < 1e-3 and peak["massless"] < 0.15
    assert impulse["moreau"] > 0.02 and peak["moreau"] > 0.5
    # Moreau's scheme loses less with a shorter step.
    last = found["moreau", 4].largest_impulse, found["massless", 4].largest_impulse
    assert last[0] == pytest.approx(last[1], rel=0.03)


def test_laws_of_contact_hold_at_each_step(full):
    contact = full.contact
    assert contact.residual.max() < 1e-9
    assert contact.impulse.min() >= 0.0
    assert contact.energy.residual < 1e-9 and contact.energy.gained < 1e-12
    # A constraint is seen one step late.
    fastest = np.abs(np.diff(contact.gap, axis=0)).max()
    assert 0.0 < contact.penetration.max() < fastest


def slab_rows(model, mesh):
    """Rows of the displacements towards the wall on the slab of floor 2."""
    return model.rows(np.unique(mesh.triangles[mesh.slab(2)])) + 1


def test_the_whole_floor_starts_at_the_displacement(frame, patterns, reduced, full):
    """Every node of the slab, in full order and in the basis; the other floor follows freely."""
    model, K, mesh, _, _ = frame
    state, push = patterns.held(K)
    assert np.abs(state[slab_rows(model, mesh)] - 1.0).max() == 0.0
    assert reduced.uneven < 1e-9
    # Nothing but the slab along n is held: no force acts elsewhere.
    held = np.zeros(len(push), dtype=bool)
    held[slab_rows(model, mesh)] = True
    assert np.abs(product(K, state[:, None])[~held]).max() < 1e-8 * np.abs(push).max()
    z = reduced.start(-0.01)
    assert z @ reduced.seen[:, -1] == pytest.approx(-0.01, rel=1e-12)
    assert full.history.displacement[0, 1] == pytest.approx(-0.01, rel=1e-12)
    assert z @ reduced.seen[:, 0] == pytest.approx(full.history.displacement[0, 0], rel=1e-9)
    assert full.contact.energy.kinetic[0] == 0.0
    # ½ k d² of the forces that hold it, which the building has when it is let go.
    energy = 0.5 * 0.01**2 * float(push @ state)
    assert full.contact.energy.elastic[0] == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize("pull", ["even_load", "mass_centre"])
def test_a_load_draws_the_mass_centre_aside(frame, reduced, pull):
    """The slab of a frame yields between its columns; the resultant is that of the load."""
    model, K, mesh, damping, _ = frame
    drawn = WallPatterns.of(model, mesh, Wall(EXPERIMENT.floors, 2, pull))
    state, push = drawn.held(K)
    assert drawn.seen[:, -1].T @ state == pytest.approx(1.0, rel=1e-12)
    along = push[1::6]
    acting = np.abs(along) > 1e-6 * np.abs(along).max()
    assert acting.sum() == (1 if pull == "mass_centre" else (drawn.pull.load != 0.0).sum())
    away = np.abs(state[slab_rows(model, mesh)] - 1.0).max()
    assert away > 0.1
    found = wall_of(frame, pull)
    assert found.uneven == pytest.approx(away, rel=1e-6)
    # It arrives later than the floor that is held as a whole, and slower.
    ours = floor_impacts(run_reduced(found, EXPERIMENT, MASS, damping).history, 2)
    held = floor_impacts(run_reduced(reduced, EXPERIMENT, MASS, damping).history, 2)
    assert ours.first_complete().start > 2.0 * held.first_complete().start
    assert ours.first_complete().approach < 0.8 * held.first_complete().approach


def test_without_the_state_in_the_basis(frame, patterns):
    """What a basis of the forces alone would start from is another state."""
    model, K, _, _, _ = frame
    _, push = patterns.held(K)
    with KrylovBasis(K, model.mass, (2.0 * np.pi * 30.0) ** 2) as basis:
        basis.add(push[:, None])
        basis.grow(4)
        found = WallModel.of(GalerkinModes.of(basis), patterns, push, 0.0)
    assert found.uneven > 1e-7


def test_scaled_experiment(frame, reduced):
    """Gap and displacement scaled together: the problem is linear but for its sign."""
    scaled = replace(EXPERIMENT, displacement=-0.03, gap=0.012)
    one = floor_impacts(run_reduced(reduced, EXPERIMENT, MASS, frame[3]).history, 2)
    other = floor_impacts(run_reduced(reduced, scaled, MASS, frame[3]).history, 2)
    first, second = one.first_complete(), other.first_complete()
    assert second.epsilon == pytest.approx(first.epsilon, rel=1e-9)
    assert second.largest_impulse == pytest.approx(3.0 * first.largest_impulse, rel=1e-9)
    # The gap alone changes it.
    alone = replace(EXPERIMENT, gap=0.002)
    third = floor_impacts(run_reduced(reduced, alone, MASS, frame[3]).history, 2).first_complete()
    assert abs(third.epsilon - first.epsilon) > 1e-3


def test_wall_inside_the_building(frame, reduced):
    inside = replace(EXPERIMENT, floors=(1, 2), displacement=0.0039, gap=0.004)
    damping = frame[3]
    # The edge of floor 2 is ahead of its mass centre.
    stretched = replace(reduced, contact=reduced.contact * 1.1)
    with pytest.raises(ImpactfemError, match="building: floor 2"):
        run_reduced(stretched, inside, MASS, damping)


LIGHT = RayleighCase(name="light", mass_coefficient=0.838, stiffness_coefficient=2.12e-4)
HEAVY = RayleighCase(name="heavy", ratio=0.09, frequencies=(1.0, 20.0), restitution=0.5)


@pytest.mark.parametrize("cases", [(), (LIGHT, HEAVY), (HEAVY, LIGHT)])
def test_dampings(cases):
    """The building's own first, then the damping cases that leave their restitution open."""
    wall = WallImpactSetup(
        building="F",
        floors=(1, 2),
        displaced_floor=2,
        gap=0.01,
        displacement=-0.02,
        duration=1.3,
        time_step=1e-3,
    )
    case = load_case(GEOMETRY / "frame.toml")
    case = case.model_copy(update={"wall_impact": wall, "damping_cases": cases})
    prepared = prepare(building_of(case), GEOMETRY / "frame.msh")
    open_ones = {one.name: one.rayleigh for one in cases if one is not HEAVY}
    assert prepared.dampings == {OWN: case.building("F").damping.rayleigh} | open_ones
    assert next(iter(prepared.dampings)) == OWN
