"""The elastic spectra of the French decrees for buildings and for special-risk installations."""

from __future__ import annotations

from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.motion.eurocode import Shape, ground_shape, shaped
from impactfem.system.errors import ImpactfemError

# Arrêté of 22 October 2010, article 4: a_gr by zone of seismicity [m/s2].
REFERENCE_ACCELERATION = {1: 0.4, 2: 0.7, 3: 1.1, 4: 1.6, 5: 3.0}

# The first set of article 4, for zones 1 to 4, and the second, for zone 5.
_MODERATE = {
    "A": Shape(1.0, (0.03, 0.20, 2.5)),
    "B": Shape(1.35, (0.05, 0.25, 2.5)),
    "C": Shape(1.5, (0.06, 0.40, 2.0)),
    "D": Shape(1.6, (0.10, 0.60, 1.5)),
    "E": Shape(1.8, (0.08, 0.45, 1.25)),
}
_STRONG = {
    "A": Shape(1.0, (0.15, 0.4, 2.0)),
    "B": Shape(1.2, (0.15, 0.5, 2.0)),
    "C": Shape(1.15, (0.20, 0.6, 2.0)),
    "D": Shape(1.35, (0.20, 0.8, 2.0)),
    "E": Shape(1.4, (0.15, 0.5, 2.0)),
}
_MODERATE_VERTICAL = Shape(0.8, (0.03, 0.20, 2.5))
_STRONG_VERTICAL = Shape(0.9, (0.15, 0.40, 2.0))
_FIRST_STRONG_ZONE = {"ordinary": 5, "special": 4}


def decree_spectrum(
    zone: int,
    ground: str,
    *,
    importance_factor: float = 1.0,
    text: str = "ordinary",
    vertical: bool = False,
    damping: float = 0.05,
) -> DesignSpectrum:
    """Give the elastic spectrum of the French decrees, in the form of EN 1998-1.

    The arrêté of 22 October 2010 (ordinary risk) has one set of soil factors and corner periods
    for zones 1 to 4 and another, that of type 1 of the Eurocode, for zone 5; the arrêté of
    4 October 2010 (special risk, article 12-3) takes the second from zone 4 on. The level is
    γ_I a_gr S, or γ_I a_gr (a_vg/a_g) for the vertical spectrum; the accelerations of the
    special-risk text are its own, so γ_I stands for their ratio to a_gr.

    Args:
        zone: Zone of seismicity, 1 to 5.
        ground: Type of ground, "A" to "E"; without influence on the vertical spectrum.
        importance_factor: γ_I [-].
        text: "ordinary" or "special" risk.
        vertical: Whether the vertical spectrum is wanted.
        damping: Ratio ξ [-].

    Raises:
        ImpactfemError: There is no such zone, ground or text, or a value is out of range.
    """
    if zone not in REFERENCE_ACCELERATION:
        raise ImpactfemError(f"the zone of seismicity is 1 to 5, got {zone!r}")
    if text not in _FIRST_STRONG_ZONE:
        raise ImpactfemError(f"the text is 'ordinary' or 'special', got {text!r}")
    strong = zone >= _FIRST_STRONG_ZONE[text]
    if vertical:
        shape = _STRONG_VERTICAL if strong else _MODERATE_VERTICAL
    else:
        shape = ground_shape(_STRONG if strong else _MODERATE, ground)
    return shaped(shape, REFERENCE_ACCELERATION[zone], importance_factor, vertical, damping)
