"""From the devices of a case file to their matrices, and to the rules of their analysis."""

import math
from collections.abc import Iterable

import numpy as np

from impactfem.case import Building3D, DeviceAnalysis, DeviceSetup
from impactfem.case.devices import RIGID, ModeRule, Rigid, RigidMethod
from impactfem.device.combination import Gupta, LindleyYow, RigidResponse, Rules
from impactfem.device.device import Device
from impactfem.device.models import TableMode, from_matrices, from_modes, on_springs
from impactfem.device.modes import device_modes
from impactfem.device.parts import BaseSprings, Beam, RigidBody, solid_cylinder
from impactfem.device.spectrum import NotRigidError, given_spectra, refuse_open_ends
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.sticks.element import COMPONENTS
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.log import LOGGER


def device_of(setup: DeviceSetup) -> Device:
    """The device that a case file describes; refuses a free motion, or an indefinite mass.

    Raises ValueError where it has no modes, no matrices and no body on springs: it was made without
    validation.
    """
    damping = 0.0 if setup.damping is None else setup.damping.law
    body = None
    if setup.mass is not None and setup.mass_height is not None:
        inertia = setup.inertia
        if setup.shape is not None:
            inertia = solid_cylinder(setup.mass, setup.shape.radius, setup.shape.length)
        body = RigidBody.at_height(setup.mass, setup.mass_height, *(inertia or ()))
    if setup.modes is not None:
        rows = [
            TableMode(
                frequency=row.frequency,
                direction=row.direction,
                effective_mass=row.effective_mass + row.effective_inertia,  # one of them is zero
                height=row.height,
                damping=row.damping,
            )
            for row in setup.modes
        ]
        return from_modes(setup.name, rows, damping, body)
    if setup.matrices is not None:
        return from_matrices(
            setup.name,
            np.array(setup.matrices.mass.rows),
            np.array(setup.matrices.stiffness.rows),
            setup.matrices.anchored,
            damping,
            anchors=len(setup.anchor_points),
            motions=setup.matrices.own,
        )
    if body is None or setup.stiffness is None:
        raise ValueError(f"device {setup.name} has no body, or no springs")
    stiffness = {name: _number(getattr(setup.stiffness, name)) for name in COMPONENTS}
    beam = None
    if (given := setup.beam) is not None:
        beam = Beam(
            length=given.length,
            bending_x=given.bending[0],
            bending_y=given.bending[1],
            shear_x=_number(given.shear[0]),
            shear_y=_number(given.shear[1]),
            stretching=_number(given.stretching),
            twisting=_number(given.twisting),
            mass=given.mass,
            elements=given.elements,
        )
    springs = BaseSprings.of_directions(**stiffness)
    return on_springs(setup.name, springs, body, damping, beam)


def rules_of(analysis: DeviceAnalysis, maximum_frequency: float) -> dict[ModeRule, Rules]:
    """The rules of the analysis, by the combination of modes and the method of their rigid part.

    Modes above the maximum frequency [Hz] are not in use.
    """
    part = analysis.rigid
    methods: tuple[RigidMethod, ...] = ("none",) if part is None else part.method
    rigid: dict[RigidMethod, RigidResponse | None] = {"none": None, "lindley-yow": LindleyYow()}
    if part is not None and "gupta" in methods:
        rigid["gupta"] = Gupta(part.f1, part.f2)
    return {
        (combination, method): Rules(
            modes=combination,
            duration=analysis.duration,
            rigid=rigid[method],
            missing_mass=analysis.missing_mass,
            maximum_frequency=maximum_frequency,
            directions=analysis.directions,
            displacements=analysis.displacements,
            whole=analysis.displacements,
        )
        for combination in analysis.combination
        for method in methods
    }


def first_method(rules: Iterable[ModeRule]) -> RigidMethod:
    """The method for the rigid part of the modes that is reported where only one is."""
    return next(iter(rules))[1]


def checked_devices(building: Building3D) -> list[Device]:
    """Build the devices of a building and see that their modes can be used as the case asks.

    Raises:
        InputError: With the faults of all of them.
    """
    faults: list[Fault] = []
    devices = []
    analysis, path = building.device_analysis, building.case.path
    for index, setup in building.numbered_devices:
        key = f"devices[{index}]"
        try:
            device = device_of(setup)
            device.refuse_held_ground()
            every = device_modes(device)
            used = every.below(setup.maximum_frequency)
            if not used.frequency.size:
                lowest = f"{every.frequency[0]:.4g} Hz"
                expected = f"expected one above the first mode of the device, {lowest}"
                highest = f"{setup.maximum_frequency:g} Hz"
                faults.append(Fault(path, f"{key}.maximum_frequency", highest, expected))
                continue
            used.refuse_overdamped(device)
            left_out = every.frequency.size - used.frequency.size
            if analysis is not None and left_out and not analysis.missing_mass:
                LOGGER.warning(
                    "warning: device %s: %d of its modes are above maximum_frequency, %g Hz, and "
                    "without missing_mass in no response spectrum analysis: %.0f, %.0f and %.0f %% "
                    "of its mass along x, y and z",
                    setup.name,
                    left_out,
                    setup.maximum_frequency,
                    *(100.0 * (1.0 - used.share[:3].sum(axis=1))),
                )
            damped = bool((used.damping > 0.0).all())
            if analysis is not None and "cqc" in analysis.combination and not damped:
                expected = "expected another combination than 'cqc'"
                raise device.error(f"a mode without damping; {expected}")
        except ImpactfemError as error:
            faults.append(Fault(path, key, setup.name, str(error)))
            continue
        devices.append(device)
        if setup.spectra is None or analysis is None:
            continue
        rules = rules_of(analysis, setup.maximum_frequency)
        try:
            given = given_spectra(setup.spectra)
            refuse_open_ends(device, used, given)
            for (_, method), one in rules.items():
                try:
                    spectrum_analysis(device, given, one)
                except NotRigidError:
                    # A further method is left out where the spectra say too little for it.
                    if method == first_method(rules):
                        raise
        except ImpactfemError as error:
            faults.append(Fault(path, f"{key}.spectra", None, str(error)))
    if faults:
        raise InputError(faults)
    return devices


def _number(stiffness: float | Rigid) -> float:
    return math.inf if stiffness == RIGID else float(stiffness)
