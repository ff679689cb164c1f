"""Rayleigh damping as a table of its own curve: the same numbers in the stores of every stage."""

import shutil

import numpy as np
import pytest
import tomli_w
import xarray as xr

from impactfem.case import load_case
from impactfem.run import loop
from no_pictures import no_pictures
from two_models import BUILDINGS, DEVICE, WALL, write_case

FURTHER = """
[[damping_cases]]
name = "light"
ratio = "2 %"
frequencies = ["1 Hz", "20 Hz"]
[ensemble]
motions = 2
structure_motions = 2
"""
CALIBRATED = ('"5e8 N/m"\nrestitution = 0.5', '"calibrated"\nrestitution = "calibrated"')
NAMES = {"mass_coefficient", "stiffness_coefficient", "law_frequency", "law_ratio", "result_note"}
"""What says which law it is."""
BOUND = {"transfer_bound"}
"""The rigorous bound is known of Rayleigh damping alone."""
ROUNDING = {"complementarity", "imbalance", "energy_residual", "impulse_error"}
ROUNDING |= {"contact_energy_defect", "energy_gained"}
"""Residuals that are rounding themselves, and a small difference of large energies (2e-10).

Unilateral contact does no work, so the energy that it gains is rounding, too.
"""
BETWEEN = {"structural_damping", "largest_psa_damping"}
"""The damping ratio at the governing frequency, which is no point of the table."""
TIED = {"governing"}
"""Of two points as large up to rounding either governs; what they have is compared."""
SAME = 1e-10
"""Measured: at most 1.7e-11 (`impact_defect`), 1.0e-11 (`psa_band`), 9e-12 in all others."""


def frequencies(folder):
    """Of all modes that a stage damps: of the sticks, and of every model of the 3D building [Hz].

    A table has the law's own ratios at its points, and not between them.
    """
    with (
        xr.open_dataset(folder / "pounding.nc", engine="netcdf4") as sticks,
        np.load(folder / "reduce.npz") as models,
    ):
        names = [name for name in models.files if name.endswith("eigenvalue")]
        omega = [np.sqrt(np.maximum(models[name], 0.0)) for name in names]
        omega.append(2.0 * np.pi * sticks["mode_frequency"].values.ravel())
    every = np.concatenate(omega) / (2.0 * np.pi)
    return np.unique(every[every > 0.0])


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The folders of one case with Rayleigh damping, with its tables, and with 1 % more."""
    folder = tmp_path_factory.mktemp("laws")
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        path = write_case(folder, WALL, DEVICE, FURTHER)
        stick = BUILDINGS[0][: BUILDINGS[0].index("[buildings.structure]")]
        text = path.read_text(encoding="utf-8").replace(BUILDINGS[0], stick).replace(*CALIBRATED)
        path.write_text(text, encoding="utf-8")
        loop.run(path, out=folder / "rayleigh", stage="design")
        case, at = load_case(path), frequencies(folder / "rayleigh")
        laws = case.buildings[0].damping.law, case.damping_cases[0].law
        for name, factor, last in (("table", 1.0, "design"), ("more", 1.01, "pounding")):
            own, light = (
                {
                    "type": "table",
                    "points": [
                        [f"{f!r} Hz", factor * ratio]
                        for f, ratio in zip(at.tolist(), law.ratio(at).tolist(), strict=True)
                    ],
                }
                for law in laws
            )
            variant = {"extends": path.name, "damping": own}
            variant["damping_cases"] = [{"name": "light", **light}]
            file = folder / f"{name}.toml"
            file.write_text(tomli_w.dumps(variant), encoding="utf-8")
            # The vectors of the reduced building are the same: they do not depend on the damping.
            shutil.copytree(folder / "rayleigh", folder / name)
            loop.run(file, out=folder / name, stage=last)
    return folder


def differences(one, other):
    """The largest difference of each result of two stores, over its largest value."""
    found = {}
    with (
        xr.open_dataset(one, engine="netcdf4") as store,
        xr.open_dataset(other, engine="netcdf4") as again,
    ):
        assert set(store.variables) == set(again.variables)
        excluded = ROUNDING | BETWEEN
        for name in set(store.variables) - NAMES - BOUND - TIED - excluded:
            a, b = store[name].values, again[name].values
            if name == "result_value":
                # Each for itself: they have units of their own.
                for scalar, x, y in zip(store["result"].values, a, b, strict=True):
                    if np.isfinite(x) and not excluded & {scalar, scalar.rpartition(".")[2]}:
                        found[scalar] = abs(y - x) / (abs(x) or 1.0)
                continue
            if a.dtype.kind != "f":
                found[name] = 0.0 if np.array_equal(a, b) else np.inf
                continue
            assert np.array_equal(np.isfinite(a), np.isfinite(b)), name
            a, b = a[np.isfinite(a)], b[np.isfinite(b)]
            apart = np.abs(b - a)
            if a.dtype == np.float32:  # which may be rounded to neighbours where they are equal
                apart = np.maximum(apart - np.spacing(np.abs(a)), 0.0)
            found[name] = apart.max(initial=0.0) / (np.abs(a).max(initial=0.0) or 1.0)
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    "store",
    ["calibrate", "pounding", "transient", "transient_maps", "device", "ensemble", "design"],
)
def test_rayleigh_as_a_table_of_its_own_curve(runs, store):
    found = differences(*(runs / name / f"{store}.nc" for name in ("rayleigh", "table")))
    assert len(found) > 5 and max(found.values()) < SAME, max(found, key=found.__getitem__)


@pytest.mark.slow
@pytest.mark.parametrize("store", ["calibrate", "pounding"])
def test_one_per_cent_more_damping_is_seen(runs, store):
    found = differences(*(runs / name / f"{store}.nc" for name in ("rayleigh", "more")))
    assert max(one for one in found.values() if np.isfinite(one)) > 1e-4


@pytest.mark.slow
def test_the_law_of_each_run(runs):
    """The second one has no coefficients, and no rigorous bound."""
    for name, finite in (("rayleigh", True), ("table", False)):
        with xr.open_dataset(runs / name / "transient.nc", engine="netcdf4") as store:
            assert np.isfinite(store["transfer_bound"]).any() == finite
        with xr.open_dataset(runs / name / "device.nc", engine="netcdf4") as store:
            assert np.isfinite(store["stiffness_coefficient"]).all() == finite
