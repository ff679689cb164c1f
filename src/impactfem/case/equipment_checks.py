"""Rules between the equipment list and the buildings that its items stand in."""

from collections.abc import Iterator
from itertools import product

from impactfem.case.contact_checks import Finding
from impactfem.case.levels import plan_of
from impactfem.case.members import TOUCH
from impactfem.case.model import Case
from impactfem.case.plan import inside, moved
from impactfem.case.reading import Reading


def of_equipment(case: Case, _: Reading) -> Iterator[Finding]:
    """Items off the plan of their floor, and items on a 3D model without a reduced model."""
    buildings = {one.name: one for one in case.buildings}
    off = []
    for item in case.equipment:
        building = buildings.get(item.building)
        if building is None or item.floor not in building.levels:
            continue
        index = list(building.levels).index(item.floor)
        plan = plan_of(building, index)
        corners = product((-TOUCH, TOUCH), repeat=2)
        at = [(item.x + dx, item.y + dy) for dx, dy in corners]
        if plan is not None and not any(inside(one, moved(plan, building.axis)) for one in at):
            off.append(f"{item.tag} at ({item.x:g}, {item.y:g}) m")
    if off:
        more = f" and {len(off) - 3} more" if len(off) > 3 else ""
        yield (
            ("equipment",),
            "expected x and y of each item on its floor, in the plan of the case as `axis` of "
            f"[[buildings]]; off their floor: {'; '.join(off[:3])}{more}",
        )
    named = {item.building for item in case.equipment}
    in_3d = [one.name for one in case.in_time if one.name in named]
    if in_3d and case.transient is not None and case.transient.solver == "full":
        yield (
            ("transient", "solver"),
            f"expected 'reduced' or 'both' with an equipment list on the 3D model of {in_3d[0]}",
        )
