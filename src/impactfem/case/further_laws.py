"""Keys of further contact laws in the case file, for laws outside this package."""

from __future__ import annotations

from typing import Annotated, Union, get_args

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.load import section_adapter
from impactfem.case.model import Case, CaseFile


def add_law(keys: type[Section]) -> None:
    """Accept a further ``type`` in [contact_laws], with the keys of a section."""
    for model in (CaseFile, Case):
        info = model.model_fields["contact_laws"]
        name, entry = get_args(info.annotation)
        laws = Union[(*get_args(get_args(entry)[0]), keys)]  # type: ignore[valid-type]
        info.annotation = dict[name, Annotated[laws, Field(discriminator="type")]]  # type: ignore[valid-type]
        model.model_rebuild(force=True)
    section_adapter.cache_clear()
