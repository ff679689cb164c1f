"""The scalar results of the stage `transient`, by the names of `summary.json`."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from impactfem.building.floor import floor_bar
from impactfem.stages.transient.compute import TransientStudy
from impactfem.stages.transient.selection import known, of_kind
from impactfem.system.scalar import Scalar

DIFFERENCE = "error of the transfer functions at the probes, by nested models"


def transient_scalars(
    study: TransientStudy, store: xr.Dataset, maps: xr.Dataset | None
) -> list[Scalar]:
    """All scalars of the stage; spectra at the first damping, along the shown direction.

    Args:
        study: The stage's results.
        store: The content of `transient.nc`.
        maps: That of `transient_maps.nc`; None without.
    """
    d, mesh = str(store.attrs["shown_direction"]), study.prepared.parts.mesh
    response = store.isel(damping=0).sel(component=d)
    scalars = _solver(study, store)
    for kind in ("centre", "edge"):
        probes = of_kind(response, kind)
        for k, number in enumerate(probes["probe_floor"].values):
            one, floor = probes.isel(probe=k), f"floor_{number}"
            pfa = float(one["pfa"])
            if kind == "centre":
                displacement = float(abs(one["displacement"]).max())
                scalars += [
                    Scalar(f"transient.frs.{floor}.peak", float(one["psa"].max()), "m/s2"),
                    Scalar(
                        f"transient.frs.{floor}.peak_frequency", float(one["psa"].idxmax()), "Hz"
                    ),
                    Scalar(f"transient.pfa.{floor}", pfa, "m/s2"),
                    Scalar(f"transient.displacement.{floor}", displacement, "m"),
                ]
                continue
            name = f"transient.pfa.edge_{number}"
            scalars.append(Scalar(name, pfa, "m/s2", "middle of the impact edge"))
            if maps is not None:
                on_edge = np.isin(maps["node_number"], np.unique(mesh.edges[int(number)]))
                along, note = maps["pfa"].sel(component=d)[on_edge], "vertices of the impact edge"
                scalars += [
                    Scalar(f"{name}.mean", float(along.mean()), "m/s2", note),
                    Scalar(f"{name}.max", float(along.max()), "m/s2", note),
                ]
    return [*scalars, *_waves(study)]


def _solver(study: TransientStudy, store: xr.Dataset) -> list[Scalar]:
    spectra = study.spectra
    finer = (
        f"of the highest frequency after up-sampling: {spectra.method}, histories made "
        f"{spectra.upsampling_factor} times finer for the spectra"
    )
    impulse = study.prepared.loads.impulse_error
    scalars = [
        Scalar("transient.impulse_error", impulse, "-", "of the resampling"),
        Scalar("transient.points_per_cycle", spectra.points_per_cycle, "-", finer),
    ]
    if study.basis is not None:
        good, highest = known(store), float(store.attrs["maximum_frequency"])
        moved = good["psa"] > 1e-3 * store["psa"].max()
        share = float((good["psa_band"] / good["psa"]).where(moved).max().fillna(0.0))
        note = f"up to {highest:g} Hz, where it is above a thousandth of the largest one"
        scalars += [
            Scalar("transient.basis_vectors", float(len(study.basis.model.eigenvalue)), "-"),
            Scalar("transient.basis_difference", study.basis.difference, "-", DIFFERENCE),
            Scalar("transient.band_max", share, "-", note),
        ]
    if study.full is not None:
        residual = study.full.energy.residual
        scalars.append(Scalar("transient.energy_residual", residual, "-", "of the full model"))
    if study.full_error is not None:
        note = "largest relative difference of a spectrum, both by Newmark at the same step"
        scalars.append(Scalar("transient.reduced_against_full", study.full_error, "-", note))
    return scalars


def _waves(study: TransientStudy) -> list[Scalar]:
    """What the model gives for waves by hand: the floor as a bar, and the slab's bare material."""
    parts, floor = study.prepared.parts, study.case.wave_floor
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
