"""Logging and progress: on standard error, and in the file of a run."""

from __future__ import annotations

import logging
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from impactfem.system.errors import ImpactfemError, printable
from impactfem.system.stop import Stopped, advised, stop_if_requested, stop_line

LOGGER = logging.getLogger("impactfem")
PROGRESS = LOGGER.getChild("progress")
Step = Callable[[str], AbstractContextManager[None]]
"""`Steps.step`: its block is the step of this name."""
EVERY = 30.0  # time between two lines of progress [s]


class _Visible(logging.Formatter):
    """Lines without control characters, which names of files and foreign values may hold."""

    def format(self, record: logging.LogRecord) -> str:
        """The record; it may have several lines."""
        return "\n".join(map(printable, super().format(record).split("\n")))


class _Errors(logging.StreamHandler):  # type: ignore[type-arg]
    """Writes to standard error, whatever that is at the time."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write the record."""
        self.stream = sys.stderr
        super().emit(record)


# A program that uses this package has its own root logger, with its own level and handlers.
LOGGER.propagate = False
if not LOGGER.handlers:
    _errors = _Errors()
    _errors.setFormatter(_Visible("%(message)s"))
    _errors.setLevel(logging.WARNING)
    LOGGER.addHandler(_errors)


@contextmanager
def root_logger_kept() -> Iterator[None]:
    """The root logger and the display of warnings stay as they are in spite of an import."""
    root, shown = logging.getLogger(), warnings.showwarning
    handlers = root.handlers[:]
    try:
        yield
    finally:
        root.handlers[:] = handlers
        if warnings.showwarning is not shown:
            logging.captureWarnings(False)


def set_up(verbose: bool, rank: int = 0) -> None:
    """Send the log of rank 0 to standard error, with details where `verbose`."""
    LOGGER.setLevel(logging.DEBUG)
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
    """A log file whose failure is an `ImpactfemError`; `logging` would print a traceback."""

    def handleError(self, record: logging.LogRecord) -> None:
        """Raise the error of the file."""
        error = sys.exc_info()[1]
        if isinstance(error, OSError):
            reason = error.strerror or error
            raise ImpactfemError(f"cannot write {self.baseFilename}: {reason}") from error
        super().handleError(record)

    def close(self) -> None:
        """Close the file; a full disk was reported before."""
        with suppress(OSError):
            super().close()


@contextmanager
def mirrored(path: Path, rank: int = 0) -> Iterator[None]:
    """Append the log of rank 0, details included, to a file while the block runs.

    ImpactfemError where the file cannot be written; also by messages in the block.
    """
    if rank != 0:
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
        with advised():
            yield
    except (KeyboardInterrupt, Stopped) as stop:
        line = stop_line(stop.number) if isinstance(stop, Stopped) else "interrupted"
        entry = {"name": LOGGER.name, "msg": line, "levelno": logging.WARNING}
        handler.handle(logging.makeLogRecord(entry | {"levelname": "WARNING"}))
        raise
    finally:
        LOGGER.removeHandler(handler)
        LOGGER.setLevel(level)
        handler.close()


@contextmanager
def quiet(*, warnings: bool = True) -> Iterator[None]:
    """Report warnings only while the block runs, or not even these."""
    level = LOGGER.level
    LOGGER.setLevel(logging.WARNING if warnings else logging.ERROR)
    try:
        yield
    finally:
        LOGGER.setLevel(level)


@contextmanager
def collected_warnings(console: str = "all") -> Iterator[list[str]]:
    """Yield the warnings of the block as they come, each once.

    Args:
        console: What goes to standard error: "all", "progress" (with `-v` also the rest), or
            "nothing".
    """
    warnings: list[str] = []

    def collect(record: logging.LogRecord) -> bool:
        if record.levelno >= logging.WARNING and record.getMessage() not in warnings:
            warnings.append(record.getMessage())
        return False

    def shown(record: logging.LogRecord) -> bool:
        return console == "progress" and record.name == PROGRESS.name

    collector = logging.Handler(logging.WARNING)
    collector.addFilter(collect)
    hidden = [
        handler
        for handler in LOGGER.handlers
        if not isinstance(handler, logging.FileHandler)
        and (console == "nothing" or (console == "progress" and handler.level == logging.INFO))
    ]
    LOGGER.addHandler(collector)
    for handler in hidden:
        handler.addFilter(shown)
    try:
        yield warnings
    finally:
        LOGGER.removeHandler(collector)
        for handler in hidden:
            handler.removeFilter(shown)


class Steps:
    """The named steps of a stage in order, with their expected share of the time.

    A terminal shows a `bar` with the remaining time; elsewhere a line with the title comes `every`
    so many seconds, also where a step does not report how far it is. The log file has the lines in
    any case. `quiet` shows nothing, as on all ranks but the first; the clock gives the time [s].
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
        self._shares, self._title, self._quiet = names, title, quiet
        self._every, self._clock = every, clock
        console = Console(stderr=True)
        self._bar = bar and not quiet and console.is_terminal
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TimeElapsedColumn(),
            TextColumn("remaining"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not self._bar,
        )
        self._task = self._progress.add_task(title, total=sum(names.values()))
        self._before = 0.0  # shares of the steps that are done
        self._now = _Now("", clock())
        self._ended = threading.Event()
        self._reporter = threading.Thread(target=self._report_on, daemon=True)
        self.times: dict[str, float] = {}

    def __enter__(self) -> Steps:
        self._now = _Now("", self._clock())
        self._progress.start()
        if not self._quiet:
            self._reporter.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        if not self._quiet:
            self._reporter.join()
        self._progress.stop()

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Show a step while it runs; its wall time [s] goes to `times`."""
        stop_if_requested()
        self._progress.update(self._task, description=f"{self._title}: {name}")
        before, self._now = self._now, _Now(name, self._clock())
        start = self._now.start
        try:
            yield
        finally:
            self._now = before
        self.times[name] = self._clock() - start
        LOGGER.debug("%s: %.2f s", name, self.times[name])
        self._before += self._shares[name]
        self._progress.update(self._task, completed=self._before)

    def within(self, name: str, part: float) -> None:
        """Show the progress of the current step, as a part from 0 to 1."""
        stop_if_requested()
        self._now.last = (part, self._clock())
        self._now.first = self._now.first or self._now.last
        self._progress.update(self._task, completed=self._before + part * self._shares[name])

    def report(self) -> None:
        """Log the progress of the current step; to files only where a bar is shown."""
        now, names, time = self._now, list(self._shares), self._clock()
        place = ""
        if len(names) > 1 and now.name:
            place = f" (step {names.index(now.name) + 1} of {len(names)})"
        step = f": {now.name}{place}" if now.name else ""
        words = f"{self._title}{step}, {_duration(time - now.start)} elapsed"
        if now.first is not None and now.last is not None:
            (part0, time0), (part, reported) = now.first, now.last
            words += f", {min(int(100.0 * part), 99)} %"  # it has not ended
            if part0 < part < 1.0:
                left = (1.0 - part) * (reported - time0) / (part - part0) - (time - reported)
                words += f", {_duration(max(left, 0.0))} remaining"
        PROGRESS.log(logging.DEBUG if self._bar else logging.INFO, "%s", words)

    def _report_on(self) -> None:
        while not self._ended.wait(self._every):
            try:
                self.report()
            except ImpactfemError:
                return  # the log cannot be written: the next message of the stage says so


@dataclass
class _Now:
    """The current step: its name, "" between two, its start [s], and parts done at times [s].

    A step that continues an earlier run begins with a part that took no time: the speed is that
    from the first to the last part.
    """

    name: str
    start: float
    first: tuple[float, float] | None = None
    last: tuple[float, float] | None = None


def _duration(seconds: float) -> str:
    """A time in seconds up to two minutes, then in minutes, then in hours."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
