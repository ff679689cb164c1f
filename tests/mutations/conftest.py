"""Folders of good cases, which between them name every kind of file."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from frame_case import floors_meet, neighbour
from impactfem.coupling.force_history import ForceHistory
from impactfem.records.accelerogram import Accelerogram
from impactfem.records.csv import write_csv
from impactfem.verify.motion import at2_text, cosmos_text, csmip_text, esm_text, knet_text

TESTS = Path(__file__).parents[1]
GEOMETRY = TESTS.parent / "geometry"
FORMATS = {
    "record.csv": "csv",
    "record.at2": "at2",
    "record.esm": "esm",
    "record.v2c": "cosmos",
    "record.v2": "csmip",
    "record.NS": "knet",
}
TREATED = (
    '[[motions]]\ndirection = "y"\ntype = "record"\nfile = "{}"\nformat = "{}"\n'
    'baseline = "linear"\ntaper = "0.1 s"\nfilter = ["0.5 Hz", "20 Hz"]\nresample = "5 ms"\n'
    'pga = "2 m/s2"\n\n'
)
TRANSIENT = (
    """
[contact_laws.floor]
type = "hunt-crossley"
stiffness = "1e9 N/m^1.5"
restitution = 0.65
"""
    + floors_meet("1 m")
    + """
[transient]
solver = "%s"
time_step = "1 ms"
maximum_frequency = "50 Hz"
forces = "forces.csv"
[[transient.probes]]
name = "corner"
point = ["0 m", "0 m", "6 m"]
[[transient.probes]]
name = "aisle"
from = ["0 m", "0 m", "6 m"]
to = ["6 m", "0 m", "6 m"]
count = 3
[[transient.probes]]
name = "roof"
group = "edge_2"
"""
)
PART_DAMPING = """
[[buildings.structure.damping]]
parts = ["column_*"]
ratio = "2 %"
frequencies = ["1 Hz", "20 Hz"]
[buildings.structure.mesh]
"""
DEVICES = """
[[devices]]
name = "pipe"
maximum_frequency = "40 Hz"
spectra = "spectra.csv"
[[devices.supports]]
point = ["3 m", "1 m", "3 m"]
radius = "0.5 m"
envelope = ["corner", "aisle_*"]
[[devices.supports]]
point = ["3 m", "1 m", "6 m"]
radius = "0.5 m"
[devices.matrices]
mass = "mass.csv"
stiffness = "stiffness.csv"
[devices.damping]
ratio = "2 %"
frequencies = ["10 Hz", "60 Hz"]
[[devices]]
name = "cabinet"
point = ["5 m", "3 m", "6 m"]
radius = "0.5 m"
modes = "modes.csv"
[device_analysis]
combination = ["srss", "dsc"]
duration = "2 s"
supports = ["srss", "envelope"]
[device_analysis.rigid]
method = "gupta"
f1 = "5 Hz"
f2 = "20 Hz"
[[damping_cases]]
name = "light"
ratio = "3 %"
frequencies = ["1 Hz", "20 Hz"]
restitution = 0.5
"""


@pytest.fixture(scope="session")
def good(tmp_path_factory):
    """A folder of folders, each with cases and all files that they name."""
    root = tmp_path_factory.mktemp("good")
    for name, pattern in (("paper", "npp_*"), ("second", "two_*"), ("frame", "frame*")):
        (root / name).mkdir()
        for path in GEOMETRY.glob(pattern):
            if path.suffix not in (".py", ".geo"):
                shutil.copy(path, root / name)
    _records(root / "records")
    _frame(root / "frame")
    return root


def _records(folder):
    """A case for each format of a record, for a table of a spectrum, for a folder of records."""
    shutil.copytree(TESTS / "case" / "data", folder)
    t = np.arange(400) * 0.01
    a = np.sin(9.0 * t) * np.exp(-t)
    (folder / "many").mkdir()
    for path in (folder / "record.csv", folder / "many" / "1.csv", folder / "many" / "2.csv"):
        write_csv(Accelerogram(0.01, a, "record", "made"), path)
    for name, text in {
        "record.at2": at2_text(a / 9.80665, 0.01),
        "record.esm": esm_text(100.0 * a, 0.01),
        "record.v2c": cosmos_text([("360", "HNN", 100.0 * a)], 0.01),
        "record.v2": csmip_text([("360", 100.0 * a)], 0.01),
        "record.NS": knet_text([round(1e5 * x) for x in a], 100),
    }.items():
        (folder / name).write_text(text, encoding="utf-8")
    text = (folder / "pair.toml").read_text(encoding="utf-8")
    start, end = text.index("[[motions]]"), text.index("[contact_laws")
    for name, kind in FORMATS.items():
        whole = text[:start] + TREATED.format(name, kind) + text[end:]
        (folder / f"{kind}.toml").write_text(whole, encoding="utf-8")
    many = TREATED.format("record.csv", "csv") + text[end:] + '\n[ensemble]\nrecords = "many"\n'
    (folder / "ensemble.toml").write_text(text[:start] + many, encoding="utf-8")
    points = ((0.2, 1), (2, 5), (9, 5), (33, 2.3), (100, 2.3))
    rows = "".join(f"{f},{a},{d}\n" for d in (0.02, 0.05) for f, a in points)
    header = "frequency [Hz],acceleration [m/s2],damping [-]\n"
    (folder / "spectrum.csv").write_text(header + rows)
    start = text.index("[motions.spectrum]")
    table = '[motions.spectrum]\ntype = "table"\nfile = "spectrum.csv"\n\n'
    (folder / "table.toml").write_text(text[:start] + table + text[end:], encoding="utf-8")


def _frame(folder):
    """Cases of the frame with forces, probes, part damping, and devices of matrices and modes."""
    text = (folder / "frame.toml").read_text(encoding="utf-8")
    two = text.replace(*neighbour(), 1)
    (folder / "full.toml").write_text(
        two.replace("[buildings.structure.mesh]", PART_DAMPING, 1) + TRANSIENT % "full"
    )
    (folder / "device.toml").write_text(two + TRANSIENT % "reduced" + DEVICES)
    t = np.arange(301) * 1e-2
    force = np.column_stack([np.maximum(0.0, 1e5 * np.sin(20.0 * t)), 0.0 * t])
    pairs = "F.floor_1-G.floor_1", "F.floor_2-G.floor_2"
    ForceHistory(t, pairs, force).write_csv(folder / "forces.csv")
    names = ("1.x", "1.y", "2.x", "2.y", "tip")
    K = 1e6 * np.array([[1, 0, 0, 0, -1], [0] * 5, [0, 0, 1, 0, -1], [0] * 5, [-1, 0, -1, 0, 2]])
    for name, unit, matrix in (("mass", "kg", 100.0 * np.eye(5)), ("stiffness", "N/m", K)):
        header = ",".join(f"{motion} [{unit}]" for motion in names) + "\n"
        rows = "".join(",".join(f"{value:g}" for value in row) + "\n" for row in matrix)
        (folder / f"{name}.csv").write_text(header + rows)
    (folder / "modes.csv").write_text(
        "frequency [Hz],direction,effective_mass [kg],height [m],damping [-]\n"
        "8.5,x,320,1.25,0.03\n8.5,y,320,1.25,0.03\n"
    )
    points = ((0.1, 1), (1, 4), (10, 9), (100, 3), (1000, 3))
    (folder / "spectra.csv").write_text(
        "frequency [Hz],acceleration [m/s2],direction,damping\n"
        + "".join(f"{f},{a},{d},{z}\n" for d in "xyz" for z in (0.001, 0.5) for f, a in points)
    )
