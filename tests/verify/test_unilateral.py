import numpy as np
import pytest

from impactfem.sticks.stick import Stick
from impactfem.verify import contact, unilateral
from impactfem.verify.unilateral import CORNERS, GRAVITY, INERTIA, MASS, START, bounced, modal_bar


def test_the_solvers_agree():
    one, other = (run(20, 1e-6) for run in unilateral.SOLVERS.values())
    assert np.abs(one.impulse - other.impulse).max() < 1e-9 * one.impulse.max()
    lasts, expected = (unilateral.impact_of(history).duration for history in (one, other))
    assert lasts == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("part", ["stiffness", "mass"])
def test_a_wrong_bar_is_seen(wrong, failed, monkeypatch, part):
    """Also with fewer elements, on which the rows of the contact in time are counted in steps."""
    monkeypatch.setattr(unilateral, "ELEMENTS", 40)

    def changed(right, *bar):
        K, M = right(*bar)
        return (1.03 * K, M) if part == "stiffness" else (K, 1.03 * M)

    wrong(unilateral, "bar_matrices", changed)
    for rows in (unilateral.unilateral_bar(), unilateral.unilateral_damped_bar()):
        found = failed(rows)
        for solver in unilateral.SOLVERS:
            assert f"force, mean of the contact, {solver}" in found
            assert f"duration, {solver}" in found


@pytest.mark.parametrize("part", ["stiffness", "mass"])
def test_a_wrong_second_bar_is_seen(wrong, failed, part):
    def changed(right, elements, length):
        K, M = right(elements, length)
        factor = 1.03 if length > 1.0 else 1.0
        return (factor * K, M) if part == "stiffness" else (K, factor * M)

    wrong(unilateral, "bar_matrices", changed)
    assert "impulse" in failed(unilateral.bars_head_on())


@pytest.mark.parametrize(("name", "by"), [("APART", 0.1), ("RESTITUTION", 0.02), ("SHAKEN", 0.02)])
def test_a_wrong_collision_is_seen(wrong, failed, monkeypatch, name, by):
    def changed(right, steps):
        with monkeypatch.context() as other:
            other.setattr(unilateral, name, (1.0 + by) * getattr(unilateral, name))
            return right(steps)

    wrong(unilateral, "_colliding", changed)
    found = failed(unilateral.colliding_oscillators())
    assert any("after 5 impacts" in quantity for quantity in found)


def test_a_wrong_damping_is_seen(monkeypatch, failed):
    """Of fewer elements, with which no row of the right bar fails."""
    monkeypatch.setattr(unilateral, "ELEMENTS", 40)
    assert failed(unilateral.unilateral_damped_bar()) == set()
    monkeypatch.setitem(unilateral.SOLVERS, "modal", lambda n, beta: modal_bar(n, 1.1 * beta))
    found = failed(unilateral.unilateral_damped_bar())
    assert {"ε by the impulse, modal", "force, mean of the contact, modal"} <= found
    assert not any(quantity.endswith("full") for quantity in found)


def test_flights_and_bounces():
    """Until the first bounce it is a flight; a bounce keeps e² of the corner's energy."""
    (x, v, count), (x0, v0) = bounced(0.1, 0.8), START
    assert count == 0
    assert x == pytest.approx(x0 + 0.1 * v0 - [0.5 * GRAVITY * 0.01, 0.0])
    assert v == pytest.approx(v0 - [GRAVITY * 0.1, 0.0])

    def energy(x, v):
        return 0.5 * MASS * v[0] ** 2 + 0.5 * INERTIA * v[1] ** 2 + MASS * GRAVITY * x[0]

    elastic, count = bounced(0.6, 1.0)[:2], bounced(0.6, 1.0)[2]
    assert count > 1 and energy(*elastic) == pytest.approx(energy(x0, v0))
    assert energy(*bounced(0.6, 0.8)[:2]) < energy(x0, v0)
    for end in np.linspace(0.0, 0.6, 30):
        assert np.all(-CORNERS.T @ bounced(end, 0.8)[0] >= -1e-12)


def test_a_wrong_inertia_is_seen(wrong, failed):
    turned = [[1.0], [1.02]]
    wrong(unilateral, "_block", lambda right, corners, step: right(corners * turned, step))
    found = failed(unilateral.landing_block())
    assert "turning fast on near corners: impulse on corner 1" in found
    assert "rotation after 4 bounces with e = 0.8 under gravity" in found


def test_a_storey_that_stays_straight_is_seen(wrong, failed):
    """The floor's motion straight down to the base, in place of the column's bending and shear."""
    wrong(Stick, "storey_motion", lambda _, stick, number, height: height * np.eye(6, stick.n))
    assert failed(contact.missing_pair()) == {"smallest distance"}


def test_pairs_that_are_not_looked_for_are_seen(wrong, failed):
    """Contacts that the search does not know: all places are in no pair."""

    def without(right, case):
        return right(case.model_copy(update={"contacts": ()}))

    wrong(contact, "facing_floors", without)
    places = {f"places in no pair, with the pair {word}" for word in ("listed", "missing")}
    assert places <= failed(contact.missing_pair())
