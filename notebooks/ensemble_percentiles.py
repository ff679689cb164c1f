# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Percentiles of an ensemble
#
# What this notebook teaches: compute many ground motions of the same kind, and take percentiles of
# floor spectra, impact forces and the required gap. One motion is one sample: a design value needs
# several. The case is the template of `impactfem new`, with stick models.

# %% tags=["parameters"]
folder = "../runs/ensemble_percentiles"  # of the case file and the run
motions = 12  # number of synthetic motions
changes = {}  # keys of the case with other values

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import impactfem
from impactfem.case.template import write_new_case

case_file = Path(folder) / "towers.toml"
case_file.parent.mkdir(parents=True, exist_ok=True)
if not case_file.exists():
    write_new_case(case_file, minimal=True)

# %% [markdown]
# ## The run
#
# `[ensemble]` repeats the stick models with other seeds of the synthetic motion. The motions match
# the same design spectrum.

# %%
case = impactfem.load(case_file).set("ensemble", {"motions": motions})
for key, value in changes.items():
    case.set(key, value)
run = impactfem.run(case, out=Path(folder) / "run", stage="ensemble", draw=False)
ensemble = run.ensemble
print(f"{ensemble.sizes['motion']} motions; percentiles {ensemble['percentile'].values} %")

# %% [markdown]
# ## Floor spectrum
#
# Thin lines are single motions. The band reaches from the 16th to the 84th percentile.

# %%
here = {"station": "west.floor_3", "direction": "y"}
spectra = ensemble[["psa", "psa_percentile", "psa_free_percentile"]].sel(here).isel(damping=0)
f = spectra["frequency"]
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.semilogx(f, spectra["psa"].transpose("frequency", "motion"), color="0.8", lw=0.6)
for name, colour, label in (
    ("psa_percentile", "#D55E00", "with impact"),
    ("psa_free_percentile", "#0072B2", "without impact"),
):
    band = spectra[name]
    axes.fill_between(f, band.sel(percentile=16), band.sel(percentile=84), color=colour, alpha=0.3)
    axes.semilogx(f, band.sel(percentile=50), color=colour, label=f"median {label}")
axes.set(xlabel="frequency [Hz]", ylabel="pseudo-acceleration [m/s²]", title="west, floor 3, y")
axes.legend()
plt.show()

# %% [markdown]
# ## Impact force and required gap
#
# Each scalar result has a value for each motion. Squares are the 16th, 50th and 84th percentiles.

# %%
values = ensemble["value"].to_pandas()
figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
for panel, name, factor, label in (
    (panels[0], "pounding.main_impact_force", 1e-6, "largest impact force [MN]"),
    (panels[1], "pounding.required_separation", 1e3, "required gap [mm]"),
):
    ordered = np.sort(factor * values[name].dropna())
    share = 100.0 * (np.arange(len(ordered)) + 0.5) / len(ordered)
    panel.plot(ordered, share, "o-", ms=3)
    for percentile in (16, 50, 84):
        value = np.percentile(ordered, percentile)
        panel.plot(value, percentile, "s", color="#D55E00")
        print(f"{label}, {percentile}th percentile: {value:.3g}")
    panel.set(xlabel=label, ylabel="share of the motions [%]")
plt.show()

# %%
run.close()
