"""The response of sticks and 3D models that pound."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from impactfem.coupling.body import Body
from impactfem.coupling.line_response import LineResponse
from impactfem.system.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Response3D(LineResponse):
    """The response of sticks and 3D models; of a 3D model that of its floors' mass centres.

    The rate of the gap of a line is that of rigid floors, as their mass centres move and turn; in a
    storey the mean of its points. Its closure includes the ends of the line.
    """

    #: Impulses of Moreau's scheme, which dissipate; contact points without mass are elastic.
    impulsive: bool
    #: Largest force of each pair within the step that ends at the time, shape (n_t, n_pairs) [N];
    #: None where it is that at the times.
    largest: Array | None
    low_bodies: Mapping[str, Body]  #: 3D models on soil by their lowest modes, without ports

    def body(self, building: str) -> Body:
        """See `Response`; of a 3D model its lowest modes."""
        return self.low_bodies.get(building) or super().body(building)

    def exchanged(self, index: int, low: int, high: int) -> tuple[float, float]:
        """See `LineResponse`; impulses dissipate minus their work."""
        work, dissipated = super().exchanged(index, low, high)
        return work, -work if self.impulsive else dissipated

    @property
    def largest_forces(self) -> Array:
        """Largest force of each pair by time, within its step where steps have parts [N]."""
        return self.force if self.largest is None else self.largest
