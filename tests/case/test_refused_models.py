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
    (FACTOR, 'material = "concret"', "material", "unknown_name 'concrete'"),
    (FACTOR, "dampings = 1", "dampings", "extra_forbidden"),
    ('"pair_walls.csv"', '"none.csv"', "mesh.walls", "unreadable"),
    ('"pair_bays.csv"', '"none.csv"', "mesh.bays", "unreadable"),
    ('"pair_beams.csv"', '"none.csv"', "mesh.beams", "unreadable"),
    ('"pair_columns.csv"', '"none.csv"', "mesh.columns", "unreadable"),
    *(
        ('size = "0.9 m"', f'size = "0.9 m"\n{line}', f"mesh.{key}", words)
        for line, key, words in (
            ('slabs = [{ floors = 9, thickness = "1 m" }]', "slabs", "each_floor_once"),
            ('slabs = [{ floors = [2, 2], thickness = "1 m" }]', "slabs", "each_floor_once"),
            ('wall_setback = ["0 m", "7.8 m"]', "wall_setback", "inside"),
            ('wall_setback = ["0 m", "0.4 m"]', "openings", "in_their_walls"),
            ('openings = [{ walls = "g*", storeys = 2, width = 1.5 }]', "openings",
             "in_their_walls -0.475 m"),
            ('openings = [{ walls = "g*", storeys = 3, width = 1 }]', "openings", "in_their_walls"),
            ('openings = [{ walls = "s*", storeys = 5, width = 0 }]', "openings[0].width",
             "greater_than"),
        )
    ),
    *(
        (FACTOR, f"{more}added_mass = [{{ {row} }}]", f"added_mass{key}", words)
        for more, row, key, words in (
            ("", 'floors = 9, across = "y", strip = "1 m"', "", "each_floor_once"),
            ("", 'floors = [1, 1], across = "y", strip = "1 m"', "", "each_floor_once"),
            ("", 'floors = 1, across = "z", strip = "1 m"', "[0].across", "literal_error"),
            ("floor_masses = false\n", 'floors = 1, across = "y", strip = "1 m"', "",
             "each_floor_once"),
            ("", 'floors = 1, across = "y", edges = 0.6, middle = 0.5, strip = "1 m"',
             "[0].middle", "at_most_all 0.4"),
        )
    ),
]  # fmt: skip

MESH_FILES = [
    ('"pair.msh"', '"none.msh"', "file",
     "unreadable"),
    ('"storey_*"', '"floor_*"', "shells", "once"),
    ('type = "file"', "", "type",
     "union_tag_not_found"),
    ('file = "pair.msh"', 'walls = "pair_walls.csv"', "walls",
     "extra_forbidden",
     "buildings[1].structure.mesh.file"),
]  # fmt: skip

MATERIALS = [
    ('material = "masonry"', 'material = "stone"', "material", "unknown_name"),
    ('density = "1800 kg/m3"\n', "", "material", "no_density"),
    ('parts = ["storey_*", "column_1_*"]', "parts = []", "parts", "too_short"),
    ('material = "masonry"\n', "", "material", "missing"),
]  # fmt: skip

DAMPINGS = [
    ('parts = ["beam_*"]', "parts = []", "damping[1].parts", "too_short"),
    ('parts = ["beam_*"]\n', "", "damping[1].parts", "missing"),
    ('ratio = "2 %"', 'ratio = "120 %"', "damping[0].ratio", "less_than 1"),
    ('coefficient = "1 ms"', 'coefficient = "1 m"', "damping[1].stiffness_coefficient", "unit"),
    ('parts = ["beam_*"]', 'part = ["beam_*"]', "damping[1].part", "extra_forbidden"),
]  # fmt: skip

SOUTH = "south,1-8,0,0,46.2,0,60"
GABLE = "gable,2,0,0,0,15.6,60"
WINDOW = "1,gable,2,2,2.05,3.3,57e-2"
ALONG = "along,1-8,0,7.8,46.2,7.8"
COLUMN = "row_1,2-8,5.775,7.8,0.8,1.2"
OF_WALLS = [
    ("gable,2", "south,2", "line 4, column wall", "duplicate"),
    (GABLE, "gable,2,0,0,0,0,60", "line 4, column y2 [m]", "two_ends"),
    (GABLE, "gable,2,0,0,0,15.7,60", "line 4, column y2 [m]",
     "placed 15.6 m"),
    (GABLE, "gable,2,-1,0,0,15.6,60", "line 4, column x1 [m]", "placed 46.2 m"),
    (SOUTH, "south,1-9,0,0,46.2,0,60", "line 2, column storeys",
     "placed"),
    (SOUTH, "south,1 3-5 10-12,0,0,46.2,0,60", "line 2, column storeys",
     "placed 10, 11, 12"),
    (GABLE, "gable,3-2,0,0,0,15.6,60", "line 4, column storeys", "levels"),
    (GABLE, "gable,2,46.2,0,40,0,60", "line 4, column wall", "one_on_another"),
    (GABLE, "gable,2,10,0,20,0,60", "line 4, column wall", "one_on_another"),
]  # fmt: skip

OF_BAYS = [
    (WINDOW, "1,gabel,2,2,1,1,1", "line 4, column wall", "placed 'gable'"),
    (WINDOW, "1,gable,3,2,1,1,1", "line 4, column storey",
     "placed"),
    (WINDOW, "1,gable,2,0.4,1,1,1", "line 4, column centre [m]",
     "placed -0.1 m"),
    (WINDOW, "1,gable,2,15.2,1,1,1", "line 4, column centre [m]", "placed 15.7 m"),
    (WINDOW, "1,gable,2,7.8,1,16,1", "line 4, column width [m]", "placed 15.6 m"),
    (WINDOW, "1,gable,2,2,1.63,1,1", "line 4, column sill [m]",
     "placed 2.63 m"),
    (WINDOW, "1,gable,2,2,0,1,3", "line 4, column height [m]", "placed 2.62 m"),
    (WINDOW, "1,gable,2,7.8,0,15.6,2.62", "line 4, column bay",
     "placed"),
    ("6,south,5,10,2.7", "6,south,5,10,2.6", "line 3, column centre [m]",
     "placed"),
    ("6,south,5,10,2.7", "7,south,5,10,0", "line 3, column centre [m]", "placed"),
]  # fmt: skip

OF_BEAMS = [
    ("along", "row_1", "line 3, column beam", "duplicate"),
    (ALONG, "along,1-8,0,16,46.2,7.8", "line 3, column y1 [m]", "placed"),
    (ALONG, "along,8-10,0,7.8,46.2,7.8", "line 3, column floors", "placed"),
    (ALONG, "along,8,5.775,7,5.775,8", "line 3, column beam", "one_on_another"),
]  # fmt: skip

OF_COLUMNS = [
    (COLUMN, "row_1,2,50,7.8,1,1", "line 2, column x [m]", "placed"),
    (COLUMN, "row_1,9,5,7.8,1,1", "line 2, column storeys", "placed"),
    (COLUMN, f"{COLUMN}\nrow_2{COLUMN[5:]}", "line 3, column column", "one_on_another"),
    (COLUMN, f"{COLUMN}\nrow_1,1,9,9,1,1", "line 3, column column", "duplicate"),
]  # fmt: skip

TRANSIENTS = [
    ('"10 s"', '"0 s"', "duration", "greater_than 0"),
    ('"1 ms"', '"5.001 s"', "time_step", "step_within 10 s"),
    ("[8, 6, 7]", "[8, 6, 8]", "floors", "once"),
    ("[8, 6, 7]", "[8, 9, 12]", "floors", "transient_points"),
    ('"-2 m"', '"-23.2 m"', "eccentricity", "transient_points 23.1 m"),
    ('["psa"]', '["psa", "psa"]', "fields", "once"),
    ('"20 Hz"]', '"10 Hz"]', "field_frequencies", "ascending"),
    ('["10 Hz", "20 Hz"]', "[]", "field_frequencies", "of_the_maps"),
    ('"both"', '"full"', "export", "all_nodes_known"),
    ('"1 s"', '"10 s"', "export_start", "transient_times 10 s"),
    ('"5 ms"', '"0.5 ms"', "export_step", "a_step_or_more 0.001 s"),
    ('shift = "50 Hz"', 'shft = "50 Hz"', "shft", "extra_forbidden 'shift'"),
]  # fmt: skip

OF_POINT = [
    ('point = ["0 m", "15.6 m", "3030 cm"]\n', "", "group",
     "one_way"),
    ('name = "corner"', 'name = "corner"\ngroup = "edge_8"', "group", "one_way"),
    ('name = "corner"', 'name = "corner"\ncount = 3', "count",
     "of_line"),
    ('"15.6 m"', '"80 m"', "point", "transient_points"),
    ('"3030 cm"', '"-2 m"', "point", "transient_points"),
]  # fmt: skip

OF_LINE = [
    ('name = "row"', 'name = "row"\npoint = ["0 m", "0 m", "0 m"]', "from",
     "not_beside_point"),
    ('name = "row"', 'name = "row"\ngroup = "edge_8"', "group", "one_way"),
    ('from = ["0 m", "1 m", "3 m"]\n', "", "to", "together"),
    ('to = ["8 m", "1 m", "7 m"]\n', "", "to", "together"),
    ("from", "start", "start", "extra_forbidden",
     "transient.probes[0].to"),
    ("from", "frm", "frm", "extra_forbidden 'from'"),
    ('["8 m", "1 m", "7 m"]', '["0 m", "100 cm", "3 m"]', "to", "away_from_start"),
    ("count = 5\n", "", "count", "of_line"),
    ('["8 m", "1 m", "7 m"]', '["80 m", "1 m", "7 m"]', "to", "transient_points"),
]  # fmt: skip

OF_GROUP = [
    ("edge_8", "edge_9", "group", "transient_points"),
    ("edge_8", "floor_10_parapet", "group", "transient_points"),
]  # fmt: skip

PLACE = 'offset = ["0 m", "7.8 m", "0 m"]'
NORMAL = "normal = [0, 1, 0]"
CONTACTS = [
    (NORMAL, "normal = [1, 0, 0]", "contacts[0].a.offset",
     "of_struck_sides 15.6", "contacts[0].gap"),
    (NORMAL, "normal = [0, -1, 0]", "contacts[0].a.offset",
     "of_struck_sides",
     "contacts[0].normal"),
    (NORMAL, "normal = [0, 1, 1]", "contacts[0].normal", "of_struck_sides"),
    (PLACE, PLACE.replace('"0 m", "7', '"-25 m", "7'), "contacts[0].a.offset",
     "of_struck_sides 15.6"),
    (PLACE, 'offset = ["0 m", "7.8 m", "-0.5 m"]', "contacts[0].a.offset",
     "of_struck_sides 0.5 m"),
    ("", f"{PUMP}{PUMP}", "devices[1].name",
     "duplicate"),
]  # fmt: skip

PUMPS = [
    ('mass = "1.5 t"\n', "", "mass", "or_a_table"),
    ('mass_height = "46 cm"\n', "", "mass_height", "with_mass"),
    ("shape = {", 'inertia = ["1 kg m2", "1 kg m2", "1 kg m2"]\nshape = {', "shape",
     "one_inertia"),
    ('shape = { type = "cylinder", radius = "50 cm", length = "1 m" }\n', "", "shape",
     "one_inertia"),
    ('"cylinder"', '"box"', "shape.type", "literal_error"),
    ('rx = "30 MN m/rad"', 'rx = "30 MN m"', "stiffness.rx", "unit"),
    (', z = "rigid"', ', z = "stiff"', "stiffness.z", "quantity"),
    ('z = "rigid", ', "", "stiffness.z", "missing"),
    ('y = "1.2e8 N/m"', 'y = "0 N/m"', "stiffness.y",
     "mechanism"),
    ('rx = "30 MN m/rad"', 'rx = "0 N m/rad"', "stiffness.rx",
     "mechanism"),
    ('damping = { ratio = "2 %", frequencies = ["30 Hz", "80 Hz"] }', "", "damping",
     "of_a_body"),
    ("[[devices]]", "[[devices]]\nfloor = 8", "floor", "extra_forbidden"),
    ('["23.1 m", ', '["46.3 m", ', "point", "of_devices 46.2"),
    ('"12.0 m"', '"-0.1 m"', "point", "of_devices 15.6 m"),
    ('"30.3 m"', '"30.5 m"', "point", "of_devices 30.3 m"),
    ('"30.3 m"', '"28 m"', "point", "of_devices 0.15 m"),
    ('"30.3 m"', '"0 m"', "point", "of_devices 3.26 m"),
]  # fmt: skip

BEAMS = [
    ('length = "46 cm"', 'length = "0 cm"', "length", "greater_than 0"),
    ('["80 MN m2", "60 MN m2"]', '"rigid"', "bending", "quantity"),
    ('["80 MN m2", "60 MN m2"]', '["80 MN m2"]', "bending", "missing"),
]  # fmt: skip

BESIDE_MODES = [
    ("pair_modes.csv", "none.csv", "modes", "unreadable"),
    ("",
     'stiffness = { x = "1 N/m", y = "1 N/m", z = "1 N/m", rx = "rigid", ry = "rigid", rz = '
     '"rigid" }', "stiffness", "alone"),
    ("", 'beam = { length = "1 m", bending = "1 N m2" }', "beam",
     "alone"),
    ("", 'mass = "400 kg"', "mass_height", "with_mass", "devices[0].shape"),
    ("", 'mass_height = "1 m"', "mass_height", "with_mass"),
    ("", 'inertia = ["1 kg m2", "1 kg m2", "1 kg m2"]', "inertia", "with_a_mass"),
    ("", 'shape = { type = "cylinder", radius = "1 m", length = "1 m" }', "shape",
     "with_a_mass"),
]  # fmt: skip

MODE_ROWS = [
    ("8,y", "8,u", "line 3, column direction", "text"),
    ("8,y,300", "8,y,0", "line 3, column direction", "carries_something"),
    ("8,y,300", "8,rx,300", "line 3, column direction", "carries_something"),
    ("8,y,300", "8,y,many", "line 3, column effective_mass [kg]", "cell",
     "line 3, column direction"),
    ("30,z,50,0", "30,z,50,1", "line 5, column direction", "above_the_anchor"),
    ("height [m]", "level [m]", "line 1, column level [m]", "column"),
]  # fmt: skip

SUPPORT = '[[devices.supports]]\npoint = ["23.1 m", "12.0 m", "30.3 m"]'
THIRD = f'{SUPPORT.replace("23.1", "9.1")}\nradius = "1 m"\n{SUPPORT}'
MATRICES = '[devices.matrices]\nmass = "mass.csv"\nstiffness = "stiffness.csv"\n'
PIPES = [
    ('"30.3 m"]\nradius', '"28 m"]\nradius', "supports[1].point", "of_devices"),
    ('["23.1 m", "12.0 m", "25.5 m"]', '["99 m", "12 m", "25.5 m"]', "supports[0].point",
     "of_devices"),
    ('"12.0 m", "30.3 m"]', '"12.0 m", "25.5 m"]', "supports", "apart"),
    ('["corner", "edge_*"]', '["korner"]', "supports[1].envelope", "of_devices"),
    ('["corner", "edge_*"]', '["corner", "corner"]', "supports[1].envelope", "once"),
    ('"pipe"\n', '"pipe"\npoint = ["1 m", "1 m", "30.3 m"]\n', "point", "one_place"),
    ('"pipe"\n', '"pipe"\nradius = "1 m"\n', "radius", "one_place"),
    ('"pipe"\n', '"pipe"\nenvelope = ["corner"]\n', "envelope", "envelope"),
    ('"pipe"\n', '"pipe"\nmass = "1 t"\n', "mass", "of_the_matrices 0.5 t"),
    ('"pipe"\n', '"pipe"\nmass = "520 kg"\n', "mass", "of_the_matrices 0.5 t"),
    ('"pipe"\n', '"pipe"\nmass = "500 kg"\nmass_height = "0 m"\n', "mass_height", "alone"),
    (MATRICES, "", "matrices", "of_the_supports"),
    ('"pipe"\n', '"pipe"\nmodes = "spectra.csv"\n', "modes", "one_anchor"),
    (SUPPORT, THIRD, "matrices", "of_the_supports"),
    ('mass = "mass.csv"', 'mass = "no.csv"', "matrices.mass", "unreadable"),
    ('spectra = "spectra.csv"', 'spectra = "no.csv"', "spectra", "unreadable"),
]  # fmt: skip

ANALYSES = [
    ('"abs"', '"dsc"', "combination", "once"),
    ('duration = "4 s"\n', "", "duration", "for_the_double_sum"),
    ('"gupta"', '"lindley-yow"', "rigid.f1", "of_gupta",
     "device_analysis.rigid.f2"),
    ('"gupta"', '["lindley-yow", "none"]', "rigid.f1", "of_gupta",
     "device_analysis.rigid.f2"),
    ('"gupta"', '"stiff"', "rigid.method", "literal_error"),
    ('"gupta"', '["gupta", "gupta"]', "rigid.method", "once"),
    ('f2 = "30 Hz"', 'f2 = "5 Hz"', "rigid.f2", "above_f1 5 Hz"),
    ('"0.2 ms"', '"1.1 ms"', "time_step", "of_devices 0.001 s"),
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
