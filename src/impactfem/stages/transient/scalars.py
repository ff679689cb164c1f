"""The scalar results of the stage `transient`, by the names of `summary.json`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from impactfem.building.floor import floor_bar
from impactfem.stages.transient.compute import TransientStudy
from impactfem.system.scalar import Scalar

Array = NDArray[np.float64]

DIFFERENCE = "error of the transfer functions at the probes, by nested models"


def transient_scalars(study: TransientStudy) -> list[Scalar]:
    """All scalars of the stage; spectra at the first damping, along the shown direction."""
    return [*_solver(study), *_floors(study), *_edges(study), *_waves(study)]


def shown_direction(study: TransientStudy) -> int:
    """Component of the first ground motion."""
    return "xyz".index(study.case.shown_direction)


def _solver(study: TransientStudy) -> list[Scalar]:
    spectra = study.spectra
    finer = (
        f"of the highest frequency after up-sampling: {spectra.method}, histories made "
        f"{spectra.upsampling_factor} times finer for the spectra"
    )
    scalars = [
        Scalar("transient.impulse_error", study.loads.impulse_error, "-", "of the resampling"),
        Scalar("transient.points_per_cycle", spectra.points_per_cycle, "-", finer),
    ]
    if study.basis is not None:
        known = spectra.frequency <= _highest(study)
        psa, band = study.psa[..., known], study.band[..., known]
        moved = psa > 1e-3 * study.psa.max()
        share = band[moved] / psa[moved]
        note = f"up to {_highest(study):g} Hz, where it is above a thousandth of the largest one"
        scalars += [
            Scalar("transient.basis_vectors", float(len(study.basis.model.eigenvalue)), "-"),
            Scalar("transient.basis_difference", study.basis.difference, "-", DIFFERENCE),
            Scalar("transient.band_max", float(share.max(initial=0.0)), "-", note),
        ]
    if study.full is not None:
        residual = study.full.energy.residual
        scalars.append(Scalar("transient.energy_residual", residual, "-", "of the full model"))
    if study.full_error is not None:
        note = "largest relative difference of a spectrum, both by Newmark at the same step"
        scalars.append(Scalar("transient.reduced_against_full", study.full_error, "-", note))
    return scalars


def _highest(study: TransientStudy) -> float:
    transient = study.case.transient
    return transient.maximum_frequency if transient is not None else math.inf


def _floors(study: TransientStudy) -> list[Scalar]:
    """Floor response spectra at the mass centres."""
    c, frequency = shown_direction(study), study.spectra.frequency
    scalars = []
    for index, probe in enumerate(study.probes):
        if probe.kind != "centre":
            continue
        psa, floor = study.psa[0, index, c], f"floor_{probe.floor}"
        displacement = float(np.abs(study.response.displacement[:, index, c]).max())
        at = float(frequency[psa.argmax()])
        scalars += [
            Scalar(f"transient.frs.{floor}.peak", float(psa.max()), "m/s2"),
            Scalar(f"transient.frs.{floor}.peak_frequency", at, "Hz"),
            Scalar(f"transient.pfa.{floor}", float(study.pfa[index, c]), "m/s2"),
            Scalar(f"transient.displacement.{floor}", displacement, "m"),
        ]
    return scalars


def _edges(study: TransientStudy) -> list[Scalar]:
    """Peak accelerations at the middle of each impact edge, and along all of it."""
    c = shown_direction(study)
    scalars = []
    for probe, pfa in zip(study.probes, study.pfa[:, c], strict=True):
        if probe.kind != "edge":
            continue
        name = f"transient.pfa.edge_{probe.floor}"
        scalars.append(Scalar(name, float(pfa), "m/s2", "middle of the impact edge"))
        if study.maps is not None:
            edge = np.unique(study.parts.mesh.edges[probe.floor])
            along = study.maps.pfa[np.isin(study.maps.nodes, edge), c]
            scalars += [
                Scalar(f"{name}.mean", float(along.mean()), "m/s2", "vertices of the impact edge"),
                Scalar(f"{name}.max", float(along.max()), "m/s2", "vertices of the impact edge"),
            ]
    return scalars


def _waves(study: TransientStudy) -> list[Scalar]:
    """What the model gives for waves by hand: the floor as a bar, and the slab's bare material."""
    parts, floor = study.parts, study.case.wave_floor
    slab = parts.slab_material(floor)
    E, nu, rho = slab.E, slab.nu, slab.rho
    scalars = [
        Scalar(
            "transient.wave_speed",
            math.sqrt(E / (2.0 * rho * (1.0 + nu))),
            "m/s",
            "of the material, from the inputs: shear waves (equation 8 of Bodnar et al. 2022)",
        ),
        Scalar(
            "transient.plate_wave_speed",
            math.sqrt(E / (rho * (1.0 - nu**2))),
            "m/s",
            "of the material, from the inputs: waves normal to the edge of a bare plate",
        ),
    ]
    if floor in parts.mesh.edges:
        bar = floor_bar(parts, floor, 1 - parts.mesh.edge_axis(floor))
        note = f"√(EA'/m') of floor {floor} across: slab and beams, with the added mass"
        scalars += [
            Scalar("transient.loaded_wave_speed", bar.speed, "m/s", note),
            Scalar("transient.loaded_wave_crossing", bar.crossing, "s", f"by {note}"),
        ]
    return scalars
