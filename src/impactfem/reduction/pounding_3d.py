"""Buildings that pound by their reduced 3D models: with each other, with sticks and rigid walls.

All are bodies in one time loop: a 3D model by all vectors of its reduced building, a stick by all
of its modes. A line has one link for each of its points of contact, with the law of the pair for
the part w_i / Σ w of its area; a unilateral one has no law. Its forces are those of contact points
without mass (`massless`) or, on request, impulses of Moreau's scheme with θ = ½. All loops are the
average acceleration rule: once the forces are known, the motion of the 3D models, with all of their
mass, follows mode by mode from their mean f in a step h,

    v_m = (v₀ + h/2 (f - λ u₀)) / (1 + h d/2 + h² λ/4),  v₁ = 2 v_m - v₀,  u₁ = u₀ + h v_m.   (1)

The forces that are handed on are straight in time between the steps. Of impulses P in the steps
they are the mean of P/h before and after each time, which keeps the impulse.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid

from impactfem.building.mesh import DOFS
from impactfem.case import Building, Case
from impactfem.case.contacts import UnilateralLaw
from impactfem.case.quantity import RIGID
from impactfem.case.transient import SHIFT
from impactfem.coupling.body import Body, Port
from impactfem.coupling.ground import Ground, as_ground
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.links import Assembly
from impactfem.coupling.march import Modes
from impactfem.coupling.massless import MasslessPoints, massless_response, strip_stiffness
from impactfem.coupling.pounding import (
    Load,
    Pair,
    Response,
    System,
    add_ground,
    opened,
    opening,
    simulate,
)
from impactfem.coupling.unilateral import (
    ContactHistory,
    ModalMotion,
    march_modes,
    unilateral_response,
)
from impactfem.dynamics.energy import Energy
from impactfem.reduction.contact_line import ContactLine
from impactfem.reduction.contact_points import ContactPoints, Side
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.reduced_building import FURTHER_SHIFTS, CompleteModel
from impactfem.system.arrays import Array, Index

SEPARATION = 5e-3
"""Pulses less than this apart are one impact [s]: a slab's waves take some ms, its return 0.1 s."""
CORNER = 4.0
"""Frequency above which contact points have no mass, over the highest one at which a reduced
building has the response to each contact force. With 1, 2 and 4 floor spectra of the paper's pair
at 100 Hz are off by 6, 3 and 0.9 %, impulses by 0.4, 0.2 and 0.04 %: damping of the part without
mass is missing."""
AT_ONCE = 64
"""Modes of a building that are followed in time at once."""


class Motions(NamedTuple):
    """Displacements, velocities and accelerations, shape (n_t, n) each."""

    u: Array
    v: Array
    a: Array


class ModelMotions(NamedTuple):
    """Motions of the floors of a 3D model, and of points of contact by it."""

    u: Array  #: displacements, shape (n_t, 6 n_floors)
    v: Array  #: velocities, same shape
    a: Array  #: accelerations, same shape
    gap: Array  #: change of the gaps of some points, shape (n_t, number of them)
    rate: Array  #: its rate, same shape


class _Contact(NamedTuple):
    """Contact forces, and the motion of the sticks under them."""

    mean: Array  #: means of the steps, shape (n_t - 1, n_points) [N]
    force: Array  #: forces at the times, shape (n_t, n_points) [N]
    z: Array  #: coordinates of the sticks, shape (n_t, r)
    v: Array  #: their velocities
    energy: Energy
    gap: Array | None = None  #: gaps of the points, shape (n_t, n_points) [m]; None if unknown
    residual: float = 0.0
    work: Array | None = None  #: work of the points since the start, same shape; None if unknown
    largest: Array | None = None  #: largest forces of the pairs within each step, (n_t, n_pairs)
    parts: int = 1  #: equal parts of a step with contact

    @classmethod
    def of(cls, history: ContactHistory) -> _Contact:
        """Of a history whose probes are the coordinates of the sticks."""
        # Row k is the mean of the step that ends at k; the ends keep their half of a step.
        mean = history.force[1:]
        force = 0.5 * (history.force + np.vstack([mean, mean[-1:]]))
        force[0] = mean[0]
        return cls(
            mean=mean,
            force=force,
            z=history.displacement,
            v=history.velocity,
            energy=history.energy,
            gap=history.gap,
            residual=float(history.residual.max()),
        )


@dataclass(frozen=True, eq=False)
class Models3D:
    """The 3D models that pound, and the lines along which they touch."""

    lines: tuple[ContactLine, ...]
    models: Mapping[str, CompleteModel]  #: by building; its last points are the floors' centres
    #: Outward normal of the edge, shape (3,), and patterns that push it inwards, by building and
    #: loaded floor.
    pushes: Mapping[tuple[str, int], tuple[Array, Shares]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Response3D(Response):
    """The response of sticks and 3D models; of a 3D model that of its floors' mass centres.

    The pairs of the system are the lines, then pairs of two sticks. The force of a line is the
    resultant, its gap the least of its points, and its rate that at its middle of floors that are
    rigid, as their mass centres move and turn.
    """

    acceleration: Array  #: relative to the ground, shape (n_t, n)
    gap: Array  #: least one of each line, negative in contact, shape (n_t, n_pairs) [m]
    least_gap: Array  #: with the ends of lines for the outermost points, same shape [m]
    gap_rate: Array  #: at the middles, in storeys the mean of the points, same shape [m/s]
    points: tuple[Pair, ...]  #: the points of contact, line by line, then pairs of two sticks
    pair_of: Index  #: of each of them the index of its pair
    point_force: Array  #: shape (n_t, n_points) [N]
    point_gap: Array  #: same shape [m]
    point_rate: Array | None  #: of the gaps, same shape [m/s]; None for unilateral contact
    work: Array  #: of each pair on the buildings since the start, shape (n_t, n_pairs) [J]
    #: Impulses of Moreau's scheme, which dissipate; contact points without mass are elastic.
    impulsive: bool
    #: Largest force of each pair within the step that ends at the time, shape (n_t, n_pairs) [N];
    #: None where it is that at the times.
    largest: Array | None

    def closed(self, pairs: Sequence[Pair]) -> Array:
        """Return the closure of the least gap of lines, at a point or an end, (n_t, m) [m]."""
        return np.asarray([pair.gap for pair in pairs] - self.least_gap)

    def exchanged(self, index: int, low: int, high: int) -> tuple[float, float]:
        """Return work of a line's forces between two times, and dissipation by its laws [J].

        Impulses dissipate minus their work; unilateral contact is elastic otherwise.
        """
        work, rate = float(self.work[high, index] - self.work[low, index]), self.point_rate
        if rate is None:
            return work, -work if self.impulsive else 0.0
        here = slice(low, high + 1)
        mine = np.flatnonzero(self.pair_of == index)
        laws = sum(
            self.points[k].law.dissipated(self.point_gap[here, k], rate[here, k]) for k in mine
        )
        return work, laws

    @property
    def largest_forces(self) -> Array:
        """Largest force of each pair by time, within its step where steps have parts [N]."""
        return self.force if self.largest is None else self.largest

    @property
    def exerted(self) -> tuple[tuple[Pair, ...], Array]:
        """The points of contact and their forces."""
        return self.points, self.point_force


class Pounding3D:
    """The bodies and links of a case whose 3D models pound.

    The system are its sticks, those of the 3D models among them, and its pairs. Lines have every
    n-th of their points, and the last one.

    Attributes:
        system: The same sticks with one pair for each line.
        points: The points of contact, line by line, then pairs of two sticks.
        pair_of: Index of the pair of each of them.
        assembly: The bodies with the points as links.
    """

    def __init__(self, case: Case, system: System, given: Models3D, *, every: int = 1) -> None:
        self._given = given
        in_3d = {contact.name for contact in case.contacts if case.touches_in_3d(contact)}
        sticks = tuple(stick for stick in system.sticks if stick.name not in given.models)
        self._sticks = System(
            sticks, tuple(pair for pair in system.pairs if pair.name not in in_3d)
        )
        contacts = ContactPoints.of(case, system, given.lines, self._port, every)
        self.system = System(system.sticks, contacts.pairs)
        self.points, self.pair_of = contacts.points, contacts.pair_of
        self._contacts = contacts
        self.unilateral = any(pair.law.unilateral for pair in self.points)
        self.impulsive = case.pounding.unilateral_scheme == "moreau"
        self._case = case
        self.assembly = Assembly(
            [self._body(building) for building in case.buildings],
            [*contacts.links, *self._sticks.assembly.links],
        )

    def _body(self, building: Building) -> Body:
        """Body of a building, with the ports of its lines."""
        ports = self._contacts.ports[building.name]
        if building.name not in self._given.models:
            names = [stick.name for stick in self._sticks.sticks]
            body = self._sticks.modes[names.index(building.name)][1]
            return replace(body, ports={**body.ports, **ports})
        model = self._given.models[building.name]
        return Body(
            name=building.name,
            eigenvalue=model.eigenvalue,
            damping=building.damping.law,
            participation=-model.ground,
            rigid_mass=np.zeros((DOFS, DOFS)),
            ports=ports,
        )

    def _port(self, side: Side) -> Port:
        """Motion of the points of a line along its normal, by the coordinates of one building."""
        model = self._given.models.get(side.at.building)
        share, normal = side.share, side.line.normal
        if model is None:
            names = [stick.name for stick in self._sticks.sticks]
            k = names.index(side.at.building)
            stick, (basis, _) = self._sticks.sticks[k], self._sticks.modes[k]
            translations = (stick.translation(side.at.master, r) for r in side.end.offset)
            moved = share.T @ np.array([normal @ one for one in translations])
            return Port(moved @ basis, moved @ stick.rigid_body())
        column = {str(name): k for k, name in enumerate(model.names)}
        # Forces push inwards, on the first building against the normal.
        rows = side.sign * model.edges[:, [column[force.name] for force in side.end.forces]]
        return Port(share.T @ rows.T, np.zeros((share.shape[1], DOFS)))

    @cached_property
    def massless_points(self) -> MasslessPoints:
        """The bodies, those of 3D models without mass at their contact points."""
        frequency = self._case.pounding.contact_frequency
        if frequency is None:
            transient = self._case.transient
            frequency = (
                CORNER * FURTHER_SHIFTS[-1] * (SHIFT if transient is None else transient.shift)
            )
        shift = (2.0 * np.pi * frequency) ** 2
        return MasslessPoints.of(self.assembly, dict.fromkeys(self._given.models, shift))

    @cached_property
    def compliance(self) -> Array:
        """Compliance of the surfaces at the points of contact, shape (m,) [m/N]."""
        laws = {contact.name: contact.law for contact in self._case.contacts}
        found = np.zeros(len(self.points))
        for k, weight in enumerate(self._contacts.weight):
            point = self.points[k]
            law = self._case.contact_laws[laws[point.line]]
            stiffness = law.edge_stiffness if isinstance(law, UnilateralLaw) else RIGID
            if isinstance(stiffness, str):
                continue
            if stiffness is None:
                ends = [end for end in (point.a, point.b) if end is not None]
                found[k] = sum(self._local(end.building) for end in ends) / weight
            else:
                found[k] = 1.0 / (stiffness * weight)
        return found

    def _local(self, building: str) -> float:
        """Compliance of the edges of a building's slabs, for a length of 1 m."""
        material = self._case.building(building).material
        return 1.0 / strip_stiffness(material.young_modulus, material.poisson_ratio)

    def respond(
        self, ground: Array | Ground, time_step: float, loads: Sequence[Load] = ()
    ) -> Response3D:
        """Return the response to a ground motion, as `simulate` takes it, at a time step [s].

        Further loads act at mass centres of sticks, and along the edges of floors of 3D models.

        Raises:
            SolutionError: The start penetrates, the response is not finite, or the contact forces
                are not found.
        """
        ground = as_ground(ground)
        patterns, amplitudes = self._loads(ground, loads)
        apart = opened(self.points, ground)
        # First the contact forces, with the motion of the sticks alone.
        solve = self._smooth
        if self.unilateral:
            solve = self._moreau if self.impulsive else self._massless
        contact = solve(ground, time_step, patterns, amplitudes, apart)
        basis = self._sticks.basis
        u_sticks, v_sticks = contact.z @ basis.T, contact.v @ basis.T
        a_sticks = self._accelerations(u_sticks, v_sticks, contact.force, ground, loads)
        sticks = Motions(u_sticks, v_sticks, a_sticks)
        # Then the 3D models by equation (1). Of unilateral points, only the gaps are known already.
        wanted = self._in_storeys if self.unilateral else np.arange(len(self.assembly.gaps))
        forces = contact.mean, contact.force
        models = self._motions(time_step, patterns, amplitudes, forces, wanted)
        motions = self._joined(ground, sticks, models)
        change, rate = self._opened(sticks, models, wanted)
        if apart is not None:
            change, rate = change + apart[0][:, wanted], rate + apart[1][:, wanted]
        gap = self.assembly.gaps + change if contact.gap is None else contact.gap
        joined = np.eye(len(self.system.pairs))[self.pair_of]
        work = contact.work
        if work is None:
            work = np.cumsum(np.diff(gap, axis=0) * contact.mean, axis=0)
            work = np.vstack([np.zeros(work.shape[1]), work])
        return Response3D(
            system=self.system,
            time_step=time_step,
            u=motions.u,
            v=motions.v,
            force=contact.force @ joined,
            ground=ground.acceleration,
            energy=contact.energy,
            relative=ground.relative,
            loads=tuple(loads),
            in_3d=tuple(self._given.models),
            pause=SEPARATION,
            residual=contact.residual,
            parts=contact.parts,
            acceleration=motions.a,
            gap=self._least(gap),
            least_gap=self._least(gap, ends=True),
            gap_rate=self._rates(ground, motions.v, rate, wanted),
            points=self.points,
            pair_of=self.pair_of,
            point_force=contact.force,
            point_gap=gap,
            point_rate=None if self.unilateral else rate,
            work=work @ joined,
            impulsive=self.unilateral and self.impulsive,
            largest=contact.largest,
        )

    def _motion(self, assembly: Assembly, h: float, patterns: Array) -> ModalMotion:
        """Motion under loads, with the coordinates of the sticks as probes."""
        return ModalMotion(
            assembly,
            h,
            load=patterns,
            push=np.pad(assembly.attached.push, ((0, 0), (0, patterns.shape[1] - 3))),
            probes=np.eye(len(assembly))[:, self._of_sticks],
        )

    def _massless(
        self, ground: Ground, h: float, patterns: Array, amplitudes: Array, apart: Array | None
    ) -> _Contact:
        """Forces of contact points without mass."""
        points = self.massless_points
        joined = np.eye(len(self.system.pairs))[self.pair_of]
        history = massless_response(
            points,
            self._motion(points.assembly, h, patterns),
            len(ground.acceleration) - 1,
            compliance=self.compliance,
            amplitudes=amplitudes,
            opened=apart,
            groups=joined,
        )
        made = _Contact.of(history)
        return made._replace(work=history.work, largest=history.largest, parts=history.parts)

    def _moreau(
        self, ground: Ground, h: float, patterns: Array, amplitudes: Array, apart: Array | None
    ) -> _Contact:
        """Forces by the impulses of Moreau's scheme with θ = ½."""
        motion = self._motion(self.assembly, h, patterns)
        history = unilateral_response(
            motion,
            self.assembly.gaps,
            len(ground.acceleration) - 1,
            amplitudes=amplitudes,
            opened=apart,
        )
        return _Contact.of(history)

    def _smooth(
        self, ground: Ground, h: float, patterns: Array, amplitudes: Array, apart: Array | None
    ) -> _Contact:
        """Forces by contact laws, with the implicit loop."""
        kept, f = self._of_sticks, amplitudes @ patterns.T
        start = Start(recorded=kept)
        motion = respond(self.assembly, f, ground.acceleration, h, start=start, opened=apart)
        z, v = np.zeros((2, len(f), kept.size))
        moving = np.searchsorted(kept, motion.moving)
        z[:, moving], v[:, moving] = motion.u, motion.v
        mean = 0.5 * (motion.force[:-1] + motion.force[1:])
        return _Contact(mean, motion.force, z, v, motion.energy)

    def free(
        self, ground: Array | Ground, time_step: float, loads: Sequence[Load] = ()
    ) -> Response:
        """Return the response with nothing between the buildings, without energies."""
        ground = as_ground(ground)
        n_t = len(ground.acceleration)
        none, every = np.zeros((n_t, 0)), np.arange(len(self.points))
        sticks = Motions(none, none, none)
        if self._sticks.sticks:
            under = self._under_sticks(ground)
            moved = simulate(
                self._sticks.without_contact(), under, time_step, loads=self._on_sticks(loads)
            )
            sticks = Motions(moved.u, moved.v, moved.acceleration)
            add_ground(self._sticks, under, sticks, sign=-1.0)
        patterns, amplitudes = self._loads(ground, loads)
        models = self._motions(time_step, patterns, amplitudes, (none[1:], none), every)
        motions = self._joined(ground, sticks, models)
        gap = self.assembly.gaps + self._opened(sticks, models, every)[0]
        if (apart := opened(self.points, ground)) is not None:
            gap = gap + apart[0]
        return Response3D(
            system=self.system.without_contact(),
            time_step=time_step,
            u=motions.u,
            v=motions.v,
            force=none,
            ground=ground.acceleration,
            relative=ground.relative,
            energy=Energy(*np.zeros((4, n_t))),
            loads=tuple(loads),
            in_3d=tuple(self._given.models),
            acceleration=motions.a,
            gap=self._least(gap),
            least_gap=self._least(gap, ends=True),
            gap_rate=none,
            points=(),
            pair_of=every[:0],
            point_force=none,
            point_gap=none,
            point_rate=None,
            work=none,
            impulsive=False,
            largest=None,
        )

    @cached_property
    def _of_sticks(self) -> Index:
        """Indices of the coordinates of the sticks in the assembly."""
        every = np.arange(len(self.assembly))
        return np.concatenate(
            [every[:0], *(every[self.assembly.columns[one.name]] for one in self._sticks.sticks)]
        )

    def _under_sticks(self, ground: Ground) -> Ground:
        relative = {k: x for k, x in ground.relative.items() if k not in self._given.models}
        return replace(ground, relative=relative)

    def _on_sticks(self, loads: Sequence[Load]) -> list[Load]:
        return [load for load in loads if load.at.building not in self._given.models]

    def _loads(self, ground: Ground, loads: Sequence[Load]) -> tuple[Array, Array]:
        """Patterns of all loads on the coordinates, and their amplitudes."""
        rows = np.zeros((len(self.assembly), len(loads)))
        for row, load in zip(rows.T, loads, strict=True):
            if load.at.building in self._given.models:
                name, model = load.at.building, self._given.models[load.at.building]
                column = {str(known): k for k, known in enumerate(model.names)}
                outward, shares = self._given.pushes[name, load.at.floor]
                for force, share in shares:
                    pushed = share * model.edges[:, column[force.name]]
                    row[self.assembly.columns[name]] -= float(load.direction @ outward) * pushed
                continue
            row[self._of_sticks] = self._sticks.row(load.at, load.direction) @ self._sticks.basis
        patterns, amplitudes = [self.assembly.ground], [ground.acceleration]
        for name, (_, _, a) in ground.relative.items():
            here = self.assembly.columns[name]
            patterns.append(np.zeros_like(patterns[0]))
            patterns[-1][here] = patterns[0][here]
            amplitudes.append(a)
        forces = [load.force for load in loads]
        return np.hstack([*patterns, rows]), np.column_stack([*amplitudes, *forces])

    def _motions(
        self,
        h: float,
        patterns: Array,
        amplitudes: Array,
        forces: tuple[Array, Array],
        wanted: Index,
    ) -> dict[str, ModelMotions]:
        """Motions of the floors of each 3D model by equation (1), relative to the ground.

        `forces` are the means of the steps and those at the times; `wanted` are the points whose
        gaps are wanted.
        """
        mean, force = forces
        touching = np.flatnonzero(mean.any(axis=1))
        pressed = np.flatnonzero(force.any(axis=1))
        steps = 0.5 * (amplitudes[:-1] + amplitudes[1:])
        motions = dict[str, ModelMotions]()
        for name, model in self._given.models.items():
            here = self.assembly.columns[name]
            λ, d = self.assembly.eigenvalue[here], self.assembly.damping[here]
            b, gamma = patterns[here], self.assembly.gamma[: force.shape[1], here]
            count = len(self.system.stick(name).floors)
            rows = model.points[-count:].reshape(DOFS * count, len(λ))
            touched = self.assembly.gamma[wanted, here]
            v, a = np.zeros((2, len(rows), len(amplitudes)))
            rate = np.zeros((len(wanted), len(amplitudes)))
            for first in range(0, len(λ), AT_ONCE):
                some = slice(first, first + AT_ONCE)
                # Modal loads: the mean f of each step, and f at the times.
                f_mean, f = b[some] @ steps.T, b[some] @ amplitudes.T
                f_mean[:, touching] += gamma[:, some].T @ mean[touching].T
                f[:, pressed] += gamma[:, some].T @ force[pressed].T
                one, rest = np.ones(len(f)), np.zeros(len(f))
                # (1): v_m = (v₀ + h/2 (f - λ u₀)) / (1 + h d/2 + h² λ/4), mode by mode.
                inverse = 1.0 / (1.0 + 0.5 * h * d[some] + 0.25 * h**2 * λ[some])
                modes = Modes(one, d[some], λ[some], inverse)
                z, ż = (np.zeros(f.shape) for _ in range(2))
                z[:, 1:], ż[:, 1:], _ = march_modes(
                    modes, rest, rest, f_mean, h, 0.5, counted=False
                )
                # Equilibrium at the times: z̈ = f - d ż - λ z.
                f -= d[some, None] * ż + λ[some, None] * z
                for x, Φ, q in ((v, rows, ż), (a, rows, f), (rate, touched, ż)):
                    x += Φ[:, some] @ q
            # As u₁ = u₀ + h v_m holds in each mode, it does at each place.
            u, gap = (cumulative_trapezoid(x, dx=h, initial=0.0) for x in (v, rate))
            motions[name] = ModelMotions(*(np.ascontiguousarray(x.T) for x in (u, v, a, gap, rate)))
        return motions

    @cached_property
    def _in_storeys(self) -> Index:
        """Indices of the points of lines that meet a storey, where no mass centre is."""
        ends = [(k, end) for k, point in enumerate(self.points) for end in (point.a, point.b)]
        inside = [k for k, end in ends if end is not None and end.relative_height is not None]
        return np.array(inside, dtype=np.int64)

    @cached_property
    def _pressed(self) -> Array:
        """Rows of the points of contact for the masters of the sticks, shape (m, their n)."""
        return self.assembly.gamma[:, self._of_sticks] @ np.linalg.inv(self._sticks.basis)

    def _opened(
        self, sticks: Motions, models: Mapping[str, ModelMotions], points: Index
    ) -> tuple[Array, Array]:
        """Change of the gaps of points by the motion of all buildings, and their rates."""
        gap, rate = (x @ self._pressed[points].T for x in (sticks.u, sticks.v))
        for model in models.values():
            gap, rate = gap + model.gap, rate + model.rate
        return gap, rate

    def _least(self, gap: Array, *, ends: bool = False) -> Array:
        """Least gap of the points of each pair, and of the ends of lines.

        A point moves by the mean along its hat, an outermost one as a place inside the line; floors
        that rotate come closest at the ends, which replace the outermost points on request.
        """
        if ends:
            rest, points = np.array([pair.gap for pair in self.points]), self._contacts
            moved, gap = (gap - rest) @ points.ends.T, gap.copy()
            gap[:, points.outermost] = rest[points.outermost] + moved
        pairs = range(len(self.system.pairs))
        return np.column_stack([gap[:, self.pair_of == k].min(axis=1) for k in pairs])

    def _rates(self, ground: Ground, velocity: Array, rate: Array, points: Index) -> Array:
        """Rates of the gaps of all pairs: at the middles, in storeys the mean of the points."""
        rates = opening(self.system, velocity, ground.relative, 1)
        for k in np.unique(self.pair_of[self._in_storeys]):
            rates[:, k] = rate[:, self.pair_of[points] == k].mean(axis=1)
        return np.asarray(rates)

    def _accelerations(
        self, u: Array, v: Array, force: Array, ground: Ground, loads: Sequence[Load]
    ) -> Array:
        """Accelerations of the sticks from their equilibrium; zero of points without mass."""
        one = self._sticks
        moved = ground.acceleration @ one.ground.T
        add_ground(one, self._under_sticks(ground), [moved], first=2)
        balance = force @ self._pressed - moved @ one.M - v @ one.C - u @ one.K
        for load in self._on_sticks(loads):
            balance += np.outer(load.force, one.row(load.at, load.direction))
        mass = np.diag(one.M)
        return np.divide(balance, mass, out=np.zeros_like(balance), where=mass > 0.0)

    def _joined(
        self, ground: Ground, sticks: Motions, models: Mapping[str, ModelMotions]
    ) -> Motions:
        """Motions of all masters, shape (n_t, n) each.

        Relative to the ground under the first building, from those to the ground under each.
        """
        n_t = len(ground.acceleration)
        motions = np.zeros((3, n_t, sum(stick.n for stick in self.system.sticks)))
        for stick in self.system.sticks:
            start = self.system.offsets[stick.name]
            if stick.name in models:
                own: Sequence[Array] = models[stick.name][:3]
            else:
                first = self._sticks.offsets[stick.name]
                own = [x[:, first : first + stick.n] for x in sticks]
            for x, history in zip(motions, own, strict=True):
                x[:, start : start + history.shape[1]] = history
        add_ground(self.system, ground, list(motions))
        return Motions(*motions)
