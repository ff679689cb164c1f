"""The table [buildings.soil] of a case file."""

import re
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.plausibility import implausible
from impactfem.stages.inputs import inputs_key

from .faults import all_faults, check_fault, faults_of
from .texts import replaced

GEOMETRY = Path(__file__).parents[2] / "geometry"
FULL = '[transient]\nsolver = "full"\n[ensemble]\nstructure_motions = 0\n'

RAFT = """
[buildings.soil.raft]
length = "46.2 m"
width = "15.6 m"
thickness = "1 m"
density = "2500 kg/m3"
"""
DISK = replaced(RAFT, ('length = "46.2 m"\nwidth = "15.6 m"', 'radius = "15 m"'))
HALF_SPACE = f"""
[buildings.soil]
type = "half-space"
shear_velocity = "400 m/s"
density = "2000 kg/m3"
poisson_ratio = 0.35
{RAFT}"""
ROWS = [[1e10, 0, 0, 0, -1e9, 0], [0, 1e10, 0, 1e9, 0, 0], [0, 0, 2e10, 0, 0, 0]]
ROWS += [[0, 1e9, 0, 1e12, 0, 0], [-1e9, 0, 0, 0, 5e12, 0], [0, 0, 0, 0, 0, 6e12]]
MATRICES = f"""
[buildings.soil]
type = "matrices"
stiffness = {ROWS}
damping = {[[value / 100 for value in row] for row in ROWS]}
{RAFT}"""
TABLE = f"""
[buildings.soil]
type = "table"
file = "soil.csv"
{RAFT}"""


def impedances(lowest=0.5, highest=60.0, scale=1.0):
    lines = ["component,frequency [Hz],real,imaginary,unit"]
    for name in ("x", "y", "z", "rx", "ry", "rz"):
        unit = "N m/rad" if name.startswith("r") else "N/m"
        for f in np.linspace(lowest, highest, 12):
            real, imaginary = scale * (1e10 - 1e5 * f**2), scale * 2e8 * f
            lines.append(f"{name},{f:.6g},{real:.8g},{imaginary:.8g},{unit}")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        (
            "400 m/s",
            "4 m/s",
            "soil.shear_velocity = '4 m/s'",
            "outside the usual range, 150 to 3000 m/s",
        ),
        (
            "2000 kg",
            "20 kg",
            "soil.density = '20 kg/m3'",
            "outside the usual range, 1600 to 2700 kg/m3",
        ),
        ('"1 m"', '"1 km"', "raft.thickness = '1 km'", "outside the usual range, 0.5 to 6 m"),
        ("15.6 m", "15.7 m", None, None),
    ],
)
def test_implausible_soil(broken, old, new, key, words):
    more = HALF_SPACE.replace(old, new)
    path = broken(
        (None, 'name = "B1"', 'name = "B1"\nlength = "46.2 m"\nwidth = "15.6 m"'), more=more
    )
    found = [str(fault) for fault in implausible(load_case(path), 10.0) if "soil" in str(fault)]
    assert len(found) == (key is not None)
    assert all(key in line and words in line for line in found)


@pytest.mark.parametrize(
    ("more", "factor", "keys"),
    [
        (MATRICES, 1e-3, ["buildings[1]"]),
        (TABLE, 1e-3, ["buildings[1]"]),
        (MATRICES, 1.0, []),
        (TABLE, 1.0, []),
    ],
)
def test_springs_that_do_not_go_with_the_mass(broken, more, factor, keys):
    """As where they are in kN/m: their unit is in neither of the two."""
    rows = [[factor * value for value in row] for row in ROWS]
    text, table = (
        more.replace(f"stiffness = {ROWS}", f"stiffness = {rows}"),
        impedances(scale=factor),
    )
    path = broken(more=text, files={"soil.csv": table})
    found = implausible(load_case(path), 10.0)
    assert [fault.key for fault in found] == keys
    assert all("0.12" in fault.expected for fault in found)


def test_half_space(broken):
    """The middle of the raft's underside sways by the rotation of the base times its thickness."""
    clamped, soft = load_case(broken()), load_case(broken(more=HALF_SPACE))
    soil = soft.buildings[1].soil
    assert soil is not None and clamped.buildings[1].soil is None
    law = soil.law
    assert law.raft[0, 0] == pytest.approx(46.2 * 15.6 * 2500.0)
    assert law.static[1, 3] == pytest.approx(law.static[1, 1])
    for sections, same in ((("buildings", "soil"), False), (("buildings",), True)):
        keys = [inputs_key(case, sections) for case in (clamped, soft)]
        assert (keys[0] == keys[1]) is same


def test_matrices_and_table(broken):
    soil = load_case(broken(more=MATRICES)).buildings[1].soil
    assert soil is not None
    T = np.eye(6)
    T[0, 4], T[1, 3] = 1.0, -1.0
    assert soil.law.moved(T).static == pytest.approx(np.array(ROWS))
    soil = load_case(broken(more=TABLE, files={"soil.csv": impedances()})).buildings[1].soil
    assert soil is not None
    assert soil.law.errors().max() < 0.03
    text = re.sub(",N(/m| m/rad)", r",kN\1", impedances(scale=1e-3))
    other = load_case(broken(more=TABLE, files={"soil.csv": text})).buildings[1].soil
    for (f, *parts), (f_other, *others) in zip(soil.curves, other.curves, strict=True):
        assert np.array_equal(f, f_other)
        assert np.array(others) == pytest.approx(np.array(parts), rel=1e-6)


BAD = [
    (HALF_SPACE, "poisson_ratio = 0.35", "poisson_ratio = 0.5", "model", "of_the_shape"),
    (
        HALF_SPACE,
        "poisson_ratio = 0.35",
        "poisson_ratio = 0.6",
        "poisson_ratio",
        "less_than_equal 0.5",
    ),
    (HALF_SPACE, '"46.2 m"', '"40 m"', "raft.length", "of_soil 46.2 m"),
    (HALF_SPACE, RAFT, f'embedment = "-1 m"\n{RAFT}', "embedment", "greater_than_equal 0"),
    (HALF_SPACE, 'density = "2500 kg/m3"\n', "", "raft.density", "either"),
    (HALF_SPACE, 'width = "15.6 m"\n', "", "raft.width", "together"),
    (HALF_SPACE, "width =", 'radius = "9 m"\nwidth =', "raft.radius", "either"),
    (HALF_SPACE, '"400 m/s"', '"400"', "shear_velocity", "unit_missing"),
    (HALF_SPACE, RAFT, f'model = "pais-kausel"\n{DISK}', "model", "of_the_shape"),
    (HALF_SPACE, RAFT, f'embedment = "2 m"\n{DISK}', "embedment", "of_rectangles"),
    (MATRICES, "20000000000.0", "-20000000000.0", "stiffness", "definite"),
    (MATRICES, "[0, 10000000000.0", "[1e6, 10000000000.0", "stiffness", "definite"),
    (MATRICES, "200000000.0", "-200000000.0", "damping", "definite"),
    (MATRICES, f", {ROWS[5]}", "", "stiffness", "too_short"),
    (MATRICES, f"{ROWS[5]}", f"{ROWS[5]}, {ROWS[5]}", "stiffness", "too_long"),
    (
        MATRICES,
        f"{ROWS[5]}",
        "[0, 0, 0]",
        "stiffness[5]",
        "missing",
    ),
]


@pytest.mark.parametrize(("text", "old", "new", "key", "kind"), BAD)
def test_refused(broken, text, old, new, key, kind):
    plan = "stiffness_factor = 0.131\nsecond", 'length = "46.2 m"\nstiffness_factor = 0.131\nsecond'
    path = broken((None, *plan), more=replaced(text, (old, new)))
    check_fault(all_faults(path), f"buildings[1].soil.{key}", kind)


def test_full_order_has_a_clamped_base(tmp_path):
    """One fault, of however many buildings on soil; none of a stick on soil."""
    path = tmp_path / "soft.toml"
    soil = HALF_SPACE.replace("[buildings.", "[buildings.{0}.")
    for names in (("B1",), ("B1", "B2")):
        soils = "".join(soil.format(name) for name in names)
        path.write_text(f'extends = "{GEOMETRY / "npp_pair_both.toml"}"\n{soils}' + FULL)
        assert list(faults_of(path)) == ["transient.solver"]
    path.write_text(f'extends = "{GEOMETRY / "npp_pair.toml"}"\n{soil.format("B2")}' + FULL)
    assert load_case(path).buildings[1].soil is not None


@pytest.mark.parametrize(
    ("table", "kind"),
    [
        (impedances(highest=30.0), "of_soil 0.5 Hz"),
        (impedances(lowest=5.0), "of_soil 0.5 Hz"),
        (re.sub("(\nry,.*),.*,", r"\1,-1,", impedances(), count=1), "complete"),
        (impedances().replace("ry,0.5,9", "ry,0.5,-9"), "complete 0.5 Hz"),
        (re.sub("rz,.*\n", "", impedances()), "complete"),
        (re.sub(",unit|,N.*", "", impedances()), "missing_column"),
        (
            impedances().replace(",N/m", ",kN", 1),
            "in_si",
        ),
        (
            impedances().replace(",N m/rad", ",N/m", 1),
            "in_si",
        ),
    ],
)
def test_refused_tables(broken, table, kind):
    (fault,) = all_faults(broken(more=TABLE, files={"soil.csv": table}))
    check_fault([fault], fault.key, kind)
