"""The faults that the loader finds in a case."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.system.errors import InputError


def faults_of(path: Path) -> dict[str, str]:
    """What was found and what was expected, by the key of each fault; no key has two."""
    with pytest.raises(InputError) as caught:
        load_case(path)
    faults = caught.value.faults
    assert len({fault.key for fault in faults}) == len(faults), faults
    return {fault.key: f"{fault.value} {fault.expected}" for fault in faults}


def own_faults(path: Path) -> dict[str, str]:
    """The same; all of them in the case file itself."""
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert {fault.file for fault in caught.value.faults} == {path}
    return faults_of(path)
