"""A small case of two buildings with a 3D model each, which pound."""

from frame_case import pump

WALLS = """wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [m]
front,1-2,2,1.5,4,1.5,0.2
back,1-2,2,2.5,4,2.5,0.2
"""
COLUMNS = """column,storeys,x [m],y [m],width_x [m],width_y [m]
a,1-2,0,0,0.4,0.4
b,1-2,6,0,0.4,0.4
c,1-2,0,4,0.4,0.4
d,1-2,6,4,0.4,0.4
"""
FLOORS = (
    "floor,mass [t],Jx [kg m2],Jy [kg m2],Jz [kg m2],Ix [m4],Iy [m4],Iz [m4],A [m2],Avy [m2],"
    "Avx [m2],storey_height [m]\n"
    "1,30,5.8e4,1.5e5,2.1e5,1.2,0.1,1.3,1.1,0.8,0.3,3\n"
    "2,28,5.3e4,1.2e5,1.7e5,1.2,0.1,1.3,1.1,0.8,0.3,3\n"
)
BUILDING = """
[[buildings]]
name = "{name}"
material = "concrete"
floors = "floors.csv"
axis = ["3 m", "{y} m"]
rigid_below = "0.2 m"
rigid_above = "0.1 m"
second_moment_factor = {factor}
stick = "own"
[buildings.structure]
calibration = {{ frequency = "{frequency} Hz", direction = "y" }}
modes = 8
[buildings.structure.mesh]
type = "generated"
length = "6 m"
width = "4 m"
slab_thickness = "20 cm"
walls = "walls.csv"
columns = "columns.csv"
impact_edge = "{edge}"
size = "2 m"
"""
BUILDINGS = (
    BUILDING.format(name="A", y=2, factor=1, frequency=4, edge="y+"),
    BUILDING.format(name="B", y=6.001, factor=0.2, frequency=3, edge="y-"),
)
CASE = f"""allow = "gap"
title = "Two small frames with 3D models, 1 mm apart"
[materials.concrete]
young_modulus = "33 GPa"
poisson_ratio = 0.2
density = "2500 kg/m3"
[damping]
ratio = "5 %"
frequencies = ["1 Hz", "20 Hz"]
{"".join(BUILDINGS)}
[transient]
time_step = "2 ms"
maximum_frequency = "50 Hz"
tolerance = 0.05
[[motions]]
direction = "y"
type = "synthetic"
seed = 1
pga = "4 m/s2"
duration = "2 s"
time_step = "5 ms"
strong_phase = ["0.4 s", "1.6 s"]
iterations = 1
[motions.spectrum]
ground_acceleration = "4 m/s2"
corner_periods = ["0.1 s", "0.3 s", "2 s"]
[contact_laws.floor]
type = "kelvin-voigt"
stiffness = "5e8 N/m"
restitution = 0.5
[[contacts]]
a = {{ building = "A", floor = [1, 2], offset = ["0 m", "2 m", "0 m"] }}
b = {{ building = "B", floor = [1, 2], offset = ["0 m", "-2 m", "0 m"] }}
normal = [0, 1, 0]
gap = "1 mm"
law = "floor"
[pounding]
time_step = "0.5 ms"
[spectra]
damping = ["5 %"]
frequencies = {{ minimum = "0.5 Hz", maximum = "50 Hz", per_decade = 10 }}
"""
WALL = """
[wall_impact]
building = "B"
gap = "2 mm"
displacement = "-5 mm"
pull = "even_load"
duration = "0.5 s"
time_step = "0.5 ms"
"""
DEVICE = pump('["3 m", "1 m", "6 m"]', "0.6 m").replace('"pump"', '"pump"\nbuilding = "B"')
PROBE = """
[[transient.probes]]
name = "corner"
building = "B"
point = ["0 m", "0 m", "6 m"]
"""
MODELS = '[pounding]\nmodels = {{ A = "structure", B = "{}" }}\n'
LAW = 'type = "kelvin-voigt"\nstiffness = "5e8 N/m"\nrestitution = 0.5\n'


def write_case(folder, *more):
    """Write the case with its tables into a folder.

    Args:
        folder: The folder, which is made.
        more: Further sections.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tables = {"walls.csv": WALLS, "columns.csv": COLUMNS, "floors.csv": FLOORS}
    for name, text in tables.items():
        (folder / name).write_text(text, encoding="utf-8")
    path = folder / "pair.toml"
    path.write_text("".join([CASE, *more]), encoding="utf-8")
    return path


def in_3d(folder, *changes, b="structure", law='type = "unilateral"\n'):
    """The case of both buildings, touching in 3D."""
    path = write_case(folder)
    text = path.read_text(encoding="utf-8").replace(LAW, law)
    for old, new in (("[pounding]\n", MODELS.format(b)), *changes):
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path
