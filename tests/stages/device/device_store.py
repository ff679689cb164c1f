"""A small store of the stage `device` that no solver made, in the layout of its `store.py`.

The force of a device is a pulse; response spectrum analyses find a given part of it.
"""

from dataclasses import dataclass, field
from itertools import product

import numpy as np

from impactfem.stages.device.choice import SpectrumChoice
from impactfem.stages.device.store import OUTPUTS, differences, labels_of
from impactfem.stages.stores import dataset
from impactfem.system.files import write_netcdf

TIME, FREQUENCY = 1e-3 * np.arange(2001), np.geomspace(0.5, 450.0, 60)
DAMPINGS = {
    "own": (0.838, 1.06e-3),
    "under-damped": (0.838, 2.12e-4),
    "damped": (0.838, 1.06e-3),
    "over-damped": (0.559, 3.18e-3),
}
EPSILON = (np.nan, 0.89, 0.67, 0.41)
CALIBRATED = (0, 1, 1, 1)
# By damping: without impact, with impacts.
DETAILED = ((10e3, 66e3), (12e3, 116e3), (10e3, 66e3), (9e3, 64e3))
SHARES = {
    "srss": (0.65, 0.95),
    "srss, rotations": (0.97, 0.96),
    "srss, broadened": (0.8, 1.2),
    "srss, rotations, broadened": (1.1, 1.25),
}
KINDS = [{}, {"source": "envelope"}, {"source": "envelope-dampings"}, {"source": "given"}]
KINDS += [{"supports": "abs"}, {"supports": "envelope"}]
KINDS += [{"rigid": "gupta"}, {"rigid": "lindley-yow"}]
FLAGS = [{}, {"rotations": True}, {"broadened": True}, {"rotations": True, "broadened": True}]
# Analyses by their names.
KNOWN = {
    choice.label: choice
    for kind, flags in product(KINDS, FLAGS)
    for modal in ("srss", "cqc")
    for choice in (SpectrumChoice(modal, **kind, **flags),)
}
COMPONENTS = ["x", "y", "z", "rx", "ry", "rz"]
MASSES = (1219.0, 327.0)
FREQUENCIES = (30.5, 30.5, 82.9, 82.9)
HEIGHT = 0.46


@dataclass(frozen=True)
class WantedDevice:
    """What a store of the stage `device` is to have."""

    devices: tuple[str, ...] = ("pump",)  #: their names
    dampings: int = 4  #: number of damping cases
    direction: str = "y"  #: that is shown
    #: names of the analyses, and what they find of the force without and with impacts
    choices: dict[str, tuple[float, float]] = field(default_factory=lambda: SHARES)
    #: largest force without and with impacts by damping [N]
    detailed: tuple[tuple[float, float], ...] = DETAILED
    impact_force: float = 120e6  #: largest impact force of all dampings [N]
    imbalance: float = 1e-12  #: of action and reaction
    #: net tension without and with impacts [N]; nan for a weight that is not known
    pulls: tuple[float, float] = (-4e3, -1e3)
    nodes: int = 5  #: number of nodes of an anchor
    from_modes: bool = False  #: whether the devices have modes in place of springs and a body
    beam: bool = True  #: whether they have a beam
    cylinder: bool = True  #: whether the body is a cylinder
    basis_error: float = 0.002  #: error estimate of the reduced model
    notes: tuple[str, ...] = ()  #: of the analyses


def device_store(asked):
    """The store."""
    alpha, beta = np.array(list(DAMPINGS.values())[: asked.dampings]).T
    values = {
        **_responses(asked),
        **_modes(asked),
        **_drawings(asked),
        "mass_coefficient": alpha,
        "stiffness_coefficient": beta,
        "epsilon": EPSILON[: asked.dampings],
        "epsilon_calibrated": CALIBRATED[: asked.dampings],
        "impact_force": np.full(asked.dampings, asked.impact_force),
        "case": list(DAMPINGS)[: asked.dampings],
        "impact": ["without", "with"],
        "device": asked.devices,
        "component": COMPONENTS,
        "axis": ["x", "y", "z"],
        "bending_about": ["x", "y"],
        "mode": np.arange(1, 6),
        "note": asked.notes,
        **labels_of([KNOWN[name] for name in asked.choices]),
        "frequency": FREQUENCY,
        "basis_error": asked.basis_error,
        "basis_vectors": 250,
        "time": TIME,
    }
    attributes = {
        "building": "one",
        "shown_direction": asked.direction,
        "headline": "srss",
        "resolved_frequency": 1e3,
    }
    return dataset(OUTPUTS, values, attributes=attributes)


def _responses(asked):
    column = "xyz".index(asked.direction)
    # Of each load: the second device has twice the force of the first.
    detailed = np.array(asked.detailed[: asked.dampings])[..., None]
    peak = detailed * (1.0 + np.arange(len(asked.devices)))
    pulse = np.exp(-(((TIME - 1.2) / 0.2) ** 2)) * np.cos(2 * np.pi * 30.0 * (TIME - 1.2))
    hill = 1.0 + 2.0 * np.exp(-(np.log(FREQUENCY / 40.0) ** 2))
    # Half of it in other components: what is read must be that of the direction.
    along = np.where(np.arange(6) == column, 1.0, 0.5)
    force = peak[..., None, None] * (along == 1.0)[:, None] * pulse
    shares = np.array(list(asked.choices.values())).T[:, None, :, None]
    # Along x and y and about x, at the modes that these move; no other component moves.
    ordinate = np.full((6, 5), np.nan)
    ordinate[[0, 1, 3]] = 0.0
    ordinate[0, 0:4:2], ordinate[1, 1:4:2], ordinate[3, 1:4:2] = 1.0, (4.0, 8.0), 2.0
    factor = np.array([1.0, 10.0])[:, None, None, None] * np.ones((*peak.shape, 1, 1))
    tension = np.broadcast_to(np.array(asked.pulls)[:, None], peak.shape)
    psa = peak[..., None, None] / 5e3 * (along[:3] == 1.0)[:, None] * hill
    by_spectrum = peak[..., None, None] * np.where(along == 1.0, shares, 0.1)
    peaks = np.concatenate([(peak[..., None] * along)[..., None, :], by_spectrum], axis=-2)
    weight = np.nan if np.isnan(asked.pulls[0]) else 15e3
    return {
        "force": force.astype(np.float32),
        # The floor at the anchor: a fifth of the force over a tonne, so that S / ZPA is near 1.
        "anchor_acceleration": (force / 5e3).astype(np.float32),
        "peak_force": peaks,
        "relative_difference": differences(peaks[..., column]),
        "imbalance": np.full(peak.shape, asked.imbalance),
        "psa": psa,
        "psa_peak": psa.max(axis=-1),
        "psa_peak_frequency": FREQUENCY[psa.argmax(axis=-1)],
        "pfa": np.abs(force[..., :3, :]).max(axis=-1) / 5e3,
        "zpa": np.abs(force[..., :3, :]).max(axis=-1) / 5e3,
        "mode_psa": factor * ordinate,
        # 15 kN on anchors at 0.5 m; all of the base is lifted by 20 kN less than one is pulled.
        "net_tension": np.stack([tension, *(1.1 * tension for _ in asked.choices)], axis=-1),
        "net_uplift": np.concatenate([(tension - 20e3)[..., None], peaks[..., 1:, 2] - weight], -1),
    }


def _modes(asked):
    count = len(asked.devices)
    frequency = np.tile([*FREQUENCIES, np.nan], (count, 1))
    damping = np.tile([*4 * [0.02], np.nan], (count, 1))
    mass = np.full((count, 6, 5), np.nan)
    mass[..., :4] = 0.0
    for mode in range(4):
        mass[:, mode % 2, mode] = MASSES[mode // 2]
        mass[:, 4 - mode % 2, mode] = HEIGHT**2 * MASSES[mode // 2]
    # A last mode in the second device only, from a table: along z.
    if count > 1:
        frequency[1, 4], damping[1, 4] = 120.0, 0.03
        mass[1, :, 4] = [0.0, 0.0, 900.0, 0.0, 0.0, 0.0]
    return {
        "mode_frequency": frequency,
        "mode_damping": damping,
        "effective_mass": mass,
        "mode_mass": mass[:, :3].max(axis=1),
    }


def _drawings(asked):
    known = np.nan if asked.from_modes else 1.0
    beam = known if asked.beam else np.nan
    size = known if asked.cylinder else np.nan
    levels = known * np.linspace(0.0, HEIGHT, 3)
    shape = np.zeros((5, 3, 6))
    for mode in range(4):
        turn = 1.0 if mode < 2 else -1.5
        # u_x = s + θ_y z and u_y = s - θ_x z.
        shape[mode, :, mode % 2] = 0.01 + 0.03 * turn * levels
        shape[mode, :, 4 - mode % 2] = 0.03 * turn * (1.0 if mode % 2 == 0 else -1.0)
    of_one = {
        "anchor_position": [4.1, 2.6, 12.0],
        "anchor_floor": 3,
        "anchor_nodes": asked.nodes,
        "anchor_radius": 0.5,
        "weight": np.nan if np.isnan(asked.pulls[0]) else 15e3,
        "weight_force": [0.0, 0.0, -15e3, 0.0, 0.0, 0.0],
        "base_stiffness": known * np.array([1.4e8, 1.4e8, np.inf, 3e7, 3e7, np.inf]),
        "body_mass": 1500.0 * known,
        "body_inertia": np.full(3, 220.0 * known),
        "body_height": HEIGHT * known,
        "body_radius": 0.5 * size,
        "body_length": 1.0 * size,
        "beam_length": HEIGHT * beam,
        "beam_mass": 45.9 * beam,
        "beam_bending": np.full(2, 8e7 * beam),
        "level_height": levels,
        "mode_shape": known * shape,
    }
    return {name: np.stack(len(asked.devices) * [values]) for name, values in of_one.items()}


def device_folder(folder, **wanted):
    """Write `device.nc` of a run into a folder and give the folder."""
    asked = WantedDevice(**wanted)  # type: ignore[arg-type]
    write_netcdf(folder / "device.nc", device_store(asked))
    return folder
