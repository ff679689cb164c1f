"""Mass and stiffness of a device from files."""

from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case.device_tables import DeviceMatrices, NamedMatrix, read_matrix
from impactfem.system.errors import Fault

TABLE = """\
# N/m
1.y,middle y,2.y
3e6,-3e6,0
-3e6,4e6,-1e6
0,-1e6,1e6
"""
Read = Callable[[str], tuple[NamedMatrix | None, list[Fault]]]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def of(text: str) -> tuple[NamedMatrix | None, list[Fault]]:
        faults: list[Fault] = []
        path = tmp_path / "matrix.csv"
        path.write_text(text, encoding="utf-8")
        return read_matrix(path, faults), faults

    return of


def test_a_matrix(read: Read) -> None:
    found, faults = read(TABLE)
    assert found is not None and not faults
    assert found.names == ("1.y", "middle y", "2.y")
    assert found.rows[1] == (-3e6, 4e6, -1e6)


@pytest.mark.parametrize(
    ("old", "new", "key", "message"),
    [
        ("-1e6,1e6", "-1e6,1e6,0", "line 5", "expected 3 cells as in the header, found 4"),
        (
            "0,-1e6,1e6\n",
            "",
            "line 2",
            "expected 3 rows below the header, as it has names; found 2",
        ),
        ("4e6", "stiff", "line 4", "expected a finite number"),
        ("4e6", "inf", "line 4", "expected a finite number"),
        ("2.y", "1.y", "line 2", "names that are all different; found 1.y twice"),
        ("1.y,middle y,2.y", "1,2,3", "line 2", "found numbers"),
        ("1.y,middle y,2.y", "1.y,,2.y", "line 2", "one is empty"),
        ("0,-1e6", "0,-2e6", "2.y, middle y", "symmetric matrix, found -1e+06 at middle y, 2.y"),
    ],
)
def test_faults(read: Read, old: str, new: str, key: str, message: str) -> None:
    found, faults = read(TABLE.replace(old, new))
    assert found is None
    assert any(fault.key == key and message in fault.expected for fault in faults), faults


def matrices(*names: str) -> DeviceMatrices:
    none = tuple(tuple(0.0 for _ in names) for _ in names)
    return DeviceMatrices(mass=NamedMatrix(names, none), stiffness=NamedMatrix(names, none))


def test_which_motion_is_whose() -> None:
    found = matrices("1.y", "2.rx", "tip", "3.y above", "10.z")
    assert found.anchored == {0: 1, 1: 9, 4: 56}
    assert found.own == ("tip", "3.y above")


@pytest.mark.parametrize(
    ("names", "supports", "message"),
    [
        (("1.y", "tip"), 2, "no motion of support 2; expected at least one of 2.x, 2.y"),
        (("1.y", "2.y", "3.y", "tip"), 2, "have a support 3, the device has 2"),
        (("1.y", "2.y"), 2, "expected motions of the device's own"),
    ],
)
def test_beside_the_supports(names: tuple[str, ...], supports: int, message: str) -> None:
    (found,) = matrices(*names).lacks(supports)
    assert message in found
    assert not list(matrices("1.y", "2.y", "tip").lacks(2))
