"""What a case file refuses of 3D models, their response in time, and devices."""

from .faults import check_row, each_row
from .sections import (
    ANALYSIS,
    BEAM,
    CABINET,
    EVERY_KEY,
    FROM_FILE,
    FULL_ORDER,
    GROUP,
    LINE,
    MODES,
    OTHERS,
    PART_DAMPING,
    PARTS,
    PIPE,
    PIPE_FILES,
    POINT,
    PUMP,
    TRANSIENT,
    Base,
)

FACTOR = "storey_stiffness_factor = 0.13"
STRUCTURES = [
    ('"1.80 Hz", direction = "y"', '"1 Hz"', "calibration.direction", "missing"),
    (FACTOR, 'material = "concret"', "material", "did you mean 'concrete'?"),
    (FACTOR, "dampings = 1", "dampings", "unknown key"),
    ('"pair_walls.csv"', '"none.csv"', "mesh.walls", "no such file; expected a wall table"),
    ('"pair_bays.csv"', '"none.csv"', "mesh.bays", "no such file; expected a bay table"),
    ('"pair_beams.csv"', '"none.csv"', "mesh.beams", "no such file; expected a beam table"),
    ('"pair_columns.csv"', '"none.csv"', "mesh.columns", "expected a column table"),
    *(
        ('size = "0.9 m"', f'size = "0.9 m"\n{line}', f"mesh.{key}", words)
        for line, key, words in (
            ('slabs = [{ floors = 9, thickness = "1 m" }]', "slabs", "floors of the building"),
            ('slabs = [{ floors = [2, 2], thickness = "1 m" }]', "slabs", "found 2 twice"),
            ('wall_setback = ["0 m", "7.8 m"]', "wall_setback", "less than half of the plan's 15"),
            ('wall_setback = ["0 m", "0.4 m"]', "openings", "bay 1 of gable, storey 2: the bay"),
            ('openings = [{ walls = "g*", storeys = 2, width = 1.5 }]', "openings", "-0.475 m to"),
            ('openings = [{ walls = "g*", storeys = 3, width = 1 }]', "openings", "no bay of st"),
            ('openings = [{ walls = "s*", storeys = 5, width = 0 }]', "openings[0].width", "above"),
        )
    ),
    *(
        (FACTOR, f"{more}added_mass = [{{ {row} }}]", f"added_mass{key}", words)
        for more, row, key, words in (
            ("", 'floors = 9, across = "y", strip = "1 m"', "", "floors of the building, 1, 2"),
            ("", 'floors = [1, 1], across = "y", strip = "1 m"', "", "found 1 twice"),
            ("", 'floors = 1, across = "z", strip = "1 m"', "[0].across", "'x' or 'y'"),
            ("floor_masses = false\n", 'floors = 1, across = "y", strip = "1 m"', "", "no mass is"),
            ("", 'floors = 1, across = "y", edges = 0.6, middle = 0.5, strip = "1 m"',
             "[0].middle", "at most 0.4: both parts"),
        )
    ),
]  # fmt: skip

MESH_FILES = [
    ('"pair.msh"', '"none.msh"', "file",
     "no such file; expected a mesh of gmsh"),
    ('"storey_*"', '"floor_*"', "shells", "'floor_*' twice"),
    ('type = "file"', "", "type",
     "missing; expected 'generated' or 'file'"),
    ('file = "pair.msh"', 'walls = "pair_walls.csv"', "walls",
     "unknown key",
     "buildings[1].structure.mesh.file"),
]  # fmt: skip

MATERIALS = [
    ('material = "masonry"', 'material = "stone"', "material", "concrete"),
    ('density = "1800 kg/m3"\n', "", "material", "a material with a density"),
    ('parts = ["storey_*", "column_1_*"]', "parts = []", "parts", "a list that is not empty"),
    ('material = "masonry"\n', "", "material", "missing"),
]  # fmt: skip

DAMPINGS = [
    ('parts = ["beam_*"]', "parts = []", "damping[1].parts", "expected"),
    ('parts = ["beam_*"]\n', "", "damping[1].parts", "expected"),
    ('ratio = "2 %"', 'ratio = "120 %"', "damping[0].ratio", "expected"),
    ('coefficient = "1 ms"', 'coefficient = "1 m"', "damping[1].stiffness_coefficient", "expected"),
    ('parts = ["beam_*"]', 'part = ["beam_*"]', "damping[1].part", "unknown key",
     "buildings[1].structure.damping[1].parts"),
]  # fmt: skip

SOUTH = "south,1-8,0,0,46.2,0,60"
GABLE = "gable,2,0,0,0,15.6,60"
WINDOW = "1,gable,2,2,2.05,3.3,57e-2"
ALONG = "along,1-8,0,7.8,46.2,7.8"
COLUMN = "row_1,2-8,5.775,7.8,0.8,1.2"
OF_WALLS = [
    ("gable,2", "south,2", "line 4, column wall", "duplicate wall, the first is in line 2"),
    (GABLE, "gable,2,0,0,0,0,60", "line 4, column y2 [m]", "expected an end (x2, y2) away"),
    (GABLE, "gable,2,0,0,0,15.7,60", "line 4, column y2 [m]",
     "expected a wall within the plan: 0 m to its width, 15.6 m"),
    (GABLE, "gable,2,-1,0,0,15.6,60", "line 4, column x1 [m]", "0 m to its length, 46.2 m"),
    (SOUTH, "south,1-9,0,0,46.2,0,60", "line 2, column storeys",
     "1-9 the building has the storeys 1, 2, 3, 4, 5, 6, 7, 8, not 9"),
    (SOUTH, "south,1 3-5 10-12,0,0,46.2,0,60", "line 2, column storeys",
     "1 3-5 10-12 the building has the storeys 1, 2, 3, 4, 5, 6, 7, 8, not 10, 11, 12"),
    (GABLE, "gable,3-2,0,0,0,15.6,60", "line 4, column storeys", "expected numbers of stor"),
    (GABLE, "gable,2,46.2,0,40,0,60", "line 4, column wall", "lies on south of line 2 in"),
    (GABLE, "gable,2,10,0,20,0,60", "line 4, column wall", "in storey 2; expected a place"),
]  # fmt: skip

OF_BAYS = [
    (WINDOW, "1,gabel,2,2,1,1,1", "line 4, column wall", "did you mean 'gable'?"),
    (WINDOW, "1,gable,3,2,1,1,1", "line 4, column storey",
     "expected a storey of gable, which stands in 2"),
    (WINDOW, "1,gable,2,0.4,1,1,1", "line 4, column centre [m]",
     "the bay goes from -0.1 m to 0.9 m along gable; expected 0 m to 15.6 m at most"),
    (WINDOW, "1,gable,2,15.2,1,1,1", "line 4, column centre [m]", "to 15.7 m along gable"),
    (WINDOW, "1,gable,2,7.8,1,16,1", "line 4, column width [m]", "expected 0 m to 15.6 m"),
    (WINDOW, "1,gable,2,2,1.63,1,1", "line 4, column sill [m]",
     "the bay goes up to 2.63 m; expected at most the height of storey 2, 2.62 m"),
    (WINDOW, "1,gable,2,2,0,1,3", "line 4, column height [m]", "storey 2, 2.62 m"),
    (WINDOW, "1,gable,2,7.8,0,15.6,2.62", "line 4, column bay",
     "nothing is left of gable in storey 2"),
    ("6,south,5,10,2.7", "6,south,5,10,2.6", "line 3, column centre [m]",
     "bay 6 overlaps bay 6 of line 2 in south, storey 5"),
    ("6,south,5,10,2.7", "7,south,5,10,0", "line 3, column centre [m]", "bay 7 overlaps"),
]  # fmt: skip

OF_BEAMS = [
    ("along", "row_1", "line 3, column beam", "duplicate beam"),
    (ALONG, "along,1-8,0,16,46.2,7.8", "line 3, column y1 [m]", "a beam within the plan"),
    (ALONG, "along,8-10,0,7.8,46.2,7.8", "line 3, column floors", "has the floors 1, 2"),
    (ALONG, "along,8,5.775,7,5.775,8", "line 3, column beam", "lies on row_1 of line"),
]  # fmt: skip

OF_COLUMNS = [
    (COLUMN, "row_1,2,50,7.8,1,1", "line 2, column x [m]", "a column within the plan"),
    (COLUMN, "row_1,9,5,7.8,1,1", "line 2, column storeys", "has the storeys 1, 2"),
    (COLUMN, f"{COLUMN}\nrow_2{COLUMN[5:]}", "line 3, column column", "lies on row_1 of"),
    (COLUMN, f"{COLUMN}\nrow_1,1,9,9,1,1", "line 3, column column", "duplicate column"),
]  # fmt: skip

TRANSIENTS = [
    ('"10 s"', '"0 s"', "duration", "expected a time above 0"),
    ('"1 ms"', '"5.001 s"', "time_step", "expected at most half of the duration, 10 s"),
    ("[8, 6, 7]", "[8, 6, 8]", "floors", "expected each floor once"),
    ("[8, 6, 7]", "[8, 9, 12]", "floors", "no floor 9, 12 in B1; expected some of [1, 2, 3"),
    ('"-2 m"', '"-23.2 m"', "eccentricity", "within the edge, 23.1 m to either side"),
    ('["psa"]', '["psa", "psa"]', "fields", "expected each map once"),
    ('"20 Hz"]', '"10 Hz"]', "field_frequencies", "expected increasing frequencies"),
    ('["10 Hz", "20 Hz"]', "[]", "field_frequencies", "at least one frequency, or fields"),
    ('"both"', '"full"', "export", "solver 'reduced' or 'both': 'full' records its probes"),
    ('"1 s"', '"10 s"', "export_start", "expected less than what is computed, 10 s"),
    ('"5 ms"', '"0.5 ms"', "export_step", "expected at least the time step, 0.001 s"),
    ('shift = "50 Hz"', 'shft = "50 Hz"', "shft", "unknown key; did you mean 'shift'?"),
]  # fmt: skip

OF_POINT = [
    ('point = ["0 m", "15.6 m", "3030 cm"]\n', "", "group",
     "missing; expected one of point, or from with to and count, or group"),
    ('name = "corner"', 'name = "corner"\ngroup = "edge_8"', "group", "expected one way only"),
    ('name = "corner"', 'name = "corner"\ncount = 3', "count",
     "expected no count, only beside from and to"),
    ('"15.6 m"', '"80 m"', "point", "a point of the building, which has x of 0"),
    ('"3030 cm"', '"-2 m"', "point", "z of 0 to 30"),
]  # fmt: skip

OF_LINE = [
    ('name = "row"', 'name = "row"\npoint = ["0 m", "0 m", "0 m"]', "from",
     "expected one way only"),
    ('name = "row"', 'name = "row"\ngroup = "edge_8"', "group", "expected one way only"),
    ('from = ["0 m", "1 m", "3 m"]\n', "", "to", "expected from and to together"),
    ('to = ["8 m", "1 m", "7 m"]\n', "", "to", "expected from and to together"),
    ("from", "start", "start", "unknown key; known: name, building, point",
     "transient.probes[0].to"),
    ("from", "frm", "frm", "unknown key; did you mean 'from'?", "transient.probes[0].to"),
    ('["8 m", "1 m", "7 m"]', '["0 m", "100 cm", "3 m"]', "to", "another point"),
    ("count = 5\n", "", "count", "missing; expected a whole number of at least 2"),
    ('["8 m", "1 m", "7 m"]', '["80 m", "1 m", "7 m"]', "to", "a point of the building"),
]  # fmt: skip

OF_GROUP = [
    ("edge_8", "edge_9", "group", "expected a number of 1 to 8, the floors of the"),
    ("edge_8", "floor_10_parapet", "group", "expected a number of 1 to 8"),
]  # fmt: skip

PLACE = 'offset = ["0 m", "7.8 m", "0 m"]'
NORMAL = "normal = [0, 1, 0]"
CONTACTS = [
    (NORMAL, "normal = [1, 0, 0]", "contacts[0].a.offset",
     "the normal leads through: x- from (0, 0) to (0, 15.6) m, x+ from (46.2, 0)"),
    (NORMAL, "normal = [0, -1, 0]", "contacts[0].a.offset",
     "expected a point on the side of the floor of the 3D building that the normal leads",
     "contacts[0].normal"),
    (NORMAL, "normal = [0, 1, 1]", "contacts[0].normal", "expected a horizontal normal"),
    (PLACE, PLACE.replace('"0 m", "7', '"-25 m", "7'), "contacts[0].a.offset",
     "y+ from (0, 15.6) to (46.2, 15.6) m"),
    (PLACE, 'offset = ["0 m", "7.8 m", "-0.5 m"]', "contacts[0].a.offset",
     "this pair is 0.5 m below the floor's mass centre; expected at most 0.1 m"),
    ("", f"{PUMP}{PUMP}", "devices[1].name",
     "pump duplicate name, the first is devices[0].name"),
]  # fmt: skip

PUMPS = [
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
]  # fmt: skip

BEAMS = [
    ('length = "46 cm"', 'length = "0 cm"', "length", "a length above 0"),
    ('["80 MN m2", "60 MN m2"]', '"rigid"', "bending", "or a list of two of them"),
    ('["80 MN m2", "60 MN m2"]', '["80 MN m2"]', "bending", "or a list of two of them"),
]  # fmt: skip

BESIDE_MODES = [
    ("pair_modes.csv", "none.csv", "modes", "no such file; expected a table of modes (CSV)"),
    ("",
     'stiffness = { x = "1 N/m", y = "1 N/m", z = "1 N/m", rx = "rigid", ry = "rigid", rz = '
     '"rigid" }', "stiffness", "expected nothing here beside modes"),
    ("", 'beam = { length = "1 m", bending = "1 N m2" }', "beam",
     "expected nothing here beside modes"),
    ("", 'mass = "400 kg"', "mass_height", "mass and mass_height together", "devices[0].shape"),
    ("", 'mass_height = "1 m"', "mass_height", "mass and mass_height together"),
    ("", 'inertia = ["1 kg m2", "1 kg m2", "1 kg m2"]', "inertia", "a mass beside it"),
    ("", 'shape = { type = "cylinder", radius = "1 m", length = "1 m" }', "shape",
     "a mass beside it"),
]  # fmt: skip

MODE_ROWS = [
    ("8,y", "8,u", "line 3, column direction", "expected 'x', 'y', 'z', 'rx'"),
    ("8,y,300", "8,y,0", "line 3, column direction", "effective_mass above 0"),
    ("8,y,300", "8,rx,300", "line 3, column direction", "effective_inertia above 0"),
    ("8,y,300", "8,y,many", "line 3, column effective_mass [kg]", "a finite number",
     "line 3, column direction"),
    ("30,z,50,0", "30,z,50,1", "line 5, column direction", "expected height 0"),
    ("height [m]", "level [m]", "line 1, column level [m]", "unknown column"),
]  # fmt: skip

SUPPORT = '[[devices.supports]]\npoint = ["23.1 m", "12.0 m", "30.3 m"]'
THIRD = f'{SUPPORT.replace("23.1", "9.1")}\nradius = "1 m"\n{SUPPORT}'
MATRICES = '[devices.matrices]\nmass = "mass.csv"\nstiffness = "stiffness.csv"\n'
PIPES = [
    ('"30.3 m"]\nradius', '"28 m"]\nradius', "supports[1].point", "at the level of no floor"),
    ('["23.1 m", "12.0 m", "25.5 m"]', '["99 m", "12 m", "25.5 m"]', "supports[0].point", "out"),
    ('"12.0 m", "30.3 m"]', '"12.0 m", "25.5 m"]', "supports", "at different points, found two"),
    ('["corner", "edge_*"]', '["korner"]', "supports[1].envelope", "there is none for korner"),
    ('["corner", "edge_*"]', '["corner", "corner"]', "supports[1].envelope", "once"),
    ('"pipe"\n', '"pipe"\npoint = ["1 m", "1 m", "30.3 m"]\n', "point", "beside supports"),
    ('"pipe"\n', '"pipe"\nradius = "1 m"\n', "radius", "nothing here beside supports"),
    ('"pipe"\n', '"pipe"\nenvelope = ["corner"]\n', "envelope", "each may have an envelope"),
    ('"pipe"\n', '"pipe"\nmass = "1 t"\n', "mass", "0.5 t along y"),
    ('"pipe"\n', '"pipe"\nmass = "520 kg"\n', "mass", "0.5 t along y"),
    ('"pipe"\n', '"pipe"\nmass = "500 kg"\nmass_height = "0 m"\n', "mass_height", "matrices"),
    (MATRICES, "", "matrices", "missing; expected the matrices of a device with several"),
    ('"pipe"\n', '"pipe"\nmodes = "spectra.csv"\n', "modes", "a device with several supports"),
    (SUPPORT, THIRD, "matrices", "the matrices have no motion of support 3"),
    ('mass = "mass.csv"', 'mass = "no.csv"', "matrices.mass", "no such file"),
    ('spectra = "spectra.csv"', 'spectra = "no.csv"', "spectra", "no such file"),
]  # fmt: skip

ANALYSES = [
    ('"abs"', '"dsc"', "combination", "each combination once"),
    ('duration = "4 s"\n', "", "duration", "the duration of the strong motion"),
    ('"gupta"', '"lindley-yow"', "rigid.f1", "only with method 'gupta'",
     "device_analysis.rigid.f2"),
    ('"gupta"', '["lindley-yow", "none"]', "rigid.f1", "only with method 'gupta'",
     "device_analysis.rigid.f2"),
    ('"gupta"', '"stiff"', "rigid.method", "expected 'none' or 'gupta' or 'lindley-yow', or a"),
    ('"gupta"', '["gupta", "gupta"]', "rigid.method", "or a list of them, each once"),
    ('f2 = "30 Hz"', 'f2 = "5 Hz"', "rigid.f2", "above f1, 5 Hz"),
    ('"0.2 ms"', '"1.1 ms"', "time_step", "at most the time step of [transient], 0.001 s"),
]  # fmt: skip

# Two devices share the table: what is wrong with it is reported once.
CABINETS = TRANSIENT + CABINET + CABINET.replace("cabinet", "other")
TABLES = [
    (Base(), None, "buildings[1].structure.", STRUCTURES),
    (FROM_FILE, None, "buildings[1].structure.mesh.", MESH_FILES),
    (Base(PARTS), None, "buildings[1].structure.materials[0].", MATERIALS),
    (Base(PART_DAMPING + FULL_ORDER), None, "buildings[1].structure.", DAMPINGS),
    (Base(), "pair_walls.csv", "", OF_WALLS),
    (Base(), "pair_bays.csv", "", OF_BAYS),
    (Base(), "pair_beams.csv", "", OF_BEAMS),
    (Base(), "pair_columns.csv", "", OF_COLUMNS),
    (Base(EVERY_KEY, OTHERS), None, "transient.", TRANSIENTS),
    (Base(TRANSIENT + POINT), None, "transient.probes[0].", OF_POINT),
    (Base(TRANSIENT + LINE), None, "transient.probes[0].", OF_LINE),
    (Base(TRANSIENT + GROUP), None, "transient.probes[0].", OF_GROUP),
    (Base(TRANSIENT), None, "", CONTACTS),
    (Base(TRANSIENT + PUMP), None, "devices[0].", PUMPS),
    (Base(TRANSIENT + PUMP + BEAM), None, "devices[0].beam.", BEAMS),
    (Base(TRANSIENT + CABINET, MODES), None, "devices[0].", BESIDE_MODES),
    (Base(CABINETS, MODES), "pair_modes.csv", "", MODE_ROWS),
    (Base(PIPE, PIPE_FILES), None, "devices[0].", PIPES),
    (Base(TRANSIENT + CABINET + ANALYSIS, MODES), None, "device_analysis.", ANALYSES),
]


@each_row(TABLES)
def test_refused(written, base, file, key, row):
    check_row(written, base, file, key, row)
