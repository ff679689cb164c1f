"""Speed of a fit by the modes of a 3D model."""

from __future__ import annotations

import tempfile
from pathlib import Path

from bench.building import load_forms, peak_memory
from bench.suite import Figure, timed
from impactfem.fit.fit import fit
from impactfem.system.files import in_source_tree

CASE, FIT = "geometry/npp_pair_reread.toml", "geometry/npp_pair_reread_modes_fit.toml"
KEYS = """
[free."materials.storey_5.young_modulus"]
bounds = ["3.3 GPa", "33 GPa"]
scale = "log"
[free."materials.concrete.young_modulus"]
bounds = ["20 GPa", "40 GPa"]
scale = "log"
[free."buildings[0].structure.storey_stiffness_factor"]
bounds = [0.5, 1.5]
scale = "log"
"""
"""Three in place of those that the shipped fit has: of one storey, of all slabs, of all walls."""


def fit_figures() -> list[Figure]:
    """Fit three keys of the default mesh to six modal targets."""
    load_forms()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "three.toml"
        head, _, rest = in_source_tree(FIT).read_text("utf-8").partition("[free.")
        targets = rest[rest.index("[[targets]]") :]
        file.write_text(f"{head}{KEYS}{targets}", encoding="utf-8")
        result, passed = timed(lambda: fit(in_source_tree(CASE), file, out=Path(folder) / "fit"))
    evaluations = 0 if result is None else result.evaluations
    return [
        Figure("three keys to six modal targets", passed, "s", 240.0),
        Figure("evaluations", float(evaluations), "-"),
        Figure("peak memory", peak_memory(), "GB"),
    ]
