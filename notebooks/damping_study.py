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
# # The damping study
#
# What this notebook teaches: to sweep a key of a case file from Python, here the damping of the
# buildings, and to compare the damping cases of a case up to the force on the anchors of a device,
# as section 5.3 of the paper does. The detailed force, of the device in the 3D building, stands
# beside that of a response spectrum analysis (RSA) with the floor spectrum.
#
# The second part runs all stages up to the device. For the paper's case that takes some minutes,
# unless its run (`scripts/run`) is there already: then it is read.

# %% tags=["parameters"]
case_file = "../geometry/npp_pair.toml"  # the case, with [[devices]] and [[damping_cases]]
run_folder = "../runs/npp_pair"  # its run; what is there already is reused
sweep_folder = "../runs/damping_sweep"  # where the sweep goes
ratios = ["3 %", "5 %", "7 %", "9 %"]  # damping ratios of the sweep

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from impactfem import study
from impactfem.study import open_run
from impactfem.system import log

log.set_up(verbose=False)
case = study.check(Path(case_file))
first = case.buildings[0]
top = max(floor.floor for floor in first.floors)
print(f"{case.title}; floor {top} of {first.name} is looked at")

# %% [markdown]
# ## A sweep of the sticks
#
# Rayleigh damping $C = \alpha M + \beta K$ has the ratio that is asked at two frequencies.
# `study.sweep` writes a case for each value, runs it, and gathers the results in one table;
# finished stages are reused when it is run again. The contact law stays the same here, so that
# only the buildings' own damping changes.

# %%
shown = [
    f"pounding.peak_force.floor_{top}",
    f"frs.floor_{top}.pfa",
    f"frs.floor_{top}.peak",
    "pounding.required_separation",
]
swept = study.sweep(
    Path(case_file), {"damping.ratio": ratios}, stage="pounding", out=Path(sweep_folder), show=shown
)
for text in swept.table.texts(swept.shown, width=140):
    print(text)

# %%
xi = 100.0 * swept.table.values["damping.ratio"].to_numpy(dtype=float)  # %
force, pfa, peak, _ = (swept.table.results[name].to_numpy(dtype=float) for name in shown)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
left.plot(xi, 1e-6 * force, "o-")
left.set(xlabel="damping ratio [%]", ylabel=f"largest impact force on floor {top} [MN]")
right.plot(xi, pfa, "o-", label="peak acceleration")
right.plot(xi, peak, "s--", label="peak of the floor spectrum")
right.set(xlabel="damping ratio [%]", ylabel=f"acceleration of floor {top} [m/s²]")
right.legend()
for panel in (left, right):
    panel.set_ylim(0.0, 1.1 * panel.dataLim.y1)
    panel.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ## The damping cases and the device
#
# The section `[[damping_cases]]` names dampings for which the whole study is repeated: restitution
# of the contact, impact forces of the sticks, the 3D building in time, the device. One reduced
# basis of the 3D building serves them all, as it does not depend on the damping.

# %%
done = study.run(Path(case_file), out=Path(run_folder), stage="device")
run = open_run(done.folder)
device = run.device
names = [str(name) for name in device.case.values]
print("damping cases:", ", ".join(names))

# %% [markdown]
# The ratio that Rayleigh damping has over the frequency, $\xi(f) = \alpha / (4 \pi f) + \pi f
# \beta$. Shock waves have frequencies far above those at which a ratio is usually chosen: there
# the stiffness part rules.

# %%
f = np.geomspace(0.5, 200.0, 200)  # Hz
styles = ("-", "--", "-.", ":")
figure, axes = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
for k, name in enumerate(names):
    alpha = float(device.mass_coefficient.sel(case=name))  # 1/s
    beta = float(device.stiffness_coefficient.sel(case=name))  # s
    ratio = alpha / (4.0 * np.pi * f) + np.pi * f * beta
    axes.loglog(f, 100.0 * ratio, styles[k % 4], label=name)
axes.set(xlabel="frequency [Hz]", ylabel="damping ratio [%]", title="damping of the buildings")
axes.grid(alpha=0.3, which="both")
axes.legend()
plt.show()

# %% [markdown]
# ## Force on the anchors
#
# Largest absolute force of the device on the floor along the first ground motion, without and with
# the impacts: in detail, and by response spectrum analysis of the device with the spectrum at its
# anchor.

# %%
direction = device.attrs["shown_direction"]
choice = device.attrs["headline"]
name = str(device.device.values[0])
there = {"device": name, "component": direction}
detailed = device.largest_force.sel(there)  # case, impact [N]
by_spectrum = device.spectrum_force.sel(**there, choice=choice)

print(f"{name}, force along {direction} [kN]; difference of RSA from the detailed force [%]")
print(f"{'damping':>14} {'ε':>6} {'impacts':>8} {'detailed':>9} {'RSA':>7} {'difference':>10}")
for one in names:
    for impact in device.impact.values:
        D = float(detailed.sel(case=one, impact=impact))
        R = float(by_spectrum.sel(case=one, impact=impact))
        epsilon = float(device.epsilon.sel(case=one))
        told = f"{epsilon:6.3f}" if np.isfinite(epsilon) else "   law"
        difference = 100.0 * (D - R) / D
        print(f"{one:>14} {told} {impact!s:>8} {1e-3 * D:9.2f} {1e-3 * R:7.2f} {difference:10.1f}")

# %%
places = np.arange(len(names))
figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
for panel, impact in zip(panels, device.impact.values, strict=True):
    panel.bar(
        places - 0.2, 1e-3 * detailed.sel(impact=impact), 0.4, label="detailed", color="#0072B2"
    )
    panel.bar(
        places + 0.2,
        1e-3 * by_spectrum.sel(impact=impact),
        0.4,
        label=f"RSA, {choice.upper()}",
        color="#E69F00",
        hatch="//",
        edgecolor="white",
    )
    panel.set_xticks(places, names, rotation=20, ha="right")
    panel.set(ylabel=f"force on the anchor along {direction} [kN]", title=f"{impact} impacts")
figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
plt.show()

# %% [markdown]
# ## In time
#
# The same force around the main impact. Light damping makes the impact harder, as the restitution
# is higher, and lets the waves in the floor ring longer.

# %%
start = float(np.atleast_1d(run.transient.attrs["main_impact"])[0])
around = {"time": slice(start - 0.05, start + 0.3)}
figure, axes = plt.subplots(figsize=(8, 3.6), layout="constrained")
for k, one in enumerate(names):
    history = device.force.sel(**there, **around, case=one, impact="with")
    axes.plot(1e3 * (history.time - start), 1e-3 * history, styles[k % 4], lw=1.0, label=one)
axes.set(
    xlabel=f"time after {start:.3f} s [ms]",
    ylabel=f"force on the anchor along {direction} [kN]",
    title=f"{name}, with impacts",
)
axes.grid(alpha=0.3)
axes.legend()
plt.show()

# %%
run.close()
