"""A stop by a signal: Ctrl-C, a closed terminal, or what batch schedulers send before they kill.

In one process the signal becomes an exception and unwinds the program as an error does: unfinished
files and the lock of the folder go. A second signal ends the process at once. A rank of several
leaves at once: PETSc frees its objects on all ranks together, and `mpirun` ends the other ranks.
All files are whole at any moment.
"""

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Final

from impactfem.system.parallel import launched

SIGNALS: Final = {
    signal.SIGINT: "interrupted",
    signal.SIGTERM: "terminated",
    signal.SIGHUP: "stopped by SIGHUP (terminal closed)",
    signal.SIGUSR1: "stopped by SIGUSR1",
    signal.SIGUSR2: "stopped by SIGUSR2",
    signal.SIGXCPU: "stopped by SIGXCPU (limit of processor time)",
}
"""Signals that stop the program, and the words that report each of them."""
ADVICE = "run again with --resume to go on"
RANKS = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID")


class Stopped(BaseException):
    """A signal stops the program; no `Exception`, so that nothing on the way catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class _State:
    def __init__(self) -> None:
        self.number: int | None = None  #: of the first signal that stops the program
        self.advice: str | None = None  #: to the user

    def take(self) -> int | None:
        """Return the signal and forget it."""
        number, self.number = self.number, None
        return number


_state = _State()


def stop_if_requested() -> None:
    """Raise `Stopped` after a signal whose exception a library has lost; for use between steps."""
    if _state.number is not None:
        raise Stopped(_state.number)


def _stop(number: int, _: FrameType | None) -> None:
    """Answer a signal: end the processes of this one, and unwind."""
    second, _state.number = _state.number is not None, number
    for process in multiprocessing.active_children():
        process.terminate()
    if second or launched() > 1:
        _report(number)
        os._exit(128 + number)
    raise Stopped(number)


def _report(number: int) -> None:
    """Print the line of a stop, once for all ranks."""
    if next((os.environ[name] for name in RANKS if name in os.environ), "0") == "0":
        with suppress(OSError, RuntimeError):  # the signal came while something was written there
            sys.stdout.flush()
            print(stop_line(number), file=sys.stderr, flush=True)


def stop_line(number: int) -> str:
    """The line that reports a stop, with the advice to the user if a folder is open."""
    word = SIGNALS[signal.Signals(number)]
    return word if _state.advice is None else f"{word}; {_state.advice}"


@contextmanager
def signals_answered() -> Iterator[None]:
    """Let each of `SIGNALS` end the program while the block runs, in the main thread.

    One line goes to standard error. The exit code is 128 plus the number of the signal, as in a
    shell. A signal that is ignored stays ignored (`nohup`, jobs of a shell in the background).
    """
    _state.take()
    _state.advice, before = None, {}
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, _stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        # A library may have made another error of the exception.
        stopped = _state.take()
        if stopped is not None:
            _report(stopped)
            raise SystemExit(128 + stopped)


@contextmanager
def advised(words: str = ADVICE) -> Iterator[None]:
    """Report a stop with this advice while the block runs, unless another one is set."""
    before, _state.advice = _state.advice, _state.advice or words
    try:
        yield
    finally:
        if _state.number is None:  # the report of a stop still needs it
            _state.advice = before
