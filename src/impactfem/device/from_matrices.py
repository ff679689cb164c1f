"""A device of which the matrices are known, on one or several anchors.

A model's degrees of freedom are those of its anchors, a, and the others, q, which are absolute.
Without any force, q follows the anchors by

    r = -K_qq⁻¹ K_qa                                                                       (1)

and with x = q - r a

    M = M_qq,    L = M_qq r + M_qa,    J = rᵀ M_qq r + rᵀ M_qa + M_aq r + M_aa              (2)
    K = K_qq,    K_a = K_aa + K_aq r                                                       (3)

K_a is zero when a motion of the anchors moves the device as a rigid body. Damping acts on x only.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import scipy.linalg

from impactfem.device.device import Device
from impactfem.device.mechanism import refuse_mechanism
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


def from_matrices(
    name: str,
    M: Array,
    K: Array,
    anchored: Mapping[int, int],
    damping: Rayleigh | float,
    anchors: int = 1,
    motions: tuple[str, ...] | None = None,
) -> Device:
    """Build a device from the matrices of a model.

    Args:
        name: Name of the device.
        M: Mass of all degrees of freedom, shape (n, n).
        K: Stiffness of all degrees of freedom, shape (n, n).
        anchored: For each degree of freedom that is one of an anchor, which component it is: for
            anchor k, 6 (k - 1) plus its place in COMPONENTS.
        damping: Rayleigh damping of the other degrees of freedom, or one ratio for all modes.
        anchors: Number of anchors.
        motions: Names of the other degrees of freedom, in their order; numbers when left out.

    Raises:
        ImpactfemError: The matrices do not fit, a component is anchored twice, nothing is left to
            move, or the stiffness leaves a motion free.
    """
    n = M.shape[0]
    if M.shape != (n, n) or K.shape != (n, n):
        raise ImpactfemError(
            f"device {name}: mass and stiffness need one square shape, got {M.shape} and {K.shape}"
        )
    fixed = np.array(sorted(anchored), dtype=np.int64)
    columns = [anchored[int(i)] for i in fixed]
    if (
        len(set(columns)) < len(columns)
        or not all(0 <= i < n for i in fixed)
        or not all(0 <= c < 6 * anchors for c in columns)
    ):
        raise ImpactfemError(
            f"device {name}: expected each of the {6 * anchors} components of its anchors at most"
            f" once, and degrees of freedom below {n}"
        )
    q = np.setdiff1d(np.arange(n), fixed)
    if motions is None:
        motions = tuple(f"degree of freedom {i}" for i in q)
    if len(motions) != q.size:
        raise ImpactfemError(f"device {name}: {q.size} motions need as many names")
    K_qq, M_qq = K[np.ix_(q, q)], M[np.ix_(q, q)]
    K_qa, M_qa = K[np.ix_(q, fixed)], M[np.ix_(q, fixed)]
    refuse_mechanism(name, K_qq, motions)
    follow = -scipy.linalg.solve(K_qq, K_qa, assume_a="pos")
    every = np.zeros((len(fixed), 6 * anchors))
    every[np.arange(len(fixed)), columns] = 1.0
    L = M_qq @ follow + M_qa
    J = follow.T @ L + M_qa.T @ follow + M[np.ix_(fixed, fixed)]
    K_a = K[np.ix_(fixed, fixed)] + K_qa.T @ follow
    K_a = np.where(np.abs(K_a) > 1e-10 * np.max(np.abs(K)), K_a, 0.0)
    return Device(
        name=name,
        motions=motions,
        M=M_qq,
        K=K_qq,
        L=L @ every,
        J=every.T @ (0.5 * (J + J.T)) @ every,
        r=follow @ every,
        damping=damping,
        anchor_stiffness=every.T @ (0.5 * (K_a + K_a.T)) @ every,
    )
