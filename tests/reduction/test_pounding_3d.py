"""3D models that pound: with each other, with walls, sticks and their mirror images."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid

import impactfem.building.read_mesh as read_mesh_module
from impactfem.building.facade import facades
from impactfem.building.from_case import read_parts
from impactfem.building.mesh import outward_normal, rigid_body
from impactfem.building.model import assemble_building
from impactfem.building.read_mesh import read_mesh
from impactfem.case import load_case
from impactfem.case.analysis import Pounding
from impactfem.case.contacts import KelvinVoigtLaw
from impactfem.case.soil import HalfSpaceSoil, Raft
from impactfem.coupling.force_history import ForceHistory, read_forces, write_forces
from impactfem.coupling.from_case import system_of
from impactfem.coupling.ground import Ground
from impactfem.coupling.impacts import impacts
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.laws import Hertz, KelvinVoigt
from impactfem.coupling.links import Assembly
from impactfem.coupling.massless import MasslessPoints, massless_response
from impactfem.coupling.modal_motion import ModalMotion, body_before_walls
from impactfem.coupling.pounding import End, Load, simulate
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.columns import combined
from impactfem.dynamics.factorisation import Factorisation
from impactfem.reduction.contact_line import LineEnd, contact_lines
from impactfem.reduction.edge_force import EdgeForce, even, inward
from impactfem.reduction.forces import checked_forces
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.pounding_3d import Pounding3D
from impactfem.reduction.reduced_building import FURTHER_SHIFTS, SMOOTH_RESPONSES, reduce_building
from impactfem.run import loop
from impactfem.stages.building.compute import mesh_of_run
from impactfem.stages.reduce.compute import prepare
from impactfem.stages.reduce.stage import models_of_run, storey_factor
from impactfem.system.parallel import communicator
from no_pictures import no_pictures
from two_models import in_3d

from .test_pounding_3d_exact import body as model_of

STEP = 5e-4


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """The case, its sticks and its reduced 3D models."""
    folder = tmp_path_factory.mktemp("in_3d")
    path = in_3d(folder)
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        loop.run(path, out=folder / "out", stage="reduce")
    case = load_case(path)
    return case, system_of(case, None), models_of_run(case, folder / "out"), folder / "out"


@pytest.fixture
def shaken():
    """Half a second of ground motion along y."""
    t = STEP * np.arange(1001)
    return np.outer(
        4.0 * np.sin(2.0 * np.pi * 3.0 * t) * np.sin(np.pi * t / t[-1]), [0.0, 1.0, 0.0]
    )


def with_law(case, law):
    """The case with another contact law."""
    laws = {"floor": KelvinVoigtLaw.model_construct(**law, type="kelvin-voigt")}
    return case.model_copy(update={"contact_laws": laws})


def with_scheme(case, scheme):
    """The case with another scheme of unilateral contact."""
    changed = case.pounding.model_copy(update={"unilateral_scheme": scheme})
    return case.model_copy(update={"pounding": changed})


def on_soil(case, speed=200.0):
    """The case with both buildings on rafts on a half-space."""
    raft = Raft(length=6.0, width=4.0, thickness=0.5, mass=3e4)
    soil = HalfSpaceSoil(
        raft=raft, type="half-space", shear_velocity=speed, density=2000.0, poisson_ratio=0.3
    )
    buildings = [one.model_copy(update={"soil": soil}) for one in case.buildings]
    return case.model_copy(update={"buildings": tuple(buildings)})


AT_WALL = Pounding.model_construct(models={"A": "structure"}, time_step=STEP)
SMOOTH = {"stiffness": 5e8, "restitution": 0.5, "damping_ratio": None, "tension": False}


def test_one_with_its_mirror_image_is_one_before_a_wall(pair):
    """Every force, unilateral and by two laws; with another gap or another law it is not."""
    case, system, given, _ = pair
    mine, other = given.models["A"], mirrored(given)
    names = [str(name) for name in mine.names]
    both = Pounding3D(case, system, Models3D(given.lines, {"A": mine, "B": other}))
    one = both.assembly
    contact = -mine.edges[:, [names.index(f.name) for line in given.lines for f in line.a.forces]]
    # Drawn aside, away from the wall, as by an even push.
    z0 = contact.sum(axis=1) / mine.eigenvalue
    z0 *= -0.01 / (contact.T @ z0).max()
    law = case.building("A").damping.law
    r, steps = len(z0), 1000
    # As the wall of a case: B, a stick then, touches nothing.
    walls = tuple(one.model_copy(update={"b": None, "wall": "pit"}) for one in case.contacts)
    alone = case.model_copy(update={"contacts": walls, "pounding": AT_WALL})
    lines = tuple(replace(line, b=None) for line in given.lines)
    in_pit = Pounding3D(alone, system_of(alone, None), Models3D(lines, {"A": mine}))
    pit = in_pit.assembly
    at_rest = np.concatenate([z0, np.zeros(len(pit) - r)])

    def before_wall(gap):
        wall = body_before_walls(mine.eigenvalue, contact, law)
        force = unilateral_response(ModalMotion(wall, STEP), gap, steps, displacement=z0).force
        motion = ModalMotion(pit, STEP)
        of_case = unilateral_response(motion, gap, steps, displacement=at_rest).force
        assert np.abs(of_case - force).max() < 1e-9 * force.max()
        return force

    motion = ModalMotion(one, STEP)
    found = unilateral_response(motion, one.gaps, steps, displacement=np.tile(z0, 2))
    expected = before_wall(one.gaps / 2.0)
    largest = expected.max()
    assert np.count_nonzero(expected) > 20
    assert np.abs(found.force - expected).max() < 1e-8 * largest
    assert np.abs(found.force - before_wall(one.gaps)).max() > 0.1 * largest
    # Without mass at the points, the flexibility of both is twice that of one.
    points, start = both.massless_points, np.tile(z0, 2)
    motion = ModalMotion(points.assembly, STEP)
    options = {"compliance": both.compliance, "displacement": start}
    found = massless_response(points, motion, steps, **options).force
    options = {"compliance": in_pit.compliance, "displacement": at_rest}
    for factor in (0.5, 1.0):
        links = [replace(link, gap=factor * link.gap) for link in pit.links]
        wall = Assembly(list(pit.bodies.values()), links)
        points = MasslessPoints.of(wall, {"A": points.corner**2})
        motion = ModalMotion(points.assembly, STEP)
        force = massless_response(points, motion, steps, **options).force
        apart = np.abs(found - force).max() / found.max()
        assert apart < 1e-8 if factor == 0.5 else apart > 0.1
    # F(p) between both is F(2 p) at the wall.
    none = np.zeros((steps, 3))

    def between(law_of_pair):
        links = [replace(link, law=law_of_pair) for link in one.links]
        pounding = Assembly(list(one.bodies.values()), links)
        return respond(
            pounding, np.zeros((steps, 2 * r)), none, STEP, start=Start(np.tile(z0, 2))
        ).force

    def at_wall(law_of_wall):
        links = [replace(link, gap=link.gap / 2.0, law=law_of_wall) for link in pit.links]
        wall = Assembly(list(pit.bodies.values()), links)
        return respond(wall, np.zeros((steps, len(pit))), none, STEP, start=Start(at_rest)).force

    for make, factor in (
        (lambda k: KelvinVoigt(k * 1e8, 0.1, mass=1e4 * k, tension=False), 2.0),
        (lambda k: Hertz(k * 1e10, mass=1e4), 2.0**1.5),
    ):
        F, expected = between(make(1.0)), at_wall(make(factor))
        assert np.abs(F - expected).max() < 1e-8 * np.abs(expected).max()
        assert np.abs(F - at_wall(make(1.0))).max() > 0.01 * np.abs(expected).max()


def mirrored(given):
    """The model of A, and as B its mirror image."""
    mine, mirror = given.models["A"], []
    for line in given.lines:
        columns = {f.name: k for k, f in enumerate(line.a.forces)}
        assert len(columns) == len(line.b.forces)
        mirror += zip((f.name for f in line.b.forces), (f.name for f in line.a.forces), strict=True)
    names = [str(name) for name in mine.names]
    at = [names.index(of_a) for _, of_a in mirror]
    of_b = np.array([of_b for of_b, _ in mirror])
    return replace(mine, names=of_b, edges=mine.edges[:, at], wrench=mine.wrench[at])


@pytest.mark.parametrize("scheme", ["massless", "moreau"])
def test_on_soil_one_with_its_mirror_image_is_one_before_a_wall(pair, scheme):
    """Both rafts move; with another gap, or before the wall without soil, it is another run."""
    case, _, given, _ = pair
    case = with_scheme(on_soil(case), scheme)
    mine, steps = given.models["A"], 1000
    models = {"A": mine, "B": mirrored(given)}
    both = Pounding3D(case, system_of(case, None), Models3D(given.lines, models))
    contact = both.assembly.gamma[:, : len(mine.eigenvalue)].T
    z0 = contact.sum(axis=1) / mine.eigenvalue
    z0 *= 0.01 / (contact.T @ z0).max()
    base = np.zeros(6)

    def force(pounding, start, factor=1.0):
        if scheme == "moreau":
            motion = ModalMotion(pounding.assembly, STEP)
            gaps = factor * pounding.assembly.gaps
            return unilateral_response(motion, gaps, steps, displacement=start).force
        links = [replace(one, gap=factor * one.gap) for one in pounding.assembly.links]
        shifts = dict.fromkeys(pounding._given.models, pounding.massless_points.corner**2)
        wall = Assembly(list(pounding.assembly.bodies.values()), links)
        points = MasslessPoints.of(wall, shifts)
        options = {"compliance": pounding.compliance, "displacement": start}
        motion = ModalMotion(points.assembly, STEP)
        return massless_response(points, motion, steps, **options).force

    found = force(both, np.concatenate([z0, base, z0, base]))
    assert np.count_nonzero(found) > 20
    walls = tuple(one.model_copy(update={"b": None, "wall": "pit"}) for one in case.contacts)
    alone = case.model_copy(update={"contacts": walls, "pounding": with_scheme_at_wall(scheme)})
    lines = tuple(replace(line, b=None) for line in given.lines)
    for soil, factor in ((True, 0.5), (True, 1.0), (False, 0.5)):
        one = alone if soil else alone.model_copy(update={"buildings": pair[0].buildings})
        pit = Pounding3D(one, system_of(one, None), Models3D(lines, {"A": mine}))
        start = np.zeros(len(pit.assembly))
        start[: len(z0)] = z0
        apart = np.abs(force(pit, start, factor) - found).max() / found.max()
        assert apart < 1e-8 if soil and factor == 0.5 else apart > 0.01


def with_scheme_at_wall(scheme):
    """The section [pounding] of A before a wall."""
    return AT_WALL.model_copy(update={"unilateral_scheme": scheme})


@pytest.mark.parametrize("stick", [False, True])
@pytest.mark.parametrize("law", ["massless", "moreau", "smooth"])
def test_on_soil_energies_balance_under_waves_that_pass(pair, shaken, law, stick):
    """With what both rafts radiate, in each step; also of a stick beside a 3D model."""
    case, _, given, _ = pair
    case = on_soil(with_law(case, SMOOTH) if law == "smooth" else with_scheme(case, law))
    if stick:
        pounding = case.pounding.model_copy(update={"models": {"A": "structure"}})
        case = case.model_copy(update={"pounding": pounding})
        given = replace(given, models={"A": given.models["A"]})
    response = Pounding3D(case, system_of(case, None), given).respond(later(shaken), STEP)
    energy = response.energy
    assert response.force.max() > 1e5 and response.residual < 1e-10
    assert energy.residual < 1e-10
    assert energy.radiated[-1] > 1e-3 * energy.scale
    assert np.diff(energy.radiated).min() >= 0.0
    # Without mass at the points, buildings move a little otherwise than with all of their mass.
    radiated = sum(base.radiated for base in response.bases.values())
    most = 1e-3 if law == "massless" else 1e-8
    assert radiated == pytest.approx(energy.radiated, abs=most * energy.radiated[-1])


@pytest.mark.parametrize("law", ["massless", "moreau", "smooth"])
def test_very_stiff_soil_is_a_clamped_base(pair, shaken, law):
    """To 1e-6 of forces and motions at 1e7 m/s; at 1e4 m/s it is not."""
    case, _, given, _ = pair
    case = with_law(case, SMOOTH) if law == "smooth" else with_scheme(case, law)

    def run(one):
        return Pounding3D(one, system_of(one, None), given).respond(shaken, STEP)

    clamped, stiff, soft = run(case), run(on_soil(case, 1e7)), run(on_soil(case, 1e4))
    for name in ("force", "u", "absolute_acceleration"):
        expected = getattr(clamped, name)
        size = np.abs(expected).max()
        assert np.abs(getattr(stiff, name) - expected).max() < 1e-6 * size, name
        assert np.abs(getattr(soft, name) - expected).max() > 1e-6 * size, name


@pytest.mark.parametrize("scheme", ["massless", "moreau"])
def test_what_is_reported_of_a_run_under_waves_that_pass(pair, shaken, scheme):
    """Complementary, energies in balance; the gap without contact until they touch, no other."""
    case, system, given, _ = pair
    case = with_scheme(case, scheme)
    model, ground = Pounding3D(case, system, given), later(shaken)
    response, free = model.respond(ground, STEP), model.free(ground, STEP)
    assert response.residual < 1e-10 and response.energy.residual < 1e-10
    # A wall that moves with changing speed gives a little: its way is exact, not the scheme's.
    most = 1e-7 if scheme == "moreau" else 1e-3
    assert np.max(np.diff(response.energy.contact)) < most * response.energy.scale
    first = int(response.force.any(axis=1).argmax())
    assert first > 100
    reach = np.abs(free.gap[:first]).max()
    # A mode of 4 Hz moves points without mass above 810 Hz less by ½ (4/810)².
    within = 1e-9 if scheme == "moreau" else 1e-4
    assert np.abs(response.gap - free.gap)[:first].max() < within * reach
    alike = model.free(shaken, STEP)
    assert np.abs(alike.gap - free.gap)[:first].max() > 1e-2 * reach


@pytest.mark.parametrize("smooth", [False, True])
def test_where_a_pair_is_along_its_line_changes_nothing(pair, shaken, smooth):
    """It says where the sides are; law and reported speeds are those at the middle of the line."""
    case, _, given, _ = pair

    def moved(point):
        x, y, z = point.offset
        return point.model_copy(update={"offset": (x - 1.5, y, z)})

    aside = [one.model_copy(update={"a": moved(one.a), "b": moved(one.b)}) for one in case.contacts]
    other, found = case.model_copy(update={"contacts": tuple(aside)}), []
    for one in (case, other):
        one = with_law(one, SMOOTH) if smooth else one
        pounding = Pounding3D(one, system_of(one, None), given)
        found.append((pounding, pounding.respond(shaken, STEP)))
    (first, response), (second, again) = found
    assert response.force.max() > 0.0
    np.testing.assert_allclose(again.force, response.force, atol=1e-9 * response.force.max())
    np.testing.assert_allclose(again.gap_rate, response.gap_rate, atol=1e-12)
    for a, b in zip(first.system.pairs, second.system.pairs, strict=True):
        assert a.law.mass == pytest.approx(b.law.mass, rel=1e-12)
    # The sticks' pairs are where the case has them.
    masses = [system_of(one, None).pairs[0].law.mass for one in (case, other)]
    assert masses[1] < 0.9 * masses[0]


@pytest.mark.parametrize("every", [1, 4])
def test_the_least_gap_of_floors_that_turn_is_at_the_ends(pair, every):
    """By whatever points of contact: those of the outermost are means inside the ends."""
    case, system, given, _ = pair
    model = Pounding3D(case, system, given, every=every)
    assert (len(model.points) < 3 * len(given.lines)) == (every == 4)
    turns = np.array([1e-3, -2e-3])
    along = np.array([point.a.offset[0] for point in model.points])
    gap = 0.01 + turns[:, None] * along  # of a rigid floor, at the middle of each hat
    for k, line in enumerate(given.lines):
        ends = line.a.point.offset[0] - line.position[[0, -1]] * line.normal[1]
        least = 0.01 + np.min(turns[:, None] * ends, axis=1)
        assert model._least(gap, ends=True)[:, k] == pytest.approx(least, rel=1e-12)
        assert np.all(model._least(gap)[:, k] > least + 1e-5)
    # At rest the gap is known there, also where it is not the same along the line.
    sloping = [replace(one, gap=0.01 + 1e-3 * one.position) for one in given.lines]
    model = Pounding3D(case, system, replace(given, lines=tuple(sloping)), every=every)
    rest = np.array([point.gap for point in model.points])
    found = model._least(rest + turns[:, None] * along, ends=True)
    for k, line in enumerate(sloping):
        ends = line.a.point.offset[0] - line.position[[0, -1]] * line.normal[1]
        least = np.min(line.gap[[0, -1]] + turns[:, None] * ends, axis=1)
        assert found[:, k] == pytest.approx(least, rel=1e-12)
        # Both extrapolated would be less than what is there.
        assert (rest @ model._contacts.ends.T).reshape(-1, 2)[k].min() < line.gap.min() - 1e-5


def test_the_closure_without_contact_does_not_depend_on_the_gap(pair, shaken):
    """One run without contact serves all gaps of a study."""
    case, system, given, _ = pair
    wider = tuple(replace(one, gap=one.gap + 0.01) for one in given.lines)
    free = [
        Pounding3D(case, system, replace(given, lines=lines)).free(shaken, STEP)
        for lines in (given.lines, wider)
    ]
    closed = [one.closed(system.pairs) for one in free]
    assert closed[0].max() > 1e-4
    np.testing.assert_allclose(closed[1], closed[0], atol=1e-12)


@pytest.mark.parametrize("scheme", ["massless", "moreau"])
def test_what_is_reported_of_a_run(pair, shaken, scheme):
    """Complementary, energies in balance, resultants and impulses those of the points."""
    case, system, given, _ = pair
    case = with_scheme(case, scheme)
    response = Pounding3D(case, system, given).respond(shaken, STEP)
    assert response.residual < 1e-10
    assert response.energy.residual < 1e-10
    lost = -response.energy.contact[-1] / response.energy.scale
    if scheme == "moreau":
        assert np.max(np.diff(response.energy.contact)) <= 1e-12 * response.energy.scale
        assert lost > 0.01
    else:
        assert abs(lost) < 2e-3
        assert response.gap.min() > -1e-12
    points, force = response.exerted
    assert len(points) == sum(map(len, given.lines)) > len(given.lines)
    for k, line in enumerate(given.lines):
        mine = [j for j, point in enumerate(points) if point.name.startswith(f"{line.name} at ")]
        assert np.allclose(force[:, mine].sum(axis=1), response.force[:, k])
    found = impacts(response)
    assert found
    assert 0.0 < found[0].restitution < 1.0
    taken = sum(impact.dissipated for impact in found)
    assert taken == pytest.approx(-response.energy.contact[-1], rel=1e-6)
    defect = sum(impact.defect for impact in found)
    assert defect == pytest.approx(0.0 if scheme == "moreau" else taken, abs=1e-6 * abs(taken))
    assert found[0].peak_force == response.largest_forces.max(axis=0)[found[0].index] or found[1:]
    # The scheme stops what closes: it goes no further behind than in a step or two.
    assert -response.gap.min() < 2.0 * np.abs(np.diff(response.gap, axis=0)).max()
    # What is handed on has the impulses of the steps, and begins and ends with them.
    one, n = Pounding3D(case, system, given), len(shaken) - 1
    if scheme == "moreau":
        motion = ModalMotion(one.assembly, STEP, load=one.assembly.ground)
        steps = unilateral_response(motion, one.assembly.gaps, n, amplitudes=shaken).impulse
    else:
        motion = ModalMotion(one.massless_points.assembly, STEP, load=one.assembly.ground)
        options = {"compliance": one.compliance, "amplitudes": shaken}
        steps = massless_response(one.massless_points, motion, n, **options).impulse
    handed = ForceHistory.of_response(response)
    assert (
        np.abs(trapezoid(handed.force, handed.time, axis=0) - steps.sum(axis=0)).max()
        < 1e-9 * steps.sum()
    )
    begins = steps.any(axis=1).argmax()
    assert handed.force.any(axis=1).argmax() == begins - 1


def test_the_largest_force_has_a_limit_for_short_steps(pair, shaken):
    """Without mass at the points of contact, and by Moreau's scheme it has none."""
    largest, impulses = {}, {}
    for scheme in ("massless", "moreau"):
        case, found = with_scheme(pair[0], scheme), []
        for parts in (1, 2, 4):
            t = np.linspace(0.0, 1.0, 1000 * parts + 1)
            ground = np.array([np.interp(t, np.linspace(0, 1, 1001), a) for a in shaken.T]).T
            end = 260 * parts
            run = Pounding3D(case, *pair[1:3]).respond(ground[:end], STEP / parts)
            found.append((run.largest_forces.max(), run.force.sum() * STEP / parts))
        largest[scheme], impulses[scheme] = np.array(found).T
    assert np.ptp(largest["massless"]) < 0.03 * largest["massless"][-1]
    assert largest["moreau"][-1] > 1.3 * largest["moreau"][0]
    assert impulses["massless"] == pytest.approx(impulses["massless"][-1], rel=0.03)


def test_double_steps_have_double_parts_in_contact(pair, shaken):
    """Half of the step keeps the length of the parts, and has half as many."""
    case = with_scheme(pair[0], "massless")
    in_3d, step = Pounding3D(case, *pair[1:3]), case.pounding.time_step
    parts = [in_3d.respond(shaken[:20], f * step).parts for f in (0.5, 1.0, 2.0)]
    assert parts[1] > 1 and parts[2] == parts[1]
    assert parts[0] == pytest.approx(0.5 * parts[1], abs=0.5)


@pytest.mark.parametrize("stiffness", ["rigid", 2e9, None])
def test_compliance_of_edges(pair, stiffness):
    case, system, given, _ = pair
    laws = {
        k: law.model_copy(update={"edge_stiffness": stiffness})
        for k, law in case.contact_laws.items()
    }
    model = Pounding3D(case.model_copy(update={"contact_laws": laws}), system, given)
    weight = np.concatenate([line.weight for line in given.lines])
    # Two slabs of 33 GPa, in series.
    local = 2.0 * 7.0 * 1.2020569 * (1.0 - 0.2**2) / (np.pi**3 * 33e9)
    expected = {"rigid": 0.0, None: local}.get(stiffness, 1.0 / 2e9)
    assert model.compliance == pytest.approx(expected / weight, rel=1e-7)


def test_siconos_gives_the_same(pair, siconos):
    """The first impact under a constant acceleration of the ground; with another gap it does not.

    What closes again from a little behind the edge is another law there: ours makes no energy.
    """
    case, system, given, _ = pair
    one, steps = Pounding3D(case, system, given).assembly, 600
    ground = np.tile([0.0, 8.0, 0.0], (steps + 1, 1))
    ours = unilateral_response(
        ModalMotion(one, STEP, load=one.ground), one.gaps, steps, amplitudes=ground
    ).impulse
    theirs = siconos(
        M=np.eye(len(one)),
        K=np.diag(one.eigenvalue),
        C=np.diag(one.damping),
        G=-one.gamma.T,
        gap=one.gaps,
        e=np.zeros(len(one.gaps)),
        h=STEP,
        u=np.zeros(len(one)),
        v=np.zeros(len(one)),
        f=one.ground @ ground[0],
        steps=steps,
    )["impulse"]
    touching = ours.any(axis=1)
    begin = int(touching.argmax())
    first = slice(0, begin + int((~touching[begin:]).argmax()) + 1)
    assert first.stop - begin > 5 and np.count_nonzero(ours[first].any(axis=0)) > 3
    assert np.abs(ours - theirs)[first].max() < 1e-8 * ours[first].max()
    wider = unilateral_response(
        ModalMotion(one, STEP, load=one.ground), 1.1 * one.gaps, steps, amplitudes=ground
    ).impulse
    assert np.abs(wider - theirs)[first].max() > 1e-2 * ours[first].max()


@pytest.mark.parametrize("soil", [False, True])
@pytest.mark.parametrize("law", [None, SMOOTH], ids=["unilateral", "smooth"])
def test_buildings_and_ends_of_pairs_change_places(pair, shaken, law, soil):
    """The forces are the same; another order is another order of sums, which contact amplifies."""
    case, _, given, _ = pair
    case = case if law is None else with_law(case, law)
    case = on_soil(case) if soil else case
    turned = []
    for contact in case.contacts:
        (a, b), (x, y, z) = (contact.b, contact.a), contact.normal
        turned.append(contact.model_copy(update={"a": a, "b": b, "normal": (-x, -y, -z)}))
    lines = tuple(replace(one, a=one.b, b=one.a, normal=-one.normal) for one in given.lines)
    other = case.model_copy(update={"contacts": tuple(turned), "buildings": case.buildings[::-1]})
    first = Pounding3D(case, system_of(case, None), given).respond(shaken, STEP)
    second = Pounding3D(other, system_of(other, None), replace(given, lines=lines)).respond(
        shaken, STEP
    )
    assert first.force.max() > 1e4
    assert np.abs(first.point_force - second.point_force).max() < 1e-10 * first.force.max()


AT_A = 'a = {{ building = "A", floor = [1, 2], offset = ["0 m", "{} m"'
AT_B = 'b = {{ building = "B", floor = [1, 2], offset = ["0 m", "{} m"'
ROUND = [
    ('axis = ["3 m", "2 m"]', 'axis = ["-3 m", "-2 m"]'),
    ('axis = ["3 m", "6.001 m"]', 'axis = ["-3 m", "-6.001 m"]'),
    (AT_A.format(2), AT_A.format(-2)),
    (AT_B.format(-2), AT_B.format(2)),
    ("normal = [0, 1, 0]", "normal = [0, -1, 0]"),
]


def test_the_pair_turned_by_180_degrees(pair, shaken, tmp_path, monkeypatch):
    """Both meshes turned about the origin, and reduced anew: what differs is the order of sums.

    With vectors whose direction is rounding it would be 1e-8. About another axis coordinates are
    rounded, which moves forces by 1e-11, by a law 1.3e-10.
    """
    case, _, given, out = pair
    turned = load_case(in_3d(tmp_path, *ROUND))
    of_file = read_mesh_module._read_mesh

    def turn(path, digest):
        mesh = of_file(path, digest)
        return replace(mesh, nodes=mesh.nodes * [-1.0, -1.0, 1.0])

    monkeypatch.setattr(read_mesh_module, "_read_mesh", turn)
    files = {name: mesh_of_run(one, one.folder(out)) for name, one in case.modelled.items()}
    models = {}
    for name, one in turned.modelled.items():
        folder = one.folder(out)
        prepared = prepare(one, files[name], storey_factor(folder), files)
        building = assemble_building(communicator(), prepared.parts)
        factor = prepared.storey_factor
        reduced = reduce_building(building, prepared.parts.mesh, factor, prepared.plan)
        models[name] = reduced.complete
    lines = contact_lines(turned, {name: read_mesh(file) for name, file in files.items()})
    for law, soil in itertools.product((None, SMOOTH), (False, True)):
        one, other = ((k if law is None else with_law(k, law)) for k in (case, turned))
        one, other = (on_soil(one), on_soil(other)) if soil else (one, other)
        expected = Pounding3D(one, system_of(one, None), given).respond(shaken, STEP).force
        opposite = Pounding3D(other, system_of(other, None), Models3D(lines, models))
        assert expected.max() > 1e5
        found = opposite.respond(-shaken, STEP).force
        assert np.abs(found - expected).max() < 1e-10 * expected.max()
        # Shaken the same way as before, the turned pair is another one.
        assert np.abs(opposite.respond(shaken, STEP).force - expected).max() > 0.1 * expected.max()


def test_every_model_holds_the_response_to_a_point_of_contact(pair, monkeypatch):
    """At the shift, (K + σ0 M) u = f of the mesh, at all nodes that are recorded."""
    case, _, _, out = pair
    a, factor = case.modelled["A"], storey_factor(out)
    files = {name: mesh_of_run(one, one.folder(out)) for name, one in case.modelled.items()}
    prepared = prepare(a, files["A"], factor, files)
    plan, mesh = prepared.plan, prepared.parts.mesh
    force = plan.contacts[len(plan.contacts) // 3]
    building = assemble_building(communicator(), prepared.parts)
    f = force.vector(building, mesh)
    K = building.take_stiffness(factor)
    shifted = combined(1.0, K, (2.0 * np.pi * plan.shift) ** 2, building.mass)
    with Factorisation(shifted, name="the shifted stiffness") as A:
        u = A.solve_block(f[:, None])[:, 0]
    nodes = np.setdiff1d(plan.nodes, mesh.base)
    exact = u[building.rows(nodes)[:, None] + np.arange(3)]

    def errors():
        once = assemble_building(communicator(), prepared.parts)
        made = reduce_building(once, mesh, factor, plan)
        # The errors are those of the models with the vectors of contacts, as where it is read.
        assert made.errors == pytest.approx(made.serving(plan)[0].errors, rel=1e-9)
        basis = made.basis
        at, found = basis.loads.index(force.name), []
        for model in (*basis.models, *basis.larger):
            z = model.load[:, at] / (model.eigenvalue + model.shift)
            found.append(np.abs(basis.of(model, nodes) @ z - exact).max() / np.abs(exact).max())
        return found

    assert len(every := errors()) > 3 and max(every) < 1e-9
    # Not so with vectors as they were appended, orthogonal to more of the Krylov space.
    own, calls = len(plan.contacts), itertools.count()
    steps = SMOOTH_RESPONSES + 1 + len(FURTHER_SHIFTS)

    def appended(W, full_matrices):
        return np.eye(len(W))[:, -own:], np.full(own, float(next(calls) % steps == 0)), None

    monkeypatch.setattr("impactfem.reduction.reduced_basis.svd", appended)
    assert errors()[0] > 1e-4


def test_a_constant_load_gives_the_static_displacement(pair):
    """On the edge of the roof of A, after its oscillations have died, against K u = F."""
    case, system, given, out = pair
    a, direction, h = case.modelled["A"], np.array([0.0, -1.0, 0.0]), 5e-3
    mesh = read_mesh(mesh_of_run(a, out))
    facade, _ = facades(mesh, 2, "")[""]
    push = even(2, facade, inward(facade))
    pushes = {("A", 2): (outward_normal(mesh, 2), ((push, 1.0),))}
    load = Load(End.of_floor(system.stick("A"), 2), direction, np.full(2001, 1e5))
    row = Pounding3D(case, system, Models3D(given.lines, given.models, pushes))
    found = row.free(np.zeros((2001, 3)), h, [load]).u[-1, [7, 1]]
    parts = read_parts(a, mesh_of_run(a, out))[0]
    building = assemble_building(communicator(), parts)
    with Factorisation(building.take_stiffness(storey_factor(out)), name="the stiffness") as K:
        u = K.solve_block(1e5 * push.vector(building, mesh)[:, None])[:, 0]
    expected = u[building.rows(np.array([mesh.centres[2], mesh.centres[1]])) + 1]
    assert expected.max() < -1e-5
    # The basis is accurate to 5 %.
    assert found == pytest.approx(expected, rel=0.01)
    assert found != pytest.approx(1.05 * expected, rel=0.01)
    assert not row.free(np.zeros((2001, 3)), h).u.any()


def later(ground):
    """The same ground, 20.5 steps later under B than under A."""
    delays = {"A": 0.0, "B": 20.5 * STEP}
    return Ground.under([(1, STEP, ground[:, 1])], STEP, len(ground), delays)


def of_all_modes(system, lines):
    """Lines whose forces push 3D models that are made of all modes of sticks, and these models."""
    made, models = [], {}
    for line in lines:
        ends = []
        for end, sign in ((line.a, -1.0), (line.b, 1.0)):
            direction = (0.0, sign, 0.0)
            forces = tuple(
                EdgeForce(f"{line.name} {k} {sign}", end.point.floor, direction)
                for k in range(len(line))
            )
            ends.append(LineEnd(end.point, end.offset, end.hats, forces))
        made.append(replace(line, a=ends[0], b=ends[1]))
    for stick, (basis, body) in zip(system.sticks, system.modes, strict=True):
        ends = [
            (end, force, offset)
            for line in made
            for end in (line.a, line.b)
            if end.point.building == stick.name
            for force, offset in zip(end.forces, end.offset, strict=True)
        ]
        rows = np.array(
            [
                np.array(force.direction)
                @ stick.translation(stick.floor_master(end.point.floor), offset)
                for end, force, offset in ends
            ]
        )
        R = stick.rigid_body()
        # About the origin of a mesh, from which the base is away.
        away = np.array([2.0, -3.0, 1.0])
        of_base = rigid_body(away[None], np.zeros(3))
        models[stick.name] = replace(
            model_of(body.eigenvalue, 0.0, rows @ basis),
            ground=-body.participation @ of_base,
            names=np.array([force.name for _, force, _ in ends]),
            points=basis[: 6 * len(stick.floors)].reshape(-1, 6, len(basis)),
            points_carried=(R[: 6 * len(stick.floors)] @ of_base).reshape(-1, 6, 6),
            wrench=rows @ R @ of_base,
            rigid_mass=of_base.T @ R.T @ stick.M @ R @ of_base,
            base=away,
        )
    return tuple(made), models


@pytest.mark.parametrize("passing", [False, True])
@pytest.mark.parametrize("soil", [False, True])
def test_a_stick_in_the_place_of_a_3d_model(pair, shaken, passing, soil):
    """A model of all modes of a stick, with rigid floors, gives the pounding of the sticks."""
    ground = later(10.0 * shaken) if passing else 10.0 * shaken
    case = with_law(pair[0], SMOOTH)
    case = on_soil(case) if soil else case
    system = system_of(case, None)
    lines, models = of_all_modes(system, pair[2].lines)
    expected = simulate(system, ground, STEP)
    scale = np.abs(expected.force).max()
    for in_models in (("A",), ("A", "B")):
        given = Models3D(lines, {name: models[name] for name in in_models})
        found = Pounding3D(case, system, given).respond(ground, STEP)
        free = Pounding3D(case, system, given).free(ground, STEP)
        assert np.abs(found.force - expected.force).max() < 1e-7 * scale
        moved = np.abs(expected.u).max(axis=0)
        good = moved > 1e-6 * moved.max()
        assert np.abs(found.u - expected.u)[:, good].max() < 1e-7 * moved.max()
        a, b = (one.absolute_acceleration[:, good] for one in (found, expected))
        assert np.abs(a - b).max() < 1e-6 * np.abs(b).max()
        assert found.energy.residual < 1e-10
        alone = simulate(system.without_contact(), ground, STEP)
        assert np.abs(free.u - alone.u).max() < 1e-9 * np.abs(alone.u).max()
        ours, theirs = (
            [(i.impulse, i.dissipated, i.defect) for i in impacts(one)[:3]]
            for one in (found, expected)
        )
        assert np.allclose(ours, theirs, rtol=1e-3, atol=1e-3 * abs(theirs[0][1]))
        assert found.bases.keys() == expected.bases.keys() == ({"A", "B"} if soil else set())
        for name, base in expected.bases.items():
            for what in ("u", "v", "force", "radiated"):
                one, other = (getattr(x, what) for x in (found.bases[name], base))
                assert np.abs(one - other).max() < 1e-6 * np.abs(other).max(), what
    if soil:
        clamped = simulate(system_of(with_law(pair[0], SMOOTH), None), ground, STEP)
        assert np.abs(clamped.force - expected.force).max() > 1e-2 * scale
        assert expected.energy.radiated[-1] > 1e-3 * expected.energy.scale


def test_two_ranks_give_the_pounding_of_one(pair, shaken, on_ranks, tmp_path):
    """Both reduced on the ranks, on soil; forces of points, accelerations of floors."""
    raft = 'raft = { length = "6 m", width = "4 m", thickness = "0.5 m", mass = "30 t" }\n'
    soil = '[buildings.soil]\ntype = "half-space"\nshear_velocity = "200 m/s"\n'
    soil += f'density = "2000 kg/m3"\npoisson_ratio = 0.3\n{raft}[buildings.structure]\n'
    path = in_3d(tmp_path, ("[buildings.structure]\n", soil))
    script = Path(__file__).with_name("pounding_on_ranks.py")
    found = on_ranks(script, path=str(path), out=str(pair[3]), ground=shaken, step=STEP)
    for one, many in zip(found(1), found(2), strict=True):
        assert one.any()
        assert np.abs(many - one).max() < 1e-8 * np.abs(one).max()


def test_forces_find_their_patterns_again(pair, shaken, tmp_path):
    """Through the file: the same patterns, on the building that they push."""
    case, system, given, out = pair
    response = Pounding3D(case, system, given).respond(shaken, STEP)
    write_forces(tmp_path / "forces.nc", response, case.content_hash())
    for history in (read_forces(tmp_path / "forces.nc"), ForceHistory.of_response(response)):
        for name, one in case.modelled.items():
            mesh = read_mesh(one.folder(out) / "building.msh")
            _, shares = checked_forces(history, tmp_path / "forces.nc", one, mesh, 0.4)
            patterns = [force for line in given.lines for force in line.forces_on(name)]
            assert shares == [((force, 1.0),) for force in patterns]
