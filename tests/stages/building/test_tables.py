"""Tables of the stage `building`."""

import numpy as np
import pytest

from impactfem.building.floor_properties import UNITS
from impactfem.case.floors import Floor
from impactfem.case.members import Bay
from impactfem.stages.building.stage import building_checks
from impactfem.stages.building.store import OUTPUTS
from impactfem.stages.building.tables import building_tables
from impactfem.stages.building.targets import LEAST_SHARE, bending_modes
from impactfem.stages.stores import dataset
from impactfem.system.files import write_netcdf

from ..figure_file import rows


def stored(folder, direction, **values):
    """The store of two floors of 6 m by 4 m, as no model made it."""
    common = {
        "mode": np.arange(1, len(values["frequency"]) + 1),
        "floor": [1, 2],
        "direction": ["x", "y"],
        "node_position": [[0.0, 0.0, 0.0], [6.0, 4.0, 3.0]],
        "mesh_warning": [],
    }
    attributes = {"building": "B1", "bending_direction": direction}
    store = dataset(OUTPUTS, common | values, attributes=attributes)
    write_netcdf(folder / "building.nc", store)
    return folder


@pytest.fixture
def folder(tmp_path):
    return stored(
        tmp_path,
        "x",
        frequency=[2.0, 3.0, 7.0],
        effective_mass=[[8e3, 0.0], [0.0, 5e3], [1e3, 0.0]],
        residual=np.full(3, 1e-12),
        total_mass=[1e4, 1e4],
        bending_mode=[1, 3],
        floor_added_mass=[1e3, 0.0],
        base_mass=0.0,
        floor_mass=[6e3, 4e3],
        **{f"floor_e{x}": [0.0, 0.03] for x in "xy"},
        **{f"floor_{name}": [2.0, 1.1] for name in UNITS if name != "mass"},
    )


def test_tables_beside_the_published_modes(folder):
    files = building_tables(folder, {"building.frequency.1": 1.6})
    assert [path.name for path in files] == [
        "building_bending_modes.csv",
        "building_modes.csv",
        "building_floor_masses.csv",
    ]
    first, second = rows(files[0])
    assert [float(first[k]) for k in list(first)[:5]] == pytest.approx([1, 1, 2.0, 1.6, 25.0])
    assert second["mode of all"] == "3"


def test_each_size_of_opening_is_counted(folder):
    size = {"wall": "a", "storey": 2, "sill": 0.0, "width": 0.9, "height": 2.1}
    bays = [Bay(bay="4", centre=x, **size) for x in (3.0, 6.0, 9.0)]
    bays.append(Bay(bay="4", centre=12.0, **{**size, "width": 1.8}))
    files = building_tables(folder, {}, (), bays)
    assert files[-1].name == "building_bays.csv"
    found = [[float(cell) for cell in row.values()] for row in rows(files[-1])]
    assert found == [
        pytest.approx([4, 2, 90.0, 210.0, 1.89, 3]),
        pytest.approx([4, 2, 180.0, 210.0, 3.78, 1]),
    ]


@pytest.mark.parametrize(("Jy", "met", "off"), [(0.9, False, "22.2"), (1.0, True, "10")])
def test_inertias_beside_the_floor_table(folder, Jy, met, off):
    """The floor that is farthest off is named; a fifth is the limit."""
    given = {"A": 4.0, "Jx": 1.1, "Jz": 1.1} | dict.fromkeys(("Avy", "Avx", "Ix", "Iy"), 1.0)
    floors = [
        Floor.model_construct(floor=1, **given | dict.fromkeys(("Jx", "Jy", "Jz"), 2.0)),
        Floor.model_construct(floor=2, **given | {"Jy": Jy}),
    ]
    check = building_checks(folder, floors)[-1]
    assert (check.id, check.place) == ("building.floor_inertia", "J_y of floor 2")
    assert check.passed is met and check.value == pytest.approx(float(off) / 100, abs=5e-4)
    *_, inertias, sections = building_tables(folder, {}, floors)
    assert inertias.stem == "building_floor_inertias"
    (first, second), (storey, _) = rows(inertias), rows(sections)
    assert float(first["difference of J_y [%]"]) == pytest.approx(0.0)
    assert float(second["difference of J_y [%]"]) == pytest.approx(float(off), abs=0.05)
    assert [float(cell) for cell in storey.values()][:4] == pytest.approx([1.0, 2.0, 4.0, -50.0])


def test_modes_that_move_the_mass():
    masses = np.array([600.0, 0.0, 9.9, 200.0, 10.0])
    assert bending_modes(masses, 1000.0).tolist() == [0, 3, 4]
    assert bending_modes(masses, 1000.0, 0.5).tolist() == [0]


def test_none_of_local_modes():
    assert bending_modes(np.full(5, 0.9 * LEAST_SHARE * 1000.0), 1000.0).size == 0


IDS = [
    "building.mesh_warnings",
    "building.mass_balance",
    "building.mode_residual",
    "building.bending_modes",
    "building.period_per_storey",
]


@pytest.fixture
def checked(tmp_path):
    """The checks of a store that no model made."""

    def check(*, total=4e5, residual=1e-12, bending=(1,), warnings=(), ey=0.0, first=1.8):
        stored(
            tmp_path,
            "y",
            total_mass=[total, total],
            floor_mass=[2e5, 1e5],
            base_mass=1e5,
            residual=[1e-14, residual],
            frequency=[first, first + 3.42],
            effective_mass=[[0.0, 3e5], [3e5, 0.0]],
            mesh_warning=warnings,
            bending_mode=np.array(bending, dtype=np.int64),
            floor_ex=[0.0, 0.05],
            floor_ey=[0.0, ey],
        )
        return building_checks(tmp_path)

    return check


def test_all_is_well(checked):
    checks = checked()
    assert [check.id for check in checks] == IDS and all(check.passed for check in checks)
    assert [check.value for check in checks] == pytest.approx([0, 0, 1e-12, 1, 0.2778], rel=1e-3)
    assert "(75.0 % of the mass)" in checks[3].detail


@pytest.mark.parametrize(
    ("change", "name", "value"),
    [
        ({"total": 4.04e5}, "mass_balance", 0.0099),
        ({"residual": 1e-3}, "mode_residual", 1e-3),
        ({"bending": ()}, "bending_modes", 0.0),
        ({"first": 0.04}, "period_per_storey", 12.5),
        ({"first": 1e4}, "period_per_storey", 5e-5),
        ({"warnings": ("flat elements", "a hole")}, "mesh_warnings", 2.0),
    ],
)
def test_what_fails(checked, change, name, value):
    (found,) = (check for check in checked(**change) if check.passed is False)
    assert found.id == f"building.{name}" and found.value == pytest.approx(value, rel=1e-2)
    if name == "mesh_warnings":
        assert found.detail == "flat elements; a hole"


def test_a_centre_of_mass_away_from_its_node(checked):
    """Reported from 1 % of the plan on, 4 cm along y; a tenth of the plan is the limit."""
    assert checked(ey=0.039) == checked()
    for ey, passed in ((0.12, True), (0.42, False)):
        check = checked(ey=ey)[-1]
        assert (check.id, check.place) == ("building.mass_centre_distance", "floor 2")
        assert check.passed is passed
