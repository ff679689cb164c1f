"""A kernel for the notebooks' tests: IPython's, strict about axes, and without a run's own figures.

With `--film` a run draws the film that a notebook shows.

The figures that a run draws by itself take most of the time of a small one, and have tests of their
own. A figure that a notebook shows without a unit on an axis is an error here.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from ipykernel.kernelapp import launch_new_instance
from matplotlib.ticker import FuncFormatter

sys.path.insert(0, str(Path(__file__).parents[1]))
from no_pictures import no_pictures, one_picture


def check_axes():
    """ValueError where an axis with numbers has no label, or one without a unit in brackets."""
    for number in plt.get_fignums():
        for axes in plt.figure(number).axes:
            if axes.axison:
                _check(axes.xaxis, "labelbottom")
                _check(axes.yaxis, "labelleft")


def _check(axis, shown):
    told = axis.get_label().get_text()
    names = isinstance(axis.get_major_formatter(), FuncFormatter)  # as of set_xticks(..., labels)
    hidden = not axis.get_tick_params().get(shown, True) or not len(axis.get_ticklocs())
    if not (names or (hidden and not told)) and not ("[" in told and told.endswith("]")):
        raise ValueError(f"an axis of a figure is labelled {told!r}, without a unit in brackets")


if __name__ == "__main__":
    if "--film" in sys.argv:
        sys.argv.remove("--film")
        one_picture(pytest.MonkeyPatch(), "main_impact_loop")
    else:
        no_pictures(pytest.MonkeyPatch())
    show = plt.show

    def checked_show(*arguments, **named):
        """Show figures that pass."""
        check_axes()
        show(*arguments, **named)

    plt.show = checked_show
    launch_new_instance()
