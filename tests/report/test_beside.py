"""A run beside a publication."""

import pytest

from impactfem.report.beside import ABSENT, DIFFERS, REPRODUCED, SHOWN, UNPUBLISHED, count, places


def entry(name="a.b", value=1.0, paper=1.0):
    return {"name": name, "value": value, "unit": "m", "paper": paper, "note": ""}


def item(kind="figure", number="1", shows=(), values=()):
    compared = [{"name": n, "tolerance": t, "reason": r} for n, t, r in values]
    title = {"kind": kind, "number": number, "title": "it", "tells": None}
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


def test_a_result_that_the_run_does_not_have():
    assert place([], values=[("a.b", 0.1, None)]).status == ABSENT


def test_the_worst_value_decides():
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


def test_an_equation_without_a_number():
    assert place([], kind="equation").status == SHOWN


def test_count():
    reference = {"items": [item(number="1"), item(number="2"), item("table", "1")]}
    found = places(reference, [], [])
    assert count(found, "figure") == {UNPUBLISHED: 2} and count(found, "table") == {UNPUBLISHED: 1}
