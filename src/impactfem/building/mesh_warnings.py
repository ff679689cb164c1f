"""Warnings of what is probably a mistake in a building's mesh, although it can be computed."""

from collections.abc import Iterator

import numpy as np

from impactfem.building.mesh import BuildingMesh, line_lengths, outward_normal, place, rim
from impactfem.building.mesh_checks import (
    NEAR,
    beam_groups,
    by_group,
    frames,
    nodes_on_triangles,
    shell_groups,
)
from impactfem.system.arrays import Array

OUTSIDE = 0.25
"""Part of a storey's height by which cells of its walls and columns may be outside of it."""
SHORT = 0.3
"""Distance from a slab or the base at which a wall hardly ends on purpose [m]."""
LEVEL = 0.1
"""Slope below which a line or a side counts as level, and how near to a floor it is in it [m]."""


def mesh_warnings(mesh: BuildingMesh) -> Iterator[str]:
    """Warnings, each of which begins with the name of the group."""
    if not mesh.base.size or not mesh.floors:
        return
    levels = np.array([mesh.nodes[mesh.base, 2].min(), *mesh.elevations.values()])
    yield from _misplaced(mesh, levels)
    # Columns with a lower end that nothing carries.
    ends = mesh.lines[:, :2]
    foot = ends[np.arange(len(ends)), mesh.nodes[ends, 2].argmin(axis=1)]
    used = np.concatenate([mesh.lines.ravel(), mesh.triangles.ravel()])
    alone = np.bincount(used, minlength=len(mesh.nodes))[foot] == 1
    columns = np.isin(np.arange(len(ends)), mesh.lines_of("column"))
    loose = np.flatnonzero(columns & alone & ~np.isin(foot, mesh.base))
    for group, some, _ in by_group(mesh, loose, mesh.lines, beam_groups(mesh)):
        where = place(mesh.nodes[foot[some[0]]])
        yield f"{group}: its lower end at {where} stands on nothing and is not in base"
    yield from _loose_walls(mesh, levels)
    # Edges beside which their side of the slab goes on: forces act on the edge alone.
    for k, lines in mesh.edges.items():
        n, own = outward_normal(mesh, k)[:2], np.unique(lines)
        every, _ = rim(mesh.triangles[mesh.slab(k)])
        rest = every[~np.isin(every[:, 2], own)]
        across = mesh.nodes[rest, :2] @ n - (mesh.nodes[own, :2] @ n).mean()
        on = (np.abs(across) < NEAR).all(axis=1) & np.isin(rest[:, :2], own).any(axis=1)
        if on.any():
            length = np.ptp(mesh.nodes[own, :2] @ [-n[1], n[0]])
            where = place(mesh.nodes[rest[int(np.argmax(on)), 2]])
            yield f"edge_{k}: {length:.4g} m of a side of floor_{k} that goes on at {where}"
    high = mesh.base[mesh.nodes[mesh.base, 2] > levels[1] - NEAR]
    if high.size:
        where = place(mesh.nodes[high[0]])
        yield f"base: {len(high)} clamped nodes at floor 1 or above it, the first at {where}"


def _misplaced(mesh: BuildingMesh, levels: Array) -> Iterator[str]:
    """Cells at another level than the number of their group says, and level walls and columns."""
    corners, ends = mesh.nodes[mesh.triangles[:, :3]], mesh.nodes[mesh.lines[:, :2]]
    # The slope of a cell: 0 where it is level, 1 where it is upright.
    of_shells = np.sqrt(np.maximum(1.0 - frames(corners)[0][:, 2] ** 2, 0.0))
    of_beams = np.abs(ends[:, 1, 2] - ends[:, 0, 2]) / line_lengths(mesh)
    for cells, points, parts, part, slope, groups in (
        (mesh.triangles, corners, mesh.shell_parts, mesh.triangle_part, of_shells, shell_groups),
        (mesh.lines, ends, mesh.beam_parts, mesh.line_part, of_beams, beam_groups),
    ):
        k = np.array([one.level for one in parts], dtype=np.int64)[part]
        stands = np.array([one.scaled for one in parts], dtype=bool)[part]
        z = points[:, :, 2].mean(axis=1)
        margin = OUTSIDE * (levels[k] - levels[k - 1])
        # Above the top floor is no storey: a gable is of the one below.
        above = (z > levels[k] + margin) & (k < len(mesh.floors))
        outside = above | ((z < levels[k - 1] - margin) & (k > 1))
        distance = np.abs(z[:, None] - levels)
        # Stairs and ramps are of the floor that they lead to, landings of the storey.
        plain = (slope < LEVEL) | (slope > 1.0 - LEVEL)
        off = ~stands & plain & (distance.argmin(axis=1) != k)
        lying = stands & (slope < LEVEL) & (distance.min(axis=1) < LEVEL)
        for what, bad in (
            ("are in another storey than the number of their group says", stands & outside),
            ("are nearer to another floor than the number of their group says", off),
            ("are horizontal at a floor, in a group of walls or columns", lying),
        ):
            for group, some, where in by_group(mesh, np.flatnonzero(bad), cells, groups(mesh)):
                yield (
                    f"{group}: {len(some)} cells {what}, the first at {where}; masses of floors "
                    "and the storey factor go by the name of the group"
                )


def _loose_walls(mesh: BuildingMesh, levels: Array) -> Iterator[str]:
    """Walls with a level rim close to a slab, or to the base, that is not joined to it."""
    lines, own = rim(mesh.triangles)
    held = np.isin(lines[:, 2], [*mesh.lines[:, 2], *mesh.base])
    ends = mesh.nodes[lines[:, :2]]
    rise = np.abs(ends[:, 1, 2] - ends[:, 0, 2])
    level = rise < LEVEL * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    free = np.isin(own, mesh.triangles_of("storey")) & ~held & level
    lines, own = lines[free], own[free]
    z = mesh.nodes[lines[:, 2], 2]
    k = np.array([part.level for part in mesh.shell_parts], dtype=np.int64)[mesh.triangle_part[own]]
    # A sill has its wall below; what is meant is the rim that a wall should stand on or carry by.
    under = mesh.nodes[mesh.triangles[own, :3], 2].mean(axis=1) > z
    near = np.abs(z - np.where(under, levels[k - 1], levels[k])) < SHORT
    short = near & np.where(under, z > levels[k - 1] + NEAR, z < levels[k] - NEAR)
    # A wall in a shaft, or over a void, has no slab there.
    slab = mesh.triangles_of("floor")
    points = np.vstack([mesh.nodes, mesh.nodes[lines[:, 2]]])
    over = nodes_on_triangles(points, mesh.triangles[slab], SHORT)[:, 1] - len(mesh.nodes)
    short &= np.isin(np.arange(len(lines)), over)
    low = under & (short | ((k == 1) & near))
    high = ~under & short
    for what, where in (("lower", low), ("upper", high)):
        some = own[where]
        for group, cells, _ in by_group(mesh, some, mesh.triangles, shell_groups(mesh)):
            at = place(mesh.nodes[lines[where][some == cells[0]][0, 2]])
            yield f"{group}: its {what} rim at {at} is joined to nothing and is not in base"
