import numpy as np
import pytest

from impactfem.device.directions import PLANES, combine_inputs
from impactfem.device.springs import COMPONENTS
from impactfem.system.errors import ImpactfemError

R = np.array([[3.0, 1.0], [4.0, 2.0], [12.0, 2.0]])


def test_rules_by_hand():
    assert combine_inputs(R, "srss") == pytest.approx([13.0, 3.0])
    assert combine_inputs(R, "abs") == pytest.approx([19.0, 5.0])
    assert combine_inputs(R, "100-40-40") == pytest.approx([12.0 + 2.8, 2.0 + 1.2])
    assert combine_inputs(R[::-1], "100-40-40") == pytest.approx([14.8, 3.2])


def test_one_input_stays_as_it_is():
    for rule in ("srss", "abs", "100-40-40"):
        assert combine_inputs(R[:1], rule) == pytest.approx(R[0])


def test_every_component_has_its_plane():
    assert sorted(c for plane in PLANES for c in plane) == sorted(COMPONENTS)


def test_an_unknown_rule_is_refused():
    with pytest.raises(ImpactfemError, match="one of srss, abs, 100-40-40: got 'max'"):
        combine_inputs(R, "max")
