"""A small store of the stage `design` that no solver made, by the stage's own writer."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from impactfem.stages.design.carried import CarriedEnsemble
from impactfem.stages.design.case_spectra import CaseSpectra
from impactfem.stages.design.floor_points import enveloped, floor_points
from impactfem.stages.design.records import Records, RecordSpectra
from impactfem.stages.design.store import write_design
from impactfem.stages.design.whole_floors import WholeFloors
from impactfem.system.files import write_netcdf

F = np.geomspace(0.5, 50.0, 40)
DAMPING = np.array([0.02, 0.05])
NAMES = ("centre_1", "edge_1", "centre_2", "edge_2", "line_1", "tower")
HEIGHT = (3.0, 3.0, 6.0, 6.0, 6.0, 8.0)


@dataclass(frozen=True)
class WantedDesign:
    """What a store of the stage `design` is to have.

    Args:
        motions: Members of the ensemble; none without one.
        devices: Names of the anchors.
        still: Whether nothing moves along x.
        whole: Envelope of all vertices over that of those that govern; None without fields over
            the floors, and without such vertices.
        failed: Number of members that failed.
    """

    motions: int = 5
    devices: tuple[str, ...] = ("pump",)
    still: bool = False
    whole: float | None = 1.02
    failed: int = 0


def peaked(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Spectra with a narrow peak each, shape (*shape, n_f)."""
    at = rng.uniform(3.0, 20.0, (*shape, 1))
    return 1.0 + rng.uniform(5.0, 9.0, (*shape, 1)) / (1.0 + (9.0 * (F / at - 1.0)) ** 2)


def vertices(still: bool = False) -> Records:
    """A vertex of each floor along each direction, and one more of the upper floor along y."""
    places = [(s, c) for s in (0, 1) for c in range(3) if c or not still]
    floor, component = np.array([*places, (1, 1)]).T
    return Records(floor, component, 100 + np.arange(len(floor)))


def own_spectra(still: bool = False, alone: bool = False) -> CaseSpectra:
    """Spectra under the case's own motion; with the probes alone, or with vertices."""
    psa = peaked(np.random.default_rng(1), (2, len(NAMES), 3))
    if still:
        psa[:, :, 0] = 0.0
    floors, elsewhere = floor_points(NAMES, np.array([[0.0, 0.0, z] for z in HEIGHT]), {1: 0, 2: 2})
    own = CaseSpectra(
        building="B1",
        names=NAMES,
        nodes=np.arange(len(NAMES)),
        floors=floors,
        elsewhere=elsewhere,
        frequency=F,
        damping=DAMPING,
        psa=psa,
        pfa=psa[0, :, :, -1],
        maximum_frequency=50.0,
    )
    if alone:
        return own
    there = vertices(still)
    # The vertices move as much as the probes, at other frequencies.
    at_vertices = peaked(np.random.default_rng(5), (2, len(there)))
    return own.with_vertices(there, RecordSpectra(at_vertices, at_vertices[0, :, -1]))


def design_store(path: Path, asked: WantedDesign | None = None) -> CaseSpectra:
    """Write the store; gives the spectra under the case's own motion."""
    asked = asked or WantedDesign()
    rng, own = np.random.default_rng(2), own_spectra(asked.still, asked.whole is None)
    whole = None
    if asked.whole is not None:
        there = vertices(asked.still)
        empty = np.zeros((2, 3, F.size))
        known = RecordSpectra(own.vertex_spectra.psa, own.vertex_spectra.pfa)
        reached = there.raised(empty, known.psa[0], axis=0)
        reached_pfa = there.raised(empty[..., 0], known.pfa, axis=0)
        whole = WholeFloors(
            frequency=F,
            damping=0.02,
            psa=asked.whole * reached,
            pfa=asked.whole * reached_pfa,
            vertices=np.array([50, 60]),
            points_per_cycle=2.0,
            governing=there,
            position=np.stack([there.node, 0.0 * there.node, 3.0 + 3.0 * there.floor], axis=1),
            governing_psa=reached,
            governing_pfa=reached_pfa,
            candidates=there,
        )
    carried = None
    if asked.motions:
        n, d = asked.motions, len(asked.devices)
        psa = peaked(rng, (n, 2, len(NAMES), 3))
        carried = CarriedEnsemble(
            members=tuple(f"seed_{k}" for k in range(n)),
            failed={f"seed_{n + k}": "too far" for k in range(asked.failed)},
            psa=psa,
            pfa=psa[:, 0, :, :, -1],
            floor_psa=enveloped(psa, own.floors, axis=2),
            floor_pfa=enveloped(psa[:, 0, :, :, -1], own.floors, axis=1),
            vertices=np.full((n, 2, 3), 4),
            floors=(1, 2),
            impact_force=rng.uniform(8e7, 1.4e8, (n, 2)),
            devices=asked.devices,
            device_force=rng.uniform(6e4, 1.1e5, (n, d, 6)),
            device_spectrum=rng.uniform(5e4, 1e5, (n, d, 6)),
            analysis="srss",
            basis_error=np.full(n, 1e-3),
        )
    case: Any = SimpleNamespace(
        title="Two buildings", content_hash=lambda: "abc", shown_direction="y"
    )
    write_design(path, case, own, whole, carried, "key")
    return own


def stick_store(path: Path) -> None:
    """The sticks beside it: two floors of two buildings along y."""
    psa = peaked(np.random.default_rng(3), (2, 4, 1))
    data = xr.Dataset(
        {
            "psa": (("damping", "station", "direction", "frequency"), psa),
            "pfa": (("station", "direction"), psa[0, :, :, -1]),
            "frequency": ("frequency", F),
            "damping": ("damping", DAMPING),
            "direction": ("direction", np.array(["y"], dtype=object)),
            "station_building": ("station", np.array(["B2", "B2", "B1", "B1"], dtype=object)),
            "station_floor": ("station", np.array([1, 2, 1, 2])),
        },
        attrs={"title": "Two buildings", "inputs": "key"},
    )
    write_netcdf(path, data)


def ensemble_store(path: Path, force: np.ndarray, building: str = "B1") -> None:
    """The stage `ensemble` beside it, with impact forces of shape (n_motions, 2)."""
    names = [f"pounding.peak_force.floor_{k}" for k in (1, 2)]
    data = xr.Dataset(
        {
            "value": (("motion", "scalar"), force),
            "motion": ("motion", np.array([f"seed_{k}" for k in range(len(force))], dtype=object)),
            "scalar": ("scalar", np.array(names, dtype=object)),
        },
        attrs={"studied_building": building},
    )
    write_netcdf(path, data)
