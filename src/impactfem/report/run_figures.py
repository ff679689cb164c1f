"""Pictures of a run as a whole: its map (figure 4), and the building in 3D."""

from __future__ import annotations

from pathlib import Path

from impactfem.report import flowchart, scene_page

OVERVIEW = (flowchart.NAME, scene_page.PAGE)
"""Their names in `figures/`."""


def overview_pictures(folder: Path) -> list[Path]:
    """Draw what shows all stages of a run together, into `figures/`.

    No stage of its own: whichever ran last, they show what is there.

    Args:
        folder: The run's folder.

    Returns:
        The files; the building only where there is one.

    Raises:
        ImpactfemError: A file cannot be written, or OpenGL is missing.
    """
    files = [*flowchart.flowchart_figure(folder), *scene_page.write_scene(folder)]
    # Those of a run before would go with other results.
    for name in OVERVIEW:
        if folder / "figures" / name not in files:
            (folder / "figures" / name).unlink(missing_ok=True)
    return files
