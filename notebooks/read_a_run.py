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
# # Read a run with a 3D building
#
# What this notebook teaches: open a finished run, select floor spectra of the 3D building, find
# peak floor accelerations, and draw the building with pyvista off-screen.
#
# pyvista and dolfinx must not share a process. A notebook that uses pyvista only reads results. If
# the run does not exist, the cell below starts it in another process.

# %% tags=["parameters"]
case_file = "../geometry/tower_pair.toml"  # is run if the folder holds no run
folder = "../runs/tower_pair"  # of the run

# %%
import os
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import impactfem

if not (Path(folder) / "summary.json").exists():
    command = [sys.executable, "-m", "impactfem", "run", case_file, "--out", folder]
    subprocess.run([*command, "--stage", "transient"], check=True, capture_output=True)
run = impactfem.open(folder)
print(run)

# %% [markdown]
# ## Floor spectra
#
# The probes of `transient.nc` are points of the 3D building: `centre_K` at the mass centre of
# floor K, `edge_K` in the middle of its edge on the impact side, and `line_N` across one floor.

# %%
transient = run.transient
direction = transient.attrs["shown_direction"]
resolved = transient.attrs["resolved_frequency"]  # Hz
psa = transient["psa"].sel(component=direction).isel(damping=0).sel(frequency=slice(None, resolved))
edges = psa.isel(probe=(psa["probe_kind"] == "edge").values)

figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
order = edges.max("frequency").argsort().values[::-1]
for name in edges["probe"].values[order[:3]]:  # the floors with the largest peaks
    floor = int(edges["probe_floor"].sel(probe=name))
    (line,) = axes.semilogx(edges["frequency"], edges.sel(probe=name), label=f"edge, floor {floor}")
    centre = psa.sel(probe=f"centre_{floor}")
    axes.semilogx(
        centre["frequency"], centre, "--", color=line.get_color(), label=f"centre, floor {floor}"
    )
axes.set(xlabel="frequency [Hz]", ylabel="pseudo-acceleration [m/s²]")
axes.set_title(f"direction {direction}, {100 * float(psa['damping']):g} % damping")
axes.legend(fontsize=8)
plt.show()

# %% [markdown]
# ## Peak floor accelerations
#
# `transient_maps.nc` has the peak acceleration of all vertices of the floor parts. These parts
# include parapets. A peak floor acceleration must come from a slab, so the selection below takes
# the vertices of the slab triangles only.

# %%
maps = run.maps
pfa = maps["pfa"].sel(component=direction).values  # m/s², by vertex
for floor in np.unique(maps["floor_triangle_floor"]):
    here = (maps["floor_triangle_floor"] == floor).values
    slab = np.unique(maps["floor_triangle_node"].values[here])
    top = slab[pfa[slab].argmax()]
    x, y, z = maps["node_position"].values[top]
    print(f"floor {floor}: {pfa[top]:6.1f} m/s² at ({x:.1f}, {y:.1f}, {z:.1f}) m")

# %% [markdown]
# `run.plot.building` draws this field on the building in a separate process.

# %%
run.plot.building("pfa")
plt.show()

# %% [markdown]
# ## Your own picture
#
# `building.nc` has the mesh: six-node triangles of the shells, lines of the beams. The environment
# variable must be set before pyvista is loaded: VTK then needs no display. The colours show the
# spectral ordinate at one frequency.

# %%
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
import pyvista

at = maps["psa"].sel(component=direction).sel(frequency=20.0, method="nearest")
building = run.building
floors = pyvista.PolyData.from_regular_faces(
    maps["node_position"].values, maps["floor_triangle_node"].values
)
floors["psa"] = at.values
walls = pyvista.PolyData.from_regular_faces(
    building["node_position"].values, building["triangle_node"].values[:, :3]
)

scene = pyvista.Plotter(off_screen=True, window_size=(900, 800))
scene.set_background("white")
scene.add_mesh(walls, color="lightgrey", opacity=0.15)
title = f"Sa at {float(at['frequency']):.1f} Hz [m/s²]"
bar = {"title": title, "vertical": True, "title_font_size": 20, "position_x": 0.85}
scene.add_mesh(floors, scalars="psa", cmap="viridis", lighting=False, scalar_bar_args=bar)
scene.add_axes()
scene.view_vector((1.0, 1.4, 0.7), viewup=(0.0, 0.0, 1.0))
picture = scene.screenshot(return_img=True)
scene.close()

figure, axes = plt.subplots(figsize=(6, 5.4), layout="constrained")
axes.imshow(picture)
axes.set_axis_off()
plt.show()

# %%
run.close()
