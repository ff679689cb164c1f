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
    ('gap = "1 cm"', "gap = 0.01", "contacts[0].gap", "expected a length with its unit"),
    ('gap = "1 cm"', 'gap = "-1 cm"', "contacts[0].gap", "expected a length of at least 0"),
    ('gap = "1 cm"', "gap = 2020-01-01", "contacts[0].gap", "expected a length"),
    ('gap = "1 cm"', "", "contacts[0].gap", "missing; expected a length with its unit"),
    ('young_modulus = "33 GPa"', 'young_modulus = "0 GPa"', "materials.concrete.young_modulus",
     "expected a stress above 0"),
    ("poisson_ratio = 0.2", "poisson_ratio = 0.5", "materials.concrete.poisson_ratio",
     "expected a number of at least 0 and below 0.5"),
    ("[0.02, 1.0]", "[0.02, inf]", "calibration.stiffness_factor[1]", "expected a number above 0"),
    ('gap = "1 cm"', 'gapp = "1 cm"', "contacts[0].gapp", "unknown key; did you mean 'gap'?",
     "contacts[0].gap"),
    ("[damping]", "[dampin]", "dampin", "unknown key; did you mean 'damping'?", "damping"),
    ("[damping]", "[dampin]", "damping", "missing; expected a table", "dampin"),
    ("[[buildings]]", "[[building]]", "buildings", "missing; expected one or more tables",
     "building"),
    ("starts = 40", "startz = 40", "calibration.startz", "did you mean 'starts'?"),
    ("amplification = 2.5", "zz = 2.5", "motions[0].spectrum.zz", "unknown key; known: ground_acc"),
    ('time_step = "0.3358 ms"', "", "pounding.time_step", "missing; expected a time"),
    ("title = ", "title = 1 #", "title", "expected a text in quotes"),
    ('title = "Two', 'title = "" # "Two', "title", "expected a text in quotes"),
    ('name = "B1"', 'name = "B 1"', "buildings[0].name", "expected a name of letters",
     "contacts[0].a.building", *(f"line {k}, column building" for k in (3, 4, 5))),
    ("seed = 1\n", "seed = 1.5\n", "motions[0].seed", "expected a whole number of at least 0"),
    ("tension = true", 'tension = "yes"', "contact_laws.floor.tension", "expected true or false"),
    ("[materials.concrete]", "[materials]", "materials.young_modulus", "expected a table",
     *(f"materials.{key}" for key in ("poisson_ratio", "density", "compressive_strength")),
     "buildings[0].material", "buildings[1].material"),
    ("[[contacts]]", "[contacts]", "contacts", "expected one or more tables, [[contacts]], not"),
    ("[pounding]", "[[pounding]]", "pounding", "expected a table"),
    ('axis = ["23.1 m", "7.8 m"]', 'axis = ["23.1 m"]', "buildings[0].axis",
     "expected a list of 2 values, each a length with its unit"),
    ('axis = ["23.1 m", "7.8 m"]', 'axis = "23.1 m"', "buildings[0].axis", "a list of 2 values"),
    ("[0, 1, 0]", "[0, 1, 0, 0]", "contacts[0].normal", "a list of 3 values, each a number"),
    ("[0, 1, 0]", "[0, 0, 0]", "contacts[0].normal", "expected a vector that is not zero"),
    ("[0, 1, 0]", '["x", 1, 0]', "contacts[0].normal[0]", "expected a number"),
    ('"implicit"', '"implicitly"', "pounding.update", "expected 'implicit' or 'lagged'"),
    ('direction = "y"\ntype', 'direction = "Y"\ntype', "motions[0].direction", "'x' or 'y' or 'z'"),
    ('type = "synthetic"', 'type = "synth"', "motions[0].type", "'synthetic' or 'record'"),
    ('type = "synthetic"', "", "motions[0].type", "missing; expected 'synthetic' or 'record'"),
    ('type = "kelvin-voigt"', 'type = "herz"', "contact_laws.floor.type", "'hertz' or 'hertz-d"),
    ('type = "kelvin-voigt"', "", "contact_laws.floor.type", "missing; expected 'kelvin-voigt'"),
    ('law = "floor"', 'law = "flor"', "contacts[0].law",
     "unknown contact law; did you mean 'floor'?"),
    ("[contact_laws.floor]", "[contact_laws.wall]", "contacts[0].law", "known: wall"),
    ('material = "concrete"', 'material = "concret"', "buildings[1].material",
     "unknown material; did you mean 'concrete'?", "buildings[0].material"),
    ('{ building = "B1"', '{ building = "B3"', "contacts[0].a.building", "unknown building"),
    ('name = "B2"', 'name = "B1"', "buildings[1].name",
     "duplicate name, the first is buildings[0].name"),
    ('name = "B2"', 'name = "b1"', "buildings[1].name",
     "duplicate name, upper and lower case alike, the first is buildings[0].name"),
    (FLOORS_A, '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 9]', "contacts[0].a.floor",
     "B1 has no floor 9; its floors are 1, 2, 3, 4, 5, 6, 7, 8"),
    (FLOORS_A, '{ building = "B1", storey = 9, relative_height = 0.5', "contacts[0].a.storey",
     "B1 has no floor 9"),
    (FLOORS_A, '{ building = "B1", floor = [1, 2]', "contacts[0].b",
     "expected lists of the same length in a and b, found 2 and 8"),
    (FLOORS_A, '{ building = "B1"', "contacts[0].a.storey", "expected either floor, or storey"),
    (FLOORS_A, f"{FLOORS_A}, storey = 1, relative_height = 0.5", "contacts[0].a.storey",
     "expected either floor, or storey with relative_height, not both"),
    (FLOORS_A, '{ building = "B1", storey = 1', "contacts[0].a.relative_height",
     "expected a number between 0 and 1 beside storey"),
    (FLOORS_A, f"{FLOORS_A}, relative_height = 0.5", "contacts[0].a.relative_height",
     "expected no relative_height beside floor"),
    *(
        (FLOORS_A, f'{{ building = "B1", storey = 1, relative_height = {s}',
         "contacts[0].a.relative_height", "a number above 0 and below 1")
        for s in ("-0.1", "0.0", "1.0", "1.5", '"0 %"')
    ),
    (FLOORS_B, '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 8]', "contacts[0].b",
     "expected another building than 'B1'"),
    ("b = { build", 'wall = "pit"\nb = { build', "contacts[0].wall", "either b or wall, not both"),
    ("b = { build", "# { build", "contacts[0].wall", "missing; expected either b, the point on"),
    ("b = { build", 'wall = "B2" # { build', "contacts[0].wall", "a name that no building has"),
    ("b = { build", 'wall = "a b" # { build', "contacts[0].wall", "expected a name of letters"),
    ("[pounding]", f"{TWICE}[pounding]", "contacts", "found B1.floor_8 and B2.floor_8 twice"),
    ("[pounding]", f"{SWAPPED}[pounding]", "contacts", "found B2.floor_8 and B1.floor_8 twice"),
    (FLOORS, f'floors = "none.csv"\n{AXIS}', "buildings[0].floors", "no such file"),
    (FLOORS, f'floors = "."\n{AXIS}', "buildings[0].floors", "this is a directory"),
    (FLOORS, f"floors = 3\n{AXIS}", "buildings[0].floors", "expected a file name in quotes"),
    ('"pair_targets.csv"', '"none.csv"', "calibration.targets", "no such file"),
    ('"pair_published.csv"', '"none.csv"', "published", "no such file"),
    ('frequencies = ["1 Hz", "20 Hz"]', "", "damping.frequencies",
     "expected ratio and frequencies together"),
    ('ratio = "7 %"', 'ratio = "7 %"\nmass_coefficient = "1 1/s"', "damping.mass_coefficient",
     "not both"),
    ('["1 Hz", "20 Hz"]', '["20 Hz", "1 Hz"]', "damping.frequencies", "the lower one first"),
    ('ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]\n', "", "damping.stiffness_coefficient",
     "expected ratio and frequencies, or mass_coefficient and"),
    ('damping_ratio = "12 %"', 'damping_ratio = "12 %"\nrestitution = 0.7',
     "contact_laws.floor.damping_ratio", "not both"),
    ('damping_ratio = "12 %"', "", "contact_laws.floor.damping_ratio", "missing; expected either"),
    ('"0.05 s", "0.25 s"', '"0.25 s", "0.05 s"', "motions[0].spectrum.corner_periods",
     "expected increasing corner periods"),
    ('["2 s", "5 s"]', '["5 s", "2 s"]', "motions[0].strong_phase", "the begin"),
    ('["2 s", "5 s"]', '["2 s", "50 s"]', "motions[0].strong_phase",
     "expected a phase within the duration, 16.79 s"),
    ('["2 s", "5 s"]', '["2 s", "2.155 s"]', "motions[0].strong_phase",
     "expected at least 32 time steps, 0.16 s"),
    ("amplification = 2.5", "amplification = 0.9", "motions[0].spectrum.amplification",
     "expected a number of at least 1"),
    ('time_step = "5 ms"', 'time_step = "50 s"', "motions[0].time_step", "below the duration"),
    ('"0.3358 ms"', '"335.8 s"', "pounding.time_step", "below the duration, 16.79 s"),
    ("[0.02, 1.0]", "[1.0, 0.02]", "calibration.stiffness_factor", "bounds in order"),
    ('height = "30.3 m"', 'height = "40 m"', "calibration.height", "26.52 m to 35.22 m"),
    ('rigid_depth = "0.85 m"', 'rigid_depth = "2.7 m"', "calibration.rigid_depth",
     "the storey below floor 2 of B1 may become 2.62 m high"),
    ('rigid_above = "0.79 m"', 'rigid_above = "2.6 m"', "buildings[1].rigid_above",
     "2.62 m high by the floor table; expected rigid zones together of less, not rigid_below, 0.06 "
     "m, and rigid_above, 2.6 m", "buildings[0].rigid_above"),
    ('rigid_below = "0.06 m"', 'rigid_below = "4.5 m"', "buildings[1].rigid_below",
     "the storey below floor 1 is 3.26 m high by the floor table; expected rigid zones together "
     "of less, not rigid_below, 4.5 m", "buildings[0].rigid_below"),
    ("", f"{LIGHT}{LIGHT}", "damping_cases[1].name",
     "light duplicate name, the first is damping_cases[0].name"),
    *(
        ("", section, section.split()[0].strip("[]"), "expected a [buildings.structure] beside it")
        for section in (WALL, TRANSIENT)
    ),
    (GRID, '["2 Hz", "1 Hz"]', "spectra.frequencies", "expected increasing frequencies"),
    (GRID, '["2 Hz", 3]', "spectra.frequencies[1]", "the unit is missing; expected a frequency"),
    (GRID, "[]", "spectra.frequencies", "expected a list that is not empty"),
    (GRID, '"1 Hz"', "spectra.frequencies", "expected a table or a list, each value a frequency"),
    ('damping = ["5 %"]', 'damping = ["5 %", 0.05]', "spectra.damping",
     "expected each damping ratio once"),
    ('damping = ["5 %"]', 'damping = ["5 %"]\nbroadening = 1', "spectra.broadening",
     "expected a number of at least 0 and below 1"),
    ('damping = ["5 %"]', 'damping = ["5 %"]\nclipping = 1', "spectra.clipping",
     "expected true or false"),
    ('damping = ["5 %"]', "damping = []", "spectra.damping", "expected a list that is not empty"),
    (GRID, '{ list = "rg1.122", minimum = "1 Hz" }', "spectra.frequencies.minimum", "has its own"),
    (GRID, '{ list = "rg1.122", maximum = "34 Hz" }', "spectra.frequencies.maximum",
     "above the 34 Hz"),
    (GRID, '{ maximum = "5 Hz", per_decade = 9 }', "spectra.frequencies.minimum",
     "missing; expected a frequency"),
    (GRID, '{ minimum = "5 Hz", per_decade = 9 }', "spectra.frequencies.maximum",
     "missing; expected a frequency"),
    (GRID, "{ }", "spectra.frequencies.minimum", "or list = 'rg1.122'"),
    (GRID, '{ minimum = "5 Hz", maximum = "4 Hz" }', "spectra.frequencies.maximum",
     "above minimum, 5 Hz"),
    (GRID, '{ minimum = "1 Hz", maximum = "100 Hz", per_decade = 50001 }',
     "spectra.frequencies.per_decade", "at most 100000 frequencies"),
    (GRID, '{ list = "rg1.122", frequency = "1 Hz" }', "spectra.frequencies.frequency",
     "unknown key"),
]  # fmt: skip

# Of the law of the contacts; each row has all of it, or of a damped law what is beside HERTZ.
HERTZ = 'type = "hertz"\nstiffness = "2 N/m^1.5"\n'
CALIBRATED = 'type = "kelvin-voigt"\nstiffness = "calibrated"\nrestitution = "calibrated"\n'
DAMPED = ("hertz-damp", "hunt-crossley", "jankowski")
NAMES = " or ".join(f"'{name}'" for name in ("kelvin-voigt", "hertz", *DAMPED))
ONLY = "only a law of type 'kelvin-voigt' is calibrated"
LAWS = [
    ('type = "hertz"\nstiffness = "1e11 N/m"', "stiffness",
     "'N/m' is a stiffness; expected a stiffness of Hertz contact"),
    ('type = "hertz"\nstiffness = "calibrated"', "stiffness", ONLY),
    ('type = "kelvin-voigt"\nstiffness = "2 N/m^1.5"\nrestitution = 0.6', "stiffness",
     "'N/m^1.5' is a stiffness of Hertz contact; expected a stiffness"),
    ('type = "hertz"', "stiffness", "missing; expected a stiffness of Hertz contact"),
    (f"{HERTZ}restitution = 0.6", "restitution", "unknown key; known: type, stiffness"),
    (f"{HERTZ}damping_ratio = 0.1", "damping_ratio", "unknown key"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = 0.6\nrelation = "exact"',
     "relation", "unknown key"),
    ('type = "jankowski"\nstiffness = "2 N/m^1.5"\nrestitution = 0.6\nslowest_approach = "1 m/s"',
     "slowest_approach", "unknown key"),
    ('type = "herz"\nstiffness = "2 N/m^1.5"', "type", f"expected {NAMES}"),
    ('stiffness = "2 N/m^1.5"', "type", f"missing; expected {NAMES}"),
    ('type = "kelvin-voigt"\nstiffness = "calibratd"\nrestitution = 0.6', "stiffness",
     "expected a stiffness with its unit, for example '1e11 N/m'; or 'calibrated'"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = "measured"', "restitution",
     "expected a number above 0 and at most 1, bare or as a percentage: 0.05 or '5 %'; or "
     "'calibrated'"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = 1.2', "restitution", "at most 1"),
    (f"{CALIBRATED}damping_ratio = 0.1", "damping_ratio", "not both",
     "contact_laws.floor.stiffness", "contact_laws.floor.restitution"),
    *(
        (f"{HERTZ.replace('hertz', name)}{more}", *fault)
        for name in DAMPED
        for more, *fault in (
            ("restitution = 1\ntension = true", "tension", "unknown key"),
            ("restitution = 1\ndamping_ratio = 0", "damping_ratio", "unknown key"),
            ('restitution = "calibrated"', "restitution", ONLY),
        )
    ),
    *(
        (f'type = "{name}"\nstiffness = "calibrated"\nrestitution = 0.6', "stiffness", ONLY)
        for name in DAMPED
    ),
    *(
        (f"{HERTZ.replace('hertz', name)}restitution = 0.6\nslowest_approach = \"0 m/s\"",
         "slowest_approach", "expected a velocity above 0")
        for name in DAMPED[:2]
    ),
]  # fmt: skip

DAMPING_CASES = [
    ('"light"', '"own"', "name", "own expected another name"),
    ('"light"', '"light"\nfloors = 2', "floors", "unknown key"),
    ('"light"', '"light"\nratio = 0.1\nfrequencies = ["1 Hz", "2 Hz"]', "mass_coefficient",
     "not both"),
    ('mass_coefficient = "0.838 1/s"\n', "", "stiffness_coefficient", "together"),
]  # fmt: skip

ENSEMBLES = [
    ("", "motions = 1", "motions", "1 expected"),
    ("", "motions = 5\nfirst_seed = -1", "first_seed", "-1 expected"),
    ("", "first_seed = 1", "records", "expected either motions or records"),
    ("", 'motions = 5\nrecords = "here"', "records", "expected either motions or records"),
    ("", 'records = "nowhere"', "records", "a folder of records; there is none"),
    ("", 'records = "."', "records", "a case with one motion of type 'record'"),
    ("", "motion = 5", "motion", "did you mean 'motions'?", "ensemble.records"),
    ("", "motions = 5\nstructure_motions = 1", "structure_motions", "1 expected 0, or at least 2"),
    ("", "motions = 5\nstructure_motions = 6", "structure_motions",
     "expected at most all members, 5"),
    ("", "motions = 5\nstructure_motions = 3", "structure_motions",
     "expected 0, or a section [transient]"),
]  # fmt: skip

# Of a record in place of the motion: further keys.
RECORDS = [
    ("component = 0", "component", "expected the name of a component in quotes, or its number"),
    ('component = " "', "component", "expected the name of a component"),
    ('filter = ["40 Hz", "0.1 Hz"]', "filter", "the low corner frequency before the high"),
    ('filter = ["1 Hz", "1 Hz"]', "filter", "the low corner frequency before the high"),
    ('bandpass = ["1 Hz", "2 Hz"]', "bandpass", "unknown key"),
    ("scale = 0", "scale", "expected a factor that is not 0"),
    ('scale = 2\npga = "1 m/s2"', "pga", "expected either scale or pga, not both"),
]

# Of the spectrum of the motion; each row has all of it.
SPECTRA = [
    (EC8.replace("ec8", "ec9"), "type",
     "expected 'corner-periods' or 'ec8' or 'french-decree' or 'table'"),
    (EC8.replace("spectrum_type = 1\n", ""), "spectrum_type",
     "missing; expected a whole number of at least 1 and at most 2: Type of spectrum"),
    (EC8 + "amplification = 2.5", "amplification",
     "unknown key; known: type, spectrum_type, ground, reference_acceleration"),
    (EC8 + "importance_facto = 1", "importance_facto", "did you mean 'importance_factor'?"),
    (DECREE + 'text = "special"', "importance_factor",
     "missing; expected the acceleration of the special-risk text over the zone's a_gr"),
    (TABLE.replace("target", "none"), "file", "no such file; expected a table of a design"),
    (TABLE + "damping = 0.05", "damping", "unknown key; known: type, file"),
]  # fmt: skip

FORCES = [
    ("B1.floor_8", "B3.floor_8", "column B3.floor_8", "expected a building of the case"),
    ("B1.floor_8", "B1.floor_9", "column B1.floor_9", "B1 has no floor 9; its floors are 1"),
    ("B1.floor_8 [MN]", "B1.floor_8", "line 1, column B1.floor_8", "no unit"),
    ("[MN]", "[m]", "line 1, column B1.floor_8 [m]", "is a length"),
    ("[ms]", "[N]", "line 1, column time [N]", "is a force"),
    ("B1.floor_8", "roof", "line 1, column roof [MN]", "expected '<building>.floor_<k> [N]'"),
    ("[kN]", "[kN] up", "line 1, column B2.floor_1 [kN] up", "or 'time [s]'"),
    ("5,2.5,-40", "5,x,-40", "line 3, column B1.floor_8 [MN]", "a finite number"),
    ("5,2.5,-40", "20,2.5,-40", "line 4, column time [ms]", "times that increase"),
    ("0,0,0\n5", "-1,0,0\n5", "line 2, column time [ms]", "from 0 s or later"),
    ("\n5,2.5,-40\n20,0,0", "", "", "at least two lines"),
]  # fmt: skip

DIRECTIONS = [
    ("blast.csv", "gone.csv", "loads[0].file", "no such file"),
    ("[0, -2, 0]", "[0, 0, 0]", "loads[0].direction", "a vector that is not zero"),
    ("direction = [0, -2, 0]\n", "", "loads[0].direction", "missing"),
]  # fmt: skip

WALLS = [
    ('"-2 cm"', '"0 m"', "displacement", "0 m expected a displacement that is not zero"),
    ('"-2 cm"', '"1 cm"', "displacement", "1 cm the wall would start inside the building"),
    ('"-2 cm"', '"2 cm"', "displacement", "expected less than the gap, 0.01 m"),
    ('"0.34 ms"', '"0.66 s"', "time_step", "0.66 s expected at most half of the duration, 1.3 s"),
    ('"0.34 ms"', '"0.34 ms"\nseparation = "2 s"', "separation", "2 s expected less than the dur"),
    ('"0.34 ms"', '"0.34 ms"\ncontact_spacing = "0 m"', "contact_spacing", "above 0"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = []', "floors", "the list is empty"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = [8, 7, 8]', "floors", "each floor once, found 8 again"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = [8, 9, 12]', "floors",
     "[8, 9, 12] B1 has no floor 9, 12; its floors are 1, 2, 3, 4, 5, 6, 7, 8"),
    ('"0.34 ms"', '"0.34 ms"\ndisplaced_floor = 9', "displaced_floor", "9 B1 has no floor 9"),
    ('"0.34 ms"', '"0.34 ms"\nside = "y+"', "side", "unknown key"),
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
