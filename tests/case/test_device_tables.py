"""Tables of a device: its matrices, and floor spectra that are given for it."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from impactfem.case.device_tables import (
    DeviceMatrices,
    GivenSpectrum,
    NamedMatrix,
    read_given_spectra,
    read_mass_matrix,
    read_stiffness_matrix,
)
from impactfem.system.errors import Fault

from .faults import check_fault

MATRIX = """\
# N/m
1.y [N/m],middle y [N/m],2.y [N/m]
3e6,-3e6,0
-3e6,4e6,-1e6
0,-1e6,1e6
"""
TABLE = """\
frequency [Hz],acceleration [m/s2],direction,damping [%]
1,2,y,2
10,8,y,2
40,3,y,2
# descending is as good
40,3,y,5
1,1.5,y,5
"""
PRODUCT = """\
building,floor,direction,damping [-],frequency [Hz],raw [m/s2],broadened [m/s2]
B1,7,y,0.05,1,2,2
B1,7,y,0.05,1.15,,3
B1,8,y,0.05,1,4,4
B1,8,y,0.05,2,5,5
B2,8,y,0.05,1,9,9
B2,8,y,0.05,2,9,9
"""
Read = Callable[..., tuple[Any, list[Fault]]]


@pytest.fixture
def read(tmp_path):
    """Read a text as floor spectra, or as a matrix."""

    def of(text, reader=read_given_spectra):
        faults = []
        path = tmp_path / "table.csv"
        path.write_text(text, encoding="utf-8")
        return reader(path, faults), faults

    return of


def test_a_matrix(read):
    found, faults = read(MATRIX, read_stiffness_matrix)
    assert found is not None and not faults
    assert found.names == ("1.y", "middle y", "2.y")
    assert found.rows[1] == (-3e6, 4e6, -1e6)


@pytest.mark.parametrize(
    ("old", "new", "key", "kind"),
    [
        ("-1e6,1e6", "-1e6,1e6,0", "line 5", "cells"),
        ("0,-1e6,1e6\n", "", "line 2", "matrix"),
        ("4e6", "stiff", "line 4", "matrix"),
        ("4e6", "inf", "line 4", "matrix"),
        ("2.y", "1.y", "line 2", "matrix"),
        ("1.y [N/m],middle y [N/m],2.y [N/m]", "1,2,3", "line 2", "matrix"),
        ("middle y [N/m]", "", "line 2", "matrix"),
        ("1.y [N/m]", "1.y", "line 2, column 1.y", "matrix"),
        ("middle y [N/m]", "middle y", "line 2, column middle y", "matrix"),
        ("1.y [N/m]", "1.y [kg]", "line 2, column 1.y [kg]", "matrix"),
        ("1.y [N/m]", "1.y [N m]", "line 2, column 1.y [N m]", "matrix"),
        ("2.y [N/m]", "2.ry [N/m]", "line 2, column 2.ry [N/m]", "matrix"),
        ("0,-1e6", "0,1e308", "2.y, middle y", "matrix -1e+06"),
        ("0,-1e6", "0,-2e6", "2.y, middle y", "matrix -1e+06"),
    ],
)
def test_faults_of_a_matrix(read, old, new, key, kind):
    found, faults = read(MATRIX.replace(old, new), read_stiffness_matrix)
    assert found is None
    check_fault(faults, key, kind)


UNITS = {
    "SI": (("kg", 1.0), ("kg m2", 1.0), ("N/m", 1.0), ("N m/rad", 1.0)),
    "tonne, mm, s": (("t", 1e-3), ("t mm2", 1e3), ("N/mm", 1e-3), ("N mm", 1e3)),
    "kN, m, s": (("kN s2/m", 1e-3), ("kN m s2", 1e-3), ("kN/m", 1e-3), ("kN m/rad", 1e-3)),
}


def on_feet(units):
    """A mass of 1500 kg whose height of 2 m above the anchor couples shift and turn, in units."""
    (of_mass, m), (of_inertia, J), (of_spring, k), (of_turn, c) = UNITS[units]
    mass = np.array([[1500.0, -3000.0], [-3000.0, 7000.0]])
    stiffness = np.array([[4e7, 0.0], [0.0, 9e7]])
    texts = []
    for names, matrix, shift, turn in (
        (f"{{0}} [{of_mass}],{{1}} [{of_inertia}]", mass, m, J),
        (f"{{0}} [{of_spring}],{{1}} [{of_turn}]", stiffness, k, c),
    ):
        factor = np.sqrt(np.outer([shift, turn], [shift, turn]))
        sign = np.array([[1.0, -1.0], [-1.0, 1.0]])
        own = np.array([[0.0, 0.0], [0.0, 1.0]])
        whole = np.kron(own if matrix is mass else sign, matrix * factor)
        header = f"{names.format('1.x', '1.ry')},{names.format('mx', 'turn')}"
        rows = "\n".join(",".join(f"{value:.17g}" for value in row) for row in whole)
        texts.append(f"{header}\n{rows}\n")
    return texts


@pytest.mark.parametrize("units", UNITS)
def test_matrices_in_other_units(read, units):
    mass, stiffness = on_feet(units)
    M, faults = read(mass, read_mass_matrix)
    K, more = read(stiffness, read_stiffness_matrix)
    assert not faults and not more
    assert M.turns == K.turns == (False, True, False, True)
    assert np.array(M.rows)[2:, 2:] == pytest.approx(np.array([[1500, -3000], [-3000, 7000]]))
    assert np.array(K.rows)[:2, :2] == pytest.approx(np.array([[4e7, 0.0], [0.0, 9e7]]))
    found = DeviceMatrices(mass=M, stiffness=K)
    assert found.total_masses == pytest.approx({"x": 1500.0})
    # det(K - λ M) = 0, on supports at rest.
    a, b, c = 1500 * 7000 - 3000**2, -(4e7 * 7000 + 9e7 * 1500), 4e7 * 9e7
    root = (-b - math.sqrt(b * b - 4 * a * c)) / (2 * a)
    assert found.first_frequency == pytest.approx(math.sqrt(root) / (2 * math.pi))


def test_units_of_different_motions(read):
    mass, _ = read(on_feet("SI")[0].replace("turn [kg m2]", "turn [kg]"), read_mass_matrix)
    stiffness, _ = read(on_feet("SI")[1], read_stiffness_matrix)
    with pytest.raises(ValidationError, match="turn is a rotation in one of the headers"):
        DeviceMatrices(mass=mass, stiffness=stiffness)


def matrices(*names):
    none = tuple(tuple(0.0 for _ in names) for _ in names)
    return DeviceMatrices(mass=NamedMatrix(names, none), stiffness=NamedMatrix(names, none))


def test_which_motion_is_whose():
    found = matrices("1.y", "2.rx", "tip", "3.y above", "10.z")
    assert found.anchored == {0: 1, 1: 9, 4: 56}
    assert found.own == ("tip", "3.y above")


@pytest.mark.parametrize(
    ("names", "supports", "message"),
    [
        (("1.y", "1.RZ", "tip"), 1, "1.RZ is no motion of a support; expected numbers from 1"),
        (("0.y", "1.y", "tip"), 1, "0.y is no motion of a support; expected numbers from 1"),
        (("1.y", "tip"), 2, "no motion of support 2; expected at least one of 2.x, 2.y"),
        (("1.y", "2.y", "3.y", "tip"), 2, "have a support 3, the device has 2"),
        (("1.y", "2.y"), 2, "expected motions of the device's own"),
    ],
)
def test_beside_the_supports(names, supports, message):
    (found,) = matrices(*names).lacks(supports)
    assert message in found
    assert not list(matrices("1.y", "2.y", "tip").lacks(2))


def test_a_table_holds_for_all_supports(read):
    found, faults = read(TABLE)
    assert found is not None and not faults
    light, heavy = found.at("B1", [8])
    values = {"frequency": (1.0, 10.0, 40.0), "acceleration": (2.0, 8.0, 3.0)}
    assert light == GivenSpectrum(support=1, direction="y", damping=0.02, **values)
    assert (heavy.damping, heavy.frequency) == (0.05, (1.0, 40.0))
    assert [one.support for one in found.at("B1", [7, 8])] == [1, 1, 2, 2]
    assert list(found.lacks("B1", [7, 8])) == []


def test_a_table_by_support(read):
    lines = TABLE.replace("damping [%]", "damping [%],support").splitlines()
    found, _ = read("\n".join([lines[0], *(f"{row},2" for row in lines[1:] if row[0] != "#")]))
    assert [one.support for one in found.at("B1", [7, 8])] == [2, 2]
    assert list(found.lacks("B1", [7, 8])) == ["it has no spectrum of support 1"]
    assert "it has spectra of support 2; expected those of 1 to 1" in found.lacks("B1", [7])


def test_products_of_a_run(read):
    """The broadened spectra of the device's floor; what was not computed at a corner is no loss."""
    found, faults = read(PRODUCT)
    assert found is not None and not faults
    (one,) = found.at("B1", [7])
    assert (one.frequency, one.acceleration) == ((1.0, 1.15), (2.0, 3.0))
    below, above = found.at("B1", [7, 8])
    assert (below.support, above.support, above.acceleration) == (1, 2, (4.0, 5.0))
    assert list(found.lacks("B1", [6])) == ["it has no spectrum of floor 6 of building B1"]


@pytest.mark.parametrize(
    ("old", "new", "key", "kind"),
    [
        ("10,8", "50,8", "line 4, column frequency [Hz]", "order 50"),
        ("10,8", "1,8", "line 3, column frequency [Hz]", "order"),
        ("1,1.5,y,5", "", "line 6", "points"),
        ("10,8,y,2", "10,8,north,2", "line 3, column direction", "text"),
    ],
)
def test_faults_of_a_table(read, old, new, key, kind):
    assert old in TABLE
    found, faults = read(TABLE.replace(old, new))
    assert found is None
    check_fault(faults, key, kind)


@pytest.mark.parametrize(
    ("old", "new", "key", "message"),
    [
        ("broadened [m/s2]", "smooth [m/s2]", "line 1", "missing column; expected 'broadened [m"),
        ("1.15,,3", "0.5,,3", "", ""),
        ("2,5,5", "1,5,5", "line 5, column frequency [Hz]", "order"),
    ],
)
def test_faults_of_products(read, old, new, key, message):
    found, faults = read(PRODUCT.replace(old, new))
    assert (found is None) == bool(message)
    assert [fault.key for fault in faults] == ([key] if message else [])
    assert all(message in fault.expected for fault in faults)


def test_no_table(read):
    for text, message in (
        ("", "the file is empty"),
        (TABLE.splitlines()[0], "no row below its header"),
        (PRODUCT.splitlines()[0], "no row below its header"),
    ):
        found, faults = read(text)
        assert found is None and message in faults[0].expected
