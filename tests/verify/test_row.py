import json
import math

import numpy as np
import pytest

from impactfem.verify.row import Row

KEYS = [
    "name",
    "quantity",
    "reference",
    "computed",
    "unit",
    "error",
    "tolerance",
    "absolute",
    "at_least",
    "passed",
    "source",
]


def row(computed, reference=2.0, tolerance=0.01, **options):
    return Row("a", "b", reference, computed, "m", tolerance, "somewhere", **options)


@pytest.mark.parametrize(
    ("made", "error", "passed"),
    [
        (row(2.0), 0.0, True),
        (row(2.019), 0.0095, True),
        (row(1.981), 0.0095, True),
        (row(2.021), 0.0105, False),
        (row(1.979), 0.0105, False),
        (row(-1.981, reference=-2.0), 0.0095, True),
        (row(2.0, reference=-2.0), 2.0, False),
        (row(2.009, absolute=True), 0.009, True),
        (row(2.011, absolute=True), 0.011, False),
        (row(0.009, reference=0.0, absolute=True), 0.009, True),
        (row(-0.011, reference=0.0, absolute=True), 0.011, False),
        (row(1.992, at_least=True), 0.008, True),
        (row(1.988, at_least=True), 0.012, False),
        (row(5.0, at_least=True), 0.0, True),
        (row(math.inf, at_least=True), 0.0, False),
        (row(math.inf), math.inf, False),
        (row(-math.inf, absolute=True), math.inf, False),
    ],
)
def test_error_and_tolerance(made, error, passed):
    assert made.error == pytest.approx(error)
    assert made.passed is passed


@pytest.mark.parametrize("kind", [{}, {"absolute": True}, {"at_least": True}])
def test_what_is_no_number_never_passes(kind):
    made = row(math.nan, tolerance=math.inf, **kind)
    assert math.isnan(made.error) and made.passed is False


def test_json_of_numpy_numbers():
    made = row(np.float64(2.0), reference=np.float64(2.0))
    entry = json.loads(json.dumps(made.as_dict()))
    assert list(entry) == KEYS
    assert entry["passed"] is True and entry["error"] == 0.0 and entry["unit"] == "m"
