"""A kernel for the notebooks' tests: IPython's, strict about axes, and without a run's own figures.

The figures that a run draws by itself take most of the time of a small one, and have tests of their
own. A figure that a notebook shows without a unit on an axis is an error here.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
from ipykernel.kernelapp import launch_new_instance
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter

from impactfem.plot import floor_products
from impactfem.stages.building import stage as building
from impactfem.stages.calibrate import stage as calibrate
from impactfem.stages.device import stage as device
from impactfem.stages.pounding import stage as sticks
from impactfem.stages.transient import stage as transient

FIGURES = (
    (building, "building_pictures"),
    (calibrate, "wall_figures"),
    (sticks, "stick_figures"),
    (floor_products, "floor_figures"),
    (transient, "transient_figures"),
    (device, "device_figures"),
)


def without_figures() -> None:
    """Leave out what the stages draw."""
    for module, name in FIGURES:
        if not hasattr(module, name):
            raise AttributeError(f"{module.__name__} draws nothing with {name}")
        setattr(module, name, lambda *_, **__: [])


def check_axes() -> None:
    """Refuse open figures whose axes do not say what they show and in which unit.

    Raises:
        ValueError: An axis with numbers has no label, or a label without a unit in brackets.
    """
    for number in plt.get_fignums():
        for axes in plt.figure(number).axes:
            if axes.axison:
                _check(axes.xaxis, "labelbottom")
                _check(axes.yaxis, "labelleft")


def _check(axis: Axis, shown: str) -> None:
    told = axis.get_label().get_text()
    names = isinstance(axis.get_major_formatter(), FuncFormatter)  # as of set_xticks(..., labels)
    hidden = not axis.get_tick_params().get(shown, True) or not len(axis.get_ticklocs())
    if not (names or (hidden and not told)) and not ("[" in told and told.endswith("]")):
        raise ValueError(f"an axis of a figure is labelled {told!r}, without a unit in brackets")


if __name__ == "__main__":
    without_figures()
    show = plt.show

    def checked_show(*arguments: Any, **named: Any) -> None:
        """Show figures that pass."""
        check_axes()
        show(*arguments, **named)

    plt.show = checked_show
    launch_new_instance()
