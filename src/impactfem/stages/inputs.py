"""Inputs of the stages: hashes that tell whether one changed, and the published values."""

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import impactfem
from impactfem.case import Building3D, Case, motion_files
from impactfem.case.capacities import CAPACITIES


@cache
def program_key() -> str:
    """Compute the hash of the version and all sources: a changed program may change a result.

    In a checkout the sources are those of the working tree. They are read once: their changes
    during a run are not seen.
    """
    digest, root = hashlib.sha256(impactfem.__version__.encode()), Path(impactfem.__file__).parent
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def inputs_key(
    subject: Case | Building3D, sections: tuple[str, ...], files: tuple[Path, ...] = ()
) -> str:
    """Compute the hash of the program, of sections of the case, and of the content of files.

    Of a building those that it has itself count in the place of the case's.

    With ``motions`` and ``loads`` the files that they name count too; without ``damping`` that of
    buildings and parts does not, without ``soil`` not the soil under buildings, and without
    ``contact_laws`` not the restitution of the damping cases. Capacities of devices never count.
    """
    case = subject if isinstance(subject, Case) else subject.with_sections
    digest = hashlib.sha256(program_key().encode())
    # The content of a record or a mesh counts, not its path.
    nowhere: dict[str, Any] = {
        "motions": {"__all__": {"file"}},
        "loads": {"__all__": {"file"}},
        "structure": {"mesh": {"file"}},
        "transient": {"forces"},
        "devices": {"__all__": set(CAPACITIES)},
        # The number of members for the 3D model changes none of the members.
        "ensemble": {"structure_motions"},
    }
    nowhere["buildings"] = {"__all__": {"damping", "soil"} - set(sections)}
    if "damping" not in sections:
        nowhere["structure"]["damping"] = True
    if "contact_laws" not in sections:
        nowhere["damping_cases"] = {"__all__": {"restitution"}}
    digest.update(case.model_dump_json(include=set(sections), exclude=nowhere).encode())
    motions = case.motions if "motions" in sections else ()
    loads = case.loads if "loads" in sections else ()
    records = [file for motion in motions for file in motion_files(motion)]
    for file in (*records, *(one.file for one in loads), *files):
        # A stage that is not requested may lack a file; no finished stage has this key then.
        digest.update(file.read_bytes() if file.exists() else b"missing")
    return digest.hexdigest()


def published_values(subject: Case | Building3D) -> dict[str, float]:
    """Published values in SI by the name of the result; they change no result."""
    return {name: entry.value for name, entry in subject.published.items()}


def tolerances(case: Case) -> dict[str, float]:
    """Largest relative difference from a published value that the case's reference allows."""
    reference = case.report.reference
    items = () if reference is None else reference.items
    return {value.name: value.tolerance for item in items for value in item.values}
