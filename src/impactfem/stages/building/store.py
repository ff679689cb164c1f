"""The store of the stage: `building.nc`, the mesh as arrays and the modes."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.building.floor_properties import UNITS, floor_properties
from impactfem.building.parts import FloorMasses
from impactfem.stages.building.study import BuildingStudy
from impactfem.stages.building.targets import SHOWN_BENDING
from impactfem.stages.results import outputs, scalars, value
from impactfem.stages.stores import Output, dataset
from impactfem.sticks.condensed import CondensedStick
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
SCALARS = {
    "building.{variable}": "elements dofs",
    "building.mass": "total_mass",
    "building.storey_stiffness_factor": "storey_factor",
    "building.{variable}.{bending}": "frequency effective_mass",
    "building.{variable}.{floor}": "floor_mass",
}
"""Patterns of the names of the scalars, with the variables that they are selected from."""
OUTPUTS = {
    "floor": Output("floor"),
    "direction": Output("direction", "", "of a motion of the rigid building"),
    "xyz": Output("xyz"),
    "node_position": Output("node xyz", "m"),
    "triangle_node": Output("triangle triangle_corner", "", "vertices, then middles of 01, 12, 20"),
    "triangle_part": Output("triangle", "", "number of its shell part"),
    "line_node": Output("line line_corner", "", "ends, then the middle"),
    "line_part": Output("line", "", "number of its beam part"),
    "shell_part_name": Output("shell_part"),
    "beam_part_name": Output("beam_part"),
    "shell_part_thickness": Output("shell_part", "m"),
    "beam_part_area": Output("beam_part", "m2"),
    "edge_line": Output("edge line_corner", "", "lines on the edges that face other buildings"),
    "edge_floor": Output("edge", label=True),
    "centre": Output("floor", "", "node at its mass centre"),
    "base": Output("base_node", "", "clamped nodes"),
    "mode": Output("mode", "", "in natural order, from 1"),
    **outputs(BuildingStudy),
    **outputs(FloorMasses),
    **outputs(CondensedStick),
    **{
        f"floor_{name}": Output("floor", unit, "of parts and added mass, or of the storey below")
        for name, unit in UNITS.items()
        if name != "mass"
    },
    **{
        f"floor_e{x}": Output("floor", "m", f"along {x}, of the centre of mass from the node")
        for x in "xy"
    },
    "mesh_warning": Output("mesh_warning"),
}


def write_building(path: Path, study: BuildingStudy, title: str, key: str) -> None:
    """Write the store of the results on rank 0, with the hash of the stage's inputs.

    ImpactfemError where the file cannot be written.
    """
    mesh, sections = study.parts.mesh, study.parts.sections
    properties = floor_properties(study.parts, study.masses)
    values = {
        **_results(study),
        "xyz": ["x", "y", "z"],
        "node_position": mesh.nodes,
        "triangle_node": mesh.triangles,
        "triangle_part": mesh.triangle_part,
        "line_node": mesh.lines,
        "line_part": mesh.line_part,
        "shell_part_name": [part.group for part in mesh.shell_parts],
        "beam_part_name": [part.group for part in mesh.beam_parts],
        "shell_part_thickness": [section.thickness for section in sections.shells],
        "beam_part_area": [section.A for section in sections.beams],
        "edge_line": np.vstack([*mesh.edges.values(), np.empty((0, 3), dtype=np.int64)]),
        "edge_floor": [floor for floor, lines in mesh.edges.items() for _ in lines],
        "centre": [mesh.centres[k] for k in mesh.floors],
        "base": mesh.base,
        **{f"floor_{name}": column for name, column in properties.items() if name != "mass"},
        "mesh_warning": study.report.warnings,
    }
    attributes = {
        "title": title,
        "inputs": key,
        "building": study.structure.building,
        "bending_direction": study.bending_direction,
        "mesh_report": str(study.report),
    }
    store = dataset(OUTPUTS, values, attributes=attributes)
    write_netcdf(path, with_scalars(store, building_scalars(store)))


def _results(study: BuildingStudy) -> dict[str, Any]:
    """Return results and labels by variable, without the mesh."""
    return {
        "floor": study.parts.mesh.floors,
        "direction": DIRECTIONS,
        "mode": np.arange(1, len(study.frequency) + 1),
        **value(study),
        **value(study.masses),
        **({} if study.stick is None else value(study.stick)),
    }


def study_scalars(study: BuildingStudy) -> list[Scalar]:
    """Return the scalars of the stage, from a study that has no store."""
    about = {"bending_direction": study.bending_direction}
    return building_scalars(dataset(OUTPUTS, _results(study), attributes=about))


def building_scalars(store: xr.Dataset) -> list[Scalar]:
    """Return the scalars of the stage; a bending mode that was not computed has no value."""
    direction, modes = str(store.attrs["bending_direction"]), store["bending_mode"]
    names = SCALARS["building.{variable}.{bending}"].split()
    bending = store[names].sel(mode=modes, direction=direction).drop_vars(["mode", "direction"])
    bending = bending.assign_coords(bending=1 + np.arange(modes.size))
    note = f"bending along {direction}, modes {modes.values[:SHOWN_BENDING].tolist()} of all"
    if modes.size < SHOWN_BENDING:
        note += "; raise buildings.structure.modes"
    own = store.drop_dims(["mode", "bending"]).sel(direction="x")
    own = own.assign(bending.reindex(bending=1 + np.arange(SHOWN_BENDING)))
    for name in names:
        own[name].attrs["long_name"] = note
    return [
        scalar
        for pattern, variables in SCALARS.items()
        for scalar in scalars(own, pattern, variables)
    ]
