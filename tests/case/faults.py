"""The faults that the loader finds in a case."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.system.errors import Fault, InputError

JARGON = ("Input should", "pydantic", "https://", "Value error", "type=", "validation", "Tag")


def all_faults(path: Path) -> tuple[Fault, ...]:
    """Every fault of a case, each once, in no words of pydantic's."""
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert not any(jargon in str(caught.value) for jargon in JARGON)
    faults = caught.value.faults
    assert len({str(fault) for fault in faults}) == len(faults), faults
    return faults


def by_file(path: Path) -> dict[str, str]:
    """What was expected, by 'file: key' of each fault."""
    return {f"{Path(f.file).name}: {f.key}": f.expected for f in all_faults(path)}


def faults_of(path: Path) -> dict[str, str]:
    """What was found and what was expected, by the key of each fault; no key has two."""
    faults = all_faults(path)
    assert len({fault.key for fault in faults}) == len(faults), faults
    return {fault.key: f"{fault.value} {fault.expected}" for fault in faults}


def own_faults(path: Path) -> dict[str, str]:
    """The same; all of them in the case file itself."""
    assert {fault.file for fault in all_faults(path)} == {path}
    return faults_of(path)


def refused(path: Path, key: str, words: str) -> None:
    """A case has one fault, of a key of it or of 'file: key', with these words."""
    (fault,) = all_faults(path)
    assert (fault.file, fault.key) == (path, key) or f"{Path(fault.file).name}: {fault.key}" == key
    assert words in f"{fault.value} {fault.expected}"
