"""Logging and progress: on a terminal, in a pipe, and in the run's own file."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from impactfem.errors import ImpactfemError
from impactfem.stop import recorded

LOGGER = logging.getLogger("impactfem")


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
    handler.setFormatter(logging.Formatter("%(message)s"))
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
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)-7s %(message)s"))
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
    """Reports go to files only while the block runs; the details that `-v` asks for still come.

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
        handler.setLevel(logging.CRITICAL)
    try:
        yield kept.messages
    finally:
        LOGGER.removeHandler(kept)
        for handler in handlers:
            handler.setLevel(logging.INFO)


class Steps:
    """The named steps of a run, with a bar and the remaining time on a terminal.

    Args:
        names: The steps in order, with their expected share of the time.
        quiet: Whether nothing is shown, as on all ranks but the first.
    """

    def __init__(self, names: dict[str, float], *, quiet: bool = False) -> None:
        self._shares = names
        self._console = Console(stderr=True)
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TimeElapsedColumn(),
            TextColumn("remaining"),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
            disable=quiet or not self._console.is_terminal,
        )
        self._task = self._progress.add_task("", total=sum(names.values()))
        self._before = 0.0
        self.times: dict[str, float] = {}

    def __enter__(self) -> Steps:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """One step: shown while it runs, its wall time [s] kept in `times`."""
        self._progress.update(self._task, description=name)
        start = time.perf_counter()
        yield
        self.times[name] = time.perf_counter() - start
        LOGGER.debug("%s: %.2f s", name, self.times[name])
        self._before += self._shares[name]
        self._progress.update(self._task, completed=self._before)

    def within(self, name: str, part: float) -> None:
        """Show how far the current step is, as a part from 0 to 1."""
        self._progress.update(self._task, completed=self._before + part * self._shares[name])
