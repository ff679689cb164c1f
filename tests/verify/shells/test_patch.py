import numpy as np
import pytest

from impactfem.verify.shells import patch

PLACE = np.random.default_rng(1).uniform(-1.0, 1.0, (4, 3)) * [1.0, 1.0, 0.0]
STEP = 1e-5


def slopes(state, column):
    """∂/∂x and ∂/∂y of a column of the state, by differences."""
    found = []
    for axis in (0, 1):
        step = STEP * np.eye(3)[axis]
        found.append((state(PLACE + step) - state(PLACE - step))[:, column] / (2.0 * STEP))
    return found


@pytest.mark.parametrize("strain", patch.STATES.values())
def test_the_states_are_what_they_say(strain):
    def membrane(place):
        return patch.membrane_state(place, strain)

    (uxx, uxy), (uyx, uyy) = slopes(membrane, 0), slopes(membrane, 1)
    for found, asked in zip((uxx, uyy, 0.5 * (uxy + uyx)), strain, strict=True):
        assert found == pytest.approx(asked, abs=1e-9)
    assert 0.5 * (uyx - uxy) == pytest.approx(membrane(PLACE)[:, 5], abs=1e-9)

    def bending(place):
        return patch.bending_state(place, strain)

    # β = θ × e3 = (θy, −θx).
    (bxx, bxy), (byx, byy) = slopes(bending, 4), [-s for s in slopes(bending, 3)]
    for found, asked in zip((bxx, byy, 0.5 * (bxy + byx)), strain, strict=True):
        assert found == pytest.approx(asked, abs=1e-9)
    wx, wy = slopes(bending, 2)
    assert wx + bending(PLACE)[:, 4] == pytest.approx(0.0, abs=1e-9)
    assert wy - bending(PLACE)[:, 3] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("state", "kind"), [("membrane_state", "membrane"), ("bending_state", "bending")]
)
def test_another_state_is_not_reproduced(monkeypatch, state, kind):
    right = getattr(patch, state)

    def wrong(place, strain):
        made = right(place, strain)
        made[:, 3:] *= 1.01
        return made

    monkeypatch.setattr(patch, state, wrong)
    rows = patch.shell_patch()
    assert {row.name for row in rows if not row.passed} == {f"{kind} patch test"}
    assert all(row.passed == (kind not in row.name) for row in rows)


@pytest.mark.usefixtures("wrong_drilling")
def test_a_wrong_element_is_seen():
    rows = patch.shell_patch()
    assert not any(row.passed for row in rows if row.name == "membrane patch test")


@pytest.mark.usefixtures("wrong_drilling")
def test_a_wrong_sign_of_drilling_is_seen(failed):
    rows = patch.shell_rigid_body()
    quantities = failed(rows)
    assert {row.quantity for row in rows if "largest energy" in row.quantity} <= quantities
    assert "energy of rotations against the turn of a plate" in quantities


def test_spurious_modes_are_seen(failed, quadrature):
    quadrature(1)
    rows = patch.shell_rigid_body()
    found = [row for row in rows if row.quantity == "zero eigenvalues, thin skew plate"]
    assert found[0].computed > 6.0
    # Rigid motions cost nothing all the same.
    assert not {quantity for quantity in failed(rows) if "largest energy" in quantity}
