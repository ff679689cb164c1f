"""Small stores of the stage `transient` that no solver made, in the layout of its `store.py`.

Slabs above one another, with a pulse that travels across them at a known speed.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from impactfem.dynamics.damping import UNDAMPED
from impactfem.stages.building import store as building
from impactfem.stages.pounding import store as pounding
from impactfem.stages.stores import dataset
from impactfem.stages.transient import store as transient
from impactfem.stages.transient.findings import findings, transient_scalars
from impactfem.stages.transient.maps import MAP_OUTPUTS
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

from .wall_store import WantedWall, calibrate_store

STEP = 1e-3
STEPS = 2001
LENGTH, WIDTH = 12.0, 6.0
START, LASTS = 0.5, 0.012
SPEED = 2000.0
HIGHEST = 450.0
XYZ = ["x", "y", "z"]


@dataclass(frozen=True)
class Wanted:
    """What a set of stores is to have."""

    floors: tuple[int, ...] = (1, 2, 3)
    direction: str = "y"  #: of the first motion; the impact edge is at its upper end
    loads: tuple[int, ...] = (2, 3)  #: floors with impact forces
    solver: str = "reduced"  #: or "full"
    maps: bool = True  #: whether there are fields
    frames: bool = True  #: whether these have the frames of a film
    dampings: tuple[float, ...] = (0.05,)  #: of the spectra
    frequencies: int = 41  #: how many
    model: str = "stick"  #: what pounds: or "structure"
    plates: bool = False  #: whether a base plate is tied to the highest floor


@pytest.fixture
def transient_folder(tmp_path):
    """Write the stores of a run and give its folder."""

    def write(**wanted):
        asked = Wanted(**wanted)  # type: ignore[arg-type]
        slab = _slab(asked.direction)
        write_netcdf(tmp_path / "building.nc", _building(asked, slab))
        write_netcdf(tmp_path / "pounding.nc", _sticks(asked))
        write_netcdf(tmp_path / "transient.nc", _transient(asked, slab))
        if asked.maps:
            write_netcdf(tmp_path / "transient_maps.nc", _maps(asked, slab))
        return tmp_path

    return write


@pytest.fixture
def wall_folder(tmp_path):
    """Write the store of a run against a wall and give its folder."""

    def write(**wanted):
        asked = WantedWall(**wanted)  # type: ignore[arg-type]
        write_netcdf(tmp_path / "calibrate.nc", calibrate_store(asked))
        return tmp_path

    return write


@dataclass(frozen=True)
class Slab:
    """A plan of 4 by 4 squares of two six-node triangles each, and its probes' nodes."""

    plan: np.ndarray
    cells: np.ndarray
    edge: np.ndarray
    centre: int
    line: tuple[int, ...]


def _slab(direction):
    count = 9
    across = direction == "x"
    size = (WIDTH, LENGTH) if across else (LENGTH, WIDTH)
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    plan = np.stack([i.ravel() * size[0], j.ravel() * size[1]], axis=1) / (count - 1)
    number = np.arange(count**2).reshape(count, count)
    cells = []
    for a in range(0, count - 1, 2):
        for b in range(0, count - 1, 2):
            n = number[a : a + 3, b : b + 3]
            cells.append([n[0, 0], n[2, 0], n[2, 2], n[1, 0], n[2, 1], n[1, 1]])
            cells.append([n[0, 0], n[2, 2], n[0, 2], n[1, 1], n[1, 2], n[0, 1]])
    if across:
        edge, line = number[-1], number[::-2, count // 2]
    else:
        edge, line = number[:, -1], number[count // 2, ::-2]
    lines = np.stack([edge[:-2:2], edge[2::2], edge[1::2]], axis=1)
    return Slab(plan, np.array(cells), lines, int(number[4, 4]), tuple(int(n) for n in line))


def _building(asked, slab):
    """The slabs above one another, on columns at two corners."""
    n, levels = len(slab.plan), range(len(asked.floors))
    base = np.column_stack([slab.plan[[0, n - 1]], np.zeros(2)])
    slabs = [np.column_stack([slab.plan, np.full(n, 4.0 * (k + 1))]) for k in levels]
    foot = n * len(levels)
    values = {
        "node_position": np.concatenate([*slabs, base]),
        "triangle_node": np.concatenate([slab.cells + n * k for k in levels]),
        "triangle_part": np.repeat(levels, len(slab.cells)),
        "shell_part_name": [f"floor_{k}" for k in asked.floors],
        "line_node": [[foot + c, corner, corner] for c, corner in enumerate((0, n - 1))],
        "line_part": [0, 0],
        "beam_part_name": [f"column_{asked.floors[0]}"],
        "edge_line": np.concatenate([slab.edge + n * k for k in levels]),
        "edge_floor": np.repeat(asked.floors, len(slab.edge)),
        "centre": slab.centre + n * np.array(levels),
    }
    return dataset(building.OUTPUTS, values, attributes={})


def _sticks(asked):
    time = np.arange(0.0, 2.2, 0.5e-3)
    frequency = np.geomspace(0.5, 500.0, asked.frequencies)
    stations = len(asked.floors)
    wave = np.sin(2.0 * np.pi * 2.0 * time)[:, None, None] * np.ones((1, stations, 1))
    psa = 20.0 * np.exp(-(np.log(frequency / 20.0) ** 2)) + 0.1
    values = {
        "time": time,
        "displacement": 0.01 * wave,
        "acceleration": 2.0 * wave,
        "psa": np.broadcast_to(psa, (len(asked.dampings), stations, 1, len(psa))),
        "building": ["one"],
        "building_model": [asked.model],
        "station_building": ["one"] * stations,
        "station_floor": asked.floors,
        "component": [asked.direction],
        "direction": [asked.direction],
        "damping": asked.dampings,
        "frequency": frequency,
        "pair": ["one.floor_1-two.floor_1"],
        "pair_onset_force": [1e5],
    }
    return dataset(pounding.OUTPUTS, values, attributes={})


def pulse(time):
    """Half a sine, as long as the impact."""
    inside = (time >= 0.0) & (time <= LASTS)
    return np.where(inside, np.sin(np.pi * time / LASTS), 0.0)


def _transient(asked, slab):
    names, nodes, kinds, floors = _probes(asked, slab)
    c = XYZ.index(asked.direction)
    time = STEP * np.arange(STEPS)
    position = _building(asked, slab)["node_position"].values[list(nodes)]
    distance = position[:, c].max() - position[:, c]
    ground = np.sin(2.0 * np.pi * 2.0 * time)
    displacement = np.zeros((STEPS, len(nodes), 3))
    acceleration = np.zeros_like(displacement)
    displacement[:, :, c] = 0.01 * ground[:, None]
    if asked.loads:
        for k, d in enumerate(distance):
            acceleration[:, k, c] = -50.0 * pulse(time - START - d / SPEED)
    else:
        acceleration[:, :, c] = ground[:, None]
    frequency = np.geomspace(0.5, 500.0, asked.frequencies)
    peak = 40.0 + 30.0 * np.arange(len(nodes)) / len(nodes)
    psa = np.zeros((len(asked.dampings), len(nodes), 3, len(frequency)))
    psa[:] = peak[:, None, None] * np.exp(-(np.log(frequency / 60.0) ** 2)) + 0.1
    band = np.zeros_like(psa) if asked.solver == "full" else 0.02 * psa
    force = np.zeros((STEPS, len(asked.loads)))
    for k in range(len(asked.loads)):
        force[:, k] = 1e7 * (k + 1) * pulse(time - START)
    edges = [f"floor {k}" for k in asked.loads]
    pfa = np.abs(acceleration).max(axis=0)
    values = {
        "time": time,
        "component": XYZ,
        "xyz": XYZ,
        "probe": names,
        "probe_kind": kinds,
        "probe_floor": floors,
        "probe_position": position,
        "probe_node": nodes,
        "probe_distance": np.zeros(len(nodes)),
        "displacement": displacement,
        "acceleration": acceleration,
        "frequency": frequency,
        "damping": asked.dampings,
        "psa": psa,
        "psa_band": band,
        "sd": psa / (2.0 * np.pi * frequency) ** 2,
        "pfa": pfa,
        "zpa": pfa,
        "pfa_band": np.zeros((len(nodes), 3)),
        "pfa_interpolated": pfa,
        "ground_acceleration": np.zeros((STEPS, 3)),
        "edge": edges,
        "edge_floor": np.array(asked.loads, dtype=int),
        "edge_side": [""] * len(asked.loads),
        "edge_length": [6.0] * len(asked.loads),
        "edge_force": force,
        "impact_force": force,
        "edge_moment": np.zeros_like(force),
        "psa_peak": psa[..., frequency <= HIGHEST].max(axis=-1),
        "psa_peak_band": band[..., frequency <= HIGHEST].max(axis=-1),
        "psa_peak_frequency": frequency[psa[..., frequency <= HIGHEST].argmax(axis=-1)],
        "largest_displacement": np.abs(displacement).max(axis=0),
        "wave_speed": SPEED / 1.6,
        "plate_wave_speed": 1.6 * SPEED,
        "loaded_wave_speed": SPEED,
        "loaded_wave_crossing": 6.0 / SPEED,
    }
    if asked.solver != "full":
        tf = np.geomspace(0.5, 500.0, 50)
        shape = (len(tf), len(asked.loads), len(nodes), 3)
        values |= {
            "transfer_frequency": tf,
            "transfer_load": edges,
            "transfer_load_floor": np.array(asked.loads, dtype=int),
            "transfer_re": 1e-6 * (1.0 + np.log(tf / 0.5))[:, None, None, None] * np.ones(shape),
            "transfer_im": np.zeros(shape),
            "transfer_bound": np.full(shape, np.inf),
        }
    if asked.plates:
        values |= {
            "base_plate": ["pump", "tank"],
            "base_plate_floor": [asked.floors[-1], 0],
            "base_plate_position": position[[len(asked.floors) - 1, -1]],
            "base_plate_radius": [0.8, 0.5],
        }
    attributes = {
        "building": "one",
        "shown_direction": asked.direction,
        "wave_floor": max(asked.floors),
        "solver": asked.solver,
        "maximum_frequency": HIGHEST,
        "resolved_frequency": 100.0,
        "spread": "uniform",
        "patch_width": 2.0,
        "main_impact": [START, START + LASTS] if asked.loads else [],
    }
    store = dataset(transient.OUTPUTS, values, attributes=attributes)
    found = findings(store, _sticks(asked), UNDAMPED)
    store = dataset(transient.OUTPUTS, values | found, attributes=attributes)
    return with_scalars(store, transient_scalars(store))


def _probes(asked, slab):
    """Names, nodes, kinds and floors."""
    n, last = len(slab.plan), len(asked.floors) - 1
    numbered = list(enumerate(asked.floors))
    probes = [
        *((f"centre_{floor}", slab.centre + n * k, "centre", floor) for k, floor in numbered),
        *((f"edge_{floor}", slab.line[0] + n * k, "edge", floor) for k, floor in numbered),
        *(
            (f"line_{k}", node + n * last, "line", asked.floors[-1])
            for k, node in enumerate(slab.line, start=1)
        ),
        ("corner", n * last, "point", 0),
    ]
    names, nodes, kinds, floors = zip(*probes, strict=True)
    return names, nodes, kinds, floors


def _maps(asked, slab):
    n = len(slab.plan)
    vertices = np.unique(slab.cells[:, :3])
    levels = range(len(asked.floors))
    nodes = np.concatenate([vertices + n * k for k in levels])
    position = _building(asked, slab)["node_position"].values
    c = XYZ.index(asked.direction)
    frequency = np.geomspace(0.5, 500.0, asked.frequencies)
    pfa = np.zeros((len(nodes), 3))
    pfa[:, c] = 10.0 + position[nodes, c]
    psa = pfa[:, :, None] * frequency
    top = n * (len(asked.floors) - 1) + np.arange(n)
    snapshots = START + LASTS * np.array([0.0, 0.5, 1.0]) if asked.loads else np.zeros(0)
    wave = np.zeros((len(snapshots), n, 3))
    wave[:, :, c] = np.sin(position[top, c]) + np.arange(len(snapshots))[:, None]
    frames = START + STEP * np.arange(-10, 43) if asked.loads else np.zeros(0)
    moved = np.zeros((len(frames), len(nodes), 3), dtype=np.float32)
    moved[:, :, c] = 0.01 * np.sin(4.0 * np.pi * frames)[:, None]
    distance = position[nodes, c].max() - position[nodes, c]
    pulses = -50.0 * pulse(frames[:, None] - START - distance / SPEED).astype(np.float32)
    values = {
        "component": XYZ,
        "xyz": XYZ,
        "node_number": nodes,
        "node_position": position[nodes],
        "floor_triangle_node": np.searchsorted(
            nodes, np.concatenate([slab.cells[:, :3] + n * k for k in levels])
        ),
        "floor_triangle_floor": np.repeat(asked.floors, len(slab.cells)),
        "frequency": frequency,
        "pfa": pfa,
        "psa": psa.astype(np.float32),
        "pfa_free": 0.25 * pfa,
        "psa_free": (0.25 * psa).astype(np.float32),
        "wave_node_number": top,
        "wave_node_position": position[top],
        "wave_triangle_node": slab.cells,
        "snapshot": snapshots,
        "wave_displacement": 1e-3 * wave,
        "wave_acceleration": 30.0 * wave,
        "membrane_force": 1e6 * np.ones((len(snapshots), 1)) * np.arange(len(slab.cells)),
    }
    if asked.frames:
        values |= {"frame": frames, "frame_displacement": moved, "frame_acceleration": pulses}
    attributes = {"damping": asked.dampings[0], "points_per_cycle": 2.0}
    return dataset(MAP_OUTPUTS, values, attributes=attributes)
