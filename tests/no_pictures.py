"""Runs without the figures that stages draw, which take most of the time of a small one."""

from impactfem.stages.drawing import Figures


def no_pictures(patch):
    """Leave out the figures of all stages."""
    patch.setattr(Figures, "draw", lambda *_: [])
