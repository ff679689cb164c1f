"""Small stores of the stages."""

from ..stages.conftest import transient_folder, wall_folder  # noqa: F401
