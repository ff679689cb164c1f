"""Response spectrum analysis of a device.

A mode with the participation Γ_k along the component k of an anchor, whose spectrum gives the
pseudo-acceleration S(ω, ξ), brings to a quantity Q = c x + d ä + e a at most

    R_i = -c φ_i Γ_ik S(ω_i, ξ_i) / ω_i²                                                   (1)

What the modes in use do not carry follows the anchors rigidly, exactly so for a slow motion, with
the zero-period acceleration ZPA (missing mass, static correction):

    R_m = (d_k - c K⁻¹ L_k + Σ_i c φ_i Γ_ik / ω_i²) ZPA                                    (2)

With the rigid parts α_i of the modes (:mod:`impactfem.device.combination`), for one component,

    R_r = Σ α_i R_i + R_m,    R_p = combination of √(1 - α_i²) R_i,    R = √(R_p² + R_r²)   (3)

(US NRC Regulatory Guide 1.92, revision 2). The same component of several anchors is combined first
(with its sign, before (3), when they move together), then rotations with the translation they come
with, then directions. Displacements Δ of the anchors against each other, e Δ, are combined on their
own and then with the rest, by the root of the squares or as absolute values.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from impactfem.device.anchor_force import Quantities, anchor_forces
from impactfem.device.combination import PLANES, InputRule, Rules, combine_inputs, combine_modes
from impactfem.device.device import Device
from impactfem.device.modes import DeviceModes, device_modes
from impactfem.device.spectrum import MOVED, AnchorSpectrum, NotRigidError
from impactfem.sticks.element import COMPONENTS
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError


@dataclass(frozen=True, eq=False)
class InputResponse:
    """Response to one component of one anchor."""

    spectrum: AnchorSpectrum
    #: Pseudo-acceleration S of each mode, shape (m,) [m/s2, rad/s2]; 0 for a mode that the
    #: component does not move.
    ordinate: Array
    rigid_fraction: Array  #: α, shape (m,) [-]
    modal: Array  #: R_i with its sign, shape (n_q, m)
    missing: Array  #: R_m, shape (n_q,)
    periodic: Array  #: R_p, shape (n_q,)
    rigid: Array  #: R_r, shape (n_q,)
    total: Array  #: R, shape (n_q,)


@dataclass(frozen=True, eq=False)
class SpectrumResponse:
    """Largest responses of a device."""

    device: str
    modes: DeviceModes
    quantities: Quantities  #: what was computed, n_q quantities
    inputs: tuple[InputResponse, ...]  #: the part of each input
    columns: tuple[int, ...]  #: which component of the anchors each input is
    by_component: dict[str, Array]  #: R of each component over all anchors, shape (n_q,)
    inertial: Array  #: all components combined, shape (n_q,)
    displacement: Array  #: of the displacements of the anchors against each other, shape (n_q,)
    notes: tuple[str, ...]  #: what was assumed, in words
    whole: InputRule = "srss"  #: combination of the last two parts: "srss" or "abs"

    @property
    def total(self) -> Array:
        """Inertial part and displacements of the anchors, √(R² + R_Δ²) or R + R_Δ, shape (n_q,)."""
        return combine_inputs(np.stack([self.inertial, self.displacement]), self.whole)

    def value(self, name: str) -> float:
        """The total of one quantity.

        Raises:
            ImpactfemError: There is no such quantity.
        """
        if name not in self.quantities.names:
            raise ImpactfemError(
                f"device {self.device}: no quantity {name!r} was computed; there are"
                f" {', '.join(self.quantities.names)}"
            )
        return float(self.total[self.quantities.names.index(name)])


AXES = COMPONENTS[:3]
MINOR = 1e-3
"""A component whose ZPA is below this part of the largest has little to say of rigid modes."""


def spectrum_analysis(
    device: Device,
    spectra: Sequence[AnchorSpectrum],
    rules: Rules | None = None,
    quantities: Quantities | None = None,
) -> SpectrumResponse:
    """Compute the largest responses of a device from the spectra of its anchors.

    There is one spectrum for each component of an anchor that moves, translations and rotations.
    Rules are the defaults of :class:`Rules` when None, quantities the forces on the anchors. The
    responses come with the part of each input and each mode.

    Raises:
        ImpactfemError: There is no spectrum, or two of one component; a spectrum does not reach a
            mode; a mode is damped by 100 % or more; a rule is unknown or lacks a value.
    """
    rules = Rules() if rules is None else rules
    wanted = anchor_forces(device) if quantities is None else quantities
    columns = [device.column(s.component, s.anchor) for s in spectra]
    if not spectra or len(set(columns)) < len(columns):
        raise device.error(
            "expected at least one spectrum, and one for a component of an anchor; got"
            f" {', '.join(s.label for s in spectra) or 'none'}"
        )
    every = device_modes(device)
    modes = every.below(rules.maximum_frequency)
    modes.refuse_overdamped(device)
    static = wanted.static(device)
    inputs, notes = [], list[str]()
    left_out = every.frequency.size - modes.frequency.size
    if left_out and not rules.missing_mass:
        notes.append(f"{left_out} modes above the maximum frequency left out, without missing mass")
    for spectrum, k in zip(spectra, columns, strict=True):
        largest = max(
            s.zpa for s in spectra if (s.component in AXES) == (spectrum.component in AXES)
        )
        minor = spectrum.zpa < MINOR * largest
        S, α, assumed = _ordinates(spectrum, modes, k, rules, minor=minor)
        notes += assumed
        unit = -(wanted.own @ modes.shape) * modes.participation[k] / modes.omega**2
        missing = (static[:, k] - unit.sum(axis=1)) * spectrum.zpa
        modal, missing = unit * S, missing * rules.missing_mass
        # Equation (3).
        periodic = _periodic(np.sqrt(1.0 - α**2) * modal, modes, rules)
        rigid = modal @ α + missing
        total = np.hypot(periodic, rigid)
        inputs.append(InputResponse(spectrum, S, α, modal, missing, periodic, rigid, total))
    components = tuple(dict.fromkeys(s.component for s in spectra))
    by_component = {}
    for name in components:
        own = [one for one in inputs if one.spectrum.component == name]
        if rules.supports == "algebraic":
            parts = [np.sqrt(1.0 - one.rigid_fraction**2) * one.modal for one in own]
            periodic = _periodic(np.sum(parts, axis=0), modes, rules)
            by_component[name] = np.hypot(periodic, np.sum([one.rigid for one in own], axis=0))
        else:
            by_component[name] = combine_inputs(np.stack([o.total for o in own]), rules.supports)
    planes = [
        combine_inputs(np.stack(found), rules.rotations)
        for plane in PLANES
        if (found := [by_component[name] for name in plane if name in by_component])
    ]
    shifts = [
        wanted.displacement[:, k] * s.displacement for s, k in zip(spectra, columns, strict=True)
    ]
    return SpectrumResponse(
        device=device.name,
        modes=modes,
        quantities=wanted,
        inputs=tuple(inputs),
        columns=tuple(columns),
        by_component=by_component,
        inertial=combine_inputs(np.stack(planes), rules.directions),
        displacement=combine_inputs(np.stack(shifts), rules.displacements),
        notes=tuple(notes),
        whole=rules.whole,
    )


def _ordinates(
    spectrum: AnchorSpectrum, modes: DeviceModes, k: int, rules: Rules, *, minor: bool
) -> tuple[Array, Array, tuple[str, ...]]:
    """S and α of each mode, and what was assumed of the spectrum."""
    # Of a mode that the component does not move, the spectrum need not know anything.
    size = np.abs(modes.participation[k])
    moved = size > MOVED * np.max(size, initial=0.0)
    driven = modes.only(moved)
    S, α = np.zeros((2, moved.size))
    S[moved], assumed = spectrum.at(driven.frequency, driven.damping)
    if rules.rigid is not None:
        try:
            α[moved] = rules.rigid.fraction(spectrum, driven.frequency, driven.damping, S[moved])
        except NotRigidError:
            if not minor:
                raise
            assumed += (
                f"the {spectrum.label}, below {MINOR:g} of the largest, ends before it is rigid:"
                " its modes are taken as periodic",
            )
    return S, α, assumed


def _periodic(modal: Array, modes: DeviceModes, rules: Rules) -> Array:
    return combine_modes(modal, modes.frequency, modes.damping, rules.modes, rules.duration)
