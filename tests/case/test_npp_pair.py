"""The paper's case as it is in geometry/, against the paper."""

from pathlib import Path

import pytest

from impactfem.case import Case, KelvinVoigtLaw, load_case


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case(Path(__file__).parents[2] / "geometry" / "npp_pair.toml")


def test_masses_of_appendix_a(case: Case) -> None:
    # Section 3.1: the modes carry more than 81 % of the mass; 12 742 t is 81.2 % of 15 701 t.
    for building in case.buildings:
        assert sum(floor.mass for floor in building.floors) == pytest.approx(15_701e3)
        assert min(floor.mass for floor in building.floors) == 1574e3  # lightest, section 3.2.2


def test_polar_moments_of_appendix_a(case: Case) -> None:
    """The third moments are close to the sum of the others: a slip of the pen would not be."""
    for floor in case.buildings[0].floors:
        assert floor.Jz == pytest.approx(floor.Jx + floor.Jy, rel=0.03)
        assert floor.Iz == pytest.approx(floor.Ix + floor.Iy, rel=0.12)
        assert floor.Avy < floor.A
        assert floor.Avz < floor.A


def test_heights(case: Case) -> None:
    floors = case.buildings[0].floors
    assert case.buildings[0].elevations[-1] == pytest.approx(30.30, abs=1e-9)  # section 2
    basement, storeys = floors[1], floors[2:]
    assert basement.storey_height_min == basement.storey_height_max == 2.62
    for storey in storeys:
        assert (storey.storey_height_min, storey.storey_height_max) == (3.50, 4.80)


def test_the_points_in_contact_are_the_gap_apart(case: Case) -> None:
    for contact in case.contacts:
        a, b = case.building(contact.a.building), case.building(contact.b.building)
        distance = (b.axis[1] + contact.b.offset[1]) - (a.axis[1] + contact.a.offset[1])
        assert distance == pytest.approx(contact.gap, abs=1e-12)
        assert a.axis[0] == b.axis[0]
        assert contact.bearing_area == pytest.approx(46.20 * 0.30)


def test_parameters_of_table_5(case: Case) -> None:
    law = case.contact_laws["floor"]
    assert isinstance(law, KelvinVoigtLaw)
    assert (law.stiffness, law.damping_ratio, law.tension) == (1e11, 0.12, True)
    assert case.contacts[0].gap == 0.01
    assert case.materials["concrete"].young_modulus == 33e9
    assert case.pounding.duration is not None
    assert case.pounding.duration / case.pounding.time_step == pytest.approx(50_000)


def test_targets_of_tables_2_to_4(case: Case) -> None:
    assert case.calibration is not None
    targets = {(t.building, t.mode): t for t in case.calibration.targets}
    assert list(targets) == [("B1", 1), ("B1", 2), ("B1", 3), ("B2", 1), ("B2", 2), ("B2", 4)]
    # Table 3: the masses of the first three modes of the sticks add up to 12 742 t.
    assert sum(targets["B1", mode].effective_mass for mode in (1, 2, 3)) == 12_742e3
    for (building, mode), target in targets.items():
        for quantity in ("frequency", "effective_mass"):
            published = case.published[f"sticks.{building}.{quantity}.{mode}"]
            assert published.value == getattr(target, quantity)


@pytest.mark.parametrize(
    ("name", "value", "unit"),
    [
        ("motion.pga", 2.32, "m/s2"),
        ("motion.sa_max", 7.17, "m/s2"),
        ("motion.sa_max_frequency", 5.12, "Hz"),
        ("pounding.peak_force.floor_8", 121e6, "N"),
        ("pounding.penetration.floor_8", 1.2e-3, "m"),
        ("pounding.peak_acceleration.floor_8", 37.0, "m/s2"),
        ("pounding.main_impact_time", 3.532, "s"),
        ("pounding.main_impact_duration", 13.1e-3, "s"),
        ("pounding.steps_per_impact_min", 36.0, "-"),
        ("frs.floor_8.peak", 63.8, "m/s2"),
        ("frs.floor_8.peak_frequency", 72.0, "Hz"),
        ("frs.floor_8.pfa", 37.0, "m/s2"),
    ],
)
def test_published(case: Case, name: str, value: float, unit: str) -> None:
    assert case.published[name].value == pytest.approx(value, rel=1e-14)
    assert case.published[name].unit == unit
    assert case.published[name].source
