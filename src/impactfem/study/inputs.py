"""Inputs of the stages: hashes that tell whether one changed, and the published values."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import impactfem
from impactfem.case import Case, motion_files


def inputs_key(
    case: Case,
    sections: tuple[str, ...],
    rooms: tuple[str, ...],
    files: tuple[Path, ...] = (),
) -> str:
    """Hash of the program's version and rooms, of sections of the case, and of files.

    Args:
        case: The case.
        sections: Names of the sections of the case file that count. With ``motions`` the records
            that they name count too; without ``damping`` that of the buildings does not, and
            without ``contact_laws`` the restitution of the damping cases does not.
        rooms: Names of the folders of the program, or of its files, whose sources count.
        files: Further files whose content counts.

    Returns:
        The hash, as hexadecimal digits.
    """
    digest = hashlib.sha256(program_key(rooms).encode())
    # What is in a record or a mesh counts, not where it lies.
    nowhere: dict[str, Any] = {
        "motions": {"__all__": {"file"}},
        "structure": {"mesh": {"file"}},
        "transient": {"forces"},
    }
    if "damping" not in sections:
        nowhere["buildings"] = {"__all__": {"damping"}}
    if "contact_laws" not in sections:
        nowhere["damping_cases"] = {"__all__": {"restitution"}}
    digest.update(case.model_dump_json(include=set(sections), exclude=nowhere).encode())
    if "motions" in sections:
        for motion in case.motions:
            for file in motion_files(motion):
                digest.update(file.read_bytes())
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()


@cache
def program_key(rooms: tuple[str, ...]) -> str:
    """Hash of the program's version and of the rooms' sources, as they were when first asked.

    A changed program may change the result: it counts as an input.

    Args:
        rooms: Names of folders of the program; the Python files in each count, not those of
            folders below. Or names of files.

    Returns:
        The hash, as hexadecimal digits.
    """
    digest = hashlib.sha256(impactfem.__version__.encode())
    for room in rooms:
        place = Path(impactfem.__file__).parent / room
        for source in [place] if place.is_file() else sorted(place.glob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def published_values(case: Case) -> dict[str, float]:
    """Published values in SI by the name of the result; they change no result."""
    return {name: entry.value for name, entry in case.published.items()}
