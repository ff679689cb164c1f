"""Contact laws, each a class in one file of this package.

A further file of this package is imported, and its law registered, without a change elsewhere.
"""

from importlib import import_module
from pkgutil import iter_modules

from impactfem.coupling.law import LAWS, Law, effective_mass
from impactfem.coupling.laws.hertz import Hertz
from impactfem.coupling.laws.hertz_damp import HertzDamp
from impactfem.coupling.laws.hunt_crossley import HuntCrossley
from impactfem.coupling.laws.jankowski import Jankowski
from impactfem.coupling.laws.kelvin_voigt import KelvinVoigt
from impactfem.coupling.laws.unilateral import Unilateral

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

__all__ = [
    "LAWS",
    "Hertz",
    "HertzDamp",
    "HuntCrossley",
    "Jankowski",
    "KelvinVoigt",
    "Law",
    "Unilateral",
    "effective_mass",
]
