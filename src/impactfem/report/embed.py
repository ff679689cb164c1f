"""Files as parts of a page that needs nothing beside itself."""

from __future__ import annotations

import base64
import csv
import html
from pathlib import Path

from impactfem.system.errors import ImpactfemError

ROWS = 400
"""Rows of a table that a page shows; the rest is in the file."""

TYPES = {".png": "image/png", ".mp4": "video/mp4"}


def data_address(path: Path) -> str:
    """A picture or film as an address that holds its content."""
    return f"data:{TYPES[path.suffix]};base64,{base64.b64encode(_read(path)).decode()}"


def frame_document(path: Path) -> str:
    """A page as the text of an attribute, for a frame within another page."""
    return html.escape(_read(path).decode("utf-8"), quote=True)


def csv_table(path: Path) -> tuple[list[str], list[list[str]], int]:
    """The header of a CSV table, the rows that are shown, and how many there are."""
    rows = list(csv.reader(_read(path).decode("utf-8").splitlines()))
    if not rows:
        return [], [], 0
    return rows[0], [[cell(text) for text in row] for row in rows[1 : ROWS + 1]], len(rows) - 1


def cell(text: str) -> str:
    """A cell of a table, numbers with five digits."""
    try:
        number = float(text)
    except ValueError:
        return text
    return text if len(text) <= 6 else f"{number:.5g}"


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error.strerror or error}") from error
