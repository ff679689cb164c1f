"""Points of line contacts, joined to the pairs that are reported."""

from dataclasses import fields, replace

import numpy as np
import pytest

from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.impacts import Impact, impacts, largest_means, separations
from impactfem.coupling.line_response import line_pairs, with_lines
from impactfem.coupling.pounding import System, simulate

DT = 2.5e-4
NUMBERS = [one.name for one in fields(Impact) if one.name not in ("pair", "index")]


def split(system, along=3.0, slope=0.0):
    """The system with two points of half the area for each pair, on both sides of it."""
    points = []
    for pair in system.pairs:
        for number, s in enumerate((-along, along)):
            ends = {
                side: replace(end, offset=(end.offset[0] + s, *end.offset[1:]))
                for side, end in (("a", pair.a), ("b", pair.b))
            }
            name = f"{pair.name}#2" if number else pair.name
            half = {"law": pair.law.part(0.5), "area": 0.5 * pair.area, "line": pair.name}
            points.append(replace(pair, name=name, gap=pair.gap + slope * s, **ends, **half))
    return System(system.sticks, tuple(points))


def responses(system, ground):
    """With contact and without, by pairs."""
    with_contact = with_lines(simulate(system, ground, DT), system.pairs)
    return with_contact, with_lines(simulate(system.without_contact(), ground, DT), system.pairs)


@pytest.fixture(scope="module")
def central(row, shake):
    """One point for each pair, at the middle of the floors."""
    system, ground = row(gap=0.002), shake()
    return system, ground, *responses(system, ground)


def test_without_lines_nothing_is_joined(central):
    system, _, response, free = central
    assert type(response).__name__ == type(free).__name__ == "Response"
    assert line_pairs(system.pairs)[0] == system.pairs
    assert with_lines(response, system.pairs) is response


def test_two_equal_points_are_one_of_the_whole_area(central):
    """Floors that do not turn: each point has half of the force of the pair."""
    system, ground, response, free = central
    points = split(system)
    line, without = responses(points, ground)
    assert len(line.points) == 2 * len(line.system.pairs) == 4
    assert ForceHistory.of_response(line).ends.line == tuple(p.line for p in points.pairs)
    for one, whole in zip(line.system.pairs, system.pairs, strict=True):
        assert (one.name, one.line, one.area, one.gap) == (whole.name, "", whole.area, whole.gap)
        assert (one.a, one.b, one.law) == (whole.a, whole.b, whole.law)
    size = response.force.max()
    np.testing.assert_allclose(line.force, response.force, atol=1e-7 * size)
    np.testing.assert_allclose(line.point_force[:, ::2], 0.5 * response.force, atol=1e-7 * size)
    found, expected = impacts(line), impacts(response)
    assert len(found) == len(expected) > 3
    for one, other in zip(found, expected, strict=True):
        assert (one.pair.name, one.index, one.steps) == (other.pair.name, other.index, other.steps)
        assert [getattr(one, name) for name in NUMBERS] == pytest.approx(
            [getattr(other, name) for name in NUMBERS], rel=1e-6, abs=1e-6
        )
    means = [largest_means(run.time, run.force) for run in (line, response)]
    assert means[0] == pytest.approx(means[1], rel=1e-7)
    for one, other in zip(separations(without, line), separations(free, response), strict=True):
        assert one.required == pytest.approx(other.required, rel=1e-9)
        assert one.touched == other.touched


def test_the_sum_of_an_eccentric_line(central):
    """A gap that opens along the line: unequal points, their sum as force, the least gap."""
    system, ground, *_ = central
    points = split(system, slope=5e-5)
    by_point = simulate(points, ground, DT)
    line, free = responses(points, ground)
    assert line.u == pytest.approx(by_point.u, abs=0.0)
    assert line.acceleration == pytest.approx(by_point.acceleration, abs=0.0)
    first, second = by_point.force[:, 2:].T  # of the roofs
    assert first.max() > 1.05 * second.max() > 0.0
    np.testing.assert_allclose(line.force[:, 1], first + second, rtol=1e-12)
    np.testing.assert_array_equal(line.gap[:, 1], by_point.gap[:, 2:].min(axis=1))
    found, single = impacts(line), impacts(by_point)
    assert len(found) < len(single)
    largest = max(one.peak_force for one in found)
    assert largest > 1.2 * max(one.peak_force for one in single)
    # Nothing is lost: impulses and energies of the points are those of the lines.
    for name in ("impulse", "dissipated"):
        of_points = sum(getattr(one, name) for one in single)
        assert sum(getattr(one, name) for one in found) == pytest.approx(of_points, rel=1e-6)
    # The gap that avoids contact is that of the point which comes closest.
    apart = simulate(points.without_contact(), ground, DT).closed(points.pairs)[:, 2:]
    rest = np.array([pair.gap for pair in points.pairs[2:]])
    required = separations(free, line)[1].required
    assert required == pytest.approx(np.max(rest.min() - (rest - apart)), rel=1e-12)
    assert required > 1.01 * np.max(rest.min() - (rest.max() - apart))
