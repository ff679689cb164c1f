"""The stages of the study, what they hand over to one another and what a run computed."""

import json
import re
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import FancyBboxPatch

from impactfem.plot.style import BLUE, figure
from impactfem.report.overview import quantity
from impactfem.report.run_files import FLOWCHART, PROVENANCE, SUMMARY
from impactfem.stages.stage import Stage
from impactfem.system.scalar import alone

WIDTH, GAP = 27.0, 2.5
"""Widths of a box and of the passage of an arrow between two, in percent of the figure's."""
ROW, FILL = 1.3, 0.72
"""Height of a row [inch], and of a box over it."""
LETTERS, ACROSS = 40, 3
"""Letters in a line of a box, and boxes in a row."""
DONE, MISSING, GREY = "#dcebf7", "white", "0.45"
ABSENT = "not part of this run"
Place = tuple[float, float]
Slot = tuple[str, ...]
"""A box, (stage,), or the passage of an arrow through a row, (from, to, row)."""


def flowchart_figure(folder: Path, stages: Sequence[Stage]) -> list[Path]:
    """Draw `figures/figure_04_flowchart.svg`: a box for each stage, an arrow for each need."""
    made = json.loads((folder / PROVENANCE).read_text(encoding="utf-8"))
    results = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    needs: Mapping[str, Sequence[str]] = made.get("needs", {})
    done = list(made["inputs"])
    known = {stage.name: stage for stage in stages}
    missing = [name for name in known if name not in {one.rpartition("/")[2] for one in done}]
    links = [(a, b) for b in done for a in needs.get(b, ()) if a in done]
    rows = _rows(done, links)
    rows += [[(name,) for name in missing[k : k + ACROSS]] for k in range(0, len(missing), ACROSS)]
    step = 100.0 / len(rows)
    places: dict[Slot, Place] = {}
    # Boxes have their width, arrows that of a gap; the free width is shared out evenly. With
    # several 3D models there are more boxes in a row than a page is wide.
    every = [np.array([WIDTH if len(slot) == 1 else GAP for slot in row]) for row in rows]
    across = max(100.0, *(float((widths + GAP).sum()) for widths in every))
    for r, (row, widths) in enumerate(zip(rows, every, strict=True)):
        free = (across - widths.sum()) / len(row)
        middles = widths.cumsum() - 0.5 * widths + free * (np.arange(len(row)) + 0.5)
        for slot, x in zip(row, middles.tolist(), strict=True):
            places[slot] = (x, 100.0 - step * (r + 0.5))
    caption = (
        "The stages of this run: how they hand over to one another, and what they computed."
        + (" Dashed: not part of this run." if missing else "")
    )
    target = folder / "figures"
    handed = "; ".join(f"{a} to {b}" for a, b in links)
    seen = f"Boxes of the stages {', '.join(done)}{f', with arrows from {handed}' * bool(links)}."
    size = (0.09 * across, ROW * len(rows))
    with figure(target / f"{FLOWCHART}.svg", (1, 1), size, caption, seen) as (_, axes):
        for name in [*done, *missing]:
            building, _, own = name.rpartition("/")
            lines = [ABSENT]
            if name in done:
                # Those of a further building by the names that they have alone.
                named = ({**one, "name": alone(one["name"], building)} for one in results)
                mine = [one for one in named if one["name"]] if building else results
                lines = headlines(known[own], mine)
            italic = name.replace("_", "\\_")
            head = f"{known[own].title}  ($\\it{{{italic}}}$)"
            (x, y), height, here = places[(name,)], FILL * step, name in done
            frame = FancyBboxPatch(
                (x - 0.5 * WIDTH, y - 0.5 * height),
                WIDTH,
                height,
                boxstyle="round,pad=0,rounding_size=1.2",
                facecolor=DONE if here else MISSING,
                edgecolor=BLUE if here else GREY,
                linestyle="-" if here else "--",
                zorder=2,
            )
            axes[0].add_patch(frame)
            look: dict[str, Any] = {"ha": "center", "va": "top", "zorder": 3}
            look["color"] = "black" if here else GREY
            axes[0].text(x, y + 0.4 * height, head, fontsize=8.5, **look)
            text = "\n".join(part for line in lines for part in textwrap.wrap(line, LETTERS))
            axes[0].text(x, y + 0.18 * height, text, fontsize=7.5, linespacing=1.2, **look)
        for a, b in links:
            between = [places[slot] for slot in places if slot == (a, b, slot[-1])]
            # From a box to one below, between the boxes of the rows that the arrow passes.
            half = 0.5 * FILL * step
            (x, y), (end, top) = places[(a,)], places[(b,)]
            line = [(x, y - half)]
            for x, y in between:
                line += [(x, y + half), (x, y - half)]
            axes[0].plot(*zip(*line, strict=True), color="black", lw=1.0, zorder=1)
            arrow = {"arrowstyle": "-|>", "shrinkA": 0.0, "shrinkB": 0.0, "color": "black"}
            axes[0].annotate("", (end, top + half), xytext=line[-1], arrowprops=arrow, zorder=4)
        axes[0].set(xlim=(0.0, across), ylim=(0.0, 100.0))
        axes[0].set_axis_off()
    return [target / f"{FLOWCHART}.svg"]


def _rows(names: Sequence[str], links: Sequence[tuple[str, str]]) -> list[list[Slot]]:
    """Each stage below those that it needs, and a slot in each row that an arrow passes through."""
    # In a row, slots stand in the order of the mean place of those above that lead to them.
    level: dict[str, int] = {}
    for name in names:
        level[name] = 1 + max((level[a] for a, b in links if b == name), default=-1)
    rows: list[list[Slot]] = []
    for row in range(1 + max(level.values(), default=-1)):
        above: dict[Slot, list[float]] = {(n,): [] for n in names if level[n] == row}
        for a, b in links:
            if level[a] < row <= level[b]:
                start = (a,) if level[a] == row - 1 else (a, b, str(row - 1))
                place = (rows[-1].index(start) + 0.5) / len(rows[-1])
                above.setdefault((b,) if level[b] == row else (a, b, str(row)), []).append(place)
        rows.append(sorted(above, key=lambda slot: float(np.mean(above[slot] or [0.5]))))
    return rows


def headlines(stage: Stage, results: Sequence[Mapping[str, Any]]) -> list[str]:
    """The lines of a stage with its results; those that lack one are left out.

    In a line, ``{name}`` stands for a result with its unit; a name with * for the largest of those
    that it matches, one with ? for the first one, whose letter stands in place of each ? of the
    line. The results are those of `summary.json`.
    """
    values = {one["name"]: (one["value"], one["unit"]) for one in results}
    lines = []
    for line in stage.headlines:
        words: str | None = line
        for name in re.findall(r"\{([^}]+)\}", line):
            pattern = re.escape(name).replace(r"\*", r"[\w.]*").replace(r"\?", r"(\w)")
            matches = ((re.fullmatch(pattern, n), v) for n, v in values.items() if v[0] is not None)
            found = [(match, v) for match, v in matches if match]
            if words is None or not found:
                words = None
                break
            value = found[0][1] if "?" in name else max(v for _, v in found)
            words = words.replace(f"{{{name}}}", quantity(*value, digits=4))
            words = words.replace("?", found[0][0][1]) if "?" in name else words
        lines += [] if words is None else [words.replace("m/s2", "m/s²")]
    return lines
