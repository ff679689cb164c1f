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
# # First steps
#
# What this notebook teaches: validate a case file, run it, read results by name, and plot impact
# forces, gaps and floor response spectra. The case is the template of `impactfem new`: two
# three-storey buildings as stick models, 2 cm apart.

# %% tags=["parameters"]
folder = "../runs/first_steps"  # of the case file and the run
changes = {}  # keys of the case with other values

# %%
from pathlib import Path

import matplotlib.pyplot as plt

import impactfem
from impactfem.case.template import write_new_case

case_file = Path(folder) / "towers.toml"
case_file.parent.mkdir(parents=True, exist_ok=True)
if not case_file.exists():
    write_new_case(case_file, minimal=True)

# %% [markdown]
# ## Validate
#
# `impactfem.load` reads a case file. `set` changes a key in memory; the file is not changed.
# `impactfem.check` validates all values and returns them in SI.

# %%
case = impactfem.load(case_file)
for key, value in changes.items():
    case.set(key, value)
values = impactfem.check(case)
print(values.title)
for building in values.buildings:
    mass = sum(floor.mass for floor in building.floors)
    print(f"{building.name}: {len(building.floors)} floors, {1e-3 * mass:.0f} t")

# %% [markdown]
# Invalid input raises `InputError` with all faults: file, key, value and expected value.

# %%
wrong = impactfem.load(case_file)
wrong.set("pounding.time_step", "0.3 kg").set("spectra.damping", ["500 %"])
try:
    wrong.check()
except impactfem.study.InputError as error:
    for fault in error.faults:
        print(fault)

# %% [markdown]
# ## Run
#
# `stage="pounding"` ends the run after the stick models. A stage with unchanged input is not
# computed again.

# %%
run = impactfem.run(case, out=Path(folder) / "run", stage="pounding")
print(run)

# %% [markdown]
# ## Results by name
#
# `value` returns a scalar result in SI. `table` selects results by patterns. `to_dataframe` returns
# all scalar results for pandas.

# %%
print(f"largest impact force: {1e-6 * run.value('pounding.main_impact_force'):.2f} MN")
print(run.table("pounding.impacts", "pounding.main_impact_*", "pounding.required*").as_text())

# %%
run.to_dataframe().filter(like="sticks.west.frequency", axis=0)[["value", "unit"]].head(6)

# %% [markdown]
# ## Plots
#
# A plot returns matplotlib axes. The gap of the decisive pair is negative during contact.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
run.plot.gap(ax=left)
run.plot.floor_spectrum("west", 3, ax=right)
plt.show()

# %% [markdown]
# ## Histories
#
# The stores of a run are xarray data sets with units: here the impact forces, positive in
# compression, 60 ms before and after the largest one.

# %%
force = run.forces["force"]
pair = str(force.max("time").idxmax("pair").values)
peak = float(force.sel(pair=pair).idxmax("time"))
near = force.sel(time=slice(peak - 0.06, peak + 0.06))
figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for name in near["pair"].values:
    axes.plot(1e3 * (near["time"] - peak), 1e-6 * near.sel(pair=name), label=str(name))
axes.set(xlabel=f"time after {peak:.3f} s [ms]", ylabel="impact force [MN]")
axes.legend()
plt.show()

# %%
run.close()
