"""The lines of a stage with its results."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from impactfem.report.facts import quantity
from impactfem.stages.stage import Stage


def headlines(stage: Stage, results: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a stage with its results, without those that lack a result.

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
