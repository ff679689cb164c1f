"""The matrix of damping by part."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from mpi4py import MPI
from numpy.typing import NDArray

from impactfem.building.mesh import Part
from impactfem.building.model import assemble_building, damping_matrix
from impactfem.building.parts import BuildingParts, PartDamping
from impactfem.building.section import BeamSection
from impactfem.dynamics.damping import Rayleigh

Array = NDArray[np.float64]
FACTOR = 0.4
WHOLE = Rayleigh(0.3, 2e-4)
OWN = Rayleigh(1.2, 5e-5)


def dampings(parts: BuildingParts, own: dict[str, Rayleigh]) -> PartDamping:
    """By the names of parts; "*" is every part."""
    mesh = parts.mesh
    shells, beams = (
        tuple(own.get(part.group, own.get("*")) for part in some)
        for some in (mesh.shell_parts, mesh.beam_parts)
    )
    return PartDamping(shells, beams)


def dense(matrix: Any) -> Array:
    return np.asarray(matrix[:, :], dtype=np.float64)


def added_damping(parts: BuildingParts, own: dict[str, Rayleigh]) -> Array:
    return dense(damping_matrix(MPI.COMM_SELF, parts, dampings(parts, own), FACTOR, WHOLE))


def test_all_parts_alike(house: BuildingParts) -> None:
    """Their damping is Rayleigh's of the whole building with their coefficients."""
    model = assemble_building(MPI.COMM_SELF, house)
    K, M = dense(model.stiffness(FACTOR)), dense(model.mass)
    C = WHOLE.alpha * M + WHOLE.beta * K + added_damping(house, {"*": OWN})
    expected = OWN.alpha * M + OWN.beta * K
    assert np.abs(C - expected).max() < 1e-13 * np.abs(expected).max()
    # Without one of the parts it is not.
    C = WHOLE.alpha * M + WHOLE.beta * K + added_damping(house, {"*": OWN, "column_2": WHOLE})
    assert np.abs(C - expected).max() > 1e-3 * np.abs(expected).max()


def test_parts_add_up(house: BuildingParts) -> None:
    """Each part by itself, shells and beams, with the factor on walls and columns."""
    groups = [part.group for part in (*house.mesh.shell_parts, *house.mesh.beam_parts)]
    assert len(groups) == 10
    total = sum(added_damping(house, {group: OWN}) for group in groups)
    together = added_damping(house, {"*": OWN})
    assert np.abs(total - together).max() < 1e-13 * np.abs(together).max()
    two = {"floor_2": OWN, "column_1": Rayleigh(0.0, 7e-4)}
    apart = sum(added_damping(house, {name: damping}) for name, damping in two.items())
    assert np.abs(added_damping(house, two) - apart).max() < 1e-13 * np.abs(apart).max()


def test_added_mass_is_damped_with_its_slab(house: BuildingParts) -> None:
    """A slab of 4 m by 3 m and 30 cm with 500 kg/m2 on it, moved along x."""
    mesh = house.mesh
    slab = np.flatnonzero(mesh.triangle_part == mesh.shell_parts.index(Part("floor", 2)))
    added = np.zeros(len(mesh.triangles))
    added[slab] = 500.0
    loaded = replace(house, added_mass=added)
    mass = 12.0 * (0.3 * 2500.0 + 500.0)
    only_mass = {"floor_2": Rayleigh(OWN.alpha, WHOLE.beta)}
    for parts, expected in ((loaded, mass), (house, 12.0 * 0.3 * 2500.0)):
        C = added_damping(parts, only_mass)
        along = np.zeros(len(C))
        along[0::6] = 1.0
        assert along @ C @ along == pytest.approx((OWN.alpha - WHOLE.alpha) * expected, rel=1e-12)
    # That on another slab is not.
    C = added_damping(loaded, {"floor_1": Rayleigh(OWN.alpha, WHOLE.beta)})
    assert along @ C @ along == pytest.approx((OWN.alpha - WHOLE.alpha) * 12.0 * 750.0, rel=1e-12)


def quadratic_bar(
    lengths: Array, EA: Array, rhoA: Array
) -> tuple[NDArray[np.int64], list[Array], list[Array]]:
    """Stiffness and mass of each quadratic element of a bar that stands on its first node.

    By the integrals of the shape functions at both ends and in the middle (Bathe, section 5.3).
    """
    k = np.array([[7.0, 1.0, -8.0], [1.0, 7.0, -8.0], [-8.0, -8.0, 16.0]]) / 3.0
    m = np.array([[4.0, -1.0, 2.0], [-1.0, 4.0, 2.0], [2.0, 2.0, 16.0]]) / 30.0
    nodes = np.array([[2 * e, 2 * e + 2, 2 * e + 1] for e in range(len(lengths))])
    return (
        nodes,
        [a / h * k for a, h in zip(EA, lengths, strict=True)],
        [a * h * m for a, h in zip(rhoA, lengths, strict=True)],
    )


def complex_frequencies(M: Array, C: Array, K: Array) -> tuple[Array, Array]:
    """|s| and −Re s/|s| of the roots of s²M + sC + K above the real axis, ascending."""
    n = len(M)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, np.hstack([K, C]))]])
    s = scipy.linalg.eigvals(state)
    s = s[s.imag > 0.0]
    order = np.argsort(np.abs(s))
    return np.abs(s)[order], (-s.real / np.abs(s))[order]


def test_bar_of_two_parts(panels: Any) -> None:
    """Frequencies and damping ratios along a bar, against matrices made by hand."""
    section = BeamSection.column(0.4, 0.4)
    panels.line((0, 0, 0), (0, 0, 2), 2, Part("column", 1), section)
    panels.line((0, 0, 2), (0, 0, 5), 2, Part("column", 2), section)
    parts = panels.parts(base=panels.at((2, 0.0)))
    model = assemble_building(MPI.COMM_SELF, parts)
    upper = Rayleigh(4.0, 3e-5)
    C = WHOLE.alpha * dense(model.mass) + WHOLE.beta * dense(model.stiffness(FACTOR))
    C += added_damping(parts, {"column_2": upper})
    along = slice(2, None, 6)
    found = complex_frequencies(
        dense(model.mass)[along, along],
        C[along, along],
        dense(model.stiffness(FACTOR))[along, along],
    )
    nodes, k, m = quadratic_bar(
        np.array([1.0, 1.0, 1.5, 1.5]), np.full(4, FACTOR * 33e9 * 0.16), np.full(4, 2500 * 0.16)
    )
    M, B, K = (np.zeros((9, 9)) for _ in range(3))
    for e, damping in enumerate((WHOLE, WHOLE, upper, upper)):
        here = np.ix_(nodes[e], nodes[e])
        M[here] += m[e]
        K[here] += k[e]
        B[here] += damping.matrix(k[e], m[e])
    expected = complex_frequencies(M[1:, 1:], B[1:, 1:], K[1:, 1:])
    assert len(found[0]) == len(expected[0]) > 5
    assert found[0] == pytest.approx(expected[0], rel=1e-9)
    assert found[1] == pytest.approx(expected[1], rel=1e-9)
    # The ratios of one damping for all are others.
    same = complex_frequencies(
        M[1:, 1:], WHOLE.alpha * M[1:, 1:] + WHOLE.beta * K[1:, 1:], K[1:, 1:]
    )
    assert np.abs(found[1][:3] / same[1][:3] - 1.0).max() > 0.1


def test_materials_of_parts_count_in_their_damping(house: BuildingParts) -> None:
    """Stiffness damping of a column of half of E is half as much; that of the mass stays."""
    own = house.materials
    soft = tuple(
        replace(m, E=0.5 * m.E) if part.group == "column_2" else m
        for part, m in zip(house.mesh.beam_parts, own.beams, strict=True)
    )
    mixed = replace(house, materials=replace(own, beams=soft))
    for damping, factor in (
        (Rayleigh(WHOLE.alpha, OWN.beta), 0.5),
        (Rayleigh(OWN.alpha, WHOLE.beta), 1.0),
    ):
        expected = factor * added_damping(house, {"column_2": damping})
        found = added_damping(mixed, {"column_2": damping})
        assert np.abs(expected).max() > 0.0
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()
