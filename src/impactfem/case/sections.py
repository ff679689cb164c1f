"""Sections of beams and columns: rolled I and H sections by name, and sections by their properties.

The axes are those of EN 1993-1-1: y along the flanges, z along the web. A section bends about y
where it moves along its web.

With the depth h, the width b, the thicknesses t_w and t_f, the radius r of the fillets, and the
depth h_w = h − 2 t_f between the flanges, a rolled section has

    A = 2 b t_f + h_w t_w + (4 − π) r²
    I_y = (b h³ − (b − t_w) h_w³)/12 + 4 (I_r + A_r (h_w/2 − e)²)
    I_z = (2 t_f b³ + h_w t_w³)/12 + 4 (I_r + A_r (t_w/2 + e)²)
    J = ⅔ b t_f³ (1 − 0.63 t_f/b) + ⅓ h_w t_w³ + 2 α D⁴
    A_vz = h t_w,   A_vy = 5/6 · 2 b t_f

A_r = (1 − π/4) r² is the area of a fillet, e = r (10 − 3π)/(12 − 3π) the distance of its centroid
from the corner, I_r = r⁴ (1/3 − π/16 − 1/(36 − 9π)) its second moment about that. J is that of El
Darwish and Johnston (1965), D = ((r + t_w/2)² + (r + t_f)² − r²)/(2 r + t_f) the diameter of the
circle inscribed in the joint of web and flange, α = (0.145 + 0.1 r/t_f) t_w/t_f. Shear areas are
those of SAP2000 (CSI Analysis Reference Manual, section Frame element).
"""

# The method of the leaf is described once, in its base.

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any

from pydantic import ValidationInfo

from impactfem.case.base import Section, nearest, refuse
from impactfem.case.leaf import Words
from impactfem.case.quantity import Area, PositiveLength, SecondMoment, Si
from impactfem.case.table import read_table
from impactfem.system.errors import Fault

STANDARDS = ("european", "british", "american")
"""Tables of rolled sections: EN 10365 (IPE, HEA, HEB, HEM; UB, UC), ASTM A6 (W)."""
_SPELLED = {
    r"HE(\d+)([ABM])": r"HE\2\1",  # HE 300 B
    r"([\dX.]+)(UB|UC)": r"\2\1",  # 457 x 191 x 67 UB
}
Angle = Annotated[float, Si("rad")]


class MemberSection(Section):
    """A section of beams or columns by its properties, in its own axes y and z."""

    A: Area
    """Area of the section."""
    Iy: SecondMoment
    """Second moment of area for bending about y, that is for a movement along z."""
    Iz: SecondMoment
    """Second moment of area for bending about z, that is for a movement along y."""
    J: SecondMoment
    """Torsion constant."""
    Avy: Annotated[float | None, Si("m2", gt=0)] = None
    """Shear area along y; default no shear deformation."""
    Avz: Annotated[float | None, Si("m2", gt=0)] = None
    """Shear area along z; default no shear deformation."""


UNKNOWN_SECTION = MemberSection(A=1.0, Iy=1.0, Iz=1.0, J=1.0)
"""Replaces a section with faults, so that the other faults of a case are found."""


class RolledSection(Section):
    """Dimensions of a rolled I or H section: one row of a table of a standard."""

    section: Annotated[str, Words()]
    """Name of the section."""
    h: PositiveLength
    """Depth."""
    b: PositiveLength
    """Width of the flanges."""
    tw: PositiveLength
    """Thickness of the web."""
    tf: PositiveLength
    """Thickness of the flanges."""
    r: PositiveLength
    """Radius of the fillets."""
    A: Annotated[float | None, Si("m2", gt=0)] = None
    """Tabulated area; default by the dimensions."""
    Iy: Annotated[float | None, Si("m4", gt=0)] = None
    """Tabulated second moment of area about y; default by the dimensions."""
    Iz: Annotated[float | None, Si("m4", gt=0)] = None
    """Tabulated second moment of area about z; default by the dimensions."""
    J: Annotated[float | None, Si("m4", gt=0)] = None
    """Tabulated torsion constant; default by the dimensions."""

    @property
    def by_dimensions(self) -> MemberSection:
        """Properties by the equations of the module."""
        h, b, tw, tf, r = self.h, self.b, self.tw, self.tf, self.r
        hw = h - 2.0 * tf
        A_r, e = (1.0 - math.pi / 4.0) * r**2, r * (10.0 - 3.0 * math.pi) / (12.0 - 3.0 * math.pi)
        I_r = r**4 * (1.0 / 3.0 - math.pi / 16.0 - 1.0 / (36.0 - 9.0 * math.pi))
        D = ((r + tw / 2.0) ** 2 + (r + tf) ** 2 - r**2) / (2.0 * r + tf)
        alpha = (0.145 + 0.1 * r / tf) * tw / tf
        flanges = 2.0 / 3.0 * b * tf**3 * (1.0 - 0.63 * tf / b)
        return MemberSection(
            A=2.0 * b * tf + hw * tw + 4.0 * A_r,
            Iy=(b * h**3 - (b - tw) * hw**3) / 12.0 + 4.0 * (I_r + A_r * (hw / 2.0 - e) ** 2),
            Iz=(2.0 * tf * b**3 + hw * tw**3) / 12.0 + 4.0 * (I_r + A_r * (tw / 2.0 + e) ** 2),
            J=flanges + hw * tw**3 / 3.0 + 2.0 * alpha * D**4,
            Avy=5.0 / 6.0 * 2.0 * b * tf,
            Avz=h * tw,
        )

    @property
    def properties(self) -> MemberSection:
        """Properties: the tabulated ones, the others by the dimensions."""
        given = {name: getattr(self, name) for name in ("A", "Iy", "Iz", "J")}
        table = {name: value for name, value in given.items() if value is not None}
        return self.by_dimensions.model_copy(update=table)


@lru_cache(maxsize=1)
def rolled_sections() -> dict[str, RolledSection]:
    """Read the tables of rolled sections, by the name in capitals without blanks: HEB300."""
    found = dict[str, RolledSection]()
    for standard in STANDARDS:
        path = Path(str(files("impactfem.case") / "rolled" / f"{standard}.csv"))
        faults: list[Fault] = []
        table = read_table(path, RolledSection, faults, once=("section",))
        if table is None:
            raise ValueError(faults)
        found |= {_spelled(row.section): row for row in table.rows}
    return found


def rolled_section(name: str) -> MemberSection:
    """Return the properties of a rolled section by its name: HEB 300, UB 457x191x67, W14x90.

    Raises:
        KeyError: No table has the name.
    """
    return rolled_sections()[_spelled(name)].properties


def _spelled(name: str) -> str:
    text = re.sub(r"[\s_-]", "", name).upper().replace("×", "X")
    for pattern, order in _SPELLED.items():
        text = re.sub(f"^{pattern}$", order, text)
    return text


@dataclass(frozen=True)
class SectionOf(Words):
    """The name of a rolled section or of one of [sections]; held as its properties."""

    words: str = (
        "the name of a rolled section (IPE, HEA, HEB, HEM, UB, UC, W), for example 'HEB 300', or "
        "of one of [sections]"
    )
    longest: int = 64

    def check(self, value: Any, info: ValidationInfo) -> Any:
        """Take the properties of the name."""
        if isinstance(value, MemberSection):
            return value
        name = super().check(value, info)
        context = info.context
        own = () if context is None else context.names("sections") or ()
        if context is not None and name in own:
            return context.values.get("sections", {}).get(name, UNKNOWN_SECTION)
        try:
            return rolled_section(name)
        except KeyError:
            known = [*own, *(row.section for row in rolled_sections().values())]
            raise refuse(f"unknown section; {nearest(name, known)}", kind="unknown_name") from None
