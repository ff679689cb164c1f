"""The stage `ensemble`: many motions through the sticks."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.plot.floor_products import write_floor_products
from impactfem.stages.building.targets import with_structure_targets
from impactfem.stages.calibrate.calibrated_contact import with_contact_of_run
from impactfem.stages.ensemble.compute import run_ensemble
from impactfem.stages.ensemble.figures import ensemble_checks, ensemble_results
from impactfem.stages.ensemble.store import write_ensemble
from impactfem.stages.inputs import published_values
from impactfem.stages.pounding.stage import STICK_INPUTS, STICK_ROOMS, stick_inputs_key
from impactfem.stages.stage import Stage
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root, workers


def _key(case: Case) -> str:
    files = tuple(case.ensemble.files()) if case.ensemble is not None else ()
    return stick_inputs_key(case, (*STICK_INPUTS, "ensemble", "published"), files)


def _published(case: Case) -> dict[str, float]:
    """Published values that other motions may miss: not what all of them are scaled or given to."""
    same = ("input", "fitted", "scaled")
    return {n: v for n, v in published_values(case).items() if case.published[n].kind not in same}


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    case = on_root(lambda: with_contact_of_run(with_structure_targets(case, folder), folder))
    with steps.step("sticks"):
        calibration = on_root(lambda: calibration_of(case))
        ready = (calibration, system_of(case, calibration))
    sections = tuple(section for section in STICK_INPUTS if section != "motions")
    members_key = on_root(lambda: stick_inputs_key(case, sections))
    with workers() as executor:
        if executor is None:
            return []  # this rank has worked for rank 0 until now
        with steps.step("members"):
            result = run_ensemble(
                case,
                ready,
                folder / "ensemble" / "members",
                members_key,
                executor,
                lambda done, of: steps.within("members", done / of),
            )
    with steps.step("stores and figures"):
        write_ensemble(folder / "ensemble.nc", case, result, key)
        return [
            folder / "ensemble.nc",
            *ensemble_results(folder, _published(case)),
            *write_floor_products(
                folder / "ensemble",
                folder / "ensemble.nc",
                broadening=case.spectra.broadening,
                clipping=case.spectra.clipping,
                statistic="mean",
            ),
        ]


ENSEMBLE = Stage(
    name="ensemble",
    steps={"sticks": 2.0, "members": 40.0, "stores and figures": 2.0},
    rooms=(*STICK_ROOMS, "stages/ensemble"),
    key=_key,
    store="ensemble.nc",
    run=_run,
    checks=lambda case, folder: ensemble_checks(folder, _published(case)),
    lacks=lambda case: "ensemble" if case.ensemble is None else None,
    needs=lambda case: ("sticks",),
    collective=True,
)
