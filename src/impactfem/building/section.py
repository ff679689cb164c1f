"""Sections and materials of shells and beams, and the frame that a beam's section stands in."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]

E_X: Vector = (1.0, 0.0, 0.0)
E_Y: Vector = (0.0, 1.0, 0.0)
E_Z: Vector = (0.0, 0.0, 1.0)
SHEAR = 5.0 / 6.0  # shear factor of a rectangle, and of a plate
RIGID = 1e4  # shear factor without shear deformation
_TERMS = 40  # of the series of J: the rest is below 1e-11 of it


@dataclass(frozen=True)
class Material:
    """An isotropic, linear elastic material."""

    E: float  #: Young's modulus [Pa].
    nu: float  #: Poisson's ratio ν.
    rho: float  #: Density ρ [kg/m3].

    @property
    def G(self) -> float:
        """Shear modulus [Pa]."""
        return self.E / (2.0 * (1.0 + self.nu))


@dataclass(frozen=True)
class Materials:
    """The materials of a mesh's `shell_parts` and `beam_parts`, in their order."""

    shells: tuple[Material, ...]
    beams: tuple[Material, ...]


@dataclass(frozen=True)
class ShellSection:
    """Section of a shell."""

    thickness: float  #: t [m].


@dataclass(frozen=True)
class BeamSection:
    """Section of a beam in its frame (t, n1, n2), with s1 and s2 along n1 and n2."""

    A: float  #: Area [m2].
    I1: float  #: ∫ s2² dA, for bending that moves along n2 [m4].
    I2: float  #: ∫ s1² dA, for bending that moves along n1 [m4].
    J: float  #: Torsion constant [m4].
    k1: float = SHEAR  #: Shear factor along n1.
    k2: float = SHEAR  #: Shear factor along n2.
    reference: Vector = E_Z  #: Vector r in the plane of t and n2; not along t.
    offset: Vector = (0.0, 0.0, 0.0)  #: From the node line to the axis, global components [m].

    @classmethod
    def rectangle(
        cls,
        width: float,
        depth: float,
        *,
        reference: Vector = E_Z,
        offset: Vector = (0.0, 0.0, 0.0),
    ) -> BeamSection:
        """A solid rectangle, the depth h along n2 and the width b along n1 [m].

        A = b h, I1 = b h³/12, I2 = h b³/12; J by the series of Saint-Venant, with a the shorter
        side and b the longer one (Timoshenko and Goodier, Theory of Elasticity, section 109):
        J = a³ b/3 (1 - 192 a/(π⁵ b) Σ tanh(n π b/(2 a))/n⁵), over odd n.
        """
        a, b = sorted((width, depth))
        series = sum(math.tanh(n * math.pi * b / (2.0 * a)) / n**5 for n in range(1, 2 * _TERMS, 2))
        return cls(
            A=width * depth,
            I1=width * depth**3 / 12.0,
            I2=depth * width**3 / 12.0,
            J=a**3 * b / 3.0 * (1.0 - 192.0 * a / (math.pi**5 * b) * series),
            reference=reference,
            offset=offset,
        )

    @classmethod
    def beam(cls, width: float, depth: float, offset: float = 0.0) -> BeamSection:
        """A rectangular beam that is not vertical: the depth in the vertical plane [m].

        The offset is that of the axis above the node line, negative below [m].
        """
        return cls.rectangle(width, depth, reference=E_Z, offset=(0.0, 0.0, offset))

    @classmethod
    def column(cls, width_x: float, width_y: float, angle: float = 0.0) -> BeamSection:
        """A rectangular column, sides along x and y [m]: n1 = e_x and n2 = e_y, as t is e_z.

        The angle turns it from x towards y [rad].
        """
        return cls.rectangle(width_x, width_y, reference=_turned(E_Y, E_Z, angle))

    def in_plan(self) -> tuple[float, float, float, float]:
        """Return A_x, A_y, I_x and I_y of a column in plan, on the axes x and y [m2, m4].

        Shear areas are gross areas, k A over 5/6: A itself of a rectangle. I_x = ∫ y² dA.
        """
        x, y, _ = np.square(self.reference) / np.sum(np.square(self.reference))
        A1, A2 = (k * self.A / SHEAR for k in (self.k1, self.k2))
        I1, I2 = self.I1, self.I2
        return A1 * y + A2 * x, A1 * x + A2 * y, I1 * y + I2 * x, I1 * x + I2 * y

    def along_reference(self, directions: ArrayLike) -> NDArray[np.bool_]:
        """Whether each direction, shape (..., 3), is along r within about 0.1°: it has no frame."""
        t = np.asarray(directions, dtype=np.float64)
        t = t / np.linalg.norm(t, axis=-1, keepdims=True)
        r = np.asarray(self.reference) / np.linalg.norm(self.reference)
        return np.asarray(np.linalg.norm(r - (t @ r)[..., None] * t, axis=-1) < 2e-3)


def beam_reference(direction: ArrayLike, angle: float) -> Vector:
    """Return the direction of the web of a beam: upwards, turned by an angle about its axis [rad].

    The axis points to +x, or to +y where it has no x.
    """
    x, y, z = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    sign = -1.0 if x < -1e-9 or (abs(x) <= 1e-9 and y < 0.0) else 1.0
    return _turned(E_Z, (sign * x, sign * y, sign * z), angle)


def column_reference(angle: float) -> Vector:
    """Return the direction of the web of a column, at an angle from x towards y [rad]."""
    return _turned(E_X, E_Z, angle)


def _turned(vector: Vector, axis: Vector, angle: float) -> Vector:
    """Turn a vector by an angle about an axis, of which it has no part or that does not matter."""
    if angle == 0.0:
        return vector
    x, y, z = math.cos(angle) * np.array(vector) + math.sin(angle) * np.cross(axis, vector)
    return float(x), float(y), float(z)


@dataclass(frozen=True)
class Sections:
    """The sections of a mesh's `shell_parts` and `beam_parts`, in their order."""

    shells: tuple[ShellSection, ...]
    beams: tuple[BeamSection, ...]
