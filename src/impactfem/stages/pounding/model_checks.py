"""Checks of the stage `pounding` on its models: sticks, soil, and floors in no pair."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import xarray as xr

from impactfem.case import Case
from impactfem.case.contact_search import facing_floors
from impactfem.stages.check import Check, Criterion, digits
from impactfem.stages.stores import names_of, open_store, open_stores

STICK_FIT = Criterion("pounding.stick_fit", "fitted factor of the storey stiffness")
FIT_TARGETS = Criterion(
    "pounding.fit_targets",
    "targets of the fit beyond the tolerances of the case's reference",
    upper=0,
    consequence="The stick does not have the modes of the targets",
    remedy="Free more keys in [calibration]",
)
SOIL_PERIOD = Criterion("pounding.soil_period", "first period on soil over that of a clamped base")
# The rocking of a tall building is the most affected: its resonance is governed by Im S.
SOIL_STIFFNESS = Criterion(
    "pounding.soil_stiffness",
    "error of the stiffness of the soil model",
    "% of |S|",
    upper=0.2,
    consequence="Frequencies of the building on soil are wrong. No springs, dashpots and masses "
    "have these impedances (tables/soil.csv has each component)",
    remedy='Compare with buildings.soil.model = "cone" for a long or embedded raft; a resonating '
    "soil layer has no such model",
)
SOIL_DAMPING = Criterion(
    "pounding.soil_damping",
    "error of the damping of the soil model",
    "% of Im S",
    upper=0.1,
    consequence="Heights of the resonances on soil are wrong. No springs, dashpots and masses "
    "have these impedances (tables/soil.csv has each component)",
    remedy='Compare with buildings.soil.model = "cone" for a long or embedded raft; a resonating '
    "soil layer has no such model",
)
RAFT_PRESSURE = Criterion(
    "pounding.raft_pressure",
    "least pressure under the raft relative to that by gravity",
    "%",
    lower=0.0,
    consequence="The raft would lift: linear analysis overestimates the restoring moment",
    remedy="Use results as an approximation, or a nonlinear program for the foundation",
)
STICK_FREQUENCY = Criterion(
    "pounding.stick_frequency",
    "difference of the first bending frequency between stick and 3D model",
    "%",
    # Sections taken as cracked have half the stiffness (EN 1998-1, 4.3.1(7)) and a frequency 29 %
    # lower; models that differ in mesh, rigid zones and joints differ by less than 20 %.
    upper=0.2,
    severity="invalid",
    consequence="The impact forces are those of another building than the 3D model",
    remedy='Give the stick the stiffness of the 3D model: remove stick = "own"',
    concerns=("pounding.main_impact_*", "transient.*", "design.*", "device.*"),
)
FACING = Criterion(
    "pounding.facing_overlap",
    "facing floors that overlap and are in no contact pair",
    upper=0,
    severity="invalid",
    consequence="These floors would collide; the computed impacts are not all",
    remedy="Add the pairs to [[contacts]]; tables/facing_floors.csv lists them",
)
UNKNOWN_PLANS = Criterion("pounding.facing_unknown", "facing floors that cannot be checked")


def fit_checks(store: xr.Dataset, tolerances: Mapping[str, float]) -> Iterator[Check]:
    """What was fitted, and the errors; no limit without a tolerance for each target."""
    if "stiffness_factor" not in store:
        return
    below, above = (float(store[f"rigid_depth_{side}"]) for side in ("below", "above"))
    yield STICK_FIT.check(
        float(store["stiffness_factor"]),
        "of the floor table",
        f"rigid zones {round(below, 6):.3g} m below and {round(above, 6):.3g} m above the mass "
        f"centres, storey heights {', '.join(f'{h:.3g}' for h in store['storey_height'].values)} m",
    )
    largest = {
        kind: 100 * float(abs(store[f"{kind}_error"]).max())
        for kind in ("frequency", "effective_mass")
    }
    detail = f"largest error of a frequency {largest['frequency']:.2g} %"
    if math.isfinite(largest["effective_mass"]):
        detail += f", of an effective mass {largest['effective_mass']:.2g} %"
    errors: dict[str, float] = {}
    for kind in largest:
        error = abs(store[f"{kind}_error"])
        # A target table may leave a mass out.
        for target in error.dropna("target"):
            building, mode = target["target_building"].item(), target["target_mode"].item()
            errors[f"sticks.{building}.{kind}.{mode}"] = float(target)
    if not errors or any(name not in tolerances for name in errors):
        yield FIT_TARGETS.check(detail=f"no tolerances; {detail}")
        return
    missed = [
        f"{name} {digits(100 * error)} % (at most {digits(100 * tolerances[name])} %)"
        for name, error in errors.items()
        if error > tolerances[name]
    ]
    detail += f"; beyond: {', '.join(missed)}" if missed else ""
    yield FIT_TARGETS.check(len(missed), f"of {len(errors)}", detail)


def foundation_checks(store: xr.Dataset) -> Iterator[Check]:
    """Periods on soil, errors of the soil model, and the pressure under each raft."""
    band = "from the first frequency on soil to twice the first one clamped"
    for name in names_of(store, "foundation") if "foundation" in store.dims else ():
        raft = store.sel(foundation=name)
        x, y = raft["foundation_period_ratio"].sel(foundation_direction=["x", "y"]).values
        yield SOIL_PERIOD.check(place=name, detail=f"{x:.4g} (x), {y:.4g} (y)")
        errors = [float(raft[f"foundation_{of}_error"].max()) for of in ("stiffness", "damping")]
        yield from soil_checks(name, errors, band)
        yield RAFT_PRESSURE.check(float(raft["foundation_least_pressure_ratio"]), name)


def soil_checks(building: str, errors: Sequence[float], band: str) -> list[Check]:
    """Check the errors of the soil model under a building in a band of frequencies.

    Args:
        building: Name.
        errors: Of the stiffness over |S| and of the damping over Im S [-].
        band: In words.
    """
    place = f"{building}, {band}"
    stiffness, damping = errors
    return [SOIL_STIFFNESS.check(stiffness, place), SOIL_DAMPING.check(damping, place)]


def facing_checks(folder: Path, case: Case) -> list[Check]:
    """Check that floors that face each other and are in no pair stay apart."""
    unknown = [UNKNOWN_PLANS.check(detail=line) for line in facing_floors(case).unknown_lines]
    with open_store(folder / "pounding.nc") as store:
        if "facing" not in store.dims:
            return unknown
        nearest = store.isel(facing=store["facing_distance_min"].argmin("facing"))
        count = int((store["facing_distance_min"] < 0.0).sum())
        names = f"{nearest['facing_a'].item()} and {nearest['facing_b'].item()}"
        distance = 1e3 * float(nearest["facing_distance_min"])
        at = f"{float(nearest['facing_time']):.4g} s"
    detail = f"least distance {distance:.4g} mm between {names} at {at}"
    return [FACING.check(count, f"of {store.sizes['facing']}", detail), *unknown]


def stick_against_model(folder: Path) -> list[Check]:
    """Compare the fundamental modes of stick and 3D model along the shown direction.

    With stick = "own" nothing fits a stick to the 3D model. One that is too stiff or too soft
    collides at other times and with other velocities than the building that its forces load.
    There is no check for a vertical direction, along which nothing bends.
    """
    with open_stores(folder) as opened:
        building, sticks = opened("building.nc"), opened("pounding.nc")
        name, direction = str(building.attrs["building"]), str(sticks.attrs["shown_direction"])
        if direction == "z":
            return []
        # The most mass, not the lowest: a mode that twists may be lower, and moves some mass, too.
        mass = building["effective_mass"].sel(direction=direction)
        model = float(building["frequency"].isel(mode=mass.argmax("mode")))
        stick = sticks.sel(building=name, mode_direction=direction)
        main = stick["mode_effective_mass"].argmax("mode")
        frequency = float(stick["mode_frequency"].isel(mode=main))
    detail = f"stick {frequency:.3g} Hz, 3D model {model:.3g} Hz"
    return [
        STICK_FREQUENCY.check(abs(frequency / model - 1.0), f"{name} along {direction}", detail)
    ]
