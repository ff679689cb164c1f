"""What figures, tables and checks ask of `device.nc`: forces, analyses and damping cases."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.stages.stores import CasesView

Array = NDArray[np.float64]

XYZ = "xyz"
WITHOUT, WITH = 0, 1
"""Positions in the dimension `impact`."""
NAMES = ("no_impact", "impact")
"""The same in the names of scalars."""
ROTATIONS, BROADENED = "rotations", "broadened"
"""What the names of response spectrum analyses say behind the combination of the modes."""
GUPTA, LINDLEY_YOW = "gupta", "lindley-yow"
RIGID = {GUPTA: "Gupta", LINDLEY_YOW: "Lindley-Yow"}
"""The same of the rigid part of the modes, and whose method it is."""
STIFF = 0.1
"""A mode follows the floor whose pseudo-acceleration is within this part of the ZPA."""


@dataclass(frozen=True)
class Pull:
    """How a device pulls at its anchor in the detailed analysis, its weight included.

    Args:
        weight: Its weight at this anchor [N].
        radius: Of the circle that the anchors stand on [m].
        uplift: Largest force upward less the weight [N].
        tension: n times the pull of the most loaded of n anchors, evenly on it [N].
    """

    weight: float
    radius: float
    uplift: float
    tension: float


@dataclass(frozen=True, eq=False)
class Drawing:
    """A device on springs, seen across a horizontal direction; nan for what it has not.

    Args:
        axis: The direction, "x" or "y".
        spring: Stiffness of the base along it [N/m]; infinite for a rigid one.
        turning: Stiffness of the base about the other axis [N m/rad].
        mass: Of the body [kg].
        inertia: Of the body about the other axis through its mass centre [kg m2].
        height: Of its mass centre above the anchor [m].
        radius: Of a body that is a cylinder [m].
        length: The same.
        beam_length: [m].
        beam_bending: E I for bending along the direction [N m2].
        beam_mass: [kg].
        levels: Heights of the points of the shapes, the mass centre last, shape (n,) [m].
        shift: Displacement of each mode along the direction, shape (n_modes, n) [1/√kg].
        slope: Its derivative along the height by the rotation, shape (n_modes, n) [1/(m √kg)].
    """

    axis: str
    spring: float
    turning: float
    mass: float
    inertia: float
    height: float
    radius: float
    length: float
    beam_length: float
    beam_bending: float
    beam_mass: float
    levels: Array
    shift: Array
    slope: Array


class DeviceView(CasesView):
    """A store of the stage `device`, read along the direction that is shown.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        super().__init__(store)
        self.direction = str(store.attrs["shown_direction"])
        self.column = XYZ.index(self.direction)
        self.headline = str(store.attrs["headline"])
        self.devices = [str(name) for name in store["device"].values]
        self.choices = [str(name) for name in store["choice"].values]

    @cached_property
    def impact_force(self) -> Array:
        """Largest impact force of each damping case, shape (n_cases,) [N]."""
        return self._values("impact_force")

    def start(self, device: int) -> str:
        """How the names of a device's scalars begin; published values have the same names."""
        return "device" if device == 0 else f"device.{self.devices[device]}"

    def name(self, device: int, quantity: str, impact: int, case: int) -> str:
        """Name of a scalar of a device under one load with one damping.

        Args:
            device: Its number, from 0.
            quantity: Such as "fy.detailed".
            impact: `WITHOUT` or `WITH`.
            case: Number of the damping case, from 0.
        """
        end = f".{self.cases[case]}" if case else ""
        return f"{self.start(device)}.{quantity}.{NAMES[impact]}{end}"

    def force(self, device: int, impact: int, case: int = 0) -> Array:
        """Force of the device on the floor along the shown direction, shape (n_t,) [N]."""
        found = self.store["force"][case, impact, device, self.column].values
        return np.asarray(found, dtype=np.float64)

    def detailed(self, device: int, impact: int, case: int = 0) -> float:
        """Its largest value [N]."""
        return float(self.store["largest_force"].values[case, impact, device, self.column])

    def by_spectrum(
        self, device: int, impact: int, case: int = 0, choice: str | None = None
    ) -> float:
        """The same by response spectrum analysis [N].

        Args:
            device: Number of the device.
            impact: `WITHOUT` or `WITH`.
            case: Number of the damping case.
            choice: Which analysis; the headline when None.
        """
        which = self.choices.index(choice or self.headline)
        return float(self.store["spectrum_force"].values[case, impact, device, which, self.column])

    def components(
        self, device: int, impact: int, case: int = 0, choice: str | None = None
    ) -> Array:
        """Largest forces and moments, shape (6,) [N, N m]; of a named analysis or the detailed one.

        Args:
            device: Number of the device.
            impact: `WITHOUT` or `WITH`.
            case: Number of the damping case.
            choice: Which response spectrum analysis; the detailed analysis when None.
        """
        if choice is None:
            found = self.store["largest_force"].values[case, impact, device]
        else:
            which = self.choices.index(choice)
            found = self.store["spectrum_force"].values[case, impact, device, which]
        return np.asarray(found, dtype=np.float64)

    def done(self, device: int, impact: int, case: int, choice: str) -> bool:
        """Whether an analysis was done of a device: not all have envelopes or given spectra."""
        return math.isfinite(self.by_spectrum(device, impact, case, choice))

    def difference(
        self, device: int, impact: int, case: int = 0, choice: str | None = None
    ) -> float | None:
        """(detailed - by spectrum) / detailed, positive where the latter is too low [-].

        None where nothing moves the device.
        """
        detailed = self.detailed(device, impact, case)
        if not detailed > 0.0:
            return None
        return 1.0 - self.by_spectrum(device, impact, case, choice) / detailed

    def variant(self, *words: str) -> str | None:
        """Name of the headline analysis with rotations, broadened spectra or both; None if none."""
        name = ".".join([self.headline, *words])
        return name if name in self.choices else None

    def rigid_variants(self) -> dict[str, str]:
        """Analyses that differ from the headline by the rigid part of the modes: method and name.

        Of these as well where the headline has one itself: "none" without any.
        """
        combination, _, own = self.headline.partition(".")
        names = {"none": combination} | {method: f"{combination}.{method}" for method in RIGID}
        return {
            method: name
            for method, name in names.items()
            if name in self.choices and method != (own or "none")
        }

    def pull(self, device: int, impact: int, case: int = 0) -> Pull | None:
        """How a device pulls at its anchor; None where its weight is not known, or nothing says."""
        if "net_tension" not in self.store:
            return None
        tension = float(self.store["net_tension"].values[case, impact, device])
        if not math.isfinite(tension):
            return None
        return Pull(
            weight=-float(self.store["weight_force"].values[device, 2]),
            radius=float(self.store["anchor_radius"].values[device]),
            uplift=float(self.store["net_uplift"].values[case, impact, device]),
            tension=tension,
        )

    def tension_by_spectrum(
        self, device: int, impact: int, case: int = 0, choice: str | None = None
    ) -> float | None:
        """Net tension by a response spectrum analysis, its largest values at one instant [N]."""
        if self.pull(device, impact, case) is None:
            return None
        which = self.choices.index(choice or self.headline)
        return float(self.store["spectrum_tension"].values[case, impact, device, which])

    def spectrum(self, device: int, impact: int, case: int = 0) -> Array:
        """Pseudo-acceleration of the anchor by the device's first damping, shape (n_f,) [m/s2]."""
        found = self.store["psa"][case, impact, device, self.column].values
        return np.asarray(found, dtype=np.float64)

    def modes(self, device: int) -> int:
        """Number of modes of a device."""
        return int(np.isfinite(self.store["mode_frequency"].values[device]).sum())

    def mode_frequency(self, device: int) -> Array:
        """Frequencies of its modes, shape (n_modes,) [Hz]."""
        return self._values("mode_frequency")[device, : self.modes(device)]

    def mode_damping(self, device: int) -> Array:
        """Damping ratios of its modes, shape (n_modes,) [-]."""
        return self._values("mode_damping")[device, : self.modes(device)]

    def effective_mass(self, device: int) -> Array:
        """Effective masses and inertias, shape (6, n_modes) [kg, kg m2]."""
        return self._values("effective_mass")[device, :, : self.modes(device)]

    def modal_mass(self, device: int) -> float:
        """Sum of the effective masses along the shown direction [kg]."""
        return float(self.effective_mass(device)[self.column].sum())

    def shown_modes(self, device: int) -> list[int]:
        """Numbers from 0 of the modes that carry mass along the shown direction."""
        mass = self.effective_mass(device)[self.column]
        return [int(k) for k in np.flatnonzero(mass > 1e-6 * self.modal_mass(device))]

    def ordinates(self, device: int, impact: int, case: int = 0) -> Array | None:
        """Pseudo-accelerations of the anchor at the device's modes, shape (6, n_modes).

        By component of the anchor, at the modes' dampings [m/s2, rad/s2]; nan where a component is
        no input. None in a store without them.
        """
        if "mode_psa" not in self.store:
            return None
        return self._values("mode_psa")[case, impact, device, :, : self.modes(device)]

    def followed(self, device: int, impact: int, case: int = 0) -> list[tuple[float, float]] | None:
        """Frequency of each shown mode, and its pseudo-acceleration over the ZPA of the floor.

        Args:
            device: Number of the device.
            impact: `WITHOUT` or `WITH`.
            case: Number of the damping case.

        Returns:
            Pairs [Hz, -]; None where the store does not say, or nothing moves the anchor.
        """
        S = self.ordinates(device, impact, case)
        if S is None or "anchor_acceleration" not in self.store:
            return None
        motion = self.store["anchor_acceleration"][case, impact, device, self.column].values
        zpa = float(np.abs(motion).max())
        if not zpa > 0.0:
            return None
        frequency = self.mode_frequency(device)
        return [
            (float(frequency[k]), float(S[self.column, k]) / zpa) for k in self.shown_modes(device)
        ]

    def stiff(self, device: int, impact: int, case: int = 0) -> bool:
        """Whether all shown modes follow the floor: above its peak, and at its ZPA."""
        found = self.followed(device, impact, case)
        if found is None:
            return False
        peak = float(self.frequency[int(np.argmax(self.spectrum(device, impact, case)))])
        return all(f > peak and abs(ratio - 1.0) <= STIFF for f, ratio in found)

    def with_signs(self, device: int, impact: int, case: int = 0) -> float | None:
        """Sum with their signs of the forces of all modes along the shown direction [N].

        By the spectrum along it alone: M_i S_i with the effective mass M_i, without the missing
        mass. None in a store without ordinates.
        """
        S = self.ordinates(device, impact, case)
        if S is None:
            return None
        own = np.nan_to_num(S[self.column])
        return float(np.sum(self.effective_mass(device)[self.column] * own))

    def anchor(self, device: int) -> tuple[Array, int, int]:
        """Position of the anchor (3,) [m], number of its floor, number of its nodes."""
        return (
            self._values("anchor_position")[device],
            int(self.store["anchor_floor"].values[device]),
            int(self.store["anchor_nodes"].values[device]),
        )

    def drawing(self, device: int) -> Drawing | None:
        """What figures show of a device on springs; None for one that is made of modes.

        None, too, where the store says nothing of springs and bodies.
        """
        if "body_mass" not in self.store or math.isnan(self._values("body_mass")[device]):
            return None
        # Across a vertical direction, either horizontal one will do.
        axis = self.direction if self.direction in "xy" else "y"
        along = "xy".index(axis)
        about = 1 - along
        levels = self._values("level_height")[device]
        known = np.isfinite(levels)
        shape = self._values("mode_shape")[device, : self.modes(device)][:, known]
        # u = θ × r: du_x/dz = θ_y, du_y/dz = -θ_x.
        slope = shape[:, :, 3 + about] * (1.0 if along == 0 else -1.0)
        stiffness = self._values("base_stiffness")[device]
        return Drawing(
            axis=axis,
            spring=float(stiffness[along]),
            turning=float(stiffness[3 + about]),
            mass=float(self._values("body_mass")[device]),
            inertia=float(self._values("body_inertia")[device, about]),
            height=float(self._values("body_height")[device]),
            radius=float(self._values("body_radius")[device]),
            length=float(self._values("body_length")[device]),
            beam_length=float(self._values("beam_length")[device]),
            beam_mass=float(self._values("beam_mass")[device]),
            beam_bending=float(self._values("beam_bending")[device, about]),
            levels=levels[known],
            shift=shape[:, :, along],
            slope=slope,
        )

    @property
    def own_is_a_case(self) -> bool:
        """Whether a damping case repeats the buildings' own damping, to a hundredth: as printed."""
        own, *cases = (astuple(self.damping(case)) for case in range(len(self.cases)))
        return any(np.allclose(one, own, rtol=0.01, atol=0.0) for one in cases)

    def epsilon(self, case: int) -> float | None:
        """Restitution of the impacts; None where the contact laws keep theirs."""
        found = float(self.store["epsilon"].values[case])
        return found if math.isfinite(found) else None

    def calibrated(self, case: int) -> bool:
        """Whether it comes from the wall experiment with this damping."""
        return bool(self.store["epsilon_calibrated"].values[case])

    def of_device(self, stem: str, device: int) -> str:
        """A file's name: that of the first device is short, others hold the device's name."""
        return stem if device == 0 else f"{stem}_{self.devices[device]}"
