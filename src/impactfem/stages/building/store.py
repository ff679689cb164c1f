"""The store of the stage: `building.nc`, the mesh as arrays and the modes."""

from pathlib import Path

import numpy as np

from impactfem.building.floor_properties import UNITS, floor_properties
from impactfem.stages.building.compute import BuildingStudy
from impactfem.stages.building.targets import RESULTS, SHOWN_BENDING, bending_modes
from impactfem.stages.stores import Output, dataset
from impactfem.system.arrays import Index
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


def bending_direction(study: BuildingStudy) -> str:
    """Direction in which the bending modes of the summary move.

    That of the fit, else the one in which the building pounds: across the edges that face other
    buildings, or y without any.
    """
    fit, mesh = study.structure.calibration, study.parts.mesh
    if fit is not None:
        return fit.direction
    across = [1 - mesh.edge_axis(floor) for floor, lines in mesh.edges.items() if lines.size]
    return "xy"[across[-1]] if across else "y"


def bending_of(study: BuildingStudy) -> Index:
    """Indices of the bending modes along that direction, in ascending frequency."""
    axis = "xy".index(bending_direction(study))
    return bending_modes(study.effective_mass[:, axis], float(study.total[axis]))


def building_scalars(study: BuildingStudy) -> list[Scalar]:
    """All scalars of the stage."""
    report = study.report
    direction = bending_direction(study)
    axis = "xy".index(direction)
    about = {"x": "e_y", "y": "e_x"}[direction]
    effective = study.effective_mass[:, axis]
    bending = bending_of(study)
    note = f"bending about {about}"
    rows: list[tuple[str, float | None, str]] = [
        ("elements", report.shells + report.beams, "shells and beams"),
        ("nodes", report.nodes, ""),
        ("dofs", 6 * report.nodes, "clamped ones included"),
        ("mass", float(study.total[0]), "with what belongs to the base"),
        ("storey_stiffness_factor", study.factor, "on walls and columns"),
    ]
    for number in range(SHOWN_BENDING):
        frequency = mass = None
        which = f"{note}: {len(bending)} of the {len(study.frequency)} modes; raise structure.modes"
        if number < len(bending):
            mode = int(bending[number])
            frequency, mass = float(study.frequency[mode]), float(effective[mode])
            which = f"{note}, mode {mode + 1} of all"
        rows += [
            (f"frequency.{number + 1}", frequency, which),
            (f"effective_mass.{number + 1}", mass, which),
        ]
    for k, (mass, added) in enumerate(
        zip(study.masses.floors, study.masses.added, strict=True), start=1
    ):
        share = f"of it {added / 1e3:.0f} t added" if added else ""
        rows.append((f"floor_mass.{k}", float(mass), share))
    return [
        Scalar(f"building.{name}", value, RESULTS[name.partition(".")[0]], note)
        for name, value, note in rows
    ]


_NOTE = "rotations about the middle of the base"
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
    "added_mass": Output("triangle", "kg/m2"),
    "edge_line": Output("edge line_corner", "", "lines on the edges that face other buildings"),
    "edge_floor": Output("edge", label=True),
    "centre": Output("floor", "", "node at its mass centre"),
    "base": Output("base_node", "", "clamped nodes"),
    "storey_factor": Output("", "-", "on the stiffness of walls and columns, given or fitted"),
    "mode": Output("mode", "", "in natural order, from 1"),
    "frequency": Output("mode", "Hz"),
    "shape": Output("mode node xyz", "1/sqrt(kg)", "with unit modal mass"),
    "bending_mode": Output("bending", "", "numbers of the modes that bend along one direction"),
    "residual": Output("mode", "-"),
    "participation": Output("mode direction", "sqrt(kg)", _NOTE),
    "effective_mass": Output("mode direction", "kg, kg m2", _NOTE),
    "total_mass": Output("direction", "kg, kg m2", _NOTE),
    "floor_mass": Output("floor", "kg"),
    "floor_added_mass": Output("floor", "kg", "of it added"),
    **{
        f"floor_{name}": Output("floor", unit, "of parts and added mass, or of the storey below")
        for name, unit in UNITS.items()
        if name != "mass"
    },
    **{
        f"floor_e{x}": Output("floor", "m", f"along {x}, of the centre of mass from the node")
        for x in "xy"
    },
    "base_mass": Output("", "kg"),
    "mesh_warning": Output("mesh_warning"),
}


def write_building(path: Path, study: BuildingStudy, title: str, key: str) -> None:
    """Write the store of the results on rank 0, with the hash of the stage's inputs.

    ImpactfemError where the file cannot be written.
    """
    mesh, sections, masses = study.parts.mesh, study.parts.sections, study.masses
    properties = floor_properties(study.parts, masses)
    values = {
        "floor": mesh.floors,
        "direction": DIRECTIONS,
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
        "added_mass": study.parts.added_mass,
        "edge_line": np.vstack([*mesh.edges.values(), np.empty((0, 3), dtype=np.int64)]),
        "edge_floor": [floor for floor, lines in mesh.edges.items() for _ in lines],
        "centre": [mesh.centres[k] for k in mesh.floors],
        "base": mesh.base,
        "storey_factor": study.factor,
        "mode": np.arange(1, len(study.frequency) + 1),
        "frequency": study.frequency,
        "shape": study.shapes,
        "bending_mode": bending_of(study) + 1,
        "residual": study.residual,
        "participation": study.participation,
        "effective_mass": study.effective_mass,
        "total_mass": study.total,
        "floor_mass": masses.floors,
        "floor_added_mass": masses.added,
        **{f"floor_{name}": column for name, column in properties.items() if name != "mass"},
        "base_mass": masses.base,
        "mesh_warning": study.report.warnings,
    }
    attributes = {
        "title": title,
        "inputs": key,
        "building": study.structure.building,
        "bending_direction": bending_direction(study),
        "mesh_report": str(study.report),
    }
    scalars = building_scalars(study)
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))
