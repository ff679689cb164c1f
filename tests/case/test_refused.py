"""What a case file refuses: sections, motions, laws, loads, ensembles."""

from .faults import check_row, each_row, own_faults
from .sections import (
    BLAST,
    DECREE,
    EC8,
    GRID,
    LAW,
    LIGHT,
    LOADS,
    RECORDED,
    TABLE,
    TRANSIENT,
    WALL,
    Base,
    with_spectrum,
)

AXIS = 'axis = ["23.1 m", "7.8 m"]'
FLOORS = f'floors = "pair_floors.csv"\n{AXIS}'  # of B1
FLOORS_A = '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 8]'
FLOORS_B = '{ building = "B2", floor = [1, 2, 3, 4, 5, 6, 7, 8]'
TWICE = """[[contacts]]
a = { building = "B1", floor = 8, offset = ["0 m", "7.8 m", "0 m"] }
b = { building = "B2", floor = 8, offset = ["0 m", "-7.8 m", "0 m"] }
normal = [0, 1, 0]
gap = "1 cm"
law = "floor"

"""
SWAPPED = TWICE.replace("b = {", "c = {").replace("a = {", "b = {").replace("c = {", "a = {")
SWAPPED = SWAPPED.replace("[0, 1, 0]", "[0, -1, 0]")
SECTIONS = [
    ('gap = "1 cm"', "gap = 0.01", "contacts[0].gap", "unit_missing"),
    ('gap = "1 cm"', 'gap = "-1 cm"', "contacts[0].gap", "greater_than_equal 0"),
    ('gap = "1 cm"', "gap = 2020-01-01", "contacts[0].gap", "quantity"),
    ('gap = "1 cm"', "", "contacts[0].gap", "missing"),
    ('young_modulus = "33 GPa"', 'young_modulus = "0 GPa"', "materials.concrete.young_modulus",
     "greater_than 0"),
    ("poisson_ratio = 0.2", "poisson_ratio = 0.5", "materials.concrete.poisson_ratio",
     "less_than 0.5"),
    ("[0.02, 1.0]", "[0.02, inf]", "calibration.stiffness_factor[1]", "finite_number"),
    ('gap = "1 cm"', 'gapp = "1 cm"', "contacts[0].gapp", "extra_forbidden 'gap'"),
    ("[damping]", "[dampin]", "dampin", "extra_forbidden 'damping'"),
    ("[[buildings]]", "[[building]]", "building", "extra_forbidden 'buildings'"),
    ("starts = 40", "startz = 40", "calibration.startz", "extra_forbidden 'starts'"),
    ("amplification = 2.5", "zz = 2.5", "motions[0].spectrum.zz", "extra_forbidden"),
    ('time_step = "0.3358 ms"', "", "pounding.time_step", "missing"),
    ("title = ", "title = 1 #", "title", "text"),
    ('title = "Two', 'title = "" # "Two', "title", "text"),
    ('name = "B1"', 'name = "B 1"', "buildings[0].name", "text",
     "contacts[0].a.building", *(f"line {k}, column building" for k in (3, 4, 5))),
    ("seed = 1\n", "seed = 1.5\n", "motions[0].seed", "int_type"),
    ("tension = true", 'tension = "yes"', "contact_laws.floor.tension", "bool_type"),
    ("[materials.concrete]", "[materials]", "materials.young_modulus", "model_type",
     *(f"materials.{key}" for key in ("poisson_ratio", "density", "compressive_strength")),
     "buildings[0].material", "buildings[1].material"),
    ("[[contacts]]", "[contacts]", "contacts", "tuple_type"),
    ("[pounding]", "[[pounding]]", "pounding", "model_type"),
    ('axis = ["23.1 m", "7.8 m"]', 'axis = ["23.1 m"]', "buildings[0].axis",
     "missing"),
    ('axis = ["23.1 m", "7.8 m"]', 'axis = "23.1 m"', "buildings[0].axis", "tuple_type"),
    ("[0, 1, 0]", "[0, 1, 0, 0]", "contacts[0].normal", "too_long"),
    ("[0, 1, 0]", "[0, 0, 0]", "contacts[0].normal", "zero"),
    ("[0, 1, 0]", '["x", 1, 0]', "contacts[0].normal[0]", "quantity"),
    ('"implicit"', '"implicitly"', "pounding.update", "literal_error"),
    ('direction = "y"\ntype', 'direction = "Y"\ntype', "motions[0].direction", "literal_error"),
    ('type = "synthetic"', 'type = "synth"', "motions[0].type", "union_tag_invalid"),
    ('type = "synthetic"', "", "motions[0].type", "union_tag_not_found"),
    ('type = "kelvin-voigt"', 'type = "herz"', "contact_laws.floor.type", "union_tag_invalid"),
    ('type = "kelvin-voigt"', "", "contact_laws.floor.type", "union_tag_not_found"),
    ('law = "floor"', 'law = "flor"', "contacts[0].law",
     "unknown_name 'floor'"),
    ("[contact_laws.floor]", "[contact_laws.wall]", "contacts[0].law", "unknown_name"),
    ('material = "concrete"', 'material = "concret"', "buildings[1].material",
     "unknown_name 'concrete'", "buildings[0].material"),
    ('{ building = "B1"', '{ building = "B3"', "contacts[0].a.building", "unknown_name"),
    ('name = "B2"', 'name = "B1"', "buildings[1].name",
     "duplicate"),
    ('name = "B2"', 'name = "b1"', "buildings[1].name",
     "duplicate"),
    (FLOORS_A, '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 9]', "contacts[0].a.floor",
     "no_floor"),
    (FLOORS_A, '{ building = "B1", storey = 9, relative_height = 0.5', "contacts[0].a.storey",
     "no_floor"),
    (FLOORS_A, '{ building = "B1", floor = [1, 2]', "contacts[0].b",
     "pairs"),
    (FLOORS_A, '{ building = "B1"', "contacts[0].a.storey", "either"),
    (FLOORS_A, f"{FLOORS_A}, storey = 1, relative_height = 0.5", "contacts[0].a.storey",
     "either"),
    (FLOORS_A, '{ building = "B1", storey = 1', "contacts[0].a.relative_height",
     "of_storey"),
    (FLOORS_A, f"{FLOORS_A}, relative_height = 0.5", "contacts[0].a.relative_height",
     "of_storey"),
    *(
        (FLOORS_A, f'{{ building = "B1", storey = 1, relative_height = {s}',
         "contacts[0].a.relative_height", kind)
        for s, kind in (("0.0", "greater_than 0"), ("1.0", "less_than 1"),
                        ('"0 %"', "greater_than 0"))
    ),
    (FLOORS_B, '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 8]', "contacts[0].b",
     "pairs"),
    ("b = { build", 'wall = "pit"\nb = { build', "contacts[0].wall", "building_or_wall"),
    ("b = { build", "# { build", "contacts[0].wall", "building_or_wall"),
    ("b = { build", 'wall = "B2" # { build', "contacts[0].wall", "building_or_wall"),
    ("b = { build", 'wall = "a b" # { build', "contacts[0].wall", "text"),
    ("[pounding]", f"{TWICE}[pounding]", "contacts", "of_contacts"),
    ("[pounding]", f"{SWAPPED}[pounding]", "contacts", "of_contacts"),
    (FLOORS, f'floors = "none.csv"\n{AXIS}', "buildings[0].floors", "unreadable"),
    (FLOORS, f'floors = "."\n{AXIS}', "buildings[0].floors", "unreadable"),
    (FLOORS, f"floors = 3\n{AXIS}", "buildings[0].floors", "file_name"),
    ('"pair_targets.csv"', '"none.csv"', "calibration.targets", "unreadable"),
    ('"pair_published.csv"', '"none.csv"', "published", "unreadable"),
    ('ratio = "7 %"', 'ratio = "7 %"\nmass_coefficient = "1 1/s"', "damping.mass_coefficient",
     "one_way"),
    ('["1 Hz", "20 Hz"]', '["20 Hz", "1 Hz"]', "damping.frequencies", "ascending"),
    ('ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]\n', "", "damping.stiffness_coefficient",
     "one_of_them"),
    ('damping_ratio = "12 %"', 'damping_ratio = "12 %"\nrestitution = 0.7',
     "contact_laws.floor.damping_ratio", "either"),
    ('damping_ratio = "12 %"', "", "contact_laws.floor.damping_ratio", "either"),
    ('"0.05 s", "0.25 s"', '"0.25 s", "0.05 s"', "motions[0].spectrum.corner_periods",
     "ascending"),
    ('["2 s", "5 s"]', '["5 s", "2 s"]', "motions[0].strong_phase", "ascending"),
    ('["2 s", "5 s"]', '["2 s", "50 s"]', "motions[0].strong_phase",
     "phase_in_duration 16.79 s"),
    ('["2 s", "5 s"]', '["2 s", "2.155 s"]', "motions[0].strong_phase",
     "phase_of_steps 32 time steps"),
    ("amplification = 2.5", "amplification = 0.9", "motions[0].spectrum.amplification",
     "greater_than_equal 1"),
    ('time_step = "5 ms"', 'time_step = "50 s"', "motions[0].time_step", "step_within"),
    ('"0.3358 ms"', '"335.8 s"', "pounding.time_step", "step_within 16.79 s"),
    ("[0.02, 1.0]", "[1.0, 0.02]", "calibration.stiffness_factor", "ordered"),
    ('height = "30.3 m"', 'height = "40 m"', "calibration.height", "within_bounds 26.52 m"),
    ('rigid_depth = "0.85 m"', 'rigid_depth = "2.7 m"', "calibration.rigid_depth",
     "within_storeys 2.62 m"),
    ('rigid_above = "0.79 m"', 'rigid_above = "2.6 m"', "buildings[1].rigid_above",
     "of_buildings 2.62 m", "buildings[0].rigid_above"),
    ('rigid_below = "0.06 m"', 'rigid_below = "4.5 m"', "buildings[1].rigid_below",
     "of_buildings 3.26 m", "buildings[0].rigid_below"),
    ("", f"{LIGHT}{LIGHT}", "damping_cases[1].name",
     "duplicate"),
    *(
        ("", section, section.split()[0].strip("[]"), "missing_section")
        for section in (WALL, TRANSIENT)
    ),
    (GRID, '["2 Hz", "1 Hz"]', "spectra.frequencies", "ascending"),
    (GRID, '["2 Hz", 3]', "spectra.frequencies[1]", "unit_missing"),
    (GRID, "[]", "spectra.frequencies", "too_short"),
    (GRID, '"1 Hz"', "spectra.frequencies", "model_type"),
    ('damping = ["5 %"]', 'damping = ["5 %", 0.05]', "spectra.damping",
     "once"),
    ('damping = ["5 %"]', 'damping = ["5 %"]\nbroadening = 1', "spectra.broadening",
     "less_than 0"),
    ('damping = ["5 %"]', 'damping = ["5 %"]\nclipping = 1', "spectra.clipping",
     "bool_type"),
    ('damping = ["5 %"]', "damping = []", "spectra.damping", "too_short"),
    (GRID, '{ list = "rg1.122", minimum = "1 Hz" }', "spectra.frequencies.minimum", "begins"),
    (GRID, '{ list = "rg1.122", maximum = "34 Hz" }', "spectra.frequencies.maximum",
     "ordered 34 Hz"),
    (GRID, '{ maximum = "5 Hz", per_decade = 9 }', "spectra.frequencies.minimum",
     "begins"),
    (GRID, '{ minimum = "5 Hz", per_decade = 9 }', "spectra.frequencies.maximum",
     "ordered"),
    (GRID, "{ }", "spectra.frequencies.minimum", "begins 1.122"),
    (GRID, '{ minimum = "5 Hz", maximum = "4 Hz" }', "spectra.frequencies.maximum",
     "ordered 5 Hz"),
    (GRID, '{ minimum = "1 Hz", maximum = "100 Hz", per_decade = 50001 }',
     "spectra.frequencies.per_decade", "not_too_many 100000"),
    (GRID, '{ list = "rg1.122", frequency = "1 Hz" }', "spectra.frequencies.frequency",
     "extra_forbidden"),
]  # fmt: skip

# Of the law of the contacts; each row has all of it, or of a damped law what is beside HERTZ.
HERTZ = 'type = "hertz"\nstiffness = "2 N/m^1.5"\n'
CALIBRATED = 'type = "kelvin-voigt"\nstiffness = "calibrated"\nrestitution = "calibrated"\n'
DAMPED = ("hertz-damp", "hunt-crossley", "jankowski")
NAMES = " or ".join(f"'{name}'" for name in ("kelvin-voigt", "hertz", *DAMPED))
ONLY = "not_calibrated"
LAWS = [
    ('type = "hertz"\nstiffness = "1e11 N/m"', "stiffness",
     "unit"),
    ('type = "hertz"\nstiffness = "calibrated"', "stiffness", ONLY),
    ('type = "kelvin-voigt"\nstiffness = "2 N/m^1.5"\nrestitution = 0.6', "stiffness",
     "unit 1.5"),
    ('type = "hertz"', "stiffness", "missing"),
    (f"{HERTZ}restitution = 0.6", "restitution", "extra_forbidden"),
    (f"{HERTZ}damping_ratio = 0.1", "damping_ratio", "extra_forbidden"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = 0.6\nrelation = "exact"',
     "relation", "extra_forbidden"),
    ('type = "jankowski"\nstiffness = "2 N/m^1.5"\nrestitution = 0.6\nslowest_approach = "1 m/s"',
     "slowest_approach", "extra_forbidden"),
    ('type = "herz"\nstiffness = "2 N/m^1.5"', "type", "union_tag_invalid"),
    ('stiffness = "2 N/m^1.5"', "type", "union_tag_not_found"),
    ('type = "kelvin-voigt"\nstiffness = "calibratd"\nrestitution = 0.6', "stiffness",
     "quantity 1e11 N"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = "measured"', "restitution",
     "quantity 0.05"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = 1.2', "restitution",
     "less_than_equal 1"),
    (f"{CALIBRATED}damping_ratio = 0.1", "damping_ratio", "either",
     "contact_laws.floor.stiffness", "contact_laws.floor.restitution"),
    *(
        (f"{HERTZ.replace('hertz', name)}{more}", *fault)
        for name in DAMPED
        for more, *fault in (
            ("restitution = 1\ntension = true", "tension", "extra_forbidden"),
            ("restitution = 1\ndamping_ratio = 0", "damping_ratio", "extra_forbidden"),
            ('restitution = "calibrated"', "restitution", ONLY),
        )
    ),
    *(
        (f'type = "{name}"\nstiffness = "calibrated"\nrestitution = 0.6', "stiffness", ONLY)
        for name in DAMPED
    ),
    *(
        (f"{HERTZ.replace('hertz', name)}restitution = 0.6\nslowest_approach = \"0 m/s\"",
         "slowest_approach", "greater_than 0")
        for name in DAMPED[:2]
    ),
]  # fmt: skip

DAMPING_CASES = [
    ('"light"', '"own"', "name", "another_than_own"),
    ('"light"', '"light"\nfloors = 2', "floors", "extra_forbidden"),
    ('"light"', '"light"\nratio = 0.1\nfrequencies = ["1 Hz", "2 Hz"]', "mass_coefficient",
     "one_way"),
    ('mass_coefficient = "0.838 1/s"\n', "", "stiffness_coefficient", "together"),
]  # fmt: skip

ENSEMBLES = [
    ("", "motions = 1", "motions", "greater_than_equal 1"),
    ("", "motions = 5\nfirst_seed = -1", "first_seed", "greater_than_equal 0"),
    ("", "first_seed = 1", "records", "either"),
    ("", 'motions = 5\nrecords = "here"', "records", "either"),
    ("", 'records = "nowhere"', "records", "of_motions"),
    ("", 'records = "."', "records", "of_motions"),
    ("", "motion = 5", "motion", "extra_forbidden 'motions'"),
    ("", "motions = 5\nstructure_motions = 1", "structure_motions", "some"),
    ("", "motions = 5\nstructure_motions = 6", "structure_motions",
     "of_motions"),
    ("", "motions = 5\nstructure_motions = 3", "structure_motions",
     "of_motions"),
]  # fmt: skip

# Of a record in place of the motion: further keys.
RECORDS = [
    ("component = 0", "component", "text"),
    ('component = " "', "component", "text"),
    ('filter = ["40 Hz", "0.1 Hz"]', "filter", "ascending"),
    ('filter = ["1 Hz", "1 Hz"]', "filter", "ascending"),
    ('bandpass = ["1 Hz", "2 Hz"]', "bandpass", "extra_forbidden"),
    ("scale = 0", "scale", "not_zero"),
    ('scale = 2\npga = "1 m/s2"', "pga", "scale_or_pga"),
]

# Of the spectrum of the motion; each row has all of it.
SPECTRA = [
    (EC8.replace("ec8", "ec9"), "type",
     "union_tag_invalid"),
    (EC8.replace("spectrum_type = 1\n", ""), "spectrum_type",
     "missing"),
    (EC8 + "amplification = 2.5", "amplification",
     "extra_forbidden"),
    (EC8 + "importance_facto = 1", "importance_facto", "extra_forbidden 'importance_factor'"),
    (DECREE + 'text = "special"', "importance_factor",
     "missing"),
    (TABLE.replace("target", "none"), "file", "unreadable"),
    (TABLE + "damping = 0.05", "damping", "extra_forbidden"),
]  # fmt: skip

FORCES = [
    ("B1.floor_8", "B3.floor_8", "column B3.floor_8", "forces"),
    ("B1.floor_8", "B1.floor_9", "column B1.floor_9", "forces"),
    ("B1.floor_8 [MN]", "B1.floor_8", "line 1, column B1.floor_8", "forces"),
    ("[MN]", "[m]", "line 1, column B1.floor_8 [m]", "forces"),
    ("[ms]", "[N]", "line 1, column time [N]", "forces"),
    ("B1.floor_8", "roof", "line 1, column roof [MN]", "forces"),
    ("[kN]", "[kN] up", "line 1, column B2.floor_1 [kN] up", "forces"),
    ("5,2.5,-40", "5,x,-40", "line 3, column B1.floor_8 [MN]", "cell"),
    ("5,2.5,-40", "20,2.5,-40", "line 4, column time [ms]", "forces"),
    ("0,0,0\n5", "-1,0,0\n5", "line 2, column time [ms]", "forces 0 s"),
    ("\n5,2.5,-40\n20,0,0", "", "", "forces"),
]  # fmt: skip

DIRECTIONS = [
    ("blast.csv", "gone.csv", "loads[0].file", "unreadable"),
    ("[0, -2, 0]", "[0, 0, 0]", "loads[0].direction", "zero"),
    ("direction = [0, -2, 0]\n", "", "loads[0].direction", "missing"),
]  # fmt: skip

WALLS = [
    ('"-2 cm"', '"0 m"', "displacement", "moved"),
    ('"-2 cm"', '"1 cm"', "displacement", "outside_the_wall"),
    ('"-2 cm"', '"2 cm"', "displacement", "outside_the_wall 0.01 m"),
    ('"0.34 ms"', '"0.66 s"', "time_step", "step_within 1.3 s"),
    ('"0.34 ms"', '"0.34 ms"\nseparation = "2 s"', "separation", "seen_to_be_over 1.3 s"),
    ('"0.34 ms"', '"0.34 ms"\ncontact_spacing = "0 m"', "contact_spacing", "greater_than 0"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = []', "floors", "too_short"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = [8, 7, 8]', "floors", "once"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = [8, 9, 12]', "floors",
     "no_floor"),
    ('"0.34 ms"', '"0.34 ms"\ndisplaced_floor = 9', "displaced_floor", "no_floor"),
    ('"0.34 ms"', '"0.34 ms"\nside = "y+"', "side", "extra_forbidden"),
]  # fmt: skip

PLAIN = Base(structure=False)
HEADER, FILE = "[motions.spectrum]\n", 'file = "motion.csv"\n'
TABLES = [
    (PLAIN, None, "", SECTIONS),
    (PLAIN, None, "contact_laws.floor.", [(LAW, f"{law}\n", *row) for law, *row in LAWS]),
    (Base(LIGHT, structure=False), None, "damping_cases[0].", DAMPING_CASES),
    (Base("\n[ensemble]\n", structure=False), None, "ensemble.", ENSEMBLES),
    (Base(LOADS, BLAST, structure=False), "blast.csv", "", FORCES),
    (Base(LOADS, BLAST, structure=False), None, "", DIRECTIONS),
    (RECORDED, None, "motions[0].", [(FILE, FILE + keys, *row) for keys, *row in RECORDS]),
    (
        with_spectrum(""),
        None,
        "motions[0].spectrum.",
        [(HEADER, HEADER + keys, *row) for keys, *row in SPECTRA],
    ),
    (Base(WALL), None, "wall_impact.", WALLS),
]


@each_row(TABLES)
def test_refused(written, base, file, key, row):
    check_row(written, base, file, key, row)


def test_storeys_of_a_few_millimetres_are_the_fault_of_their_table(broken):
    """And not of rigid zones that go with storeys as they are."""
    columns = "storey_height [m],storey_height_min [m],storey_height_max [m]"
    path = broken(("pair_floors.csv", columns, columns.replace("[m]", "[mm]")))
    found = own_faults(path)
    for k in (0, 1):
        assert not {f"buildings[{k}].rigid_below", f"buildings[{k}].rigid_above"} & {*found}
        assert found[f"buildings[{k}].floors"] == (
            "pair_floors.csv the storey below floor 1 is 0.00326 m high by the floor table; "
            "expected more than its rigid zones together, rigid_below, 0.06 m"
        )
