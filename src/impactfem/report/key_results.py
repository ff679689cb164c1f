"""The key results of a run."""

import math
import re

from impactfem.report.answers import answers
from impactfem.report.buildings import at_wall, wall_is_used
from impactfem.report.devices import devices
from impactfem.report.facts import quantity
from impactfem.report.governing import governing
from impactfem.report.impacts import untouched
from impactfem.report.run_files import RunFiles
from impactfem.stages.device import selection as of_device

KEY_RESULTS = 10
"""Number of results at the end of a run."""
NEAR = 5e-4
"""Differences below it are 0.0 % in print."""


def key_results(run: RunFiles) -> list[tuple[str, str]]:
    """Return up to ten results of a run with their descriptions: the first screen, and more."""
    spectra = governing(run)
    every = answers(run, spectra)[:-1]  # the console has counted the checks already
    found = [(one.value, f"{one.question.lower()}: {one.text}") for one in every]
    if (epsilon := at_wall(run)) is not None:
        used = "" if wall_is_used(run.case) else ": not used, the case file gives the contact law"
        used = used if run.case["contact_laws"] else ": not used, the case has no contact law"
        found.append((f"{epsilon:.3g}", f"restitution of the 3D model at a rigid wall{used}"))
    found += _differences(run)
    # Then further spectra, the largest first, displacements, storey shear and ground acceleration.
    for one in spectra[1:]:
        text = f"floor spectrum of {one.words}, direction {one.direction}, at {one.at:.3g} Hz"
        found.append((f"{one.peak:.3g} m/s²", text))
    start = "pounding.peak_displacement."
    for name in (name for name in run.values if name.startswith(start)):
        free = run.values.get(name.replace("displacement.", "displacement_no_contact."), math.nan)
        text = f"largest displacement of {name.removeprefix(start)}"
        if run.values.get("pounding.impacts"):
            text += f"; {1e2 * free:.3g} cm without contact"
        found.append((f"{1e2 * run.values[name]:.3g} cm", text))
    if (shear := run.values.get("pounding.storey_shear_max")) is not None:
        found.append((quantity(shear, "N", digits=4), "largest storey shear in impacts"))
    ground = {
        name.removeprefix("motion").removesuffix("pga").strip("."): value
        for name, value in run.values.items()
        if re.fullmatch(r"motion(\.[xyz])?\.pga", name)
    }
    if ground:
        largest = max(ground, key=lambda one: ground[one])
        text = f"peak ground acceleration{f', direction {largest}' * bool(largest)}"
        found.append((quantity(ground[largest], "m/s²", digits=4), text))
    return found[:KEY_RESULTS]


def _differences(run: RunFiles) -> list[tuple[str, str]]:
    """Return how far response spectrum analysis is off for the first device, by load."""
    found = []
    for store, device in devices(run):
        for impact, words in of_device.LOADS.items():
            load = of_device.Load(store, device, impact)
            off, moment = load.difference(), load.moment()
            if off is None or (impact == of_device.WITH and untouched(run)):
                continue
            side = "" if abs(off) < NEAR else ", unconservative" if off > 0.0 else ", conservative"
            text = f"difference of response spectrum analysis{side}:"
            text += f" F{of_device.direction(store)} of {device}, {words}"
            if moment is not None and moment[1] > NEAR:
                text += f"; {moment[0]} unconservative by {100.0 * moment[1]:.1f} %"
            found.append((f"{100.0 * abs(off):.1f} %", text))
        break
    return found
