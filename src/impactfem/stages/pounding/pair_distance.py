"""The check of the gaps: what is given, beside what axes and offsets say."""

from __future__ import annotations

import math
from collections.abc import Sequence

from impactfem.case.pair_distance import allowed
from impactfem.stages.check import Check


def distance_check(
    names: Sequence[str], gaps: Sequence[float], distances: Sequence[float]
) -> list[Check]:
    """The check that the points of the pairs are their gaps apart; a computation takes the gaps.

    Args:
        names: Names of the pairs.
        gaps: Their gaps as given [m].
        distances: Distances of their points along the normals [m]; nan where they are not known.

    Returns:
        The check; nothing where no distance is known.
    """
    known = [
        (name, gap, distance)
        for name, gap, distance in zip(names, gaps, distances, strict=True)
        if math.isfinite(distance)
    ]
    if not known:
        return []
    off = [one for one in known if abs(one[2] - one[1]) > allowed(one[1])]
    if not off:
        return [(True, f"contact: {len(known)} gaps are those of axes and offsets")]
    name, gap, distance = max(off, key=lambda one: abs(one[2] - one[1]))
    text = (
        f"contact: the points of {name} are {distance:.4g} m apart along the normal by axis and "
        f"offset, and its gap is {gap:.4g} m; the gap counts"
    )
    others = len(off) - 1
    return [(False, f"{text}; so it is for {others} more" if others else text)]
