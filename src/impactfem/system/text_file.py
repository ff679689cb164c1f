"""Reading a text file of the user, with a fault in place of an exception."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from impactfem.system.errors import Fault

LARGEST = 20_000_000
"""Size of the largest table [byte]."""
LARGEST_TOML = 1_000_000
"""Size of the largest case file [byte]; the paper's has 10,000."""


def read_bytes(path: Path, what: str) -> bytes | Fault:
    """The content of a file, or the fault that says why there is none.

    Args:
        path: The file.
        what: What it is to be, for the message: ``a case file (TOML)``.
    """
    try:
        if path.is_dir():
            return Fault(path, "", None, f"this is a directory; expected {what}")
        if not path.exists():
            return Fault(path, "", None, f"no such file; expected {what}")
        if not path.is_file():
            return Fault(path, "", None, f"this is not an ordinary file; expected {what}")
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        return Fault(path, "", None, f"cannot be read ({reason}); expected {what}")
    if not content.strip():
        return Fault(path, "", None, f"the file is empty; expected {what}")
    return content


def read_text(path: Path, what: str, largest: float = LARGEST) -> str | Fault:
    """The text of a UTF-8 file, or the fault that says why there is none.

    A byte order mark at the beginning is dropped: spreadsheets write one.

    Args:
        path: The file.
        what: As for `read_bytes`.
        largest: Largest size of the file [byte].
    """
    with suppress(OSError, ValueError):  # which `read_bytes` explains
        size = path.stat().st_size
        if path.is_file() and size > largest:
            expected = f"{1e-6 * size:.3g} MB; expected at most {1e-6 * largest:g} MB: {what}"
            return Fault(path, "", None, expected)
    content = read_bytes(path, what)
    if isinstance(content, Fault):
        return content
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        byte = content[error.start]
        where = f"byte {byte:#04x} at position {error.start} is not UTF-8"
        return Fault(path, "", None, f"not a text file ({where}); expected {what}")
    position = text.find("\0")
    if position >= 0:
        return Fault(
            path, "", None, f"not a text file (NUL at position {position}); expected {what}"
        )
    return text


def wrong_separators(header: str) -> str | None:
    """What separates the columns of a CSV header in place of commas, in words; None for commas.

    Args:
        header: The line with the names of the columns; no name holds a separator.
    """
    if "," in header:
        return None
    return next(
        (words for sign, words in ((";", "semicolons"), ("\t", "tabs")) if sign in header), None
    )
