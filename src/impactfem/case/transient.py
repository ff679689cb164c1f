"""The response of the 3D model in time: how it is computed, and the probes that record it."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, StrictBool, Tag, field_validator

from impactfem.case.base import Section, ascending, once, refuse, rule, step_within, together
from impactfem.case.leaf import FileName, FloorNumbers, ModelledBuilding, Name, Whole, Words
from impactfem.case.quantity import (
    Duration,
    Frequency,
    Length,
    PositiveLength,
    PositiveTime,
    Si,
    Time,
    TimeStep,
)
from impactfem.system.files import LARGEST_FORCES

Point = tuple[float, float, float]
_Point = tuple[Length, Length, Length]
_GroupName = Annotated[
    str,
    Words(
        "the name of a physical group of the mesh, for example 'edge_8' or 'floor_8'",
        "(?:floor|storey|beam|column)_[1-9][0-9]*(?:_[a-z0-9]+)*|(?:edge|centre)_[1-9][0-9]*|base",
    ),
]
_STANDARD = "(?:centre|edge|line)_[1-9][0-9]*"
_FORCES = FileName("a force history (NetCDF or CSV)", largest=LARGEST_FORCES, deferred=True)
OUTSIDE = 1.0
"""Distance of a point from the building that is always taken for a point of it [m]."""
ModelName = Annotated[str, ModelledBuilding()]
_WAYS = "point, or from with to and count, or group"


class Probe(Section):
    """A point of the 3D model whose motion is recorded, or several of them.

    Of a point of the case, and of mass centres, the rotations of its node are recorded as well.

    Either ``point``, or ``from``, ``to`` and ``count``, or ``group``. Several points are named
    ``corner_1``, ``corner_2`` and so on. Always there, without a table: ``centre_1`` and so on, the
    mass centre of each floor; ``edge_1`` and so on, the middle of each impact edge; ``line_1`` and
    so on, from the middle of its impact edge to the opposite one, across the highest floor that
    contacts may strike; without contacts across the top floor.
    """

    name: Name
    """Name of the probe; several points are numbered."""
    building: ModelName = Field(default=None, validate_default=True)
    """Name of the building; default each one with a 3D model."""
    point: _Point | None = None
    """Coordinates (x, y, z) of one point; the nearest node is taken."""
    start: _Point | None = Field(default=None, alias="from")
    """First of several points on a straight line."""
    end: _Point | None = Field(default=None, alias="to", validate_default=True)
    """Last of these points."""
    count: Annotated[int, Whole(2, 10_000)] | None = Field(default=None, validate_default=True)
    """Number of these points, equally far apart, both ends included."""
    group: _GroupName | None = Field(default=None, validate_default=True)
    """Physical group of the mesh: every node of it."""

    @rule("start", "point")
    @staticmethod
    def _not_beside_point(start: Point | None, point: Point | None) -> Iterator[str]:
        if start is not None and point is not None:
            yield f"expected one way only: {_WAYS}"

    _both_ends = together("start", "end", "from and to")

    @rule("end", "start")
    @staticmethod
    def _away_from_start(end: Point | None, start: Point | None) -> Iterator[str]:
        if end is not None and end == start:
            yield "expected another point than from"

    @rule("count", "start", "end")
    @staticmethod
    def _of_line(count: int | None, start: Point | None, end: Point | None) -> Iterator[str]:
        if count is None and start is not None:
            yield "required with `from` and `to`: a whole number of at least 2"
        if count is not None and start is None:
            yield "`count` requires `from` and `to`"

    @rule("group", "point", "start", "end", "count")
    @staticmethod
    def _one_way(group: str | None, point: Any, start: Any, end: Any, count: Any) -> Iterator[str]:
        if group is None and point is None and start is None:
            yield f"missing; expected one of {_WAYS}"
        if group is not None and (point is not None or start is not None):
            yield f"expected one way only: {_WAYS}"

    @property
    def points(self) -> tuple[tuple[str, Point], ...]:
        """Names and coordinates [m] of the points; none for a group, whose nodes the mesh has."""
        if self.point is not None:
            return ((self.name, self.point),)
        if self.start is None or self.end is None or self.count is None:
            return ()
        last = self.count - 1
        return tuple(
            (self.numbered(k + 1), _between(self.start, self.end, k / last))
            for k in range(self.count)
        )

    def numbered(self, number: int) -> str:
        """Name of one of several points, counted from 1."""
        return f"{self.name}_{number}"

    def claims(self, name: str) -> bool:
        """Return True if a point of this probe has, or in a group may have, a name."""
        if self.point is not None:
            return name == self.name
        match = re.fullmatch(rf"{re.escape(self.name)}_([1-9][0-9]*)", name)
        return match is not None and (self.count is None or int(match[1]) <= self.count)


def _between(a: Point, b: Point, share: float) -> Point:
    """The point at a share of the way from a to b; both ends are met exactly."""
    x, y, z = ((1.0 - share) * p + share * q for p, q in zip(a, b, strict=True))
    return x, y, z


SHIFT = 30.0
"""Frequency that the reduced basis is expanded about, where the case names none [Hz]."""
MAXIMUM_FREQUENCY = 450.0
TOLERANCE = 0.001
LARGEST_BASIS = 1200


class Transient(Section):
    """The 3D model in time, under the ground motion and the impact forces.

    The forces act as line loads on the struck sides of the floors, and inside storeys on walls and
    columns. ``[spectra]`` applies. The damping is that of the building for all parts without a
    separate damping.
    """

    solver: Literal["reduced", "full", "both"] = "reduced"
    """'reduced' uses a reduced basis; 'full' integrates all unknowns, takes much longer, and
    records probes only (no maps, waves, export); 'both' compares them."""
    duration: Duration | None = None
    """Computed time; default that of the pounding, or of the forces of another program."""
    time_step: TimeStep
    """Time step of the 3D model."""
    maximum_frequency: Frequency = MAXIMUM_FREQUENCY
    """Highest frequency of the reduced basis; spectra above are marked."""
    tolerance: Annotated[float, Si("-", gt=0, lt=1)] = TOLERANCE
    """Allowed relative error of the reduced transfer functions at the probes, estimated by nested
    bases."""
    serve_damping_cases: StrictBool = False
    """Make the reduced basis for the lowest damping of the building and [[damping_cases]] at
    maximum_frequency. It then serves all of them, with more vectors."""
    shift: Frequency = SHIFT
    """Expansion frequency of the reduced basis."""
    largest_basis: Annotated[int, Whole(1, 100_000)] = LARGEST_BASIS
    """Largest number of vectors of the reduced basis."""
    floors: (
        Annotated[
            Annotated[FloorNumbers, Tag("list")]
            | Annotated[dict[ModelName, FloorNumbers], Tag("table")],
            Discriminator(lambda value: "table" if isinstance(value, dict) else "list"),
        ]
        | None
    ) = None
    """Floors that may be hit or loaded, each with the storey below; fewer floors need fewer
    vectors. One list for all 3D models, or a table by name: { B1 = [7, 8], B2 = 5 }. Default those
    of contacts and loads."""
    band: Literal["larger", "smaller"] = "larger"
    """Source of the error band of the reduced model: 'larger' bases with up to a fifth more
    vectors, which need time and memory; or 'smaller' bases without cost, whose band is often more
    than ten times too wide."""
    spread: Literal["uniform", "patch", "calibrated"] = "uniform"
    """Distribution of the force of a pair along the struck side. Resultant and moment about the
    vertical are always those of the pair. 'uniform': on the whole side, with a linear part for an
    eccentric pair; 'patch': on patch_width around the pair; 'calibrated': as the impulse of
    [wall_impact], whose contact_spacing sets the number of load patterns and the size of the
    basis."""
    patch_width: PositiveLength = 2.0
    """Width of the patch of spread 'patch', and of the square on walls and columns loaded by a pair
    inside a storey."""
    eccentricity: Length = 0.0
    """Shift of all forces along the sides, in addition to the offsets of their pairs, for example
    accidental eccentricity."""
    forces: Annotated[Path, _FORCES] | None = None
    """Impact forces of another program (NetCDF or CSV) in place of the pounding, positive in
    compression (see compression). A CSV has the columns `time [s]` and `<pair> [N]`, in any units
    of time and force. A pair is named by its two points: west.floor_2-east.floor_2, east.storey_3
    for a point in a storey, or the wall. Further pairs of the same floors end with #2, #3:
    west.floor_2-east.floor_2#2."""
    compression: Literal["positive", "negative"] = "positive"
    """Sign of compression in the file of forces: contact forces of OpenSees and SAP2000 are
    'negative'."""
    fields: tuple[Literal["pfa", "psa"], ...] = ("pfa", "psa")
    """Maps over all nodes of the floors: peak acceleration, pseudo-acceleration at
    field_frequencies."""
    field_frequencies: tuple[Frequency, ...] | None = None
    """Frequencies of the maps of pseudo-acceleration; default: the modes of the devices of the
    building, without devices 10, 33 and 100 Hz."""
    snapshots: StrictBool = True
    """Draw the waves at the main impact."""
    export: StrictBool = False
    """Write the motion of the whole model for ParaView; not with solver 'full'."""
    export_nodes: Literal["vertices", "all"] = "vertices"
    """Nodes that are written; 'all' needs about four times the space and shows shorter waves."""
    export_start: Time | None = None
    """First time that is written; default 10 ms before the main impact, or, without contact, before
    the largest force of [[loads]] or the largest ground acceleration."""
    export_duration: PositiveTime = 0.2
    """Duration that is written."""
    export_step: PositiveTime | None = None
    """Time between two frames, rounded to whole time steps; default one step."""
    checkpoint_every: PositiveTime = 1.0
    """Computed time between two checkpoints of the full solver."""
    probes: tuple[Probe, ...] = ()
    """Further points at which the response is recorded."""

    _step_in_duration = step_within("duration", 0.5)

    @rule("compression", "forces")
    @staticmethod
    def _of_given_forces(compression: str, forces: Path | None) -> Iterator[str]:
        if compression == "negative" and forces is None:
            yield "expected forces of another program; those of the pounding are positive"

    @rule("export", "solver")
    @staticmethod
    def _all_nodes_known(export: bool, solver: str) -> Iterator[str]:
        if export and solver == "full":
            yield "expected solver 'reduced' or 'both': 'full' records its probes only"

    @rule("export_step", "time_step")
    @staticmethod
    def _a_step_or_more(export: float | None, step: float) -> Iterator[str]:
        if export is not None and export < step * (1.0 - 1e-9):
            yield f"expected at least the time step, {step:g} s"

    @field_validator("floors")
    @classmethod
    def _floors_once(cls, value: Any) -> Any:
        if isinstance(value, dict):
            return {name: cls._floors_once(floors) for name, floors in value.items()}
        if value is not None and len(set(value)) < len(value):
            raise refuse("expected each floor once", kind="once")
        return None if value is None else tuple(sorted(value))

    _maps_once = once("fields", "map")
    _increasing = ascending("field_frequencies", "expected increasing frequencies")

    @rule("field_frequencies", "fields")
    @staticmethod
    def _of_the_maps(
        frequencies: tuple[float, ...] | None, fields: tuple[str, ...]
    ) -> Iterator[str]:
        if frequencies == () and "psa" in fields:
            yield "expected at least one frequency, or fields without 'psa'"

    @rule("probes")
    @staticmethod
    def _own_names(probes: tuple[Probe, ...]) -> Iterator[tuple[str | int, ...]]:
        names: dict[str, Probe] = {}
        # By what is before the number at the end of their name.
        points: dict[str, list[tuple[int, Probe]]] = {}
        for k, probe in enumerate(probes):
            first = probe.numbered(1) if probe.point is None else probe.name
            if re.fullmatch(_STANDARD, first) is not None:
                yield (
                    f"expected another name than {probe.name}: centre_1, edge_1, line_1 and so on "
                    "are always there",
                    k,
                    "name",
                )
            other = names.setdefault(probe.name.lower(), probe)
            if other is not probe:
                expected = f"expected unique names, found {other.name} and {probe.name}"
                yield expected, k, "name"
            if probe.point is not None:
                points.setdefault(probe.name.rpartition("_")[0], []).append((k, probe))
        for several in probes:
            for k, one in points.get(several.name, ()) if several.point is None else ():
                if several.claims(one.name):
                    expected = f"expected unique names, found {several.name} and {one.name}"
                    yield expected, k, "name"


def transient_files(transient: Transient) -> tuple[Path, ...]:
    """The files that the response depends on besides those of the case: forces from elsewhere."""
    return () if transient.forces is None else (transient.forces,)
