"""How far apart the points of a contact are by axis and offset, beside the gap that is given."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from impactfem.case.buildings import Building
from impactfem.case.contacts import Contact, ContactEntry, expand
from impactfem.case.model import Case
from impactfem.case.source import Source
from impactfem.system.errors import Fault

SMALLEST, PART = 1e-3, 0.1
"""Distance and gap may differ by so much [m], or by this part of the gap, and count as the same."""


def allowed(gap: float) -> float:
    """Difference of distance and gap up to which they count as the same [m].

    Args:
        gap: The gap of the pair [m].
    """
    return max(SMALLEST, PART * gap)


def pair_distance(contact: Contact, case: Case) -> float:
    """Distance of the points of a pair along its normal, n · (x_b − x_a) in plan [m].

    Args:
        contact: The pair.
        case: The case, with the buildings.

    Returns:
        The distance; nan where the case does not say it: both buildings have the same axis, so
        that no plan was given, or the normal is not level.
    """
    return _distance(contact, {building.name: building for building in case.buildings})


def distance_faults(source: Source, entries: Sequence[ContactEntry], case: Case) -> Iterator[Fault]:
    """Contacts whose points lie the other way round along the normal than from a to b.

    Where the axes lie so, too, the normal is at fault, else axes or offsets.

    Args:
        source: The case as written.
        entries: Its contacts, as written.
        case: The case.
    """
    buildings = {building.name: building for building in case.buildings}
    for index, entry in enumerate(entries):
        for contact in expand((entry,)):
            distance = _distance(contact, buildings)
            if distance >= -allowed(contact.gap) or math.isnan(distance):
                continue
            apart = (
                f"by axis and offset the points of {contact.name} are {distance:.4g} m apart along "
            )
            a, b = (buildings[end.building] for end in (contact.a, contact.b))
            x, y, _ = contact.normal
            if x * (b.axis[0] - a.axis[0]) + y * (b.axis[1] - a.axis[1]) < 0.0:
                place = ("contacts", index, "normal")
                expected = f"expected the direction from a to b: {apart}it"
                yield source.fault(
                    place, list(entry.normal), f"{expected}, and the gap is {contact.gap:.4g} m"
                )
            else:
                expected = (
                    f"expected buildings that stand side by side: {apart}the normal, and the gap "
                    f"is {contact.gap:.4g} m; see axis of [[buildings]], {a.name} {_point(a.axis)} "
                    f"and {b.name} {_point(b.axis)}, and the offsets"
                )
                yield source.fault(("contacts", index), None, expected)
            break


def _point(axis: tuple[float, float]) -> str:
    return f"({axis[0]:g} m, {axis[1]:g} m)"


def _distance(contact: Contact, buildings: dict[str, Building]) -> float:
    a, b = contact.a, contact.b
    (ax, ay), (bx, by) = (buildings[point.building].axis for point in (a, b))
    x, y, z = contact.normal
    if (ax, ay) == (bx, by) or z != 0.0:
        return math.nan
    return x * (bx + b.offset[0] - ax - a.offset[0]) + y * (by + b.offset[1] - ay - a.offset[1])
