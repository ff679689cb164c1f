"""A small store of the stage `design` that no solver made, by the stage's own writer."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pandas as pd
import xarray as xr

from impactfem.stages.design.envelopes import DesignStudy, ResolvedSpectra
from impactfem.stages.design.floors import WholeFloors, enveloped, probe_points
from impactfem.stages.design.store import write_design
from impactfem.stages.ensemble import store as ensemble
from impactfem.stages.pounding import store as pounding
from impactfem.stages.stores import dataset
from impactfem.system.files import write_netcdf

F = np.geomspace(0.5, 50.0, 40)
DAMPING = np.array([0.02, 0.05])
NAMES = ("centre_1", "edge_1", "centre_2", "edge_2", "line_1", "tower")
HEIGHT = (3.0, 3.0, 6.0, 6.0, 6.0, 8.0)


@dataclass(frozen=True)
class WantedDesign:
    """What a store of the stage `design` is to have."""

    motions: int = 5  #: members of the ensemble; none without one
    devices: tuple[str, ...] = ("pump",)  #: names of the anchors
    still: bool = False  #: whether nothing moves along x
    #: envelope of all vertices over that of those that govern; None without fields over the floors
    whole: float | None = 1.02
    failed: int = 0  #: number of members that failed


def peaked(rng, shape):
    """Spectra with a narrow peak each, shape (*shape, n_f)."""
    at = rng.uniform(3.0, 20.0, (*shape, 1))
    return 1.0 + rng.uniform(5.0, 9.0, (*shape, 1)) / (1.0 + (9.0 * (F / at - 1.0)) ** 2)


def vertices(still=False):
    """A vertex of each floor along each direction, and one more of the upper floor along y."""
    places = [(s, c) for s in (0, 1) for c in range(3) if c or not still]
    floor, component = np.array([*places, (1, 1)]).T
    node = 100 + np.arange(len(floor))
    at = {"x": node, "y": 0.0 * node, "z": 3.0 + 3.0 * floor}
    return pd.DataFrame({"floor": floor, "component": component, "node": node} | at)


def probes_of(still=False):
    """Spectra of the probes under the case's own motion."""
    psa = peaked(np.random.default_rng(1), (2, len(NAMES), 3))
    if still:
        psa[:, :, 0] = 0.0
    height = np.array(HEIGHT)
    turned = peaked(np.random.default_rng(3), (2, 3, 3))
    return xr.Dataset(
        {
            "rotational_psa": (("damping", "turning", "rotation", "frequency"), turned),
            "rotational_pfa": (("turning", "rotation"), turned[0, :, :, -1]),
            "psa": (("damping", "probe", "component", "frequency"), psa),
            "pfa": (("probe", "component"), psa[0, :, :, -1]),
            "zpa": (("probe", "component"), psa[0, :, :, -1]),
            "probe_node": ("probe", np.arange(len(NAMES))),
            "on_floor": (("probe", "station"), height[:, None] == [3.0, 6.0]),
            "station_floor": ("station", [1, 2]),
            "elevation": ("station", [3.0, 6.0]),
            "centre": ("station", [0, 2]),
        },
        coords={
            "probe": list(NAMES),
            "turning": ["centre_1", "centre_2", "line_1"],
            "rotation": ["rx", "ry", "rz"],
            "damping": DAMPING,
            "frequency": F,
        },
        attrs={"building": "B1", "maximum_frequency": 50.0, "resolved_frequency": 50.0},
    )


@dataclass(frozen=True)
class Stored:
    """What a store was written from: the spectra at the probes, and at the vertices."""

    psa: np.ndarray
    vertex_psa: np.ndarray

    def probes(self, damping, component):
        """Spectra of the probes of the upper floor, shape (3, n_f)."""
        return self.psa[damping, 2:5, component]

    def upper(self, damping):
        """Spectra of the vertices of the upper floor along y, shape (2, n_f)."""
        return self.vertex_psa[damping, [4, 6]]


def design_store(path, asked=None):
    """Write the store; gives the spectra under the case's own motion."""
    asked = asked or WantedDesign()
    rng, probes = np.random.default_rng(2), probes_of(asked.still)
    there = vertices(asked.still)
    # The vertices move as much as the probes, at other frequencies.
    at_vertices = peaked(np.random.default_rng(5), (2, len(there)))
    whole = None
    members = {}
    spectra = None
    if asked.whole is not None:
        peaks = at_vertices[0, :, -1]
        spectra = ResolvedSpectra(at_vertices, peaks, peaks)
        with_peak = np.concatenate([at_vertices[0], at_vertices[0, :, -1:]], axis=1)
        reached = enveloped(there, with_peak, 2)
        whole = WholeFloors(
            frequency=F,
            damping=0.02,
            points_per_cycle=2.0,
            whole_psa=asked.whole * reached[..., :-1],
            whole_zpa=asked.whole * reached[..., -1],
            reached_psa=reached[..., :-1],
            reached_zpa=reached[..., -1],
            vertices=np.array([50, 60]),
            governing=there,
            candidates=there,
        )
    if asked.motions:
        n, d = asked.motions, len(asked.devices)
        psa = peaked(rng, (n, 2, len(NAMES), 3))
        points = probe_points(probes)
        rows, along = points["point"].to_numpy(), points["component"].to_numpy()
        pfa = psa[:, 0, :, :, -1]
        members = {
            "motion": [f"seed_{k}" for k in range(n)],
            "failed": [f"seed_{n + k}" for k in range(asked.failed)],
            "failed_reason": ["too far"] * asked.failed,
            "edge": [1, 2],
            "edge_storey": [0, 0],
            "member_psa": enveloped(points, psa[:, :, rows, along], 2, axis=2),
            "member_zpa": enveloped(points, pfa[:, rows, along], 2, axis=1),
            "member_centre_peak": psa[:, :, [0, 2]].max(axis=-1),
            "member_vertices": np.full((n, 2, 3), 4),
            "member_impact_force": rng.uniform(8e7, 1.4e8, (n, 2)),
        }
        if d:
            members |= {
                "device": list(asked.devices),
                "component": ["x", "y", "z", "rx", "ry", "rz"],
                "member_device_force": rng.uniform(6e4, 1.1e5, (n, d, 6)),
                "member_device_spectrum": rng.uniform(5e4, 1e5, (n, d, 6)),
            }
        members["member_basis_error"] = np.full(n, 1e-3)
    case = SimpleNamespace(title="Two buildings", content_hash=lambda: "abc", shown_direction="y")
    analysis = "srss" if members else ""
    write_design(path, DesignStudy(case, probes, whole, spectra, members, analysis), "key")
    return Stored(probes["psa"].values, at_vertices)


def stick_store(path):
    """The sticks beside it: two floors of two buildings along y."""
    psa = peaked(np.random.default_rng(3), (2, 4, 1))
    values = {
        "psa": psa,
        "pfa": psa[0, :, :, -1],
        "frequency": F,
        "damping": DAMPING,
        "direction": ["y"],
        "station_building": ["B2", "B2", "B1", "B1"],
        "station_floor": [1, 2, 1, 2],
    }
    attributes = {"title": "Two buildings", "inputs": "key"}
    write_netcdf(path, dataset(pounding.OUTPUTS, values, attributes=attributes))


def ensemble_store(path, force, building="B1"):
    """The stage `ensemble` beside it, with impact forces of shape (n_motions, 2)."""
    values = {
        "value": force,
        "motion": [f"seed_{k}" for k in range(len(force))],
        "scalar": [f"pounding.peak_force.floor_{k}" for k in (1, 2)],
    }
    attributes = {"studied_building": building}
    write_netcdf(path, dataset(ensemble.OUTPUTS, values, attributes=attributes))
