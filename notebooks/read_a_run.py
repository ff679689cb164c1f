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
# # Read a run
#
# What this notebook teaches: to open the stores of a finished run with xarray, to draw the paper's
# figures 15 and 19 again (floor response spectra across the top floor, and at the impact edges of
# all floors), and to look at the peak floor accelerations on the 3D building with pyvista. It
# reads any run whose case has a 3D building (and `[transient]`), for example that of
# `scripts/run`; nothing is computed.
#
# pyvista and dolfinx do not go together in one process. A notebook that draws with pyvista reads
# the stores and leaves `study.run` to another one.

# %% tags=["parameters"]
folder = "../runs/npp_pair"  # the run
figures = ""  # a folder for the pictures; empty: they are only shown

# %%
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

from impactfem.study import open_run

run = open_run(folder)
print("stores:", ", ".join(run.stores))


def show(figure, name):
    """Show a figure; keep it where a folder for the pictures is named."""
    if figures:
        Path(figures).mkdir(parents=True, exist_ok=True)
        figure.savefig(Path(figures) / name, dpi=150)
    plt.show()


# %% [markdown]
# ## What is in a store
#
# Dimensions and variables have names, variables have units; `docs/run-folder.md` says what they
# mean. The probes of `transient.nc` are points of the 3D building: `centre_K` at the mass centre
# of floor K, `edge_K` in the middle of the edge that is hit, `line_N` on a line across the top
# floor from that edge to the other side.

# %%
transient = run.transient
print(transient.sizes)
print("probes:", ", ".join(str(name) for name in transient.probe.values))
for name in ("acceleration", "psa", "sd", "pfa"):
    print(f"{name} [{transient[name].attrs['units']}]: {', '.join(transient[name].dims)}")

direction = transient.attrs["shown_direction"]
highest = float(transient.attrs["maximum_frequency"])  # Hz, up to which the reduced model is meant
damping = float(transient.damping[0])


def of_kind(kind):
    """Names of the probes of a kind: by floor, and of the line from the impact edge."""
    return transient.probe.values[transient.probe_kind == kind].tolist()


# %% [markdown]
# ## Spectra with their error band
#
# `psa` is the pseudo-acceleration and `sd` the spectral displacement, $PS_a = \omega^2 S_d$.
# `psa_band` is the half width of the error band of the reduced model. The function below draws
# some probes as the paper does: displacement (a) and pseudo-acceleration (b).


# %%
def spectra(probes, labels, title, from_top=False):
    """Draw the spectra of some probes; the labels from the last on if they go up the building."""
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.92, len(probes)))
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    omega = 2.0 * np.pi * transient.frequency
    for probe, label, colour in zip(probes, labels, colours, strict=True):
        here = {"probe": probe, "component": direction, "damping": damping}
        psa, band = transient.psa.sel(here), transient.psa_band.sel(here)
        sd = transient.sd.sel(here)
        left.semilogx(sd.frequency, 1e2 * sd, color=colour, lw=1.2, label=label)
        left.fill_between(
            sd.frequency,
            1e2 * (sd - band / omega**2),
            1e2 * (sd + band / omega**2),
            color=colour,
            alpha=0.3,
            lw=0,
        )
        right.semilogx(psa.frequency, psa, color=colour, lw=1.2, label=label)
        right.fill_between(psa.frequency, psa - band, psa + band, color=colour, alpha=0.3, lw=0)
    left.set(ylabel="spectral displacement [cm]", title="(a)")
    right.set(ylabel="pseudo-acceleration [m/s²]", title="(b)")
    for panel in (left, right):
        panel.set(xlabel="frequency [Hz]", xlim=(transient.frequency[0], transient.frequency[-1]))
        panel.set_ylim(bottom=0.0)
        panel.grid(alpha=0.3)
        if highest < transient.frequency[-1]:
            panel.axvspan(highest, float(transient.frequency[-1]), color="0.9", zorder=0)
    right.legend(loc="upper left", fontsize=8, reverse=from_top)
    figure.suptitle(f"{title}, along {direction}, damping {100 * damping:g} %")
    return figure


# %% [markdown]
# ## Figure 15: across the top floor
#
# Floor response spectra at some distances *d* from the edge that is hit. Below the first modes of
# the slab the floor moves as one body, and the curves are one. Above, the shock waves that cross
# the floor make them differ: the paper finds the largest peak accelerations at the edges, where
# the waves are reflected. What is grey lies above the frequency that the reduced model is meant
# for.

# %%
line = of_kind("line")
shown = [line[k] for k in np.unique(np.linspace(0, len(line) - 1, 5).round().astype(int))]
start = transient.probe_position.sel(probe=line[0])
distance = {
    name: float(np.linalg.norm(transient.probe_position.sel(probe=name) - start)) for name in shown
}
figure = spectra(shown, [f"d = {distance[name]:.1f} m" for name in shown], "Figure 15: top floor")
show(figure, "figure_15.png")

pfa = transient.pfa.sel(component=direction)
for name in shown:
    told = f"{float(pfa.sel(probe=name)):5.1f} m/s²"
    print(f"d = {distance[name]:4.1f} m: peak floor acceleration {told}")

# %% [markdown]
# ## Figure 19: up the building
#
# The same at the middle of the impact edges of all floors. In the paper the floor below the top
# one has the highest spectrum between 36 and 152 Hz, although it is hit less hard: it is lighter,
# and more of its waves have these frequencies.

# %%
edges = of_kind("edge")
labels = [f"floor {floor}" for floor in transient.probe_floor.sel(probe=edges).values]
figure = spectra(edges, labels, "Figure 19: impact edges of the floors", from_top=True)
show(figure, "figure_19.png")

at_edges = transient.psa.sel(probe=edges, component=direction, damping=damping)
known = at_edges.where(at_edges.frequency <= highest, drop=True)
first = known.idxmax("probe")
for name in reversed(edges):
    here = known.frequency.values[first.values == name]
    where = f"highest of all at {here.size} of {first.size} frequencies"
    if here.size:
        where += f", within {here[0]:.1f} to {here[-1]:.1f} Hz"
    print(f"{name}: peak {float(known.sel(probe=name).max()):5.1f} m/s²; {where}")

# %% [markdown]
# ## Peak floor accelerations on the building
#
# `transient_maps.nc` has the peak acceleration at every vertex of the parts `floor_K`, and these
# parts include the parapet. `floor_triangle_node` lists the triangles of the slabs alone: a peak
# on a slab is a peak floor acceleration, one on the parapet is not. `building.nc` has the mesh:
# six-node triangles with the part that each belongs to. pyvista draws them into a picture
# without a window. `VTK_DEFAULT_OPENGL_WINDOW` must be set before pyvista is loaded: with it no X
# server is needed. The colours are logarithmic: the lower floors see a small part of what the
# upper ones do.

# %%
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
import pyvista

building, maps = run.building, run.maps
parts = np.array([str(name) for name in building.shell_part_name.values])[building.triangle_part]
corners = building.triangle_node.values[:, :3]
points = building.node_position.values

slab = np.unique(maps.floor_triangle_node)
peak = np.full(len(points), np.nan)  # m/s², of the slabs
peak[maps.node_number.values[slab]] = maps.pfa.sel(component=direction).values[slab]
on_floor = np.char.startswith(parts.astype(str), "floor") & np.isfinite(peak[corners]).all(axis=1)
floors = pyvista.PolyData.from_regular_faces(points, corners[on_floor])
floors["peak"] = peak
walls = pyvista.PolyData.from_regular_faces(points, corners[np.char.startswith(parts, "storey")])

scene = pyvista.Plotter(off_screen=True, window_size=(1400, 1000))
scene.set_background("white")
scene.add_mesh(walls, color="lightgrey", opacity=0.15)
limits = np.nanmin(peak), np.nanmax(peak)
colours = {"cmap": "cividis", "clim": limits, "log_scale": True}
scene.add_mesh(
    floors.remove_unused_points(),
    scalars="peak",
    lighting=False,
    show_scalar_bar=False,
    **colours,
)
scene.add_axes(color="black")
scene.enable_parallel_projection()
scene.view_vector((1.0, 1.35, 0.75), viewup=(0.0, 0.0, 1.0))  # from the side that is hit
scene.camera.zoom(1.3)
picture = scene.screenshot(return_img=True)
scene.close()

figure, axes = plt.subplots(figsize=(9, 6.4), layout="constrained")
axes.imshow(picture)
axes.set_axis_off()
figure.colorbar(
    plt.cm.ScalarMappable(LogNorm(*limits), "cividis"),
    ax=axes,
    shrink=0.6,
    label=f"peak floor acceleration along {direction} [m/s²]",
)
axes.set_title(f"Peak floor accelerations of {building.attrs['building']}, with pounding")
show(figure, "peak_floor_accelerations.png")

largest = int(np.nanargmax(peak))
x, y, z = points[largest]
print(f"largest: {peak[largest]:.1f} m/s² at ({x:.2f}, {y:.2f}, {z:.2f}) m")

# %%
run.close()
