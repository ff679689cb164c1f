import numpy as np
import pytest

from impactfem.verify.shells import shell_patch

PLACE = np.random.default_rng(1).uniform(-1.0, 1.0, (4, 3)) * [1.0, 1.0, 0.0]
STEP = 1e-5


def slopes(state, column):
    """∂/∂x and ∂/∂y of a column of the state, by differences."""
    found = []
    for axis in (0, 1):
        step = STEP * np.eye(3)[axis]
        found.append((state(PLACE + step) - state(PLACE - step))[:, column] / (2.0 * STEP))
    return found


@pytest.mark.parametrize("strain", shell_patch.STATES.values())
def test_the_states_are_what_they_say(strain):
    def membrane(place):
        return shell_patch.membrane_state(place, strain)

    (uxx, uxy), (uyx, uyy) = slopes(membrane, 0), slopes(membrane, 1)
    for found, asked in zip((uxx, uyy, 0.5 * (uxy + uyx)), strain, strict=True):
        assert found == pytest.approx(asked, abs=1e-9)
    assert 0.5 * (uyx - uxy) == pytest.approx(membrane(PLACE)[:, 5], abs=1e-9)

    def bending(place):
        return shell_patch.bending_state(place, strain)

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
    right = getattr(shell_patch, state)

    def wrong(place, strain):
        made = right(place, strain)
        made[:, 3:] *= 1.01
        return made

    monkeypatch.setattr(shell_patch, state, wrong)
    rows = shell_patch.patch_tests()
    assert {row.name for row in rows if not row.passed} == {f"{kind} patch test"}
    assert all(row.passed == (kind not in row.name) for row in rows)


@pytest.mark.usefixtures("wrong_drilling")
def test_a_wrong_element_is_seen():
    rows = shell_patch.patch_tests()
    assert not any(row.passed for row in rows if row.name == "membrane patch test")
