import inspect
import json
import time
from importlib import import_module
from types import SimpleNamespace

import pytest
from rich.console import Console

from bench import suite
from bench.suite import Figure, Watch, as_table, best_time
from bench.transient import basis_figures
from impactfem.system.errors import InputError


@pytest.mark.parametrize(
    ("value", "target", "at_most", "met"),
    [
        (0.2, 0.3, True, True),
        (0.3, 0.3, True, True),
        (0.31, 0.3, True, False),
        (2e9, 1.5e9, False, True),
        (1.5e9, 1.5e9, False, True),
        (1.4e9, 1.5e9, False, False),
        (float("nan"), 0.3, True, False),
        (float("nan"), 0.3, False, False),
        (1.0, None, True, None),
        (1.0, None, False, None),
    ],
)
def test_met(value, target, at_most, met):
    assert Figure("a", value, "s", target, at_most).met is met


def test_table():
    made = [
        Figure("fast", 0.2, "s", 0.3),
        Figure("slow", 1e9, "1/s", 1.5e9, at_most=False),
        Figure("told", 96.0, "-"),
    ]
    console = Console(width=100, record=True, file=None, quiet=False)
    with console.capture() as capture:
        console.print(as_table(made))
    fast, slow, told = [line for line in capture.get().splitlines() if "│" in line][-3:]
    assert "≤ 0.3" in fast and "met" in fast
    assert "≥ 1.5e+09" in slow and "not reached" in slow
    assert "≤" not in told and "met" not in told


def test_json(tmp_path, monkeypatch):
    for name, value in (("sticks", 0.4), ("spectra", 0.2)):
        made = [Figure(name, value, "s", 0.3), Figure(f"{name} steps", 5.0, "-")]
        monkeypatch.setitem(suite.GROUPS, name, lambda made=made: made)
    path = tmp_path / "bench.json"
    found = suite.measure(json_file=path)
    entries = json.loads(path.read_text(encoding="utf-8"))
    assert [entry["name"] for entry in entries] == [figure.name for figure in found]
    assert set(entries[0]) == {"name", "value", "unit", "target", "at_most", "met"}
    assert [entry["met"] for entry in entries] == [False, None, True, None]


def test_groups(monkeypatch):
    for name in suite.GROUPS:
        monkeypatch.setitem(suite.GROUPS, name, lambda name=name: [Figure(name, 1.0, "-")])
    assert [figure.name for figure in suite.measure()] == list(suite.QUICK)
    assert [figure.name for figure in suite.measure(["building"])] == ["building"]
    expected = "GROUP = 'roof': expected one of the groups sticks, spectra"
    with pytest.raises(InputError, match=expected):
        suite.measure(["roof", "sticks"])


def test_every_group_names_a_function():
    """They are loaded where they are measured: nothing else would see another name."""
    for run in suite.GROUPS.values():
        named = inspect.getclosurevars(run).nonlocals
        assert callable(getattr(import_module(f"bench.{named['module']}"), named["function"]))


def test_the_best_of_several():
    calls = []
    assert best_time(lambda: calls.append(1), 5) >= 0.0
    assert len(calls) == 6  # the first is not timed


def test_a_watch_gives_each_function_its_own_part():
    def inner(k):
        time.sleep(0.02)
        return k

    def outer(k):
        return watched.inner(k) + watched.inner(k)

    watched, watch = SimpleNamespace(inner=inner, outer=outer), Watch()
    with (
        watch.on(watched, "inner", "part", lambda k: 3.0 * k),
        watch.on(watched, "outer", "all", lambda k: 1.0),
    ):
        assert watched.outer(5) == 10
    assert (watched.inner, watched.outer) == (inner, outer)
    assert watch.operations == {"part": 30.0, "all": 1.0}
    assert watch.seconds["part"] >= 0.04 and watch.seconds["all"] < 0.02


def test_what_a_watch_sees_fail_is_as_before():
    def fails():
        raise ValueError

    watched, watch = SimpleNamespace(fails=fails), Watch()
    with pytest.raises(ValueError), watch.on(watched, "fails", "a", lambda: 1.0):
        watched.fails()
    assert watched.fails is fails and not watch.operations and watch._inside == [0.0]


@pytest.mark.slow
def test_the_parts_of_a_reduced_building():
    """Each is seen by the names and the arguments of today's functions."""
    found = {one.name: one.value for one in basis_figures("geometry/row_of_three_3d.toml")}
    counted = {name for name in found if name.endswith(", operations")}
    parts = ("factor", "solves", "orthogonalisation", "solves and orthogonalisation at once")
    parts += ("products with M and K", "Galerkin's products")
    assert counted == {f"basis, {part}, operations" for part in parts}
    assert all(found[name] > 0.0 for name in counted)
