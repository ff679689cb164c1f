"""Damping cases: further dampings of the buildings, for which the study is repeated."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field, field_validator

from impactfem.case.base import Section
from impactfem.case.calibrated import CALIBRATED, CalibratedRestitution
from impactfem.case.damping import Damping
from impactfem.case.leaf import Name, refuse
from impactfem.case.named_files import tables_of
from impactfem.case.source import Source
from impactfem.system.errors import Fault

OWN = "own"
"""Stands in results for the dampings that the buildings have without a damping case."""


class _Named(Section):
    name: Name = Field(description=f"Name of the damping case, each its own; not '{OWN}'.")

    @field_validator("name")
    @classmethod
    def _another_than_own(cls, value: str) -> str:
        if value == OWN:
            raise refuse(f"expected another name: '{OWN}' is the damping of [damping]")
        return value


# The name comes first in the order of the fields, which is that of the bases from right to left.
class DampingCase(Damping, _Named):
    """A further Rayleigh damping of all buildings, for which the study is repeated.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    """

    restitution: CalibratedRestitution = Field(
        default="calibrated",
        description="Coefficient of restitution with this damping, of contact laws of type "
        "'kelvin-voigt'; calibrated by the impact of [wall_impact] with this damping, for those "
        "laws that say 'calibrated' where one does. Left out in a case without [wall_impact], the "
        "laws keep theirs.",
    )


def damping_case_faults(source: Source) -> Iterator[Fault]:
    """What damping cases ask for that the case has not, from the file as it stands.

    Args:
        source: The case file.
    """
    if "wall_impact" not in source.raw:
        for index, entry in tables_of(source.raw, "damping_cases"):
            if entry.get("restitution") == CALIBRATED:
                expected = "expected a section [wall_impact] beside it: the impact that gives it"
                yield source.fault(("damping_cases", index, "restitution"), CALIBRATED, expected)
    transient = source.raw.get("transient")
    served = isinstance(transient, dict) and transient.get("serve_damping_cases") is True
    if served and "damping_cases" not in source.raw:
        expected = "expected [[damping_cases]] beside it: the dampings to serve"
        yield source.fault(("transient", "serve_damping_cases"), True, expected)
