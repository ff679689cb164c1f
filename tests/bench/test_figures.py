import time
from types import SimpleNamespace

import pytest

from bench.figures import Watch, best_time


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
