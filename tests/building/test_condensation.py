"""Flexibility of the floors of a 3D model."""

import numpy as np
import pytest

from impactfem.building.condensation import floor_flexibility, floor_motions
from impactfem.dynamics.columns import product
from impactfem.dynamics.modes import modes
from impactfem.sticks.modes import natural_modes


@pytest.fixture(scope="module")
def model(house, assembled):
    return assembled(house)


def test_motions_of_the_floors_add_up(model, house):
    """All floors move by one: so does what stands above the first one."""
    mesh = house.mesh
    R = floor_motions(model.coordinates, mesh)
    floors = len(mesh.floors)
    moved = (R @ np.tile([1.0, 2.0, 3.0, 0.0, 0.0, 0.0], floors)).reshape(-1, 6)
    above = model.coordinates[:, 2] > mesh.elevations[1] - 1e-9
    assert moved[above] == pytest.approx(np.tile([1.0, 2.0, 3.0, 0, 0, 0], (above.sum(), 1)))


def test_frequencies_of_floors_on_their_flexibility(model, house):
    """Lumped on F they have those of the lowest modes of the building, which F does not know."""
    mesh = house.mesh
    K = model.stiffness(1.0)
    found = modes(K, model.mass, 4)
    K.destroy()
    flexibility = floor_flexibility(model, mesh, 1.0, found.shapes)
    R = floor_motions(model.coordinates, mesh)
    mass = R.T @ product(model.mass, R)
    omega, shapes = natural_modes(mass, np.linalg.inv(flexibility.F))
    a = flexibility.shapes
    norm = np.einsum("ik,ij,jk->k", a, mass, a)
    whole = np.flatnonzero(norm > 0.8)
    assert whole.size
    mac = (shapes.T @ mass @ a) ** 2 / norm
    for k in whole:
        nearest = mac[:, k].argmax()
        assert mac[nearest, k] > 0.95
        assert omega[nearest] / (2.0 * np.pi) == pytest.approx(found.frequency[k], rel=0.02)
    softer = floor_flexibility(model, mesh, 0.8, found.shapes)
    assert natural_modes(mass, np.linalg.inv(softer.F))[0][0] < 0.97 * omega[0]
