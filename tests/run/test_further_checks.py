"""What `check` finds beyond the files of a case, in one round; what a run would refuse later."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from frame_case import floors_meet, neighbour, pump
from impactfem import study
from impactfem.coupling.force_history import ForceHistory, write_forces_csv
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"
TRANSIENT = """
[contact_laws.floor]
type = "hertz"
stiffness = "1e9 N/m^1.5"
[transient]
time_step = "1 ms"
maximum_frequency = "50 Hz"
"""
FORCES = """forces = "forces.csv"
duration = "0.5 s"
"""
PROBE = """[[transient.probes]]
name = "corner"
point = ["0 m", "0 m", "%s"]
"""


@pytest.fixture
def frame(tmp_path, edited):
    """A case of the shipped frame with a mesh of its own, changed and with more text."""
    for path in GEOMETRY.glob("frame*"):
        shutil.copy(path, tmp_path)
    case = tmp_path / "frame.toml"
    edited(case, neighbour('axis = ["0 m", "5 m"]\n'))

    def made(more="", *changes):
        with case.open("a", encoding="utf-8") as stream:
            stream.write(TRANSIENT + more)
        return edited(case, *changes)

    return made


def forces(folder, pairs=("F.floor_1-G.floor_1", "F.floor_2-G.floor_2"), end=0.5):
    t = 0.001 * np.arange(round(1000 * end) + 1)
    force = np.zeros((t.size, len(pairs)))
    write_forces_csv(folder / "forces.csv", ForceHistory(t, pairs, force))


def faults(case, mesh=True):
    with pytest.raises(InputError) as caught:
        study.check(case, mesh=mesh)
    return [str(fault).removeprefix(f"{case.parent}/") for fault in caught.value.faults]


AT_ONCE = {
    "devices[0].point = (3.0, 1.0, 4.5): device pump: its anchor at z = 4.5 m is on no floor": (
        '"1 m", "4.5 m"]',
        '"1 m", "3 m"]',
    ),
    "ensemble.structure_motions = 2: expected 0: each member has": ("_motions = 2", "_motions = 0"),
    "pounding.time_step = 5.0: expected at most half of what is computed, 3 s": ('"5 s"', '"1 ms"'),
    "baem_*": ("baem_*", "beam_*"),
    "transient.probes[0]: the probe corner at (0.000, 0.000, 99.000) m is outside": ("99 m", "6 m"),
    "spectra.dampings: unknown key": ("dampings", "damping"),
}
"""What the faults of a case say, and how each is mended."""


def test_everything_at_once(frame, tmp_path, edited):
    forces(tmp_path)
    more = FORCES + PROBE % "99 m" + floors_meet("1 m") + pump('["3 m", "1 m", "4.5 m"]', "0.5 m")
    case = frame(
        more + "[ensemble]\nmotions = 4\nstructure_motions = 2\n",
        ('groups = "beam_*"', 'groups = "baem_*"'),
        ('[pounding]\ntime_step = "1 ms"', '[pounding]\ntime_step = "5 s"'),
        ("[spectra]\ndamping = ", "[spectra]\ndampings = "),
    )
    left = dict(AT_ONCE)
    while left:
        found = faults(case)
        for words in AT_ONCE:
            assert (words in "\n".join(found)) == (words in left), (words, found)
        _, change = left.popitem()
        edited(case, change)
    assert study.check(case, mesh=True).devices


@pytest.mark.parametrize(
    ("pairs", "end", "meet", "words"),
    [
        (("F.floor_1-G.floor_1", "F.floor_2-G.floor_2"), 0.5, True, ""),
        (("F.floor_1-G.floor_1", "F.floor_9-G.floor_9"), 0.5, True, "did you mean 'F.floor_"),
        (("F.floor_1-G.floor_1",), 0.5, True, "the forces of the pair F.floor_2-G.floor_2"),
        (("F.floor_1-G.floor_1", "F.floor_2-G.floor_2"), 0.2, True, "forces up to 0.5 s, which"),
        (("F.floor_1-G.floor_1",), 0.5, False, "the case has no contacts to say it"),
    ],
    ids=["good", "no pair", "a pair too few", "too short", "no contacts"],
)
@pytest.mark.parametrize("mesh", [False, True])
def test_forces_of_a_table(frame, tmp_path, pairs, end, meet, words, mesh):
    forces(tmp_path, pairs, end)
    case = frame(FORCES + (floors_meet("1 m") if meet else ""))
    if words:
        assert words in "\n".join(faults(case, mesh))
    else:
        assert study.check(case, mesh=mesh).transient is not None


def test_a_duration_that_no_record_lasts(frame, tmp_path):
    """How long a record lasts is known once it is read."""
    text = "time [s],acceleration [m/s2]\n" + "".join(f"{0.01 * k:g},{k % 7}\n" for k in range(201))
    (tmp_path / "record.csv").write_text(text)
    case = frame('duration = "3 s"\n')
    whole = case.read_text()
    start, end = whole.index("[[motions]]"), whole.index("[pounding]")
    record = '[[motions]]\ndirection = "y"\ntype = "record"\nfile = "record.csv"\n'
    case.write_text(whole[:start] + record + whole[end:])
    (found,) = faults(case, mesh=False)
    assert "transient.duration = 3.0: expected at most what is computed of the sticks, 2 s" in found


@pytest.fixture
def coarse(tmp_path):
    """The paper's case on a coarse mesh, which the generator makes."""
    for path in GEOMETRY.glob("npp_*.*"):
        shutil.copy(path, tmp_path)
    text = (tmp_path / "npp_pair.toml").read_text(encoding="utf-8")
    (tmp_path / "npp_pair.toml").write_text(text.replace('size = "1.0 m" ', 'size = "3 m" '))
    return tmp_path / "npp_pair.toml"


def test_devices_on_a_generated_mesh(coarse):
    text = coarse.read_text(encoding="utf-8")
    start, end = text.index("[[devices]]"), text.index("[device_analysis]")
    second = text[start:end].replace('"pump"', '"second"')
    small = second.replace('"second"', '"small"').replace('"0.5 m"', '"1 mm"')
    small = small.replace('"23.1 m", "12.0 m"', '"20.2 m", "9.1 m"')
    coarse.write_text(text[:end] + second + small + text[end:], encoding="utf-8")
    wide = text.replace('radius = "0.5 m"', 'radius = "3 m"')
    found = faults(coarse)
    assert all(one.startswith("npp_pair.toml: ") for one in found), found
    assert any("devices[2].point" in one and "too coarse for the radius" in one for one in found)
    twice = wide.replace("[device_analysis]", second + "[device_analysis]")
    coarse.write_text(twice.replace('radius = "0.5 m"', 'radius = "3 m"'), encoding="utf-8")
    (found,) = faults(coarse)
    assert "devices[1].radius" in found and "tie the same nodes of floor 8" in found
    coarse.write_text(wide, encoding="utf-8")
    assert study.check(coarse, mesh=True).devices
