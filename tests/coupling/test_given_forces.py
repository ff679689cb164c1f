"""Impact forces of another program: sign, size and sampling."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.given_forces import (
    doubts,
    given_forces,
    impulses,
    largest_disagreement,
    wrong_signs,
)

GEOMETRY = Path(__file__).parents[2] / "geometry"
PATH = Path("theirs.csv")
STEP, LASTING = 2.5e-4, 8e-3


@pytest.fixture(scope="module")
def case():
    return load_case(GEOMETRY / "row_of_three.toml")


def impacts(case, peaks, step=STEP, lasting=LASTING):
    """Half sines of the pairs of the case, each at a time of its own, over the step of a file."""
    pairs = tuple(contact.name for contact in case.contacts)[: len(peaks)]
    time = step * np.arange(round(2.0 / step) + 1)
    starts = 0.3 + 0.2 * np.arange(len(peaks))
    phase = (time[:, None] - starts) / lasting
    shape = np.where((phase > 0.0) & (phase < 1.0), np.sin(np.pi * phase), 0.0)
    return ForceHistory(time, pairs, np.array(peaks) * shape)


def weight_of(case, j):
    """Weight of the lighter floor of a pair."""
    ends = {(point.building, point.floor) for point, _ in case.contacts[j].ends}
    floors = [(b.name, f) for b in case.buildings for f in b.floors]
    return 9.80665 * min(floor.mass for name, floor in floors if (name, floor.floor) in ends)


def test_forces_of_a_pounding_are_no_doubt(case):
    history = impacts(case, [2.0 * weight_of(case, j) for j in range(3)])
    assert list(wrong_signs(history, PATH, case)) == []
    assert list(doubts(history, PATH, case)) == []
    assert impulses(history)[0] == pytest.approx(
        2.0 * weight_of(case, 0) * LASTING * 2.0 / np.pi, rel=1e-3
    )
    nothing = replace(history, force=np.zeros_like(history.force))
    assert list(wrong_signs(nothing, PATH, case)) == list(doubts(nothing, PATH, case)) == []


@pytest.mark.parametrize("compression", ["positive", "negative"])
def test_all_pairs_in_tension(case, compression):
    transient = load_case(GEOMETRY / "two_frames.toml").transient
    case = case.model_copy(
        update={"transient": transient.model_copy(update={"compression": compression})}
    )
    history = impacts(case, [-1e6, -2e6, 0.0])
    (fault,) = wrong_signs(history, PATH, case)
    other = "negative" if compression == "positive" else "positive"
    assert fault.key == "force" and f'compression = "{other}"' in fault.expected


def test_one_pair_in_tension(case):
    history = impacts(case, [1e6, -2e6, 1e6])
    (fault,) = wrong_signs(history, PATH, case)
    assert fault.key == f"pair {history.pairs[1]}" and "100 %" in fault.expected


def test_what_alternates_about_an_impact_is_no_wrong_sign(case):
    """Band-limited resampling, and the pull of a dashpot at the end of an impact."""
    history = impacts(case, [1e7, 1e7, 1e7])
    ringing = history.force + 0.05 * np.roll(history.force, 40, axis=0)
    ringing -= 0.1 * np.roll(history.force, 32, axis=0)
    assert list(wrong_signs(replace(history, force=ringing), PATH, case)) == []
    ringing -= 0.4 * np.roll(history.force, 32, axis=0)
    changed = replace(history, force=ringing)
    assert list(wrong_signs(changed, PATH, case)) == []
    assert [one.key for one in doubts(changed, PATH, case) if "tension" in one.expected] == [
        f"pair {name}" for name in history.pairs
    ]


@pytest.mark.parametrize(
    ("factor", "told"),
    [(0.3, False), (2.0, False), (2e-3, True), (2e3, True), (150.0, True), (0.0136, True)],
)
def test_forces_against_the_weights_of_floors(case, factor, told):
    """Newtons that are kilonewtons, and the other way round."""
    peaks = [factor * weight_of(case, j) for j in range(3)]
    found = [one for one in doubts(impacts(case, peaks), PATH, case) if "weight" in one.expected]
    assert len(found) == told


@pytest.mark.parametrize(("step", "told"), [(STEP, False), (1e-3, True), (5e-3, True)])
def test_few_samples_in_an_impact(case, step, told):
    history = impacts(case, [5e6, 5e6, 5e6], step)
    found = [one for one in doubts(history, PATH, case) if "samples" in one.expected]
    assert len(found) == told
    if told:
        assert f"step of the file, {1e3 * step:g} ms" in found[0].expected


def test_impulses_of_two_programs(case):
    own = impacts(case, [1e6, 3e6, 10e6])
    assert largest_disagreement(own, own)[1:] == pytest.approx(2 * (impulses(own)[0],))
    name, theirs, ours = largest_disagreement(impacts(case, [1.5e6, 4e6, 9e6]), own)
    assert max(theirs / ours, ours / theirs) < 2.0
    exchanged = impacts(case, [10e6, 3e6, 1e6])
    name, theirs, ours = largest_disagreement(exchanged, own)
    assert name in (own.pairs[0], own.pairs[2])
    assert max(theirs / ours, ours / theirs) == pytest.approx(10.0, rel=1e-6)
    # Pairs that touch in neither, and other names.
    assert largest_disagreement(impacts(case, [0.0, 0.0]), impacts(case, [0.0, 0.0])) is None
    assert largest_disagreement(replace(own, pairs=("a", "b", "c")), own) is None
    # A file that ends early is compared up to its end.
    short = replace(own, time=own.time[:2000], force=own.force[:2000])
    assert largest_disagreement(short, own)[1] == pytest.approx(largest_disagreement(own, short)[1])


def test_compression_that_is_negative(case, tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_text("time [s],a [kN]\n0,0\n1,-5\n")
    transient = load_case(GEOMETRY / "two_frames.toml").transient
    given = transient.model_copy(update={"forces": path})
    assert given_forces(given).force[:, 0].tolist() == [0.0, -5e3]
    flipped = given_forces(given.model_copy(update={"compression": "negative"}))
    assert flipped.force[:, 0].tolist() == [0.0, 5e3]
    assert not np.signbit(flipped.force).any()
    with pytest.raises(ValueError, match="no forces"):
        given_forces(transient)
