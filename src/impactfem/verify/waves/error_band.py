"""The error band of the reduced model against the error it has: the shipped frame."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from impactfem.building.shell_model import petsc_matrix
from impactfem.dynamics.damping import Rayleigh
from impactfem.spectra import response_spectra
from impactfem.verify.row import Row
from impactfem.verify.waves.frame_loads import Frame, shipped_frame
from impactfem.verify.waves.shell_motion import ReducedMotion

if TYPE_CHECKING:
    from impactfem.reduction.effectivity import Effectivity

Array = NDArray[np.float64]

NAME = "frame under short pulses, error band of the reduced model"
STEP, END = 0.5e-3, 0.4
PULSE = 0.006
SHIFT = 60.0
VECTORS = (54, 66, 78, 90)
"""Of the bases: from poor ones to good ones."""
LIGHTER = 0.2
"""β of the second damping over that of the case."""
FREQUENCY: Array = np.asarray(np.geomspace(2.0, 250.0, 100), dtype=np.float64)
ENOUGH = 0.95
"""Least share of the thirds of octaves at which band over error is between 1 and 10."""
SOURCE = "the full model with the same step; maxima within thirds of octaves"


def band_on_frame() -> list[Row]:
    """Spectra of the edges by three bases and two dampings: band over true error.

    Counted are thirds of octaves with an error above a ten-thousandth of the spectrum.
    """
    from impactfem.reduction.effectivity import LEAST, MOST, together

    frame = shipped_frame()
    amplitudes = _amplitudes()
    own = frame.damping
    found: list[Effectivity] = []
    for damping in (own, Rayleigh(own.alpha, LIGHTER * own.beta)):
        truth = _spectra(frame.moving.full(amplitudes, STEP, damping).motion["acceleration"])
        for used, *larger in (_models(frame, vectors) for vectors in VECTORS):
            found.append(_of_one(used, larger, amplitudes, damping, truth))
    every = together(found)
    return [
        Row(
            NAME,
            f"share of {len(every.ratio)} errors of which the band is {LEAST:g} to {MOST:g} times,"
            f" {len(every.misses)} of them not held",
            1.0,
            every.good,
            "-",
            1.0 - ENOUGH,
            SOURCE,
            absolute=True,
        ),
        Row(
            NAME,
            "errors to be told, at least 1000 (yes = 1)",
            1.0,
            float(len(every.ratio) >= 1000),
            "-",
            0.0,
            SOURCE,
        ),
    ]


def _models(frame: Frame, vectors: int) -> list[ReducedMotion]:
    """The model of a basis, then those that it is nested in."""
    from impactfem.reduction.krylov import KrylovBasis
    from impactfem.reduction.larger_models import larger_models
    from impactfem.reduction.reduced import reduced_model

    moving = frame.moving
    K, M = petsc_matrix(moving.K), petsc_matrix(moving.M)
    with KrylovBasis(K, M, (2.0 * math.pi * SHIFT) ** 2) as basis:
        basis.add(moving.loads)
        while basis.size < vectors and basis.grow(1) > 0:
            pass
        models = [reduced_model(basis), *larger_models(basis)]
        rows = basis.rows(moving.probes)
    K.destroy()
    M.destroy()
    return [ReducedMotion(model, model.shapes(rows)) for model in models]


def _of_one(
    used: ReducedMotion,
    larger: list[ReducedMotion],
    amplitudes: Array,
    damping: Rayleigh,
    truth: Array,
) -> Effectivity:
    """Of the band that larger models tell of a model."""
    from impactfem.reduction.band import LARGER, SAFETY, WIDTH, spectrum_difference
    from impactfem.reduction.effectivity import effectivity

    psa, *others = (
        _spectra(one.motion(amplitudes, STEP, damping, "newmark")["acceleration"])
        for one in (used, *larger)
    )
    band = SAFETY[LARGER] * spectrum_difference(psa, others, FREQUENCY, WIDTH[LARGER])
    return effectivity(band, psa, truth, FREQUENCY)


def _spectra(acceleration: Array) -> Array:
    """Pseudo-acceleration at 5 % of each probe, shape (n_probes, n_frequencies)."""
    found = response_spectra(acceleration.T, STEP, FREQUENCY, [0.05], absolute=False)
    return np.asarray(found.psa[0], dtype=np.float64)


def _amplitudes() -> Array:
    """A pulse on each edge, 1 MN and half of it later, and a ground that shakes, (n_t, 3)."""
    time = STEP * np.arange(round(END / STEP) + 1)
    pulses = [
        size * np.sin(np.pi * np.clip((time - start) / PULSE, 0.0, 1.0)) ** 2
        for size, start in ((1e6, 0.1), (0.5e6, 0.2))
    ]
    ground = 2.0 * np.sin(np.pi * time / END) ** 2 * np.sin(2.0 * np.pi * 5.0 * time)
    return np.column_stack([*pulses, ground])
