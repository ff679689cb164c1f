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
# What this notebook teaches: to describe a building, to make the mesh of its 3D model, to read a
# recorded ground motion, and to write the case file that leads from there to floor response
# spectra at points of the 3D building. The building is a frame of three storeys with a wall; a
# softer one stands beside it, and they pound.
#
# A mesh of any other program does as well, as long as its groups have the names of
# `docs/mesh-groups.md` (`geometry/two_frames.geo` is a script for gmsh); the cell that makes the
# mesh is then left out.

# %% tags=["parameters"]
folder = "../runs/own_building"  # where all files go
record = (
    ""  # a record of yours: AT2, ESM, COSMOS, CSMIP, K-NET or CSV; empty: a stand-in is written
)
mesh_size = 0.6  # of the elements [m]
duration = 10.0  # of what is computed [s]
highest = 200.0  # frequency up to which the 3D model is to be good [Hz]

# %%
import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from impactfem import study
from impactfem.building.generate import generate
from impactfem.building.geometry import Beam, Column, Geometry, MeshSize, Wall, storey_sections
from impactfem.study import open_run
from impactfem.system import log

log.set_up(verbose=False)
place = Path(folder)
place.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The building
#
# 9 m by 6 m in plan, x along the longer side; three floors. A short wall stands in the middle of
# each side, columns at the corners, beams between them. `Geometry` takes rectangular plans; slabs
# and walls are their mid-planes, the axis of a beam lies below its slab by the offset.

# %%
length, width = 9.0, 6.0  # m
levels = (0.0, 3.3, 6.4, 9.5)  # m: base and floors
slab = 0.20  # m
floors = (1, 2, 3)
frame = Geometry(
    length=length,
    width=width,
    levels=levels,
    slab_thickness=slab,
    walls=(
        Wall("west", floors, (0.0, 2.0), (0.0, 4.0), 0.2),
        Wall("east", floors, (length, 2.0), (length, 4.0), 0.2),
        Wall("south", floors, (3.5, 0.0), (5.5, 0.0), 0.2),
        Wall("north", floors, (3.5, width), (5.5, width), 0.2),
    ),
    beams=tuple(
        Beam(name, floors, start, end, 0.3, 0.5, -0.15)
        for name, start, end in (
            ("west", (0.0, 0.0), (0.0, width)),
            ("east", (length, 0.0), (length, width)),
            ("south", (0.0, 0.0), (length, 0.0)),
            ("north", (0.0, width), (length, width)),
        )
    ),
    columns=tuple(
        Column(name, floors, (x, y), 0.4, 0.4)
        for name, x, y in (
            ("south_west", 0.0, 0.0),
            ("south_east", length, 0.0),
            ("north_west", 0.0, width),
            ("north_east", length, width),
        )
    ),
    size=MeshSize.uniform(mesh_size),
)
generate(frame, place / "frame.msh")
print(f"{place / 'frame.msh'}: groups floor_K, storey_K_west, beam_K_north, column_K_..., edge_K")

# %% [markdown]
# ## The floor table
#
# One row a floor, for the stick model and for the masses: mass and rotary inertia of the floor,
# and the section of the storey below it. The sections come from the walls and columns just drawn,
# the mass from slab, beams and half of the storeys above and below, with 250 kg/m² for finishes
# and the live load that is there during an earthquake. The 3D model takes these masses: what its
# parts weigh less is added to the slab.

# %%
density = 2500.0  # kg/m3, reinforced concrete
sections = storey_sections(frame)
heights = np.diff(levels)
beams = sum(
    beam.width * beam.depth * np.hypot(*np.subtract(beam.end, beam.start)) for beam in frame.beams
)
rows = []
for floor, height in zip(floors, heights, strict=True):
    section = sections[floor]
    above = heights[floor] * sections[floor + 1].A if floor + 1 in sections else 0.0
    volume = length * width * slab + beams + 0.5 * (height * section.A + above)
    mass = density * volume + 250.0 * length * width
    inertia = mass / 12.0 * np.array([width**2, length**2, length**2 + width**2])
    bending = section.I_x, section.I_y, section.I_x + section.I_y
    rows.append(
        [floor, mass / 1e3, *inertia, *bending, section.A, section.A_vy, section.A_vz, height]
    )
header = (
    "floor,mass [t],Jx [kg m2],Jy [kg m2],Jz [kg m2],Ix [m4],Iy [m4],Iz [m4],"
    "A [m2],Avy [m2],Avz [m2],storey_height [m]"
)
with (place / "floors.csv").open("w", newline="") as stream:
    writer = csv.writer(stream)
    writer.writerow(header.split(","))
    writer.writerows([[f"{value:.6g}" for value in row] for row in rows])
print((place / "floors.csv").read_text())

# %% [markdown]
# ## The record
#
# Records are read from PEER's AT2, ESM, COSMOS, CSMIP, K-NET and CSV files. None is shipped, as
# most may not be passed on; without one of yours this cell writes a stand-in in the AT2 format:
# noise between 0.5 and 15 Hz that rises and fades. It is no earthquake.

# %%
if record:
    file = Path(record).resolve()
else:
    dt, n = 0.005, 2 * round(duration / 0.01)
    t = dt * np.arange(n)
    rng = np.random.default_rng(7)
    frequency = np.fft.rfftfreq(n, dt)
    noise = np.fft.rfft(rng.standard_normal(n))
    noise[(frequency < 0.5) | (frequency > 15.0)] = 0.0
    motion = np.fft.irfft(noise, n) * np.sin(np.pi * t / t[-1]) ** 2
    motion *= 0.35 / np.abs(motion).max()  # g
    file = (place / "stand_in.AT2").resolve()
    lines = ["".join(f"{a:15.7E}" for a in motion[k : k + 5]) for k in range(0, n, 5)]
    title = "STAND-IN, NOISE FROM 0.5 TO 15 HZ, NOT A RECORD OF AN EARTHQUAKE"
    units = "ACCELERATION TIME SERIES IN UNITS OF G"
    file.write_text("\n".join([title, "", units, f"NPTS= {n}, DT= {dt:.4f} SEC", *lines]) + "\n")
print(file.name)

# %% [markdown]
# ## The case file
#
# Quantities carry their units. The neighbour has the same floors on softer storeys; only the first
# building gets a 3D model. Contact is a spring and a dashpot whose restitution is given here; a
# section `[wall_impact]` would find it by an impact of the 3D model on a rigid wall. The gross
# sections of the floor table make the stick too stiff: joints give way, and half of the stiffness
# of the storeys is taken away for cracks. So the stick is calibrated on the first mode of the 3D
# model (`from_structure`: its numbers replace those of the target table).

# %%
case_text = f"""
title = "A frame of three storeys and its softer neighbour"

[materials.concrete]
young_modulus = "33 GPa"
poisson_ratio = 0.2
density = "{density} kg/m3"

[damping]
ratio = "5 %"
frequencies = ["1 Hz", "20 Hz"]

[[buildings]]
name = "mine"
material = "concrete"
floors = "floors.csv"
axis = ["{length / 2} m", "{width / 2} m"]
rigid_below = "0.4 m"
rigid_above = "0.1 m"

[buildings.structure]
storey_stiffness_factor = 0.5
modes = 6
[buildings.structure.mesh]
type = "file"
file = "frame.msh"
[[buildings.structure.mesh.shells]]
groups = "floor_*"
thickness = "{slab} m"
[[buildings.structure.mesh.shells]]
groups = "storey_*"
thickness = "0.2 m"
[[buildings.structure.mesh.beams]]
groups = "beam_*"
width = "0.3 m"
depth = "0.5 m"
offset = "-0.15 m"
[[buildings.structure.mesh.beams]]
groups = "column_*"
width = "0.4 m"
depth = "0.4 m"

[[buildings]]
name = "neighbour"
material = "concrete"
floors = "floors.csv"
axis = ["{length / 2} m", "{1.5 * width + 0.01} m"]
rigid_below = "0.4 m"
rigid_above = "0.1 m"
second_moment_factor = 0.02

[calibration]                   # of the stick, on the first bending mode of the 3D model
targets = "targets.csv"
from_structure = true
direction = "y"
stiffness_factor = [0.01, 1.0]
rigid_depth = "0.5 m"
height = "{levels[-1]} m"
starts = 4

[transient]
time_step = "0.5 ms"
duration = "{duration} s"
maximum_frequency = "{highest} Hz"
[[transient.probes]]
name = "corner"
point = ["{length} m", "{width} m", "{levels[-1]} m"]

[[motions]]
direction = "y"
type = "record"
file = "{file}"

[contact_laws.slabs]
type = "kelvin-voigt"
stiffness = "5e9 N/m"
restitution = 0.6

[[contacts]]
a = {{ building = "mine", floor = {list(floors)}, offset = ["0 m", "{width / 2} m", "0 m"] }}
b = {{ building = "neighbour", floor = {list(floors)}, offset = ["0 m", "{-width / 2} m", "0 m"] }}
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
(place / "targets.csv").write_text(
    "building,mode,frequency [Hz],effective_mass [t]\nmine,1,3,100\n"
)
case_file = place / "own_building.toml"
case_file.write_text(case_text)
case = study.check(case_file, mesh=True)  # the mesh, too: its groups, its joints, its elements
print(f"{case.title}: no fault found")

# %% [markdown]
# ## Run
#
# From the mesh to the 3D building in time. The log says what was checked on the way.

# %%
done = study.run(case_file, out=place / "run", stage="transient")
run = open_run(done.folder)
print(run.table("building.elements", "building.frequency.1", "pounding.impacts").as_text())
print(run.table("pounding.peak_force.*", "transient.pfa.*").as_text())

# %% [markdown]
# ## Floor spectra of the 3D building
#
# At the mass centre of the top floor, at the middle of its impact edge and at the corner that the
# case asked for. The stick knows the mass centre only.

# %%
transient, sticks = run.transient, run.pounding
top = max(floors)
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for probe, label, colour in (
    (f"edge_{top}", "impact edge", "#D55E00"),
    ("corner", "corner", "#E69F00"),
    (f"centre_{top}", "mass centre", "#0072B2"),
):
    psa = transient.psa.sel(probe=probe, component="y").isel(damping=0)
    axes.semilogx(psa.frequency, psa, color=colour, label=label)
psa = sticks.psa.sel(station=f"mine.floor_{top}", direction="y").isel(damping=0)
axes.semilogx(psa.frequency, psa, color="black", ls=":", label="mass centre, stick")
axes.set(
    xlabel="frequency [Hz]",
    ylabel="pseudo-acceleration [m/s²]",
    title=f"floor {top}, along y, damping 5 %, with pounding",
)
axes.grid(alpha=0.3)
axes.legend()
plt.show()

# %% [markdown]
# ## The main impact
#
# The impact force on the top floor, and what the floor does at its edge and at its centre: the
# wave needs some milliseconds from one to the other.

# %%
start, end = np.atleast_1d(transient.attrs["main_impact"])
window = {"time": slice(start - 0.01, end + 0.03)}
figure, (upper, lower) = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True, layout="constrained")
force = transient.edge_force.sel(window)
for edge in force.edge.values:
    upper.plot(1e3 * (force.time - start), 1e-6 * force.sel(edge=edge), label=str(edge))
upper.set(ylabel="impact force [MN]", title=f"main impact at {start:.3f} s")
upper.legend(fontsize=8)
for probe, label in ((f"edge_{top}", "impact edge"), (f"centre_{top}", "mass centre")):
    acceleration = transient.acceleration.sel(probe=probe, component="y").sel(window)
    lower.plot(1e3 * (acceleration.time - start), acceleration, label=label)
lower.set(xlabel="time after its start [ms]", ylabel="acceleration [m/s²]")
lower.legend(fontsize=8)
plt.show()

# %%
run.close()
