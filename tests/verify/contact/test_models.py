import numpy as np
import pytest

from impactfem.verify.contact.models import fitted_order, order_at_least

SIZES = np.array([0.4, 0.2, 0.1])


def test_an_order_is_the_slope():
    assert fitted_order(SIZES, 3.0 * SIZES**2.5) == pytest.approx(2.5, rel=1e-12)


@pytest.mark.parametrize(
    ("order", "missing", "passed"), [(4.0, 0.0, True), (1.95, 0.05, True), (1.8, 0.2, False)]
)
def test_an_order_above_its_bound_passes(order, missing, passed):
    row = order_at_least("a", "b", 2.0, SIZES, 7.0 * SIZES**order, "c")
    assert row.quantity == "fitted order of b, at least 2"
    assert row.error == pytest.approx(missing, abs=1e-12)
    assert row.passed is passed
