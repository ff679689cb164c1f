"""A small store of the stage `device` that no solver made, in the layout of its `store.py`.

The force of a device is a pulse; response spectrum analyses find a given part of it.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

DEVICE_STEP = 1e-3
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
    "srss.rotations": (0.97, 0.96),
    "srss.broadened": (0.8, 1.2),
    "srss.rotations.broadened": (1.1, 1.25),
}
COMPONENTS = ["x", "y", "z", "rx", "ry", "rz"]
MASSES = (1219.0, 327.0)
FREQUENCIES = (30.5, 30.5, 82.9, 82.9)
HEIGHT = 0.46
DEVICE_SCALARS: dict[str, float | None] = {"basis_error": 0.002, "basis_vectors": 250.0}


@dataclass(frozen=True)
class WantedDevice:
    """What a store of the stage `device` is to have.

    Args:
        devices: Their names.
        dampings: Number of damping cases.
        direction: That is shown.
        choices: Names of the analyses, and what they find of the force without and with impacts.
        detailed: Largest force without and with impacts by damping [N].
        impact_force: Largest impact force of all dampings [N].
        imbalance: Of action and reaction.
        pulls: Net tension without and with impacts [N]; nan for a weight that is not known.
        nodes: Number of nodes of an anchor.
        from_modes: Whether the devices have modes in place of springs and a body.
        beam: Whether they have a beam.
        cylinder: Whether the body is a cylinder.
        scalars: Scalars that differ from `DEVICE_SCALARS`; None for one that does not exist.
        notes: Of the analyses.
    """

    devices: tuple[str, ...] = ("pump",)
    dampings: int = 4
    direction: str = "y"
    choices: dict[str, tuple[float, float]] = field(default_factory=lambda: SHARES)
    detailed: tuple[tuple[float, float], ...] = DETAILED
    impact_force: float = 120e6
    imbalance: float = 1e-12
    pulls: tuple[float, float] = (-4e3, -1e3)
    nodes: int = 5
    from_modes: bool = False
    beam: bool = True
    cylinder: bool = True
    scalars: dict[str, float | None] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def device_store(asked: WantedDevice) -> xr.Dataset:
    """The store."""
    names = list(DAMPINGS)[: asked.dampings]
    scalars = [Scalar(f"device.{k}", v, "-") for k, v in (DEVICE_SCALARS | asked.scalars).items()]
    variables = {
        **_responses(asked),
        **_modes(asked),
        **_cases(asked),
        **_drawings(asked),
        **_pulls(asked, asked.pulls),
        **_ordinates(asked),
    }
    store = xr.Dataset(
        variables,
        coords={
            "case": ("case", np.array(names, dtype=object)),
            "impact": ["without", "with"],
            "device": ("device", np.array(asked.devices, dtype=object)),
            "component": COMPONENTS,
            "axis": ["x", "y", "z"],
            "bending_about": ["x", "y"],
            "mode": np.arange(1, 6),
            "note": ("note", np.array(asked.notes, dtype=object)),
            "choice": ("choice", np.array(list(asked.choices), dtype=object)),
            "frequency": ("frequency", np.geomspace(0.5, 450.0, 60)),
            "time": ("time", DEVICE_STEP * np.arange(2001)),
        },
        attrs={
            "building": "one",
            "shown_direction": asked.direction,
            "headline": "srss",
        },
    )
    return with_scalars(store, scalars)


def _responses(asked: WantedDevice) -> dict[str, tuple]:
    time, frequency = DEVICE_STEP * np.arange(2001), np.geomspace(0.5, 450.0, 60)
    count, column = len(asked.devices), "xyz".index(asked.direction)
    shape = (asked.dampings, 2, count)
    force = np.zeros((*shape, 6, time.size), dtype=np.float32)
    largest = np.zeros((*shape, 6))
    found = np.zeros((*shape, len(asked.choices), 6))
    psa = np.zeros((*shape, 3, frequency.size))
    pulse = np.exp(-(((time - 1.2) / 0.2) ** 2)) * np.cos(2 * np.pi * 30.0 * (time - 1.2))
    hill = 1.0 + 2.0 * np.exp(-(np.log(frequency / 40.0) ** 2))
    for c in range(asked.dampings):
        for impact in range(2):
            for d in range(count):
                peak = asked.detailed[c][impact] * (1.0 + d)
                force[c, impact, d, column] = peak * pulse
                # Half of it in other components: what is read must be that of the direction.
                largest[c, impact, d] = 0.5 * peak
                largest[c, impact, d, column] = peak
                psa[c, impact, d, column] = hill * peak / 5e3
                for k, shares in enumerate(asked.choices.values()):
                    found[c, impact, d, k] = 0.1 * peak
                    found[c, impact, d, k, column] = shares[impact] * peak
    dims = ("case", "impact", "device")
    return {
        "force": ((*dims, "component", "time"), force),
        # The floor at the anchor: a fifth of the force over a tonne, so that S / ZPA is near 1.
        "anchor_acceleration": ((*dims, "component", "time"), force / 5e3),
        "largest_force": ((*dims, "component"), largest),
        "imbalance": (dims, np.full(shape, asked.imbalance)),
        "psa": ((*dims, "axis", "frequency"), psa),
        "spectrum_force": ((*dims, "choice", "component"), found),
    }


def _modes(asked: WantedDevice) -> dict[str, tuple]:
    count = len(asked.devices)
    frequency = np.full((count, 5), np.nan)
    damping = np.full((count, 5), np.nan)
    mass = np.full((count, 6, 5), np.nan)
    for d in range(count):
        frequency[d, :4] = FREQUENCIES
        damping[d, :4] = 0.02
        mass[d, :, :4] = 0.0
        for mode in range(4):
            mass[d, mode % 2, mode] = MASSES[mode // 2]
            mass[d, 4 - mode % 2, mode] = HEIGHT**2 * MASSES[mode // 2]
    # A last mode in the second device only, from a table: along z.
    if count > 1:
        frequency[1, 4], damping[1, 4] = 120.0, 0.03
        mass[1, :, 4] = [0.0, 0.0, 900.0, 0.0, 0.0, 0.0]
    return {
        "mode_frequency": (("device", "mode"), frequency),
        "mode_damping": (("device", "mode"), damping),
        "effective_mass": (("device", "component", "mode"), mass),
        "anchor_position": (("device", "xyz"), np.tile([4.1, 2.6, 12.0], (count, 1))),
        "anchor_floor": ("device", np.full(count, 3)),
        "anchor_nodes": ("device", np.full(count, asked.nodes)),
    }


def _ordinates(asked: WantedDevice) -> dict[str, tuple]:
    """Along x and y and about x, at the modes that these move; no other component moves."""
    psa = np.full((asked.dampings, 2, len(asked.devices), 6, 5), np.nan)
    psa[..., [0, 1, 3], :] = 0.0
    psa[..., 0, 0:4:2] = 1.0
    psa[..., 1, 1:4:2] = 4.0, 8.0
    psa[..., 3, 1:4:2] = 2.0
    psa[:, 1] *= 10.0
    return {"mode_psa": (("case", "impact", "device", "component", "mode"), psa)}


def _pulls(asked: WantedDevice, pulls: tuple[float, float]) -> dict[str, tuple]:
    """15 kN on anchors at 0.5 m; all of the base is lifted by 20 kN less than one is pulled."""
    count = len(asked.devices)
    dims = ("case", "impact", "device")
    tension = np.broadcast_to(np.array(pulls)[None, :, None], (asked.dampings, 2, count))
    by_choice = np.broadcast_to(tension[..., None], (*tension.shape, len(asked.choices)))
    weight = np.tile([0.0, 0.0, -15e3, 0.0, 0.0, 0.0], (count, 1))
    return {
        "weight_force": (("device", "component"), weight),
        "anchor_radius": ("device", np.full(count, 0.5)),
        "net_tension": (dims, tension.copy()),
        "net_uplift": (dims, tension - 20e3),
        "spectrum_tension": ((*dims, "choice"), 1.1 * by_choice),
    }


def _drawings(asked: WantedDevice) -> dict[str, tuple]:
    count = len(asked.devices)
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
    springs = known * np.array([1.4e8, 1.4e8, np.inf, 3e7, 3e7, np.inf])
    return {
        "base_stiffness": (("device", "component"), np.tile(springs, (count, 1))),
        "body_mass": ("device", np.full(count, 1500.0 * known)),
        "body_inertia": (("device", "axis"), np.full((count, 3), 220.0 * known)),
        "body_height": ("device", np.full(count, HEIGHT * known)),
        "body_radius": ("device", np.full(count, 0.5 * size)),
        "body_length": ("device", np.full(count, 1.0 * size)),
        "beam_length": ("device", np.full(count, HEIGHT * beam)),
        "beam_mass": ("device", np.full(count, 45.9 * beam)),
        "beam_bending": (("device", "bending_about"), np.full((count, 2), 8e7 * beam)),
        "level_height": (("device", "level"), np.tile(levels, (count, 1))),
        "mode_shape": (
            ("device", "mode", "level", "component"),
            np.tile(known * shape, (count, 1, 1, 1)),
        ),
    }


def _cases(asked: WantedDevice) -> dict[str, tuple]:
    dampings = list(DAMPINGS.values())[: asked.dampings]
    return {
        "mass_coefficient": ("case", np.array([d[0] for d in dampings])),
        "stiffness_coefficient": ("case", np.array([d[1] for d in dampings])),
        "epsilon": ("case", np.array(EPSILON[: asked.dampings])),
        "epsilon_calibrated": ("case", np.array(CALIBRATED[: asked.dampings])),
        "impact_force": ("case", np.full(asked.dampings, asked.impact_force)),
    }


def device_folder(folder: Path, **wanted: object) -> Path:
    """Write `device.nc` of a run into a folder and give the folder."""
    asked = WantedDevice(**wanted)  # type: ignore[arg-type]
    write_netcdf(folder / "device.nc", device_store(asked))
    return folder
