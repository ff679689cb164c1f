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
# # Your own building and record
#
# What this notebook teaches: describe a building by tables, read a recorded ground motion, write
# the case file, and compute floor spectra of the 3D building next to a neighbour. The building is
# a three-storey frame with four walls.

# %% tags=["parameters"]
folder = "../runs/own_building"  # of all files
record = ""  # a record: AT2, ESM, COSMOS, CSMIP, K-NET or CSV; a stand-in is written if empty
mesh_size = 1.0  # of the elements [m]
duration = 6.0  # of the computation [s]
highest = 100.0  # largest frequency of the 3D model [Hz]

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import impactfem

place = Path(folder)
place.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The building
#
# The plan is 9 m by 6 m, with x along the longer side. Positions in the tables are counted from a
# corner of the plan. Beams have a level of their axis below the mid-plane of the slab (offset).

# %%
tables = {
    "walls.csv": """wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [m]
west,1-3,0,2,0,4,0.2
east,1-3,9,2,9,4,0.2
south,1-3,3.5,0,5.5,0,0.2
north,1-3,3.5,6,5.5,6,0.2
""",
    "columns.csv": """column,storeys,x [m],y [m],width_x [m],width_y [m]
south_west,1-3,0,0,0.4,0.4
south_east,1-3,9,0,0.4,0.4
north_west,1-3,0,6,0.4,0.4
north_east,1-3,9,6,0.4,0.4
""",
    "beams.csv": """beam,floors,x1 [m],y1 [m],x2 [m],y2 [m],width [m],depth [m],offset [m]
west,1-3,0,0,0,6,0.3,0.3,-0.25
east,1-3,9,0,9,6,0.3,0.3,-0.25
south,1-3,0,0,9,0,0.3,0.3,-0.25
north,1-3,0,6,9,6,0.3,0.3,-0.25
""",
}
for name, text in tables.items():
    (place / name).write_text(text)

# %% [markdown]
# ## The floor table
#
# One row for each floor: its mass with moments of inertia, and the section of the storey below it.
# Here the mass is 1 t/m². The sections are start values, changed by the calibration below so that
# the stick has the first frequency of the 3D model.

# %%
length, width, mass = 9.0, 6.0, 54.0  # m, m, t
inertia = mass / 12.0 * np.array([width**2, length**2, length**2 + width**2])  # t m2
row = ",".join(f"{value:.4g}" for value in (mass, *inertia, 1.5, 1.5, 3.0, 2.2, 0.67, 0.67))
head = (
    "floor,mass [t],Jx [t m2],Jy [t m2],Jz [t m2],Ix [m4],Iy [m4],Iz [m4],A [m2],Avy [m2],Avx [m2]"
)
rows = [f"{floor},{row},3.2" for floor in (1, 2, 3)]
(place / "floors.csv").write_text("\n".join([f"{head},storey_height [m]", *rows]) + "\n")
targets = "building,mode,frequency [Hz],effective_mass [t]\nmine,1,3,100\n"
count = (place / "targets.csv").write_text(targets)

# %% [markdown]
# ## The record
#
# No record is shipped. Without a file of yours, this cell writes noise between 0.5 and 15 Hz in the
# AT2 format. It is not a record of an earthquake.

# %%
if record:
    file = Path(record).resolve()
else:
    step, n = 0.005, 2 * round(duration / 0.01)
    frequency = np.fft.rfftfreq(n, step)
    noise = np.fft.rfft(np.random.default_rng(7).standard_normal(n))
    noise[(frequency < 0.5) | (frequency > 15.0)] = 0.0
    motion = np.fft.irfft(noise, n) * np.sin(np.pi * np.arange(n) / n) ** 2
    motion *= 0.35 / np.abs(motion).max()  # g
    file = (place / "stand_in.AT2").resolve()
    lines = ["".join(f"{a:15.7E}" for a in motion[k : k + 5]) for k in range(0, n, 5)]
    units = "ACCELERATION TIME SERIES IN UNITS OF G"
    title = "STAND-IN, NOISE FROM 0.5 TO 15 HZ, NOT A RECORD OF AN EARTHQUAKE"
    file.write_text("\n".join([title, "", units, f"NPTS= {n}, DT= {step:.4f} SEC", *lines]) + "\n")
print(file.name)

# %% [markdown]
# ## The case file
#
# The neighbour has the same floors on softer storeys and is a stick.

# %%
case_text = f"""
title = "A frame of three storeys and its softer neighbour"

[materials.concrete]
young_modulus = "33 GPa"
poisson_ratio = 0.2
density = "2500 kg/m3"

[damping]
ratio = "5 %"
frequencies = ["1 Hz", "20 Hz"]

[[buildings]]
name = "mine"
material = "concrete"
floors = "floors.csv"
axis = ["4.5 m", "3 m"]
length = "9 m"
width = "6 m"
rigid_below = "0.4 m"
rigid_above = "0.1 m"

[buildings.structure]
storey_stiffness_factor = 0.5           # cracked walls and columns
floor_masses = true                     # the 3D model has the masses of the floor table
modes = 6
[buildings.structure.mesh]
type = "generated"
length = "9 m"
width = "6 m"
slab_thickness = "20 cm"
walls = "walls.csv"
columns = "columns.csv"
beams = "beams.csv"
impact_edge = "y+"
size = "{mesh_size} m"

[[buildings]]
name = "neighbour"
material = "concrete"
floors = "floors.csv"
axis = ["4.5 m", "9.01 m"]
length = "9 m"
width = "6 m"
rigid_below = "0.4 m"
rigid_above = "0.1 m"
second_moment_factor = 0.1

[calibration]                           # the stick gets the first mode of the 3D model
targets = "targets.csv"
from_structure = true
direction = "y"
stiffness_factor = [0.05, 5.0]
rigid_depth = "0.5 m"
height = "9.6 m"
starts = 2

[transient]
time_step = "1 ms"
duration = "{duration} s"
maximum_frequency = "{highest} Hz"
[[transient.probes]]
name = "corner"
point = ["9 m", "6 m", "9.6 m"]

[[motions]]
direction = "y"
type = "record"
file = "{file}"

[contact_laws.slabs]
type = "hunt-crossley"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65
relation = "exact"

[[contacts]]
a = {{ building = "mine", floor = [1, 2, 3], offset = ["0 m", "3 m", "0 m"] }}
b = {{ building = "neighbour", floor = [1, 2, 3], offset = ["0 m", "-3 m", "0 m"] }}
normal = [0, 1, 0]
gap = "1 cm"
law = "slabs"

[pounding]
time_step = "0.25 ms"
duration = "{duration} s"

[spectra]
damping = ["5 %"]
frequencies = {{ minimum = "0.5 Hz", maximum = "{highest} Hz", per_decade = 30 }}
"""
case_file = place / "own_building.toml"
case_file.write_text(case_text)
case = impactfem.check(case_file, mesh=True)
print(f"{case.title}: valid")

# %% [markdown]
# ## The run

# %%
run = impactfem.run(case_file, out=place / "run", stage="transient", bar=False)
print(run.table("building.frequency.1", "pounding.impacts", "pounding.main_impact_force").as_text())

# %% [markdown]
# ## Floor spectra
#
# The stick gives the mass centre only. Above 15 Hz the 3D floor has higher spectra than the stick.

# %%
axes = run.plot.floor_spectrum("mine", 3)
transient = run.transient
for probe in ("edge_3", "corner"):
    psa = transient["psa"].sel(probe=probe, component="y").isel(damping=0)
    axes.plot(psa["frequency"], psa, label=f"3D model, {probe}")
axes.legend()
plt.show()

# %% [markdown]
# ## Peak floor accelerations

# %%
run.plot.building("pfa", direction="y")
plt.show()

# %%
run.close()
