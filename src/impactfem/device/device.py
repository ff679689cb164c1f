"""A device: its matrices in coordinates relative to its anchors.

The device has p anchors with six components each, whose motions are a, and own coordinates x:
motions relative to where the anchors carry the device. With the mass M, damping C, stiffness K,
and the mass L that couples own coordinates and anchors,

    M ẍ + C ẋ + K x = -L ä                                                                 (1)

The force of the device on the floor at its anchors, with the mass J of the device as one rigid
body (six components a anchor) and the stiffness K_a between anchors, which is zero for one anchor,

    F = -Lᵀ ẍ - J ä - K_a a                                                                (2)

Absolute coordinates are q = x + r a; r is how the own coordinates follow the anchors without any
force. Where no motion of the base is blocked, L = M r and J = rᵀ M r.

As a part of a larger model, with y = (a, x),

    [J  Lᵀ] ÿ + [0  0] ẏ + [K_a  0] y = f                                                  (3)
    [L  M ]     [0  C]     [0    K]

f holds the forces of the floor on the device in its first 6 p rows. Damping acts on x, and leaves a
rigid motion of the device alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from impactfem.dynamics.damping import DampingLaw, Rayleigh, as_law
from impactfem.sticks.element import COMPONENTS
from impactfem.sticks.modes import natural_modes
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

MECHANISM = 1e-12
"""Smallest eigenvalue of the equilibrated stiffness, whose diagonal is 1, that holds a motion."""
NAMED = 0.1
"""Motions are named that have this part of the largest one in the mechanism."""


def refuse_mechanism(name: str, K: Array, motions: Sequence[str]) -> None:
    """Refuse a stiffness (n, n) that is not positive definite; names the motions that it lacks."""
    diagonal = np.diag(K)
    if np.any(diagonal <= 0.0):
        loose = [motions[i] for i in np.flatnonzero(diagonal <= 0.0)]
    else:
        scale = 1.0 / np.sqrt(diagonal)
        values, vectors = np.linalg.eigh(K * np.outer(scale, scale))
        if values[0] > MECHANISM:
            return
        shape = np.abs(vectors[:, 0])
        loose = [m for m, s in zip(motions, shape, strict=True) if s > NAMED * np.max(shape)]
    raise ImpactfemError(
        f"device {name}: a mechanism, no stiffness holds the motion {' with '.join(loose)};"
        " expected a positive definite stiffness (a motion is blocked by an infinite one)"
    )


@dataclass(frozen=True, eq=False)
class Device:
    """Matrices of a device with n own coordinates and p anchors.

    Raises:
        ImpactfemError: Shapes do not fit, a matrix is not finite or not symmetric, the device has
            no mass, the damping ratio is 100 % or more, or the stiffness leaves a motion free: the
            message names the motion.
    """

    name: str
    motions: tuple[str, ...]  #: names of the own coordinates, n of them
    M: Array  #: mass, symmetric, not indefinite, shape (n, n) [kg, kg m, kg m2]
    K: Array  #: stiffness, symmetric and positive definite, shape (n, n) [N/m, N, N m]
    L: Array  #: coupling mass, shape (n, 6 p)
    J: Array  #: mass of the rigid device about its anchors, shape (6 p, 6 p)
    r: Array  #: own coordinates by unit motions of the anchors, shape (n, 6 p) [-, m, 1/m]
    #: law of the damping of the own coordinates, or one ratio for all modes [-]
    damping: DampingLaw | float
    #: damping matrix of what is added to it, shape (n, n); none when left out
    dampers: Array | None = None
    anchor_stiffness: Array | None = None  #: K_a, shape (6 p, 6 p); zero when left out
    C: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n, columns = len(self.motions), self.J.shape[0]
        wanted = {
            "M": (n, n),
            "K": (n, n),
            "L": (n, columns),
            "J": (columns, columns),
            "r": (n, columns),
        }
        for name, shape in wanted.items():
            self._check(name, getattr(self, name), shape)
        if n == 0 or columns == 0 or columns % 6:
            raise self.error(
                f"it has {n} own motions and {columns} components at its anchors; expected at least"
                " one motion, and six components an anchor"
            )
        for name, matrix, size in (
            ("dampers", self.dampers, n),
            ("anchor_stiffness", self.anchor_stiffness, columns),
        ):
            if matrix is not None:
                self._check(name, matrix, (size, size))
        self._refuse_bad_mass()
        refuse_mechanism(self.name, self.K, self.motions)
        object.__setattr__(self, "C", self._damping_matrix())

    @property
    def anchors(self) -> int:
        """Number p of anchors."""
        return self.J.shape[0] // 6

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the components of the anchors, 6 p: "y", or "2.y" at the second of several."""
        if self.anchors == 1:
            return COMPONENTS
        return tuple(f"{k + 1}.{name}" for k in range(self.anchors) for name in COMPONENTS)

    def column(self, component: str, anchor: int = 1) -> int:
        """Index of a component of an anchor among the columns.

        Raises:
            ImpactfemError: There is no such component or anchor.
        """
        if component not in COMPONENTS or not 1 <= anchor <= self.anchors:
            raise self.error(
                f"there is no component {component!r} of anchor {anchor}: expected one of"
                f" {', '.join(COMPONENTS)} of anchors 1 to {self.anchors}"
            )
        return 6 * (anchor - 1) + COMPONENTS.index(component)

    def refuse_held_ground(self) -> None:
        """Refuse a stiffness between anchors that resists a translation of all of them; names it.

        Displacements of the ground are not known, and need not be where it does not.
        """
        K_a = self.anchor_stiffness
        if K_a is None:
            return
        held = np.abs(K_a @ np.tile(np.eye(6, 3), (self.anchors, 1))).max(axis=0)
        wrong = np.flatnonzero(held > 1e-8 * np.max(np.abs(K_a)))
        if wrong.size:
            along = ", ".join(COMPONENTS[c] for c in wrong)
            raise self.error(
                "the stiffness between its anchors resists a translation of all of them along"
                f" {along}; expected one that leaves it free"
            )

    def error(self, text: str) -> ImpactfemError:
        """An error that names the device."""
        return ImpactfemError(f"device {self.name}: {text}")

    def _check(self, name: str, matrix: Array, shape: tuple[int, int]) -> None:
        if matrix.shape != shape:
            raise self.error(f"{name} needs shape {shape}, got {matrix.shape}")
        if not np.all(np.isfinite(matrix)):
            raise self.error(f"{name} holds a value that is not a finite number")
        square = name not in ("L", "r")
        if square and np.max(np.abs(matrix - matrix.T), initial=0.0) > 1e-9 * np.max(
            np.abs(matrix), initial=0.0
        ):
            raise self.error(f"{name} is not symmetric")

    def _refuse_bad_mass(self) -> None:
        if not np.any(np.diag(self.M) > 0.0):
            raise self.error("nothing that moves has a mass")
        every = np.block([[self.J, self.L.T], [self.L, self.M]])
        diagonal = np.diag(every)
        # Equilibrated: masses and inertias differ by orders of magnitude. Zero rows stay zero.
        scale = np.where(
            diagonal > 0.0, 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), 1.0
        )
        if np.linalg.eigvalsh(every * np.outer(scale, scale))[0] < -1e-8:
            raise self.error(
                "its mass is indefinite: a mass or an inertia is negative, or its modes carry more"
                " mass, overturning moment or inertia than the whole device has"
            )

    def _damping_matrix(self) -> Array:
        law = as_law(self.damping)
        if isinstance(law, Rayleigh):
            C = law.matrix(self.K, self.M)
        else:
            omega, shapes = natural_modes(self.M, self.K)
            images = self.M @ shapes
            C = images @ np.diag(law.modal(omega**2)) @ images.T
        return np.asarray(C if self.dampers is None else C + self.dampers, dtype=np.float64)


def coupled(device: Device) -> tuple[Array, Array, Array]:
    """M, C and K of equation (3), shape (6 p + n, 6 p + n) each."""
    zero = np.zeros_like(device.L.T)
    K_a = np.zeros_like(device.J) if device.anchor_stiffness is None else device.anchor_stiffness
    M = np.block([[device.J, device.L.T], [device.L, device.M]])
    C = np.block([[np.zeros_like(device.J), zero], [zero.T, device.C]])
    K = np.block([[K_a, zero], [zero.T, device.K]])
    return M, C, K
