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
# What this notebook teaches: to check a case file, to run it from Python, and to look at what came
# out. The case is that of two buildings which pound during an earthquake, as **stick models**: a
# mass for each floor, a Timoshenko beam for each storey, and a contact law between the facing
# floors. It takes some seconds; the 3D building comes in the other notebooks.

# %% tags=["parameters"]
case_file = "../geometry/npp_pair.toml"  # the case
folder = "../runs/first_steps"  # where the results go

# %%
from pathlib import Path

import matplotlib.pyplot as plt

from impactfem import study
from impactfem.study import open_run
from impactfem.system import log
from impactfem.system.errors import InputError

log.set_up(verbose=False)  # what the program says, as on the command line

# %% [markdown]
# ## Check
#
# `study.check` reads the case file and all that it names, and computes nothing. What comes back
# holds every value in SI.

# %%
case = study.check(Path(case_file))
print(case.title)
for building in case.buildings:
    mass = sum(floor.mass for floor in building.floors)
    print(f"building {building.name}: {len(building.floors)} floors, {mass / 1e3:.0f} t")
for name, law in case.contact_laws.items():
    print(f"contact law {name}: {law.type}, stiffness {law.stiffness:.3g} N/m")
gaps = sorted({contact.gap for contact in case.contacts})
print(f"{len(case.contacts)} contact pairs, gap {', '.join(f'{1e2 * gap:g} cm' for gap in gaps)}")
motion = case.motions[0]
print(f"ground motion along {motion.direction}: {motion.type}")

# %% [markdown]
# A case file with mistakes is refused, and every mistake is named at once. A case may also say
# only what differs from another one (`extends`); here two values are wrong on purpose.

# %%
Path(folder).mkdir(parents=True, exist_ok=True)
wrong = Path(folder) / "wrong.toml"
wrong.write_text(
    f'''extends = "{Path(case_file).resolve()}"
[pounding]
time_step = "0.3 kg"
[spectra]
damping = ["500 %"]
'''
)
try:
    study.check(wrong)
except InputError as error:
    for fault in error.faults:
        print(fault)

# %% [markdown]
# ## Run
#
# `study.run` runs the stages of the case up to the one that is named; the stage `pounding` is the
# pounding of the stick models. A second call with the same inputs reads what the first one has
# written.

# %%
done = study.run(Path(case_file), out=Path(folder) / "run", stage="pounding")
run = open_run(done.folder)
print("stores:", ", ".join(run.stores))

# %% [markdown]
# ## Results by name
#
# `summary.json` has every scalar result in SI units, with the published value where there is one.

# %%
top = max(case.buildings[0].floors, key=lambda floor: floor.floor).floor
print(
    run.table(
        "motion.pga",
        f"pounding.peak_force.floor_{top}",
        "pounding.main_impact_*",
        f"frs.floor_{top}.*",
        "pounding.required_separation",
    ).as_text()
)

# %% [markdown]
# ## Histories
#
# The stores are NetCDF files that xarray opens; their dimensions have names. First the force
# between the buildings: it is zero but for some milliseconds at each impact.

# %%
force = run.forces.force  # time, pair [N]
pair = str(force.max("time").idxmax("pair").values)
at = float(force.sel(pair=pair).idxmax("time"))

figure, (whole, close) = plt.subplots(1, 2, figsize=(10, 3.2), layout="constrained")
touched = [str(name) for name in force.pair.values if force.sel(pair=name).any()]
for name in reversed(touched):
    whole.plot(force.time, 1e-6 * force.sel(pair=name), lw=0.8, label=name)
whole.set(xlabel="time [s]", ylabel="impact force [MN]", title="contact pairs that touched")
whole.legend(fontsize=8)
main = force.sel(pair=pair, time=slice(at - 0.02, at + 0.02))
close.plot(1e3 * (main.time - at), 1e-6 * main, marker=".", ms=4)
close.set(
    xlabel=f"time after {at:.3f} s [ms]", ylabel="impact force [MN]", title=f"main impact, {pair}"
)
plt.show()
print(f"largest force {1e-6 * float(main.max()):.1f} MN between {pair} at {at:.3f} s")

# %% [markdown]
# ## Floor response spectra
#
# A floor response spectrum (FRS) gives, over the eigenfrequency of an oscillator that stands on
# the floor, its largest pseudo-acceleration: what a light device there has to bear. Names that end
# in `_free` belong to the run without contact. Pounding raises the spectrum at high frequencies.
# Near the first modes, where the buildings sway, it may even lower it: they hold each other up.

# %%
sticks = run.pounding
station = f"{case.buildings[0].name}.floor_{top}"
direction = sticks.attrs["shown_direction"]
damping = float(sticks.damping[0])
there = {"station": station, "direction": direction, "damping": damping}
psa, free = sticks.psa.sel(there), sticks.psa_free.sel(there)

figure, axes = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
axes.semilogx(psa.frequency, psa, color="#D55E00", label="with pounding")
axes.semilogx(free.frequency, free, color="#0072B2", ls="--", label="without")
axes.set(
    xlabel="frequency [Hz]",
    ylabel="pseudo-acceleration [m/s²]",
    title=f"{station}, along {direction}, damping {100 * damping:g} %",
)
axes.grid(alpha=0.3)
axes.legend()
plt.show()

above = psa.where(psa.frequency > 10.0, drop=True)
at = float(above.idxmax("frequency"))
print(f"peak above 10 Hz: {float(above.max()):.1f} m/s² at {at:.0f} Hz")
ratio = psa / free
at = float(ratio.idxmax("frequency"))
print(f"with pounding over without: {float(ratio.max()):.1f} at {at:.0f} Hz")

# %%
run.close()

# %% [markdown]
# ## Where to go next
#
# - `read_a_run.py` reads the 3D results of a finished run and draws two figures of the paper again.
# - `own_building.py` makes a case of your own: a building, a mesh and a record.
# - `damping_study.py` varies the damping, up to the force on the anchors of a pump.
# - `contact_law.py` brings in a contact law of your own.
