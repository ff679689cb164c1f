"""Records at vertices of floors: which vertex of which floor, along which direction."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Records:
    """Some vertices of floors, each along one direction.

    Args:
        floor: Place of the floor among all from the lowest, shape (n,).
        component: 0, 1 or 2 for x, y, z, shape (n,).
        node: The vertex, shape (n,).
    """

    floor: Index
    component: Index
    node: Index

    def __len__(self) -> int:
        return len(self.node)

    @classmethod
    def none(cls) -> Records:
        """No record."""
        return cls(*(np.zeros(0, dtype=np.int64) for _ in range(3)))

    @classmethod
    def joined(cls, parts: list[Records]) -> Records:
        """Several one after the other."""
        every = [cls.none(), *parts]
        return cls(
            floor=np.concatenate([one.floor for one in every]),
            component=np.concatenate([one.component for one in every]),
            node=np.concatenate([one.node for one in every]),
        )

    def at(self, floor: int, component: int) -> Index:
        """Which of the records are of a floor along a direction."""
        return np.flatnonzero((self.floor == floor) & (self.component == component))

    def taken(self, chosen: Index) -> Records:
        """Some of the records."""
        return Records(self.floor[chosen], self.component[chosen], self.node[chosen])

    def counts(self, floors: int) -> Index:
        """How many there are of each floor along x, y, z, shape (n_floors, 3)."""
        found = np.zeros((floors, 3), dtype=np.int64)
        np.add.at(found, (self.floor, self.component), 1)
        return found

    @property
    def key(self) -> str:
        """Hash of them all."""
        every = np.stack([self.floor, self.component, self.node])
        return hashlib.sha256(np.ascontiguousarray(every).tobytes()).hexdigest()

    def raised(self, envelope: Array, values: Array, axis: int) -> Array:
        """An envelope over other points of the floors, and over these records too.

        Args:
            envelope: Its values, the floors along an axis and x, y, z along the next.
            values: At the records, which lie along the same axis; no axis of directions.
            axis: That axis.

        Returns:
            Shaped as the envelope.
        """
        found = np.moveaxis(np.array(envelope, dtype=np.float64), (axis, axis + 1), (0, 1))
        np.maximum.at(found, (self.floor, self.component), np.moveaxis(values, axis, 0))
        return np.moveaxis(found, (0, 1), (axis, axis + 1))


@dataclass(frozen=True, eq=False)
class RecordSpectra:
    """Spectra at n_r records, sampled as the case asks.

    Args:
        psa: Pseudo-acceleration, shape (n_dampings, n_r, n_f) [m/s2].
        pfa: Peak acceleration, shape (n_r,) [m/s2].
    """

    psa: Array
    pfa: Array
