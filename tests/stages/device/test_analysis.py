"""Which response spectrum analyses are done of a device, and what with."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.case.device_tables import GivenSpectrum
from impactfem.device.combination import Gupta, LindleyYow, Rules
from impactfem.device.models import from_matrices
from impactfem.device.spectrum import AnchorSpectrum, given_spectra
from impactfem.stages.device.analysis import SpectrumPlan, envelopes
from impactfem.stages.device.choice import SpectrumChoice, headline_of
from impactfem.system.errors import ImpactfemError

RULES = {("srss", "none"): Rules(modes="srss"), ("cqc", "none"): Rules(modes="cqc")}
SRSS = ("srss", "none")
K = np.array([[3e6, -3e6, 0.0], [-3e6, 4e6, -1e6], [0.0, -1e6, 1e6]])
LABELS = ["srss", "cqc", "srss, rotations", "cqc, rotations", "srss, broadened", "cqc, broadened"]
LABELS += ["srss, rotations, broadened", "cqc, rotations, broadened"]


def flat(component, value, anchor=1, shift=0.0):
    psa = np.full((2, 2), value)
    ends = np.array([0.1, 1e4])
    return AnchorSpectrum(component, ends, np.array([0.0, 0.9]), psa, value, anchor, shift)


@pytest.fixture
def device():
    """500 kg between two anchors, 14.2 Hz."""
    M = np.diag([0.0, 500.0, 0.0])
    return from_matrices("pipe", M, K, {0: 1, 2: 7}, 0.05, anchors=2)


@pytest.fixture
def single():
    """500 kg on one anchor, 14.2 Hz."""
    spring = 4e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return from_matrices("pump", np.diag([0.0, 500.0]), spring, {0: 1}, 0.05)


def test_all_of_a_device_with_one_anchor(single):
    plan = SpectrumPlan(single, RULES, rotations=True, broadening=0.15, supports=("srss", "abs"))
    found = plan.analyses([flat("y", 2.0), flat("rx", 1.0)], "computed")
    assert [one.label for one in found] == LABELS
    shown = plan.analyses([flat("y", 2.0)], "envelope")
    assert [one.label for one in shown][:2] == ["srss, envelope", "cqc, envelope"]
    plain = SpectrumPlan(single, RULES, rotations=False, broadening=0.0)
    assert [one.label for one in plain.analyses([flat("y", 2.0)], "computed")] == LABELS[:2]
    assert plain.given_analyses() == {}


def test_rules_of_two_supports(device):
    rules = ("srss", "abs", "algebraic", "envelope")
    plan = SpectrumPlan(device, {SRSS: RULES[SRSS]}, False, 0.0, rules)
    spectra = [flat("y", 6.0, 1, 0.002), flat("y", 4.0, 2)]
    found = plan.analyses(spectra, "computed")
    total = {one.label: answer.value("force y at anchor 1") for one, answer in found.items()}
    # The mass follows the anchors by 3/4 and 1/4; a shift between them presses with 0.75e6 N/m.
    m, between = 500.0 * 0.75, 0.75e6 * 0.002
    assert total == pytest.approx(
        {
            "srss": np.hypot(m * np.hypot(6.0 * 0.75, 4.0 * 0.25), between),
            "srss, supports abs": np.hypot(m * (6.0 * 0.75 + 4.0 * 0.25), between),
            "srss, supports algebraic": np.hypot(m * (6.0 * 0.75 + 4.0 * 0.25), between),
            "srss, supports envelope": np.hypot(m * 6.0, between),
        }
    )
    notes = next(iter(found.values())).notes
    assert "combined by 'srss'" in notes[0]
    added = replace(RULES[SRSS], displacements="abs", whole="abs")
    summed = replace(plan, rules={SRSS: added}, supports=("abs",)).analyses(spectra, "computed")
    (answer,) = summed.values()
    assert answer.value("force y at anchor 1") == pytest.approx(m * 5.5 + between)


def test_envelopes_by_component_and_anchor():
    found = envelopes(
        [[flat("y", 2.0, 1, 0.1), flat("x", 9.0)], [flat("y", 3.0)], [flat("y", 1.0, 2)]]
    )
    assert [(s.component, s.anchor, s.zpa) for s in found] == [
        ("y", 1, 3.0),
        ("x", 1, 9.0),
        ("y", 2, 1.0),
    ]
    assert found[0].displacement == 0.1 and found[0].psa.max() == 3.0


def test_in_step_all_anchors_see_the_largest(device):
    plan = SpectrumPlan(device, {SRSS: RULES[SRSS]}, False, 0.0, ("envelope",))
    spectra = [flat("y", 2.0, 1, 0.1), flat("y", 5.0, 2), flat("z", 1.0, 2, 0.3)]
    (answer,) = plan.analyses(spectra, "computed").values()
    seen = [one.spectrum for one in answer.inputs]
    assert {(s.component, s.anchor): (s.zpa, s.displacement) for s in seen} == {
        ("y", 1): (5.0, 0.1),
        ("y", 2): (5.0, 0.0),
        ("z", 1): (1.0, 0.0),
        ("z", 2): (1.0, 0.3),
    }


def of_file(support, damping, *ordinates, frequency=(0.1, 14.0, 100.0)):
    return GivenSpectrum(
        support=support, direction="y", damping=damping, frequency=frequency, acceleration=ordinates
    )


def test_given_spectra(single):
    """Between two dampings the logarithm of the ordinate is linear in the damping."""
    given = given_spectra([of_file(1, 0.1, 1.0, 4.0, 3.0), of_file(1, 0.02, 1.0, 9.0, 3.0)])
    assert [one.label for one in given] == ["spectrum along y at anchor 1"]
    assert given[0].zpa == 3.0 and given[0].damping.tolist() == [0.02, 0.1]
    plan = SpectrumPlan(single, RULES, rotations=True, broadening=0.15, given=given)
    found = plan.given_analyses()
    assert [one.label for one in found] == ["srss, given", "cqc, given"]
    answer = found[SpectrumChoice("srss", source="given")]
    f = answer.modes.frequency[0]
    at = np.exp(np.log(4.0 / 9.0) * 3.0 / 8.0) * 9.0
    end = np.log(3.0 / at) / np.log(100.0 / 14.0)
    start = np.log(at / 1.0) / np.log(140.0)
    slope = end if f > 14.0 else start
    assert answer.value("force y") == pytest.approx(500.0 * at * (f / 14.0) ** slope)
    assert any("last ordinate" in note for note in answer.notes)


def test_spectra_that_do_not_reach_a_mode_are_refused(single):
    short = given_spectra([of_file(1, 0.02, 1.0, 4.0, frequency=(0.1, 5.0))])
    far = given_spectra([of_file(1, 0.02, 1.0, 4.0, frequency=(50.0, 60.0))])
    other = given_spectra([of_file(1, 0.02, 1.0, 4.0, 4.0), of_file(1, 0.03, 1.0, 3.0, 3.0)])
    steep = given_spectra(
        [
            of_file(1, 0.02, 1.0, 9.0, frequency=(0.1, 5.0)),
            of_file(1, 0.1, 1.0, 4.0, frequency=(0.1, 5.0)),
        ]
    )
    for given, message in (
        (far, r"device pump: the spectrum along y at anchor 1 begins at 50 Hz and does not reach"),
        (other, r"was requested; expected dampings on both sides of the modes'"),
        (steep, r"ends at 5 Hz with 4, which is not its zero-period acceleration 9"),
    ):
        with pytest.raises(ImpactfemError, match=message):
            SpectrumPlan(single, RULES, False, 0.0, given=given).given_analyses()
    # One that ends at its zero-period acceleration says what a higher mode gets; that is told.
    with pytest.raises(ImpactfemError, match="both sides"):
        SpectrumPlan(single, RULES, False, 0.0, given=short).given_analyses()


RIGID = {
    ("srss", "none"): Rules(modes="srss"),
    ("srss", "gupta"): Rules(modes="srss", rigid=Gupta()),
    ("srss", "lindley-yow"): Rules(modes="srss", rigid=LindleyYow()),
}


def hill(end):
    """A peak at 1 to 3 Hz, at its zero-period acceleration of 2 m/s2 from `end` on."""
    frequency = np.array([0.1, 1.0, 3.0, end, 20.0])
    psa = np.tile([1.0, 8.0, 8.0, 2.0, 2.0], (2, 1))
    return AnchorSpectrum("y", frequency, np.array([0.0, 0.9]), psa, 2.0)


def test_every_rigid_part_beside_none(single):
    """The mode at 14.2 Hz follows a floor that is rigid from 12 Hz on, whatever the method."""
    plan = SpectrumPlan(single, RIGID, rotations=False, broadening=0.15)
    found = plan.analyses([hill(12.0)], "computed")
    assert [one.label for one in found] == [
        *("srss", "srss, gupta", "srss, lindley-yow"),
        *("srss, broadened", "srss, gupta, broadened", "srss, lindley-yow, broadened"),
    ]
    rigid = [
        answer.inputs[0].rigid_fraction.max() for one, answer in found.items() if not one.broadened
    ]
    assert rigid == pytest.approx([0.0, 1.0, 1.0])


def test_a_rigid_part_that_the_spectrum_says_too_little_for(single):
    """A further method is left out and a note says so; the first one is an error, as before."""
    steep = replace(hill(12.0), zpa=1.0)
    plan = SpectrumPlan(single, RIGID, rotations=False, broadening=0.0)
    found = plan.analyses([steep], "computed")
    assert [one.label for one in found] == ["srss", "srss, lindley-yow"]
    for answer in found.values():
        (note,) = (one for one in answer.notes if "rigid part" in one)
        assert "spectrum ends before" in note
    for order in ([("srss", "gupta")], [("srss", "gupta"), ("srss", "none")]):
        first = replace(plan, rules={key: RIGID[key] for key in order})
        with pytest.raises(ImpactfemError, match=r"device pump: .*before"):
            first.analyses([steep], "computed")


def test_the_headline_is_the_first_rigid_part_of_the_preferred_combination():
    rules = [("cqc", "gupta"), ("srss", "gupta"), ("srss", "none")]
    assert headline_of(rules).label == "srss, gupta"
    assert headline_of([("abs", "none")]).label == "abs"
