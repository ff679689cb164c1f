"""Rayleigh damping of parts of the 3D model, in place of that of the whole building."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.damping import Damping
from impactfem.case.leaf import Text
from impactfem.case.place import value_at
from impactfem.case.source import Source
from impactfem.system.errors import Fault

PLACE = ("structure", "damping")
REDUCED = {
    "wall_impact": "the impact on a wall",
    "devices": "the study of devices",
    "damping_cases": "the damping cases",
}
"""Sections that use the reduced basis, by name, and what they are."""


class Parts(Section):
    """Parts of the 3D model, by patterns of their names."""

    parts: tuple[Text, ...] = Field(
        min_length=1,
        description="Patterns of the names of its parts, with * and ? as in a shell: `floor_*`, "
        "`column_1_*`. Each part matches one entry or none, and each pattern a part.",
    )


# The parts come first in the order of the fields, which is that of the bases from right to left.
class PartDamping(Damping, Parts):
    """Rayleigh damping C = Σ α_p M_p + β_p K_p of some parts p of the 3D model.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    Parts without an entry have the damping of the building. The mass that is added to a floor
    belongs to the slab that it lies on. Only in full order.
    """


def part_damping_faults(source: Source) -> Iterator[Fault]:
    """What damping by part does not go with, from the file as it stands.

    Args:
        source: The case file.
    """
    if not isinstance(value_at(PLACE, source.raw), list):
        return
    place = ("transient", "solver")
    solver = value_at(place, source.raw)
    if solver != "full":
        expected = (
            "expected 'full' beside [[structure.damping]]: with damping by part there is no "
            "reduced basis"
        )
        yield source.fault(place, solver, expected)
    for name, what in REDUCED.items():
        if name in source.raw:
            expected = (
                f"expected none beside [[structure.damping]]: {what} uses the reduced basis, which "
                "serves one Rayleigh damping of the whole building at a time"
            )
            yield source.fault((name,), None, expected)
