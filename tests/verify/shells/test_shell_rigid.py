import pytest

from impactfem.verify.shells import shell_rigid


@pytest.mark.usefixtures("wrong_drilling")
def test_a_wrong_sign_of_drilling_is_seen(failed):
    rows = shell_rigid.rigid_body_modes()
    quantities = failed(rows)
    assert {row.quantity for row in rows if "largest energy" in row.quantity} <= quantities
    assert "energy of rotations against the turn of a plate" in quantities


def test_spurious_modes_are_seen(failed, quadrature):
    quadrature(1)
    rows = shell_rigid.rigid_body_modes()
    found = [row for row in rows if row.quantity == "zero eigenvalues, thin skew plate"]
    assert found[0].computed > 6.0
    # Rigid motions cost nothing all the same.
    assert not {quantity for quantity in failed(rows) if "largest energy" in quantity}
