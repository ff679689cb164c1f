"""One member of an ensemble through the 3D building and the devices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.design.bases import superposed
from impactfem.design.member_loads import MemberLoads
from impactfem.equipment.analysis import Analyst
from impactfem.equipment.spectrum_choice import SpectrumChoice
from impactfem.transient.reduced_basis import ReducedBasis
from impactfem.transient.response import node_spectra

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
        bases: Reduced bases of the building (see `bases`), at its probes.
        nodes: Nodes of the probes, shape (n_p,).
        damping: α [1/s] and β [s] of the building.
        spectra: The case's floor spectra.
        analyst: Of the devices; None without devices.
        choice: Which response spectrum analysis counts; None without devices.
    """

    bases: tuple[ReducedBasis, ...]
    nodes: Index
    damping: tuple[float, float]
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
    loads = member.loads
    response = superposed(carrier.bases, loads, carrier.damping, carrier.nodes)
    spectra = node_spectra(response, carrier.spectra)
    found = {
        "psa": spectra.psa.reshape(len(spectra.damping), len(carrier.nodes), 3, -1),
        "pfa": np.abs(response.acceleration).max(axis=0),
        "impact_force": member.peak_force,
        "basis_error": np.array(max(basis.difference for basis in carrier.bases)),
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
