"""Makes updating_modes.csv and updating_shapes.csv: modes of a known building, with noise.

Run from the folder of the program: .venv/bin/python geometry/updating.py
"""

from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from scipy.spatial import cKDTree

from impactfem.case.load import read_case
from impactfem.case.model import CaseFile
from impactfem.case.source import read_source
from impactfem.stages.building.compute import analysed

HERE = Path(__file__).parent
CORNERS = ((0.0, 0.0), (14.0, 0.0), (14.0, 8.0))
MODES, SEED = 6, 1
# Standard deviations: parts of each value, and of the largest amplitude.
FREQUENCY, DAMPING, SHAPE = 0.005, 0.2, 0.03

source = read_source(HERE / "updating.toml", CaseFile)
source.raw["materials"]["concrete"]["young_modulus"] = "27 GPa"
source.raw["materials"]["masonry"]["young_modulus"] = "8 GPa"
source.raw["damping"]["ratio"] = "2 %"
source.raw["buildings"][0]["structure"]["mesh"]["slab_thickness"] = "22 cm"
case = read_case(source)[0]
with TemporaryDirectory() as folder:
    study, model, found = analysed(case, Path(folder), MPI.COMM_SELF, lambda name: nullcontext())
levels = study.parts.mesh.elevations
sensors = [(x, y, levels[k], d) for k in (2, 3, 4) for x, y in CORNERS for d in (0, 1)]
nodes = cKDTree(study.parts.mesh.nodes).query([sensor[:3] for sensor in sensors])[1]
at = found.shapes[model.rows(nodes) + np.array([sensor[3] for sensor in sensors])]

rng = np.random.default_rng(SEED)
modes = ["# Made by updating.py: synthetic, with noise.", "mode,frequency [Hz],damping [%]"]
shapes = [modes[0], "mode,x [m],y [m],z [m],direction,amplitude"]
law = case.building("T").damping.law
for k in range(MODES):
    f = found.frequency[k]
    ratio = law.ratio(np.array([f]))[0]
    noisy = f * (1.0 + FREQUENCY * rng.standard_normal())
    measured = ratio * (1.0 + DAMPING * rng.standard_normal())
    modes.append(f"{k + 1},{noisy:.4f},{100.0 * measured:.3f}")
    shape = at[:, k] / np.abs(at[:, k]).max()
    shape = shape + SHAPE * rng.standard_normal(shape.size)
    shapes += [
        f"{k + 1},{x:g},{y:g},{z:g},{'xyz'[d]},{a:.4f}"
        for (x, y, z, d), a in zip(sensors, shape, strict=True)
    ]
for name, lines in (("updating_modes.csv", modes), ("updating_shapes.csv", shapes)):
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
print(found.frequency)
