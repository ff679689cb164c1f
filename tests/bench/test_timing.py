from bench.timing import best_time


def test_the_best_of_several():
    calls = []
    assert best_time(lambda: calls.append(1), 5) >= 0.0
    assert len(calls) == 6  # the first is not timed
