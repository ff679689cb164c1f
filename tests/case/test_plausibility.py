"""What is hardly meant: a warning each, with the value and what is usual."""

import math
import shutil
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.plausibility import implausible
from impactfem.case.usual import USUAL
from impactfem.motion.from_case import plausibility_warnings
from impactfem.verify.motion import at2_text

from .sections import (
    BEAM,
    BLAST,
    CABINET,
    EC8,
    LAW,
    LIGHT,
    LOADS,
    MOTION,
    PIPE,
    PIPE_FILES,
    PUMP,
    RECORD,
    RECORDED,
    TRANSIENT,
    WALL,
    with_spectrum,
)
from .texts import replaced

GEOMETRY = Path(__file__).parents[2] / "geometry"
LONGEST = 16.79
FLOORS, TARGETS = "pair_floors.csv", "pair_targets.csv"
SHAPE = 'shape = { type = "cylinder", radius = "50 cm", length = "1 m" }'


@pytest.fixture
def recorded(broken):
    """The case with a record in place of its motion."""

    def write(samples, step, keys="", direction="y", name="a"):
        lines = (f"{k * step:g},{a:.17g}" for k, a in enumerate(samples))
        record = RECORD.replace('"x"', f'"{direction}"').replace("\n\n", f"\n{keys}\n\n")
        text = "\n".join((f"time [s],{name} [m/s2]", *lines))
        return broken((None, MOTION, record), files={"motion.csv": text})

    return write


def warnings(path, longest=LONGEST):
    case = load_case(path)
    found = (*implausible(case, longest), *plausibility_warnings(case))
    return [str(one).replace(f"{path.parent}/", "") for one in found]


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("mass.csv", "500", "500", []),
        ("mass.csv", "500", "0.5", ["0.5 kg along y; usual is 10 kg"]),  # tonnes as kilograms
        ("mass.csv", "500", "5e5", ["5e+05 kg along y", "first frequency"]),
        ("stiffness.csv", "e6", "e3", ["first frequency on supports at rest is 0.45"]),  # kN/m
        ("stiffness.csv", "e6", "e9", []),
        ("stiffness.csv", "e6", "e10", ["is 1.42e+03 Hz; usual is 1 to 100 Hz"]),
    ],
)
def test_matrices_in_wrong_units(structured, file, old, new, words):
    """A device with matrices: 500 kg, 14.2 Hz."""
    files = PIPE_FILES | {file: PIPE_FILES[file].replace(old, new)}
    found = [line for line in warnings(structured(more=PIPE, files=files)) if "matrices" in line]
    heavy = [line for line in found if "SRP 3.7.2" in line]
    assert bool(heavy) == (new == "5e5")
    others = [line for line in found if line not in heavy]
    assert [word in line for word, line in zip(words, others, strict=True)] == [True] * len(words)


def test_a_mass_that_the_matrices_have(structured):
    stated = PIPE.replace('name = "pipe"', 'name = "pipe"\nmass = "0.502 t"')
    assert [
        line for line in warnings(structured(more=stated, files=PIPE_FILES)) if "mass" in line
    ] == []


@pytest.mark.parametrize(
    "path",
    [
        *(
            path
            for path in GEOMETRY.glob("*.toml")
            if not path.name.endswith(("_report.toml", "_fit.toml"))
        ),
        Path(__file__).parent / "data" / "pair.toml",
    ],
    ids=lambda path: path.stem,
)
def test_the_shipped_cases_give_none(path):
    assert warnings(path) == []


def test_the_template_gives_none(new_case, tmp_path):
    assert warnings(new_case(tmp_path), 10.0) == []


def test_a_generated_mesh_gives_none(structured):
    assert warnings(structured()) == []


@pytest.mark.parametrize(
    ("file", "old", "new", "key", "usual"),
    [
        (None, '"33 GPa"', '"33 Pa"', "materials.concrete.young_modulus = '33 Pa'",
         "usual is concrete 20 to 45 GPa"),
        (None, '"33 GPa"', '"33e40 GPa"', "materials.concrete.young_modulus = '33e40 GPa'",
         "usual is concrete 20 to 45 GPa"),
        (FLOORS, "3,1682,", "3,1e50,", "pair_floors.csv: floor 3, mass = 1e+53",
         "in SI; usual is 20 to 5000 t"),
        (None, 'ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]',
         'mass_coefficient = "0 1/s"\nstiffness_coefficient = "0 s"', "damping",
         "both coefficients are 0: no damping at all"),
        (None, 'ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]',
         'mass_coefficient = "1 1/s"\nstiffness_coefficient = "1e50 s"',
         "damping.stiffness_coefficient = '1e50 s'", "usual is below 10 ms"),
        (None, 'ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]',
         'type = "table"\npoints = [["1 Hz", "7 %"], ["1 kHz", 7]]',
         "damping.points[1] = ['1 kHz', 7]", "usual is 1 % to 10 %"),
        (None, 'damping_ratio = "12 %"', "restitution = 1e-9",
         "contact_laws.floor.restitution = 1e-09", "usual is 0.4 to 0.9"),
        (None, 'axis = ["23.1 m", "23.41 m"]', 'axis = ["23.1 m", "7.8 m"]',
         "buildings[1].axis = ['23.1 m', '7.8 m']", "the axis of buildings[0], B1: one stands in"),
        (None, "normal = [0, 1, 0]", "normal = [0, 0, 1]", "contacts[0].normal = [0, 0, 1]",
         "not horizontal"),
        (None, 'a = { building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 8]',
         'a = { building = "B1", floor = [2, 1, 3, 4, 5, 6, 7, 8]', "contacts[0]",
         "the points of B1.floor_2-B2.floor_1 are at 5.88 m and 3.26 m; points that"),
        (None, 'duration = "16.79 s"\ntime_step = "0.3358 ms"',
         'duration = "1679 s"\ntime_step = "0.3358 ms"', "pounding.duration = '1679 s'",
         "100 times the longest motion, 16.79 s"),
        (None, 'duration = "16.79 s"\ntime_step = "0.3358 ms"',
         'duration = "2 s"\ntime_step = "0.3358 ms"', "pounding.duration = '2 s'",
         "the strong phase of motions[0] lasts until 5 s"),
        (FLOORS, "1,2502,6.3e7", "1,2502,6.3e3", "pair_floors.csv: floor 1, Jx = '6300 kg m2'",
         "√(Jx/mass) is 0.0502 m; usual is 2 to 30 m"),
        (FLOORS, "Jy [kg m2]", "Jy [g m2]", "pair_floors.csv: floor 1, Jy = '5.1e+05 kg m2'",
         "√(Jy/mass) is 0.451 m; usual is 2 to 30 m; so it is in 7 more"),
        (FLOORS, "1,2502,6.3e7,5.1e8,5.7e8", "1,2502,6.3e8,5.1e8,5.7e7",
         "pair_floors.csv: floor 1, Jx = '6.3e+08 kg m2'", "more than the sum of the other two"),
        (FLOORS, ",234,169,214,", ",234,469,214,", "pair_floors.csv: floor 1, Avy = '469 m2'",
         "more than A, 234 m2"),
        (None, 'frequencies = ["1 Hz", "20 Hz"]', 'frequencies = ["0.1 Hz", "0.2 Hz"]', "damping",
         "467 % of critical at 20 Hz; usual is 1 % to 10 % from 1 to 20 Hz"),
        (None, "[[buildings]]\nname = \"B1\"",
         '[materials.steel]\nyoung_modulus = "210 GPa"\npoisson_ratio = 0.3\n[[buildings]]\n'
         'name = "B1"', "materials.steel", "not used: nothing in the case has it"),
        (None, "[contact_laws.floor]", '[contact_laws.spare]\ntype = "unilateral"\n'
         "[contact_laws.floor]", "contact_laws.spare", "not used: nothing in the case has it"),
        (None, 'rigid_depth = "0.85 m"', 'rigid_depth = "0.5 m"', "calibration.rigid_depth",
         "usual is rigid_below + rigid_above, 0.85 m of B1 and 0.85 m of B2"),
        (None, "stiffness_factor = [0.02, 1.0]", "stiffness_factor = [10, 300]",
         "calibration.stiffness_factor = [10, 300]", "0.131 of B1 and 0.131 of B2"),
        (TARGETS, "B1,1,1.75,", "B1,1,17.5,", "mode 2, frequency = '", "mode 1 of B1 has 17.5 Hz"),
        (TARGETS, "B1,1,1.75,10100", "B1,1,1.75,1e6", "effective_mass = '", "the modes of B1 tog"),
        (None, '[[motions]]\ndirection = "y"', '[[motions]]\ndirection = "x"',
         "motions[0].direction = 'x'", "no contact has a normal along it"),
        (None, 'name = "B1"', 'name = "B1"\nwidth = "10 m"', "contacts[0].a.offset",
         "7.8 m from the axis along y, and the plan of B1 reaches 5 m"),
        (None, 'damping = ["5 %"]', 'damping = ["90 %"]', "spectra.damping[0] = '90 %'",
         "usual is 0.5 % to 10 %"),
        (None, "per_decade = 100 }", "per_decade = 100 }\nbroadening = 0.9",
         "spectra.broadening = 0.9", "usual is 10 % to 15 %"),
        (None, 'frequencies = ["1 Hz", "20 Hz"]', 'frequencies = ["1 Hz", "2 kHz"]',
         "damping.frequencies[1] = '2 kHz'", "usual is 0.5 to 50 Hz"),
        (None, "amplification = 2.5", "amplification = 25",
         "motions[0].spectrum.amplification = 25", "usual is 2.5 to 3"),
        (None, 'damping = "5 %"', 'damping = "50 %"', "motions[0].damping = '50 %'",
         "usual is 5 %"),
        (None, LAW, 'type = "hertz-damp"\nstiffness = "1e11 N/m^1.5"\nrestitution = 0.6\n'
         'slowest_approach = "1 m/s"\n', "contact_laws.floor.slowest_approach = '1 m/s'",
         "usual is 0.1 to 10 mm/s"),
        (None, "per_decade = 100", "per_decade = 1", "spectra.frequencies.per_decade = 1",
         "usual is 30 to 100"),
        (None, "0.3358 ms", "5 ms", "pounding.time_step = '5 ms'",
         "1.76 steps in an impact of B1.floor_7-B2.floor_7, which lasts 8.81 ms; 16 are requested"),
        ("pair_published.csv", "frs.", "floors.", "pair_published.csv: name = 'floors.",
         "no result; their names begin with motion, sticks, pounding, frs, soil, building, reduce"),
    ],
)  # fmt: skip
def test_one_value(broken, file, old, new, key, usual):
    found = warnings(broken((file, old, new)))
    # Each name of the table that was changed has a line.
    assert len(found) == 1 or file == "pair_published.csv"
    assert key in found[0]
    assert usual in found[0]


@pytest.mark.parametrize(
    ("file", "old", "new", "key"),
    [
        (None, 'slab_thickness = "30 cm"', 'slab_thickness = "1 nm"',
         "buildings[1].structure.mesh.slab_thickness = '1 nm'"),
        ("pair_walls.csv", "south,1-8,0,0,46.2,0,60", "south,1-8,0,0,46.2,0,1e-7",
         "pair_walls.csv: row 1, thickness = 1e-09"),
        ("pair_beams.csv", "-0.29", "29", "pair_beams.csv: row 2, offset = 29.0"),
        ("pair_columns.csv", "0.8,1.2", "1e-9,1.2", "pair_columns.csv: row 1, width_x = 1e-09"),
    ],
)  # fmt: skip
def test_the_mesh(structured, file, old, new, key):
    (line,) = warnings(structured((file, old, new)))
    assert key in line and "usual is 0" in line


def test_a_column_in_a_wrong_unit_has_one_warning(structured):
    found = warnings(structured(("pair_walls.csv", "thickness [cm]", "thickness [m]")))
    (line,) = [line for line in found if "pair_walls.csv" in line]
    assert "row 1, thickness = 60.0: in SI; usual is 0.1 to 2 m; so it is in 2 more" in line


def test_an_edge_where_nothing_strikes(structured):
    """The pairs of B1 are on y+; results at its edges would be those of another side."""
    for edge in ("y-", "x+"):
        (line,) = warnings(structured((None, 'impact_edge = "y+"', f'impact_edge = "{edge}"')))
        key = f"buildings[1].structure.mesh.impact_edge = '{edge}': the pairs of B1 are on its side"
        assert f"{key} y+; results at the edges of floors are those of side {edge}" in line
    assert warnings(structured((None, "normal = [0, 1, 0]", "normal = [0.1, 1, 0]"))) == []


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('mass_height = "46 cm"', 'mass_height = "-46 cm"',
         "mass_height = '-46 cm': the mass centre is below the anchor; net tension is that of a"),
        ('radius = "0.5 m"\nmass', 'radius = "500 m"\nmass',
         "radius = '500 m': usual is 0.1 to 2 m"),
        ('damping = { ratio = "2 %"', 'damping = { ratio = "50 %"',
         "damping.ratio = '50 %': usual is 1 % to 10 %"),
        (SHAPE, 'inertia = ["300 t m2", "250 kg m2", "190 kg m2"]',
         "inertia[0] = '300 t m2': √(J/mass) is 14.1 m; usual is at most the size of the device"),
        (SHAPE, 'inertia = ["190 kg m2", "250 kg m2", "450 kg m2"]',
         "inertia[2] = '450 kg m2': more than the sum of the other two"),
        (SHAPE, 'inertia = ["190 kg m2", "250 kg m2", "440 kg m2"]', None),
        ('y = "1.2e8 N/m"', 'y = "1.4e4 N/m"', "stiffness.y = '1.4e4 N/m': 0.49 Hz of the body on"),
        ('y = "1.2e8 N/m"', 'y = "1.6e4 N/m"', None),
        ('rx = "30 MN m/rad"', 'rx = "3 kN m/rad"', "stiffness.rx = '3 kN m/rad': 0.49 Hz of the"),
        ('bending = ["80 MN m2", "60 MN m2"]', 'bending = "400 N m2"',
         "beam.bending = '400 N m2': 0.46 Hz of the body on it alone; usual is 1 to 50 Hz"),
    ],
)  # fmt: skip
def test_a_device(structured, old, new, told):
    found = warnings(structured((None, old, new), more=TRANSIENT + PUMP + BEAM))
    assert ["devices[0]." + told in line for line in found] == [True] if told else found == []


@pytest.mark.parametrize(
    ("section", "key", "kept", "told"),
    [
        (TRANSIENT, "time_step", "2 ms", "50 ms"),
        (TRANSIENT, "shift", "20 Hz", "300 Hz"),
        (TRANSIENT, "maximum_frequency", "60 Hz", "1 Hz"),
        (TRANSIENT, "tolerance", "3 %", "90 %"),
        (TRANSIENT, "largest_basis", 500, 1),
        (WALL, "duration", "2 s", "10 ms"),
        (WALL, "contact_spacing", "2 m", "100 m"),
    ],
)
def test_the_model_in_time(structured, section, key, kept, told):
    name = section.split()[0].strip("[]")
    lines = [line for line in section.splitlines() if not line.startswith(key)]
    for value, found in ((kept, []), (told, [f"{name}.{key} = {told!r}: usual is"])):
        case = structured(more="\n".join([*lines, f"{key} = {value!r}", ""]))
        seen = [line for line in warnings(case) if f"{name}.{key}" in line]
        assert [text in line for text, line in zip(found, seen, strict=True)] == [True] * len(found)


def test_a_device_that_is_part_of_the_building(structured):
    """From a tenth of its floor on: US NRC SRP 3.7.2."""
    for mass, told in ((14, False), (16, True)):
        light = (FLOORS, "8,3014,", "8,150,"), (None, 'mass = "1.5 t"', f'mass = "{mass} t"')
        found = [one for one in warnings(structured(*light, more=TRANSIENT + PUMP)) if "t':" in one]
        assert [f"mass = '{mass} t': 0.107 times the mass of floor 8" in one for one in found] == (
            [True] if told else []
        )


@pytest.mark.parametrize(
    ("file", "old", "kept", "told", "usual"),
    [
        (None, '"33 GPa"', '"5.5 GPa"', '"3.1 GPa"', "with a density of 2400 kg/m3; usual is"),
        (None, '"33 GPa"', '"55 GPa"', '"210 GPa"', "with a density of 2400 kg/m3; usual is"),
        (None, '"33 GPa"', '"33000 MPa"', '"310 GPa"', "usual is concrete 20 to 45 GPa, masonry"),
        (None, '"30 MPa"', '"150 MPa"', '"300 MPa"', "usual is concrete 12 to 100 MPa"),
        (None, 'gap = "1 cm"', 'gap = "50 cm"', 'gap = "90 cm"', "usual is 0 to 30 cm"),
        (None, 'ratio = "7 %"', 'ratio = "15 %"', 'ratio = "29 %"', "usual is 1 % to 10 %"),
        (None, 'minimum = "0.5 Hz"', 'minimum = "0.05 Hz"', 'minimum = "0.001 Hz"',
         "usual is 0.1 to 1 Hz"),
        (FLOORS, "62,3.60,3.50,4.80", "62,15,3.5,15", "62,40,3.5,40", "usual is 2.5 to 8 m"),
    ],
)  # fmt: skip
def test_from_where_on_a_value_is_hardly_meant(broken, file, old, kept, told, usual):
    """Beyond what is usual, but short of what no building has."""
    assert not [line for line in warnings(broken((file, old, kept))) if "usual is" in line]
    found = [line for line in warnings(broken((file, old, told))) if "usual is" in line]
    assert len(found) == 1 and usual in found[0]


def test_moduli_of_what_is_not_as_dense_as_concrete(broken):
    """Steel and timber have others, and where no density is given it says nothing."""
    for density, modulus in ((7850, 210), (450, 11), (1900, 3.1)):
        edits = (None, '"33 GPa"', f'"{modulus} GPa"'), (None, "2400 kg", f"{density} kg")
        assert warnings(broken(*edits)) == []


@pytest.mark.parametrize(
    ("step", "peak", "keys", "told"),
    [
        (0.01, 3.0, "", None),
        (0.01, 294.0, "", "peak ground acceleration = '294"),
        (0.01, 1e-3, "", "peak ground acceleration = '0.001"),
        (0.01, 294.0, "scale = 0.01", None),
        (0.01, 294.0, 'pga = "3 m/s2"', None),
        (0.01, 3.0, 'pga = "19 m/s2"', "motions[0].pga = '19 m/s2': usual is 0.5 to 10 m/s2"),
        (0.5, 3.0, "", "time step = '0.5 s': as the case uses it; usual is 1 to 20 ms"),
        (0.5, 3.0, 'resample = "5 ms"', None),
    ],
)  # fmt: skip
def test_a_record(recorded, step, peak, keys, told):
    samples = [peak * math.sin(0.1 * math.pi * k) for k in range(round(LONGEST / step))]
    path = recorded(samples, step, keys)
    found = [line for line in warnings(path) if not {"longest", "velocity"} & {*line.split()}]
    assert [told in line for line in found] == [True] if told else found == []


def test_two_motions_that_are_one(written, broken):
    """By their seeds, or their records and components."""
    other = MOTION.replace('"y"', '"x"')
    (line,) = warnings(broken(more=other))
    assert "motions[1].seed = 1: the seed of motions[0] along y, too: both go up and down" in line
    assert warnings(broken(more=other.replace("seed = 1", "seed = 2"))) == []
    lines = "".join(f"{k / 100:g},{(-1) ** k},{(-1) ** k}\n" for k in range(1680))
    record = RECORD.replace("\n\n", '\ncomponent = "NS"\n\n')
    for component, told in (("NS", True), ("EW", False)):
        second = record.replace('"x"', '"y"').replace("NS", component)
        path = written(RECORDED, (None, RECORD, f"{record}{second}"))
        (path.parent / "motion.csv").write_text(f"time [s],NS [m/s2],EW [m/s2]\n{lines}", "utf-8")
        found = [line for line in warnings(path) if "motions[1].file = 'motion.csv'" in line]
        assert len(found) == told


@pytest.mark.parametrize(
    ("component", "direction", "told"),
    [
        ("HNZ", "y", "direction = 'y': HNZ is the name of a vertical component"),
        ("UD", "x", "direction = 'x': UD is the name of a vertical component"),
        ("N-S", "z", "direction = 'z': N-S is the name of a horizontal component"),
        ("HNZ", "z", ""),
        ("EW", "y", ""),
        ("upper", "y", ""),
        *((name, "y", "") for name in ("version", "V1", "acc_x")),
        *((name, "z", "") for name in ("ch 003", "a_v")),
        *((name, "x", f"{name} is the name of a vertical") for name in ("Z", "Up-Down", "acc_z")),
        *((name, "z", f"{name} is the name of a horizontal") for name in ("north", "a H1")),
    ],
)
def test_a_component_along_another_direction(recorded, component, direction, told):
    samples = [(-1) ** k for k in range(1680)]
    path = recorded(samples, 0.01, f'component = "{component}"', direction, component)
    found = [line for line in warnings(path) if "the name of a" in line]
    assert len(found) == bool(told) and all(told in line for line in found)


@pytest.mark.parametrize(
    ("name", "direction", "told"),
    [
        ("RSN6_IMPVALL.I_I-ELC-UP", "x", "RSN6_IMPVALL.I_I-ELC-UP is the name of a vertical"),
        ("RSN79_SFERN_PAS-DWN", "x", "a vertical component"),
        ("RSN5618_IWATE_IWT010UD", "y", "a vertical component"),
        ("RSN6_IMPVALL.I_I-ELC180", "x", ""),
        ("RSN6_IMPVALL.I_I-ELC180", "z", "a horizontal component"),
        ("A-ELC-VER", "z", ""),
    ],
)
def test_a_component_by_the_name_of_its_file(broken, name, direction, told):
    """Records of PEER have one component, which ends the name of the file."""
    record = RECORD.replace('"x"', f'"{direction}"').replace("motion.csv", f"{name}.AT2")
    path = broken((None, MOTION, record), files={f"{name}.AT2": at2_text([0.1, -0.1] * 840, 0.01)})
    found = [line for line in warnings(path) if "the name of a" in line]
    assert len(found) == bool(told) and all(told in line for line in found)


@pytest.mark.parametrize(("step", "told"), [("5 ms", 0), ("10 ms", 1)])
def test_a_synthetic_motion_of_a_coarse_step(broken, step, told):
    """The structure takes straight lines between its samples."""
    found = warnings(broken((None, 'time_step = "5 ms"', f'time_step = "{step}"')))
    assert (
        sum("motions[0].time_step" in line and "straight lines" in line for line in found) == told
    )


@pytest.mark.parametrize(("late", "told"), [(1.0, "16.7 % of its"), (0.4, "")])
def test_a_duration_that_cuts_a_record(recorded, edited, late, told):
    """At a sixth of it, by the part of the Arias intensity that comes later."""
    sine = [math.sin(0.1 * math.pi * k) for k in range(1201)]
    samples = [a * (late if k > 1000 else 1.0) for k, a in enumerate(sine)]
    path = edited(recorded(samples, 0.01), ("16.79 s", "10 s"))
    found = [line for line in warnings(path) if "Arias intensity" in line]
    assert len(found) == bool(told)
    assert all(f"pounding.duration = '10 s': {told}" in line for line in found)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("20,0,0", "20,0,0", None),
        ("5,2.5,-40", "5,2.5e4,-40", "B1.floor_8 = '2.5e+10 N': 846 times its weight; usual is"),
        ("[ms]", "[s]", None),
        ("0,0,0\n5,2.5,-40\n20,0,0", "0,0,0\n17000,0,0\n17005,1,1",
         "loads[0].file = 'blast.csv': no force within the 16.79 s that are computed"),
    ],
)  # fmt: skip
def test_forces_on_floors(broken, old, new, told):
    blast = {"blast.csv": replaced(BLAST["blast.csv"], (old, new))}
    found = warnings(broken(more=LOADS, files=blast))
    assert [told in line for line in found] == [True] if told else found == []


def test_a_plan_of_another_size_than_its_mesh(structured):
    for width, told in (("15.7 m", False), ("16 m", True)):
        found = warnings(structured((None, 'name = "B1"', f'name = "B1"\nwidth = "{width}"')))
        key = f"buildings[1].width = '{width}': the width of its mesh is 15.6 m; usual is the same"
        assert [key in line for line in found] == ([True] if told else [])


@pytest.mark.parametrize(
    ("offset", "keys", "told"),
    [(0.0, "", False), (0.2, "", True), (0.2, 'baseline = "mean"', False)],
)
def test_a_record_that_does_not_end_at_rest(recorded, offset, keys, told):
    samples = [offset + math.sin(0.2 * math.pi * k) for k in range(1671)]
    path = recorded(samples, 0.01, keys)
    found = [line for line in warnings(path) if "velocity at the end" in line]
    assert len(found) == told
    assert all("motion.csv: velocity at the end = '3.34 m/s': 9" in line for line in found)


def test_points_of_contact_that_no_edge_has(broken):
    spacing = (None, "[pounding]", '[pounding]\ncontact_spacing = "2 m"')
    (line,) = warnings(broken(spacing))
    assert "pounding.contact_spacing = '2 m': not used: sticks touch at the points of" in line
    # With an edge in 3D it is used.
    assert warnings(GEOMETRY / "npp_pair_coupled.toml") == []


def test_forces_on_floors_drive_buildings_as_well(broken):
    """The ground moves along x and contacts have normals along y; a blast acts along y."""
    change = (None, 'direction = "y"', 'direction = "x"')
    (alone,) = (one for one in warnings(broken(change)) if "not driven" in one)
    assert "motions[0].direction" in alone
    path = broken(change, more=LOADS, files=BLAST)
    assert not any("not driven" in one for one in warnings(path))


@pytest.mark.parametrize(("pga", "times"), [("0.46 m/s2", "0.2"), ("3.1 m/s2", "1.35")])
def test_a_peak_that_is_not_that_of_the_target(broken, pga, times):
    change = (None, 'pga = "2.32 m/s2"', f'pga = "{pga}"')
    (line,) = warnings(broken(change))
    assert f"motions[0].pga = '{pga}': {times} times that of its spectrum at zero period" in line
    assert warnings(broken((None, 'pga = "2.32 m/s2"', 'pga = "2.28 m/s2"'))) == []  # rounded


@pytest.mark.parametrize(("last", "told"), [(40, True), (20, False)])
def test_a_table_that_ends_before_the_peak_says_nothing_of_it(broken, last, told):
    section = 'amplification = 2.5\ncorner_periods = ["0.05 s", "0.25 s", "2.5 s"]'
    table = f"frequency [Hz],acceleration [m/s2]\n0.5,2\n2,6\n8,6\n{last},4\n"
    first = (None, 'ground_acceleration = "2.3 m/s2"', 'type = "table"')
    path = broken(first, (None, section, 'file = "target.csv"'), files={"target.csv": table})
    assert [("motions[0].pga" in line) for line in warnings(path)] == ([True] if told else [])


def test_damping_cases_that_are_the_same(broken):
    def same(more):
        return [line for line in warnings(broken(more=more)) if "the same damping" in line]

    lighter = LIGHT.replace("light", "lighter").replace("0.212 ms", "2.12e-4 s")
    both = f"{LIGHT}restitution = 0.8\n{lighter}restitution = "
    (line,) = same(f"{both}0.8\n")
    assert "damping_cases[1].name = 'lighter': the same damping and restitution as" in line
    assert same(f"{both}0.7\n") == []
    own = (
        '\n[[damping_cases]]\nname = "own_again"\nratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]\n'
    )
    (line,) = same(own)
    assert "damping_cases[0].name = 'own_again': the same damping and restitution as [dam" in line
    assert same(f"{own}restitution = 0.8\n") == []


@pytest.mark.parametrize(
    ("direction", "keys", "told"),
    [("y", "", None), ("y", "vertical = true\n", "vertical"), ("z", "", "horizontal"),
     ("z", "vertical = true\n", None)],
)  # fmt: skip
def test_a_spectrum_of_another_direction(written, direction, keys, told):
    base = with_spectrum(f"{EC8}{keys}")
    found = warnings(
        written(base, (None, 'direction = "y"\ntype', f'direction = "{direction}"\ntype'))
    )
    lines = [line for line in found if "its spectrum is the" in line]
    words = f"motions[0].direction = '{direction}': its spectrum is the {told} one"
    assert len(lines) == (told is not None) and all(words in line for line in lines)


@pytest.mark.parametrize(
    ("gap", "displacement", "reached"),
    [("1 cm", "-2 cm", True), ("5 cm", "-2 cm", False), ("5 cm", "2 cm", False)],
)
def test_a_wall_out_of_reach(structured, gap, displacement, reached):
    section = replaced(WALL, ('"1 cm"', f'"{gap}"'), ("-2 cm", displacement))
    found = warnings(structured(more=section))
    assert [f"wall_impact.gap = '{gap}': the wall is out of reach" in line for line in found] == (
        [] if reached else [True]
    )


def test_plans_that_overlap(tmp_path):
    """The pairs of B and C left out, which would be refused; C moved into B."""
    for file in GEOMETRY.glob("row_of_three_*.csv"):
        shutil.copy(file, tmp_path)
    text = (GEOMETRY / "row_of_three.toml").read_text(encoding="utf-8")
    first = text.index("[[contacts]]                            # the roofs of B and C")
    text = text[:first] + text[text.index("[pounding]") :]
    path = tmp_path / "row.toml"
    path.write_text(text, encoding="utf-8")
    assert not any("axis" in line for line in warnings(path, 10.0))
    path.write_text(replaced(text, ('"24.05 m"', '"20.05 m"')), encoding="utf-8")
    (line,) = (line for line in warnings(path, 10.0) if "axis" in line)
    assert "buildings[2].axis = ['8 m', '20.05 m']: the plan overlaps that of B by 3.97 m" in line


def test_the_usual_ranges_are_ranges():
    for usual in USUAL:
        assert usual.low < usual.high and usual.words


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("10,y,300,1200", "pair_modes.csv: row 1, height = 1200.0: in SI; usual is 0.2 to 5 m"),
        ("10,y,600000,1.2", "times the mass of floor"),
        ("10,x,300,1.2", "modes = 'pair_modes.csv': no mode along y, along which the ground moves"),
        ("10,y,300,1.2", None),
    ],
)
def test_a_device_of_modes(structured, row, told):
    path = structured(more=TRANSIENT + CABINET)
    header = "frequency [Hz],direction,effective_mass [kg],height [m]\n"
    (path.parent / "pair_modes.csv").write_text(header + row, "utf-8")
    found = warnings(path)
    assert any(told in line for line in found) if told else found == []


@pytest.mark.parametrize(
    ("analysis", "told"),
    [
        ('duration = "5 s"', "duration = '5 s': not used: only the combinations 'dsc' and"),
        ('combination = ["dsc"]\nduration = "40 s"', "duration = '40 s': the strong motion is"),
        ('combination = ["dsc"]\nduration = "9 s"', None),
        ("broadening = 0.9", "broadening = 0.9: usual is 10 % to 15 %"),
    ],
)
def test_the_analysis_of_devices(structured, analysis, told):
    found = warnings(structured(more=f"{TRANSIENT}{PUMP}\n[device_analysis]\n{analysis}\n"))
    assert ["device_analysis." + told in line for line in found] == [True] if told else found == []


def test_given_spectra_without_the_direction_of_the_ground(structured):
    path = structured(more=TRANSIENT + PUMP.replace("mass =", 'spectra = "floor.csv"\nmass =', 1))
    rows = "".join(f"{f},5,x,{xi}\n" for xi in (0.01, 0.1) for f in (1, 500))
    header = "frequency [Hz],acceleration [m/s2],direction,damping [-]\n"
    (path.parent / "floor.csv").write_text(header + rows, "utf-8")
    (line,) = warnings(path)
    assert "devices[0].spectra = 'floor.csv': no spectrum along y, along which the ground" in line
    (path.parent / "floor.csv").write_text(header + rows.replace("x", "y"), "utf-8")
    assert warnings(path) == []


@pytest.mark.parametrize(
    ("ensemble", "told"),
    [
        (
            "motions = 9",
            "ensemble.motions = 9: the fractiles of 5 % and 95 % of fewer than 10 motions",
        ),
        ("motions = 10", None),
        (
            "motions = 20\nstructure_motions = 3",
            "ensemble.structure_motions = 3: fractiles of 84 % of fewer than 4",
        ),
        ("motions = 20\nstructure_motions = 4", None),
    ],
)
def test_motions_of_an_ensemble(structured, ensemble, told):
    found = warnings(structured(more=f"{TRANSIENT}\n[ensemble]\n{ensemble}\n"))
    assert [told in line for line in found] == [True] if told else found == []
