"""The loads of the 3D model: the ground motion, and the impact forces on its sides."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from scipy.integrate import trapezoid

from impactfem.building.mesh import BuildingMesh
from impactfem.building.model import BuildingModel
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.ground import interpolate_ground
from impactfem.reduction.edge_force import EdgeForce, Shares
from impactfem.system.arrays import Array


def project(time: Array, values: Array, time_step: float, n_steps: int) -> Array:
    """The piecewise-linear function on a new grid that is nearest to one on another grid.

    Nearest in the mean square over the whole time: with the hat functions h_i of the new grid,
    Σ_j ∫h_i h_j dt p_j = ∫h_i f dt. As the hats add up to 1 and to t, the impulse ∫f dt and its
    moment ∫t f dt are kept exactly. Linear interpolation keeps neither.

    The given one has ascending times, shape (n,) [s], outside of which it is zero, and values,
    shape (n, m). Gives those at time 0 and after each of the steps of the new grid, shape (n_steps
    + 1, m).
    """
    end = time_step * n_steps
    grid = time_step * np.arange(n_steps + 1)
    # Between two neighbours of both grids together everything is a polynomial of degree 2.
    cuts = np.unique(np.concatenate([grid, time[(time > 0.0) & (time < end)]]))
    right = np.zeros((n_steps + 1, values.shape[1]))
    middle = 0.5 * (cuts[1:] + cuts[:-1])
    cell = np.clip((middle / time_step).astype(np.int64), 0, n_steps - 1)
    length = np.diff(cuts)
    # Gauss's rule of two points is exact for cubics.
    for node in (-1.0 / np.sqrt(3.0), 1.0 / np.sqrt(3.0)):
        at = middle + 0.5 * node * length
        f = np.empty((len(at), values.shape[1]))
        for j, column in enumerate(values.T):
            f[:, j] = np.interp(at, time, column, 0.0, 0.0)
        f *= 0.5 * length[:, None]
        share = (at / time_step - cell)[:, None]
        np.add.at(right, cell, f * (1.0 - share))
        np.add.at(right, cell + 1, f * share)
    band = np.zeros((2, n_steps + 1))
    band[0, 1:] = time_step / 6.0
    band[1] = 2.0 / 3.0 * time_step
    band[1, [0, -1]] = time_step / 3.0
    return np.asarray(scipy.linalg.solveh_banded(band, right), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads as fixed patterns in space with amplitudes in time.

    The ground motion comes first: displacements are relative to the ground, which moves with the
    acceleration a, so that its load is −M r a.

    Raises:
        ValueError: Two patterns have the same name.
    """

    time_step: float  #: Δt [s].
    ground: Array  #: Ground acceleration, shape (n_steps + 1, 3) [m/s2].
    directions: tuple[int, ...]  #: Components (0, 1, 2) in which the ground moves.
    edges: tuple[EdgeForce, ...]  #: The patterns of forces; only those that are not zero.
    #: Their amplitudes, shape (n_steps + 1, n_edges) [N], [N m] for those without a resultant.
    force: Array
    #: Largest difference of an impulse before and after resampling, over the largest impulse.
    impulse_error: float
    #: Part of `force` that is no contact force, of the loads of the case, same shape; None without.
    external: Array | None = None

    def __post_init__(self) -> None:
        # Amplitudes find their patterns by name.
        if len(set(self.names)) < len(self.names):
            raise ValueError(f"loads of the same name: {', '.join(self.names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the patterns in their order."""
        return (*(f"ground {'xyz'[c]}" for c in self.directions), *(e.name for e in self.edges))

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the struck places, "floor 8" or "storey 3 y-", in the order of the patterns."""
        return tuple(dict.fromkeys(edge.place for edge in self.edges))

    @property
    def resultants(self) -> tuple[Array, Array]:
        """Force F [N] and moment F e [N m] on each of `places`, shape (n_steps + 1, n_places) each.

        e is along the side from its middle: of forces at right angles to the side, F e is their
        moment about the vertical through it.
        """
        share = np.zeros((2, len(self.edges), len(self.places)))
        for j, edge in enumerate(self.edges):
            share[:, j, self.places.index(edge.place)] = edge.resultant, edge.moment
        force, moment = self.force @ share
        return force, moment

    @property
    def impact_force(self) -> Array:
        """The part of F that contact exerts, without further loads of the case [N]."""
        if self.external is None:
            return self.resultants[0]
        return replace(self, force=self.force - self.external).resultants[0]

    @property
    def amplitudes(self) -> Array:
        """Amplitudes of all patterns, shape (n_steps + 1, n_patterns) [m/s2, N]."""
        return np.column_stack([self.ground[:, list(self.directions)], self.force])

    def of(self, names: Collection[str]) -> Loads:
        """Return the loads of the ground and of the patterns with these names."""
        kept = np.array([edge.name in names for edge in self.edges], dtype=bool)
        edges = tuple(edge for edge, keep in zip(self.edges, kept, strict=True) if keep)
        external = None if self.external is None else self.external[:, kept]
        return replace(self, edges=edges, force=self.force[:, kept], external=external)

    def without_impacts(self) -> Loads:
        """Return the loads without the contact forces."""
        own = np.zeros_like(self.force) if self.external is None else self.external
        acting = np.any(own != 0.0, axis=0)
        edges = tuple(edge for edge, acts in zip(self.edges, acting, strict=True) if acts)
        return replace(self, edges=edges, force=own[:, acting], external=own[:, acting])

    def patterns(self, model: BuildingModel, mesh: BuildingMesh) -> Array:
        """Patterns at this rank's rows, shape (n_local, n_patterns)."""
        columns = [-model.ground[:, c] for c in self.directions]
        columns += [edge.vector(model, mesh) for edge in self.edges]
        return np.asfortranarray(np.column_stack(columns))


def make_loads(
    motions: list[tuple[int, float, Array]],
    forces: ForceHistory,
    edges: Sequence[Shares],
    time_step: float,
    n_steps: int,
    external: int = 0,
    delay: float = 0.0,
) -> Loads:
    """Loads at the time step of the 3D model [s].

    Of each ground motion component, time step [s] and acceleration [m/s2] are given, and how much
    later all of them reach the building [s]; of each pair the patterns with their amplitudes for
    1 N. Those of the same pattern add. The last pairs, `external` in number, are loads of the case
    and no contacts.
    """
    along = list(dict.fromkeys(pattern for shares in edges for pattern, _ in shares))
    share = np.zeros((len(edges), len(along)))
    for j, shares in enumerate(edges):
        for pattern, factor in shares:
            share[j, along.index(pattern)] += factor
    contacts = len(edges) - external
    loaded = forces.force[:, contacts:] @ share[contacts:]
    # Not by one product: without contact the two are the same to the last digit.
    given = np.add(forces.force[:, :contacts] @ share[:contacts], loaded)
    force = project(forces.time, given, time_step, n_steps)
    # A pattern without force, within this time, would only make the reduced basis larger.
    acting = np.any(force != 0.0, axis=0)
    acted = given[:, acting]
    force = force[:, acting]
    before = _integral(forces.time, acted, time_step * n_steps)
    grid = time_step * np.arange(n_steps + 1, dtype=np.float64)
    after = _integral(grid, force, time_step * n_steps)
    largest = np.abs(before).max(initial=0.0)
    return Loads(
        time_step=time_step,
        ground=interpolate_ground(motions, time_step, n_steps + 1, delay),
        directions=tuple(sorted({component for component, _, _ in motions})),
        edges=tuple(edge for edge, acts in zip(along, acting, strict=True) if acts),
        force=force,
        impulse_error=float(np.abs(after - before).max(initial=0.0) / largest) if largest else 0.0,
        external=project(forces.time, loaded, time_step, n_steps)[:, acting] if external else None,
    )


def _integral(time: Array, values: Array, end: float) -> Array:
    """∫ f dt from 0 to the end of a function that is straight between its samples, shape (m,)."""
    inside = np.append(time[time < end], end)
    f = [np.interp(inside, time, column, right=0.0) for column in values.T]
    return np.array([trapezoid(column, inside) for column in f])
