"""The tables [[devices]] and the section [device_analysis] of a case file."""

import json
from typing import get_args

import pytest

from impactfem.case import DeviceAnalysis, DeviceSetup, load_case
from impactfem.case.damping import RayleighDamping
from impactfem.case.device_tables import DeviceMode
from impactfem.case.devices import (
    BaseStiffness,
    Combination,
    Cylinder,
    DeviceBeam,
    DeviceSupport,
    chosen,
)
from impactfem.case.transient import Probe
from impactfem.device import combination

from .faults import faults_of, refused
from .sections import (
    ANALYSIS,
    BEAM,
    CABINET,
    FROM_FILE,
    LIGHT,
    MODES,
    PIPE,
    PIPE_FILES,
    PUMP,
    TRANSIENT,
)
from .texts import replaced


@pytest.fixture
def with_devices(structured):
    """A case with a 3D model and devices, with texts of these or of their tables replaced."""

    def write(text=PUMP, *edits, files=MODES):
        return structured(more=TRANSIENT + replaced(text, *edits), files=files)

    return write


def test_a_body_on_springs(with_devices):
    case = load_case(with_devices())
    assert case.devices == (
        DeviceSetup(
            name="pump",
            building="B1",
            point=(23.1, 12.0, 30.3),
            radius=0.5,
            modes=None,
            mass=1500.0,
            mass_height=0.46,
            shape=Cylinder(type="cylinder", radius=0.5, length=1.0),
            stiffness=BaseStiffness(x=1.4e8, y=1.2e8, z="rigid", rx=3e7, ry="rigid", rz="rigid"),
            damping=RayleighDamping(ratio=0.02, frequencies=(30.0, 80.0)),
            maximum_frequency=1000.0,
        ),
    )
    # The defaults, with the step in terms of that of [transient].
    assert case.device_analysis == DeviceAnalysis(time_step=0.125e-3)
    dumped = json.loads(case.model_dump_json(include={"devices"}))["devices"]
    assert dumped[0]["stiffness"]["z"] == "rigid"


def test_beam(with_devices):
    (pump,) = load_case(with_devices(PUMP + BEAM)).devices
    assert pump.beam == DeviceBeam(
        length=0.46,
        bending=(8e7, 6e7),
        shear=("rigid", 1.2e9),
        stretching="rigid",
        twisting=3e7,
        mass=45.9,
        elements=2,
    )
    edits = (('["80 MN m2", "60 MN m2"]', '"80 MN m2"'), ('["rigid", "1.2e9 N"]', '"1.2e9 N"'))
    (pump,) = load_case(with_devices(PUMP + BEAM, *edits)).devices
    assert (pump.beam.bending, pump.beam.shear) == ((8e7, 8e7), (1.2e9, 1.2e9))


def test_table_of_modes(with_devices):
    case = load_case(with_devices(PUMP + CABINET))
    pump, cabinet = case.devices
    assert pump.modes is None
    assert cabinet.modes == (
        DeviceMode(frequency=8.0, direction="y", effective_mass=300.0, height=1.1),
        DeviceMode(frequency=12.5, direction="x", effective_mass=280.0, height=1.0),
        DeviceMode(frequency=30.0, direction="z", effective_mass=50.0),
    )
    assert cabinet.maximum_frequency == 50.0


def test_mass_beside_modes(with_devices):
    whole = 'mass = "400 kg"\nmass_height = "0.9 m"\ninertia = ["9 kg m2", "9 kg m2", "0 kg m2"]\n'
    (cabinet,) = load_case(with_devices(CABINET + whole)).devices
    assert (cabinet.mass, cabinet.mass_height, cabinet.inertia) == (400.0, 0.9, (9.0, 9.0, 0.0))


def test_damping_of_each_mode(with_devices):
    line = 'damping = { mass_coefficient = "0 1/s", stiffness_coefficient = "1 ms" }\n'
    damped = "frequency [Hz],direction,effective_inertia [kg m2],damping [%]\n8,rx,300,4\n"
    path = with_devices(CABINET, (line, ""), files={"pair_modes.csv": damped})
    (cabinet,) = load_case(path).devices
    assert cabinet.damping is None
    assert cabinet.modes is not None
    (mode,) = cabinet.modes
    assert (mode.effective_inertia, mode.damping) == (300.0, 0.04)
    assert faults_of(with_devices(CABINET, (line, ""))) == {
        "devices[0].damping": "None missing; expected a damping, as the table of modes has "
        "no column damping"
    }


def test_nothing_moves(with_devices):
    rigid = 'x = "rigid", y = "rigid", z = "rigid", rx = "rigid"'
    springs = 'x = "140 MN/m", y = "1.2e8 N/m", z = "rigid", rx = "30 MN m/rad"'
    assert faults_of(with_devices(PUMP, (springs, rigid))) == {
        "devices[0].beam": "None missing; expected a beam, as nothing moves on a base that is "
        "rigid all over"
    }
    assert load_case(with_devices(PUMP + BEAM, (springs, rigid))).devices[0].beam is not None


def test_what_devices_need(broken, structured):
    refused(structured(more=PUMP), "devices", "missing_section [transient]")
    refused(broken(more=PUMP), "devices", "missing_section [buildings.structure]")
    path = structured(more=TRANSIENT + ANALYSIS)
    refused(path, "device_analysis", "missing_section [[devices]]")


def test_all_at_once(with_devices):
    edits = (('"0.5 m"', '"0 m"'), ('"2 %"', '"120 %"'), ('"1.2e8 N/m"', '"0 N/m"'))
    assert set(faults_of(with_devices(PUMP, *edits))) == {
        "devices[0].radius",
        "devices[0].damping.ratio",
        "devices[0].stiffness.y",
    }
    both = (('["23.1 m"', '["-1 m"'), ('"30.3 m"', '"29 m"'))
    faults = faults_of(with_devices(PUMP + CABINET, *both, ('"0 m", "9.6 m"', '"0 m", "11 m"')))
    assert set(faults) == {"devices[0].point", "devices[1].point"}
    for expected in ("['-1 m', '12.0 m', '29 m']", "outside the building", "at the level of no"):
        assert expected in faults["devices[0].point"]


def test_no_second_fault_of_a_floor_table(structured):
    path = structured(("pair_floors.csv", ",3.26,", ",high,"), more=TRANSIENT + PUMP)
    assert not any(key.startswith("devices") for key in faults_of(path))


def test_mesh_of_a_file(structured):
    """Its plan is not known before it is read."""
    moved = replaced(PUMP, ('["23.1 m"', '["-23.1 m"'), ('"30.3 m"', '"31 m"'))
    path = structured(*FROM_FILE.edits, more=TRANSIENT + moved, files=FROM_FILE.files)
    (pump,) = load_case(path).devices
    assert pump.point is not None and pump.point[2] == 31.0


@pytest.mark.parametrize(("z", "acceleration"), [("9.6 m", 3.0), ("30.2 m", 8.0)])
def test_products_of_the_floor_that_it_stands_on(with_devices, z, acceleration):
    path = with_devices(PUMP + 'spectra = "product.csv"\n', ("30.3 m", z))
    header = "building,floor,direction,damping [-],frequency [Hz],broadened [m/s2]\n"
    rows = [
        f"{building},{floor},y,0.05,{f},{floor if building == 'B1' else 9}\n"
        for building in ("B1", "B2")
        for floor in range(1, 9)
        for f in (1, 2)
    ]
    path.with_name("product.csv").write_text(header + "".join(rows), encoding="utf-8")
    (pump,) = load_case(path).devices
    assert pump.spectra is not None
    assert [one.acceleration for one in pump.spectra] == [(acceleration, acceleration)]
    others = [row for row in rows if not row.startswith(f"B1,{acceleration:g}")]
    path.with_name("product.csv").write_text(header + "".join(others), encoding="utf-8")
    expected = f"it has no spectrum of floor {acceleration:g} of building B1"
    assert expected in faults_of(path)["devices[0].spectra"]


def test_table_of_an_extended_case(with_devices, tmp_path):
    path = with_devices(CABINET)
    (tmp_path / "sub").mkdir()
    variant = tmp_path / "sub" / "variant.toml"
    variant.write_text(f'extends = "../{path.name}"\ntitle = "A variant"\n', encoding="utf-8")
    assert load_case(variant).devices == load_case(path).devices


def test_a_device_on_two_floors(structured):
    case = load_case(structured(more=PIPE, files=PIPE_FILES))
    (pipe,) = case.devices
    assert [one.radius for one in pipe.anchor_points] == [0.5, 0.6]
    assert pipe.anchor_points[1].envelope == ("corner", "edge_*")
    assert pipe.point is None
    assert pipe.matrices is not None and pipe.matrices.own == ("tip",)
    assert pipe.spectra is not None
    found = [(one.support, one.damping) for one in pipe.spectra]
    assert found == [(1, 0.01), (1, 0.05), (2, 0.01), (2, 0.05)]
    assert case.device_analysis.supports == ("abs", "algebraic")


def test_files_that_do_not_go_together(structured):
    path = structured(("stiffness.csv", "tip", "top"), more=PIPE, files=PIPE_FILES)
    found = faults_of(path)["devices[0].matrices.stiffness"]
    assert "header of mass" in found
    first, *rows = PIPE_FILES["spectra.csv"].splitlines()
    text = "\n".join([f"{first},support", *(f"{row},2" for row in rows)])
    found = faults_of(structured(more=PIPE, files=PIPE_FILES | {"spectra.csv": text}))
    assert "spectrum of support 1" in found["devices[0].spectra"]


def test_an_envelope_over_no_dampings(structured):
    found = faults_of(structured(more=replaced(PIPE, (LIGHT, "")), files=PIPE_FILES))
    assert "one damping only" in found["device_analysis.envelope_dampings"]


def test_one_place_or_several(structured):
    supports = PIPE[PIPE.index("[[devices.supports]]") : PIPE.index("[devices.matrices]")]
    found = faults_of(structured(more=replaced(PIPE, (supports, "")), files=PIPE_FILES))
    assert "expected the anchor" in found["devices[0].point"]
    assert "expected the radius" in found["devices[0].radius"]


LINE = {"name": "aisle", "from": (0.0, 1.0, 3.0), "to": (5.0, 1.0, 3.0), "count": 3}
PROBES = (
    Probe(name="corner", point=(0.0, 0.0, 3.0)),
    Probe.model_validate(LINE),
    Probe(name="roof", group="edge_2"),
)


def test_patterns_of_probes():
    names = ["corner", "aisle_1", "aisle_2", "centre_1"]
    assert chosen(names, ["aisle_*", "corner"]) == ["corner", "aisle_1", "aisle_2"]
    assert chosen(names, ["aisle_?"]) == ["aisle_1", "aisle_2"]
    assert chosen(names, ["Corner"]) == []

    def unknown(patterns, floors):
        anchor = DeviceSupport(point=(0.0, 0.0, 0.0), radius=1.0, envelope=tuple(patterns))
        return list(anchor.unknown_probes(PROBES, floors))

    known = ["corner", "aisle_3", "aisle*", "roof_17", "roof_*", "centre_2", "edge_*", "line_9"]
    assert unknown([*known, "*"], [1, 2]) == []
    none = ["korner", "aisle", "aisle_4", "centre_3", "line_10", "roof"]
    assert unknown([*none, "corner"], [1, 2]) == none
    # Floors that are not known may have any number.
    assert unknown(["centre_9", "nothing"], []) == ["nothing"]


def analysis_of(case):
    assert case.device_analysis is not None
    return case.device_analysis


def test_analysis(with_devices):
    found = analysis_of(load_case(with_devices(CABINET + ANALYSIS)))
    assert found.combination == ("abs", "dsc", "ten-percent")
    assert (found.duration, found.time_step, found.broadening) == (4.0, 0.2e-3, 0.0)
    assert (found.missing_mass, found.rotations, found.directions) == (False, False, "100-40-40")
    assert (found.rigid.method, found.rigid.f1, found.rigid.f2) == (("gupta",), 5.0, 30.0)
    several = '["none", "gupta", "lindley-yow"]'
    for old, new, methods, f2 in (
        (', f1 = "5 Hz", f2 = "30 Hz"', "", ("gupta",), None),
        ('"gupta"', several, ("none", "gupta", "lindley-yow"), 30.0),
        ('"gupta"', '["gupta"]', ("gupta",), 30.0),
    ):
        rigid = analysis_of(load_case(with_devices(CABINET + ANALYSIS, (old, new)))).rigid
        assert (rigid.method, rigid.f2) == (methods, f2)


def test_combinations_are_those_of_the_analysis():
    assert get_args(Combination) == get_args(combination.Combination)


def test_a_removed_key(structured):
    path = structured(more=f"{TRANSIENT}{PUMP}{ANALYSIS}")
    path.write_text(
        path.read_text().replace("[device_analysis]\n", '[device_analysis]\nsolver = "full"\n')
    )
    (fault,) = faults_of(path).items()
    assert fault[0] == "device_analysis.solver" and "removed" in str(fault[1])
