"""The frequency up to which a mesh resolves bending waves, against a plate in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.building.bending_wave import ELEMENTS, mesh_limit

E, NU, RHO = 30e9, 0.2, 2500.0


def slab(side, thickness, added):
    """One equilateral triangle as the slab of floor 1."""
    nodes = side * np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.5, np.sqrt(0.75), 3.0]])
    triangles = np.array([[0, 1, 2]])
    mesh = SimpleNamespace(
        nodes=nodes, triangles=triangles, floors=[1], slab=lambda floor: np.array([0])
    )
    material = SimpleNamespace(E=E, nu=NU, rho=RHO)
    return SimpleNamespace(
        mesh=mesh,
        thickness=lambda: np.array([thickness]),
        slab_material=lambda floor: material,
        added_mass=np.array([added]),
    )


@pytest.mark.parametrize("added", [0.0, 2250.0])
def test_a_wave_has_three_elements(added):
    """A wave of the length λ = n h has ω² = D k⁴ / m' with k = 2π / λ."""
    found = mesh_limit(slab(1.0, 0.3, added))
    D = E * 0.3**3 / 12.0 / (1.0 - NU**2)
    k = 2.0 * np.pi / ELEMENTS
    assert (2.0 * np.pi * found) ** 2 == pytest.approx(D * k**4 / (RHO * 0.3 + added))


def test_smaller_elements_and_thicker_slabs_resolve_more():
    """The limit grows with t / h²."""
    base = mesh_limit(slab(1.0, 0.3, 0.0))
    assert mesh_limit(slab(0.5, 0.3, 0.0)) == pytest.approx(4.0 * base)
    assert mesh_limit(slab(1.0, 0.6, 0.0)) == pytest.approx(2.0 * base)
