"""Inputs of the stages: hashes that tell whether one changed, and the published values."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from impactfem.case import Case, motion_files
from impactfem.case.buildings import structure_files
from impactfem.stages.sources import program_key

MATRICES = ("materials", "buildings", "structure")
"""Sections that the matrices of the 3D model depend on."""


def inputs_key(
    case: Case,
    sections: tuple[str, ...],
    modules: tuple[str, ...],
    files: tuple[Path, ...] = (),
) -> str:
    """Hash of modules of the program, of sections of the case, and of files.

    Args:
        case: The case.
        sections: Names of the sections of the case file that count. With ``motions`` and ``loads``
            the files that they name count too; without ``damping`` that of buildings and parts
            does not, and without ``contact_laws`` the restitution of the damping cases does not.
        modules: Modules of the program that count with all that they import, as in
            `impactfem.stages.sources`.
        files: Further files whose content counts.

    Returns:
        The hash, as hexadecimal digits.
    """
    digest = hashlib.sha256(program_key(modules).encode())
    # What is in a record or a mesh counts, not where it lies.
    nowhere: dict[str, Any] = {
        "motions": {"__all__": {"file"}},
        "loads": {"__all__": {"file"}},
        "structure": {"mesh": {"file"}},
        "transient": {"forces"},
        # How many members go on to the 3D model changes nothing of the members.
        "ensemble": {"structure_motions"},
    }
    if "damping" not in sections:
        nowhere["buildings"] = {"__all__": {"damping"}}
        nowhere["structure"]["damping"] = True
    if "contact_laws" not in sections:
        nowhere["damping_cases"] = {"__all__": {"restitution"}}
    digest.update(case.model_dump_json(include=set(sections), exclude=nowhere).encode())
    if "motions" in sections:
        for motion in case.motions:
            for file in motion_files(motion):
                digest.update(file.read_bytes())
    if "loads" in sections:
        for loads in case.loads:
            digest.update(loads.file.read_bytes())
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()


def matrices_key(
    case: Case, modules: tuple[str, ...], own: str, sections: tuple[str, ...] = ()
) -> str:
    """Hash of the inputs of the matrices of the 3D model, of further sections and of a text."""
    files = structure_files(case.structure) if case.structure is not None else ()
    rest = inputs_key(case, (*MATRICES, *sections), modules, files)
    return hashlib.sha256(f"{own}{rest}".encode()).hexdigest()


def published_values(case: Case) -> dict[str, float]:
    """Published values in SI by the name of the result; they change no result."""
    return {name: entry.value for name, entry in case.published.items()}


def tolerances(case: Case) -> dict[str, float]:
    """Largest relative difference from a published value that the case's reference allows."""
    reference = case.report.reference
    items = () if reference is None else reference.items
    return {value.name: value.tolerance for item in items for value in item.values}
