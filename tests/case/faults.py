"""The faults that the loader finds in a case."""

from dataclasses import replace
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.system.errors import InputError

from .texts import replaced

JARGON = ("Input should", "pydantic", "https://", "Value error", "type=", "validation", "Tag")


def all_faults(path):
    """Every fault of a case, each once, in no words of pydantic's."""
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert not any(jargon in str(caught.value) for jargon in JARGON)
    faults = caught.value.faults
    assert len({str(fault) for fault in faults}) == len(faults), faults
    return faults


def by_file(path):
    """What was expected, by 'file: key' of each fault."""
    return {f"{Path(f.file).name}: {f.key}": f.expected for f in all_faults(path)}


def faults_of(path):
    """What was found and what was expected, by the key of each fault; no key has two."""
    faults = all_faults(path)
    assert len({fault.key for fault in faults}) == len(faults), faults
    return {fault.key: f"{fault.value} {fault.expected}" for fault in faults}


def own_faults(path):
    """The same; all of them in the case file itself."""
    assert {fault.file for fault in all_faults(path)} == {path}
    return faults_of(path)


def refused(path, key, what):
    """A case has one fault, of a key of it or of 'file: key', of a kind, with its limit."""
    (fault,) = all_faults(path)
    assert (fault.file, fault.key) == (path, key) or f"{Path(fault.file).name}: {fault.key}" == key
    check_fault([fault], fault.key, what)


def check_fault(faults, key, what):
    """Some faults have one of a key and a kind, with the limit or the suggestion behind it."""
    kind, _, limit = what.partition(" ")
    texts = [one.expected for one in faults if (one.key, one.kind) == (key, kind)]
    assert any(limit in text for text in texts), faults


def each_row(tables):
    """One test for each row of tables: a base, the file that is changed, what keys begin with.

    A row is the text that is replaced ("" adds at the end), what stands in its place, the key of
    the fault, its kind, with the limit or the suggestion where it has one, and the keys of further
    faults that follow from it.
    """
    params = [
        pytest.param(base, file, key, row, id=f"{key}{row[2]}-{row[3]}")
        for base, file, key, rows in tables
        for row in rows
    ]
    return pytest.mark.parametrize(("base", "file", "key", "row"), params)


def check_row(written, base, file, key, row):
    """A case with the change of a row has its fault, and no other but those that it says."""
    old, new, last, what, *others = row
    edits = []
    if not old:
        base = replace(base, more=f"{base.more}{new}\n")
    elif file is None and old in base.more:
        base = replace(base, more=replaced(base.more, (old, new)))
    else:
        edits = [(file, old, new)]
    faults = all_faults(written(base, *edits))
    name, found = file or "pair.toml", {fault.key for fault in faults}
    check_fault(faults, key + last, what)
    assert all(Path(one.file).name == name for one in faults if one.key == key + last)
    assert found == {key + last, *others}, faults
