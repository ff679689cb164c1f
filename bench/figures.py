"""A performance figure, the table of them, and watches for what a function takes."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from typing import Any, TypeVar

from rich.table import Table

T = TypeVar("T")


@dataclass(frozen=True)
class Figure:
    """One performance figure.

    Args:
        name: What is measured.
        value: The figure.
        unit: Its unit.
        target: What it should reach; None where it is only reported.
        at_most: Whether the target is an upper bound.
    """

    name: str
    value: float
    unit: str
    target: float | None = None
    at_most: bool = True

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one."""
        if self.target is None:
            return None
        return self.value <= self.target if self.at_most else self.value >= self.target


def as_table(figures: list[Figure]) -> Table:
    """The figures for a terminal."""
    table = Table("figure", "value", "unit", "target", "")
    for figure in figures:
        sign = "≤" if figure.at_most else "≥"
        target = "" if figure.target is None else f"{sign} {figure.target:.3g}"
        verdict = {True: "met", False: "MISSED", None: ""}[figure.met]
        table.add_row(figure.name, f"{figure.value:.3g}", figure.unit, target, verdict)
    return table


def timed(run: Callable[[], T]) -> tuple[T, float]:
    """What a function gives, and its wall time [s]."""
    start = time.perf_counter()
    return run(), time.perf_counter() - start


def best_time(run: Callable[[], object], repeats: int) -> float:
    """Shortest of several wall times [s]; a first run, which may compile, does not count."""
    run()
    return min(timed(run)[1] for _ in range(repeats))


class Watch:
    """Wall time and operations by label; of nested functions each has its own part alone.

    What a second thread does meanwhile takes no time of its own: its operations count for what the
    main thread does.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self.operations: dict[str, float] = defaultdict(float)
        self._inside = [0.0]
        self._labels: list[str] = []

    @contextmanager
    def on(
        self, owner: Any, name: str, label: str, operations: Callable[..., float]
    ) -> Iterator[None]:
        """Watch a function or method while the block runs.

        Args:
            owner: Its module or class.
            name: Its name there.
            label: What it counts for.
            operations: Floating-point operations of a call, from its arguments; called after it.
        """
        right = getattr(owner, name)

        @wraps(right)
        def watched(*arguments: Any, **options: Any) -> Any:
            if threading.current_thread() is not threading.main_thread():
                found = right(*arguments, **options)
                doing = self._labels[-1] if self._labels else label
                self.operations[doing] += operations(*arguments, **options)
                return found
            self._inside.append(0.0)
            self._labels.append(label)
            try:
                found, passed = timed(lambda: right(*arguments, **options))
            finally:
                inside = self._inside.pop()
                self._labels.pop()
            self.seconds[label] += passed - inside
            self._inside[-1] += passed
            self.operations[label] += operations(*arguments, **options)
            return found

        setattr(owner, name, watched)
        try:
            yield
        finally:
            setattr(owner, name, right)
