"""Speed of 3D models that pound: their reductions, and what points and vectors cost in time."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

from bench.suite import Figure, timed
from impactfem.case import load_case
from impactfem.coupling.from_case import ground_of, system_of
from impactfem.motion.from_case import ground_motions
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.pounding_3d import Pounding3D
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.run.loop import run
from impactfem.stages.reduce.stage import models_of_run
from impactfem.system.files import in_source_tree

PAIR = "geometry/npp_pair_coupled.toml"
DURATION = 10.0
"""Part of the motion that is computed [s]."""
PARTS = (1, 2, 4)
"""Each n-th point of a line, and the lowest n-th part of the modes."""


def pounding_figures(case_file: str = PAIR) -> list[Figure]:
    """Reduce both buildings, then compute their pounding with fewer points and with fewer modes.

    With fewer points a line has hats that are sums of others, from the same reduction. The lower
    modes alone are too stiff at the points of contact: only the time of their run has a meaning.
    """
    path = in_source_tree(case_file)
    case = load_case(path)
    with tempfile.TemporaryDirectory() as folder:
        run(path, out=Path(folder), stage="building", bar=False)
        # Side by side where there are two cores: the times of both stages do not add up.
        made, reductions = timed(lambda: run(path, out=Path(folder), stage="reduce", bar=False))
        models = models_of_run(case, Path(folder))
    held = sum(1e-9 * (made.memory[one] or 0.0) for one in made.memory if "reduce" in one)
    if models is None:
        raise ValueError(f"{case.path} has no 3D models that pound")
    h = case.pounding.time_step
    histories = [motion.history for motion in ground_motions(case.motions)]
    ground = ground_of(case, histories, h)
    n_t = 1 + round(DURATION / h)
    relative = {name: one[:, :n_t] for name, one in ground.relative.items()}
    ground = replace(ground, acceleration=ground.acceleration[:n_t], relative=relative)
    system, figures = system_of(case, None), list[Figure]()

    def measure(named: str, models: Models3D, every: int = 1) -> None:
        pounding = Pounding3D(case, system, models, every=every)
        start = process_time()
        pounding.respond(ground, h)
        passed = process_time() - start
        name = f"{DURATION:g} s of pounding, {named}"
        figures.extend(
            [
                Figure(f"{name}, points of contact", float(len(pounding.points)), "-"),
                Figure(f"{name}, vectors", float(len(pounding.assembly)), "-"),
                Figure(f"{name}, time of one core", passed, "s"),
            ]
        )

    whole = Pounding3D(case, system, models)
    whole.respond(ground, h)  # compiles what is not compiled yet
    _, free = timed(lambda: whole.free(ground, h))
    _, struck = timed(lambda: whole.respond(ground, h))
    for every in PARTS:
        measure("all points" if every == 1 else f"one point of {every}", models, every)
    for part in PARTS[1:]:
        fewer = {name: _lowest(one, part) for name, one in models.models.items()}
        measure(f"vectors / {part}", replace(models, models=fewer))
    return [
        Figure("both reductions", reductions, "s"),
        Figure("both reductions and the pounding", reductions + struck + free, "s", 300.0),
        *figures,
        Figure(f"{DURATION:g} s without contact", free, "s"),
        Figure("a further motion, gap, law or damping", struck + free, "s", 10.0),
        Figure("memory of both reductions", held, "GB"),
    ]


def _lowest(model: CompleteModel, part: int) -> CompleteModel:
    """A model of the lowest modes of it, one of so many parts."""
    kept = np.arange(len(model.eigenvalue) // part)
    return replace(
        model,
        eigenvalue=model.eigenvalue[kept],
        ground=model.ground[kept],
        edges=model.edges[kept],
        points=model.points[..., kept],
    )
