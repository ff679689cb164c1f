import pytest

from impactfem.verify.shells import patch


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
