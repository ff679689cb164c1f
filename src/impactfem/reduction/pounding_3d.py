"""Buildings that pound by their reduced 3D models: with each other, with sticks and rigid walls.

All are bodies in one time loop: a 3D model by all vectors of its reduced building, a stick by all
of its modes, on soil both with the six coordinates of their base. A line has one link for each of
its points of contact, with the law of the pair for the part w_i / Σ w of its area; a unilateral one
has no law. Its forces are those of contact points without mass (`massless`) or, on request,
impulses of Moreau's scheme with θ = ½. All loops are the average acceleration rule: once the forces
are known, buildings with all of their mass move by the mean force of each step (`forced_motion`).

The forces that are handed on are straight in time between the steps. Of impulses P in the steps
they are the mean of P/h before and after each time, which keeps the impulse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from impactfem.case import Building, Case
from impactfem.case.contacts import UnilateralLaw
from impactfem.case.quantity import RIGID
from impactfem.case.transient import SHIFT
from impactfem.coupling.base import base_histories
from impactfem.coupling.body import Body, Port
from impactfem.coupling.contact_loop import ContactHistory
from impactfem.coupling.forced_motion import ForcedMotion, GivenLoads, forced_motion
from impactfem.coupling.ground import Ground, as_ground
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.line_response import least_gap, sums_of_pairs
from impactfem.coupling.links import Assembly
from impactfem.coupling.massless import (
    RESOLVED,
    MasslessPoints,
    massless_response,
    strip_stiffness,
)
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.coupling.pounding import Load, System, add_ground, opened, opening
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.energy import Energy
from impactfem.reduction.contact_points import ContactPoints, Side
from impactfem.reduction.models_3d import MASTERS, Models3D, lowest
from impactfem.reduction.reduced_building import FURTHER_SHIFTS
from impactfem.reduction.response_3d import Response3D
from impactfem.system.arrays import Array, Index

SEPARATION = 5e-3
"""Pulses less than this apart are one impact [s]: a slab's waves take some ms, its return 0.1 s."""
CORNER = 4.0
"""Frequency above which contact points have no mass, over the highest one at which a reduced
building has the response to each contact force. With 1, 2 and 4 floor spectra of the paper's pair
at 100 Hz are off by 6, 3 and 0.9 %, impulses by 0.4, 0.2 and 0.04 %: damping of the part without
mass is missing."""


def contact_frequency(case: Case) -> float:
    """Return the frequency above which contact points of a case have no mass [Hz]."""
    if case.pounding.contact_frequency is not None:
        return case.pounding.contact_frequency
    return CORNER * FURTHER_SHIFTS[-1] * (SHIFT if case.transient is None else case.transient.shift)


class _Given(NamedTuple):
    """Ground and loads of a run."""

    ground: Ground
    time_step: float
    patterns: Array  #: of ground motion and loads on all coordinates, shape (r, n_patterns)
    amplitudes: Array  #: at the times, shape (n_t, n_patterns)
    apart: Array | None  #: opening of the gaps by the ground, and its rate, (2, n_t, n_points)


class _Contact(NamedTuple):
    """Contact forces."""

    mean: Array  #: means of the steps, shape (n_t - 1, n_points) [N]
    force: Array  #: forces at the times, shape (n_t, n_points) [N]
    energy: Energy
    gap: Array | None = None  #: gaps of the points, shape (n_t, n_points) [m]; None if unknown
    residual: float = 0.0
    work: Array | None = None  #: work of the points since the start, same shape; None if unknown
    largest: Array | None = None  #: largest forces of the pairs within each step, (n_t, n_pairs)
    parts: int = 1  #: equal parts of a step with contact

    @classmethod
    def none(cls, n_t: int) -> _Contact:
        """Nothing between the buildings, without energies."""
        return cls(np.zeros((n_t - 1, 0)), np.zeros((n_t, 0)), Energy(*np.zeros((4, n_t))))

    @classmethod
    def of(cls, history: ContactHistory) -> _Contact:
        """Of the steps of a loop of unilateral contact."""
        # Row k is the mean of the step that ends at k; the ends keep their half of a step.
        mean = history.force[1:]
        force = 0.5 * (history.force + np.vstack([mean, mean[-1:]]))
        force[0] = mean[0]
        residual = float(history.residual.max())
        return cls(mean, force, history.energy, gap=history.gap, residual=residual)


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
        self._bodies = {building.name: self._body(building) for building in case.buildings}
        self.assembly = Assembly(
            list(self._bodies.values()), [*contacts.links, *self._sticks.assembly.links]
        )

    def _body(self, building: Building) -> Body:
        """Body of a building, with the ports of its masters, lines and loads."""
        name, ports = building.name, dict(self._contacts.ports[building.name])
        stick = self.system.stick(name)
        if name not in self._given.models:
            names = [one.name for one in self._sticks.sticks]
            basis, body = self._sticks.modes[names.index(name)]
            ports[MASTERS] = Port(basis, stick.rigid_body())
            return replace(body, ports={**body.ports, **ports})
        for pushed, floor in self._given.pushes:
            if pushed == name:
                ports[f"load {floor}"] = self._given.pushed(name, floor)[1]
        return self._given.body(name, len(stick.floors), building.damping.law, stick.soil, ports)

    def _port(self, side: Side) -> Port:
        """Motion of the points of a line along its normal, by the coordinates of one building."""
        if side.at.building in self._given.models:
            return self._given.touched(side)
        names = [stick.name for stick in self._sticks.sticks]
        k = names.index(side.at.building)
        stick, (basis, _) = self._sticks.sticks[k], self._sticks.modes[k]
        translations = (stick.translation(side.at.master, r) for r in side.end.offset)
        moved = side.share.T @ np.array([side.line.normal @ one for one in translations])
        return Port(moved @ basis, moved @ stick.rigid_body())

    @cached_property
    def massless_points(self) -> MasslessPoints:
        """The bodies, those of 3D models without mass at their contact points."""
        shift = (2.0 * np.pi * contact_frequency(self._case)) ** 2
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
        given = self._inputs(ground, time_step, loads)
        # First the contact forces.
        if not self.unilateral:
            contact = self._smooth(given)
        else:
            contact = self._moreau(given) if self.impulsive else self._massless(given)
        # Then the motion of all buildings. Of unilateral points, only the gaps are known already.
        wanted = self._in_storeys if self.unilateral else np.arange(len(self.assembly.gaps))
        return self._response(given, contact, wanted, loads)

    def free(
        self, ground: Array | Ground, time_step: float, loads: Sequence[Load] = ()
    ) -> Response3D:
        """Return the response with nothing between the buildings, without energies."""
        given = self._inputs(ground, time_step, loads)
        contact = _Contact.none(len(given.amplitudes))
        return self._response(given, contact, np.arange(len(self.points)), loads)

    def _inputs(self, ground: Array | Ground, time_step: float, loads: Sequence[Load]) -> _Given:
        """Patterns of ground motion and loads on the coordinates, and their amplitudes."""
        ground, rows = as_ground(ground), np.zeros((len(self.assembly), len(loads)))
        for row, load in zip(rows.T, loads, strict=True):
            name, floor = load.at.building, load.at.floor
            if name in self._given.models:
                outward, _ = self._given.pushed(name, floor)
                port = self.assembly.rows((name, f"load {floor}"))[0]
                row[:] = float(load.direction @ outward) * port
            else:
                at = self.system.stick(name).translation(load.at.master, load.at.offset)
                row[:] = load.direction @ at @ self.assembly.rows((name, MASTERS))
        patterns, amplitudes = [self.assembly.ground], [ground.acceleration]
        for name, (_, _, a) in ground.relative.items():
            here = self.assembly.columns[name]
            patterns.append(np.zeros_like(patterns[0]))
            patterns[-1][here] = patterns[0][here]
            amplitudes.append(a)
        forces = [load.force for load in loads]
        return _Given(
            ground=ground,
            time_step=time_step,
            patterns=np.hstack([*patterns, rows]),
            amplitudes=np.column_stack([*amplitudes, *forces]),
            apart=opened(self.points, ground),
        )

    def _massless(self, given: _Given) -> _Contact:
        """Forces of contact points without mass."""
        # Longer steps than those of the case, for comparison, have longer parts in contact, too.
        longer = given.time_step / self._case.pounding.time_step
        points = replace(self.massless_points, resolved=RESOLVED * max(1.0, longer))
        history = massless_response(
            points,
            ModalMotion(points.assembly, given.time_step, load=given.patterns),
            len(given.amplitudes) - 1,
            compliance=self.compliance,
            amplitudes=given.amplitudes,
            opened=given.apart,
            groups=self._joined,
        )
        made = _Contact.of(history)
        return made._replace(work=history.work, largest=history.largest, parts=history.parts)

    def _moreau(self, given: _Given) -> _Contact:
        """Forces by the impulses of Moreau's scheme with θ = ½."""
        history = unilateral_response(
            ModalMotion(self.assembly, given.time_step, load=given.patterns),
            self.assembly.gaps,
            len(given.amplitudes) - 1,
            amplitudes=given.amplitudes,
            opened=given.apart,
        )
        return _Contact.of(history)

    def _smooth(self, given: _Given) -> _Contact:
        """Forces by contact laws, with the implicit loop."""
        loads, h = given.amplitudes @ given.patterns.T, given.time_step
        start = Start(recorded=np.zeros(0, dtype=np.int64))
        a_g = given.ground.acceleration
        motion = respond(self.assembly, loads, a_g, h, start=start, opened=given.apart)
        bases = base_histories(self.assembly, motion.attached, h).values()
        radiated = sum((base.radiated for base in bases), np.zeros(len(loads)))
        damped = motion.energy.damped - radiated
        return _Contact(
            mean=0.5 * (motion.force[:-1] + motion.force[1:]),
            force=motion.force,
            energy=replace(motion.energy, damped=damped, radiated=radiated),
        )

    def _response(
        self, given: _Given, contact: _Contact, wanted: Index, loads: Sequence[Load]
    ) -> Response3D:
        """Return the response to contact forces; `wanted` are the points with unknown gaps."""
        ground, touched = given.ground, contact.force.shape[1] > 0
        moved = self._moved(given, contact, wanted)
        motions = np.zeros((3, len(given.amplitudes), self.system.M.shape[0]))
        change, rate = np.zeros((2, len(given.amplitudes), len(wanted)))
        if given.apart is not None:
            change, rate = given.apart[:, :, wanted]
        for stick in self.system.sticks:
            start, one = self.system.offsets[stick.name], moved[stick.name]
            for whole, own in zip(motions, (one.u, one.v, one.a), strict=True):
                whole[:, start : start + own.shape[1]] = own
            if stick.name not in self._given.models:
                # Points without mass have no acceleration of their own.
                motions[2, :, start + np.flatnonzero(np.diag(stick.M) == 0.0)] = 0.0
            change, rate = change + one.gap, rate + one.rate
        # Relative to the ground under the first building, from those to the ground under each.
        add_ground(self.system, ground, list(motions))
        gap = self.assembly.gaps + change if contact.gap is None else contact.gap
        work = contact.work
        if work is None and touched:
            work = np.cumsum(np.diff(gap, axis=0) * contact.mean, axis=0)
            work = np.vstack([np.zeros(work.shape[1]), work])
        bases = {name: base for one in moved.values() for name, base in one.bases.items()}
        none = contact.force
        return Response3D(
            system=self.system if touched else self.system.without_contact(),
            time_step=given.time_step,
            u=motions[0],
            v=motions[1],
            force=contact.force @ self._joined if touched else none,
            ground=ground.acceleration,
            energy=contact.energy,
            relative=ground.relative,
            loads=tuple(loads),
            bases=bases,
            in_3d=tuple(self._given.models),
            pause=SEPARATION,
            residual=contact.residual,
            parts=contact.parts,
            acceleration=motions[2],
            gap=self._least(gap),
            closure=[pair.gap for pair in self.system.pairs] - self._least(gap, ends=True),
            gap_rate=self._rates(ground, motions[1], rate, wanted) if touched else none,
            points=self.points if touched else (),
            pair_of=self.pair_of if touched else self.pair_of[:0],
            point_force=contact.force,
            point_gap=gap if touched else none,
            point_rate=None if self.unilateral or not touched else rate,
            work=none if work is None else work @ self._joined,
            impulsive=touched and self.unilateral and self.impulsive,
            largest=contact.largest,
            low_bodies=self._low_bodies,
        )

    @cached_property
    def _joined(self) -> Array:
        """Columns that sum the points of each pair, shape (n_points, n_pairs)."""
        return sums_of_pairs(self.pair_of)

    @cached_property
    def _low_bodies(self) -> dict[str, Body]:
        bodies = (self._bodies[name] for name in self._given.models)
        return {body.name: lowest(body) for body in bodies if body.soil is not None}

    def _moved(self, given: _Given, contact: _Contact, wanted: Index) -> dict[str, ForcedMotion]:
        """Motion of the masters of each building, and change of the gaps of points by it."""
        moved, some = dict[str, ForcedMotion](), slice(contact.force.shape[1])
        for name, body in self._bodies.items():
            here = self.assembly.columns[name]
            loads = GivenLoads(
                patterns=given.patterns[here],
                amplitudes=given.amplitudes,
                gamma=self.assembly.gamma[some, here],
                mean=contact.mean,
                force=contact.force,
                impulsive=self.unilateral,
            )
            further = self.assembly.gamma[wanted, here]
            moved[name] = forced_motion(body, MASTERS, further, loads, given.time_step)
        return moved

    @cached_property
    def _in_storeys(self) -> Index:
        """Indices of the points of lines that meet a storey, where no mass centre is."""
        ends = [(k, end) for k, point in enumerate(self.points) for end in (point.a, point.b)]
        inside = [k for k, end in ends if end is not None and end.relative_height is not None]
        return np.array(inside, dtype=np.int64)

    def _least(self, gap: Array, *, ends: bool = False) -> Array:
        """Least gap of the points of each pair, and of the ends of lines.

        A point moves by the mean along its hat, an outermost one as a place inside the line; floors
        that rotate come closest at the ends, which replace the outermost points on request.
        """
        if ends:
            rest, points = np.array([pair.gap for pair in self.points]), self._contacts
            moved, gap = (gap - rest) @ points.ends.T, gap.copy()
            gap[:, points.outermost] = rest[points.outermost] + moved
        return least_gap(gap, self.pair_of)

    def _rates(self, ground: Ground, velocity: Array, rate: Array, points: Index) -> Array:
        """Rates of the gaps of all pairs: at the middles, in storeys the mean of the points."""
        rates = opening(self.system, velocity, ground.relative, 1)
        for k in np.unique(self.pair_of[self._in_storeys]):
            rates[:, k] = rate[:, self.pair_of[points] == k].mean(axis=1)
        return np.asarray(rates)
