"""The formats of records, and the endings of the files that have them."""

from __future__ import annotations

from typing import Literal

RecordFormat = Literal["csv", "at2", "esm", "cosmos", "csmip", "knet"]

# By the ending, without its dot and in lower case.
FORMAT_OF_ENDING: dict[str, RecordFormat] = {
    "csv": "csv",
    "at2": "at2",
    "v2c": "cosmos",
    **{
        f"{direction}{sensor}": "knet"
        for direction in ("ns", "ew", "ud")
        for sensor in ("", "1", "2")
    },
}
# Of several formats: the content tells. CESMD gives V2 to both of its own.
AMBIGUOUS_ENDINGS = ("asc", "txt", "v2")
