"""Buildings that pound by their reduced 3D models: with each other, with sticks and rigid walls.

All are bodies in one time loop: a 3D model by all vectors of its reduced building, a stick by all
of its modes. A line has one link for each of its points of contact, with the law of the pair for
the part w_i / Σ w of its area; a unilateral one has no law, and its impulses are found by Moreau's
scheme with θ = ½. Both loops are the average acceleration rule: once the forces are known, the
motion of the 3D models follows mode by mode from their mean f in a step h,

    v_m = (v₀ + h/2 (f - λ u₀)) / (1 + h d/2 + h² λ/4),  v₁ = 2 v_m - v₀,  u₁ = u₀ + h v_m.   (1)

The forces that are handed on are straight in time between the steps. Of impulses P in the steps
they are the mean of P/h before and after each time, which keeps the impulse.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid

from impactfem.building.mesh import DOFS
from impactfem.case import Case
from impactfem.coupling.body import Body, Port
from impactfem.coupling.contact import UNILATERAL
from impactfem.coupling.from_case import law_between
from impactfem.coupling.ground import Ground, as_ground
from impactfem.coupling.implicit import respond
from impactfem.coupling.links import Assembly, Link
from impactfem.coupling.pounding import (
    End,
    Load,
    Pair,
    Response,
    System,
    add_ground,
    opened,
    opening,
    simulate,
    taken,
)
from impactfem.coupling.unilateral import ModalMotion, march_modes, unilateral_response
from impactfem.dynamics.energy import Energy
from impactfem.reduction.contact_line import ContactLine, LineEnd
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.system.arrays import Array, Index

SEPARATION = 5e-3
"""Pulses less than this apart are one impact [s]: a slab's waves take some ms, its return 0.1 s."""
AT_ONCE = 64
"""Modes of a building that are followed in time at once."""


@dataclass(frozen=True, eq=False)
class Models3D:
    """The 3D models that pound, and the lines along which they touch."""

    lines: tuple[ContactLine, ...]
    models: Mapping[str, CompleteModel]  #: by building; its last points are the floors' centres
    #: By building and floor that is loaded, the outward normal of its edge, shape (3,), and what
    #: pushes it inwards.
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
    least_gap: Array  #: the same with the ends of lines for the outermost points, same shape [m]
    gap_rate: Array  #: at the middles, in storeys the mean of the points, same shape [m/s]
    points: tuple[Pair, ...]  #: the points of contact, line by line, then pairs of two sticks
    pair_of: Index  #: of each of them the index of its pair
    point_force: Array  #: shape (n_t, n_points) [N]
    point_gap: Array  #: same shape [m]
    point_rate: Array | None  #: of the gaps, same shape [m/s]; None for unilateral contact
    work: Array  #: of each pair on the buildings since the start, shape (n_t, n_pairs) [J]

    def closed(self, pairs: Sequence[Pair]) -> Array:
        """How far lines have closed the least gap of each, at a point or an end, (n_t, m) [m]."""
        return np.asarray([pair.gap for pair in pairs] - self.least_gap)

    def exchanged(self, index: int, low: int, high: int) -> tuple[float, float]:
        """Work of a line's forces between two times, and what its laws take [J].

        A unilateral one takes what the impulses do.
        """
        work, rate = float(self.work[high, index] - self.work[low, index]), self.point_rate
        if rate is None:
            return work, -work
        here = slice(low, high + 1)
        mine = np.flatnonzero(self.pair_of == index)
        laws = sum(taken(self.points[k].law, self.point_gap[here, k], rate[here, k]) for k in mine)
        return work, laws

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
        pair_of: Of each of them the index of its pair.
        assembly: The bodies with the points as links.
    """

    def __init__(self, case: Case, system: System, given: Models3D, *, every: int = 1) -> None:
        self._given = given
        in_3d = {one.name: one for one in case.contacts if case.touches_in_3d(one)}
        first = {pair.name: pair for pair in system.pairs}
        every_stick = {one.name: one for one in system.sticks}
        others = tuple(pair for pair in system.pairs if pair.name not in in_3d)
        alone = tuple(one for one in system.sticks if one.name not in given.models)
        self._sticks = System(alone, others)
        lines, points, number, links = list[Pair](), list[Pair](), list[int](), list[Link]()
        ports: dict[str, dict[str, Port]] = {one.name: {} for one in system.sticks}
        ends_of: list[tuple[int, Array]] = []
        for line in given.lines:
            share, w, gaps = line.joined(every)
            one = first[line.name]
            ends = [(line.a, one.a)]
            if line.b is not None and one.b is not None:
                ends.append((line.b, one.b))
            # At its middle, wherever its pairs are: they say where it is and what its gaps are.
            middles = [replace(at, offset=line.middle(end)) for end, at in ends]
            law = law_between(case, in_3d[line.name], every_stick, middles)
            # Several pairs of a line press together.
            law = law if law.code == UNILATERAL else law.part(len(line.pair_names))
            areas = [first[name].area for name in line.pair_names]
            area = None if None in areas else sum(a for a in areas if a is not None)
            a, b = middles[0], middles[1] if len(middles) > 1 else None
            lines.append(replace(one, a=a, b=b, law=law, gap=float(line.gap.min()), area=area))
            for (end, at), sign in zip(ends, (-1.0, 1.0), strict=False):
                ports[at.building][line.name] = self._port(line, end, at, sign, share)
            # The ground, which a rigid wall moves with, has no port.
            second = None if one.b is None else (one.b.building, line.name)
            for k, shares in enumerate(share.T):
                placed = [
                    replace(at, offset=tuple((shares @ end.offset).tolist())) for end, at in ends
                ]
                name = f"{line.name} at {shares @ line.position:.4f} m"
                part = law if law.code == UNILATERAL else law.part(float(w[k] / w.sum()))
                gap, hats = float(gaps[k]), None
                if every == 1:
                    hats = np.full((2, 3), np.nan)
                    hats[: len(ends)] = [end.hats[k] for end, _ in ends]
                between = placed[0], placed[1] if len(ends) > 1 else None
                pair = Pair(name, *between, one.normal, gap, part, hats=hats, line=line.name)
                points.append(pair)
                places = (one.a.building, line.name), second
                along = np.eye(len(w))[k]
                links.append(
                    Link(name, *places, along, gap, None if law.code == UNILATERAL else part)
                )
            number += [len(lines) - 1] * len(w)
            if len(w) > 1 and not any(at.relative_height is not None for at in middles):
                ends_of.append((len(points) - len(w), line.at_ends(share)))
        self.system = System(system.sticks, (*lines, *others))
        self.points = (*points, *others)
        self.pair_of = np.array([*number, *range(len(lines), len(lines) + len(others))])
        #: The outermost points of lines, and what gives the motion of the ends by that of points.
        self._outermost = np.array(
            [(begin, begin + rows.shape[1] - 1) for begin, rows in ends_of], dtype=np.int64
        ).ravel()
        self._ends = np.zeros((len(self._outermost), len(self.points)))
        for k, (begin, rows) in enumerate(ends_of):
            self._ends[2 * k : 2 * k + 2, begin : begin + rows.shape[1]] = rows
        self.unilateral = any(pair.law.code == UNILATERAL for pair in self.points)
        sticks = dict(zip((one.name for one in alone), self._sticks.modes, strict=True))
        bodies = []
        for building in case.buildings:
            name = building.name
            if name in sticks:
                body = sticks[name][1]
                bodies.append(replace(body, ports={**body.ports, **ports[name]}))
                continue
            model, none = given.models[name], np.zeros((DOFS, DOFS))
            damping = building.damping.law
            bodies.append(Body(name, model.eigenvalue, damping, -model.ground, none, ports[name]))
        self.assembly = Assembly(bodies, [*links, *self._sticks.assembly.links])

    def _port(self, line: ContactLine, end: LineEnd, at: End, sign: float, share: Array) -> Port:
        """Motion of the points of a line along its normal, of the building on one side."""
        model = self._given.models.get(at.building)
        if model is None:
            k = [one.name for one in self._sticks.sticks].index(at.building)
            stick, (basis, _) = self._sticks.sticks[k], self._sticks.modes[k]
            translations = [stick.translation(at.master, place) for place in end.offset]
            moved = share.T @ np.array([line.normal @ one for one in translations])
            return Port(moved @ basis, moved @ stick.rigid_body())
        column = {str(name): k for k, name in enumerate(model.names)}
        # Forces push inwards, on the first building against the normal.
        rows = sign * model.edges[:, [column[force.name] for force in end.forces]]
        return Port(share.T @ rows.T, np.zeros((share.shape[1], DOFS)))

    def respond(
        self, ground: Array | Ground, time_step: float, loads: Sequence[Load] = ()
    ) -> Response3D:
        """The response to a ground motion, as `simulate` takes it, at a time step [s].

        Further loads act at mass centres of sticks, and along the edges of floors of 3D models.

        Raises:
            SolutionError: The start penetrates, the response is not finite, or the contact forces
                are not found.
        """
        ground = as_ground(ground)
        one, h, n_t = self.assembly, time_step, len(ground.acceleration)
        apart = opened(self.points, ground)
        patterns, amplitudes = self._loads(ground, loads)
        kept, residual = self._of_sticks, 0.0
        if self.unilateral:
            push = np.pad(one.attached.push, ((0, 0), (0, patterns.shape[1] - 3)))
            motion = ModalMotion(one, h, load=patterns, push=push, probes=np.eye(len(one))[:, kept])
            found = unilateral_response(
                *(motion, one.gaps, n_t - 1), amplitudes=amplitudes, opened=apart
            )
            # Row k is the mean of the step that ends at k; the ends keep their half of a step.
            mean = found.force[1:]
            force = 0.5 * (found.force + np.vstack([mean, mean[-1:]]))
            force[0] = mean[0]
            z, v, energy = found.displacement, found.velocity, found.energy
            residual, wanted = float(found.residual.max()), self._in_storeys
        else:
            f, a_g = amplitudes @ patterns.T, ground.acceleration
            moved = respond(one, f, a_g, h, recorded=kept, opened=apart)
            force, energy = moved.force, moved.energy
            mean = 0.5 * (force[:-1] + force[1:])
            z, v = np.zeros((2, n_t, kept.size))
            here = np.searchsorted(kept, moved.moving)
            z[:, here], v[:, here] = moved.u, moved.v
            wanted = np.arange(len(one.gaps))
        u_sticks, v_sticks = z @ self._sticks.basis.T, v @ self._sticks.basis.T
        a_sticks = self._accelerations(u_sticks, v_sticks, force, ground, loads)
        models = self._motions(h, patterns, amplitudes, (mean, force), wanted)
        u, v, a = self._joined(ground, (u_sticks, v_sticks, a_sticks), models)
        change, rate = self._opened((u_sticks, v_sticks), models, wanted)
        if apart is not None:
            change, rate = change + apart[0][:, wanted], rate + apart[1][:, wanted]
        gap = found.gap if self.unilateral else one.gaps + change
        joined = np.eye(len(self.system.pairs))[self.pair_of]
        work = np.cumsum((np.diff(gap, axis=0) * mean) @ joined, axis=0)
        return Response3D(
            *(self.system, h, u, v, force @ joined, ground.acceleration, energy),
            relative=ground.relative,
            loads=tuple(loads),
            in_3d=tuple(self._given.models),
            pause=SEPARATION,
            residual=residual,
            acceleration=a,
            gap=self._least(gap),
            least_gap=self._least(gap, ends=True),
            gap_rate=self._rates(ground, v, rate, wanted),
            points=self.points,
            pair_of=self.pair_of,
            point_force=force,
            point_gap=gap,
            point_rate=None if self.unilateral else rate,
            work=np.vstack([np.zeros(len(self.system.pairs)), work]),
        )

    def free(
        self, ground: Array | Ground, time_step: float, loads: Sequence[Load] = ()
    ) -> Response:
        """The response with nothing between the buildings, without energies; as `respond`."""
        ground = as_ground(ground)
        n_t = len(ground.acceleration)
        none, every = np.zeros((n_t, 0)), np.arange(len(self.points))
        of_sticks = none, none, none
        if self._sticks.sticks:
            moved = simulate(
                *(self._sticks.without_contact(), self._under_sticks(ground), time_step),
                loads=self._on_sticks(loads),
            )
            of_sticks = moved.u, moved.v, moved.acceleration
            add_ground(self._sticks, self._under_sticks(ground), of_sticks, sign=-1.0)
        models = self._motions(time_step, *self._loads(ground, loads), (none[1:], none), every)
        u, v, a = self._joined(ground, of_sticks, models)
        gap = self.assembly.gaps + self._opened(of_sticks[:2], models, every)[0]
        if (apart := opened(self.points, ground)) is not None:
            gap = gap + apart[0]
        return Response3D(
            *(self.system.without_contact(), time_step, u, v, none, ground.acceleration),
            relative=ground.relative,
            energy=Energy(*np.zeros((4, n_t))),
            loads=tuple(loads),
            in_3d=tuple(self._given.models),
            acceleration=a,
            gap=self._least(gap),
            least_gap=self._least(gap, ends=True),
            gap_rate=none,
            points=(),
            pair_of=every[:0],
            point_force=none,
            point_gap=none,
            point_rate=None,
            work=none,
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
    ) -> dict[str, tuple[Array, ...]]:
        """Displacements, velocities and accelerations of the floors of each 3D model.

        Relative to the ground, shape (n_t, 6 n_floors) each, by equation (1), from the mean forces
        of the steps and those at the times. After them the change of the gaps of some points by its
        motion, and their rates, shape (n_t, number of them) each.
        """
        mean, force = forces
        touching = np.flatnonzero(mean.any(axis=1))
        pressed = np.flatnonzero(force.any(axis=1))
        steps = 0.5 * (amplitudes[:-1] + amplitudes[1:])
        found = dict[str, tuple[Array, ...]]()
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
                f_mean, f = b[some] @ steps.T, b[some] @ amplitudes.T
                f_mean[:, touching] += gamma[:, some].T @ mean[touching].T
                f[:, pressed] += gamma[:, some].T @ force[pressed].T
                one, rest = np.ones(len(f)), np.zeros(len(f))
                inverse = 1.0 / (1.0 + 0.5 * h * d[some] + 0.25 * h**2 * λ[some])
                modes = one, d[some], λ[some], inverse
                z, ż = (np.zeros(f.shape) for _ in range(2))
                z[:, 1:], ż[:, 1:], _ = march_modes(
                    *(*modes, rest, rest, f_mean, h, 0.5), counted=False
                )
                f -= d[some, None] * ż + λ[some, None] * z
                for x, Φ, q in ((v, rows, ż), (a, rows, f), (rate, touched, ż)):
                    x += Φ[:, some] @ q
            # What moves as u₁ = u₀ + h v_m in each mode does so at each place.
            u, gap = (cumulative_trapezoid(x, dx=h, initial=0.0) for x in (v, rate))
            found[name] = tuple(np.ascontiguousarray(x.T) for x in (u, v, a, gap, rate))
        return found

    @cached_property
    def _in_storeys(self) -> Index:
        """Indices of the points of lines that meet a storey, where no mass centre is."""
        ends = [(k, end) for k, point in enumerate(self.points) for end in (point.a, point.b)]
        inside = [k for k, end in ends if end is not None and end.relative_height is not None]
        return np.array(inside, dtype=np.int64)

    @cached_property
    def _pressed(self) -> Array:
        """What each point of contact does to the masters of the sticks, shape (m, n of these)."""
        return self.assembly.gamma[:, self._of_sticks] @ np.linalg.inv(self._sticks.basis)

    def _opened(
        self, of_sticks: tuple[Array, ...], models: Mapping[str, tuple[Array, ...]], points: Index
    ) -> tuple[Array, Array]:
        """Change of the gaps of points by the motion of all buildings, and their rates."""
        gap, rate = (x @ self._pressed[points].T for x in of_sticks)
        for *_, of_gap, of_rate in models.values():
            gap, rate = gap + of_gap, rate + of_rate
        return gap, rate

    def _least(self, gap: Array, *, ends: bool = False) -> Array:
        """Least gap of the points of each pair, and of the ends of lines.

        A point moves by the mean along its hat, an outermost one as a place inside the line; floors
        that turn come closest at the ends, which take the place of these where asked for.
        """
        if ends:
            rest, inside = np.array([pair.gap for pair in self.points]), gap
            gap = inside.copy()
            gap[:, self._outermost] = rest[self._outermost] + (inside - rest) @ self._ends.T
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
        self, ground: Ground, of_sticks: tuple[Array, ...], models: Mapping[str, tuple[Array, ...]]
    ) -> tuple[Array, Array, Array]:
        """Displacements, velocities, accelerations of all masters, shape (n_t, n) each.

        Relative to the ground under the first building, from those to the ground under each.
        """
        n_t = len(ground.acceleration)
        found = np.zeros((3, n_t, sum(one.n for one in self.system.sticks)))
        for one in self.system.sticks:
            start = self.system.offsets[one.name]
            if one.name in models:
                own = models[one.name][:3]
            else:
                first = self._sticks.offsets[one.name]
                own = tuple(x[:, first : first + one.n] for x in of_sticks)
            for x, history in zip(found, own, strict=True):
                x[:, start : start + history.shape[1]] = history
        add_ground(self.system, ground, list(found))
        return found[0], found[1], found[2]
