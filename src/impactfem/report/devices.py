"""The forces on the anchors of the devices."""

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from impactfem.report.facts import SMALL, Facts
from impactfem.report.run_files import RunFiles
from impactfem.stages.device import selection as of_device
from impactfem.stages.stores import names_of


def devices(run: RunFiles) -> Iterator[tuple[xr.Dataset, str]]:
    """The devices of all 3D models, each with the open store that has it."""
    for one in run.models.values():
        if one.ran("device"):
            with one.store("device.nc") as store:
                for device in names_of(store, "device"):
                    yield store, device


def anchor_forces(store: xr.Dataset, device: str) -> list[list[str]]:
    """Largest forces of a device by load and analysis, and the factor of the impacts."""
    headline = of_device.headline(store)
    analyses = {"3D model": of_device.DETAILED, f"RSA, {headline}": headline}
    for method, name in of_device.rigid_variants(store).items():
        analyses[f"RSA, {of_device.RIGID_WORDS[method]}"] = name
    rows = []
    loads = {words: of_device.Load(store, device, i) for i, words in of_device.LOADS.items()}
    for words, load in loads.items():
        for label, analysis in analyses.items():
            if not load.was_done(analysis):
                continue
            off, tension = load.difference(analysis), load.tension(analysis)
            rows.append(
                [
                    words,
                    label,
                    *(f"{1e-3 * value:.2f}" for value in load.components(analysis).values),
                    "" if off is None else f"{100.0 * off:+.1f}",
                    f"{1e-3 * tension:.2f}" if math.isfinite(tension) else "not known",
                ]
            )
    quiet, hit = (load.components().values for load in loads.values())
    # Forces are compared with the largest force, moments with the largest moment.
    least = SMALL * np.repeat([quiet[:3].max(), quiet[3:].max()], 3)
    both = zip(quiet, hit, least, strict=True)
    ratios = (f"{b / a:.1f}" if a > small else "" for a, b, small in both)
    return [*rows, ["ratio with / without impact", "3D model", *ratios, "", ""]]


def anchors_table(run: RunFiles) -> Facts | None:
    """Return the largest forces of all devices on their floors; None without devices."""
    rows, direction = [], ""
    for store, device in devices(run):
        direction = of_device.direction(store)
        rows += [[device, *row] for row in anchor_forces(store, device)]
    if not rows:
        return None
    head = ["device", "load", "analysis", *(f"F{a} [kN]" for a in "xyz")]
    head += [f"M{a} [kN m]" for a in "xyz"]
    head += [f"difference of F{direction} [%]", "net tension [kN]"]
    note = (
        "Largest values, without the weight. Difference = (3D - RSA)/3D, positive where response "
        "spectrum analysis (RSA) is unconservative. Net tension: tension in the most highly loaded "
        "of n equally spaced anchors, times n, less the weight."
    )
    return Facts("Forces on the anchors", head, rows, note)
