"""Several sticks on the same ground, with pairs of points that may touch and forces on points.

mass = mass_on_spring("mass", 1e3, frequency=2.0, damping_ratio=0.05)
pulse = Load(End.of_floor(mass, 1), np.array([0.0, 1.0, 0.0]), force)   # force: (n_t,) [N]
response = simulate(System((mass,), ()), np.zeros((n_t, 3)), dt, loads=[pulse])
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
import scipy.linalg

from impactfem.coupling.base import BaseHistory, base_histories
from impactfem.coupling.body import Body, Port, modal_coordinates
from impactfem.coupling.ground import Ground, as_ground
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.law import Law
from impactfem.coupling.links import Assembly, Link
from impactfem.dynamics.energy import Energy
from impactfem.sticks.stick import Stick
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError, SolutionError

Update = Literal["implicit", "lagged"]
UNSTABLE = (
    "a lagged contact force is only conditionally stable: take a smaller pounding.time_step or "
    "update = 'implicit'"
)


@dataclass(frozen=True)
class End:
    """One end of a pair: a point tied to a master of a stick."""

    building: str  #: name of the stick
    master: int  #: index of the master
    offset: tuple[float, float, float]  #: from the master to the point [m]
    floor: int  #: number of the floor, or of the floor above for a point inside a storey
    #: Height in the storey's flexible part, 0 to 1; None for a point of a floor.
    relative_height: float | None = None

    @classmethod
    def of_floor(
        cls, stick: Stick, floor: int, offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> End:
        """A point of a floor, the offset from its mass centre [m].

        Raises:
            ImpactfemError: The stick has no such floor.
        """
        return cls(stick.name, stick.floor_master(floor), offset, floor)


@dataclass(frozen=True, eq=False)
class Load:
    """An external force on a point, in addition to the ground motion."""

    at: End  #: the point
    direction: Array  #: unit vector along which a positive force acts, shape (3,)
    force: Array  #: its history at the times of the response, shape (n_t,) [N]


@dataclass(frozen=True)
class Pair:
    """Two points that may touch.

    The gap function is δ = g + n · (u_b - u_a), negative in contact; the force F on the points is
    -F n on a and +F n on b.
    """

    name: str  #: unique name
    a: End  #: the first end
    b: End | None  #: the second end; None for a rigid wall that moves with the ground under a
    normal: Array  #: unit vector n from a to b, shape (3,)
    gap: float  #: gap g at rest [m]
    law: Law  #: the contact law
    area: float | None = None  #: bearing area [m2]; None where unknown
    #: Begin, top and end of the hat of a point of contact of 3D models on the sides of a and b,
    #: shape (2, 3) [m], nan of a stick; None for a pair of points.
    hats: Array | None = None
    line: str = ""  #: name of the pair for the whole line; empty for a point of no line


@dataclass(frozen=True)
class System:
    """Sticks side by side and the pairs between them; matrices are block diagonal."""

    sticks: tuple[Stick, ...]  #: the buildings
    pairs: tuple[Pair, ...]  #: the pairs of points that may touch

    @cached_property
    def offsets(self) -> dict[str, int]:
        """First degree of freedom of each building."""
        starts = np.cumsum([0] + [stick.n for stick in self.sticks])
        return {stick.name: int(start) for stick, start in zip(self.sticks, starts, strict=False)}

    @cached_property
    def M(self) -> Array:
        """Mass matrix, shape (n, n)."""
        return _diagonal([stick.M for stick in self.sticks])

    @cached_property
    def C(self) -> Array:
        """Damping matrix, shape (n, n)."""
        return _diagonal([stick.C for stick in self.sticks])

    @cached_property
    def K(self) -> Array:
        """Stiffness matrix, shape (n, n)."""
        return _diagonal([stick.K for stick in self.sticks])

    @cached_property
    def J(self) -> Array:
        """Rows that give each pair's n · (u_b - u_a), shape (m, n)."""
        rows = np.zeros((len(self.pairs), self.M.shape[0]))
        for row, pair in zip(rows, self.pairs, strict=True):
            row -= self.row(pair.a, pair.normal)
            if pair.b is not None:
                row += self.row(pair.b, pair.normal)
        return rows

    def row(self, end: End, direction: Array) -> Array:
        """Row that gives a point's translation along a direction, shape (n,)."""
        stick = self.stick(end.building)
        start = self.offsets[stick.name]
        row = np.zeros(self.M.shape[0])
        row[start : start + stick.n] = direction @ stick.translation(end.master, end.offset)
        return row

    @cached_property
    def modes(self) -> tuple[tuple[Array, Body], ...]:
        """Basis Φ with u = Φ z, shape (n, n), and body of each stick.

        Its ports are the mass centres "floor 1" and so on, with six components, and the ends of its
        pairs, with three.
        """
        found = []
        for stick in self.sticks:
            try:
                basis, mass, eigenvalue, damping = modal_coordinates(
                    stick.M, stick.C, stick.K, stick.damping
                )
            except ImpactfemError as error:
                raise ImpactfemError(f"building {stick.name}: {error}") from error
            R = stick.rigid_body()
            ports = {}
            for k, floor in enumerate(stick.floors):
                rows = slice(6 * k, 6 * k + 6)
                ports[f"floor {floor.number}"] = Port(basis[rows], R[rows])
            for pair in self.pairs:
                for side, end in (("a", pair.a), ("b", pair.b)):
                    if end is not None and end.building == stick.name:
                        row = stick.translation(end.master, end.offset)
                        ports[f"{pair.name} {side}"] = Port(row @ basis, row @ R)
            body = Body(
                name=stick.name,
                eigenvalue=eigenvalue,
                damping=damping,
                participation=basis.T @ stick.M @ R,
                rigid_mass=R.T @ stick.M @ R + (0.0 if stick.soil is None else stick.soil.raft),
                ports=ports,
                mass=mass,
                free_base=stick.soil is not None,
                soil=stick.soil,
            )
            found.append((basis, body))
        return tuple(found)

    @cached_property
    def assembly(self) -> Assembly:
        """The sticks as bodies, the pairs as links between their ports."""
        links = []
        for pair in self.pairs:
            a = pair.a.building, f"{pair.name} a"
            b = None if pair.b is None else (pair.b.building, f"{pair.name} b")
            links.append(Link(pair.name, a, b, pair.normal, pair.gap, pair.law))
        return Assembly([body for _, body in self.modes], links)

    @cached_property
    def basis(self) -> Array:
        """Φ with u = Φ z of all sticks, those of bases on soil included, shape (n, r)."""
        blocks = []
        for stick, (basis, body) in zip(self.sticks, self.modes, strict=True):
            if body.soil is not None:
                moved = stick.rigid_body() @ self.assembly.base_motion(body)
                basis = np.hstack([basis, moved])
            blocks.append(basis)
        return _diagonal(blocks)

    @cached_property
    def ground(self) -> Array:
        """Displacements of all masters for a unit ground translation x, y, z; shape (n, 3)."""
        return np.vstack([np.zeros((0, 3)), *(one.rigid_body()[:, :3] for one in self.sticks)])

    def coordinates(self, u: Array) -> Array:
        """Coordinates of displacements of the sticks, shape (n,), with bases on soil at rest."""
        found, start = [], 0
        for basis, body in self.modes:
            z = np.linalg.solve(basis, u[start : start + len(basis)])
            found.append(np.pad(z, (0, len(body) - len(z))))
            start += len(basis)
        return np.concatenate(found)

    def stick(self, name: str) -> Stick:
        """The building of this name."""
        return next(stick for stick in self.sticks if stick.name == name)

    def floor_dofs(self, building: str) -> Index:
        """Degrees of freedom of a building's floors, shape (n_floors, 6)."""
        start = self.offsets[building]
        count = len(self.stick(building).floors)
        return start + np.arange(6 * count, dtype=np.int64).reshape(count, 6)

    def without_contact(self) -> System:
        """Return the system without its pairs."""
        return replace(self, pairs=())

    def with_laws(self, make: Callable[[Pair], Law]) -> System:
        """Return the system with other laws; `make` gives the law of a pair."""
        pairs = tuple(replace(pair, law=make(pair)) for pair in self.pairs)
        return replace(self, pairs=pairs)


def _diagonal(blocks: Sequence[Array]) -> Array:
    """A matrix of blocks along its diagonal; without rows where there are none."""
    return np.asarray(scipy.linalg.block_diag(np.zeros((0, 0)), *blocks))


@dataclass(frozen=True)
class Response:
    """Result of `simulate`, relative to the ground under the first building."""

    system: System
    time_step: float  #: time step [s]
    u: Array  #: displacements, shape (n_t, n) [m, rad]
    v: Array  #: velocities, shape (n_t, n)
    force: Array  #: contact forces, positive in compression, shape (n_t, m) [N]
    ground: Array  #: ground acceleration along x, y, z, shape (n_t, 3) [m/s2]
    energy: Energy  #: the energies
    loads: tuple[Load, ...] = ()  #: external forces in addition to it
    bases: Mapping[str, BaseHistory] = field(default_factory=dict)  #: on soil, by building
    in_3d: tuple[str, ...] = ()  #: names of the buildings whose floors alone are known
    pause: float = 0.0  #: shortest time without a force that parts two impacts of a pair [s]
    #: Error of the complementarity of unilateral forces and velocities [-]; zero with laws.
    residual: float = 0.0
    parts: int = 1  #: equal parts in which a step with contact is made
    #: Motion of the ground under other buildings, `Ground.relative`.
    relative: Mapping[str, Array] = field(default_factory=dict)

    @property
    def exerted(self) -> tuple[tuple[Pair, ...], Array]:
        """Points where forces act, and the forces for further stages, shape (n_t, m) [N]."""
        return self.system.pairs, self.force

    @property
    def largest_forces(self) -> Array:
        """Largest force of each pair by time, shape (n_t, m) [N]; within a step where known."""
        return self.force

    def body(self, building: str) -> Body:
        """Return a building as a body, with all of its modes."""
        names = [stick.name for stick in self.system.sticks]
        return self.system.modes[names.index(building)][1]

    def closed(self, pairs: Sequence[Pair]) -> Array:
        """Return the approach of the ends of pairs from rest, shape (n_t, m) [m]."""
        return -opening(replace(self.system, pairs=tuple(pairs)), self.u, self.relative)

    def largest_along(self, end: End, direction: Array) -> float:
        """Return the largest displacement of a point along a direction, without sign [m].

        A point inside a storey of a 3D model moves as the floor above, which alone is known.
        """
        if end.building in self.in_3d and end.relative_height is not None:
            end = End.of_floor(self.system.stick(end.building), end.floor, end.offset)
        return float(np.abs(self.u @ self.system.row(end, direction)).max())

    def exchanged(self, index: int, low: int, high: int) -> tuple[float, float]:
        """Return work of a pair's force on the buildings between two times, and dissipation [J]."""
        here = slice(low, high + 1)
        F, gap = self.force[here, index], self.gap[here, index]
        work = float(np.sum(np.diff(gap) * 0.5 * (F[:-1] + F[1:])))
        return work, self.system.pairs[index].law.dissipated(gap, self.gap_rate[here, index])

    @cached_property
    def time(self) -> Array:
        """Times, shape (n_t,) [s]."""
        return np.asarray(self.time_step * np.arange(self.u.shape[0]), dtype=np.float64)

    @cached_property
    def moving(self) -> Index:
        """Degrees of freedom that move at all."""
        return np.flatnonzero(self.u.any(axis=0) | self.v.any(axis=0))

    def deformation(self, values: Literal["u", "v"], building: str | None = None) -> Array:
        """Displacements or velocities relative to the bases, shape (n_t, n); of one stick or all.

        On a clamped base they are those relative to the ground under it.
        """
        system = self.system
        chosen = system.sticks if building is None else (system.stick(building),)
        first = system.offsets[chosen[0].name]
        found = getattr(self, values)[:, first : first + sum(stick.n for stick in chosen)]
        bases = [self.base(values, stick.name) for stick in chosen]
        found = found if all(base is None for base in bases) else found.copy()
        for stick, base in zip(chosen, bases, strict=True):
            if base is not None:
                at = system.offsets[stick.name] - first
                found[:, at : at + stick.n] -= base @ stick.rigid_body().T
        return np.asarray(found)

    def base(self, values: Literal["u", "v"], building: str) -> Array | None:
        """Displacement or velocity of the base of a building, shape (n_t, 6); None at rest."""
        if building not in self.bases and building not in self.relative:
            return None
        moved = np.zeros((len(self.u), 6))
        if building in self.bases:
            moved += getattr(self.bases[building], values)
        if building in self.relative:
            moved[:, :3] += self.relative[building]["uv".index(values)]
        return moved

    @property
    def external(self) -> Array:
        """External forces -M r a_g and those of the loads, shape (n_t, n)."""
        return self._external(np.arange(self.u.shape[1]))

    def _external(self, dofs: Index) -> Array:
        external = -self.ground @ (self.system.M @ self.system.ground)[dofs].T
        for load in self.loads:
            external += np.outer(load.force, self.system.row(load.at, load.direction)[dofs])
        return np.asarray(external)

    @cached_property
    def acceleration(self) -> Array:
        """Accelerations relative to the ground, from the equilibrium, shape (n_t, n).

        Points without mass have none of their own: they get zero.
        """
        system = self.system
        mass = np.diag(system.M)
        # Mostly one or two directions move, and the others have no part in these.
        dofs = self.moving[mass[self.moving] > 0.0]
        here = np.ix_(self.moving, dofs)
        balance = self._external(dofs)
        balance -= self.deformation("v")[:, self.moving] @ system.C[here]
        balance -= self.deformation("u")[:, self.moving] @ system.K[here]
        if system.pairs:
            balance += self.force @ system.J[:, dofs]
        acceleration = np.zeros_like(self.u)
        acceleration[:, dofs] = balance / mass[dofs]
        return acceleration

    @cached_property
    def absolute_acceleration(self) -> Array:
        """Accelerations with the ground's added, shape (n_t, n)."""
        return self.acceleration + self.ground @ self.system.ground.T

    @cached_property
    def gap(self) -> Array:
        """Gap function of each pair, shape (n_t, m) [m]; negative in contact."""
        rest = np.array([pair.gap for pair in self.system.pairs])
        return np.asarray(rest + opening(self.system, self.u, self.relative))

    @cached_property
    def gap_rate(self) -> Array:
        """Rate of the gap function, shape (n_t, m) [m/s]."""
        return opening(self.system, self.v, self.relative, 1)


def opening(system: System, x: Array, relative: Mapping[str, Array], row: int = 0) -> Array:
    """N · (x_b - x_a) of each pair by displacements or velocities, (n_t, n); (n_t, m).

    They and `Ground.relative`, of which the row counts, are relative to the ground under the first
    building; a wall moves with the ground under its own.
    """
    found = np.asarray(x @ system.J.T)
    for k, pair in enumerate(system.pairs):
        if pair.b is None and pair.a.building in relative:
            found[:, k] += relative[pair.a.building][row] @ pair.normal
    return found


def opened(pairs: Sequence[Pair], ground: Ground) -> Array | None:
    """Opening of the gaps by the ground, and its rate, (2, n_t, m); None if it moves uniformly."""
    if not ground.relative:
        return None
    apart = np.zeros((2, len(ground.acceleration), len(pairs)))
    for k, pair in enumerate(pairs):
        other = None if pair.b is None else pair.b.building
        apart[:, :, k] = ground.opened(pair.a.building, other, pair.normal)
    return apart


def add_ground(
    system: System, ground: Ground, values: Sequence[Array], *, first: int = 0, sign: float = 1.0
) -> None:
    """From motions relative to the ground under each stick to that under the first, in place.

    To displacements, velocities and accelerations, shape (n_t, n) each, or from the `first` of them
    on, what the ground under it moves more is added, times the sign.
    """
    for name, moved in ground.relative.items():
        at, R = system.offsets[name], system.stick(name).rigid_body()[:, :3]
        for x, of_ground in zip(values, moved[first:], strict=False):
            x[:, at : at + len(R)] += sign * of_ground @ R.T


def simulate(
    system: System,
    ground: Array | Ground,
    time_step: float,
    *,
    update: Update = "implicit",
    u0: Array | None = None,
    v0: Array | None = None,
    loads: Sequence[Load] = (),
) -> Response:
    """Response of the sticks to the ground motion and to forces on points, with contact.

    Gaps open and close with the ground under the buildings, where it does not move alike.

    Newmark's average acceleration; the contact force is implicit at the new time, or lagged one
    step as equation 2 of the paper prints it.

    Args:
        system: The buildings and pairs.
        ground: The ground at every step; of one that moves alike its acceleration along x, y, z,
            shape (n_t, 3) [m/s2].
        time_step: Time step [s].
        update: "implicit" or "lagged".
        u0: Displacements at the start, shape (n,); zero when None.
        v0: Velocities at the start, shape (n,); zero when None. Bases on soil start at rest.
        loads: External forces in addition to the ground motion.

    Raises:
        ImpactfemError: Shapes of the ground motion or of a load do not fit, or a law is unilateral.
        SolutionError: The start already penetrates, the response is not finite, or the contact
            forces do not converge.
    """
    if rigid := [pair.name for pair in system.pairs if pair.law.unilateral]:
        raise ImpactfemError(
            f"contact pair {rigid[0]}: sticks have no unilateral contact; give the pair a contact "
            "law with a stiffness, or let 3D models pound ([pounding] models)"
        )
    n = system.M.shape[0]
    ground = as_ground(ground)
    a_g = ground.acceleration
    n_t = len(a_g)
    assembly, basis = system.assembly, system.basis
    f = _modal_loads(system, ground, loads)
    # z = Φ⁻¹ u. Points without mass have no velocity at the start but that of their stiffness.
    z0, w0 = (None if x is None else system.coordinates(x) for x in (u0, v0))
    apart = opened(system.pairs, ground)
    motion = respond(
        assembly,
        f,
        a_g,
        time_step,
        lagged=update == "lagged",
        start=Start(z0, w0),
        opened=apart,
    )
    moved = basis[:, motion.moving]
    dofs = np.flatnonzero(moved.any(axis=1))
    # By columns: those that do not move take no memory.
    u, v = (np.zeros((n_t, n), order="F") for _ in range(2))
    u[:, dofs], v[:, dofs] = motion.u @ moved[dofs].T, motion.v @ moved[dofs].T
    if not np.isfinite(u[-1]).all():
        raise SolutionError(f"the response grew without bound; {UNSTABLE}")
    add_ground(system, ground, (u, v))
    bases = base_histories(assembly, motion.attached, time_step)
    radiated = sum((base.radiated for base in bases.values()), np.zeros(n_t))
    energy = replace(motion.energy, damped=motion.energy.damped - radiated, radiated=radiated)
    response = Response(
        system=system,
        time_step=time_step,
        u=u,
        v=v,
        force=motion.force,
        ground=a_g,
        energy=energy,
        loads=tuple(loads),
        bases=bases,
        relative=ground.relative,
    )
    if update == "lagged":
        _refuse_created_energy(response, motion.energy)
    return response


def _modal_loads(system: System, ground: Ground, loads: Sequence[Load]) -> Array:
    """Loads of the ground motion and the forces on the coordinates, shape (n_t, r)."""
    assembly, n_t = system.assembly, len(ground.acceleration)
    f = ground.acceleration @ assembly.ground.T
    for name, (_, _, a) in ground.relative.items():
        columns = assembly.columns[name]
        f[:, columns] += a @ assembly.ground[columns].T
    for load in loads:
        if np.shape(load.force) != (n_t,):
            where, shape = f"{load.at.building}, floor {load.at.floor}", np.shape(load.force)
            raise ImpactfemError(f"force on {where}: expected shape ({n_t},), got {shape}")
        f += np.outer(load.force, system.row(load.at, load.direction) @ system.basis)
    return np.asarray(f)


def _refuse_created_energy(response: Response, energy: Energy) -> None:
    """Refuse lagged contact forces that gave the buildings more energy than all else did."""
    external = response.external
    mean = 0.5 * (external[:-1] + external[1:])
    given = float(np.sum(np.abs(np.sum(np.diff(response.u, axis=0) * mean, axis=1))))
    given += float(energy.kinetic[0] + energy.elastic[0])
    if (work := float(energy.contact[-1])) > given:
        raise SolutionError(f"the lagged contact forces created energy, {work:.3g} J; {UNSTABLE}")
