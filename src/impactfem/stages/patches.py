"""Patches of 3D models on which contact forces of the pounding act, in words."""

from collections.abc import Iterator, Mapping
from typing import Any

from impactfem.case.levels import HALF_SLAB


def contact_patches(case: Mapping[str, Any]) -> Iterator[str]:
    """Describe for each 3D model the patches that contact forces act on.

    Args:
        case: The values of a case, as in ``case.json`` of a run.

    There are none on floors with a line load on their whole side, nor on a model that touches
    others along its edges. Line contacts have strips in place of patches on storeys.
    """
    transient, models = case.get("transient"), case["pounding"].get("models", {})
    structures = [case.get("structure"), *case.get("further_structures", ())]
    for building in (one["building"] for one in structures if one is not None):
        if transient is None or models.get(building) == "structure":
            continue
        pairs = [
            (end, contact)
            for contact in case["contacts"]
            for end in (contact["a"], contact["b"])
            if end is not None and end["building"] == building
        ]
        ends = [end for end, contact in pairs if contact.get("length") is None]
        width = f"{transient['patch_width']:g} m"
        key = f'patch_width = "{width}" of [transient]'
        floors = sorted({end["floor"] for end in ends if end["floor"] is not None})
        if floors and transient["spread"] == "patch":
            yield (
                f"Each contact force on a floor of the 3D model of {building} acts on a patch of "
                f"{width} of its side, floors {', '.join(map(str, floors))} ({key})"
            )
        storeys = sorted({end["storey"] for end in ends if end["storey"] is not None})
        if storeys:
            yield (
                f"Each contact force in a storey of the 3D model of {building} acts on the walls "
                f"and columns in a square patch of {width} x {width}, however long the edge is "
                f"that hits them, storeys {', '.join(map(str, storeys))} ({key}): a wider patch "
                "lowers the accelerations near it"
            )
        strips = [contact for end, contact in pairs if end["storey"] is not None]
        strips = [contact for contact in strips if contact.get("length") is not None]
        if strips:
            lengths, depths = (
                " to ".join(f"{x:g}" for x in sorted({min(values), max(values)}))
                for values in (
                    [contact["length"] for contact in strips],
                    [contact["depth"] or 2.0 * HALF_SLAB for contact in strips],
                )
            )
            known = all(contact["depth"] is not None for contact in strips)
            default = f"; a slab without slab_depth counts as {2.0 * HALF_SLAB:g} m deep"
            yield (
                f"Each contact force of a line in a storey of the 3D model of {building} acts on "
                f"the walls and columns in a strip of {lengths} m x {depths} m"
                f"{'' if known else default}"
            )
