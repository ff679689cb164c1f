"""The stage `design`: design spectra of the 3D building, and an ensemble of motions through it.

The impact forces of each motion of the ensemble, from the sticks, act on the 3D building and the
devices.
"""

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from impactfem.reduction.loads import Loads
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.spectra.resolved import band_limited_zpa
from impactfem.stages.design.carrier import Carrier, DesignInputs, point_records
from impactfem.stages.design.envelopes import DesignStudy, ResolvedSpectra
from impactfem.stages.design.floors import WholeFloors, read_probes, read_whole_floors
from impactfem.stages.design.members import FOLDER, Members
from impactfem.stages.design.store import write_design
from impactfem.system.executor import workers
from impactfem.system.files import kept_in_one_file
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import on_root


def run_design(inputs: DesignInputs, folder: Path, steps: Steps, key: str) -> list[Path]:
    """Run the stage and write `design.nc`: the case's own motion, and an ensemble. Collective.

    Args:
        inputs: The inputs of the stage.
        folder: The folder of the run.
        steps: The steps of the stage.
        key: Hash of the inputs.

    Raises:
        SolutionError: Fewer than two members have a result.
        ImpactfemError: A file cannot be read or written.
    """
    with ExitStack() as held:
        ensemble = inputs.prepared.building.case.ensemble
        if ensemble is not None and ensemble.structure_motions:
            on_root(lambda: held.enter_context(kept_in_one_file(folder / FOLDER)))
        files = _run(inputs, folder, steps, key)
        on_root(held.close)
        return files


def _run(inputs: DesignInputs, folder: Path, steps: Steps, key: str) -> list[Path]:
    probes = on_root(lambda: read_probes(folder / "transient.nc"))
    whole = on_root(
        lambda: read_whole_floors(folder / "transient_maps.nc", probes["elevation"].values)
    )
    members = Members.of(inputs, folder, whole)
    waiting = members is not None and bool(members.waiting)
    if members is not None and waiting:
        with steps.step("sticks"):
            on_root(lambda: members.pound(lambda part: steps.within("sticks", part)))
    spectra = free = None
    if whole is not None and inputs.reduced is not None:
        with steps.step("vertices"):
            loads = inputs.prepared.loads
            end = float(probes.attrs["resolved_frequency"])
            spectra = _vertex_spectra(inputs, whole, loads, end)
            free = _vertex_spectra(inputs, whole, loads.without_impacts(), end)
    if members is not None and waiting:
        carrier = None if inputs.reduced is None else Carrier.of(inputs, probes, whole)
        with workers() as executor:
            if executor is not None and carrier is not None:
                with steps.step("members"):
                    members.carry(carrier, executor, lambda part: steps.within("members", part))

    def write() -> list[Path]:
        case = inputs.prepared.building.case
        law = inputs.prepared.damping
        study = DesignStudy(case, probes, whole, spectra, free_vertices=free, law=law)
        if members is not None:
            study = replace(study, members=members.values(), analysis=members.analysis)
        with steps.step("stores"):
            write_design(folder / "design.nc", study, key)
        return [folder / "design.nc"]

    return on_root(write)


def _vertex_spectra(
    inputs: DesignInputs, whole: WholeFloors, loads: Loads, end: float
) -> ResolvedSpectra:
    """Compute spectra of the governing vertices under loads of the case's motion. On rank 0.

    Their ZPA is that of the resolved band, whose end is given [Hz].
    """
    if inputs.reduced is None:
        raise ValueError("without a reduced building")
    basis = inputs.reduced.basis
    modal = modal_histories(basis, loads, inputs.prepared.damping).acceleration
    records = point_records(basis, loads, modal, whole.governing)
    LOGGER.debug(
        "design: %d of %d floor vertices govern the envelopes, each along one direction",
        len(whole.governing),
        whole.vertices.sum(),
    )
    spectra = record_spectra(records, loads.time_step, inputs.prepared.building.case.spectra)
    zpa = band_limited_zpa(records.T, loads.time_step, end)
    return ResolvedSpectra(spectra.psa, spectra.zpa, zpa)
