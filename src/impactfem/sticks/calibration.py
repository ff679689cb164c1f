"""Calibration of sticks on target frequencies and effective masses (paper, section 3.1)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from impactfem.sticks.modes import FAMILIES
from impactfem.sticks.stick import Stick
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.least_squares import minima, starts_within
from impactfem.system.quantity import results, si


@dataclass(frozen=True)
class Target:
    """What one mode of one building should be."""

    building: str  #: name of the building
    mode: int  #: number of the mode in its family, from 1, in natural order
    frequency: float  #: natural frequency [Hz]
    effective_mass: float | None  #: effective modal mass [kg]; None where it is not a target
    frequency_weight: float = 1.0  #: weight of the relative error of the frequency [-]
    mass_weight: float = 1.0  #: weight of the relative error of the effective mass [-]


@dataclass(frozen=True)
class Bounds:
    """What the calibration may change, and how far."""

    factor: tuple[float, float]  #: least and largest storey stiffness factor [-]
    height_min: Array  #: least height of each storey, shape (n_storeys,) [m]
    height_max: Array  #: largest height of each storey, shape (n_storeys,) [m]
    height: float  #: height of the top mass centre above the base, kept [m]
    rigid_depth: float  #: rigid depth of a floor, lower plus upper part, kept [m]


@results
class Parameters:
    """The calibrated values, shared by all buildings of the targets."""

    factor: float = si("-", "factor on the stiffness of all storeys", name="stiffness_factor")
    #: Shape (n_storeys,).
    heights: Array = si(
        "m", "storey heights, mass centre to mass centre", dims="storey", name="storey_height"
    )
    below: float = si("m", "rigid depth below the mass centre", name="rigid_depth_below")
    above: float = si("m", "rigid depth above the mass centre", name="rigid_depth_above")


@dataclass(frozen=True)
class Calibration:
    """The result of a calibration."""

    parameters: Parameters  #: the calibrated values
    targets: tuple[Target, ...]
    frequency: Array  #: the frequency of each target's mode [Hz]
    effective_mass: Array  #: its effective mass [kg]

    @property
    def frequency_error(self) -> Array:
        """Relative error of each target's frequency [-]."""
        return np.asarray(self.frequency / [t.frequency for t in self.targets] - 1.0)

    @property
    def mass_error(self) -> Array:
        """Relative error of each target's effective mass [-]; nan where it is none."""
        asked = [np.nan if t.effective_mass is None else t.effective_mass for t in self.targets]
        return np.asarray(self.effective_mass / asked - 1.0)


def family_modes(stick: Stick, direction: str) -> tuple[Array, Array]:
    """Frequencies [Hz] and effective masses [kg] of one family, in natural order.

    A straight stick moves along y without moving along x, z or about z, so the family's own
    degrees of freedom are enough.
    """
    components = FAMILIES[direction]
    dofs = np.array([6 * i + c for i in range(stick.n // 6) for c in components])
    values, shapes = scipy.linalg.eigh(stick.K[np.ix_(dofs, dofs)], stick.M[np.ix_(dofs, dofs)])
    r = stick.rigid_body()[dofs, components[0]]
    participation = r @ stick.M[np.ix_(dofs, dofs)] @ shapes
    return np.sqrt(values) / (2.0 * np.pi), participation**2


def assess(
    make: Callable[[str, Parameters], Stick],
    targets: Sequence[Target],
    parameters: Parameters,
    *,
    direction: str,
) -> Calibration:
    """What given parameters make of the targets; nothing is fitted. Arguments as `calibrate`.

    ImpactfemError where a target names a mode that its building has not.
    """
    names = sorted({t.building for t in targets})
    found = {name: family_modes(make(name, parameters), direction) for name in names}
    for t in targets:
        if t.mode > found[t.building][0].size:
            raise ImpactfemError(
                f"the targets name mode {t.mode} of building {t.building}, which has "
                f"{found[t.building][0].size} modes of bending along {direction}"
            )
    frequency = np.array([found[t.building][0][t.mode - 1] for t in targets])
    mass = np.array([found[t.building][1][t.mode - 1] for t in targets])
    return Calibration(parameters, tuple(targets), frequency, mass)


def calibrate(
    make: Callable[[str, Parameters], Stick],
    targets: Sequence[Target],
    bounds: Bounds,
    *,
    direction: str,
    start: Parameters,
    starts: int,
    seed: int,
) -> Calibration:
    """Fit storey stiffness factor, storey heights and the split of the rigid depth.

    Minimises ½ Σ (w_f (f/f_target - 1))² + (w_m (m/m_target - 1))² under the bounds and the given
    total height. All frequencies go with the square root of the factor and the masses do not
    depend on it, so the best factor follows in closed form for any heights and split; the rest is
    found by SLSQP (Kraft 1988) from several starts, of which the best result counts.

    Args:
        make: Makes the stick of a building from parameters; massless points are not allowed.
        targets: What to reach.
        bounds: What may change.
        direction: Direction of the family, "x" or "y".
        start: First start.
        starts: Number of starts; the others are drawn at random inside the bounds.
        seed: Seed of the draw.

    ImpactfemError where the bounds of the heights leave no room for the total height, no frequency
    has a weight, or a building has fewer modes than a target requests; SolutionError where no start
    led to a result.
    """
    low, high = bounds.height_min, bounds.height_max
    slack = 1e-8 * bounds.height  # the sums are of rounded numbers
    if not low.sum() - slack <= bounds.height <= high.sum() + slack:
        raise ImpactfemError(
            f"storey heights between {low.sum():.4g} m and {high.sum():.4g} m in all cannot add up "
            f"to calibration.height = {bounds.height:.4g} m"
        )
    if not any(t.frequency_weight > 0.0 for t in targets):
        raise ImpactfemError("the calibration needs a frequency_weight above 0 in its targets")
    f_target = np.array([t.frequency for t in targets])
    w_f = np.array([t.frequency_weight for t in targets])
    m_target = np.array([t.effective_mass or 1.0 for t in targets])
    w_m = np.array([t.mass_weight if t.effective_mass is not None else 0.0 for t in targets])
    free, depth = high > low, bounds.rigid_depth

    # x holds the free storey heights [m] and the part of the rigid depth that is below the mass
    # centres [-].
    def parameters(x: Array, factor: float) -> Parameters:
        heights = low.copy()
        heights[free] = x[:-1]
        below = float(np.clip(x[-1], 0.0, 1.0)) * depth
        return Parameters(factor, heights, below, depth - below)

    def evaluate(x: Array) -> tuple[Array, Array, float]:
        """Frequencies and effective masses with the best factor, and this factor."""
        unit = assess(make, targets, parameters(x, 1.0), direction=direction)
        ratio = w_f * unit.frequency / f_target
        root = float(np.clip(w_f @ ratio / (ratio @ ratio), *np.sqrt(bounds.factor)))
        return root * unit.frequency, unit.effective_mass, root**2

    def errors(x: Array) -> Array:
        frequency, mass, _ = evaluate(x)
        return np.append(w_f * (frequency / f_target - 1), w_m * (mass / m_target - 1))

    # The heights keep their sum; nothing is to be kept where none is free.
    kept = np.append(np.ones(int(free.sum())), 0.0), float(bounds.height - low[~free].sum())
    least, most = np.append(low[free], 0.0), np.append(high[free], 1.0)
    # The first start, moved into the bounds, and others drawn inside them.
    split = start.below / depth if depth > 0.0 else 0.5
    first = np.append(np.clip(start.heights, low, high)[free], split)
    drawn = starts_within(first, least, most, starts, seed)
    best = minima(errors, drawn, least, most, total=kept)[0]
    frequency, mass, factor = evaluate(best.x)
    return Calibration(parameters(best.x, factor), tuple(targets), frequency, mass)
