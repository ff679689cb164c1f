"""What the stage `reduce` makes of a case."""

from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.floor import contact_edge
from impactfem.building.from_case import read_parts
from impactfem.case import RayleighDamping, load_case
from impactfem.case.calibration import WallImpactSetup
from impactfem.case.damping import RayleighCase
from impactfem.case.transient import Transient
from impactfem.stages.calibrate import compute as calibrate
from impactfem.stages.reduce import compute as stage
from impactfem.stages.reduce.compute import accuracies, prepare
from impactfem.stages.reduce.stage import model_key, take_model
from impactfem.stages.reduce.store import MODEL
from impactfem.system.errors import InputError
from impactfem.system.files import write_archive
from one_building import building_of
from two_models import WALL, write_case

GEOMETRY = Path(__file__).parents[3] / "geometry"


@pytest.fixture(scope="module")
def case():
    """The shipped frame in front of a wall."""
    wall = WallImpactSetup(
        building="F",
        floors=(1, 2),
        displaced_floor=2,
        gap=0.01,
        displacement=-0.02,
        duration=1.3,
        time_step=1e-3,
    )
    return load_case(GEOMETRY / "frame.toml").model_copy(update={"wall_impact": wall})


def test_a_clamped_floor_cannot_be_held_as_a_whole(case, monkeypatch):
    """A mesh whose floor 2 is clamped at one node: a load can draw it aside, holding it cannot."""
    parts, masses = read_parts(building_of(case), GEOMETRY / "frame.msh")
    slab = parts.mesh.triangles[parts.mesh.slab(2)]
    mesh = replace(parts.mesh, base=np.union1d(parts.mesh.base, slab[0, :1]))
    clamped = replace(parts, mesh=mesh)
    monkeypatch.setattr(stage, "read_parts", lambda *_: (clamped, masses))
    with pytest.raises(InputError, match=r"wall_impact.pull.*1 of"):
        prepare(building_of(case), GEOMETRY / "frame.msh", 0.5)
    loaded = case.wall_impact.model_copy(update={"pull": "even_load"})
    prepared = prepare(
        building_of(case.model_copy(update={"wall_impact": loaded})), GEOMETRY / "frame.msh", 0.5
    )
    assert prepared.plan.wall.pull == "even_load"


@pytest.mark.parametrize(
    ("served", "ratios", "lightest"),
    [
        (True, ("0.5 %", "9 %"), 0.005),
        (True, ("9 %", "0.5 %"), 0.005),
        (True, ("9 %", "8 %"), 0.05),  # the building's own
        (False, ("0.5 %", "9 %"), 0.05),
    ],
)
def test_lightest_damping(case, served, ratios, lightest):
    dampings = [
        RayleighCase(name=name, ratio=ratio, frequencies=(1.0, 20.0))
        for name, ratio in zip(("first", "second"), ratios, strict=True)
    ]
    transient = Transient(time_step=1e-3, serve_damping_cases=served)
    update = {"damping_cases": tuple(dampings), "transient": transient, "wall_impact": None}
    case = case.model_copy(update=update)
    ξ = RayleighDamping(ratio=lightest, frequencies=(1.0, 20.0))
    [first] = accuracies(building_of(case))
    assert astuple(first.damping) == pytest.approx(astuple(ξ.rayleigh), rel=1e-14)
    assert (first.maximum_frequency, first.tolerance) == (450.0, 0.001)


def test_what_helps_where_the_basis_is_not_accurate_enough(case):
    """Keys of a section are named only where the case has it, and where they do help."""
    [alone] = accuracies(building_of(case))
    assert "1200" in alone.remedy and "largest_basis" in alone.remedy
    transient = Transient(time_step=1e-3)
    own, wall = accuracies(building_of(case.model_copy(update={"transient": transient})))
    assert "transient.largest_basis" in wall.remedy
    assert "transient.maximum_frequency" in own.remedy


def test_a_floor_without_an_edge(case):
    transient = Transient(time_step=1e-3, floors=(1, 3))
    asked = case.model_copy(update={"transient": transient})
    match = r"transient\.floors = \[1, 3\]: floor 3 has no edge .*, which has 1, 2"
    with pytest.raises(InputError, match=match):
        prepare(building_of(asked), GEOMETRY / "frame.msh", 0.5)
    served = case.model_copy(update={"transient": Transient(time_step=1e-3, floors=(2,))})
    plan = prepare(building_of(served), GEOMETRY / "frame.msh", 0.5).plan
    assert plan.loads == ("ground y", "floor 2", "push", "floor 1")
    assert plan.wall is not None and plan.wall.floors == (1, 2)


def test_what_the_vectors_depend_on(case):
    """On the shift; accuracy and the names of patterns are looked at when they are used again."""

    def key(**asked):
        transient = Transient(time_step=1e-3, **asked)
        return model_key(building_of(case.model_copy(update={"transient": transient})))

    assert key() != key(shift=40.0)
    assert key() == key(tolerance=0.002, maximum_frequency=500.0, duration=1.0)


def test_the_points_of_contact_are_those_of_both_stages(case):
    """At the vertices of the mesh, and fewer; a basis for these is another one."""
    mesh_file = GEOMETRY / "frame.msh"
    counts, keys = [], set()
    for spacing in (None, 2.0):
        wall = case.wall_impact.model_copy(update={"contact_spacing": spacing})
        asked = case.model_copy(update={"wall_impact": wall})
        plan = prepare(building_of(asked), mesh_file, 0.5).plan
        mesh = read_parts(building_of(case), mesh_file)[0].mesh
        edges = [contact_edge(mesh, floor, plan.wall.spacing) for floor in plan.wall.floors]
        made = calibrate.prepare(building_of(asked), mesh_file)
        assert np.array_equal(made.position, np.concatenate([edge.position for edge in edges]))
        assert np.array_equal(made.length, np.concatenate([edge.weight for edge in edges]))
        counts.append(len(made.position))
        keys.add(model_key(building_of(asked)))
    assert counts[0] > counts[1] > 4 and len(keys) == 2


def test_the_reduced_building_of_another_run(tmp_path):
    """The largest with the same 3D model, for another damping as well; not that of another mesh."""
    case = load_case(write_case(tmp_path / "case", WALL))
    b = case.modelled["B"]
    for name, key, size in (("few", model_key(b), 2), ("many", model_key(b), 9), ("other", "", 99)):
        (tmp_path / name / "B").mkdir(parents=True)
        write_archive(tmp_path / name / "B" / MODEL, key, {"vectors": np.zeros(size)})
    others = [tmp_path / name for name in ("few", "many", "other", "none")]
    lighter = replace(b, case=case.model_copy(update={"damping_cases": ()}))
    assert take_model(lighter, tmp_path / "new", others) == tmp_path / "many"
    copied = (tmp_path / "new" / "B" / MODEL).read_bytes()
    assert copied == (tmp_path / "many" / "B" / MODEL).read_bytes()
    # What is there stays; the other building has another one.
    assert take_model(b, tmp_path / "new", others[:1]) is None
    assert take_model(case.modelled["A"], tmp_path / "new", others) is None
