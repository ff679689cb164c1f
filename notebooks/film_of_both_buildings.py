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
# # Film of both buildings
#
# What this notebook teaches: run a case in which both buildings have a 3D model and pound in 3D,
# show the film of the main impact, and read its frames.
#
# Both models touch along the edges of their floors. The contact is unilateral: it needs neither a
# stiffness nor a restitution coefficient.

# %% tags=["parameters"]
case_file = "../geometry/tower_pair.toml"  # the case
folder = "../runs/tower_pair"  # of the run
changes = {}  # keys of the case with other values

# %%
from pathlib import Path

import imageio.v2 as imageio
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Image

import impactfem

case = impactfem.load(case_file)
case.set("report.figures", ["main_impact_loop"])  # the film as GIF, in addition to mp4
for key, value in changes.items():
    case.set(key, value)
run = impactfem.run(case, out=folder, stage="transient", bar=False)
print(run.table("pounding.impacts", "pounding.main_impact_*").as_text())

# %% [markdown]
# ## The film
#
# The folder of the building that is computed last has the film as mp4 and, if requested, as GIF.
# Displacements and gap are exaggerated by the factor on the frames. The colours are absolute
# accelerations. The main impact is in slow motion.

# %%
last = run.of(run.buildings_3d[-1])
film = Path(last.folder) / "figures" / "main_impact_loop.gif"
Image(filename=film)

# %% [markdown]
# ## Single frames
#
# The store `transient_maps.nc` has the time of each frame. The pictures show the frames before the
# impact, at its start, 10 ms later, and at the end of the film.

# %%
times = last.maps["frame"].values  # s
start = float(last.transient.attrs["main_impact"][0])
chosen = [int(np.argmin(abs(times - t))) for t in (start - 0.1, start, start + 0.01, times[-1])]
frames = imageio.mimread(film)
figure, panels = plt.subplots(2, 2, figsize=(9, 6.9), layout="constrained")
for panel, k in zip(panels.flat, chosen, strict=True):
    panel.imshow(frames[k])
    panel.set_axis_off()
plt.show()

# %% [markdown]
# ## The gap over time
#
# The gap of the decisive pair, 1 s around the main impact. It closes without penetration.

# %%
axes = run.plot.gap()
axes.set_xlim(start - 0.5, start + 0.5)
plt.show()

# %%
run.close()
