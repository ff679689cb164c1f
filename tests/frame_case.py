"""Pieces of case text that make a small pounding case of the shipped frame."""

QUICK = (
    ('duration = "3 s"', 'duration = "1 s"'),
    ('strong_phase = ["0.5 s", "2.5 s"]', 'strong_phase = ["0.2 s", "0.8 s"]'),
    ("modes = 20", "modes = 6"),
    ("\nstiffness_factor = 0.0505", "\n# stiffness_factor = 1"),
)
"""What is replaced for a short motion, few modes, and a stiff stick that hits fast."""
LIGHT = ('ratio = "5 %"', 'ratio = "1 %"')


def neighbour(more=""):
    """The replacement that puts a second frame, G, beside the first.

    Args:
        more: Further lines of its table.
    """
    table = """
[[buildings]]
name = "G"
material = "concrete"
floors = "frame_floors.csv"
rigid_below = "0.2 m"
rigid_above = "0.1 m"
"""
    return "\n[[motions]]\n", f"{table}{more}\n[[motions]]\n"


SOFT_NEIGHBOUR = neighbour('axis = ["0 m", "4.0002 m"]\nsecond_moment_factor = 0.2\n')
"""One that comes near enough to be hit."""


def floors_meet(gap):
    """The table of the contacts of both floors of F and G, by the law "floor"."""
    return f"""
[[contacts]]
a = {{ building = "F", floor = [1, 2], offset = ["0 m", "2 m", "0 m"] }}
b = {{ building = "G", floor = [1, 2], offset = ["0 m", "-2 m", "0 m"] }}
normal = [0, 1, 0]
gap = "{gap}"
law = "floor"
"""


def pump(point, radius):
    """The table of a device of 500 kg on springs.

    Args:
        point: Its anchor, as a case file says it.
        radius: Of its base_plate.
    """
    return f"""
[[devices]]
name = "pump"
point = {point}
radius = "{radius}"
mass = "500 kg"
mass_height = "0.5 m"
inertia = ["30 kg m2", "30 kg m2", "20 kg m2"]
[devices.stiffness]
x = "2e7 N/m"
y = "2e7 N/m"
z = "rigid"
rx = "1e7 N m/rad"
ry = "1e7 N m/rad"
rz = "rigid"
[devices.damping]
ratio = "2 %"
frequencies = ["10 Hz", "60 Hz"]
"""
