"""Figure 4: the stages of the study, what they hand over to one another and what a run computed."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch

from impactfem.plot.style import BLUE, figure
from impactfem.report.overview import quantity
from impactfem.report.run_files import FLOWCHART, PROVENANCE, SUMMARY
from impactfem.stages.stage import Stage

WIDTH, FILL = 29.0, 0.76
"""Of a box, in parts of a hundred of the figure's width, and its height over that of a row."""
ACROSS = 3
"""Boxes in a row."""
DONE, MISSING, GREY = "#dcebf7", "white", "0.45"
ABSENT = "not part of this run"
Place = tuple[float, float]


def flowchart_figure(folder: Path, stages: Sequence[Stage]) -> list[Path]:
    """Draw `figures/figure_04_flowchart.png`: a box for each stage, an arrow for each need.

    Args:
        folder: The run's folder, with its summary and its provenance.
        stages: All stages, in order.

    Returns:
        The file.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    made = json.loads((folder / PROVENANCE).read_text(encoding="utf-8"))
    results = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    needs: Mapping[str, Sequence[str]] = made.get("needs", {})
    level: dict[str, int] = {}
    for stage in stages:
        if stage.name in made["inputs"]:
            above = (level[name] for name in needs.get(stage.name, ()) if name in level)
            level[stage.name] = 1 + max(above, default=-1)
    rows: list[list[Stage]] = []
    for row in range(1 + max(level.values(), default=-1)):
        rows.append([stage for stage in stages if level.get(stage.name) == row])
    missing = [stage for stage in stages if stage.name not in level]
    rows += [missing[k : k + ACROSS] for k in range(0, len(missing), ACROSS)]
    step = 100.0 / len(rows)
    places = {
        stage.name: (100.0 * (k + 0.5) / len(row), 100.0 - step * (r + 0.5))
        for r, row in enumerate(rows)
        for k, stage in enumerate(row)
    }
    caption = (
        "Figure 4: The forces on a device in a building that pounds against another: how the "
        "stages of this run hand over to one another, and what they computed."
        + (" Dashed: not part of this run." if missing else "")
    )
    target = folder / "figures"
    target.mkdir(parents=True, exist_ok=True)
    with figure(target / FLOWCHART, (1, 1), (9.0, 1.15 * len(rows)), caption) as (_, axes):
        for stage in stages:
            lines = headlines(stage, results) if stage.name in level else [ABSENT]
            _box(axes[0], places[stage.name], FILL * step, stage, lines, stage.name in level)
            for name in needs.get(stage.name, ()):
                if {name, stage.name} <= set(level):
                    far = level[stage.name] - level[name] > 1
                    _arrow(axes[0], places[name], places[stage.name], FILL * step, far)
        axes[0].set_xlim(0.0, 100.0)
        axes[0].set_ylim(0.0, 100.0)
        axes[0].set_axis_off()
    return [target / FLOWCHART]


def headlines(stage: Stage, results: Sequence[Mapping[str, Any]]) -> list[str]:
    """The lines of a stage with its results; those that lack one are left out.

    Args:
        stage: The stage. In its lines, ``{name}`` stands for a result with its unit; a name with *
            for the largest of those that it matches.
        results: The scalar results of the run, as `summary.json` has them.
    """
    values = {one["name"]: (one["value"], one["unit"]) for one in results}
    lines = []
    for line in stage.headlines:
        known = True
        for name in re.findall(r"\{([^}]+)\}", line):
            pattern = re.escape(name).replace(r"\*", r"\w+")
            found = [v for n, v in values.items() if v[0] is not None and re.fullmatch(pattern, n)]
            known = known and bool(found)
            if known:
                line = line.replace(f"{{{name}}}", quantity(*max(found), digits=4))
        lines += [line] if known else []
    return lines


def _box(
    panel: Axes, place: Place, height: float, stage: Stage, lines: Sequence[str], done: bool
) -> None:
    (x, y), top = place, place[1] + 0.5 * height
    frame = FancyBboxPatch(
        (x - 0.5 * WIDTH, y - 0.5 * height),
        WIDTH,
        height,
        boxstyle="round,pad=0,rounding_size=1.2",
        facecolor=DONE if done else MISSING,
        edgecolor=BLUE if done else GREY,
        linestyle="-" if done else "--",
        zorder=2,
    )
    panel.add_patch(frame)
    look: dict[str, Any] = {"ha": "center", "va": "top", "zorder": 3}
    look["color"] = "black" if done else GREY
    head = f"{stage.title}  ($\\it{{{stage.name}}}$)"
    panel.text(x, top - 0.1 * height, head, fontsize=8.5, **look)
    panel.text(x, top - 0.36 * height, "\n".join(lines), fontsize=7.5, linespacing=1.2, **look)


def _arrow(panel: Axes, start: Place, end: Place, height: float, far: bool) -> None:
    """From a box to one below; round the boxes between them where it is not the next row."""
    (x0, y0), (x1, y1) = start, end
    ends = ((x0, y0 - 0.5 * height), (x1, y1 + 0.5 * height))
    bent = "arc3"
    if far:
        side = 0.5 * WIDTH if x1 >= x0 else -0.5 * WIDTH
        ends, bent = ((x0 + side, y0), (x1 + side, y1)), f"arc3,rad={-0.35 if side > 0 else 0.35}"
    look = {"arrowstyle": "-|>", "connectionstyle": bent, "shrinkA": 0.0, "shrinkB": 0.0}
    panel.annotate("", ends[1], xytext=ends[0], arrowprops={**look, "color": "black"}, zorder=4)
