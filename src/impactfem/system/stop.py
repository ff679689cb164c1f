"""A stop by a signal: Ctrl-C, a closed terminal, or what batch schedulers send before they kill.

In one process the signal unwinds the program as an error does: half-written files go, the lock of
the folder too. It may be lost in a library, or come during a long computation outside Python: so a
watching thread ends the process where that takes longer. A rank of several does not unwind, as
PETSc frees its objects on all ranks together, and the others know nothing of the signal: it leaves
at once, by the thread where it waits for another rank. `mpirun` then ends the others. All files are
whole at any moment.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from types import FrameType
from typing import Any, Final

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
UNWINDING = 2.0  # time for the unwinding before the process is ended all the same [s]
# `mpirun` kills a second after SIGTERM, so ranks are brief.
WAITING = 0.3  # time in a call of MPI before a rank is ended all the same [s]
GRACE = 0.3  # time that another rank gives rank 0 to report first [s]
TAG = 15  # of the message between ranks that one of them has reported the stop
RANKS = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID")

CHILDREN: set[subprocess.Popen[bytes]] = set()
"""Processes that a stop of this one ends: a thread may wait for them, which no signal reaches."""


class Stopped(BaseException):
    """A signal stops the program; no `Exception`, so that nothing on the way catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class _Answer:
    """The answer to the first signal that stops the program, in the open logs too."""

    def __init__(self) -> None:
        self.number: int | None = None
        self.logs: list[Path] = []
        self.advice = ADVICE
        self.unwound = threading.Event()
        self._taken = threading.Lock()

    def hear(self, number: int, frame: FrameType | None) -> None:
        """Handler of the signals; a further one changes nothing."""
        if self.number is None:
            self.number = number
            # Objects of libraries that the signal interrupts complain when they are collected.
            sys.unraisablehook = lambda _: None
            _end_children()
            if launched() > 1:
                self.leave(number)
            raise Stopped(number)

    def watch(self, end: int) -> None:
        """End the process where a signal came and its unwinding does not end it in time."""
        with os.fdopen(end, "rb", buffering=0) as heard:
            while number := heard.read(1):
                patience = UNWINDING if launched() == 1 else WAITING
                if number[0] in SIGNALS and not self.unwound.wait(patience):
                    self.leave(number[0])

    def leave(self, number: int) -> None:
        """Report the stop, once for all ranks, and end this process as it is."""
        if not self._taken.acquire(blocking=False):
            threading.Event().wait()  # the other thread of this process is about to end it
        _end_children()
        with suppress(RuntimeError):  # the signal came while it was flushed
            sys.stdout.flush()
        if _reports():
            # Without `logging`, whose locks the main thread may hold.
            word, name = SIGNALS[signal.Signals(number)], signal.Signals(number).name
            reason = word if name in word else f"{word} by {name}"
            now = datetime.now().isoformat(" ", "milliseconds").replace(".", ",")  # as in `log`
            for path in self.logs:
                with suppress(OSError), path.open("a", encoding="utf-8") as log:  # on a full disk
                    log.write(f"{now} WARNING {reason}\n")
            line = f"{word}; {self.advice}" if self.logs else word
            try:
                print(line, file=sys.stderr, flush=True)
            except RuntimeError:  # the signal came while something was written there
                os.write(2, f"\n{line}\n".encode())
        os._exit(128 + number)


_answer = _Answer()


def _end_children() -> None:
    for child in tuple(CHILDREN):
        child.kill()


def _reports() -> bool:
    """Whether this rank reports the stop: the first that was stopped, rank 0 before others."""
    if launched() == 1:
        return True
    MPI: Any = getattr(sys.modules.get("mpi4py"), "MPI", None)
    if MPI is None or not MPI.Is_initialized():
        return next((os.environ[name] for name in RANKS if name in os.environ), "0") == "0"
    comm = MPI.COMM_WORLD
    last = time.monotonic() + (GRACE if comm.rank else 0.0)
    while not comm.Iprobe(MPI.ANY_SOURCE, TAG):
        if time.monotonic() > last:
            for other in range(comm.size):
                if other != comm.rank:
                    comm.Isend([b"", 0, MPI.BYTE], other, TAG)
            return True
        time.sleep(0.02)
    return False


@contextmanager
def signals_answered() -> Iterator[None]:
    """Each of `SIGNALS` ends the program while the block runs, in the main thread, and after it.

    One line goes to standard error and to the open logs (`recorded`). The exit code is 128 plus
    the number of the signal, as in a shell. A signal that is ignored stays ignored (`nohup`).
    """
    global _answer
    answer = _answer = _Answer()
    hook = sys.unraisablehook
    read, write = os.pipe()
    os.set_blocking(write, False)
    threading.Thread(target=answer.watch, args=(read,), daemon=True).start()
    woken = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    before = {}
    for number in SIGNALS:
        before[number] = signal.getsignal(number)
        if before[number] is not signal.SIG_IGN:  # `nohup`, a shell's jobs in the background
            signal.signal(number, answer.hear)
    try:
        yield
    finally:
        answer.unwound.set()
        # However the unwinding has ended: a library may have made another error of it.
        if answer.number is not None:
            answer.leave(answer.number)
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(woken)
        os.close(write)
        sys.unraisablehook = hook


@contextmanager
def recorded(path: Path) -> Iterator[None]:
    """A signal that stops the program while the block runs is recorded in a log, too."""
    logs = _answer.logs
    logs.append(path)
    stopped = False
    try:
        yield
    except Stopped:
        stopped = True  # the log is left to `leave`, which comes when all is unwound
        raise
    finally:
        if not stopped:
            logs.remove(path)


def advise(words: str) -> None:
    """Set the advice in the line that reports a stop, where a log is open then."""
    _answer.advice = words
