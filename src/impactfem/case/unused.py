"""Keys and sections that have no effect in a case, so that nobody relies on them."""

from collections.abc import Iterator
from typing import Any

from impactfem.case.model import Case
from impactfem.case.place import SEARCHED, Place, value_at
from impactfem.case.quantity import CALIBRATED
from impactfem.case.source import Source
from impactfem.system.errors import Fault

OF_REDUCED = (
    "tolerance", "shift", "largest_basis", "band", "fields", "field_frequencies", "snapshots",
    "maximum_frequency",
)  # fmt: skip
"""Keys of [transient] that only the reduced solver uses."""
OF_OWN_STICKS = ("stiffness_factor", "second_moment_factor", "periods", "modal_table")
"""Keys of [[buildings]] that only a stick of the floor table uses."""
OF_EXPORT = ("export_nodes", "export_start", "export_duration", "export_step")
"""Keys of [transient] that only an export uses."""


def unused(source: Source, case: Case) -> Iterator[Fault]:
    """Warn of what a case file says itself and nothing uses; a file that it extends has others."""
    yield from _unnamed(source)
    for place, text in _without_effect(case):
        if value_at(place, source.raw) is not None and source.file_of(place) == source.path:
            value = value_at(place, source.raw)
            shown = None if isinstance(value, dict) else value
            yield source.fault(place, shown, f"not used: {text}, or remove it")


def _unnamed(source: Source) -> Iterator[Fault]:
    """Materials and contact laws that nothing in the file names."""

    def texts(raw: Any) -> Iterator[str]:
        if isinstance(raw, dict | list):
            for below in raw.values() if isinstance(raw, dict) else raw:
                yield from texts(below)
        elif isinstance(raw, str):
            yield raw

    named = set(texts(source.raw))
    for table in ("materials", "contact_laws"):
        for name in source.raw.get(table, ()):
            if name not in named and source.file_of((table, name)) == source.path:
                yield source.fault((table, name), None, "not used: nothing in the case has it")


def _without_effect(case: Case) -> Iterator[tuple[Place, str]]:
    """Places of keys without effect, each with the reason and what would use it."""
    yield from _of_sticks(case)
    for k, damping in enumerate(case.damping_cases):
        calibrated = case.wall_impact is not None and damping.restitution == CALIBRATED
        if not case.devices and not calibrated:
            text = (
                "the analyses of [[devices]] are repeated with each damping, and the case has no "
                "device; results of sticks and of the 3D model have [damping] alone. Add "
                "[[devices]], or run the case with another [damping]"
            )
            yield ("damping_cases", k), text
    transient, analysis = case.transient, case.device_analysis
    if transient is not None:
        solver = transient.solver
        without = {
            "only the solvers 'reduced' and 'both' use it. Change solver": (
                OF_REDUCED if solver == "full" else ()
            ),
            "only the solvers 'full' and 'both' use it. Change solver": (
                ("checkpoint_every",) if solver == "reduced" else ()
            ),
            "nothing is exported. Add export = true": () if transient.export else OF_EXPORT,
            'fields has no "psa". Add it': (
                () if "psa" in transient.fields or solver == "full" else ("field_frequencies",)
            ),
        }
        in_storeys = any(
            end.storey is not None and end.building == structure.building
            for structure in case.structures
            for contact in case.contacts
            for end, _ in contact.ends
        )
        if transient.spread != "patch" and not in_storeys and not case.pounding_in_3d:
            text = 'no pair acts on a patch. Add spread = "patch"'
            without[text] = ("patch_width",)
        for text, keys in without.items():
            yield from ((("transient", key), text) for key in keys)
    if analysis is not None and not any(device.supports for device in case.devices):
        for key in ("supports", "displacements"):
            text = "no device has several supports. Add [[devices.supports]]"
            yield ("device_analysis", key), text
    if not case.contacts:
        for key in ("update", "points_per_impact"):
            yield ("pounding", key), "the case has no contact pairs. Add [contact_search]"
    elif case.contact_search is not None and all(c.table != SEARCHED for c in case.contacts):
        text = "no floors outside of [[contacts]] face each other. Change [[contacts]]"
        yield ("contact_search",), text
    if case.pounding.contact_spacing is not None and not case.pounding_in_3d:
        text = (
            "sticks touch at the points of [[contacts]], and only edges in 3D have such distances. "
            "Add 'structure' to models of [pounding]"
        )
        yield ("pounding", "contact_spacing"), text
    if case.calibration is not None and case.calibration.mode == "given":
        for key in ("starts", "seed"):
            yield ("calibration", key), 'mode = "given" fits nothing. Change mode to "fit"'
    if case.ensemble is not None and case.ensemble.records is not None:
        text = "the motions are records, which have no seed. Add motions in place of records"
        yield ("ensemble", "first_seed"), text


def _of_sticks(case: Case) -> Iterator[tuple[Place, str]]:
    """Factors and periods of sticks whose stiffness is given otherwise."""
    for k, building in enumerate(case.buildings):
        if building.name in case.sticks_on_models:
            text = 'the stick has the stiffness of the 3D model. Add stick = "own"'
            yield from ((("buildings", k, key), text) for key in OF_OWN_STICKS)
        elif not building.floors[0].section:
            text = "the floor table has no second moments of area. Add Ix, Iy, Iz, A, Avx and Avy"
            yield ("buildings", k, "second_moment_factor"), text
