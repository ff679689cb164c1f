"""Logging and progress: on a terminal, in a pipe, and in the run's own file."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from impactfem.system.errors import ImpactfemError, printable
from impactfem.system.stop import recorded

LOGGER = logging.getLogger("impactfem")
PROGRESS = LOGGER.getChild("progress")
EVERY = 10.0
"""Time between two lines that tell how far a stage is [s]."""


class _Visible(logging.Formatter):
    """Lines without control characters, which names of files and values of others may hold."""

    def format(self, record: logging.LogRecord) -> str:
        """The record, its own line ends kept."""
        return "\n".join(map(printable, super().format(record).split("\n")))


def set_up(verbose: bool, rank: int = 0) -> None:
    """Send the log to standard error: everything with `verbose`, else warnings and what matters.

    Args:
        verbose: Whether details are shown.
        rank: Rank of this process; only rank 0 speaks.
    """
    LOGGER.setLevel(logging.DEBUG)
    LOGGER.propagate = False
    for handler in [h for h in LOGGER.handlers if not isinstance(h, logging.FileHandler)]:
        LOGGER.removeHandler(handler)
    if rank != 0:
        LOGGER.addHandler(logging.NullHandler())
        return
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_Visible("%(message)s"))
    handler.setLevel(logging.DEBUG if verbose else logging.INFO)
    LOGGER.addHandler(handler)


class _File(logging.FileHandler):
    """A log file that says when it cannot be written; `logging` would print a traceback."""

    def handleError(self, record: logging.LogRecord) -> None:
        """Raise what has happened."""
        error = sys.exc_info()[1]
        if isinstance(error, OSError):
            reason = error.strerror or error
            raise ImpactfemError(f"cannot write {self.baseFilename}: {reason}") from error
        super().handleError(record)

    def close(self) -> None:
        """Close the file; what a full disk does not take is left out, as was said before."""
        with suppress(OSError):
            super().close()


@contextmanager
def mirrored(path: Path, rank: int = 0) -> Iterator[None]:
    """Mirror the log to a file while the block runs, details included.

    Args:
        path: The file; appended to.
        rank: Rank of this process; only rank 0 writes, but for a stop by a signal.

    Raises:
        ImpactfemError: The file cannot be written; also from what is logged in the block.
    """
    if rank != 0:
        with recorded(path):
            yield
        return
    try:
        handler = _File(path, encoding="utf-8")
    except OSError as error:
        raise ImpactfemError(f"cannot write {path}: {error.strerror or error}") from error
    handler.setFormatter(_Visible("%(asctime)s %(levelname)-7s %(message)s"))
    level = LOGGER.level
    LOGGER.setLevel(logging.DEBUG)
    LOGGER.addHandler(handler)
    try:
        with recorded(path):
            yield
    except KeyboardInterrupt:  # of a program that uses this package; the command line has `stop`
        LOGGER.debug("interrupted")
        raise
    finally:
        LOGGER.removeHandler(handler)
        LOGGER.setLevel(level)
        handler.close()


@contextmanager
def quiet() -> Iterator[None]:
    """Without reports while the block runs; warnings still come."""
    level = LOGGER.level
    LOGGER.setLevel(logging.WARNING)
    try:
        yield
    finally:
        LOGGER.setLevel(level)


class _Distinct(logging.Handler):
    """Keeps the warnings that it is given, each once."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a warning."""
        self.messages.add(record.getMessage())


@contextmanager
def in_file_only() -> Iterator[set[str]]:
    """Reports go to files only while the block runs, but for lines of progress and for `-v`.

    Yields:
        The warnings of the block, each once.
    """
    kept = _Distinct()
    handlers = [
        handler
        for handler in LOGGER.handlers
        if not isinstance(handler, logging.FileHandler) and handler.level == logging.INFO
    ]
    LOGGER.addHandler(kept)
    for handler in handlers:
        handler.addFilter(_is_progress)
    try:
        yield kept.messages
    finally:
        LOGGER.removeHandler(kept)
        for handler in handlers:
            handler.removeFilter(_is_progress)


def _is_progress(record: logging.LogRecord) -> bool:
    return record.name == PROGRESS.name


class Steps:
    """The named steps of a stage, and how far it is.

    A terminal shows a bar with the remaining time; elsewhere a line comes every ten seconds, also
    where a step does not say how far it is. The log file has the lines in any case.

    Args:
        names: The steps in order, with their expected share of the time.
        title: What they are the steps of, for the lines.
        quiet: Whether nothing is shown, as on all ranks but the first.
        bar: Whether a bar is shown on a terminal.
        every: Time between two lines [s].
        clock: Gives the time [s].
    """

    def __init__(
        self,
        names: Mapping[str, float],
        title: str = "",
        *,
        quiet: bool = False,
        bar: bool = True,
        every: float = EVERY,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._shares = names
        self._title = title
        self._quiet = quiet
        self._every = every
        self._clock = clock
        self._console = Console(stderr=True)
        self._bar = bar and not quiet and self._console.is_terminal
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TimeElapsedColumn(),
            TextColumn("remaining"),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
            disable=not self._bar,
        )
        self._task = self._progress.add_task(title, total=sum(names.values()))
        self._before = 0.0
        self._now = _Now("", clock())
        self._ended = threading.Event()
        self._teller = threading.Thread(target=self._tell_on, daemon=True)
        self.times: dict[str, float] = {}

    def __enter__(self) -> Steps:
        self._now = _Now("", self._clock())
        self._progress.start()
        if not self._quiet:
            self._teller.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        if not self._quiet:
            self._teller.join()
        self._progress.stop()

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """One step: shown while it runs, its wall time [s] kept in `times`."""
        self._progress.update(self._task, description=f"{self._title}: {name}")
        before, start = self._now, self._clock()
        self._now = _Now(name, start)
        try:
            yield
        finally:
            self._now = before
        self.times[name] = self._clock() - start
        LOGGER.debug("%s: %.2f s", name, self.times[name])
        self._before += self._shares[name]
        self._progress.update(self._task, completed=self._before)

    def within(self, name: str, part: float) -> None:
        """Show how far the current step is, as a part from 0 to 1."""
        self._now.report(part, self._clock())
        self._progress.update(self._task, completed=self._before + part * self._shares[name])

    def tell(self) -> None:
        """Log how far the current step is; to files only where a bar is shown."""
        now, names = self._now, list(self._shares)
        which = f": {now.name} ({names.index(now.name) + 1} of {len(names)})" if now.name else ""
        level = logging.DEBUG if self._bar else logging.INFO
        PROGRESS.log(level, "%s%s, %s", self._title, which, now.told(self._clock()))

    def _tell_on(self) -> None:
        while not self._ended.wait(self._every):
            try:
                self.tell()
            except ImpactfemError:
                return  # the log cannot be written: what the stage logs next says so


class _Now:
    """How far a step is.

    Args:
        name: Its name; "" between two steps.
        start: When it began [s].
    """

    def __init__(self, name: str, start: float) -> None:
        self.name = name
        self._start = start
        # A step that goes on with work of an earlier run begins with a part that took no time.
        self._first: tuple[float, float] | None = None
        self._last: tuple[float, float] | None = None

    def report(self, part: float, time: float) -> None:
        """Take note that a part from 0 to 1 is done at a time [s]."""
        self._last = (part, time)
        self._first = self._first or self._last

    def told(self, time: float) -> str:
        """In words: elapsed time, and the part that is done and the time left where known."""
        words = f"at work for {_duration(time - self._start)}"
        if self._first is None or self._last is None:
            return words
        (part0, time0), (part, reported) = self._first, self._last
        words += f", {min(int(100.0 * part), 99)} %"  # it has not ended
        if part <= part0 or part >= 1.0:
            return words
        left = (1.0 - part) * (reported - time0) / (part - part0) - (time - reported)
        return f"{words}, {_duration(max(left, 0.0))} left"


def _duration(seconds: float) -> str:
    """A time for people: in seconds up to two minutes, then in minutes, then in hours."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
