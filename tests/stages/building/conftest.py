"""Fixtures of buildings."""

from ...building.conftest import (  # noqa: F401
    assembled,
    csr,
    frame_file,
    house,
    new_panels,
    panels,
    small_file,
    small_geometry,
    small_mesh,
    small_raw,
    turn,
)
