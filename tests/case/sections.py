"""Sections, tables and edits of the case in `data`, from which the tests make other cases."""

from dataclasses import dataclass, field
from pathlib import Path

DATA = Path(__file__).parent / "data"
PAIR = (DATA / "pair.toml").read_text(encoding="utf-8")
MOTION = PAIR[PAIR.index("[[motions]]") : PAIR.index("[contact_laws")]
SPECTRUM = PAIR[PAIR.index("[motions.spectrum]") : PAIR.index("[contact_laws")]
GRID = '{ minimum = "0.5 Hz", maximum = "500 Hz", per_decade = 100 }'
LAW = """type = "kelvin-voigt"
stiffness = "1e11 N/m"
damping_ratio = "12 %"
tension = true
"""

# A file, or the case file when None; the text to be replaced there; the text in its place.
Edit = tuple[str | None, str, str]


@dataclass(frozen=True)
class Base:
    """A case without faults that a test breaks."""

    more: str = ""  #: what is added at the end of the case file
    files: dict[str, str | bytes] = field(default_factory=dict)  #: further files, by their names
    edits: tuple[Edit, ...] = ()  #: what is replaced
    structure: bool = True  #: whether B1 has a 3D model


MESH = """
[buildings.structure.mesh]
type = "generated"
length = "46.20 m"
width = "15.60 m"
slab_thickness = "30 cm"
walls = "pair_walls.csv"
bays = "pair_bays.csv"
beams = "pair_beams.csv"
columns = "pair_columns.csv"
parapet = { height = "63 cm", thickness = "30 cm" }
impact_edge = "y+"
size = "0.9 m"
"""
STRUCTURE = f"""
[buildings.structure]
storey_stiffness_factor = 0.13
calibration = {{ frequency = "1.80 Hz", direction = "y" }}
{MESH}"""
TABLES = {
    "pair_walls.csv": """\
wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [cm]
south,1-8,0,0,46.2,0,60
north,1 3-8,0,15.6,46.2,15.6,60
gable,2,0,0,0,15.6,60
""",
    "pair_bays.csv": """\
bay,wall,storey,centre [m],sill [m],width [m],height [m]
6,south,5,10,0,2,2.7
6,south,5,10,2.7,3.3,0.9
1,gable,2,2,2.05,3.3,57e-2
""",
    "pair_beams.csv": """\
beam,floors,x1 [m],y1 [m],x2 [m],y2 [m],width [m],depth [m],offset [m]
row_1,1-8,5.775,0,5.775,15.6,0.75,0.85,-0.575
along,1-8,0,7.8,46.2,7.8,0.2,0.28,-0.29
""",
    "pair_columns.csv": """\
column,storeys,x [m],y [m],width_x [m],width_y [m]
row_1,2-8,5.775,7.8,0.8,1.2
""",
}
FILE_MESH = """
[buildings.structure.mesh]
type = "file"
file = "pair.msh"
[[buildings.structure.mesh.shells]]
groups = "floor_*"
thickness = "25 cm"
[[buildings.structure.mesh.shells]]
groups = "storey_*"
thickness = "20 cm"
[[buildings.structure.mesh.beams]]
groups = "column_*"
width = "40 cm"
depth = "50 cm"
"""
FROM_FILE = Base(
    files={"pair.msh": b"$MeshFormat\n4.1 1 8\n\xff\x00"}, edits=((None, MESH, FILE_MESH),)
)
PARTS = """
[[buildings.structure.materials]]
parts = ["storey_*", "column_1_*"]
material = "masonry"
[materials.masonry]
young_modulus = "5 GPa"
poisson_ratio = 0.15
density = "1800 kg/m3"
"""
PART_DAMPING = """
[[buildings.structure.damping]]
parts = ["column_*", "floor_8"]
ratio = "2 %"
frequencies = ["1 Hz", "20 Hz"]
[[buildings.structure.damping]]
parts = ["beam_*"]
mass_coefficient = "0.2 1/s"
stiffness_coefficient = "1 ms"
"""

TRANSIENT = '\n[transient]\ntime_step = "1 ms"\n'
FULL_ORDER = f'{TRANSIENT}solver = "full"\n'
WALL = """
[wall_impact]
gap = "1 cm"
displacement = "-2 cm"
duration = "1.3 s"
time_step = "0.34 ms"
"""
LIGHT = """
[[damping_cases]]
name = "light"
mass_coefficient = "0.838 1/s"
stiffness_coefficient = "0.212 ms"
"""
POINT = '[[transient.probes]]\nname = "corner"\npoint = ["0 m", "15.6 m", "3030 cm"]\n'
LINE = """[[transient.probes]]
name = "row"
from = ["0 m", "1 m", "3 m"]
to = ["8 m", "1 m", "7 m"]
count = 5
"""
GROUP = '[[transient.probes]]\nname = "top"\ngroup = "edge_8"\n'
EVERY_KEY = """
[transient]
solver = "both"
duration = "10 s"
time_step = "1 ms"
maximum_frequency = "300 Hz"
tolerance = "1 %"
shift = "50 Hz"
largest_basis = 500
floors = [8, 6, 7]
eccentricity = "-2 m"
forces = "others.nc"
fields = ["psa"]
field_frequencies = ["10 Hz", "20 Hz"]
snapshots = false
export = true
export_nodes = "all"
export_start = "1 s"
export_duration = "2 s"
export_step = "5 ms"
checkpoint_every = "0.5 s"
"""
OTHERS = {"others.nc": "forces"}

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
MODES = {
    "pair_modes.csv": """\
frequency [Hz],direction,effective_mass [kg],height [m]
# the first one
8,y,300,1.1
12.5,x,280,1
30,z,50,0
"""
}
ANALYSIS = """
[device_analysis]
combination = ["abs", "dsc", "ten-percent"]
duration = "4 s"
rigid = { method = "gupta", f1 = "5 Hz", f2 = "30 Hz" }
missing_mass = false
directions = "100-40-40"
rotations = false
broadening = 0
time_step = "0.2 ms"
"""
PIPE = f"""{TRANSIENT}
[[transient.probes]]
name = "corner"
point = ["0 m", "0 m", "30.3 m"]
{LIGHT}
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
PIPE_FILES = {
    "mass.csv": "1.y [kg],tip [kg],2.y [kg]\n0,0,0\n0,500,0\n0,0,0\n",
    "stiffness.csv": "1.y [N/m],tip [N/m],2.y [N/m]\n3e6,-3e6,0\n-3e6,4e6,-1e6\n0,-1e6,1e6\n",
    "spectra.csv": "frequency [Hz],acceleration [m/s2],direction,damping\n"
    "1,2,y,0.01\n50,2,y,0.01\n1,1,y,0.05\n50,2,y,0.05\n",
}
LOADS = '\n[[loads]]\nfile = "blast.csv"\ndirection = [0, -2, 0]\n'
BLAST = {"blast.csv": "time [ms],B1.floor_8 [MN],B2.floor_1 [kN]\n0,0,0\n5,2.5,-40\n20,0,0\n"}
RECORD = '[[motions]]\ndirection = "x"\ntype = "record"\nfile = "motion.csv"\n\n'
RECORDED = Base(
    files={"motion.csv": "time [s],NS [g],EW [g]\n0,0,0\n1,1,2\n"},
    edits=((None, MOTION, RECORD),),
    structure=False,
)
EC8 = 'type = "ec8"\nspectrum_type = 1\nground = "B"\nreference_acceleration = "2 m/s2"\n'
DECREE = 'type = "french-decree"\nzone = 4\nground = "B"\n'
TABLE = 'type = "table"\nfile = "target.csv"\n'
POINTS = "frequency [Hz],acceleration [g]\n0.2,0.1\n10,0.5\n50,0.2\n"


def with_spectrum(keys, points=POINTS):
    """The case with another spectrum of its motion."""
    edit = (None, SPECTRUM, f"[motions.spectrum]\n{keys}\n")
    return Base(files={"target.csv": points}, edits=(edit,), structure=False)
