"""Runs without the figures of stages and report, which take most of the time of a small one."""

from dataclasses import replace

from impactfem.run import report
from impactfem.stages.drawing import Figures


def no_pictures(patch):
    """Leave out the figures of all stages, and that of the report."""
    patch.setattr(Figures, "draw", lambda *_: [])
    patch.setattr(report, "spectra_figure", lambda *_: None)


def one_picture(patch, name):
    """Leave out all figures but that of this name."""
    draw = Figures.draw

    def one(figures, *given):
        wanted = tuple(figure for figure in figures.declared if figure.name == name)
        return draw(replace(figures, declared=wanted), *given)

    no_pictures(patch)
    patch.setattr(Figures, "draw", one)
