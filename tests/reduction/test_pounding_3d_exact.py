"""Bodies whose pounding is known, in the place of the 3D models of a case."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from impactfem.building.section import Material
from impactfem.building.shell_model import Shells, shell_model
from impactfem.case import load_case
from impactfem.case.analysis import Pounding
from impactfem.coupling.from_case import system_of
from impactfem.coupling.pounding import End, Load, simulate
from impactfem.reduction.contact_line import ContactLine, LineEnd
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.pounding_3d import Pounding3D
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.sticks.element import COMPONENTS
from impactfem.system.files import in_source_tree
from impactfem.verify import unilateral
from impactfem.verify.row import fitted_order
from impactfem.verify.shells import rectangle
from impactfem.verify.unilateral import BAR, CONTACT, SPEED, V0, L, bar_matrices
from two_models import write_case

LAW = 'type = "kelvin-voigt"\nstiffness = "5e8 N/m"\nrestitution = 0.5\n'
DAMPING = 'ratio = "5 %"\nfrequencies = ["1 Hz", "20 Hz"]\n'
UNDAMPED = 'mass_coefficient = "0 1/s"\nstiffness_coefficient = "0 s"\n'


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Two undamped buildings in 3D that touch at floor 1, unilaterally."""
    path = write_case(tmp_path_factory.mktemp("exact"))
    text = path.read_text(encoding="utf-8").replace(LAW, 'type = "unilateral"\n')
    text = text.replace(DAMPING, UNDAMPED).replace("floor = [1, 2]", "floor = 1")
    models = '[pounding]\nmodels = { A = "structure", B = "structure" }\n'
    models += 'unilateral_scheme = "moreau"\n'
    path.write_text(text.replace("[pounding]\n", models), encoding="utf-8")
    return load_case(path)


def body(eigenvalue, drive, inward, **seen):
    """A 3D model by its modes.

    Driven along y, with the rows of its points of contact, and what is seen as its floor 1.
    """
    r, m = len(eigenvalue), len(inward)
    ground, points = np.zeros((r, 6)), np.zeros((2, 6, r))
    ground[:, 1] = drive
    for component, row in seen.items():
        points[0, COMPONENTS.index(component)] = row
    return CompleteModel(
        eigenvalue=np.maximum(eigenvalue, 0.0),
        ground=ground,
        names=np.array([str(k) for k in range(m)]),
        edges=np.array(inward).T,
        anchors=np.zeros((0, 6, r)),
        points=points,
        difference=0.0,
        wall=None,
        rigid_mass=np.eye(6),
        wrench=np.zeros((m, 6)),
        anchors_carried=np.zeros((0, 6, 6)),
        points_carried=np.zeros((2, 6, 6)),
        base=np.zeros(3),
    )


def touching(case, models, gap, place=(0.0,)):
    """The pounding of bodies at points along a line; of one alone, with a rigid wall."""
    m, one = len(place), case.contacts[0]
    ends = [
        LineEnd(
            point,
            np.column_stack([place, np.zeros((m, 2))]),
            np.tile(np.array(place)[:, None], 3),
            tuple(EdgeForce(str(k), 1, (0.0, sign, 0.0)) for k in range(m)),
        )
        for point, sign in ((one.a, -1.0), (one.b, 1.0))
    ]
    if len(models) == 1:
        ends[1], one = None, one.model_copy(update={"b": None, "wall": "pit"})
        case = case.model_copy(update={"contacts": (one,)})
    line = ContactLine(
        *(one.name, np.array([0.0, 1.0, 0.0]), *ends, np.array(place)),
        *(np.ones(m), np.full(m, gap), (one.name,), np.zeros(m, dtype=bool)),
    )
    return Pounding3D(case, system_of(case, None), Models3D((line,), models))


def pushed(h, steps, speed):
    """A ground motion along y that gives what it drives with 1 a speed within the first step."""
    ground = np.zeros((steps + 1, 3))
    ground[0, 1] = 2.0 * speed / h
    return ground


def massless(case, frequency):
    """The case without mass at the contact points, above a frequency; rigid edges."""
    changes = {"unilateral_scheme": "massless", "contact_frequency": frequency}
    laws = {
        name: law.model_copy(update={"edge_stiffness": "rigid"})
        for name, law in case.contact_laws.items()
    }
    pounding = case.pounding.model_copy(update=changes)
    return case.model_copy(update={"pounding": pounding, "contact_laws": laws})


@pytest.mark.parametrize("scheme", ["moreau", "massless"])
@pytest.mark.parametrize("ratio", [1, 2])
def test_bars_head_on_against_st_venant(case, ratio, scheme):
    """F = ρ c S v₀/2 for 2L/c; the second bar, at rest, has all of the momentum afterwards."""
    errors, counts = [], np.array([10, 20, 40])
    for elements in counts:
        models = {}
        for name, sign, factor in (("A", -1.0, 1), ("B", 1.0, ratio)):
            K, M = (x.toarray() for x in bar_matrices(factor * elements, factor * L))
            values, shapes = scipy.linalg.eigh(K, M)
            momentum = shapes.T @ M.sum(axis=1)
            centre, driven = momentum / (factor * BAR), momentum * (name == "A")
            # The first node is the end that meets the other bar.
            models[name] = body(values, driven, sign * shapes[:1], y=centre)
        h = unilateral._step(elements)
        steps = round((1.5 + ratio) * CONTACT / h)
        # A layer as long as half of an element.
        frequency = SPEED * 2 * elements / L / (2.0 * np.pi)
        one = case if scheme == "moreau" else massless(case, frequency)
        pounding = touching(one, models, 3.3 * V0 * h)
        found = pounding.respond(pushed(h, steps, V0), h)
        impulse = found.force[:, 0].sum() * h
        errors.append(abs(impulse / (BAR * V0) - 1.0))
        after = [found.v[-1, found.system.offsets[name] + 1] for name in "AB"]
    force = 0.5 * BAR * V0 / L * SPEED
    lasts = np.count_nonzero(found.force[:, 0] > 0.5 * force) * h
    assert lasts == pytest.approx(CONTACT, abs=3.0 * h / unilateral.COURANT)
    assert impulse / lasts == pytest.approx(force, rel=0.05)
    assert errors[-1] < 0.01
    # The front of a jump spreads over the power 2/3 of the mesh.
    assert 0.27 < fitted_order(1.0 / counts, errors) < 1.3
    assert np.array(after) == pytest.approx(V0 * np.array([0.0, 1.0 / ratio]), abs=0.01 * V0)
    assert after[0] + ratio * after[1] == pytest.approx(V0, rel=1e-9)
    # Rigid bodies with the restitution 1 would do otherwise.
    if ratio == 2:
        assert abs(after[1] - 2.0 / 3.0 * V0) > 0.1 * V0
    assert found.energy.residual < 1e-10


def plastic(m, k, gap, ground, end):
    """Two oscillators on shaken ground that hit each other and stay until they pull, at the end.

    Both fly by themselves, or move as one, by integration of high order between the events.
    """

    def flight(t, x):
        u, v = x[:2], x[2:]
        return np.concatenate([v, -k / m * u - ground(t)])

    def joined(t, x):
        a = (-k @ x[:2]) / m.sum() - ground(t)
        return np.concatenate([x[2:], [a, a]])

    def closing(t, x):
        return gap + x[1] - x[0]

    def pressing(t, x):
        return -m[0] * ground(t) - m[0] * joined(t, x)[2] - k[0] * x[0]

    closing.terminal = pressing.terminal = True
    closing.direction = pressing.direction = -1
    t, x, apart, count = 0.0, np.zeros(4), True, 0
    while t < end:
        rule, event = (flight, closing) if apart else (joined, pressing)
        done = scipy.integrate.solve_ivp(
            rule, (t, end), x, "DOP853", events=event, rtol=1e-12, atol=1e-14
        )
        t, x = done.t[-1], done.y[:, -1]
        if t < end and apart:
            x[2:] = (m @ x[2:]) / m.sum()
            apart, count = pressing(t, x) <= 0.0, count + 1
        elif t < end:
            apart = True
    return x[:2], count


def test_oscillators_against_each_other_under_ground_motion(case):
    """No restitution is put in, and masses have no waves: what hits stays until it is pulled."""
    m, k = unilateral.OSCILLATORS
    gap, end = unilateral.APART, 2.0

    def ground(t):
        return unilateral.AMPLITUDE * np.sin(unilateral.SHAKEN * t)

    u, count = plastic(m, k, gap, ground, end)
    assert count > 2
    root, errors, steps = np.sqrt(m), [], np.array([1000, 4000, 16000])
    models = {
        name: body(k[i : i + 1] / m[i], -root[i], [[sign / root[i]]], y=[1.0 / root[i]])
        for i, (name, sign) in enumerate((("A", -1.0), ("B", 1.0)))
    }
    for n in steps:
        motion = np.outer(ground(np.linspace(0.0, end, n + 1)), [0.0, 1.0, 0.0])
        found = touching(case, models, gap).respond(motion, end / n)
        at = [found.system.offsets[name] + 1 for name in "AB"]
        errors.append(np.abs(found.u[-1, at] - u).max() / np.abs(u).max())
    assert errors[-1] < 2e-3
    # The instant of an impact is known to a step.
    assert fitted_order(1.0 / steps, errors) > 0.7
    other, _ = plastic(m, k, 1.5 * gap, ground, end)
    assert np.abs(other - u).max() > 10.0 * errors[-1] * np.abs(u).max()


def test_a_free_slab_hit_off_its_centre(case):
    """It flies against a wall that a third of its edge meets; J ω is the moment of the impulses."""
    length, width, t, rho, speed = 6.0, 4.0, 0.2, 2500.0, 0.5
    nodes, triangles = rectangle(length, width, 6, 4)
    model = shell_model(nodes, Shells(triangles, t, Material(33e9, 0.2, rho)))
    model = model.hold(nodes[:, 0] >= 0.0, 2, 3, 4)
    free = model.free
    K, M = (one[np.ix_(free, free)].toarray() for one in (model.K, model.M))
    values, shapes = scipy.linalg.eigh(K, M)
    node, component = np.divmod(free, 6)
    x, y = (model.nodes[node, c] - half for c, half in ((0, length / 2), (1, width / 2)))
    along = 1.0 * (component == 1)
    turn = np.select([component == 0, component == 1, component == 5], [-y, x, np.ones(len(x))])
    m = rho * t * length * width
    # Of the mass about the vertical axis, its rotary inertia included.
    J = m * (length**2 + width**2 + t**2) / 12.0
    assert along @ M @ along == pytest.approx(m, rel=1e-12)
    struck = np.flatnonzero((component == 1) & (y == width / 2) & (x < -length / 6))
    struck = struck[np.argsort(x[struck])]  # the points of a line ascend
    slab = body(
        *(values, shapes.T @ M @ along, -shapes[struck]),
        y=along @ M @ shapes / m,
        rz=turn @ M @ shapes / (turn @ M @ turn),
    )
    h, steps = 2e-5, 1000
    pounding = touching(case, {"A": slab}, 1e-3, x[struck])
    found = pounding.respond(pushed(h, steps, speed), h)
    impulse = found.point_force.sum(axis=0) * h
    assert found.force.max() > 0.0 and not found.force[-1].any()
    # The force pushes along -y.
    after = found.v[-1, found.system.offsets["A"] :]
    assert m * (after[1] - speed) == pytest.approx(-impulse.sum(), rel=1e-9)
    assert J * after[5] == pytest.approx(-impulse @ x[struck], rel=1e-6)
    assert J * after[5] != pytest.approx(-impulse @ (x[struck] + 0.01), rel=1e-3)
    assert found.energy.residual < 1e-9


def test_three_in_a_row_with_the_middle_one_in_3d():
    """B by all modes of its stick, whose floors strike floors of A, and floors and storeys of C."""
    case = load_case(in_source_tree("geometry/row_of_three.toml"))
    pounding = Pounding.model_construct(models={"B": "structure"}, time_step=2.5e-4)
    # Points inside storeys of the stick have no mass, and no modes.
    on_floors = tuple(one for one in case.contacts if one.name.count("B.storey") == 0)
    case = case.model_copy(update={"pounding": pounding, "contacts": on_floors})
    system = system_of(case, None)
    index = next(k for k, stick in enumerate(system.sticks) if stick.name == "B")
    stick, (basis, modes) = system.sticks[index], system.modes[index]
    lines, inward, none = [], [], np.full((1, 3), np.nan)
    for contact, pair in zip(case.contacts, system.pairs, strict=True):
        ends = []
        for (point, sign), end in zip(contact.ends, (pair.a, pair.b), strict=True):
            forces = ()
            if end.building == "B":
                row = -sign * pair.normal @ stick.translation(end.master, end.offset)
                forces = (EdgeForce(str(len(inward)), end.floor, tuple(-sign * pair.normal)),)
                inward.append(row @ basis)
            ends.append(LineEnd(point, np.array([end.offset]), none, forces))
        at = np.zeros(1), np.ones(1), np.array([pair.gap])
        lines.append(
            ContactLine(pair.name, pair.normal, *ends, *at, (pair.name,), np.array([False]))
        )
    model = replace(
        body(modes.eigenvalue, 0.0, inward),
        ground=-modes.participation,
        names=np.array([force.name for line in lines for force in line.forces_on("B")]),
        points=basis[: 6 * len(stick.floors)].reshape(-1, 6, len(basis)),
        points_carried=stick.rigid_body()[: 6 * len(stick.floors)].reshape(-1, 6, 6),
    )
    # A load on the roof as well, whose edge looks along y.
    roof, push = stick.floors[-1].number, EdgeForce("push", 4, (0.0, -1.0, 0.0))
    pushed = -stick.translation(stick.floor_master(roof), (0.0, 0.0, 0.0))[1] @ basis
    model = replace(
        model,
        names=np.append(model.names, push.name),
        edges=np.column_stack([model.edges, pushed]),
        wrench=np.zeros((len(model.names) + 1, 6)),
    )
    pushes = {("B", roof): (np.array([0.0, 1.0, 0.0]), ((push, 1.0),))}
    h = case.pounding.time_step
    pulse = 2e6 * np.sin(2.0 * np.pi * h * np.arange(8001)) ** 2
    load = [Load(End.of_floor(stick, roof), np.array([0.0, -1.0, 0.0]), pulse)]
    ground = 3.0 * np.sin(2.0 * np.pi * 1.2 * h * np.arange(8001))[:, None] * [0.0, 1.0, 0.0]
    expected = simulate(system, ground, h, loads=load)
    row = Pounding3D(case, system, Models3D(tuple(lines), {"B": model}, pushes))
    found = row.respond(ground, h, load)
    scale = expected.force.max()
    assert np.count_nonzero((expected.force > 0.1 * scale).any(axis=0)) > 3
    assert np.abs(found.force - expected.force).max() < 1e-7 * scale
    assert np.abs(row.respond(ground, h).force - expected.force).max() > 0.01 * scale
    # Without one of its neighbours it is another row.
    fewer = Pounding3D(case, system, Models3D(tuple(lines[:3]), {"B": model})).respond(ground, h)
    assert np.abs(fewer.force[:, :3] - expected.force[:, :3]).max() > 0.1 * scale
