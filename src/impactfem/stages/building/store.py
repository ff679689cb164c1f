"""The store of the stage: `building.nc`, the mesh as arrays and the modes.

Dimensions: `node`, `triangle`, `line`, `shell_part`, `beam_part`, `floor`, `mode`, `direction`
(the six of a rigid-body motion) and `xyz`. Nodes of a triangle: vertices 0 1 2, then the middles
of 01, 12 and 20; of a line: ends, then the middle. All values are SI; each variable carries its
unit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.building.bending import bending_modes
from impactfem.building.mesh import BuildingMesh
from impactfem.building.part import Part, parse_group
from impactfem.stages.building.compute import BuildingStudy
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, to_json

SHOWN_BENDING = 3


DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


def bending_direction(study: BuildingStudy) -> str:
    """Direction in which the bending modes of the summary move: that of the fit, else y."""
    fit = study.structure.calibration
    return fit.direction if fit is not None else "y"


def bending_of(study: BuildingStudy) -> NDArray[np.int64]:
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
    scalars = [
        Scalar("building.elements", report.shells + report.beams, "-", "shells and beams"),
        Scalar("building.nodes", report.nodes, "-"),
        Scalar("building.dofs", 6 * report.nodes, "-", "clamped ones included"),
        Scalar("building.mass", float(study.total[0]), "kg", "with what belongs to the base"),
        Scalar("building.storey_stiffness_factor", study.factor, "-", "on walls and columns"),
    ]
    for number in range(SHOWN_BENDING):
        mode = int(bending[number]) if number < len(bending) else None
        which = note if mode is None else f"{note}, mode {mode + 1} of all"
        frequency = None if mode is None else float(study.frequency[mode])
        mass = None if mode is None else float(effective[mode])
        scalars += [
            Scalar(f"building.frequency.{number + 1}", frequency, "Hz", which),
            Scalar(f"building.effective_mass.{number + 1}", mass, "kg", which),
        ]
    for k, (mass, added) in enumerate(
        zip(study.masses.floors, study.masses.added, strict=True), start=1
    ):
        share = f"of it {added / 1e3:.0f} t added" if added else ""
        scalars.append(Scalar(f"building.floor_mass.{k}", float(mass), "kg", share))
    return scalars


def write_building(path: Path, study: BuildingStudy, title: str, key: str) -> None:
    """Write the store.

    Args:
        path: The file.
        study: The stage's results, on rank 0.
        title: Title of the case.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    variables = {**_mesh(study), **_modes(study), **_masses(study)}
    dataset = xr.Dataset(
        variables,
        coords={
            "direction": list(DIRECTIONS),
            "mode": ("mode", np.arange(1, len(study.frequency) + 1), {"units": "1"}),
            "floor": ("floor", np.array(study.parts.mesh.floors), {"units": "1"}),
        },
        attrs={
            "title": title,
            "inputs": key,
            "scalars": to_json(building_scalars(study)),
            "building": study.structure.building,
            "bending_direction": bending_direction(study),
            "base_mass": study.masses.base,
            "mesh_report": str(study.report),
            "mesh_warnings": "\n".join(study.report.warnings),
        },
    )
    write_netcdf(path, dataset)


def read_building_mesh(path: Path) -> BuildingMesh:
    """The mesh of a store, the same as that of the mesh file."""
    with xr.open_dataset(path, engine="h5netcdf") as store:
        edges = store["edge_line"].to_numpy()
        edge_floor = store["edge_floor"].to_numpy()
        return BuildingMesh(
            nodes=store["node_position"].to_numpy(),
            triangles=store["triangle_node"].to_numpy(),
            triangle_part=store["triangle_part"].to_numpy(),
            lines=store["line_node"].to_numpy(),
            line_part=store["line_part"].to_numpy(),
            shell_parts=_parts(store["shell_part_name"]),
            beam_parts=_parts(store["beam_part_name"]),
            edges={int(k): edges[edge_floor == k] for k in np.unique(edge_floor)},
            centres={
                int(k): int(node)
                for k, node in zip(store["floor"].values, store["centre"].values, strict=True)
            },
            base=store["base"].to_numpy(),
        )


def _parts(names: Any) -> tuple[Part, ...]:
    found = (parse_group(str(name)) for name in names.values)
    return tuple(part for part in found if isinstance(part, Part))


def _mesh(study: BuildingStudy) -> dict[str, tuple[Any, ...]]:
    mesh = study.parts.mesh
    floors = np.array(list(mesh.edges), dtype=np.int64)
    edge_floor = np.repeat(floors, [len(lines) for lines in mesh.edges.values()])
    edges = np.vstack([*mesh.edges.values(), np.empty((0, 3), dtype=np.int64)])
    areas = [section.A for section in study.parts.sections.beams]
    thickness = [section.thickness for section in study.parts.sections.shells]
    return {
        "node_position": (("node", "xyz"), mesh.nodes, {"units": "m"}),
        "triangle_node": (("triangle", "triangle_corner"), mesh.triangles, {}),
        "triangle_part": ("triangle", mesh.triangle_part, {}),
        "line_node": (("line", "line_corner"), mesh.lines, {}),
        "line_part": ("line", mesh.line_part, {}),
        "shell_part_name": ("shell_part", _names(mesh.shell_parts), {}),
        "beam_part_name": ("beam_part", _names(mesh.beam_parts), {}),
        "shell_part_thickness": ("shell_part", np.array(thickness), {"units": "m"}),
        "beam_part_area": ("beam_part", np.array(areas, dtype=np.float64), {"units": "m2"}),
        "added_mass": ("triangle", study.parts.added_mass, {"units": "kg/m2"}),
        "edge_line": (("edge", "line_corner"), edges, {}),
        "edge_floor": ("edge", edge_floor, {}),
        "centre": ("floor", np.array([mesh.centres[k] for k in mesh.floors]), {}),
        "base": ("base_node", mesh.base, {}),
    }


def _names(parts: tuple[Part, ...]) -> Any:
    return np.array([part.group for part in parts], dtype=object)


def _modes(study: BuildingStudy) -> dict[str, tuple[Any, ...]]:
    modal = ("mode", "direction")
    note = "rotations about the middle of the base"
    bending = bending_of(study) + 1
    return {
        "frequency": ("mode", study.frequency, {"units": "Hz"}),
        "shape": (("mode", "node", "xyz"), study.shapes, {"units": "1/sqrt(kg)"}),
        "bending_mode": ("bending", bending, {"note": "numbers of the bending modes"}),
        "residual": ("mode", study.residual, {"units": "1"}),
        "participation": (modal, study.participation, {"units": "sqrt(kg)", "note": note}),
        "effective_mass": (modal, study.effective_mass, {"units": "kg, kg m2", "note": note}),
        "total_mass": ("direction", study.total, {"units": "kg, kg m2", "note": note}),
    }


def _masses(study: BuildingStudy) -> dict[str, tuple[Any, ...]]:
    masses = study.masses
    return {
        "floor_mass": ("floor", masses.floors, {"units": "kg"}),
        "floor_added_mass": ("floor", masses.added, {"units": "kg"}),
    }
