"""Devices anchored to a floor of a 3D model, and how the forces on their anchors are computed."""

import fnmatch
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section, once, refuse, rule
from impactfem.case.capacities import AnchorBolts, QualificationSpectrum, on_plate
from impactfem.case.damping import DampingEntry
from impactfem.case.device_tables import (
    MODES_FILE,
    SPECTRA_FILE,
    DeviceMatrices,
    DeviceMode,
    GivenSpectra,
    GivenSpectrum,
)
from impactfem.case.leaf import ModelledBuilding, Name, OneOrMore, Whole, Words
from impactfem.case.members import TOUCH
from impactfem.case.quantity import (
    Acceleration,
    DampingRatio,
    Duration,
    Frequency,
    Length,
    Mass,
    PositiveLength,
    Si,
    TimeStep,
)
from impactfem.case.reading import reading_of
from impactfem.case.transient import Probe

ProbePattern = Annotated[
    str,
    Words(
        "the name of a probe of [transient], or a pattern of names such as 'corner_*'",
        r"[A-Za-z0-9_*?-]+",
    ),
]
Point = tuple[Length, Length, Length]

_LINE_POINTS = 9


def chosen(names: Sequence[str], patterns: Sequence[str]) -> list[str]:
    """The names that patterns with * and ? stand for, in the order of the names."""
    return [name for name in names if any(fnmatch.fnmatchcase(name, p) for p in patterns)]


class DeviceSupport(Section):
    """One of several places where a device is anchored."""

    point: Point
    """The anchor (x, y, z), on a floor of the building."""
    radius: PositiveLength
    """Radius of its rigid base plate, and of its circle of anchors."""
    envelope: tuple[ProbePattern, ...] = ()
    """Probes for the envelope of spectra, as for a device with one anchor."""

    _each_once = once("envelope", "name or pattern")

    def unknown_probes(self, probes: Sequence[Probe], floors: Sequence[int]) -> Iterator[str]:
        """Patterns of the envelope that stand for no probe; how many a group has the mesh will say.

        Without floors, which are then not known, what is always there is not checked.
        """
        standard = [f"{kind}_{k}" for kind in ("centre", "edge") for k in floors]
        standard += [f"line_{k}" for k in range(1, _LINE_POINTS + 1)]
        named = [name for probe in probes for name, _ in probe.points]
        groups = [probe for probe in probes if probe.group is not None]
        for pattern in self.envelope:
            if chosen([*standard, *named], [pattern]):
                continue
            if not floors and re.fullmatch(r"(?:centre|edge)_[\d*?]+", pattern):
                continue
            if any(one.claims(pattern) or chosen([one.numbered(1)], [pattern]) for one in groups):
                continue
            yield pattern


Rigid = Literal["rigid"]
(RIGID,) = get_args(Rigid)
"""Stands for a stiffness without bound."""

_Bending = Annotated[float, Si("N m2", gt=0)]
_Twisting = Annotated[float | Rigid, Si("N m2", gt=0, word=RIGID)]
_Section = Annotated[
    float | Rigid, Si("N", gt=0, word=RIGID, kind="a shear or stretching stiffness")
]

# Zero is reported below with the motion that nothing holds.
_Spring = Annotated[float | Rigid, Si("N/m", ge=0, word=RIGID)]
_TurningSpring = Annotated[float | Rigid, Si("N m/rad", ge=0, word=RIGID)]


class BaseStiffness(Section):
    """The springs between the base of a device and its anchor, one a motion; none may be zero."""

    x: _Spring
    """Stiffness along x; 'rigid' lets the base move with the anchor."""
    y: _Spring
    """Stiffness along y."""
    z: _Spring
    """Stiffness along z."""
    rx: _TurningSpring
    """Stiffness about x."""
    ry: _TurningSpring
    """Stiffness about y."""
    rz: _TurningSpring
    """Stiffness about z."""

    @field_validator("x", "y", "z", "rx", "ry", "rz")
    @classmethod
    def _no_mechanism(cls, value: float | Rigid, info: ValidationInfo) -> float | Rigid:
        if value == 0.0:
            name = info.field_name or ""
            motion = f"rotation about {name[1]}" if name.startswith("r") else f"motion along {name}"
            raise refuse(
                f"a mechanism: no stiffness holds the {motion} of the base; expected a stiffness "
                f"above 0, or '{RIGID}'",
                kind="mechanism",
            )
        return value


class DeviceBeam(Section):
    """An upright beam from the base of a device to its body."""

    length: PositiveLength
    """Length of the beam."""
    bending: Annotated[tuple[_Bending, _Bending], OneOrMore(2)]
    """Bending stiffness E I; of two, the first one bends about x, which moves along y, the second
    one about y."""
    shear: Annotated[tuple[_Section, _Section], OneOrMore(2)] = (RIGID, RIGID)
    """Shear stiffness G A_v; of two, along x and along y."""
    stretching: _Section = RIGID
    """Stiffness E A along the beam."""
    twisting: _Twisting = RIGID
    """Torsional stiffness G J."""
    mass: Annotated[float, Si("kg", ge=0)] = 0.0
    """Mass of the whole beam, evenly distributed."""
    elements: Annotated[int, Whole(1, 1000)] = 4
    """Number of elements."""


NODES = 3
"""Least number of floor nodes that spread an anchor; fewer hold it at a point or along a line."""
SAME_MASS = 0.02
"""Largest difference between the mass of a device and that of its matrices, over the mass."""
_Moment = Annotated[float, Si("kg m2", ge=0)]
_WHAT_MOVES = {"modes": "the table says", "matrices": "they say"}


def _alone(field: str, other: str) -> Any:
    """The rule that a part of the device is not combined with modes or matrices."""

    def wrong(value: Any, model: Any) -> Iterator[str]:
        if value is not None and model is not None:
            yield f"cannot be combined with `{other}`: {_WHAT_MOVES[other]} how the device moves"

    return rule(field, other, kind="alone")(wrong)


def _one_place(field: str, what: str) -> Any:
    """The rule that a device has one anchor, or several supports."""

    def wrong(value: Any, supports: Any) -> Iterator[str]:
        if value is None and not supports:
            yield f"missing; expected the {what}, or supports: several anchors"
        if value is not None and supports:
            yield "cannot be combined with `supports`: each has a point and a radius"

    return rule(field, "supports", kind="one_place")(wrong)


def _or_a_table(field: str, what: str) -> Any:
    """The rule that a device has this part of a body, or modes or matrices."""

    def wrong(value: Any, modes: Any, matrices: Any) -> Iterator[str]:
        if value is None and modes is None and matrices is None:
            yield f"missing; expected {what}, or modes: the table of a device, or matrices"

    return rule(field, "modes", "matrices", kind="or_a_table")(wrong)


def _with_a_mass(value: Any, mass: float | None) -> Iterator[str]:
    if value is not None and mass is None:
        yield "requires `mass`"


class Cylinder(Section):
    """A solid upright cylinder, from whose mass and size its moments of inertia follow."""

    type: Literal["cylinder"]
    """A solid upright cylinder."""
    radius: PositiveLength
    """Its radius."""
    length: PositiveLength
    """Its height."""


class DeviceSetup(Section):
    """A device on a floor of a building with a 3D model: a rigid body on springs, or a table.

    Either ``mass``, ``mass_height``, ``inertia`` or ``shape``, ``stiffness`` and ``damping``, with
    a ``beam`` where it has one; or ``modes``; or ``matrices``. With a beam, too, the mass centre is
    counted from the anchor.
    """

    name: Name
    """Name of the device, unique in the file."""
    building: Annotated[str, ModelledBuilding(whose="the device")] = Field(
        default=None, validate_default=True
    )
    """Name of the building; default the one with a 3D model."""
    supports: tuple[DeviceSupport, ...] = ()
    """In place of point and radius: several anchors, of a device with matrices."""
    point: tuple[Length, Length, Length] | None = Field(default=None, validate_default=True)
    """Its anchor (x, y, z), on a floor of the building."""
    radius: PositiveLength | None = Field(default=None, validate_default=True)
    """Radius of the rigid base plate: floor nodes within it are tied to the anchor. Also the radius
    of the circle of anchors, for the net tension."""
    envelope: tuple[ProbePattern, ...] = ()
    """Probes of [transient] for a further response spectrum analysis with the envelope of their
    spectra and those of the anchor: names, or patterns with * and ?."""
    spectra: Annotated[tuple[GivenSpectrum, ...], SPECTRA_FILE] | None = None
    """Floor spectra (CSV) for a further response spectrum analysis: frequency, acceleration,
    direction, damping, and support for several; or products/floor_spectra.csv of a run (its
    broadened spectra are used)."""
    modes: Annotated[tuple[DeviceMode, ...], MODES_FILE] | None = None
    """Table of the modes of the device (CSV), in place of springs and beam."""
    matrices: DeviceMatrices | None = Field(default=None, validate_default=True)
    """Mass and stiffness matrices of the device, in place of springs and beam."""
    mass: Mass | None = Field(default=None, validate_default=True)
    """Mass of the body, with mass_height and either inertia or shape. With modes: mass of the whole
    device; the part without modes follows the anchor. With matrices: their total mass, for
    comparison."""
    mass_height: Length | None = Field(default=None, validate_default=True)
    """Height of the mass centre above the anchor; net tension assumes a device that stands on the
    floor."""
    inertia: tuple[_Moment, _Moment, _Moment] | None = None
    """Moments of inertia of the body about x, y, z through its mass centre."""
    shape: Cylinder | None = Field(default=None, validate_default=True)
    """Shape that gives the moments of inertia, in place of inertia."""
    stiffness: BaseStiffness | None = Field(default=None, validate_default=True)
    """Springs between the base of the device and its anchor."""
    beam: DeviceBeam | None = Field(default=None, validate_default=True)
    """Beam from the base to the body; without it, base and body are one."""
    damping: DampingEntry | None = Field(default=None, validate_default=True)
    """Damping of the device; not needed if each row of modes has a damping."""
    maximum_frequency: Frequency = 1000.0
    """Modes above this frequency follow the anchor rigidly; the first mode must be below."""
    anchors: AnchorBolts | None = None
    """Bolts of the base plate and their capacities."""
    required_spectrum: QualificationSpectrum | None = None
    """Spectrum that the specification requires and that the device is qualified for."""
    test_spectrum: QualificationSpectrum | None = None
    """Spectrum of the motion that the device withstood in a test."""
    zpa_limit: Annotated[tuple[Acceleration, ...], OneOrMore(3)] | None = None
    """Largest zero-period acceleration that the device withstands, one value or three: along x, y
    and z."""

    @property
    def anchor_points(self) -> tuple[DeviceSupport, ...]:
        """Anchors of the device: one or several."""
        if self.point is None or self.radius is None:
            return self.supports
        return (DeviceSupport(point=self.point, radius=self.radius, envelope=self.envelope),)

    @property
    def lowest_frequency(self) -> float | None:
        """Lowest frequency of the body on one of its springs, or on its beam, alone [Hz]."""
        if self.mass is None or self.mass_height is None or self.stiffness is None:
            return None
        m, (x, y, z) = self.mass, self.inertia or (0.0, 0.0, 0.0)
        arm = m * self.mass_height**2
        moved = (m, m, m, x + arm, y + arm, z)
        on_springs = zip((stiff for _, stiff in self.stiffness), moved, strict=True)
        squares = [k / of for k, of in on_springs if isinstance(k, float) and of > 0.0]
        if self.beam is not None:
            squares.append(3.0 * min(self.beam.bending) / self.beam.length**3 / m)
        return math.sqrt(min(squares)) / (2.0 * math.pi) if squares else None

    @rule("supports")
    @staticmethod
    def _apart(supports: tuple[DeviceSupport, ...]) -> Iterator[str]:
        for one, other in itertools.combinations(supports, 2):
            if math.dist(one.point, other.point) < TOUCH:
                x, y, z = other.point
                yield f"expected supports at different points, found two at ({x:g}, {y:g}, {z:g}) m"

    _point = _one_place("point", "anchor (x, y, z)")
    _radius = _one_place("radius", "radius of the anchor")
    _each_once = once("envelope", "name or pattern")

    @rule("envelope", "supports")
    @staticmethod
    def _envelope(envelope: tuple[str, ...], supports: Any) -> Iterator[str]:
        if envelope and supports:
            yield "cannot be combined with `supports`: each may have an envelope"

    @field_validator("spectra")
    @classmethod
    def _of_its_floors(cls, value: Any, info: ValidationInfo) -> Any:
        """Select the spectra of the floors that the device stands on."""
        if not isinstance(value, GivenSpectra):
            return value
        building = info.data.get("building", "")
        valid = reading_of(info).values["buildings"]
        levels = next((one.levels for one in valid if one.name == building), dict[int, float]())
        anchors = [info.data["point"]] if info.data.get("point") else []
        anchors += [one.point for one in info.data.get("supports", ())]
        floors = [min(levels, key=lambda k: abs(levels[k] - z)) for *_, z in anchors if levels]
        lacking = "; ".join(value.lacks(building, floors)) if floors else ""
        if lacking:
            raise refuse(lacking, kind="spectra")
        return value.at(building, floors)

    @field_validator("modes", mode="before")
    @classmethod
    def _modes_of_one_anchor(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None and len(info.data.get("supports", ())) > 1:
            expected = "expected matrices for a device with several supports"
            raise refuse(expected, kind="one_anchor")
        return value

    _one_model = _alone("matrices", "modes")

    @rule("matrices", "modes", "supports", sited=True)
    @staticmethod
    def _of_the_supports(
        matrices: DeviceMatrices | None, modes: Any, supports: Any, info: ValidationInfo
    ) -> Iterator[str]:
        if matrices is None and modes is None and len(supports) > 1:
            yield "missing; expected the matrices of a device with several supports"
        if matrices is not None and info.context is not None:
            lacking = "; ".join(matrices.lacks(len(supports) or 1))
            if lacking:
                yield lacking

    @rule("mass", "matrices")
    @staticmethod
    def _of_the_matrices(mass: float | None, matrices: DeviceMatrices | None) -> Iterator[str]:
        totals = {} if mass is None or matrices is None else matrices.total_masses
        if any(abs(total - mass) > SAME_MASS * mass for total in totals.values() if mass):
            found = ", ".join(f"{1e-3 * total:.4g} t along {c}" for c, total in totals.items())
            yield (
                f"the matrices have {found}; expected the mass of the device within "
                f"{SAME_MASS:.0%}: check the units in the headers of the matrices"
            )

    _something_moves = _or_a_table("mass", "the mass of a body")
    _height_alone = _alone("mass_height", "matrices")
    _inertia_alone = _alone("inertia", "matrices")
    _shape_alone = _alone("shape", "matrices")

    @rule("mass_height", "mass", "matrices")
    @staticmethod
    def _with_mass(height: float | None, mass: float | None, matrices: Any) -> Iterator[str]:
        if matrices is None and (height is None) != (mass is None):
            yield "expected mass and mass_height together"

    _inertia_of_a_mass = rule("inertia", "mass")(_with_a_mass)
    _shape_of_a_mass = rule("shape", "mass")(_with_a_mass)

    @rule("shape", "inertia", "mass", "matrices")
    @staticmethod
    def _one_inertia(
        shape: Cylinder | None, inertia: Any, mass: float | None, matrices: Any
    ) -> Iterator[str]:
        if matrices is None and mass is not None and (inertia is None) == (shape is None):
            both = "" if shape is None else ", not both"
            yield f"`mass` requires either `inertia` or `shape`{both}"

    _springs_beside_modes = _alone("stiffness", "modes")
    _springs_beside_matrices = _alone("stiffness", "matrices")
    _on_springs = _or_a_table("stiffness", "the springs of the base")
    _beam_beside_modes = _alone("beam", "modes")
    _beam_beside_matrices = _alone("beam", "matrices")

    @rule("beam", "stiffness")
    @staticmethod
    def _moves(beam: DeviceBeam | None, springs: BaseStiffness | None) -> Iterator[str]:
        if beam is None and springs is not None and all(k == RIGID for _, k in springs):
            yield "missing; expected a beam, as nothing moves on a base that is rigid all over"

    @rule("anchors", "radius", "supports")
    @staticmethod
    def _on_the_plate(
        anchors: AnchorBolts | None, radius: float | None, supports: Sequence[DeviceSupport]
    ) -> Iterator[str]:
        yield from on_plate(anchors, [one.radius for one in supports] or [radius or 0.0])

    @rule("zpa_limit")
    @staticmethod
    def _three_axes(limit: tuple[float, ...] | None) -> Iterator[str]:
        if limit is not None and len(limit) != 3:
            yield "expected one value, or three: along x, y and z"

    @rule("damping", "modes")
    @staticmethod
    def _of_a_body(damping: Any, modes: tuple[DeviceMode, ...] | None) -> Iterator[str]:
        if damping is None and modes is None:
            yield "missing; expected the damping of the device"
        if damping is None and any(mode.damping is None for mode in modes or ()):
            yield "missing; expected a damping, as the table of modes has no column damping"


Combination = Literal["abs", "srss", "cqc", "dsc", "dsc-abs", "ten-percent", "grouping"]

SupportRule = Literal["srss", "abs", "algebraic", "envelope"]

RigidMethod = Literal["none", "gupta", "lindley-yow"]

ModeRule = tuple[Combination, RigidMethod]
"""Combination of modes: of their periodic parts, and of their rigid parts."""

STEPS = 8
"""Steps of the coupled integration in one of the transient stage, when the case names no step."""


def _of_gupta(frequency: float | None, methods: tuple[str, ...]) -> Iterator[str]:
    if frequency is not None and "gupta" not in methods:
        yield "expected no frequency, only with method 'gupta'"


class RigidPart(Section):
    """The part of a mode's response that follows the anchor rigidly (Regulatory Guide 1.92)."""

    method: Annotated[tuple[RigidMethod, ...], Field(min_length=1), OneOrMore()]
    """'gupta': by two frequencies; 'lindley-yow': by the zero-period acceleration; 'none': all
    periodic. A list gives one result for each; the first is the main result. Further methods are
    omitted if a spectrum does not determine them."""
    f1: Frequency | None = None
    """'gupta': below it, no rigid part; default by the spectrum."""
    f2: Frequency | None = Field(default=None, validate_default=True)
    """'gupta': above it, fully rigid; default by the spectrum."""

    _each_once = once("method", "method")
    _f1_of_gupta = rule("f1", "method")(_of_gupta)
    _f2_of_gupta = rule("f2", "method")(_of_gupta)

    @rule("f2", "f1")
    @staticmethod
    def _above_f1(f2: float | None, f1: float | None) -> Iterator[str]:
        if f2 is not None and f1 is not None and f2 <= f1:
            yield f"expected a frequency above f1, {f1:g} Hz"


class DeviceAnalysis(Section):
    """The response spectrum analysis of all devices, and how the detailed one is done."""

    combination: tuple[Combination, ...] = Field(default=("srss", "cqc"), min_length=1)
    """Combinations of the modes, one result for each: absolute sum, SRSS, CQC, double sum with
    signs ('dsc') and without, 10 %, grouping."""
    duration: Duration | None = Field(default=None, validate_default=True)
    """Duration of the strong motion, for 'dsc' and 'dsc-abs'."""
    rigid: RigidPart | None = None
    """Rigid part of the modes; left out, all is periodic."""
    missing_mass: StrictBool = True
    """Add the missing mass of the modes up to maximum_frequency, with the zero-period
    acceleration."""
    directions: Literal["srss", "100-40-40"] = "srss"
    """Combination of the directions."""
    supports: tuple[SupportRule, ...] = Field(default=("srss", "abs", "envelope"), min_length=1)
    """Combination of the responses to several supports, one result for each. 'srss' and 'abs':
    independent supports; 'algebraic': in phase; 'envelope': in phase, by the envelope of their
    spectra."""
    displacements: Literal["srss", "abs"] = "abs"
    """Combination of the forces due to relative displacements of the supports, and with the
    inertial forces."""
    envelope_dampings: StrictBool = False
    """Repeat the analysis with the envelope of the spectra over all [[damping_cases]], including
    the points of envelope."""
    rotations: StrictBool = True
    """Repeat the analysis with the spectra of the anchor's rotations as additional input."""
    broadening: DampingRatio = 0.15
    """Relative broadening of the spectra to either side, for an additional result; 0 for none."""
    time_step: TimeStep | None = None
    """Time step of the 3D model with the devices; default an eighth of that of [transient]."""

    _combinations_once = once("combination", "combination")
    _rules_once = once("supports", "combination")

    @rule("duration", "combination")
    @staticmethod
    def _for_the_double_sum(duration: float | None, combination: tuple[str, ...]) -> Iterator[str]:
        if duration is None and {"dsc", "dsc-abs"} & set(combination):
            yield "missing; expected the duration of the strong motion for the double sum"
