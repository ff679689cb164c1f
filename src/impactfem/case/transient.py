"""The response of the 3D model in time: how it is computed, and where it is looked at."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.generated_mesh import GeneratedMesh
from impactfem.case.leaf import (
    Duration,
    File,
    Frequency,
    Length,
    PositiveTime,
    Ratio,
    Time,
    TimeStep,
    Whole,
    refuse,
)
from impactfem.case.place import value_at
from impactfem.case.probe import OUTSIDE, Probe, name_fault
from impactfem.case.source import Source
from impactfem.case.structure import Mesh
from impactfem.case.time_step import half_of_duration, step_fault
from impactfem.system.errors import Fault

SHIFT = 30.0
"""Frequency that reduced bases are expanded about, where the case names none [Hz]."""


class Transient(Section):
    """The 3D model in time, under the ground motion and the impact forces of the sticks.

    The forces act as line loads on the edges of the floors. Spectra are those of ``[spectra]``, the
    damping is that of the building, on all its parts that have none of their own.
    """

    solver: Literal["reduced", "full", "both"] = Field(
        default="reduced",
        description="'reduced' on a basis of few vectors; 'full' integrates all unknowns, which "
        "takes much longer, and records the probes only, without maps, waves and export; 'both' "
        "holds the reduced one against the full one.",
    )
    duration: Duration | None = Field(
        default=None,
        description="Time that is computed; default what is computed of the sticks, or as long as "
        "the forces of another program last.",
    )
    time_step: TimeStep = Field(description="Time step of the 3D model.")
    maximum_frequency: Frequency = Field(
        default=450.0,
        description="Frequency up to which the reduced basis is good; spectra above are marked.",
    )
    tolerance: Annotated[float, Ratio(above=0, below=1)] = Field(
        default=0.001,
        description="Relative error of the reduced transfer functions at the probes, by nested "
        "bases.",
    )
    serve_damping_cases: StrictBool = Field(
        default=False,
        description="Whether the reduced basis is made for the lightest damping among the "
        "building's own and those of [[damping_cases]], at maximum_frequency; it then serves all "
        "of them, with more vectors.",
    )
    shift: Frequency = Field(
        default=SHIFT, description="Frequency that the reduced basis is expanded about."
    )
    largest_basis: Annotated[int, Whole(1, 100_000)] = Field(
        default=1200, description="Largest number of vectors of the reduced basis."
    )
    band: Literal["larger", "smaller"] = Field(
        default="larger",
        description="What tells the error band of the reduced model: 'larger' bases, of up to a "
        "fifth more vectors, which take time and memory; or 'smaller' ones, at no cost, whose band "
        "is often more than ten times too wide.",
    )
    eccentricity: Length = Field(
        default=0.0,
        description="Distance of the impact forces from the middle of the edges, along them.",
    )
    forces: File | None = Field(
        default=None,
        description="Impact forces of another program (NetCDF or CSV) in place of the sticks'.",
    )
    fields: tuple[Literal["pfa", "psa"], ...] = Field(
        default=("pfa", "psa"),
        description="Maps over all nodes of the floors: of the peak acceleration, of the "
        "pseudo-acceleration at field_frequencies.",
    )
    field_frequencies: tuple[Frequency, ...] = Field(
        default=(10.0, 75.0, 85.0),
        description="Frequencies of the maps of pseudo-acceleration.",
    )
    snapshots: StrictBool = Field(
        default=True, description="Whether pictures of the waves at the main impact are made."
    )
    export: StrictBool = Field(
        default=False,
        description="Whether the motion of the whole model is written for ParaView; not with "
        "solver 'full'.",
    )
    export_nodes: Literal["vertices", "all"] = Field(
        default="vertices",
        description="Which nodes of the elements are written; 'all' takes about four times the "
        "room and shows shorter waves.",
    )
    export_start: Time | None = Field(
        default=None,
        description="First time that is written; default 10 ms before the main impact, or, where "
        "nothing touches, before the largest ground acceleration.",
    )
    export_duration: PositiveTime = Field(
        default=0.2, description="Time that is written, at most to the end of what is computed."
    )
    export_step: PositiveTime | None = Field(
        default=None,
        description="Time between two pictures, rounded to whole time steps; default one step.",
    )
    checkpoint_every: PositiveTime = Field(
        default=1.0,
        description="Computed time between two states from which the full solver can go on.",
    )
    probes: tuple[Probe, ...] = Field(
        default=(), description="Points that are looked at, beside those that are always there."
    )

    _step_in_duration = field_validator("time_step")(half_of_duration)

    @field_validator("export")
    @classmethod
    def _all_nodes_known(cls, value: bool, info: ValidationInfo) -> bool:
        if value and info.data.get("solver") == "full":
            raise refuse("expected solver 'reduced' or 'both': 'full' records its probes only")
        return value

    @field_validator("export_step")
    @classmethod
    def _a_step_or_more(cls, value: float | None, info: ValidationInfo) -> float | None:
        step = info.data.get("time_step")
        if value is not None and step is not None and value < step * (1.0 - 1e-9):
            raise refuse(f"expected at least the time step, {step:g} s")
        return value

    @field_validator("fields")
    @classmethod
    def _each_once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) < len(value):
            raise refuse("expected each map once")
        return value

    @field_validator("field_frequencies")
    @classmethod
    def _increasing(cls, value: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        if any(b <= a for a, b in itertools.pairwise(value)):
            raise refuse("expected increasing frequencies")
        if not value and present(info, ["fields"]) and "psa" in info.data["fields"]:
            raise refuse("expected at least one frequency, or fields without 'psa'")
        return value

    @field_validator("probes")
    @classmethod
    def _own_names(cls, value: tuple[Probe, ...]) -> tuple[Probe, ...]:
        fault = name_fault(value)
        if fault is not None:
            raise refuse(fault)
        return value


def transient_files(transient: Transient) -> tuple[Path, ...]:
    """The files that the response depends on besides those of the case: forces from elsewhere."""
    return () if transient.forces is None else (transient.forces,)


def transient_faults(
    source: Source,
    transient: Transient,
    mesh: Mesh,
    levels: tuple[float, ...],
    computed: float | None,
) -> Iterator[Fault]:
    """What does not go together between the response in time and the rest of its case.

    Args:
        source: The case file.
        transient: The response in time.
        mesh: The mesh of the structure.
        levels: Elevations of the base and of the floors of its building [m].
        computed: Time that is computed of the sticks [s]; None when it is not known yet.
    """
    if computed is not None and transient.forces is None:
        yield from _time_faults(source, transient, computed)
    known = transient.duration or (computed if transient.forces is None else None)
    start = transient.export_start
    if transient.export and start is not None and known is not None and start >= known:
        yield _fault(source, "export_start", f"expected less than what is computed, {known:g} s")
    if isinstance(mesh, GeneratedMesh):
        edge = mesh.length if mesh.impact_edge.startswith("y") else mesh.width
        if abs(transient.eccentricity) > edge / 2.0:
            expected = f"expected a distance within the edge, {edge / 2.0:g} m to either side"
            yield _fault(source, "eccentricity", expected)
        yield from _outside_faults(source, transient, mesh, levels)
    floors = len(levels) - 1
    for index, probe in enumerate(transient.probes):
        level = re.search("_([1-9][0-9]*)", probe.group or "")
        if level is not None and int(level[1]) > floors:
            place = ("transient", "probes", index, "group")
            expected = f"expected a number of 1 to {floors}, the floors of the building"
            yield source.fault(place, probe.group, expected)


def _outside_faults(
    source: Source, transient: Transient, mesh: GeneratedMesh, levels: tuple[float, ...]
) -> Iterator[Fault]:
    """Probes away from the box around a generated building; its nodes are not known yet."""
    top = levels[-1] + (0.0 if mesh.acroterion is None else mesh.acroterion.height)
    box = ((0.0, mesh.length), (0.0, mesh.width), (levels[0], top))
    sizes = (mesh.size, mesh.floor_size, mesh.storey_size, mesh.beam_size, mesh.column_size)
    # As far as the stage may take the nearest node for the point.
    away = max(OUTSIDE, *(0.5 * size for size in sizes if size is not None))
    for index, probe in enumerate(transient.probes):
        for key, point in (("point", probe.point), ("from", probe.start), ("to", probe.end)):
            if point is None:
                continue
            if any(
                not low - away <= x <= high + away
                for x, (low, high) in zip(point, box, strict=True)
            ):
                sides = ", ".join(
                    f"{axis} of {low:g} to {high:g} m"
                    for axis, (low, high) in zip("xyz", box, strict=True)
                )
                place = ("transient", "probes", index, key)
                expected = f"expected a point of the building, which has {sides}"
                yield source.fault(place, list(point), expected)


def _time_faults(source: Source, transient: Transient, computed: float) -> Iterator[Fault]:
    """A duration that the forces of the sticks do not last, or a step that is long for them."""
    if transient.duration is None:
        fault = step_fault(transient.time_step, computed)
        if fault is not None:
            yield _fault(source, "time_step", fault)
    elif transient.duration > computed * (1.0 + 1e-9):
        expected = f"expected at most what is computed of the sticks, {computed:g} s"
        yield _fault(source, "duration", expected)


def _fault(source: Source, key: str, expected: str) -> Fault:
    place = ("transient", key)
    return source.fault(place, value_at(place, source.raw), expected)
