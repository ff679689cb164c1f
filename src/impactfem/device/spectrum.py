"""The response spectrum of one component of an anchor: what a device sees there.

Ordinates between the listed frequencies and dampings are those of
:mod:`impactfem.spectra.frequency_list`: log S linear in log f, and in ξ. Above the last frequency a
spectrum that has come down to its zero-period acceleration stays there; everywhere else outside the
list nothing is known, and nothing is made up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from impactfem.case.device_tables import GivenSpectrum
from impactfem.device.device import Device
from impactfem.device.modes import DeviceModes
from impactfem.spectra import (
    Method,
    at_common_frequencies,
    broaden,
    corner_frequencies,
    interpolate_damping,
    interpolate_frequency,
    response_spectra,
    rigid_frequency,
)
from impactfem.spectra.design import ZPA_TOLERANCE, Ratio
from impactfem.sticks.element import COMPONENTS
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

MOVED = 1e-9
"""A component moves a mode whose participation is above this part of its largest one."""


class NotRigidError(ImpactfemError):
    """A spectrum does not say from which frequency on modes are rigid."""


@dataclass(frozen=True, eq=False)
class AnchorSpectrum:
    """Pseudo-acceleration spectra of one component of the motion of an anchor.

    Raises:
        ImpactfemError: The spectra or their labels are not usable.
    """

    component: str  #: "x" to "rz"
    frequency: Array  #: ascending, shape (n_f,) [Hz]
    damping: Array  #: damping ratios, ascending, shape (n_d,) [-]
    psa: Array  #: pseudo-acceleration, shape (n_d, n_f) [m/s2, rad/s2]
    zpa: float  #: zero-period acceleration: the largest acceleration of the anchor [m/s2, rad/s2]
    anchor: int = 1  #: number of the anchor, from 1
    displacement: float = 0.0  #: largest displacement of the anchor against the other ones [m, rad]

    def __post_init__(self) -> None:
        if self.component not in COMPONENTS or self.anchor < 1:
            raise ImpactfemError(
                f"a spectrum of component {self.component!r} of anchor {self.anchor}: expected one"
                f" of {', '.join(COMPONENTS)} of anchors from 1"
            )
        if not (self.zpa >= 0.0 and self.displacement >= 0.0):
            raise ImpactfemError(
                f"{self.label}: zero-period acceleration {self.zpa!r} and displacement"
                f" {self.displacement!r} must not be negative"
            )
        # The two interpolations check frequencies, dampings and ordinates.
        interpolate_damping(self.damping, self.psa, float(np.atleast_1d(self.damping)[0]))
        interpolate_frequency(self.frequency, self.psa, self.frequency[:1])

    @property
    def label(self) -> str:
        """The spectrum in words."""
        return f"spectrum along {self.component} at anchor {self.anchor}"

    @classmethod
    def of_motion(
        cls,
        component: str,
        acceleration: npt.ArrayLike,
        time_step: float,
        frequency: npt.ArrayLike,
        damping: npt.ArrayLike,
        *,
        anchor: int = 1,
        points_per_cycle: float = 20.0,
        method: Method = "upsampled",
    ) -> AnchorSpectrum:
        """Compute the spectra of a motion, shape (n_t,) [m/s2, rad/s2].

        Frequencies [Hz] and dampings may have any order; with those of the modes among them,
        nothing is lost between them. Points per cycle and method are those of
        :func:`impactfem.spectra.response_spectra`; "in-step" is for motions that are straight
        between their samples.

        Raises:
            ImpactfemError: The motion, a frequency or a damping is not usable.
        """
        computed = response_spectra(
            acceleration,
            time_step,
            np.unique(np.asarray(frequency, dtype=np.float64)),
            np.unique(np.asarray(damping, dtype=np.float64)),
            points_per_cycle=points_per_cycle,
            method=method,
            absolute=False,
        )
        return cls(
            component=component,
            frequency=computed.frequency,
            damping=computed.damping,
            psa=computed.psa[:, 0],
            zpa=float(computed.zpa_interpolated[0]),
            anchor=anchor,
        )

    @classmethod
    def envelope(cls, spectra: Sequence[AnchorSpectrum]) -> AnchorSpectrum:
        """Envelope of spectra of the same component and anchor at the same dampings.

        Raises:
            ImpactfemError: There is none, or components, anchors or dampings differ.
        """
        if not spectra:
            raise ImpactfemError("an envelope needs at least one spectrum")
        first = spectra[0]
        for other in spectra:
            if (other.component, other.anchor) != (first.component, first.anchor) or not (
                np.array_equal(other.damping, first.damping)
            ):
                raise ImpactfemError(
                    f"no envelope of the {first.label} and the {other.label}: components, anchors"
                    " and dampings must be the same"
                )
        frequency, psa = at_common_frequencies([(s.frequency, s.psa) for s in spectra])
        return replace(
            first,
            frequency=frequency,
            psa=psa.max(axis=0),
            zpa=max(s.zpa for s in spectra),
            displacement=max(s.displacement for s in spectra),
        )

    def broadened(self, ratio: Ratio = 0.15) -> AnchorSpectrum:
        """The spectra with their peaks broadened, as by :func:`impactfem.spectra.broaden`.

        Raises:
            ImpactfemError: The ratio is out of range.
        """
        curves: list[tuple[npt.ArrayLike, npt.ArrayLike]] = [(self.frequency, s) for s in self.psa]
        listed = corner_frequencies(self.frequency, curves, ratio)
        psa = np.stack([broaden(self.frequency, s, ratio, listed) for s in self.psa])
        return replace(self, frequency=listed, psa=psa)

    def at(self, frequency: Array, damping: Array) -> tuple[Array, tuple[str, ...]]:
        """Pseudo-acceleration [m/s2, rad/s2] of oscillators by frequency [Hz] and damping [-].

        Of shape (m,) each; and what was assumed, in words.

        Raises:
            ImpactfemError: A frequency lies below the spectrum, or above it where it has not come
                down to its zero-period acceleration; or a damping is outside its dampings.
        """
        f = np.asarray(frequency, dtype=np.float64)
        if not f.size:
            return np.zeros(0), ()
        beyond = f > self.frequency[-1] * (1.0 + 1e-9)
        if np.any(f < self.frequency[0] * (1.0 - 1e-9)):
            raise ImpactfemError(
                f"the {self.label} begins at {self.frequency[0]:g} Hz and does not reach the mode"
                f" at {np.min(f):.4g} Hz; expected a spectrum that begins below it"
            )
        notes: tuple[str, ...] = ()
        if np.any(beyond):
            last = self.psa[:, -1]
            if np.any(np.abs(last - self.zpa) > ZPA_TOLERANCE * self.zpa):
                off = last[np.argmax(np.abs(last - self.zpa))]
                raise ImpactfemError(
                    f"the {self.label} ends at {self.frequency[-1]:g} Hz with {off:.4g},"
                    f" which is not its zero-period acceleration {self.zpa:.4g}, and does not reach"
                    f" the mode at {np.max(f):.4g} Hz; expected a spectrum that goes further, or a"
                    " maximum frequency of the modes"
                )
            notes = (
                f"the {self.label} ends at {self.frequency[-1]:g} Hz at its zero-period"
                f" acceleration, which the modes above it get: "
                + ", ".join(f"{one:.4g} Hz" for one in f[beyond]),
            )
        within = np.minimum(f, self.frequency[-1])
        family = interpolate_frequency(self.frequency, self.psa, within)
        try:
            ordinates = interpolate_damping(self.damping, family, damping)
        except ImpactfemError as error:
            raise ImpactfemError(
                f"the {self.label}: {error}; expected dampings on both sides of the modes'"
            ) from error
        return np.where(beyond, np.maximum(self.zpa, ordinates), ordinates), notes

    def curve(self, damping: float) -> Array:
        """Ordinates at the listed frequencies for one damping, shape (n_f,)."""
        return interpolate_damping(self.damping, self.psa, damping)

    def rigid_from(self, damping: float) -> float:
        """Frequency from which on the spectrum stays at its zero-period acceleration [Hz].

        Raises NotRigidError where it ends before.
        """
        found = float(rigid_frequency(self.frequency, self.curve(damping), self.zpa))
        if np.isnan(found):
            raise NotRigidError(
                f"the {self.label} ends at {self.frequency[-1]:g} Hz, before it comes down to its"
                f" zero-period acceleration {self.zpa:.4g}; expected one that goes further, or the"
                " frequency from which on modes are rigid"
            )
        return found


LAST = "a given spectrum's last ordinate is taken for its zero-period acceleration"
NO_SHIFT = "given spectra say nothing of displacements of the supports against each other"


END = 0.8
"""From this part of its last frequency on a spectrum must be flat that says what lies above it."""


def refuse_open_ends(device: Device, modes: DeviceModes, spectra: Sequence[AnchorSpectrum]) -> None:
    """Refuse given spectra that end before they are flat, below a used mode that they move.

    Nothing but its end says whether such a spectrum has come down to its zero-period acceleration.
    """
    for one in spectra:
        moved = np.abs(modes.participation[device.column(one.component, one.anchor)])
        moved = moved > MOVED * np.max(moved, initial=0.0)
        beyond = modes.frequency[moved & (modes.frequency > one.frequency[-1] * (1.0 + 1e-9))]
        start = max(END * one.frequency[-1], one.frequency[0])
        before = interpolate_frequency(one.frequency, one.psa, [start])[:, 0]
        last = one.psa[:, -1]
        if beyond.size and np.any(np.abs(before - last) > ZPA_TOLERANCE * last):
            raise device.error(
                f"the {one.label} ends at {one.frequency[-1]:g} Hz, where it is not flat yet, and"
                f" does not reach the mode at {beyond.min():.4g} Hz; expected a spectrum that goes"
                " further, or a maximum frequency of the modes"
            )


def given_spectra(given: Sequence[GivenSpectrum]) -> tuple[AnchorSpectrum, ...]:
    """Put the dampings of each support and direction together.

    The zero-period acceleration is the largest of the ordinates at the last common frequency.

    Raises:
        ImpactfemError: The dampings of a direction share no range of frequencies.
    """
    families: dict[tuple[int, str], list[GivenSpectrum]] = {}
    for one in given:
        families.setdefault((one.support, one.direction), []).append(one)
    found = []
    for (support, direction), family in families.items():
        family = sorted(family, key=lambda one: one.damping)
        frequency, psa = at_common_frequencies([(s.frequency, s.acceleration) for s in family])
        found.append(
            AnchorSpectrum(
                component=direction,
                frequency=frequency,
                damping=np.array([one.damping for one in family]),
                psa=psa,
                zpa=float(psa[:, -1].max()),
                anchor=support,
            )
        )
    return tuple(found)
