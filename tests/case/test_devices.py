"""The tables [[devices]] of a case file."""

import json
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import (
    BaseStiffness,
    Cylinder,
    DeviceAnalysis,
    DeviceBeam,
    DeviceMode,
    DeviceSetup,
    load_case,
)
from impactfem.case.damping import Damping
from impactfem.system.errors import InputError

from .faults import faults_of, refused
from .texts import added, replaced

Structured = Callable[..., Path]
With = Callable[..., Path]

TRANSIENT = """
[transient]
time_step = "1 ms"
"""
PUMP = """
[[devices]]
name = "pump"
point = ["23.1 m", "12.0 m", "30.3 m"]
radius = "0.5 m"
mass = "1.5 t"
mass_height = "46 cm"
shape = { type = "cylinder", radius = "50 cm", length = "1 m" }
stiffness = { x = "140 MN/m", y = "1.2e8 N/m", z = "rigid", \
rx = "30 MN m/rad", ry = "rigid", rz = "rigid" }
damping = { ratio = "2 %", frequencies = ["30 Hz", "80 Hz"] }
"""
BEAM = """
[devices.beam]
length = "46 cm"
bending = ["80 MN m2", "60 MN m2"]
shear = ["rigid", "1.2e9 N"]
twisting = "3e7 N m2"
mass = "45.9 kg"
elements = 2
"""
CABINET = """
[[devices]]
name = "cabinet"
point = ["5 m", "0 m", "9.6 m"]
radius = "40 cm"
modes = "pair_modes.csv"
damping = { mass_coefficient = "0 1/s", stiffness_coefficient = "1 ms" }
maximum_frequency = "50 Hz"
"""
MODES = """\
frequency [Hz],direction,effective_mass [kg],height [m]
# the first one
8,y,300,1.1
12.5,x,280,1
30,z,50,0
"""


@pytest.fixture
def with_devices(structured: Structured) -> With:
    """A case with a structure and devices, with texts of the devices or of the tables replaced."""

    def write(
        text: str = PUMP, *edits: tuple[str, str], transient: str = TRANSIENT, modes: str = MODES
    ) -> Path:
        path = structured()
        added(path, transient + replaced(text, *edits))
        (path.parent / "pair_modes.csv").write_text(modes, encoding="utf-8")
        return path

    return write


def test_left_out(pair: Path) -> None:
    case = load_case(pair)
    assert (case.devices, case.device_analysis) == ((), None)


def test_a_body_on_springs(with_devices: With) -> None:
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
            damping=Damping(ratio=0.02, frequencies=(30.0, 80.0)),
            maximum_frequency=1000.0,
        ),
    )
    # The defaults, with the step in terms of that of [transient].
    assert case.device_analysis == DeviceAnalysis(time_step=0.125e-3)
    assert pickle.loads(pickle.dumps(case)) == case
    dumped = json.loads(case.model_dump_json(include={"devices"}))["devices"]
    assert dumped[0]["stiffness"]["z"] == "rigid"


def test_beam(with_devices: With) -> None:
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
    assert pump.beam is not None
    assert (pump.beam.bending, pump.beam.shear) == ((8e7, 8e7), (1.2e9, 1.2e9))


def test_table_of_modes(with_devices: With) -> None:
    case = load_case(with_devices(PUMP + CABINET))
    pump, cabinet = case.devices
    assert pump.modes is None
    assert cabinet.modes == (
        DeviceMode(frequency=8.0, direction="y", effective_mass=300.0, height=1.1),
        DeviceMode(frequency=12.5, direction="x", effective_mass=280.0, height=1.0),
        DeviceMode(frequency=30.0, direction="z", effective_mass=50.0),
    )
    assert cabinet.maximum_frequency == 50.0


def test_the_table_counts(with_devices: With) -> None:
    hashes = {
        load_case(with_devices(CABINET, modes=text)).content_hash()
        for text in (MODES, MODES.replace("300", "301"))
    }
    assert len(hashes) == 2


def test_mass_beside_modes(with_devices: With) -> None:
    whole = 'mass = "400 kg"\nmass_height = "0.9 m"\ninertia = ["9 kg m2", "9 kg m2", "0 kg m2"]\n'
    (cabinet,) = load_case(with_devices(CABINET + whole)).devices
    assert (cabinet.mass, cabinet.mass_height, cabinet.inertia) == (400.0, 0.9, (9.0, 9.0, 0.0))


def test_damping_of_each_mode(with_devices: With) -> None:
    line = 'damping = { mass_coefficient = "0 1/s", stiffness_coefficient = "1 ms" }\n'
    damped = "frequency [Hz],direction,effective_inertia [kg m2],damping [%]\n8,rx,300,4\n"
    (cabinet,) = load_case(with_devices(CABINET, (line, ""), modes=damped)).devices
    assert cabinet.damping is None
    assert cabinet.modes is not None
    (mode,) = cabinet.modes
    assert (mode.effective_inertia, mode.damping) == (300.0, 0.04)
    assert faults_of(with_devices(CABINET, (line, ""))) == {
        "devices[0].damping": "None missing; expected a damping, as the table of modes has "
        "no column damping"
    }


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ('mass = "1.5 t"\n', "", "mass", "missing; expected the mass of a body, or modes"),
        ('mass_height = "46 cm"\n', "", "mass_height", "mass and mass_height together"),
        ("shape = {", 'inertia = ["1 kg m2", "1 kg m2", "1 kg m2"]\nshape = {', "shape",
         "either inertia or shape beside mass, not both"),
        ('shape = { type = "cylinder", radius = "50 cm", length = "1 m" }\n', "", "shape",
         "either inertia or shape beside mass"),
        ('"cylinder"', '"box"', "shape.type", "expected 'cylinder'"),
        ('rx = "30 MN m/rad"', 'rx = "30 MN m"', "stiffness.rx", "for example '3e7 N m/rad'"),
        (', z = "rigid"', ', z = "stiff"', "stiffness.z", "or 'rigid'"),
        ('z = "rigid", ', "", "stiffness.z", "missing; expected"),
        ('y = "1.2e8 N/m"', 'y = "0 N/m"', "stiffness.y",
         "a mechanism: no stiffness holds the motion along y of the base"),
        ('rx = "30 MN m/rad"', 'rx = "0 N m/rad"', "stiffness.rx",
         "a mechanism: no stiffness holds the rotation about x of the base"),
        ('damping = { ratio = "2 %", frequencies = ["30 Hz", "80 Hz"] }', "", "damping",
         "missing; expected the damping of the device"),
        ("[[devices]]", "[[devices]]\nfloor = 8", "floor", "unknown key"),
        ('["23.1 m", ', '["46.3 m", ', "point", "outside the building; expected x from 0 to 46.2"),
        ('"12.0 m"', '"-0.1 m"', "point", "y from 0 to 15.6 m"),
        ('"30.3 m"', '"30.5 m"', "point", "the nearest, floor 8, is at 30.3 m"),
        ('"30.3 m"', '"28 m"', "point", "within half of the slab's thickness, 0.15 m, of a floor"),
        ('"30.3 m"', '"0 m"', "point", "the nearest, floor 1, is at 3.26 m"),
    ],
)  # fmt: skip
def test_refused(with_devices: With, old: str, new: str, key: str, expected: str) -> None:
    refused(with_devices(PUMP, (old, new)), f"devices[0].{key}", expected)


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ('length = "46 cm"', 'length = "0 cm"', "length", "a length above 0"),
        ('["80 MN m2", "60 MN m2"]', '"rigid"', "bending", "or a list of two of them"),
        ('["80 MN m2", "60 MN m2"]', '["80 MN m2"]', "bending", "or a list of two of them"),
    ],
)
def test_beam_refused(with_devices: With, old: str, new: str, key: str, expected: str) -> None:
    refused(with_devices(PUMP + BEAM, (old, new)), f"devices[0].beam.{key}", expected)


def test_nothing_moves(with_devices: With) -> None:
    rigid = 'x = "rigid", y = "rigid", z = "rigid", rx = "rigid"'
    springs = 'x = "140 MN/m", y = "1.2e8 N/m", z = "rigid", rx = "30 MN m/rad"'
    assert faults_of(with_devices(PUMP, (springs, rigid))) == {
        "devices[0].beam": "None missing; expected a beam, as nothing moves on a base that is "
        "rigid all over"
    }
    assert load_case(with_devices(PUMP + BEAM, (springs, rigid))).devices[0].beam is not None


@pytest.mark.parametrize(
    ("line", "key", "expected"),
    [
        ('stiffness = { x = "1 N/m", y = "1 N/m", z = "1 N/m", rx = "rigid", ry = "rigid", '
         'rz = "rigid" }', "stiffness", "expected nothing here beside modes"),
        ('beam = { length = "1 m", bending = "1 N m2" }', "beam",
         "expected nothing here beside modes"),
        ('mass = "400 kg"', "mass_height", "mass and mass_height together"),
        ('mass_height = "1 m"', "mass_height", "mass and mass_height together"),
        ('inertia = ["1 kg m2", "1 kg m2", "1 kg m2"]', "inertia", "a mass beside it"),
        ('shape = { type = "cylinder", radius = "1 m", length = "1 m" }', "shape",
         "a mass beside it"),
    ],
)  # fmt: skip
def test_refused_beside_modes(with_devices: With, line: str, key: str, expected: str) -> None:
    faults = faults_of(with_devices(f"{CABINET}{line}\n"))
    assert expected in faults[f"devices[0].{key}"]


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ("8,y", "8,u", "line 3, column direction", "expected 'x', 'y', 'z', 'rx'"),
        ("8,y,300", "8,y,0", "line 3, column direction", "effective_mass above 0"),
        ("8,y,300", "8,rx,300", "line 3, column direction", "effective_inertia above 0"),
        ("8,y,300", "8,y,many", "line 3, column effective_mass [kg]", "a finite number"),
        ("30,z,50,0", "30,z,50,1", "line 5, column direction", "expected height 0"),
        ("height [m]", "level [m]", "line 1, column level [m]", "unknown column"),
    ],
)
def test_table_refused(with_devices: With, old: str, new: str, key: str, expected: str) -> None:
    assert old in MODES
    path = with_devices(CABINET + CABINET.replace("cabinet", "other"),
                        modes=MODES.replace(old, new))  # fmt: skip
    with pytest.raises(InputError) as caught:
        load_case(path)
    # Two devices share the table: what is wrong with it is told once.
    (fault,) = [one for one in caught.value.faults if one.key == key]
    assert Path(fault.file).name == "pair_modes.csv"
    assert expected in fault.expected


def test_table_missing(with_devices: With) -> None:
    refused(
        with_devices(CABINET, ("pair_modes.csv", "none.csv")),
        "devices[0].modes",
        "no such file; expected a table of modes (CSV)",
    )


def test_each_name_once(with_devices: With) -> None:
    assert faults_of(with_devices(PUMP + PUMP)) == {
        "devices[1].name": "pump duplicate name, the first is devices[0].name"
    }


def test_what_devices_need(broken: Structured, with_devices: With) -> None:
    assert faults_of(with_devices(transient="")) == {
        "devices": "None expected beside them [transient]: the response of that model in time"
    }
    path = broken()
    with path.open("a", encoding="utf-8") as stream:
        stream.write(PUMP)
    assert faults_of(path) == {
        "devices": "None expected beside them [buildings.structure]: the 3D model of their "
        "building, and [transient]: the response of that model in time"
    }


def test_all_at_once(with_devices: With) -> None:
    edits = (('"0.5 m"', '"0 m"'), ('"2 %"', '"120 %"'), ('"1.2e8 N/m"', '"0 N/m"'))
    faults = faults_of(with_devices(PUMP, *edits))
    assert set(faults) == {
        "devices[0].radius",
        "devices[0].damping.ratio",
        "devices[0].stiffness.y",
    }
    both = (('["23.1 m"', '["-1 m"'), ('"30.3 m"', '"29 m"'))
    faults = faults_of(with_devices(PUMP + CABINET, *both, ('"0 m", "9.6 m"', '"0 m", "11 m"')))
    assert set(faults) == {"devices[0].point", "devices[1].point"}
    for expected in ("['-1 m', '12.0 m', '29 m']", "outside the building", "at the level of no"):
        assert expected in faults["devices[0].point"]


def test_no_second_fault_of_a_floor_table(with_devices: With) -> None:
    path = with_devices()
    table = path.with_name("pair_floors.csv")
    table.write_text(table.read_text(encoding="utf-8").replace(",3.26,", ",high,"))
    assert not any(key.startswith("devices") for key in faults_of(path))


def test_mesh_of_a_file(with_devices: With) -> None:
    """Its plan is not known before it is read."""
    path = with_devices(PUMP, ('["23.1 m"', '["-23.1 m"'), ('"30.3 m"', '"31 m"'))
    text = path.read_text(encoding="utf-8")
    begin, end = text.index("[buildings.structure.mesh]"), text.index("[transient]")
    shells = 'shells = [{groups = "*", thickness = "1 m"}]'
    mesh = f'[buildings.structure.mesh]\ntype = "file"\nfile = "a.msh"\n{shells}\n'
    path.write_text(text[:begin] + mesh + text[end:], encoding="utf-8")
    path.with_name("a.msh").write_bytes(b"a mesh")
    (pump,) = load_case(path).devices
    assert pump.point is not None and pump.point[2] == 31.0


@pytest.mark.parametrize(("z", "acceleration"), [("9.6 m", 3.0), ("30.2 m", 8.0)])
def test_products_of_the_floor_that_it_stands_on(
    with_devices: With, z: str, acceleration: float
) -> None:
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


def test_table_of_an_extended_case(with_devices: With, tmp_path: Path) -> None:
    path = with_devices(CABINET)
    (tmp_path / "sub").mkdir()
    variant = tmp_path / "sub" / "variant.toml"
    variant.write_text(f'extends = "../{path.name}"\ntitle = "A variant"\n', encoding="utf-8")
    assert load_case(variant).devices == load_case(path).devices
