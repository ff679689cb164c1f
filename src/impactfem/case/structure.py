"""The structure, the 3D model of one building: as written in the case file, and resolved."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section
from impactfem.case.file_mesh import FileMesh
from impactfem.case.generated_mesh import GeneratedMesh, GeneratedMeshEntry
from impactfem.case.known import known_of
from impactfem.case.leaf import BuildingName, Frequency, MaterialName, PositiveFactor, Whole, refuse
from impactfem.case.materials import Material
from impactfem.case.part_damping import PartDamping, Parts

Mesh = GeneratedMesh | FileMesh
MeshEntry = Annotated[GeneratedMeshEntry | FileMesh, Field(discriminator="type")]


class FrequencyFit(Section):
    """Fit of the factor on walls and columns to a known frequency."""

    frequency: Frequency = Field(description="Frequency of the first bending mode to reach.")
    direction: Literal["x", "y"] = Field(description="Direction in which that mode moves.")


def _has_density(name: str | None, info: ValidationInfo) -> None:
    known = known_of(info)
    if known is not None and name in known.without_density:
        raise refuse(f"expected a material with a density, which is missing in [materials.{name}]")


class PartMaterialEntry(Parts):
    """The material of some parts of the 3D model, in place of that of the structure."""

    material: MaterialName = Field(description="Name of the material, which has a density.")

    @field_validator("material")
    @classmethod
    def _with_density(cls, value: str, info: ValidationInfo) -> str:
        _has_density(value, info)
        return value


class PartMaterial(Parts):
    """The material of some parts of the 3D model.

    Args:
        parts: Patterns of the names of the parts.
        material: The material.
    """

    material: Material


class _Structure(Section):
    """What a structure has in common before and after its names are resolved.

    The fields that differ stand here too, for the order of all fields.
    """

    building: str
    material: str | Material | None
    materials: tuple[PartMaterialEntry, ...] | tuple[PartMaterial, ...] = Field(
        default=(),
        description="Materials of parts of the 3D model in place of that of the structure.",
    )
    storey_stiffness_factor: PositiveFactor = Field(
        default=1.0,
        description="Factor on the stiffness of walls and columns, never on that of slabs and "
        "beams; with calibration the value it starts from.",
    )
    calibration: FrequencyFit | None = Field(
        default=None,
        description="Fit of storey_stiffness_factor to a frequency; left out, it is as given.",
    )
    floor_masses: StrictBool = Field(
        default=True,
        description="Whether mass is added until each floor has that of the floor table.",
    )
    modes: Annotated[int, Whole(1, 10_000)] = Field(default=20, description="Number of modes.")
    drilling: PositiveFactor = Field(
        default=1.0,
        description="Factor on the drilling stiffness of the shells, shear modulus by thickness.",
    )
    damping: tuple[PartDamping, ...] = Field(
        default=(),
        description="Damping of parts of the 3D model in place of that of the building; only with "
        "[transient] solver 'full'.",
    )
    mesh: GeneratedMeshEntry | GeneratedMesh | FileMesh


class StructureEntry(_Structure):
    """The 3D model of one building: shells and beams, clamped at the base.

    Levels, masses of the floors and damping are those of the building; parts may have another
    material and another damping.
    """

    building: BuildingName = Field(description="Name of the building.")
    material: MaterialName | None = Field(
        default=None,
        validate_default=True,
        description="Name of the material, which has a density; default that of the building.",
    )
    materials: tuple[PartMaterialEntry, ...] = Field(
        default=(),
        description="Materials of parts of the 3D model in place of that of the structure. The "
        "stick has one material.",
    )
    mesh: MeshEntry = Field(description="The mesh: generated from tables, or from a file.")

    @field_validator("building")
    @classmethod
    def _floors_from_one(cls, value: str, info: ValidationInfo) -> str:
        """Floors are named by their number in the mesh: there is no gap between 1 and the top."""
        known = known_of(info)
        floors = known.building_floors(value) if known is not None else None
        numbers = [floor.floor for floor in floors or ()]
        if numbers != list(range(1, len(numbers) + 1)):
            found = ", ".join(map(str, numbers))
            raise refuse(f"expected a building with floors from 1 without a gap, found {found}")
        return value

    @field_validator("material")
    @classmethod
    def _with_density(cls, value: str | None, info: ValidationInfo) -> str | None:
        known = known_of(info)
        if known is not None:
            _has_density(value or known.material_of.get(info.data.get("building", "")), info)
        return value


class Structure(_Structure):
    """A structure with its material, and its mesh with the tables of it."""

    building: str
    material: Material
    materials: tuple[PartMaterial, ...]
    mesh: Mesh


def structure_files(structure: Structure) -> tuple[Path, ...]:
    """The files a structure is made from besides those of the case: its mesh, where it has one."""
    return (structure.mesh.file,) if isinstance(structure.mesh, FileMesh) else ()
