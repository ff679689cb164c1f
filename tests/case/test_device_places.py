"""Devices with several supports, matrices, given spectra and envelopes in a case file."""

from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import Probe, load_case
from impactfem.case.devices import chosen, unknown_patterns

from .faults import faults_of
from .texts import added, replaced

Structured = Callable[..., Path]
With = Callable[..., Path]

TEXT = """
[transient]
time_step = "1 ms"
[[transient.probes]]
name = "corner"
point = ["0 m", "0 m", "30.3 m"]

[[damping_cases]]
name = "light"
ratio = "2 %"
frequencies = ["1 Hz", "20 Hz"]

[[devices]]
name = "pipe"
spectra = "spectra.csv"
[[devices.supports]]
point = ["23.1 m", "12.0 m", "25.5 m"]
radius = "0.5 m"
[[devices.supports]]
point = ["23.1 m", "12.0 m", "30.3 m"]
radius = "0.6 m"
envelope = ["corner", "edge_*"]
[devices.matrices]
mass = "mass.csv"
stiffness = "stiffness.csv"
[devices.damping]
ratio = "2 %"
frequencies = ["10 Hz", "60 Hz"]

[device_analysis]
supports = ["abs", "algebraic"]
displacements = "srss"
envelope_dampings = true
"""
FILES = {
    "mass.csv": "1.y,tip,2.y\n0,0,0\n0,500,0\n0,0,0\n",
    "stiffness.csv": "1.y,tip,2.y\n3e6,-3e6,0\n-3e6,4e6,-1e6\n0,-1e6,1e6\n",
    "spectra.csv": "frequency [Hz],acceleration [m/s2],direction,damping\n"
    "1,2,y,0.01\n50,2,y,0.01\n1,1,y,0.05\n50,2,y,0.05\n",
}


@pytest.fixture
def written(structured: Structured) -> With:
    def write(*edits: tuple[str, str], **files: str) -> Path:
        path = structured()
        added(path, replaced(TEXT, *edits))
        for name, content in (FILES | {f"{k}.csv": v for k, v in files.items()}).items():
            (path.parent / name).write_text(content, encoding="utf-8")
        return path

    return write


def test_a_device_on_two_floors(written: With) -> None:
    case = load_case(written())
    (pipe,) = case.devices
    assert [one.radius for one in pipe.anchors] == [0.5, 0.6]
    assert pipe.anchors[1].envelope == ("corner", "edge_*")
    assert pipe.point is None
    assert pipe.matrices is not None and pipe.matrices.own == ("tip",)
    assert pipe.spectra is not None
    assert [(one.support, one.damping) for one in pipe.spectra] == [
        (1, 0.01),
        (1, 0.05),
        (2, 0.01),
        (2, 0.05),
    ]
    assert case.device_analysis is not None
    assert case.device_analysis.supports == ("abs", "algebraic")
    changed = load_case(written(stiffness=FILES["stiffness.csv"].replace("4e6", "4.1e6")))
    assert changed.content_hash() != case.content_hash()


SUPPORT = '[[devices.supports]]\npoint = ["23.1 m", "12.0 m", "30.3 m"]'
THIRD = f'{SUPPORT.replace("23.1", "9.1")}\nradius = "1 m"\n{SUPPORT}'
MATRICES = '[devices.matrices]\nmass = "mass.csv"\nstiffness = "stiffness.csv"\n'


@pytest.mark.parametrize(
    ("old", "new", "key", "message"),
    [
        ('"30.3 m"]\nradius', '"28 m"]\nradius', "supports[1].point", "at the level of no floor"),
        (
            '["23.1 m", "12.0 m", "25.5 m"]',
            '["99 m", "12 m", "25.5 m"]',
            "supports[0].point",
            "out",
        ),
        (
            '"12.0 m", "30.3 m"]',
            '"12.0 m", "25.5 m"]',
            "supports",
            "at different points, found two",
        ),
        ('["corner", "edge_*"]', '["korner"]', "supports[1].envelope", "there is none for korner"),
        ('["corner", "edge_*"]', '["corner", "corner"]', "supports[1].envelope", "once"),
        ('"pipe"\n', '"pipe"\npoint = ["1 m", "1 m", "30.3 m"]\n', "point", "beside supports"),
        ('"pipe"\n', '"pipe"\nradius = "1 m"\n', "radius", "nothing here beside supports"),
        ('"pipe"\n', '"pipe"\nenvelope = ["corner"]\n', "envelope", "each may have an envelope"),
        ('"pipe"\n', '"pipe"\nmass = "1 t"\nmass_height = "0 m"\n', "mass", "beside matrices"),
        (MATRICES, "", "matrices", "missing; expected the matrices of a device with several"),
        ('"pipe"\n', '"pipe"\nmodes = "spectra.csv"\n', "modes", "a device with several supports"),
        (SUPPORT, THIRD, "matrices", "the matrices have no motion of support 3"),
        ('mass = "mass.csv"', 'mass = "no.csv"', "matrices.mass", "no such file"),
        ('spectra = "spectra.csv"', 'spectra = "no.csv"', "spectra", "no such file"),
    ],
)
def test_refused(written: With, old: str, new: str, key: str, message: str) -> None:
    found = faults_of(written((old, new)))
    assert message in found[f"devices[0].{key}"], found


def test_files_that_do_not_go_together(written: With) -> None:
    other = FILES["stiffness.csv"].replace("tip", "top")
    found = faults_of(written(stiffness=other))
    assert "same order as in the header of mass" in found["devices[0].matrices.stiffness"]
    rows = FILES["spectra.csv"].replace("damping\n", "damping,support\n", 1)
    rows = "\n".join([*rows.splitlines()[:1], *(f"{r},2" for r in rows.splitlines()[1:])])
    found = faults_of(written(spectra=rows))
    assert "it has no spectrum of support 1" in found["devices[0].spectra"]


def test_an_envelope_over_no_dampings(written: With) -> None:
    alone = TEXT[TEXT.index("[[damping_cases]]") : TEXT.index("[[devices]]")]
    found = faults_of(written((alone, "")))
    assert "one damping only" in found["device_analysis.envelope_dampings"]


def test_one_place_or_several(written: With) -> None:
    start, end = TEXT.index("[[devices.supports]]"), TEXT.index("[devices.matrices]")
    found = faults_of(written((TEXT[start:end], "")))
    assert "expected the anchor (x, y, z), or supports" in found["devices[0].point"]
    assert "expected the radius of the anchor" in found["devices[0].radius"]


PROBES = (
    Probe(name="corner", point=(0.0, 0.0, 3.0)),
    Probe.model_validate(
        {"name": "aisle", "from": (0.0, 1.0, 3.0), "to": (5.0, 1.0, 3.0), "count": 3}
    ),
    Probe(name="roof", group="edge_2"),
)


def test_chosen() -> None:
    names = ["corner", "aisle_1", "aisle_2", "centre_1"]
    assert chosen(names, ["aisle_*", "corner"]) == ["corner", "aisle_1", "aisle_2"]
    assert chosen(names, ["aisle_?"]) == ["aisle_1", "aisle_2"]
    assert chosen(names, ["Corner"]) == []


@pytest.mark.parametrize(
    "pattern",
    ["corner", "aisle_3", "aisle*", "roof_17", "roof_*", "centre_2", "edge_*", "line_9", "*"],
)
def test_patterns_of_probes(pattern: str) -> None:
    assert list(unknown_patterns([pattern], PROBES, [1, 2])) == []


@pytest.mark.parametrize("pattern", ["korner", "aisle", "aisle_4", "centre_3", "line_10", "roof"])
def test_patterns_of_no_probe(pattern: str) -> None:
    assert list(unknown_patterns([pattern, "corner"], PROBES, [1, 2])) == [pattern]


def test_floors_that_are_not_known() -> None:
    assert list(unknown_patterns(["centre_9", "nothing"], PROBES, [])) == ["nothing"]
