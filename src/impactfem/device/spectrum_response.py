"""What response spectrum analysis gives: totals, and the part of each input and each mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.device.directions import InputRule, combine_inputs
from impactfem.device.modes import DeviceModes
from impactfem.device.quantity import Quantities
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]
Cell = str | float | int | None


@dataclass(frozen=True, eq=False)
class InputResponse:
    """Response to one component of one anchor.

    Args:
        spectrum: The input.
        ordinate: Pseudo-acceleration S of each mode, shape (m,) [m/s2, rad/s2]; 0 for a mode that
            the component does not move.
        rigid_fraction: α, shape (m,) [-].
        modal: R_i with its sign, shape (n_q, m).
        missing: R_m, shape (n_q,).
        periodic: R_p, shape (n_q,).
        rigid: R_r, shape (n_q,).
        total: R, shape (n_q,).
    """

    spectrum: AnchorSpectrum
    ordinate: Array
    rigid_fraction: Array
    modal: Array
    missing: Array
    periodic: Array
    rigid: Array
    total: Array

    @property
    def share(self) -> Array:
        """R_i² of each mode, then R_m², over their sum, or 0, shape (n_q, m + 1) [-]."""
        squares = np.hstack([self.modal, self.missing[:, None]]) ** 2
        whole = squares.sum(axis=1, keepdims=True)
        shares = np.zeros_like(squares)
        np.divide(squares, whole, out=shares, where=whole > 0.0)
        return shares


@dataclass(frozen=True, eq=False)
class SpectrumResponse:
    """Largest responses of a device.

    Args:
        device: Its name.
        modes: The modes used.
        quantities: What was computed, n_q quantities.
        inputs: The part of each input.
        columns: Which component of the anchors each input is.
        by_component: R of each component over all anchors, shape (n_q,).
        inertial: All components combined, shape (n_q,).
        displacement: Of the displacements of the anchors against each other, shape (n_q,).
        notes: What was assumed, in words.
        whole: Combination of the last two parts: "srss" or "abs".
    """

    device: str
    modes: DeviceModes
    quantities: Quantities
    inputs: tuple[InputResponse, ...]
    columns: tuple[int, ...]
    by_component: dict[str, Array]
    inertial: Array
    displacement: Array
    notes: tuple[str, ...]
    whole: InputRule = "srss"

    @property
    def total(self) -> Array:
        """Inertial part and displacements of the anchors, √(R² + R_Δ²) or R + R_Δ, shape (n_q,)."""
        return combine_inputs(np.stack([self.inertial, self.displacement]), self.whole)

    def value(self, name: str) -> float:
        """The total of one quantity.

        Raises:
            ImpactfemError: There is no such quantity.
        """
        return float(self.total[self._index(name)])

    def mode_table(
        self, name: str
    ) -> tuple[tuple[tuple[str, str], ...], tuple[tuple[Cell, ...], ...]]:
        """Each mode's part in one quantity, input by input.

        Beside the pseudo-acceleration S stands the relative displacement S / ω² of the oscillator:
        what an anchor would have to bear in a spectrum whose high accelerations are short.

        Args:
            name: The quantity.

        Returns:
            Names and units of the columns, and the rows: one for each mode that the input moves,
            and one for the missing mass.

        Raises:
            ImpactfemError: There is no such quantity.
        """
        q = self._index(name)
        columns = (
            ("input", ""),
            ("mode", ""),
            ("frequency", "Hz"),
            ("damping", "-"),
            ("effective mass", "kg or kg m2"),
            ("pseudo-acceleration", "m/s2 or rad/s2"),
            ("displacement", "m or rad"),
            ("rigid part", "-"),
            (name, self.quantities.units[q]),
            ("share", "-"),
        )
        rows: list[tuple[Cell, ...]] = []
        for one, k in zip(self.inputs, self.columns, strict=True):
            label = f"{one.spectrum.component} at anchor {one.spectrum.anchor}"
            share = one.share[q]
            for i, f in enumerate(self.modes.frequency):
                if one.ordinate[i] == 0.0:
                    continue
                rows.append(
                    (
                        label,
                        i + 1,
                        float(f),
                        float(self.modes.damping[i]),
                        float(self.modes.effective_mass[k, i]),
                        float(one.ordinate[i]),
                        float(one.ordinate[i] / self.modes.omega[i] ** 2),
                        float(one.rigid_fraction[i]),
                        float(one.modal[q, i]),
                        float(share[i]),
                    )
                )
            rigid = max(float(self.modes.rigid_mass[k, k]), 0.0)
            rows.append(
                (
                    label,
                    "missing mass",
                    None,
                    None,
                    rigid,
                    one.spectrum.zpa,
                    None,
                    1.0,
                    float(one.missing[q]),
                    float(share[-1]),
                )
            )
        return columns, tuple(rows)

    def _index(self, name: str) -> int:
        if name not in self.quantities.names:
            raise ImpactfemError(
                f"device {self.device}: no quantity {name!r} was computed; there are"
                f" {', '.join(self.quantities.names)}"
            )
        return self.quantities.names.index(name)
