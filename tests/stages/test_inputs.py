"""What the stages depend on: sections of the case, and what counts of the program's sources."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.damping import PartDamping, RayleighCase
from impactfem.case.transient import Transient
from impactfem.run.stages import STAGES
from impactfem.stages import inputs
from impactfem.stages.building.stage import BUILDING
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.design.stage import members_key
from impactfem.stages.ensemble import stage as ensemble
from impactfem.stages.inputs import imported_by, inputs_key, program_key, tolerances
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import model_key
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.system.errors import ImpactfemError

GEOMETRY = Path(__file__).parents[2] / "geometry"
LIGHT = RayleighCase(name="light", mass_coefficient=0.8, stiffness_coefficient=2e-4)


@pytest.fixture(scope="module")
def case(new_case, tmp_path_factory):
    return _with(load_case(new_case(tmp_path_factory.mktemp("inputs"))))


def _with(case, **changes):
    """The case with one damping case, changed."""
    one = LIGHT.model_copy(update=changes)
    return case.model_copy(update={"damping_cases": (one,)})


def _serving(case, served):
    transient = Transient(time_step=1e-3, serve_damping_cases=served)
    return case.model_copy(update={"transient": transient})


@pytest.mark.parametrize("sections", [("contact_laws", "damping_cases"), ("damping_cases",)])
def test_restitution_counts_with_the_contact_laws(case, sections):
    other = inputs_key(_with(case, restitution=0.5), sections, ())
    assert (other == inputs_key(case, sections, ())) == ("contact_laws" not in sections)
    lighter = inputs_key(_with(case, stiffness_coefficient=1e-4), sections, ())
    assert lighter != inputs_key(case, sections, ())


def test_calibration_depends_on_the_dampings(case):
    assert CALIBRATE.key(_with(case, stiffness_coefficient=1e-4)) != CALIBRATE.key(case)
    assert CALIBRATE.key(case.model_copy(update={"damping_cases": ()})) != CALIBRATE.key(case)
    # It gives a restitution, and takes none.
    assert CALIBRATE.key(_with(case, restitution=0.5)) == CALIBRATE.key(case)


@pytest.mark.parametrize("served", [True, False])
def test_transient_depends_on_the_dampings_that_it_serves(case, served):
    known = TRANSIENT.key(_serving(case, served))
    lighter = TRANSIENT.key(_serving(_with(case, stiffness_coefficient=1e-4), served))
    assert (lighter != known) == served
    assert TRANSIENT.key(_serving(_with(case, restitution=0.5), served)) == known
    assert TRANSIENT.key(_serving(case, not served)) != known


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
    assert (members_key(other) != members_key(case)) == (spread == "calibrated")


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
    assert model_key(one) == model_key(other)


def test_buildings_are_those_of_another_3d_model(tmp_path):
    finer = tmp_path / "finer.toml"
    extended = f'extends = "{GEOMETRY / "npp_pair.toml"}"\n'
    finer.write_text(extended + "[buildings.B1.structure]\nmodes = 21\n", encoding="utf-8")
    one, other = load_case(GEOMETRY / "npp_pair.toml"), load_case(finer)
    assert inputs_key(one, ("buildings",), ()) == inputs_key(other, ("buildings",), ())
    assert inputs_key(one, ("structure",), ()) != inputs_key(other, ("structure",), ())


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
    found = ensemble._published(load_case(GEOMETRY / "npp_pair.toml"))
    assert {"pounding.peak_force.floor_8", "motion.sa_max", "frs.floor_8.peak"} <= found.keys()
    assert not {"motion.pga", "sticks.B1.frequency.1", "transient.wave_speed"} & found.keys()


STEEL = '''"""Of steel."""

from impactfem.girder import E

def stress(strain: float) -> float:
    """Hooke."""
    return E * strain  # [Pa]
'''
GIRDER = "E = 2.1e11\n"


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The folder in which what was read of sources is kept, a new one."""
    (tmp_path / "kept").mkdir()
    monkeypatch.setattr(inputs, "cache_folder", lambda name: tmp_path / "kept")
    yield tmp_path / "kept"
    _forget()


def _forget():
    """As another process."""
    for cached in (program_key, inputs._file, inputs._module, inputs._known):
        cached.cache_clear()


@pytest.fixture
def key(tmp_path, monkeypatch, kept):
    """The key of a small program of two modules, in a process of its own each time."""
    monkeypatch.setattr(inputs, "ROOT", tmp_path)

    def of(steel=STEEL, girder=GIRDER):
        _forget()
        (tmp_path / "steel.py").write_text(steel, encoding="utf-8")
        (tmp_path / "girder.py").write_text(girder, encoding="utf-8")
        return program_key(("steel",))

    return of


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[Pa]", "pascal"),
        ("Of steel", "Of any metal"),
        ("Hooke.", "Robert Hooke."),
        ("    return", "\n    return"),
    ],
)
def test_comments_docstrings_and_layout_do_not_count(key, old, new):
    assert old in STEEL
    assert key(STEEL.replace(old, new)) == key()


def test_statements_count_and_those_of_what_is_imported(key):
    assert key(STEEL.replace("E * strain", "E * strain / 2")) != key()
    assert key(girder="E = 2.0e11\n") != key()


def test_an_import_in_a_function_counts(key):
    within = STEEL.replace("from impactfem.girder import E\n", "").replace(
        "    return", "    from impactfem.girder import E\n    return"
    )
    assert key(within, "E = 2.0e11\n") != key(within)


def test_sources_are_read_once(key, kept, monkeypatch):
    first = key()
    with monkeypatch.context() as only_kept:
        only_kept.setattr(inputs, "ast", None)
        assert key() == first
        with pytest.raises(AttributeError):
            key(girder="E = 2.0e11\n")
    (path,) = kept.iterdir()
    for damaged in ("", "[]", '{"steel": 1}', '{"steel": ["a", "b"]}'):
        path.write_text(damaged, encoding="utf-8")
        assert key() == first
    assert "girder" in path.read_text(encoding="utf-8")


def test_without_a_folder_sources_are_read_each_time(key, monkeypatch):
    def nowhere(name):
        raise ImpactfemError("no folder can be written")

    first = key()
    monkeypatch.setattr(inputs, "cache_folder", nowhere)
    assert key() == first


def test_a_module_that_is_not_there(key):
    key()
    with pytest.raises(ValueError, match="no module timber"):
        program_key(("timber",))


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_who_computes_does_not_draw(stage):
    """So that an edited figure computes nothing again; the solvers count where they are used."""
    computing = imported_by(stage.modules)
    assert not {name for name in computing if name.split(".")[-1] in ("figures", "tables")}
    assert not {name for name in computing if name.split(".")[0] in ("plot", "report", "run")}
    assert f"stages.{stage.name}.compute" in computing and "case.model" in computing
    assert not stage.drawn_by or "plot.style" in imported_by(stage.drawing_modules)
