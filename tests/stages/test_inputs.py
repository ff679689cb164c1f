"""What the stages depend on: sections of the case, and what counts of the program's sources."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.damping import PartDamping, RayleighCase
from impactfem.case.transient import Transient
from impactfem.stages import inputs
from impactfem.stages.building.stage import BUILDING
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.design.stage import members_key
from impactfem.stages.device.stage import DEVICE
from impactfem.stages.ensemble.figures import published_results
from impactfem.stages.inputs import inputs_key, program_key, tolerances
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import model_key
from impactfem.stages.transient.stage import TRANSIENT
from one_building import building_of

GEOMETRY = Path(__file__).parents[2] / "geometry"
LIGHT = RayleighCase(name="light", mass_coefficient=0.8, stiffness_coefficient=2e-4)


@pytest.fixture(scope="module")
def case(new_case, tmp_path_factory):
    return _with(load_case(new_case(tmp_path_factory.mktemp("inputs"))))


@pytest.fixture(scope="module")
def frame():
    """A building with a 3D model that hits a wall, without devices."""
    wall = load_case(GEOMETRY / "npp_pair.toml").wall_impact.model_copy(update={"building": "F"})
    return _with(load_case(GEOMETRY / "frame.toml").model_copy(update={"wall_impact": wall}))


def _with(case, **changes):
    """The case with one damping case, changed."""
    one = LIGHT.model_copy(update=changes)
    return case.model_copy(update={"damping_cases": (one,)})


def _serving(case, served):
    transient = Transient(time_step=1e-3, serve_damping_cases=served)
    return case.model_copy(update={"transient": transient})


@pytest.mark.parametrize("sections", [("contact_laws", "damping_cases"), ("damping_cases",)])
def test_restitution_counts_with_the_contact_laws(case, sections):
    other = inputs_key(_with(case, restitution=0.5), sections)
    assert (other == inputs_key(case, sections)) == ("contact_laws" not in sections)
    lighter = inputs_key(_with(case, stiffness_coefficient=1e-4), sections)
    assert lighter != inputs_key(case, sections)


def test_calibration_depends_on_the_dampings(frame):
    assert CALIBRATE.key(_with(frame, stiffness_coefficient=1e-4)) != CALIBRATE.key(frame)
    assert CALIBRATE.key(frame.model_copy(update={"damping_cases": ()})) != CALIBRATE.key(frame)
    # It gives a restitution, and takes none.
    assert CALIBRATE.key(_with(frame, restitution=0.5)) == CALIBRATE.key(frame)


@pytest.mark.parametrize("served", [True, False])
def test_transient_depends_on_the_dampings_that_it_serves(frame, served):
    known = TRANSIENT.key(_serving(frame, served))
    lighter = TRANSIENT.key(_serving(_with(frame, stiffness_coefficient=1e-4), served))
    assert (lighter != known) == served
    assert TRANSIENT.key(_serving(_with(frame, restitution=0.5), served)) == known
    assert TRANSIENT.key(_serving(frame, not served)) != known


@pytest.mark.parametrize("spread", ["uniform", "calibrated"])
def test_members_depend_on_the_impact_that_spreads_their_forces(spread):
    case = load_case(GEOMETRY / "npp_pair.toml")
    laws = {
        name: law.model_copy(update={"stiffness": 1e10, "restitution": 0.6, "tension": True})
        for name, law in case.contact_laws.items()
    }
    if case.transient is None or case.wall_impact is None:
        raise ValueError("the case has no 3D model before a wall")
    transient = case.transient.model_copy(update={"spread": spread})
    case = case.model_copy(update={"transient": transient, "contact_laws": laws})
    wall = case.wall_impact.model_copy(update={"displacement": 2.0 * case.wall_impact.displacement})
    other = case.model_copy(update={"wall_impact": wall})
    assert (members_key(building_of(other)) != members_key(building_of(case))) == (
        spread == "calibrated"
    )


def test_sticks_of_the_case_itself_depend_on_none(case):
    assert POUNDING.key(case.model_copy(update={"damping_cases": ()})) == POUNDING.key(case)


def _with_part_damping(case, ratio):
    if case.structure is None:
        raise ValueError("the case has no structure")
    damping = (PartDamping(parts=("*",), ratio=ratio, frequencies=(1.0, 20.0)),)
    structure = case.structure.model_copy(update={"damping": damping})
    transient = Transient(time_step=1e-3, solver="full")
    return case.model_copy(update={"structure": structure, "transient": transient})


def test_damping_by_part_is_that_of_the_response():
    """Modes, and what is made of matrices without damping, do not depend on it."""
    case = load_case(GEOMETRY / "frame.toml")
    one, other = (_with_part_damping(case, ratio) for ratio in (0.02, 0.03))
    assert TRANSIENT.key(one) != TRANSIENT.key(other)
    assert BUILDING.key(one) == BUILDING.key(other) == BUILDING.key(case)
    assert model_key(building_of(one)) == model_key(building_of(other))


def test_buildings_are_those_of_another_3d_model(tmp_path):
    finer = tmp_path / "finer.toml"
    extended = f'extends = "{GEOMETRY / "npp_pair.toml"}"\n'
    finer.write_text(extended + "[buildings.B1.structure]\nmodes = 21\n", encoding="utf-8")
    one, other = load_case(GEOMETRY / "npp_pair.toml"), load_case(finer)
    assert inputs_key(one, ("buildings",)) == inputs_key(other, ("buildings",))
    assert inputs_key(one, ("structure",)) != inputs_key(other, ("structure",))


def test_tolerances_are_those_of_the_reference(case):
    assert tolerances(case) == {}
    paper = load_case(GEOMETRY / "npp_pair.toml")
    found = tolerances(paper)
    assert found["sticks.B1.frequency.1"] == 0.015
    # Every target of the calibration has one, so that its check can be met or missed.
    for target in paper.calibration.targets:
        for kind in ("frequency", "effective_mass"):
            assert f"sticks.{target.building}.{kind}.{target.mode}" in found


def test_an_ensemble_is_compared_with_what_it_may_miss():
    """Not with the peak that all its motions are scaled to, nor with what the sticks are fitted."""
    found = published_results(load_case(GEOMETRY / "npp_pair.toml"))
    assert {"pounding.peak_force.floor_8", "motion.sa_max", "frs.floor_8.peak"} <= found.keys()
    assert not {"motion.pga", "sticks.B1.frequency.1", "transient.wave_speed"} & found.keys()


@pytest.fixture
def program(tmp_path, monkeypatch):
    """The key of a program of one module, in a new process each time."""
    (tmp_path / "__init__.py").touch()
    monkeypatch.setattr(inputs.impactfem, "__file__", str(tmp_path / "__init__.py"))
    yield lambda text: (tmp_path / "steel.py").write_text(text) and program_key.__wrapped__()


def test_the_sources_of_the_program_count(program, monkeypatch):
    first = program("E = 2.1e11")
    assert program("E = 2.1e11") == first != program("E = 2.0e11")
    monkeypatch.setattr(inputs.impactfem, "__version__", "other")
    assert program("E = 2.1e11") != first


def test_capacities_change_no_stage():
    """The paper's case with capacities computes nothing again; a lighter device would."""
    without, having = (
        load_case(GEOMETRY / name) for name in ("npp_pair.toml", "npp_pair_anchors.toml")
    )
    assert DEVICE.key(having) == DEVICE.key(without)
    assert POUNDING.key(having) == POUNDING.key(without)
    assert DEVICE.drawing_key(having) == DEVICE.drawing_key(without)
    (pump,) = without.devices
    lighter = without.model_copy(update={"devices": (pump.model_copy(update={"mass": 1e3}),)})
    assert DEVICE.key(lighter) != DEVICE.key(without)
