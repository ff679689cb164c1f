"""Plausibility warnings: one for each value, with what is usual."""

import math
from pathlib import Path
from typing import get_args, get_origin

import pytest
from pydantic import BaseModel

from impactfem.case import load_case
from impactfem.case.model import CaseFile
from impactfem.case.place import alternatives, form_of
from impactfem.case.plausibility import USUAL, implausible
from impactfem.motion.from_case import plausibility_warnings
from impactfem.verify.motion import at2_text

from .sections import (
    BEAM,
    BLAST,
    CABINET,
    EC8,
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

GEOMETRY = Path(__file__).parents[2] / "geometry"
LONGEST = 16.79
FLOORS, TARGETS = "pair_floors.csv", "pair_targets.csv"
MASS = "devices[0].mass"


@pytest.fixture
def recorded(broken):
    """The case with a record in place of its motion."""

    def write(samples, step, keys="", direction="y", name="a"):
        lines = (f"{k * step:g},{a:.17g}" for k, a in enumerate(samples))
        record = RECORD.replace('"x"', f'"{direction}"').replace("\n\n", f"\n{keys}\n\n")
        text = "\n".join((f"time [s],{name} [m/s2]", *lines))
        return broken((None, MOTION, record), files={"motion.csv": text})

    return write


def faults(path, longest=LONGEST):
    return implausible(load_case(path), longest)


def warnings(path, longest=LONGEST):
    found = (*faults(path, longest), *plausibility_warnings(load_case(path)))
    return [str(one).replace(f"{path.parent}/", "") for one in found]


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


RAYLEIGH = 'ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]'


@pytest.mark.parametrize(
    ("file", "old", "new", "key", "value"),
    [
        (None, '"33 GPa"', '"33 Pa"', "materials.concrete.young_modulus", "33 Pa"),
        (None, '"30 MPa"', '"300 MPa"', "materials.concrete.compressive_strength", "300 MPa"),
        (None, 'ratio = "7 %"', 'ratio = "29 %"', "damping.ratio", "29 %"),
        (None, '["1 Hz", "20 Hz"]', '["1 Hz", "2 kHz"]', "damping.frequencies[1]", "2 kHz"),
        (None, '["1 Hz", "20 Hz"]', '["0.1 Hz", "0.2 Hz"]', "damping", None),
        (None, RAYLEIGH, 'mass_coefficient = "0 1/s"\nstiffness_coefficient = "0 s"', "damping",
         None),
        (None, RAYLEIGH, 'type = "table"\npoints = [["1 Hz", "7 %"], ["1 kHz", 7]]', "damping",
         None),
        (None, 'damping_ratio = "12 %"', "restitution = 1e-9", "contact_laws.floor.restitution",
         1e-9),
        (None, 'normal = [0, 1, 0]\ngap = "1 cm"', 'normal = [0, 1, 1e-4]\ngap = "90 cm"',
         "contacts[0].gap", "90 cm"),
        (None, "amplification = 2.5\ncorner_periods = [\"0.05 s\"",
         "amplification = 2.5\ncorner_periods = [\"0.05 ms\"",
         "motions[0].spectrum.corner_periods[0]", "0.05 ms"),
        (None, 'minimum = "0.5 Hz"', 'minimum = "0.001 Hz"', "spectra.frequencies.minimum",
         "0.001 Hz"),
        (None, "per_decade = 100 }", "per_decade = 100 }\nbroadening = 0.9", "spectra.broadening",
         0.9),
        (None, 'damping = ["5 %"]', 'damping = ["90 %"]', "spectra.damping[0]", "90 %"),
        (FLOORS, "3,1682,", "3,1e50,", "floor 3, mass", 1e53),
        (FLOORS, "62,3.60,3.50,4.80", "62,40,3.5,40", "floor 3, storey_height", 40.0),
        (FLOORS, "1,2502,6.3e7", "1,2502,6.3e3", "floor 1, gyration", 0.0501795),
        (FLOORS, "1,2502,6.3e7,5.1e8,5.7e8", "1,2502,6.3e8,5.1e8,5.7e7", "floor 1, inertia_share",
         1.11111),
        (FLOORS, ",234,169,214,", ",234,469,214,", "floor 1, shear_share", 2.00427),
        (None, "[contact_laws.floor]",
         '[contact_laws.spare]\ntype = "unilateral"\n[contact_laws.floor]', "contact_laws.spare",
         None),
        (None, "[pounding]", '[pounding]\ncontact_frequency = "300 Hz"',
         "pounding.contact_frequency", "300 Hz"),
    ],
)  # fmt: skip
def test_one_value(broken, file, old, new, key, value):
    (found,) = faults(broken((file, old, new)))
    shown = pytest.approx(found.value) if isinstance(value, float) else found.value
    assert (found.key, shown) == (key, value)


@pytest.mark.parametrize(
    ("file", "old", "new", "key"),
    [
        (None, 'slab_thickness = "30 cm"', 'slab_thickness = "1 nm"',
         "buildings[1].structure.mesh.slab_thickness"),
        (None, 'size = "0.9 m"', 'size = "90 m"', "buildings[1].structure.mesh.size"),
        # The unit of a column is that of all rows: one warning.
        ("pair_walls.csv", "thickness [cm]", "thickness [m]", "row 1, thickness"),
        ("pair_beams.csv", "-0.29", "29", "row 2, offset"),
        ("pair_columns.csv", "0.8,1.2", "1e-9,1.2", "row 1, width_x"),
    ],
)  # fmt: skip
def test_the_mesh(structured, file, old, new, key):
    assert [fault.key for fault in faults(structured((file, old, new)))] == [key]


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('radius = "0.5 m"\nmass', 'radius = "500 m"\nmass', "devices[0].radius"),
        ('damping = { ratio = "2 %"', 'damping = { ratio = "50 %"', "devices[0].damping.ratio"),
        ('y = "1.2e8 N/m"', 'y = "4e3 N/m"', "devices[0]"),
        ('y = "1.2e8 N/m"', 'y = "1.6e4 N/m"', None),
        ('bending = ["80 MN m2", "60 MN m2"]', 'bending = "80 N m2"', "devices[0]"),
        ('mass = "1.5 t"', 'mass = "150 t"', "devices[0].mass"),
    ],
)
def test_a_device(structured, old, new, key):
    found = faults(structured((None, old, new), more=TRANSIENT + PUMP + BEAM))
    assert {fault.key for fault in found} == ({key} - {None})


@pytest.mark.parametrize(
    ("file", "old", "new", "keys"),
    [
        ("mass.csv", "500", "500", set()),
        ("mass.csv", "500", "0.5", {"devices[0].matrices"}),  # tonnes as kilograms
        ("mass.csv", "500", "5e5", {"devices[0].matrices"}),
        ("stiffness.csv", "e6", "e2", {"devices[0].matrices"}),
        ("stiffness.csv", "e6", "e9", set()),
    ],
)
def test_matrices_in_wrong_units(structured, file, old, new, keys):
    """A device with matrices: 500 kg, 14.2 Hz."""
    files = PIPE_FILES | {file: PIPE_FILES[file].replace(old, new)}
    found = {fault.key for fault in faults(structured(more=PIPE, files=files))}
    assert {key for key in found if "matrices" in key} == keys


@pytest.mark.parametrize(("mass", "warned"), [(14, False), (16, True)])
def test_a_device_that_is_part_of_the_building(structured, mass, warned):
    """From a tenth of its floor on: US NRC SRP 3.7.2."""
    light = (FLOORS, "8,3014,", "8,150,"), (None, 'mass = "1.5 t"', f'mass = "{mass} t"')
    found = [one for one in faults(structured(*light, more=TRANSIENT + PUMP)) if one.key == MASS]
    assert [("0.107" in one.expected) for one in found] == [True] * warned


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        (TRANSIENT, "time_step", "50 ms"),
        (TRANSIENT, "maximum_frequency", "1 Hz"),
        (TRANSIENT, "tolerance", "90 %"),
        (WALL, "gap", "5 cm"),  # out of reach
        (WALL, "displacement", "-90 cm"),
    ],
)
def test_the_model_in_time(structured, section, key, value):
    lines = [line for line in section.splitlines() if not line.startswith(key)]
    found = faults(structured(more="\n".join([*lines, f'{key} = "{value}"', ""])))
    assert f"{section.split()[0].strip('[]')}.{key}" in {fault.key for fault in found}


def test_given_tables_without_the_direction_of_the_ground(structured):
    path = structured(more=TRANSIENT + CABINET)
    header = "frequency [Hz],direction,effective_mass [kg],height [m]\n"
    for row, keys in (("10,x,300,1.2", {"devices[0].modes"}), ("10,y,300,1.2", set())):
        (path.parent / "pair_modes.csv").write_text(header + row, "utf-8")
        assert {fault.key for fault in faults(path)} == keys


@pytest.mark.parametrize(("motions", "warned"), [(9, True), (10, False)])
def test_motions_of_an_ensemble(broken, motions, warned):
    found = faults(broken(more=f"\n[ensemble]\nmotions = {motions}\n"))
    assert [fault.key for fault in found] == ["ensemble.motions"] * warned


def test_forces_on_floors_drive_buildings_as_well(broken):
    """The ground moves along x and contacts have normals along y; a blast acts along y."""
    change = (None, 'direction = "y"', 'direction = "x"')
    assert faults(broken(change, more=LOADS, files=BLAST)) == []


@pytest.mark.parametrize(
    ("direction", "keys", "warned"),
    [("y", "", False), ("y", "vertical = true\n", True), ("z", "", True),
     ("z", "vertical = true\n", False)],
)  # fmt: skip
def test_a_spectrum_of_another_direction(written, direction, keys, warned):
    turned = (None, 'direction = "y"\ntype', f'direction = "{direction}"\ntype')
    found = faults(written(with_spectrum(f"{EC8}{keys}"), turned))
    assert any("its spectrum" in one.expected for one in found) == warned


def test_names_of_published_values(broken):
    found = faults(broken(("pair_published.csv", "frs.", "floors.")))
    assert {one.key for one in found} == {"name"}


def test_the_rows_of_the_table():
    """Each is a range, and each of its keys is one of the case, a column, or a property."""
    for usual in USUAL:
        assert usual.low < usual.high and usual.words
        for keys in usual.keys.split():
            assert known(CaseFile, keys.split(".")), keys


def known(annotation, keys):
    """Whether a type has a value at keys: fields, items of tables, properties of models."""
    if not keys:
        return True
    types = list(alternatives(annotation))
    if keys[0] in ("*", "row"):
        items = [
            get_args(one)[-1 if get_origin(one) is dict else 0]
            for one in types
            if get_origin(one) in (tuple, dict)
        ]
        return any(known(item, keys[1:]) for item in items)
    models = [one for one in types if isinstance(one, type) and issubclass(one, BaseModel)]
    fields = [
        form_of(model.model_fields[keys[0]]) for model in models if keys[0] in model.model_fields
    ]
    derived = any(isinstance(getattr(model, keys[0], None), property) for model in models)
    return derived or any(known(field, keys[1:]) for field in fields)


@pytest.mark.parametrize(
    ("step", "peak", "keys", "told"),
    [
        (0.01, 3.0, "", None),
        (0.01, 294.0, "", "peak ground acceleration = '294"),
        (0.01, 1e-3, "", "peak ground acceleration = '0.001"),
        (0.01, 294.0, "scale = 0.01", None),
        (0.01, 294.0, 'pga = "3 m/s2"', None),
        (0.01, 3.0, 'pga = "19 m/s2"', "motions[0].pga = '19 m/s2': outside the"),
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
    assert "seed of motions[0]" in line
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
    ("offset", "keys", "told"),
    [(0.0, "", False), (0.2, "", True), (0.2, 'baseline = "mean"', False)],
)
def test_a_record_that_does_not_end_at_rest(recorded, offset, keys, told):
    samples = [offset + math.sin(0.2 * math.pi * k) for k in range(1671)]
    path = recorded(samples, 0.01, keys)
    found = [line for line in warnings(path) if "velocity at the end" in line]
    assert len(found) == told
    assert all("end = '3.34 m/s': 9" in line for line in found)


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
