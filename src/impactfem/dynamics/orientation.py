"""Signs of mode shapes, by fields of displacement that have no symmetry.

The sign of an eigenvector is free. A rule by its largest entry is a tie in an antisymmetric mode:
two entries are the same but for rounding, which differs from one number of ranks to another. Here
φᵀ M f is positive for a field f(x) of the place alone, which no mode of a regular structure is
orthogonal to. f does not depend on the numbers of nodes; on the mesh it depends as M does.
"""

import numpy as np

from impactfem.system.arrays import Array

FIELDS = 3  # the second counts where a mode is orthogonal to the first within TIE, and so on
TIE = 1e-6  # of |φ| |f|: far above rounding
WAVES = (1.0, 6.0)  # phase along the extent of a structure, from and to [rad]
_RNG = np.random.default_rng(50)
_PHASE = _RNG.uniform(*WAVES, (4, 6, FIELDS))  # along x, y, z, and at the origin
_SIZE = _RNG.uniform(0.7, 1.0, (6, FIELDS))


def fields(points: Array, low: Array, high: Array) -> Array:
    """Return displacements and rotations without symmetry, shape (n, 6, FIELDS) [m, rad].

    A field is mostly positive, so that a first mode moves along the axes.

    Args:
        points: Places, shape (n, 3) [m].
        low: Least coordinates of the whole structure, shape (3,) [m].
        high: Largest ones, likewise.
    """
    extent = max(float(np.max(high - low)), 1e-300)
    phase = np.tensordot((points - low) / extent, _PHASE[:3], axes=1) + _PHASE[3]
    values = _SIZE * (1.0 + 0.5 * np.cos(phase))
    values[:, 3:] /= extent
    return np.asarray(values)


def signs(products: Array, norms: Array) -> Array:
    """Return the signs of modes, shape (k,), each 1 or -1.

    Args:
        products: φᵀ M f of each mode and field, φᵀ M φ = 1, shape (k, FIELDS).
        norms: √(fᵀ M f) of each field, shape (FIELDS,).
    """
    clear = np.abs(products) >= TIE * norms
    first = np.argmax(clear, axis=1)  # the first field where all are ties, too
    return np.where(products[np.arange(len(products)), first] < 0.0, -1.0, 1.0)
