"""Results of a run compared with those of a publication."""

import pytest

from impactfem.report.publication import (
    ABSENT,
    DIFFERS,
    GIVEN,
    REPRODUCED,
    SHOWN,
    UNPUBLISHED,
    compared_values,
    count,
    farthest,
    places,
)

NOT_RESULTS = ["input", "fitted", "scaled", "selected", "derived"]


def entry(name="a.b", value=1.0, paper=1.0, kind="result", relation="="):
    about = {"relation": relation, "kind": kind, "note": ""}
    return {"name": name, "value": value, "unit": "m", "paper": paper, **about}


def item(kind="figure", number="1", shows=(), values=(), given=False):
    compared = [{"name": n, "tolerance": t, "reason": r} for n, t, r in values]
    title = {"kind": kind, "number": number, "title": "it", "tells": None, "given": given}
    return {**title, "shows": list(shows), "values": compared}


def place(summary, written=(), **about):
    (found,) = places({"items": [item(**about)]}, summary, written)
    return found


@pytest.mark.parametrize(
    ("value", "paper", "tolerance", "status", "difference"),
    [
        (1.1, 1.0, 0.1 + 1e-12, REPRODUCED, 0.1),
        (1.11, 1.0, 0.1, DIFFERS, 0.11),
        (0.9, 1.0, 0.1 + 1e-12, REPRODUCED, -0.1),
        (-1.2, -1.0, 0.1, DIFFERS, -0.2),
        (0.0, 0.0, 0.0, REPRODUCED, None),
        (1.0, 0.0, 0.5, DIFFERS, None),
        # The stage ran, and what is published does not happen in ours.
        (None, 1.0, 0.1, DIFFERS, None),
        (None, None, 0.1, ABSENT, None),
        (1.0, None, 0.1, ABSENT, None),
    ],
)
def test_a_value(value, paper, tolerance, status, difference):
    found = place([entry(value=value, paper=paper)], values=[("a.b", tolerance, "of a reason")])
    (one,) = found.compared
    assert found.status == one.status == status
    assert one.difference == (None if difference is None else pytest.approx(difference))
    assert one.reason == ("of a reason" if status == DIFFERS else "")


def test_the_worst_value_decides():
    assert place([], values=[("a.b", 0.1, None)]).status == ABSENT
    summary = [entry("a", 1.0), entry("b", 2.0)]
    found = place(summary, values=[("a", 0.1, None), ("b", 0.1, None)])
    assert found.status == DIFFERS
    assert [one.reason for one in found.compared] == ["", "no reason is given"]


@pytest.mark.parametrize(
    ("kind", "written", "status"),
    [
        ("figure", ["figures/figure_01_mesh.png"], UNPUBLISHED),
        ("figure", ["figures/figure_02_mesh.png"], ABSENT),
        ("equation", [], ABSENT),
    ],
)
def test_without_values(kind, written, status):
    found = place([], written, kind=kind, shows=["figures/figure_01*"])
    assert found.status == status
    assert list(found.shows) == (written if status == UNPUBLISHED else [])
    assert list(found.lacking) == ([] if status == UNPUBLISHED else ["figures/figure_01*"])


def test_count_of_places_without_a_number():
    assert place([], kind="equation").status == SHOWN
    assert place([], given=True, kind="table").status == GIVEN
    reference = {"items": [item(number="1"), item(number="2"), item("table", "1")]}
    found = places(reference, [], [])
    assert count(found, "figure") == {UNPUBLISHED: 2} and count(found, "table") == {UNPUBLISHED: 1}


@pytest.mark.parametrize("kind", NOT_RESULTS)
@pytest.mark.parametrize(("value", "status"), [(1.0, GIVEN), (1.2, DIFFERS)])
def test_what_is_no_result_reproduces_nothing_and_may_differ(kind, value, status):
    found = place([entry(value=value, kind=kind)], values=[("a.b", 0.1, "it is so")])
    assert found.status == found.compared[0].status == status
    assert found.compared[0].kind == kind


def test_a_given_value_beside_a_result_does_not_count():
    """The place is what its results are: the given one neither helps nor hides."""
    values = [("a", 0.1, None), ("b", 0.1, None)]
    for value, status in ((1.0, REPRODUCED), (2.0, DIFFERS), (None, DIFFERS)):
        summary = [entry("a", kind="fitted"), entry("b", value)]
        assert place(summary, values=values).status == status


@pytest.mark.parametrize(
    ("relation", "value", "status"),
    [(">", 1.01, REPRODUCED), (">", 0.99, DIFFERS), ("<", 0.99, REPRODUCED), ("<", 1.0, DIFFERS)],
)
def test_an_inequality_holds_or_does_not_whatever_the_tolerance(relation, value, status):
    found = place([entry(value=value, relation=relation)], values=[("a.b", 0.5, None)])
    (one,) = found.compared
    assert (one.status, one.relation) == (status, relation)
    assert one.difference == pytest.approx(value - 1.0)


def test_a_summary_of_before():
    old = {"name": "a.b", "value": 1.0, "unit": "m", "paper": 1.0, "note": ""}
    assert place([old], values=[("a.b", 0.1, None)]).status == REPRODUCED


def test_values_are_counted_once():
    summary = [entry("a"), entry("b", 3.0), entry("c", kind="input")]
    values = [(name, 0.1, None) for name in "abc"]
    reference = {"items": [item(values=values), item("table", "1", values=values)]}
    found = compared_values(places(reference, summary, []))
    assert [one.status for one in found] == [REPRODUCED, DIFFERS, GIVEN]


def test_what_differs_most_is_first():
    """By the ratio: a fifth is farther than twice, and what does not happen is farthest."""
    summary = [
        *(entry(name, value) for name, value in (("near", 1.05), ("twice", 2.0), ("fifth", 0.2))),
        *(entry("none", None), entry("input", 9.0, kind="input")),
    ]
    values = [(one["name"], 0.1, None) for one in summary]
    reference = {"items": [item(values=values), item(number="2", values=values)]}
    found = [one.name for one in farthest(places(reference, summary, []))]
    assert found == ["none", "fifth", "twice"]
