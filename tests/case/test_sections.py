"""Models made from Python or read: derived values, defaults, contact laws."""

import runpy
import sys
from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import RayleighDamping, RecordMotion, Spectra, load_case
from impactfem.case.contacts import (
    ContactEntry,
    HertzDampLaw,
    HuntCrossleyLaw,
    JankowskiLaw,
    expand,
)
from impactfem.records import read_record
from impactfem.spectra import rg_1_122_frequencies

from .sections import GRID, LAW

HERTZ = 'type = "hertz"\nstiffness = "2 N/m^1.5"\n'
DAMPED = {"hertz-damp": HertzDampLaw, "hunt-crossley": HuntCrossleyLaw, "jankowski": JankowskiLaw}


def test_rayleigh_coefficients_of_the_paper():
    α_R, β_R = astuple(RayleighDamping(ratio=0.07, frequencies=(1.0, 20.0)).rayleigh)
    assert α_R == pytest.approx(0.8378, abs=5e-5)  # section 3.2.2
    assert β_R == pytest.approx(1.06e-3, abs=5e-6)  # Table 8


def test_list_of_the_regulatory_guide(broken):
    case = load_case(broken((None, GRID, '{ list = "rg1.122" }')))
    np.testing.assert_array_equal(case.spectra.frequency_values, rg_1_122_frequencies())
    longer = '{ list = "rg1.122", maximum = "500 Hz", per_decade = 50 }'
    case = load_case(broken((None, GRID, longer)))
    np.testing.assert_array_equal(case.spectra.frequency_values, rg_1_122_frequencies(500.0, 50))


def test_design_spectra_by_default():
    spectra = Spectra(damping=(0.05,), frequencies=(1.0, 2.0))
    assert (spectra.broadening, spectra.clipping) == (0.15, False)
    assert Spectra(damping=(0.05,), frequencies=(1.0,), broadening="10 %").broadening == 0.1
    assert Spectra(damping=(0.05,), frequencies=(1.0,), broadening=0, clipping=True).clipping


@pytest.mark.parametrize("name", DAMPED)
def test_damped_laws(broken, name):
    written = HERTZ.replace("hertz", name) + 'restitution = "60 %"\n'
    slowest = {} if name == "jankowski" else {"slowest_approach": 0.005}
    exact = 'relation = "exact"\n' + "".join(f'{key} = "5 mm/s"\n' for key in slowest)
    for text, values in ((written, {}), (written + exact, {"relation": "exact"} | slowest)):
        law = load_case(broken((None, LAW, text))).contact_laws["floor"]
        assert law == DAMPED[name](type=name, stiffness=2.0, restitution=0.6, **values)


def entry(a, b, **more):
    values = {"normal": (0, 3, 4), "gap": 0.01, "law": "floor"} | more
    ends = {"a": {"building": "B1"} | a, "b": {"building": "B2"} | b}
    return ContactEntry.model_validate(ends | values)


def test_contacts_expand_to_pairs():
    first = entry({"floor": [7, 8]}, {"floor": [6, 7]}, bearing_area=2.0)
    second = entry({"floor": 8}, {"storey": 7, "relative_height": 0.5, "offset": (1, 2, 3)})
    contacts = expand((first, second))
    assert [contact.name for contact in contacts] == [
        "B1.floor_7-B2.floor_6",
        "B1.floor_8-B2.floor_7",
        "B1.floor_8-B2.storey_7_at_0.5",
    ]
    assert contacts[0].normal == pytest.approx((0.0, 0.6, 0.8))
    assert (contacts[0].bearing_area, contacts[2].bearing_area) == (2.0, None)
    assert contacts[2].b.offset == (1.0, 2.0, 3.0)
    assert (contacts[2].b.floor, contacts[2].b.storey) == (None, 7)
    # Those of the same floors have names of their own.
    corners = [entry({"floor": 8, "offset": (x, 0, 0)}, {"floor": 8}) for x in (-1, 1, 2)]
    name = "B1.floor_8-B2.floor_8"
    assert [one.name for one in expand(tuple(corners))] == [name, f"{name}#2", f"{name}#3"]


@pytest.mark.parametrize("length", [1e-200, 1.0, 1e200])
def test_normal_is_normalised(length):
    contact = entry({"floor": 1}, {"floor": 1}, normal=(0, -length, 0))
    assert contact.normal == (0.0, -1.0, 0.0)


GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def case():
    return load_case(GEOMETRY / "two_frames.toml")


def test_points_in_contact_are_level_and_the_gap_apart(case):
    """A point of a storey lies in its flexible part, between the rigid zones of its floors."""
    for contact in case.contacts:
        a, b = case.building(contact.a.building), case.building(contact.b.building)
        distance = (b.axis[1] + contact.b.offset[1]) - (a.axis[1] + contact.a.offset[1])
        assert distance == pytest.approx(contact.gap, abs=1e-12)
        assert contact.a.floor is not None
        height = a.elevations[contact.a.floor - 1]
        if contact.b.floor is not None:
            assert b.elevations[contact.b.floor - 1] == pytest.approx(height)
            continue
        assert contact.b.storey is not None and contact.b.relative_height is not None
        low, high = (0.0, *b.elevations)[contact.b.storey - 1 : contact.b.storey + 1]
        assert low + contact.b.relative_height * (high - low) == pytest.approx(height, abs=1e-5)


def test_only_the_roof_of_b_is_level_with_a_floor_of_a(case):
    a, b = (np.array(case.building(name).elevations) for name in "AB")
    near = np.abs(a[:, None] - b).min(axis=0)
    assert near[-1] < 1e-9
    assert np.all(near[:-1] > 0.4)


def test_masses_and_inertias_of_the_floors(case):
    """Plates of 18 m by 12 m and 18 m by 10 m."""
    for name, width in (("A", 12.0), ("B", 10.0)):
        for floor in case.building(name).floors:
            assert floor.Jx == pytest.approx(floor.mass * width**2 / 12.0, rel=0.01)
            assert floor.Jy == pytest.approx(floor.mass * 18.0**2 / 12.0, rel=0.01)
            assert floor.Jz == pytest.approx(floor.Jx + floor.Jy, rel=0.01)


@pytest.mark.parametrize("direction", ["x", "y"])
def test_motions_say_that_they_are_synthetic(case, direction):
    (motion,) = (m for m in case.motions if m.direction == direction)
    assert isinstance(motion, RecordMotion)
    assert "NOT A RECORD" in read_record(motion.file).origin


def test_motions_can_be_made_again(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["two_frames_motion.py", str(tmp_path)])
    runpy.run_path(str(GEOMETRY / "two_frames_motion.py"), run_name="__main__")
    made = {d: read_record(tmp_path / f"two_frames_{d}.AT2").acceleration for d in "xy"}
    for direction, acceleration in made.items():
        shipped = read_record(GEOMETRY / f"two_frames_{direction}.AT2").acceleration
        assert acceleration == pytest.approx(shipped, abs=1e-6)
    assert np.abs(made["x"] - made["y"]).max() > 1.0
