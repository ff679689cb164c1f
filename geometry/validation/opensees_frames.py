"""The two frame buildings of opensees_*.toml in OpenSees, and the tables of its results.

    pip install openseespy        # 3.7.1 made the tables, under its own licence
    python opensees_frames.py

It reads floor tables and record, as they are, and nothing of impactfem.
"""

import csv
import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import openseespy.opensees as ops

HERE = Path(__file__).parent
E, NU = 30e9, 0.2
RATIO, F1, F2 = 0.05, 1.0, 20.0  # Rayleigh damping
GRAVITY, SCALE = 9.80665, 1.6
GAP, STEP, DURATION = 0.02, 2e-4, 10.0
RESTITUTION, FLOORS = 0.65, (1, 2, 3)
HERTZ = 2e11  # N/m^1.5
BELOW, ABOVE = 0.4, 0.1  # rigid zones
WIDTH = {"A": 10.0, "B": 8.0}  # along y
Table = list[dict[str, float]]


def floor_table(name: str) -> Table:
    """Rows of a floor table, by the names of its columns without units."""
    lines = (HERE.parent / f"row_of_three_{name}_floors.csv").read_text().splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return [{key.split(" [")[0]: float(value) for key, value in row.items()} for row in rows]


def record(direction: str) -> tuple[float, np.ndarray]:
    """Time step [s] and ground acceleration [m/s2]."""
    lines = (HERE.parent / f"two_frames_{direction}.AT2").read_text().splitlines()
    values = np.array(" ".join(lines[4:]).split(), dtype=float)
    return float(lines[3].split("DT=")[1].split()[0]), SCALE * GRAVITY * values


def building(table: Table, first: int) -> list[int]:
    """A clamped stick of rigid floors from a floor table; the nodes of its floors.

    Rigid zones are links: the joint offsets of a transformation act otherwise with this element.
    """
    ops.node(first, 0.0, 0.0, 0.0)
    ops.fix(first, *[1] * 6)
    below, height, floors = first, 0.0, []
    for node, row in enumerate(table, start=first + 1):
        height += row["storey_height"]
        ops.node(node, 0.0, 0.0, height)
        ops.mass(node, *[1e3 * row["mass"]] * 3, row["Jx"], row["Jy"], row["Jz"])
        lower, upper = node + 50, node + 70
        for end, offset in ((lower, -BELOW), (upper, ABOVE)):
            ops.node(end, 0.0, 0.0, height + offset)
            ops.rigidLink("beam", node, end)
        # The axes of the element are z, -y and x of the building.
        section = [row[key] for key in ("A", "Iz", "Iy", "Ix", "Avy", "Avx")]
        moduli = E, E / (2.0 * (1.0 + NU))
        ops.element("ElasticTimoshenkoBeam", node, below, lower, *moduli, *section, 1)
        below = upper
        floors.append(node)
    return floors


def material(tag: int, law: str, mass: float) -> None:
    """The contact between points of two floors of a reduced mass [kg], as a material."""
    e = RESTITUTION
    if law == "kelvin_voigt":
        K = 1e10
        xi = -math.log(e) / math.hypot(math.pi, math.log(e))
        ops.uniaxialMaterial("ViscoelasticGap", tag, K, 2.0 * xi * math.sqrt(K * mass), -GAP)
    elif law == "hertz_damp":
        ops.uniaxialMaterial("Hertzdamp", tag, HERTZ, 0.75 * (1.0 - e**2), -GAP, 1.5)
    elif law == "jankowski":
        # As in the documentation of the material, after Jankowski 2006.
        xi = 4.5 * math.sqrt(5.0) * (1.0 - e**2) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))
        ops.uniaxialMaterial("JankowskiImpact", tag, HERTZ, xi, mass, -GAP, 1.5)
    else:
        raise ValueError(law)


def model() -> None:
    """An empty model in space, for vertical members."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    ops.geomTransf("Linear", 1, 1.0, 0.0, 0.0)


def solve(
    tables: dict[str, Table],
    law: str | None,
    directions: str,
    places: Sequence[tuple[float, float]],
) -> dict[str, np.ndarray]:
    """Displacements, accelerations and contact forces in time, without contact where no law.

    The places are the distances along x of the points of contact from the axes of both buildings.
    """
    model()
    nodes = {
        (name, k): node
        for side, (name, table) in enumerate(tables.items(), start=1)
        for k, node in enumerate(building(table, 100 * side), start=1)
    }
    pairs = [(k, at) for at in range(len(places)) for k in FLOORS]
    if law is not None:
        for tag, (k, at) in enumerate(pairs, start=1000):
            ends, compliance = [], 0.0
            for name, toward, x in zip("AB", (0.5, -0.5), places[at], strict=True):
                floor, edge = nodes[name, k], 2 * tag + (name == "B")
                ops.node(edge, x, toward * WIDTH[name], ops.nodeCoord(floor)[2])
                ops.rigidLink("beam", floor, edge)
                ends.append(edge)
                # A floor that is hit off its axis turns: 1/m + x²/J.
                row = tables[name][k - 1]
                compliance += 1.0 / (1e3 * row["mass"]) + x**2 / row["Jz"]
            material(tag, law, 1.0 / compliance)
            ops.element("zeroLength", tag, *ends, "-mat", tag, "-dir", 2)
    w1, w2 = 2.0 * math.pi * F1, 2.0 * math.pi * F2
    ops.rayleigh(2.0 * RATIO * w1 * w2 / (w1 + w2), 2.0 * RATIO / (w1 + w2), 0.0, 0.0)
    moves = {}
    for direction in directions:
        axis = "xyz".index(direction)
        dt, moves[axis] = record(direction)
        ops.timeSeries("Path", axis + 1, "-dt", dt, "-values", *moves[axis].tolist())
        ops.pattern("UniformExcitation", axis + 1, axis + 1, "-accel", axis + 1)
    with tempfile.TemporaryDirectory() as folder:
        file = {what: f"{folder}/{what}.txt" for what in ("disp", "accel", "force")}
        for what in ("disp", "accel"):
            wanted = "-file", file[what], "-precision", 16, "-time", "-node", *nodes.values()
            ops.recorder("Node", *wanted, "-dof", 1, 2, 3, what)
        if law is not None:
            wanted = "-file", file["force"], "-precision", 16, "-eleRange", 1000, 999 + len(pairs)
            ops.recorder("Element", *wanted, "material", 1, "stress")
        ops.constraints("Transformation")
        ops.numberer("Plain")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-13, 100, 0)
        # Not by tangents of the materials: they have no dashpot, and after Hertz the wrong sign.
        ops.algorithm("KrylovNewton", "-initial")
        ops.integrator("Newmark", 0.5, 0.25)
        ops.analysis("Transient")
        if ops.analyze(round(DURATION / STEP), STEP) != 0:
            raise RuntimeError("OpenSees did not converge")
        ops.wipe()
        made = {what: np.loadtxt(path) for what, path in file.items() if Path(path).exists()}
    time = made["disp"][:, 0]
    force = -made["force"] if law is not None else np.zeros((len(time), len(pairs)))
    out = {"time": time, "force": force}
    for axis, ground in moves.items():
        # The recorders give accelerations relative to the ground.
        made["accel"][:, 1 + axis :: 3] += np.interp(time, dt * np.arange(len(ground)), ground)[
            :, None
        ]
    for k, (name, floor) in enumerate(nodes):
        for key, what in (("u", "disp"), ("a", "accel")):
            values = made[what][:, 1 + 3 * k : 4 + 3 * k]
            out[f"{key}.{name}.{floor}"] = np.linalg.norm(values, axis=1)
    return out


def frequencies(tables: dict[str, Table]) -> dict[str, np.ndarray]:
    """Frequencies of the bending modes of each building [Hz]."""
    found = {}
    for name, table in tables.items():
        model()
        for node in building(table, 100):
            ops.fix(node, 1, 0, 1, 0, 1, 1)  # bending along y alone
        ops.constraints("Transformation")
        eigenvalues = ops.eigen("-fullGenLapack", 2 * len(table))
        found[name] = np.sqrt(eigenvalues) / (2.0 * math.pi)
    return found


def results(
    law: str, directions: str = "y", places: Sequence[tuple[float, float]] = ((0.0, 0.0),)
) -> dict[str, tuple[float, str]]:
    """Scalar results by the names of summary.json, with units."""
    tables = {"A": floor_table("a"), "B": floor_table("b")}
    rows: dict[str, tuple[float, str]] = {}
    for name, f in frequencies(tables).items():
        rows |= {f"sticks.{name}.frequency.{k}": (f[k - 1], "Hz") for k in (1, 2, 3)}
    where = directions, places
    with_contact, free = solve(tables, law, *where), solve(tables, None, *where)
    for name, table in tables.items():
        for label, run in (("", with_contact), ("_no_contact", free)):
            peak = run[f"u.{name}.{len(table)}"].max()
            rows[f"pounding.peak_displacement{label}.{name}"] = (peak, "m")
    time, force = with_contact["time"], with_contact["force"]
    for column, k in enumerate(FLOORS):
        # Points of a floor push it together.
        together = force[:, column :: len(FLOORS)].sum(axis=1)
        rows[f"pounding.peak_force.floor_{k}"] = (together.max(), "N")
        peak = with_contact[f"a.A.{k}"].max()
        rows[f"pounding.peak_acceleration.floor_{k}"] = (peak, "m/s2")
    acts = np.pad((force != 0.0).astype(int), ((1, 0), (0, 0)))
    rows["pounding.impacts"] = (float((np.diff(acts, axis=0) == 1).sum()), "-")
    at, pair = np.unravel_index(force.argmax(), force.shape)
    first, last = at, at
    while force[first - 1, pair] != 0.0:
        first -= 1
    while force[last + 1, pair] != 0.0:
        last += 1
    # A trapezoid of equal steps from zero to zero.
    impulse = STEP * force[first : last + 1, pair].sum()
    rows["pounding.main_impact_force"] = (force[at, pair], "N")
    rows["pounding.main_impact_time"] = (time[at], "s")
    rows["pounding.main_impact_impulse"] = (float(impulse), "N s")
    return rows


def main() -> None:
    """Write the tables."""
    source = f"OpenSees {ops.version()} by opensees_frames.py"
    found = {law: results(law) for law in ("kelvin_voigt", "hertz_damp", "jankowski")}
    found["eccentric"] = results("jankowski", "xy", ((2.0, 3.0), (-4.0, -3.0)))
    for name, rows in found.items():
        lines = [f"# Results of {source}.", "name,value,unit,source"]
        lines += [f"{key},{value:.9g},{unit},{source}" for key, (value, unit) in rows.items()]
        (HERE / f"opensees_{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
