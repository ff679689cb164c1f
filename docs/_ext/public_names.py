"""Public names of the project: `[tool.impactfem.public]` of pyproject.toml is their only place.

An empty text there means: not public yet. The pages that need a name are written from templates
with a `PublicNames` (`paper_pages.py`), and say so where a name is not public.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["PublicNames", "public_names"]
ROOT = Path(__file__).parents[2]
LOCAL_IMAGE = "impactfem:local"
"""The name of a container image that the user builds."""


@dataclass(frozen=True)
class PublicNames:
    """Addresses of the project; "" for one that is not public yet."""

    repository: str  #: address of the git repository
    documentation: str  #: address of the built documentation
    image: str  #: name of the container image, with its registry
    package: str  #: name of the package on conda-forge

    @property
    def sources(self) -> str:
        """The shell line that gets the sources and enters their folder."""
        if self.repository:
            return f"git clone {self.repository} impactfem && cd impactfem"
        return "cd impactfem    # the folder of the sources: a clone, or an unpacked archive"

    @property
    def get_image(self) -> str:
        """The shell line that gets the container image, in the folder of the sources."""
        if self.image:
            return f"docker pull {self.image} && docker tag {self.image} {LOCAL_IMAGE}"
        return f"docker build -t {LOCAL_IMAGE} .    # in the folder of the sources"

    @property
    def note(self) -> str:
        """The sentence on names that are not public yet; "" if all are public."""
        words = {
            "repository": "source repository",
            "documentation": "online documentation",
            "image": "container image",
            "package": "conda-forge package",
        }
        missing = [word for key, word in words.items() if not getattr(self, key)]
        if not missing:
            return ""
        return (
            f"No public address exists yet for: {', '.join(missing)}. The steps below start from "
            "a copy of the sources, a clone or an archive."
        )


def public_names(project: Mapping[str, object] | None = None) -> PublicNames:
    """Read the public names.

    Args:
        project: The content of pyproject.toml; the file itself is read when None.

    Raises:
        KeyError: The table is missing.
        TypeError: The table lacks a name, or has another key.
    """
    if project is None:
        project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    return PublicNames(**project["tool"]["impactfem"]["public"])  # type: ignore[index]
