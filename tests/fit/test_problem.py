"""The file of a fit: what it says, and every fault of it at once."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fit_texts import TARGETS
from impactfem.fit.fit_file import Quantity, read_fit
from impactfem.fit.plausibility import implausible, warn_of_far_targets
from impactfem.fit.problem import read_problem
from impactfem.reduction.probes import LINE_POINTS
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"
FREE = """
[free."materials.concrete.young_modulus"]
bounds = ["15 GPa", "45 GPa"]
scale = "log"
[free."buildings[0].rigid_below"]
bounds = ["10 cm", "80 cm"]
"""
MESH = "buildings[0].structure.mesh"
FLOOR = 'type = "floor"\nbuilding = "T"\nfloors = 1\nquantity = "A"\n'


def faults(case, path):
    with pytest.raises(InputError) as error:
        read_problem(case, path)
    return [str(fault).removeprefix(f"{path.parent}/") for fault in error.value.faults]


@pytest.mark.parametrize(
    ("text", "value", "unit", "digit"),
    [
        ("1.80 Hz", 1.8, "Hz", 0.01),
        ("6.3e7 kg m2", 6.3e7, "kg m2", 1e6),
        ("2144 t", 2.144e6, "kg", 1e3),
        (0.25, 0.25, "-", np.nan),  # which may have been 0.250
        ("0.620", 0.62, "-", 0.001),
        (3, 3.0, "-", 1.0),
    ],
)
def test_printed_digits(text, value, unit, digit):
    """A value rounded to a digit is evenly spread over its width: σ = width/√12."""
    given = Quantity().check(text, None)
    assert (given.value, given.unit) == (pytest.approx(value), unit)
    assert given.rounding == pytest.approx(digit / np.sqrt(12.0), nan_ok=True)


@pytest.mark.parametrize("text", ["1e400 Hz", "-1e999", "1e-400 m", "1e300 Hz", "-1.1e60"])
def test_numbers_out_of_range(text):
    """Said in our words, not in those of the system."""
    with pytest.raises(ValueError, match=r"expected a (finite )?value") as error:
        Quantity().check(text, None)
    assert "result out of range" not in str(error.value)
    assert Quantity().check("1e60 Hz", None).value == 1e60


@pytest.mark.parametrize(
    ("target", "refused"),
    [
        ('result = "motion.misfit_rms"\nvalue = 1.80', True),
        ('result = "motion.misfit_rms"\nvalue = "1.80"', False),
        ('result = "motion.misfit_rms"\nvalue = 1.80\ndeviation = "1 %"', False),
        ('result = "pounding.impacts"\nvalue = 180', False),  # of whole numbers nothing is lost
        (FLOOR + 'value = "1.80 m2"', False),
    ],
)
def test_a_bare_number(written, target, refused):
    """1.80 and 1.8 are one number to TOML: without a deviation it has to be a text."""
    path = written(f"{FREE}[[targets]]\n{target}\n")
    if not refused:
        assert read_fit(path, [])[0]
        return
    found = []
    assert read_fit(path, found)[0] is None
    assert re.search(r'targets\[0\].deviation: missing; .* as "1.80"', str(found[0]))


def test_a_fit(case, written):
    problem, rough = read_problem(case, written(FREE + TARGETS))
    assert rough is None and problem.level == "sticks"
    assert problem.values(problem.start) == pytest.approx([33e9, 0.4])
    assert problem.values(np.array([0.5, 0.5])) == pytest.approx([(15e9 * 45e9) ** 0.5, 0.45])
    first, second = problem.data
    assert (first.deviation, first.part) == (pytest.approx(0.01 / 12.0**0.5), 0.0)
    assert (second.deviation, second.part) == (0.0, 0.01)
    assert problem.case(np.zeros(2)).materials["concrete"].young_modulus == pytest.approx(15e9)
    assert problem.key(np.zeros(2)) != problem.key(np.ones(2))


@pytest.mark.parametrize(
    ("target", "level", "stages"),
    [
        ('result = "building.frequency.1"\nvalue = "1 Hz"', "modes", ()),
        (
            'type = "floor"\nbuilding = "T"\nfloors = 1\nquantity = "Jx"\ndeviation = "5 %"',
            "floors",
            (),
        ),
        ('result = "pounding.impacts"\nvalue = 3', "run", ("pounding",)),
    ],
)
def test_the_cheapest_way(case, written, target, level, stages):
    problem, _ = read_problem(case, written(f"{FREE}{TARGETS}[[targets]]\n{target}\n"))
    assert (problem.level, problem.stages) == (level, stages)


def test_every_fault_at_once(case, written):
    """Those of the file, and its keys; what needs its values and the case comes then."""
    path = written(
        """
starts = 0
[free."damping.ratio"]
bounds = ["7 %", "3 %"]
scale = "cubic"
[free."damping.ration"]
bounds = ["3 %", "7 %"]
[coarse]
"pounding.time_stop" = "2 ms"
[free."buildings[0].rigid_below"]
bounds = ["10 cm", "3 kg"]
[[targets]]
result = "sticks.T.frequency.1"
value = "1.8 hz"
[[targets]]
type = "modes"
building = "T"
modes = "absent.csv"
shapes = "updating_shapes.csv"
[[targets]]
type = "modal"
"""
    )
    found = "\n".join(faults(case, path))
    for words in (
        "some_fit.toml: starts = 0: expected a whole number of at least 1",
        """free."damping.ratio".bounds = ['7 %', '3 %']: """,
        """free."damping.ration": unknown key; did you mean 'damping.ratio'?""",
        """coarse."pounding.time_stop": unknown key; did you mean 'pounding.time_step'?""",
        "expected bounds in order, the lower one first",
        "scale = 'cubic': expected 'linear' or 'log'",
        """free."buildings[0].rigid_below".bounds = ['10 cm', '3 kg']: expected one unit""",
        "targets[0].value = '1.8 hz': ",
        "did you mean 'Hz'",
        "targets[1].modes = 'absent.csv'",
        "targets[2].type = 'modal': expected 'scalar' or 'floor' or 'modes' or 'spectrum'",
    ):
        assert words in found


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FREE.replace('["10 cm", "80 cm"]', '["80 cm", "10 cm"]') + TARGETS, "bounds in order"),
        ("free = [", "not valid TOML"),
        (FREE + TARGETS, ""),
    ],
)
def test_faults_of_both_files(case, written, text, words):
    """One of the case hides none of the file of the fit alone."""
    case.write_text(case.read_text().replace('ratio = "5 %"', 'ratio = "5 m"'))
    found = faults(case, written(text))
    assert found[0].startswith("updating.toml: damping.ratio = '5 m'")
    assert len(found) == 1 + bool(words)
    assert all(one.startswith("some_fit.toml: ") and words in one for one in found[1:])


@pytest.mark.parametrize("text", ["[[buildings]]\nname = 'T'\n", "extends = 'updating.toml'\n"])
def test_a_case_for_a_fit(case, written, text):
    """Said in one line; with free keys it is the file of a fit that has keys of a case."""
    one = "this is a case; expected the file of a fit, with [free] and [[targets]]"
    assert faults(case, written(text)) == [f"some_fit.toml: {one}"]
    found = faults(case, written(f"{FREE}{TARGETS}{text}"))
    assert found and all("this is a case" not in fault for fault in found)


PRIOR = 'scale = "log"\nprior = { mean = "0 Pa", deviation = "1 GPa" }'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("targets = 3\n" + FREE, "targets = 3: expected"),
        (FREE.replace('scale = "log"', PRIOR) + TARGETS, "mean above zero for a logarithmic"),
        (f'{FREE}[[targets]]\n{FLOOR}value = "13 m"\n', "'13 m': expected a value in m2"),
        (
            f'{FREE}[[targets]]\n{FLOOR.replace("1", "[2, 1, 2]")}deviation = "2 %"\n',
            "targets[0].floors = [2, 1, 2]: expected each floor once",
        ),
    ],
)
def test_faults_of_the_file_alone(case, written, text, words):
    assert words in "\n".join(faults(case, written(text)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FREE.replace("rigid_below", "rigid_bellow"), "did you mean 'buildings[0].rigid_below'?"),
        (FREE.replace('["10 cm", "80 cm"]', '["10 kg", "80 kg"]'), "expected bounds of its unit"),
        (FREE.replace('["10 cm", "80 cm"]', '["50 cm", "80 cm"]'), "or a start"),
        (FREE.replace('["10 cm", "80 cm"]', '["10 cm", "4 m"]'), "rigid zones together"),
        (f'[coarse]\n"mesh.size" = 3\n{FREE}', "coarse"),
        (
            f'[coarse]\n"buildings[0].rigid_below" = "40 cm"\n{FREE}',
            'coarse."buildings[0].rigid_below": expected keys that do not hold one another; '
            'free."buildings[0].rigid_below" is one',
        ),
        (
            f'[coarse]\nmaterials = {{ concrete = {{ density = "2 t/m3" }} }}\n{FREE}',
            'coarse."materials": expected keys that do not hold one another',
        ),
        *(
            (f"[coarse]\n{line}\n{FREE}", words)
            for line, words in (
                ('"buildings[0].rigid_above" = "10 cm"', "expected a key of the mesh"),
                ('title = "another"', "coarse.\"title\" = 'another': expected a key of the mesh"),
                ('"motions[0].seed" = 7', "expected a key of the mesh"),
                ('"damping.ratio" = "3 %"', "expected a key of the mesh"),
                ('"pounding.time_step" = "2 ms"', "expected a key of the mesh"),
                (f'"{MESH}.slab_thickness" = "30 cm"', "expected a key of the mesh"),
                (f'"{MESH}.size" = "2 m"', ""),
                (f'"{MESH}.floor_size" = "2 m"', ""),
                ('"buildings[0].structure.modes" = 5', ""),
            )
        ),
        (FREE + "[free.title]\nbounds = [1, 2]\n", 'free."title": the case has title'),
        (
            FREE + '[free."motions[0].seed"]\nbounds = [0, 10]\n',
            'free."motions[0].seed": the case has motions[0].seed = 1; expected the key of a num',
        ),
        (FREE + '[free."damping.ratio"]\nbounds = [0.04, 0.1]\n', ""),
        (
            FREE + '[free."damping.ratio"]\nbounds = [0.5, 10]\n',
            """free."damping.ratio".bounds = [0.5, 10]: the case has damping.ratio = '5 %'; """,
        ),
        *(
            (FREE + f'[free."damping.ratio"]\nbounds = [0.01, "{high} %"]\n{start}', words)
            for high, start, words in (
                (90, 'start = "80 %"', ""),
                (200, "", """free."damping.ratio".bounds[1] = '200 %': expected a number"""),
                (300, 'start = "200 %"', """free."damping.ratio".start = '200 %': expected"""),
            )
        ),
        (f'{FREE}[[targets]]\nresult = "pounding.frequency"\nvalue = 3\n', ""),
        (f'{FREE}[[targets]]\nresult = "sticks.T.mass"\nvalue = "520 t"\n', ""),
        (f'{FREE}[[targets]]\nresult = "sticks.T.frequency"\nvalue = 3\n', "sticks.T.frequency.1"),
        (f'{FREE}[[targets]]\nresult = "sticks.T.frequency.1"\nvalue = "3 m"\n', "value in Hz"),
        (
            f'{FREE}[[targets]]\nresult = "sticks.T.frequency.7"\nvalue = "9 Hz"\n',
            "targets[2].result = 'sticks.T.frequency.7': expected a mode of T from 1 to 6",
        ),
        (f'{FREE}[[targets]]\nresult = "sticks.T.frequency.6"\nvalue = "9 Hz"\n', ""),
        (
            f'{FREE}[[targets]]\nresult = "sticks.T.effective_mass.0"\nvalue = "9 t"\n',
            "targets[2].result = 'sticks.T.effective_mass.0': expected a mode of T from 1 to 6",
        ),
        (
            f'{FREE}[[targets]]\nresult = "pounding.main_impact_forze"\nvalue = "9 kN"\n',
            "did you mean 'pounding.main_impact_force'?",
        ),
        (
            f'{FREE}[[targets]]\nresult = "pounding.main_impact_force"\nvalue = "9 Hz"\n',
            "targets[2].value = '9 Hz': expected a value in N",
        ),
        (f'{FREE}[[targets]]\nresult = "pounding.main_impact_force"\nvalue = "9 kN"\n', ""),
        (
            f'{FREE}[[targets]]\nresult = "frs.floor_5.peak"\nvalue = "9 m/s2"\n',
            "targets[2].result = 'frs.floor_5.peak': expected a floor of the case, [1, 2, 3, 4]",
        ),
        (f'{FREE}[[targets]]\nresult = "frs.floor_4.peak"\nvalue = "9 m/s2"\n', ""),
        (f'{FREE}[[targets]]\nresult = "sticks.S.mass"\nvalue = "3 t"\n', "building; known: T"),
        *(
            (f'{FREE}[[targets]]\nresult = "{name}"\nvalue = "{value}"\n', words)
            for name, value, words in (
                ("building.frequency.3", "9 Hz", ""),
                ("building.frequency.3", "9 s", "targets[2].value = '9 s': expected a value in Hz"),
                ("building.frequency.0", "9 Hz", "building.frequency.1 to building.frequency.3"),
                ("building.frequency.4", "9 Hz", "building.frequency.1 to building.frequency.3"),
                ("building.floor_mass.4", "9 t", ""),
                (
                    "building.floor_mass.4",
                    "9 m",
                    "targets[2].value = '9 m': expected a value in kg",
                ),
                ("building.floor_mass.5", "9 t", "building.floor_mass.1 to building.floor_mass.4"),
                ("building.mas", "9 t", "did you mean 'building.mass'?"),
                ("motion.pga", "9 m/s2", ""),
                ("motion.pga", "9 m/s", "targets[2].value = '9 m/s': expected a value in m/s2"),
                (
                    "pounding.storey_shear_max",
                    "9 m",
                    "targets[2].value = '9 m': expected a value in N",
                ),
            )
        ),
        (f'{FREE}[[targets]]\nresult = "stick.T"\nvalue = 3\n', "did you mean 'sticks'?"),
        (f'{FREE}[[targets]]\nresult = "device.f"\nvalue = 3\n', "expected a section"),
        (
            f'{FREE}[[targets]]\ntype = "floor"\nbuilding = "T"\nfloors = [9]\nquantity = "A"\n'
            'deviation = "1 %"\n',
            "targets[2].floors = 9: expected floors of T",
        ),
        (
            f'{FREE}[[targets]]\ntype = "floor"\nbuilding = "S"\nfloors = 1\nquantity = "A"\n',
            "unknown building",
        ),
    ],
)
def test_faults_with_the_case(case, written, text, words):
    if not words:
        read_problem(case, written(text + TARGETS))  # which name results have, a run alone knows
        return
    head, bracket, targets = text.partition("[[targets]]")
    path = written(head + TARGETS + bracket + targets)
    assert words in "\n".join(faults(case, path))


CALIBRATION = """
[calibration]
targets = "calibration.csv"
direction = "y"
stiffness_factor = [0.2, 5]
rigid_depth = "0.5 m"
height = "12 m"
"""


@pytest.mark.parametrize(
    ("more", "key", "words"),
    [
        (CALIBRATION, "stiffness_factor", "[calibration] fits it in every evaluation"),
        (CALIBRATION, "rigid_below", "[calibration] fits it in every evaluation"),
        (CALIBRATION, "second_moment_factor", ""),
        (f'{CALIBRATION}mode = "given"', "stiffness_factor", ""),
        ("", "stiffness_factor", ""),
        (
            'calibration = { frequency = "1 Hz", direction = "y" }',
            "structure.storey_stiffness_factor",
            "the calibration of the 3D model of T fits it",
        ),
        ("", "structure.storey_stiffness_factor", ""),
    ],
)
def test_keys_that_the_case_fits(case, written, more, key, words):
    """Free, they have no say: refused by name, and none that the case takes as it is given."""
    head, table, rest = case.read_text().partition("[[buildings.structure.materials]]")
    inside = "" if CALIBRATION in more else f"{more}\n"
    case.write_text(f"{head}{inside}{table}{rest}{more if CALIBRATION in more else ''}")
    row = "building,mode,frequency [Hz],effective_mass [t]\nT,1,0.93,400\n"
    case.with_name("calibration.csv").write_text(row)
    path = written(f'[free."buildings[0].{key}"]\nbounds = [0.3, 2.0]\n{TARGETS}')
    if key == "rigid_below":
        path.write_text(path.read_text().replace("[0.3, 2.0]", '["0.3 m", "0.45 m"]'))
    if not words:
        read_problem(case, path)
        return
    found = "\n".join(faults(case, path))
    assert f'free."buildings[0].{key}": {words}' in found


def test_a_calibration_by_the_first_building(case, written):
    """Of two buildings of a calibration the second one has the values of the first."""
    text = case.read_text() + CALIBRATION + 'mode = "given"\n'
    second = """
[[buildings]]
name = "S"
material = "concrete"
floors = "row_of_three_b_floors.csv"
axis = ["7 m", "40 m"]
rigid_below = "0.4 m"
rigid_above = "0.1 m"
[[motions]]"""
    case.write_text(text.replace("[[motions]]", second, 1))
    rows = "building,mode,frequency [Hz],effective_mass [t]\nT,1,0.93,400\nS,1,0.93,400\n"
    case.with_name("calibration.csv").write_text(rows)
    free = '[free."buildings[{}].stiffness_factor"]\nbounds = [0.3, 2.0]\n'
    read_problem(case, written(free.format(0) + TARGETS))
    found = faults(case, written(free.format(1) + TARGETS))
    assert len(found) == 1 and "[calibration] gives" in found[0]


MODES = """
[[targets]]
type = "modes"
building = "T"
modes = "updating_modes.csv"
shapes = "updating_shapes.csv"
"""


def warned(case, path):
    found = [str(one) for one in implausible(read_problem(case, path)[0])]
    return [one.removeprefix(f"{path.parent}/") for one in found]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ""),
        ({r"^([25],.*),.*$": r"\1,1"}, "all amplitudes of mode 2, 5 are the same"),
        ({r"^2,.*,(6|9),.*$|^2,.*,y,.*$": "", r"^(2,.*),.*$": r"\1,1"}, ""),  # the roof along x
        ({r"^2,.*\n": "", r"^1,(.*)$": r"1,\1\n2,\1"}, "one shape of modes 1 and 2 (MAC 1.000): a"),
        ({r",12,(.*)$": r",16,\1"}, "the sensor at (0, 0, 16) m is away from T; so are 2 more"),
        ({r",12,(.*)$": r",14,\1"}, ""),
        ({r",14,(0|8),": r",14000,\1,"}, "the sensor at (14000, 0, 6) m is away from T"),
    ],
)
def test_shapes_that_are_hardly_meant(case, written, changes, words):
    """None are measured, two of one mode, or sensors that are not on the stick."""
    before, _, rest = case.read_text().partition("[buildings.structure]")
    case.write_text(f"{before}[[motions]]{rest.partition('[[motions]]')[2]}")
    table = case.with_name("updating_shapes.csv")
    for old, new in changes.items():
        table.write_text(re.sub(old, new, table.read_text(), flags=re.MULTILINE))
    found = warned(case, written(FREE + MODES))
    assert len(found) == bool(words)
    where = "some_fit.toml: targets[0].shapes = 'updating_shapes.csv': "
    assert all(one.startswith(where) and words in one for one in found)


ONE = TARGETS[: TARGETS.rindex("[[targets]]")]
KNOWN = '"log"\nprior = {{ mean = "{}", deviation = "10 %" }}'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FREE + TARGETS, ""),
        (FREE.replace('"log"', KNOWN.format("45 GPa")), ""),
        (FREE.replace('"log"', KNOWN.format("50 GPa")), "the bounds, by 1.05 of its deviations"),
        (
            FREE.replace('"log"', KNOWN.format("30 MPa")),
            """free."materials.concrete.young_modulus".prior.mean = '30 MPa': outside of the """
            "bounds, by 62.1 of its deviations",
        ),
        *(
            (f"{FREE}{MODES}{key} = {value}\n", words and f"targets[0].{key} = {value}: {words}")
            for key, value, words in (
                ("frequency_deviation", "'100 %'", ""),
                ("frequency_deviation", "'101 %'", "more than 100 % of the value"),
                ("frequency_deviation", "'0.9 Hz'", ""),  # of 0.9078 Hz
                ("frequency_deviation", "'0.92 Hz'", "more than 100 % of the value"),
                ("damping_deviation", "0.2", ""),
                ("damping_deviation", "1.1", "more than 100 % of the value"),
                ("shape_deviation", "1.0", ""),
                (
                    "shape_deviation",
                    "5",
                    "outside the usual range, 0.02 to 0.1 of the largest amplitude",
                ),
            )
        ),
        (
            FREE + TARGETS + TARGETS.replace('T.frequency.1"', 'T.mass"').replace("0.93 Hz", "5 t"),
            "'sticks.T.frequency.2': sticks.T.frequency.2 is that of targets[1] already, and",
        ),
        *(
            (
                f"{FREE}[[targets]]\n{FLOOR}value = '2 m2'\n[[targets]]\n{other}value = '3 m2'\n",
                words,
            )
            for other, words in (
                (FLOOR, "targets[1].floors = 1: A of T, floor 1 is that of targets[0] already"),
                (FLOOR.replace("1", "[2, 3]"), ""),
                (FLOOR.replace('"A"', '"Avy"'), "the floor table has 0.02 m2 of floor 1"),
            )
        ),
        (FREE + ONE, "free: 2 keys, but 1 data and priors: they cannot determine all of the keys"),
        (FREE.replace('"log"', KNOWN.format("45 GPa")) + ONE, ""),
        (FREE.replace('"15 GPa"', '"46 MPa"'), ""),
        (
            FREE.replace('"15 GPa"', '"44 MPa"'),
            "bounds = ['44 MPa', '45 GPa']: the upper one is 1.02e+03",
        ),
        (f'[coarse]\n"{MESH}.size" = "2 m"\n{FREE}', ""),
        (
            f'[coarse]\n"{MESH}.size" = "1 m"\n{FREE}',
            "mesh.size\" = '1 m': not coarser than the case, which has '1 m'",
        ),
        (FREE + TARGETS.replace("1 %", "100 %"), ""),
        (FREE + TARGETS.replace("1 %", "150 %"), "targets[1].deviation = '150 %': more than 100 %"),
    ],
)
def test_what_is_hardly_meant(case, written, text, words):
    """Each a warning with its key and the value as it is written."""
    found = warned(case, written(text if "[[targets]]" in text else text + TARGETS))
    assert len(found) == bool(words) and all(words in one for one in found)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("1,0.9078,2.548", "1,0.0521,0.205", ""),
        (
            "1,0.9078,",
            "1,907.8,",
            "row 1, frequency = 907.8: in SI; outside the usual range, 0.3 to 50 Hz",
        ),
        (
            "frequency [Hz]",
            "frequency [kHz]",
            "row 1, frequency = 907.8: in SI; outside the usual range, 0.3 to 50",
        ),
        (
            ",2.548",
            ",0.025",
            "row 1, damping = 0.00025: in SI; outside the usual range, 0.5 % to 10 %",
        ),
    ],
)
def test_modes_that_are_hardly_meant(case, written, old, new, words):
    table = case.with_name("updating_modes.csv")
    table.write_text(table.read_text().replace(old, new))
    found = warned(case, written(FREE + MODES))
    assert len(found) == bool(words)
    assert all(one.startswith(f"updating_modes.csv: {words}") for one in found)


SPECTRUM = """
[[targets]]
type = "spectrum"
building = "A"
floor = 1
direction = "y"
damping = "5 %"
spectrum = "psa.csv"
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("", "", ""),
        ('"y"', '"z"', "targets[0].direction = 'z': expected a direction of [[motions]]"),
        ("floor = 1", "floor = 9", "targets[0].floor = 9: expected a floor of A"),
        ("floor = 1", 'probe = "corner_4"', ""),
        ("floor = 1", 'probe = "side_4_17"', ""),  # a node of a group, which the mesh numbers
        ("floor = 1", 'probe = "centre_2"', ""),
        ("floor = 1", f'probe = "line_{LINE_POINTS}"', ""),
        ("floor = 1", f'probe = "line_{LINE_POINTS + 1}"', "expected a probe of A; did you mean"),
        ("floor = 1", 'probe = "corner_3"', "did you mean 'corner_"),
        ("floor = 1", 'probe = "centre_9"', "targets[0].probe = 'centre_9': expected a probe of A"),
        (
            "psa.csv",
            "low.csv",
            "targets[0].spectrum = '0.01 Hz': expected frequencies of [spectra]",
        ),
        ("psa.csv", "high.csv", "targets[0].spectrum = '900 Hz': expected frequencies of"),
    ],
)
def test_spectra_that_no_run_has(written, old, new, words):
    """Place, direction and ordinates, by the case; before a run of minutes."""
    free = '[free."contacts[0].gap"]\nbounds = ["3.95 cm", "4.05 cm"]\n'
    path = written(free + SPECTRUM.replace(old, new))
    for name, row in (("psa", "3,4"), ("low", "0.01,4"), ("high", "900,4")):
        path.with_name(f"{name}.csv").write_text(f"frequency [Hz],psa [m/s2]\n5,4\n{row}\n")
    if not words:
        read_problem(GEOMETRY / "two_frames.toml", path)
        return
    assert words in "\n".join(faults(GEOMETRY / "two_frames.toml", path))


def test_bounds_that_the_case_refuses_elsewhere(written):
    """Named by the key of the file of the fit, and by no folder that is gone."""
    case = GEOMETRY / "two_frames.toml"
    free = '[free."buildings[1].axis[1]"]\nbounds = ["{}", "17.0405 m"]\n'
    target = '[[targets]]\nresult = "sticks.B.mass"\nvalue = "500 t"\n'
    found = faults(case, written(free.format("16 m") + target))
    where = """some_fit.toml: free."buildings[1].axis[1]".bounds[0] = '16 m': two_frames.toml: """
    assert found and all(one.startswith(where) and "/tmp" not in one for one in found)
    read_problem(case, written(free.format("17.04 m") + target))


def test_conditions_are_of_the_start(case, written):
    """A bound may be of a building that is too soft for a case; a start may not."""
    free = '[free."buildings[0].second_moment_factor"]\nbounds = [0.01, 2.0]\n'
    problem, _ = read_problem(case, written(free + TARGETS))
    assert problem.case(np.zeros(1)).buildings[0].second_moment_factor == 0.01
    (found,) = faults(case, written(f"{free}start = 0.01\n{TARGETS}"))
    assert "the first period of the stick of T" in found and '"period"' in found


def test_bounds_that_the_case_refuses_together(case, written):
    """Each alone is good, both are not: said of all of them, with which bounds."""
    free = '[free."buildings[0].rigid_{}"]\nbounds = ["10 cm", "{}"]\n'
    for end, words in (("1.6 m", "at all upper bounds together"), ("1.2 m", "")):
        path = written(free.format("below", end) + free.format("above", end) + TARGETS)
        if words:
            assert words in "\n".join(faults(case, path))
        else:
            read_problem(case, path)


@pytest.mark.parametrize(
    ("key", "bare", "percentage"),
    [
        ("frequency_deviation", "0.008", "'0.8 %'"),
        ("damping_deviation", "0.25", "'25 %'"),
        ("shape_deviation", "0.04", "'4 %'"),
    ],
)
def test_a_bare_deviation_is_a_part(case, written, key, bare, percentage):
    """As every ratio of the case file; of a quantity with a unit nothing is taken."""
    both = [
        read_problem(case, written(f"{FREE}{MODES}{key} = {value}\n"))[0].data
        for value in (bare, percentage)
    ]
    assert both[0] == both[1]
    assert both[0] != read_problem(case, written(FREE + MODES))[0].data


@pytest.mark.parametrize(
    ("deviation", "part", "width"),
    [("0.02", 0.02, 0.0), ("'2 %'", 0.02, 0.0), ("'0.02 Hz'", 0.0, 0.02), ("'20 mHz'", 0.0, 0.02)],
)
def test_deviations_of_scalars(case, written, deviation, part, width):
    problem, _ = read_problem(case, written(FREE + TARGETS.replace('"1 %"', deviation)))
    assert (problem.data[1].part, problem.data[1].deviation) == pytest.approx((part, width))
    prior = f'"log"\nprior = {{ mean = "30 GPa", deviation = {deviation} }}'
    path = written(FREE.replace('"log"', prior) + TARGETS)
    if not part:
        assert "unit of the bounds" in "\n".join(faults(case, path))
        return
    ((_, _, scaled),) = read_problem(case, path)[0].priors
    assert scaled == pytest.approx(part / np.log(3.0))


ONE_TARGET = '[[targets]]\nresult = "{}"\nvalue = "{}"\n{}\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *(
            (FREE + ONE_TARGET.format(name, value, deviation), words)
            for name, value, deviation, words in (
                ("sticks.T.frequency.1", "-1.6 Hz", "", "greater than 0"),
                ("sticks.T.frequency.1", "0 Hz", "deviation = '1 Hz'", "greater than 0"),
                ("sticks.T.mass", "-3 t", "deviation = '5 %'", "greater than 0"),
                ("sticks.T.effective_mass.1", "-1 t", "", "greater than 0"),
                ("sticks.T.effective_mass.1", "0 t", "", ""),
                ("pounding.main_impact_force", "-9 kN", "", ""),
                ("sticks.T.frequency.1", "1.6 Hz", "deviation = '1e-300 Hz'", "too small"),
                ("sticks.T.frequency.1", "1.6 Hz", "deviation = 1e-300", "too small"),
                ("sticks.T.frequency.1", "1.60000000000000 Hz", "", "too small"),
                ("pounding.main_impact_force", "0 N", "deviation = '1e-300 N'", "too small"),
                ("sticks.T.frequency.1", "1.6 Hz", "deviation = '1e-6 Hz'", ""),
                ("sticks.T.frequency.1", "1e61 Hz", "", "at most 1e+60"),
            )
        ),
        *(
            (f"{FREE}[[targets]]\n{FLOOR.replace('A', name)}{line}\n", words)
            for name, line, words in (
                ("Jx", "value = '0 kg m2'\ndeviation = '1 kg m2'", "greater than 0"),
                ("A", "value = '-2 m2'", "greater than 0"),
                ("A", "deviation = 1e-300", "at least 1e-09"),
            )
        ),
        *(
            (f"{FREE}{MODES}{line}\n", words)
            for line, words in (
                ("frequency_deviation = '1e-300 Hz'", "too small"),
                ("frequency_deviation = 1e-300", "too small"),
                ("damping_deviation = 1e-300", "at least 1e-09"),
                ("damping_deviation = '0.1 Hz'", "part of the damping ratios"),
                ("shape_deviation = 1e-300", "at least 1e-09"),
            )
        ),
        (FREE.replace('"log"', '"log"\nstep = 1e-17') + TARGETS, "at least 1e-06"),
        (FREE.replace('"log"', '"log"\nstep = 1e-6') + TARGETS, ""),
        *(
            (FREE.replace('["10 cm", "80 cm"]', bounds) + TARGETS, words)
            for bounds, words in (
                ('["0.4 m", "0.40000000000000008 m"]', "step of 0.001 of the range"),
                ('["0.4 m", "0.4000001 m"]', "step of 0.001 of the range"),
                ('["0.4 m", "0.401 m"]', ""),
            )
        ),
        (
            FREE.replace('"log"', '"log"\nprior = { mean = "30 GPa", deviation = 1e-300 }')
            + TARGETS,
            "deviation of at least 1e-09",
        ),
    ],
)
def test_values_that_no_building_has(case, written, text, words):
    path = written(text)
    if not words:
        read_problem(case, path)
        return
    assert words in "\n".join(faults(case, path))


def test_shapes_beyond_all_limits(case, written):
    table = case.with_name("updating_shapes.csv")
    rows = table.read_text().splitlines()
    rows[2] = rows[2].rpartition(",")[0] + ",1e308"
    table.write_text("\n".join(rows) + "\n")
    assert "amplitude = '1e308'" in "\n".join(faults(case, written(FREE + MODES)))


@pytest.mark.parametrize(
    ("datum", "count"),
    [(1.0, 0), (9.0, 0), (11.0, 1), (0.2, 0), (0.09, 1), (-1.0, 1), (1e50, 1), (0.0, 0)],
)
def test_data_far_from_the_start(case, written, caplog, datum, count):
    """By a factor of ten or more, or of another sign; of the model's value 1."""
    problem, _ = read_problem(case, written(FREE + ONE))
    data = (replace(problem.data[0], value=datum),)
    warn_of_far_targets(replace(problem, data=data), [1.0])
    assert caplog.text.count("times the model's value at the start") == count
    caplog.clear()
    warn_of_far_targets(replace(problem, data=data), [0.0])
    assert not caplog.text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (ONE_TARGET.format("sticks.T.frequency.1", "1e50 Hz", ""), "usual is 0.3 to 50 Hz"),
        (ONE_TARGET.format("sticks.T.frequency.1", "1.6 Hz", ""), ""),
        (f"[[targets]]\n{FLOOR}value = '900 m2'\n", "usual is 0.1 to 10 times"),
        (f"[[targets]]\n{FLOOR}value = '5 m2'\n", ""),
    ],
)
def test_values_far_from_usual(case, written, text, words):
    found = warned(case, written(FREE.partition('[free."buildings')[0] + text))
    assert len(found) == bool(words) and all(words in one for one in found)
