"""The folder of a run: an empty one, or that of an earlier run; one run at a time works in it."""

import errno
import os
import re
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from impactfem.case import Case
from impactfem.system.errors import CONTROL, Fault, InputError
from impactfem.system.files import remove_parts
from impactfem.system.log import LOGGER

LOG = "run.log"  # distinguishes the folder of a run from any other
LOCK = ".lock"
PATIENCE = 0.1
"""Time in which a lock is tried again [s], as its holder may be removing the file just now."""
CASE_LINE = re.compile(r" DEBUG   case (.+), hash ([0-9a-f]{64})$")
# What a file system answers that cannot lock, as some shared ones cannot.
_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}


@contextmanager
def open_folder(folder: Path, resume: bool, log: str = LOG) -> Iterator[None]:
    """Make or check the folder of a run, and keep other runs out while the block runs.

    Half-written files of a killed run are removed. With `resume` it must hold a run already; a
    folder of runs has the log of this name. Not collective: rank 0 opens it for all. InputError
    where the folder may not or cannot be used, or another run works in it; nothing is written then.
    """
    with ExitStack() as held:
        try:
            if resume and not (folder / log).is_file():
                raise _refused(folder, "--resume", "expected a folder that holds a run")
            if CONTROL.search(str(folder)):
                raise _refused(folder, "--out", "expected a name without control characters")
            if folder.exists() and not folder.is_dir():
                raise _refused(folder, "--out", "expected a folder, this is a file")
            if folder.is_dir() and any(folder.iterdir()) and not (folder / log).is_file():
                expected = "expected an empty folder or one of an earlier run"
                raise _refused(folder, "--out", f"{expected}; this one holds other files")
            _refuse_links(folder, "--out")
            folder.mkdir(parents=True, exist_ok=True)
            if not os.access(folder, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            (folder / log).touch()
            held.enter_context(locked(folder, "--out"))
            remove_parts(folder)
        except OSError as error:
            raise _not_writable(folder, "--out", error) from error
        yield


@contextmanager
def locked(folder: Path, key: str = "") -> Iterator[None]:
    """Keep other runs out of the folder of a run while the block runs. Not collective.

    The kernel releases the lock when the process ends, however it ends. InputError where another
    run works in it, or it cannot be written; `key` is the option that names it on the command line,
    "" for an argument.
    """
    path = folder / LOCK
    with ExitStack() as held:
        try:
            _refuse_links(folder, key)
            held.enter_context(FileLock(path, timeout=PATIENCE, fallback_to_soft=False))
            path.write_text(f"process {os.getpid()} on {socket.gethostname()}\n", encoding="utf-8")
        except Timeout:
            holder = path.read_text(errors="replace").strip() if path.is_file() else ""
            expected = f"expected a folder in which no other run works; {holder or 'one'} does now"
            raise _refused(folder, key, expected) from None
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise _not_writable(folder, key, error) from error
            text = "warning: %s cannot be locked (%s): see that no other run works in it"
            LOGGER.warning(text, folder, error.strerror)
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()  # before the lock is released: nobody holds a file that is removed


def check_same_case(folder: Path, case: Case) -> None:
    """Refuse to resume the run in a folder with a case of other content, whatever its name.

    InputError where the last run in the folder had another case.
    """
    lines = (folder / LOG).read_text(encoding="utf-8", errors="replace").splitlines()
    before = [found for line in lines if (found := CASE_LINE.search(line)) is not None]
    # A run that was stopped before it knew its case has computed nothing.
    if before and before[-1][2] != case.content_hash():
        name, digest = before[-1].groups()
        expected = (
            f"the folder holds a run of {name} with the hash {digest[:12]}, and {case.path.name} "
            f"has the hash {case.content_hash()[:12]}: one or more of its texts or files differ; "
            "expected the same case (without --resume what has changed is computed again)"
        )
        raise _refused(folder, "--resume", expected)


def _refuse_links(folder: Path, key: str) -> None:
    """Refuse symbolic links in a folder: files written there would land elsewhere."""
    for path in folder.rglob("*"):
        if path.is_symlink():
            name = path.relative_to(folder)
            raise _refused(folder, key, f"expected no symbolic links in it; {name} is one")


def _refused(folder: Path, key: str, expected: str) -> InputError:
    """The error for a folder that an option names, or, without a key, an argument."""
    if key:
        return InputError([Fault("command line", key, str(folder), expected)])
    return InputError([Fault(folder, "", None, expected)])


def _not_writable(folder: Path, key: str, error: OSError) -> InputError:
    expected = f"expected a folder that can be written: {error.strerror or error}"
    return _refused(folder, key, expected)
