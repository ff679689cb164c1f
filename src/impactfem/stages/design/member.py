"""One member of an ensemble through the 3D building and the devices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.stages.design.floor_points import FloorPoints, enveloped
from impactfem.stages.design.member_loads import MemberLoads
from impactfem.stages.design.point_spectra import (
    BuildingMotion,
    Search,
    governing_of,
    point_spectra,
)
from impactfem.stages.design.records import Records
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.spectrum_choice import SpectrumChoice

Array = NDArray[np.float64]
Index = NDArray[np.int64]

WORDS = (
    *("force x", "force y", "force z"),
    *("moment x", "moment y", "moment z"),
)
"""Results of a response spectrum analysis, in the order of the components of a force."""


@dataclass(frozen=True, eq=False)
class Carrier:
    """What all members share.

    Args:
        basis: The reduced basis of the building, at all nodes whose motion is wanted.
        nodes: Nodes of the probes, shape (n_p,).
        floors: Which of the probes are on each floor.
        search: Where the vertices are sought that govern; None without fields over the floors,
            where the probes stand alone for them.
        damping: α [1/s] and β [s] of the building.
        spectra: The case's floor spectra.
        analyst: Of the devices; None without devices.
        choice: Which response spectrum analysis counts; None without devices.
    """

    basis: ReducedBasis
    nodes: Index
    floors: tuple[FloorPoints, ...]
    search: Search | None
    damping: Rayleigh
    spectra: Spectra
    analyst: Analyst | None
    choice: SpectrumChoice | None


def carry(carrier: Carrier, member: MemberLoads) -> dict[str, Array]:
    """The results of one member: what `CarriedEnsemble` gathers.

    Args:
        carrier: What all members share.
        member: Its loads.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device, or the result is not finite.
    """
    loads, probes = member.loads, len(carrier.nodes)
    motion = BuildingMotion.under(carrier.basis, loads, carrier.damping)
    chosen = Records.none() if carrier.search is None else governing_of(motion, carrier.search)
    spectra = point_spectra(
        motion,
        np.concatenate([np.repeat(carrier.nodes, 3), chosen.node]),
        np.concatenate([np.tile(np.arange(3), probes), chosen.component]),
        carrier.spectra,
    )
    psa = spectra.psa[:, : 3 * probes].reshape(len(spectra.psa), probes, 3, -1)
    pfa = spectra.pfa[: 3 * probes].reshape(probes, 3)
    vertex_psa, vertex_pfa = spectra.psa[:, 3 * probes :], spectra.pfa[3 * probes :]
    found = {
        "psa": psa,
        "pfa": pfa,
        "floor_psa": chosen.raised(enveloped(psa, carrier.floors, axis=1), vertex_psa, axis=1),
        "floor_pfa": chosen.raised(enveloped(pfa, carrier.floors, axis=0), vertex_pfa, axis=0),
        "vertices": chosen.counts(len(carrier.floors)),
        "impact_force": member.peak_force,
        "basis_error": np.array(carrier.basis.difference),
        "device_force": np.zeros((0, len(WORDS))),
        "device_spectrum": np.zeros((0, len(WORDS))),
    }
    if carrier.analyst is not None and carrier.choice is not None:
        results = carrier.analyst.analyse(loads, carrier.damping)
        found["device_force"] = np.array([one.detailed.largest for one in results])
        found["device_spectrum"] = np.array(
            [[one.value(carrier.choice, word) for word in WORDS] for one in results]
        )
    return found
