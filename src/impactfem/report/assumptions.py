"""What the method assumes, whatever the case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

CALIBRATED = "calibrated"
"""The word of the case for a value that the impact on the rigid wall gives."""
ALWAYS = (
    (
        "The buildings stay linear elastic.",
        "Damage near an impact would take energy out and lower force and restitution; the checks "
        "of bearing pressure and storey shear say how far this holds.",
    ),
    (
        "The ground is rigid and moves all buildings alike.",
        "Soil and foundations would lower the frequencies and add damping.",
    ),
    (
        "Displacements are small, and gaps are those of the buildings at rest.",
        "Penetrations and drifts are a few centimetres on floors of metres.",
    ),
    (
        "Damping is Rayleigh's, C = αM + βK.",
        "It grows with the frequency: it decides how far shock waves carry.",
    ),
    (
        "Floors of a stick are rigid, and impacts act at points.",
        "Waves within a floor are those of the 3D model; the stick's restitution and contact "
        "stiffness stand for what they take out.",
    ),
)
STRUCTURE = (
    (
        "The 3D model is clamped at its base; shells are flat and thin or thick, beams are shear-"
        "flexible, joints are rigid.",
        "Openings below the size of the mesh, reinforcement and cracks are not in it.",
    ),
    (
        "One factor on the stiffness of walls and columns makes its first frequency the one asked.",
        "Slabs keep the true modulus: it decides the speed of waves and how long impacts last.",
    ),
    (
        "Masses that a floor carries beyond its own are spread evenly over it.",
        "Heavy equipment that stands together would change the floor's own modes.",
    ),
)
TRANSIENT = (
    (
        "The impact forces of the sticks act on the 3D model as line loads along the impact edges.",
        "The 3D model does not act back on them; torsion of the buildings does not change them.",
    ),
)
WALL_BESIDE = (
    (
        "The contact laws have the values of the case; those of the impact on a rigid wall are not "
        "used.",
        "They stand beside them: what the impact of the 3D model would give.",
    ),
)
WALL = (
    (
        "Restitution and contact stiffness come from one impact of the 3D model on a rigid wall.",
        "The wall neither moves nor takes energy; two buildings that meet share what one loses.",
    ),
)
DEVICES = (
    (
        "A device is linear, on a rigid base that spreads over the floor nodes within its radius.",
        "Slip and the flexibility of anchors are not in it; a check says whether the weight alone "
        "would hold it down.",
    ),
    (
        "Response spectrum analyses take the spectra of the floor without the device.",
        "Its feedback on the floor is in the detailed analysis alone.",
    ),
)


def assumptions(case: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """What was assumed and why, in groups.

    Args:
        case: The case, as a run writes it down.

    Returns:
        Each group's title, with the assumptions and their reasons.
    """
    method = list(ALWAYS)
    for section, further in (
        ("structure", STRUCTURE),
        ("wall_impact", WALL if wall_is_used(case) else WALL_BESIDE),
        ("transient", TRANSIENT),
        ("devices", DEVICES),
    ):
        if case[section]:
            method += further
    groups = [("The method", method)]
    report = case["report"]
    if report["assumptions"]:
        groups.append(("This case", _own(report["assumptions"])))
    reference = report["reference"]
    if reference is not None and reference["assumptions"]:
        title = "What the publication leaves out, and what is taken in its place"
        groups.append((title, _own(reference["assumptions"])))
    return groups


def wall_is_used(case: Mapping[str, Any]) -> bool:
    """Whether a contact law takes a value from the impact on the rigid wall.

    Args:
        case: The case, as a run writes it down.
    """
    return any(
        CALIBRATED in (law.get("stiffness"), law.get("restitution"))
        for law in case["contact_laws"].values()
    )


def _own(entries: list[Mapping[str, str]]) -> list[tuple[str, str]]:
    return [(entry["text"], entry["reason"]) for entry in entries]
