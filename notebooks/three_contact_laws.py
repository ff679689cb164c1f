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
# # Three contact laws
#
# What this notebook teaches: run variants of one case, and compare impact forces and floor spectra.
# The variants are three penalty laws with a restitution coefficient of 0.65:
#
# - `kelvin-voigt`: linear spring and dashpot; the force begins with a jump,
# - `hunt-crossley`: Hertz stiffness; the damping grows with the penetration,
# - `jankowski`: Hertz stiffness; the damping acts during the approach only.

# %% tags=["parameters"]
folder = "../runs/three_contact_laws"  # of the case file and the runs
changes = {}  # keys of the case with other values

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

import impactfem
from impactfem.case.template import write_new_case

case_file = Path(folder) / "towers.toml"
case_file.parent.mkdir(parents=True, exist_ok=True)
if not case_file.exists():
    write_new_case(case_file, minimal=True)

# %% [markdown]
# ## The runs
#
# The Hertz stiffness is that of the template. The linear stiffness gives the same elastic force at
# a penetration of 5 mm, which is about that of the main impact.

# %%
hertz = 2.75e9  # N/m^1.5
linear = hertz * 0.005**0.5  # N/m
damped = {"stiffness": f"{hertz:.3g} N/m^1.5", "restitution": 0.65, "relation": "exact"}
laws = {
    "kelvin-voigt": {"stiffness": f"{linear:.3g} N/m", "restitution": 0.65},
    "hunt-crossley": damped,
    "jankowski": damped,
}
runs = {}
for name, law in laws.items():
    case = impactfem.load(case_file).set("contact_laws.floor", {"type": name, **law})
    for key, value in changes.items():
        case.set(key, value)
    runs[name] = impactfem.run(case, out=Path(folder) / name, stage="pounding", draw=False)

# %% [markdown]
# ## Results

# %%
rows = {
    name: {
        "impacts": run.value("pounding.impacts"),
        "peak force [MN]": 1e-6 * run.value("pounding.main_impact_force"),
        "duration [ms]": 1e3 * run.value("pounding.main_impact_duration"),
        "impulse [kN s]": 1e-3 * run.value("pounding.main_impact_impulse"),
        "restitution [-]": run.value("pounding.main_impact_restitution"),
        "PFA west, floor 3 [m/s²]": float(run.pounding["pfa"].sel(station="west.floor_3").max()),
    }
    for name, run in runs.items()
}
pd.DataFrame(rows).round(3)

# %% [markdown]
# ## The main impact
#
# The dashpot of the linear law acts from the first touch to the last: its force begins with a jump
# and ends in tension. Jankowski's force also rises steeply.

# %%
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, run in runs.items():
    force = run.forces["force"]
    pair = str(force.max("time").idxmax("pair").values)
    peak = float(force.sel(pair=pair).idxmax("time"))
    near = force.sel(pair=pair, time=slice(peak - 0.06, peak + 0.06))
    first = float(near["time"][(near.values > 0.0).argmax()])
    axes.plot(1e3 * (near["time"] - first), 1e-6 * near, label=f"{name}, {pair}")
axes.set(xlabel="time after the first touch [ms]", ylabel="impact force [MN]", xlim=(-10, 100))
axes.legend(fontsize=8)
plt.show()

# %% [markdown]
# ## Floor spectra
#
# The laws agree below 8 Hz. Above 30 Hz the two laws with a steep onset give higher spectra.

# %%
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, run in runs.items():
    store = run.pounding.sel(station="west.floor_3", direction="y").isel(damping=0)
    axes.semilogx(store["frequency"], store["psa"], label=name)
axes.semilogx(store["frequency"], store["psa_free"], "k--", label="without impact")
axes.set(xlabel="frequency [Hz]", ylabel="pseudo-acceleration [m/s²]")
axes.set_title(f"west, floor 3, y, {100 * float(store['damping']):g} % damping")
axes.legend()
plt.show()

# %%
for run in runs.values():
    run.close()
