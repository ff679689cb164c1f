"""Reading a text file of the user, with a fault in place of an exception."""

from __future__ import annotations

from pathlib import Path

from impactfem.system.errors import Fault

LARGEST = 20_000_000
"""Size of the largest table [byte]."""
LARGEST_TOML = 1_000_000
"""Size of the largest case file [byte]; the paper's has 10,000."""


def read_bytes(path: Path, what: str, largest: float = float("inf")) -> bytes | Fault:
    """The content of a file, or the fault that says why there is none.

    Args:
        path: The file.
        what: What it is expected to be, for the message: ``a case file (TOML)``.
        largest: Largest size [byte].
    """

    def fault(reason: str) -> Fault:
        return Fault(path, "", None, f"{reason}; expected {what}")

    try:
        if path.is_dir():
            return fault("this is a directory")
        if not path.exists():
            return fault("no such file")
        if not path.is_file():
            return fault("this is not an ordinary file")
        size = path.stat().st_size
        if size > largest:
            expected = f"{1e-6 * size:.3g} MB; expected at most {1e-6 * largest:g} MB: {what}"
            return Fault(path, "", None, expected)
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        return fault(f"cannot be read ({getattr(error, 'strerror', None) or error})")
    return content if content.strip() else fault("the file is empty")


def read_text(path: Path, what: str, largest: float = LARGEST) -> str | Fault:
    """The text of a UTF-8 file, or the fault that says why there is none; as `read_bytes`.

    A byte order mark at the beginning, which spreadsheets write, is dropped.
    """
    content = read_bytes(path, what, largest)
    if isinstance(content, Fault):
        return content
    try:
        text = content.decode("utf-8-sig")
        position = text.find("\0")
        reason = f"NUL at position {position}" if position >= 0 else ""
    except UnicodeDecodeError as error:
        text = ""
        reason = f"byte {content[error.start]:#04x} at position {error.start} is not UTF-8"
    return Fault(path, "", None, f"not a text file ({reason}); expected {what}") if reason else text


def wrong_separators(header: str) -> str | None:
    """What separates the columns of a CSV header in place of commas, in words; None for commas."""
    words = {";": "semicolons", "\t": "tabs"}
    return None if "," in header else next((words[sign] for sign in words if sign in header), None)
