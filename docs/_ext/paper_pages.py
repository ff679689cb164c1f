"""Write README, `install.md`, `paper-case.md` and `speed.md` from numbers and public names.

``python docs/_ext/paper_pages.py RUN`` takes the numbers of the folder of a finished run of
``geometry/npp_pair.toml`` into ``npp_pair.json`` and writes the pages; without RUN it writes the
pages from the numbers that are there.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2
import pandas

from impactfem.report.facts import quantity
from impactfem.report.publication import compared_values, count, places

sys.path.insert(0, str(Path(__file__).parent))
from public_names import public_names

__all__ = ["numbers", "pages"]
EXTENSIONS = Path(__file__).parent
ROOT = EXTENSIONS.parents[1]
NUMBERS = EXTENSIONS / "npp_pair.json"
PAGES = ("README.md", "docs/install.md", "docs/paper-case.md", "docs/speed.md")
"""Made from the templates of the same names beside this module."""


def numbers(run: Path) -> dict[str, Any]:
    """What the pages take from the folder of a run: results, times, and how near the paper is."""
    summary, case, provenance = (
        json.loads((run / f"{name}.json").read_text("utf-8"))
        for name in ("summary", "case", "provenance")
    )
    written = [str(path.relative_to(run)) for path in run.rglob("*") if path.is_file()]
    found = places(case["report"]["reference"], summary, written)
    kinds = {f"{kind}s": count(found, kind) for kind in ("equation", "figure", "table")}
    statuses = [one.status for one in compared_values(found)]
    kinds["values"] = {status: statuses.count(status) for status in sorted(set(statuses))}
    seconds: dict[str, float] = {}
    for step, time in provenance["seconds"].items():
        stage = step.partition(":")[0]
        seconds[stage] = round(seconds.get(stage, 0.0) + time, 3)
    items = [
        {
            **{key: place.item[key] for key in ("kind", "number", "title")},
            "status": place.status,
            "standing": place.standing,
            "values": [
                {
                    key: getattr(one, key)
                    for key in ("name", "ours", "published", "unit", "relation", "kind")
                }
                | {"status": one.status, "reason": one.reason}
                for one in place.compared
            ],
        }
        for place in found
    ]
    shown = "".join((EXTENSIONS / f"{Path(page).name}.in").read_text("utf-8") for page in PAGES)
    results = {one["name"]: one["value"] for one in summary}
    ensemble = pandas.read_csv(run / "tables" / "ensemble.csv", index_col="result")
    for label, column in (("p05", "5 %"), ("median", "50 %"), ("p95", "95 %")):
        percentiles = ensemble[column].to_dict()
        results |= {f"ensemble.{label}.{name}": value for name, value in percentiles.items()}
    return {
        "results": {name: value for name, value in results.items() if f'"{name}"' in shown},
        "counts": kinds,
        "items": items,
        "seconds": seconds,
        "peak_memory": provenance["peak_memory"],
        "packages": provenance["packages"],
    }


def pages(content: Mapping[str, Any]) -> dict[Path, str]:
    """The text of each page.

    In the templates ``{{ v("frs.floor_8.peak", "m/s²", 3) }}`` is a result with three digits, and a
    fourth argument the unit over the SI unit, such as 1e6 for MN. ``{{ names.sources }}`` is the
    shell line that gets the sources, ``{{ names.get_image }}`` the one for the container image, and
    ``{{ names.note }}`` the sentence on names that are not public yet (`PublicNames`).
    """
    results = content["results"]
    manual = (ROOT / "docs" / "verification.md").read_text("utf-8")
    rows = re.findall(r"^(\d+) rows of \d+ benchmarks, \1 within", manual, re.MULTILINE)[0]

    def v(name: str, unit: str = "", digits: int = 3, size: float = 1.0) -> str:
        value = results[name] / size
        return f"{value:,.{digits}g} {unit}".strip()

    names = public_names()
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(EXTENSIONS),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    return {
        ROOT / page: environment.get_template(f"{Path(page).name}.in").render(
            **content, v=v, quantity=quantity, rows=rows, names=names
        )
        for page in PAGES
    }


if __name__ == "__main__":
    if len(sys.argv) > 1:
        NUMBERS.write_text(json.dumps(numbers(Path(sys.argv[1])), indent=1) + "\n", "utf-8")
    for page, text in pages(json.loads(NUMBERS.read_text("utf-8"))).items():
        page.write_text(text, "utf-8")
        print(page.relative_to(ROOT))
