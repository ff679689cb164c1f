"""Checks: a quantity, its value, the interval that is allowed, and what a failure means.

A `Criterion` declares a check once: id, quantity, unit, limits, severity, consequence and remedy.
`Criterion.check` applies it to a value. Only `Check.text` writes a sentence.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from impactfem.spectra.design import ENDED
from impactfem.system.arrays import Array
from impactfem.system.log import LOGGER

QUIET = 0.01
"""Peak acceleration over the largest one along the same axis up to which a point is at rest."""
HALVED = 0.05
"""Change of the largest force, and ordinate of floor spectra, with half of the points of contact or
steps twice as long."""

Severity = Literal["invalid", "limited", "information"]
"""What a failed check means: do not use the results it names; use them within the limit that it
states; or nothing, as it has no limits."""

PROGRAM_FAULT = "Report this as a fault of the program"
"""Remedy of a check that no input can fail."""
CRITERIA: dict[str, Criterion] = {}
"""Every declared criterion by its id; `impactfem.run.stages` imports all stages."""


@dataclass(frozen=True)
class Criterion:
    """The declaration of a check.

    The unit "%" is for parts of one, "% of the gap" for parts of a whole; values and limits are
    then parts, and the sentence shows per cent.
    """

    id: str  #: stage and name of the check, ``pounding.energy_residual``
    quantity: str  #: the checked quantity, a noun phrase
    unit: str = ""
    lower: float = -math.inf  #: the least value that passes
    upper: float = math.inf  #: the largest value that passes
    severity: Severity = "limited"
    consequence: str = ""  #: what a failure affects, a sentence
    remedy: str = ""  #: what to do after a failure, with the key of the case; a sentence
    #: Results that a failure makes doubtful: patterns of the names in `summary.json`.
    concerns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if CRITERIA.setdefault(self.id, self) != self:
            raise ValueError(f"two checks have the id {self.id}")

    def check(
        self,
        value: float | None = None,
        place: str = "",
        detail: str = "",
        *,
        lower: float | None = None,
        upper: float | None = None,
    ) -> Check:
        """Apply the criterion to a value.

        Args:
            value: The value in the unit; None where only `detail` is known.
            place: Where the value stands: building, floor, direction, frequency.
            detail: Further numbers or a reason, without a full stop.
            lower: Least value that passes, where the case gives it.
            upper: Largest value that passes, where the case gives it.
        """
        low = self.lower if lower is None else lower
        high = self.upper if upper is None else upper
        return Check(self, None if value is None else float(value), place, detail, low, high)


@dataclass(frozen=True)
class Check:
    """A criterion with the value that a run has."""

    criterion: Criterion
    value: float | None  #: in the unit of the criterion; nan where it could not be computed
    place: str = ""  #: building, floor, direction or frequency of the value
    detail: str = ""  #: further numbers, or a reason
    lower: float = -math.inf  #: least value that passes
    upper: float = math.inf  #: largest value that passes

    @property
    def id(self) -> str:
        """Id of the criterion."""
        return self.criterion.id

    @property
    def passed(self) -> bool | None:
        """Whether the value lies within its limits; nan does not. None without value or limits."""
        if self.value is None or not (math.isfinite(self.lower) or math.isfinite(self.upper)):
            return None
        return self.lower <= self.value <= self.upper

    @property
    def text(self) -> str:
        """The check as a sentence: quantity = value unit, place (limits); detail."""
        words = self.criterion.quantity
        if self.value is not None:
            words += f" = {self._number()}"
        words += f", {self.place}" if self.place else ""
        words += f" ({limits})" if self.passed is not None and (limits := self._limits()) else ""
        words += f"{'; ' if self.value is not None else ': '}{self.detail}" if self.detail else ""
        if self.passed is False:
            texts = (self.criterion.consequence, self.criterion.remedy)
            words = ". ".join((words, *(text.removesuffix(".") for text in texts if text)))
        return words

    def row(self, stage: str) -> dict[str, Any]:
        """Return the check of a stage as an entry of ``checks.json``; numbers are in the unit."""
        of = self.criterion

        def shown(value: float | None) -> float | None:
            return None if value is None or not math.isfinite(value) else self._scale() * value

        return {
            "stage": stage,
            "id": of.id,
            "quantity": of.quantity,
            "value": shown(self.value),
            "lower": shown(self.lower),
            "upper": shown(self.upper),
            "unit": of.unit,
            "place": self.place,
            "detail": self.detail,
            "passed": self.passed,
            "severity": of.severity if self.passed is not None else "information",
            "consequence": of.consequence,
            "remedy": of.remedy,
            "concerns": list(of.concerns),
            "text": self.text,
        }

    def _scale(self) -> float:
        return 100.0 if self.criterion.unit.startswith("%") else 1.0

    def _number(self) -> str:
        """Return the value in three digits, in six where three show the limit that it exceeds."""
        value, unit = self._scale() * (self.value or 0.0), self.criterion.unit
        number = digits(value)
        bounds = [digits(self._scale() * limit) for limit in (self.lower, self.upper)]
        if self.passed is False and number in bounds:
            number = f"{value:.6g}"
        return f"{number} {unit}".strip()

    def _limits(self) -> str:
        low, high = (digits(self._scale() * limit) for limit in (self.lower, self.upper))
        unit = " %" if self._scale() > 1.0 else f" {self.criterion.unit}".rstrip()
        if not math.isfinite(self.lower):
            return f"at most {high}{unit}"
        if not math.isfinite(self.upper):
            return f"at least {low}{unit}"
        return f"allowed {low} to {high}{unit}"


def severity_counts(rows: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Count the entries of ``checks.json``: failed ones by severity, passed ones, information."""
    counts = {"invalid": 0, "limited": 0, "passed": 0, "information": 0}
    for row in rows:
        failed = row["passed"] is False
        counts[row["severity"] if failed else "passed" if row["passed"] else "information"] += 1
    return counts


def digits(value: float) -> str:
    """Write a number in three digits, a small one in two with its power of ten: 15.7, 8.9e-16."""
    if not math.isfinite(value):
        return str(value)
    if 0.0 < abs(value) < 1e-3:
        mantissa, _, power = f"{value:.1e}".partition("e")
        return f"{mantissa.removesuffix('.0')}e{int(power)}"
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def end_of_spectra(stage: str, *concerns: str) -> Criterion:
    """Declare that the spectra of a stage end at the peak acceleration of their point.

    `concerns` are patterns of the names of peak accelerations.
    """
    return Criterion(
        f"{stage}.spectrum_end",
        "ratio of the last spectral ordinate to the peak acceleration",
        lower=1.0 / ENDED,
        upper=ENDED,
        consequence="The spectra have not reached their ZPA at the highest frequency",
        remedy="Raise frequencies of [spectra], or use the spectra up to the resolved frequency",
        concerns=concerns,
    )


def end_check(
    criterion: Criterion,
    points: Sequence[str],
    axes: Sequence[str],
    ratio: Array,
    last: float,
    *,
    jumps: bool = True,
) -> Check:
    """Check that spectra reach the peak acceleration at their last frequency.

    Args:
        criterion: Of `end_of_spectra`.
        points: Names of the points.
        axes: Names of the directions.
        ratio: Last ordinate over the peak acceleration, shape (n_points, n_axes) [-]; nan where a
            point is at rest.
        last: Last frequency of the spectra [Hz].
        jumps: Whether a contact force may begin with a jump.
    """
    if not np.isfinite(ratio).any():
        return criterion.check(detail="no point moves")
    off = np.nan_to_num(np.abs(np.log(ratio)))
    k, c = (int(index) for index in np.unravel_index(int(off.argmax()), off.shape))
    late = np.flatnonzero((off > np.log(ENDED)).any(axis=1))
    detail = ""
    if late.size:
        detail = f"{late.size} of {len(points)} points are outside"
        if jumps:
            detail += (
                "; a contact force that begins with a jump (kelvin-voigt) has no highest frequency:"
                " the last ordinates depend on the time step"
            )
    return criterion.check(ratio[k, c], f"{points[k]}, {axes[c]}, {last:.4g} Hz", detail)


def log_checks(label: str, checks: Iterable[Check]) -> None:
    """Log the checks of a stage: failed checks as warnings, all others in detail."""
    for check in checks:
        if check.passed is False:
            LOGGER.warning("warning: %s: %s", label, check.text)
        else:
            LOGGER.debug("%s: %s", label, check.text)
