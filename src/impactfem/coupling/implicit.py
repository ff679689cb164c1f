"""Response of bodies and links with smooth laws: input and output of the implicit time loop.

The scheme is that of `march`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impactfem.coupling.link_forces import Laws
from impactfem.coupling.links import Assembly, Inverse
from impactfem.coupling.march import (
    Attachments,
    Contacts,
    Inputs,
    Modes,
    Records,
    Scheme,
    State,
    Structure,
    Trial,
    march,
)
from impactfem.dynamics.energy import Energy
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

ROUNDING = 1e-12
"""Gap at the start over the size of its terms, up to which a negative one counts as zero."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of bodies and links at the samples of the loads, relative to the ground."""

    moving: Index  #: indices of the coordinates that are recorded and move at all
    u: Array  #: these coordinates, shape (n_t, moving)
    v: Array  #: their velocities, same shape
    force: Array  #: F of the links, positive in compression, shape (n_t, m) [N]
    displacement: Array  #: y of the attachments, shape (n_t, N)
    velocity: Array  #: ẏ, same shape
    acceleration: Array  #: ÿ, same shape
    reaction: Array  #: T on the bodies at the rows of the attachments, shape (n_t, N_a)
    energy: Energy  #: equation (3), summed up

    @property
    def attached(self) -> tuple[Array, Array, Array]:
        """Motion of the attachments, y, ẏ and ÿ."""
        return self.displacement, self.velocity, self.acceleration


@dataclass(frozen=True)
class Start:
    """State at the start, and the coordinates that are recorded."""

    u: Array | None = None  #: coordinates, shape (r,); zero when None
    v: Array | None = None  #: their velocities, likewise
    recorded: Index | None = None  #: indices of the recorded coordinates; all when None


def respond(
    assembly: Assembly,
    loads: Array,
    ground: Array,
    time_step: float,
    *,
    substeps: int = 1,
    lagged: bool = False,
    start: Start | None = None,
    opened: Array | None = None,
) -> Motion:
    """Integrate bodies and links.

    Args:
        assembly: Bodies and links, each link with a law.
        loads: Forces on the coordinates, those of the ground motion included, shape (n_t, r);
            linear between their samples.
        ground: Acceleration of the ground, for the attachments, shape (n_t, 3) [m/s2].
        time_step: Time between two samples [s].
        substeps: Number of integration steps between two samples.
        lagged: Take the force of a link from the state before the step (paper, equation 2 as
            printed) instead of the new state.
        start: State at the start, and the coordinates to record; at rest, and all, when None.
        opened: Opening of the gaps by the ground, and its rate, shape (2, n_t, m) [m, m/s]; None
            where it moves uniformly.

    Raises:
        SolutionError: A link is closed at the start, or the forces of the links do not converge.
    """
    n_t, r = loads.shape
    start = start or Start()
    inputs = _inputs(assembly, loads, ground, opened)
    state = _state(assembly, inputs, start)
    h = time_step / substeps / 2.0
    structure = _structure(assembly, h)
    # Coordinates that nothing moves stay out of the loop.
    moving = np.flatnonzero(
        loads.any(axis=0)
        | (state.u != 0.0)
        | (state.v != 0.0)
        | structure.contacts.X.any(axis=0)
        | structure.attachments.rows.any(axis=0)
    )
    if moving.size < r:
        structure, inputs, state = _restricted(structure, inputs, state, moving)
    inputs = inputs._replace(loads=np.ascontiguousarray(inputs.loads))
    kept = np.arange(moving.size)
    if start.recorded is not None:
        kept = np.flatnonzero(np.isin(moving, start.recorded))
    records, trial = Records.of(n_t, state, kept), Trial.of(state)
    done = march(Scheme(h, substeps, lagged), structure, inputs, state, trial, records)
    if done < n_t:
        raise SolutionError(
            f"contact forces did not converge at t = {done * time_step:.6g} s; "
            "a smaller pounding.time_step or a softer contact law would help"
        )
    ends = state.y.size * np.arange(1, 4)
    y, y_v, y_a, T = np.split(records.attached, ends, axis=1)
    return Motion(
        moving=moving[kept],
        u=records.u,
        v=records.v,
        force=records.force,
        displacement=y,
        velocity=y_v,
        acceleration=y_a,
        reaction=T,
        energy=Energy(*records.energy.T),
    )


def _restricted(
    structure: Structure, inputs: Inputs, state: State, moving: Index
) -> tuple[Structure, Inputs, State]:
    """Return those of some of the coordinates alone."""

    def some(values: Array) -> Array:
        return np.ascontiguousarray(values[..., moving])

    attachments, contacts = structure.attachments, structure.contacts
    return (
        structure._replace(
            modes=Modes(*map(some, structure.modes)),
            attachments=attachments._replace(rows=some(attachments.rows)),
            contacts=contacts._replace(
                gamma=some(contacts.gamma),
                X=some(contacts.X),
                ends=np.searchsorted(moving, contacts.ends),
            ),
        ),
        inputs._replace(loads=inputs.loads[:, moving]),
        state._replace(u=some(state.u), v=some(state.v), a=some(state.a)),
    )


def _inputs(assembly: Assembly, loads: Array, ground: Array, opened: Array | None) -> Inputs:
    """Gather the given histories."""
    opening = np.zeros((2, 1, len(assembly.links))) if opened is None else opened
    return Inputs(
        loads,
        np.ascontiguousarray(ground @ assembly.attached.push.T),
        assembly.gaps + opening[0],
        np.ascontiguousarray(opening[1]),
    )


def _state(assembly: Assembly, inputs: Inputs, start: Start) -> State:
    """Return the state at the start, in equilibrium; refuse a penetration."""
    r, N, m = len(assembly), len(assembly.attached.M), len(assembly.links)
    u = np.zeros(r) if start.u is None else np.array(start.u, dtype=np.float64)
    v = np.zeros(r) if start.v is None else np.array(start.v, dtype=np.float64)
    rest = inputs.gaps[0]
    size = np.abs(rest) + np.abs(assembly.gamma) @ np.abs(u)
    closed = np.flatnonzero(rest + assembly.gamma @ u < -ROUNDING * size)
    if closed.size:
        raise SolutionError(f"pair {assembly.links[closed[0]].name} penetrates at the start")
    # At rest or not, the accelerations at the start are in equilibrium: M a = f - C v - K u.
    attached = assembly.attached
    y, y_v = np.zeros((2, N))
    rows = attached.rows
    y[: len(rows)], y_v[: len(rows)] = rows @ u, rows @ v
    f_z = inputs.loads[0] - assembly.damping * v - assembly.eigenvalue * u
    f_y = inputs.pushes[0] - attached.C @ y_v - attached.K @ y
    a, y_a, T = Inverse(assembly, 0.0).solve(f_z, f_y)
    return State(u, v, a, y, y_v, y_a, T.copy(), rest.copy(), np.zeros(m), np.zeros(3))


def _structure(assembly: Assembly, h: float) -> Structure:
    """Return the matrices of a step 2 h [s]."""
    m, N, attached = len(assembly.links), len(assembly.attached.M), assembly.attached
    laws = [link.law for link in assembly.links if link.law is not None]
    if len(laws) < m:
        raise SolutionError("a unilateral constraint needs the time loop of `unilateral`")
    inverse = Inverse(assembly, h)
    ends = np.array([0, *(columns.stop for columns in assembly.columns.values())])
    X, X_y, X_T = inverse.solve(assembly.gamma, np.zeros((m, N)))
    return Structure(
        Modes(assembly.mass, assembly.damping, assembly.eigenvalue, inverse.diagonal),
        Attachments(
            M=attached.M,
            C=attached.C,
            K=attached.K,
            S=inverse.S,
            free=inverse.free,
            loaded=inverse.loaded,
            rows=inverse.rows,
        ),
        Contacts(
            gamma=assembly.gamma,
            X=np.ascontiguousarray(X),
            X_y=np.ascontiguousarray(X_y),
            X_T=np.ascontiguousarray(X_T),
            W=h * assembly.gamma @ X.T,
            ends=ends,
        ),
        Laws.of(laws),
    )
