"""Wall times."""

from __future__ import annotations

import time
from collections.abc import Callable


def best_time(run: Callable[[], object], repeats: int) -> float:
    """Shortest of several wall times [s]; a first run, which may compile, does not count.

    Args:
        run: What is timed.
        repeats: How often.
    """
    run()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)
