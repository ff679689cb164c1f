"""Plots of a finished run: floor spectra, gap histories and fields on a building.

    run = impactfem.open("runs/towers")
    run.plot.floor_spectrum("west", 3)

Each plot is drawn into matplotlib axes, which are returned. 3D pictures are rendered off-screen.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from impactfem.case.base import nearest
from impactfem.plot.floor_field import COLOURS, colour_scale, plain_ticks
from impactfem.plot.scene import show
from impactfem.plot.style import BLUE, GREEN, ORANGE, own_style
from impactfem.stages.stores import names_of
from impactfem.stages.transient.pictures import field_picture
from impactfem.stages.transient.selection import of_kind
from impactfem.system.errors import Fault, InputError
from impactfem.system.executor import in_own_process


class RunPlots:
    """The plots of a run; `run.plot` is one."""

    def __init__(self, run: Any) -> None:
        self._run = run  # a `Run`, whose module loads this one

    def floor_spectrum(
        self,
        building: str,
        floor: int,
        *,
        direction: str = "",
        damping: float | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Plot the response spectrum of a floor with and without impact.

        The spectra are those of the stick; with a 3D model, also that of its mass centre. The
        frequencies above the resolved band are hatched.

        Args:
            building: Its name.
            floor: Number of the floor.
            direction: "x", "y" or "z"; the main direction of the impacts if empty.
            damping: Damping ratio of the oscillators [-]; the first of the case if None.
            ax: The axes; new ones if None.

        Raises:
            InputError: The run has no such floor, direction or damping.
        """
        store = self._run.pounding
        direction = direction or str(store.attrs["shown_direction"])
        station = self._one(names_of(store, "station"), f"{building}.floor_{floor}", "station")
        self._one(names_of(store, "direction"), direction, "direction")
        ratio = self._damping(store, damping)
        at = {"station": station, "direction": direction, "damping": ratio}
        own = store[["psa", "psa_free"]].sel(at)
        panel = _axes(ax)
        panel.plot(own["frequency"], own["psa"], color=ORANGE, label="with impact")
        look: dict[str, Any] = {"color": BLUE, "ls": "--"}
        panel.plot(own["frequency"], own["psa_free"], label="without impact", **look)
        if "transient" in self._run.stores and building in self._run.buildings_3d:
            response = self._run.of(building).transient
            centres = of_kind(response, "centre")
            here = centres.isel(probe=(centres["probe_floor"] == floor).values)
            for psa in here["psa"].sel(component=direction, damping=ratio):
                label = "3D model, mass centre"
                panel.plot(psa["frequency"], psa, color=GREEN, label=label)
        end, last = float(store.attrs["resolved_frequency"]), float(store["frequency"][-1])
        if end < last:
            panel.axvspan(end, last, facecolor="none", edgecolor="0.6", hatch="///", lw=0.0)
        title = f"{building}, floor {floor}, {direction}, {100.0 * ratio:g} % damping"
        panel.set(xscale="log", xlabel="frequency [Hz]", title=title)
        panel.set(ylabel="pseudo-acceleration [m/s²]", ylim=(0.0, None))
        panel.legend()
        return panel

    def gap(self, pair: str = "", *, ax: Axes | None = None) -> Axes:
        """Plot the gap of a contact pair over time; negative values are penetrations.

        Args:
            pair: Its name; the pair with the largest required gap if empty.
            ax: The axes; new ones if None.

        Raises:
            InputError: The run has no such pair.
        """
        store = self._run.pounding
        pairs = names_of(store, "pair")
        if not pair and pairs:
            pair = pairs[int(store["pair_required_separation"].values.argmax())]
        gap = store["gap"].sel(pair=self._one(pairs, pair, "pair"))
        panel = _axes(ax)
        panel.plot(gap["time"], 1e3 * gap, color=BLUE)
        panel.axhline(0.0, color=ORANGE, ls="--", label="contact")
        panel.set(xlabel="time [s]", ylabel="gap [mm]", title=pair)
        panel.legend()
        return panel

    def building(
        self,
        field: str = "pfa",
        *,
        building: str = "",
        direction: str = "",
        frequency: float | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Plot a field over the floors of a 3D model.

        Args:
            field: "pfa", peak floor acceleration, or "psa", the spectral ordinate at a frequency.
            building: Its name; the first building with a 3D model if empty.
            direction: "x", "y" or "z"; the main direction of the impacts if empty.
            frequency: Of the oscillator of "psa" [Hz]; the nearest computed one is used.
            ax: The axes; new ones if None.

        Raises:
            InputError: The run has no such field.
        """
        run = self._run.of(building) if building else self._run
        maps = run.maps
        self._one(["pfa", "psa"], field, "field")
        direction = direction or str(run.transient.attrs["shown_direction"])
        self._one(names_of(maps, "component"), direction, "direction")
        values, label = maps[field].sel(component=direction), "peak floor acceleration"
        if field == "psa":
            if frequency is None:
                expected = 'expected a frequency [Hz], for example frequency=20.0, with field="psa"'
                raise InputError([Fault(self._run.folder, "frequency", None, expected)])
            values = values.sel(frequency=frequency, method="nearest")
            label = f"pseudo-acceleration at {float(values['frequency']):.3g} Hz"
        scale = colour_scale(values.values)
        picture = in_own_process(field_picture, run.folder, scale(values.values).filled(np.nan))
        rows, columns = picture.image.shape[:2]
        panel = _axes(ax, (5.0 * columns / rows + 1.5, 5.0))
        show(panel, picture)
        name = str(run.transient.attrs["building"])
        panel.set_title(name)
        place: dict[str, Any] = {"shrink": 0.7, "panchor": False}
        bar = panel.figure.colorbar(ScalarMappable(scale, COLOURS), ax=panel, **place)
        plain_ticks(bar, scale)
        bar.set_label(f"{label}, direction {direction} [m/s²]")
        return panel

    def _damping(self, store: xr.Dataset, damping: float | None) -> float:
        known = [float(one) for one in store["damping"]]
        if damping is None:
            return known[0]
        near = min(known, key=lambda one: abs(one - damping))
        if abs(near - damping) > 1e-9:
            expected = f"the damping ratios of this run are: {', '.join(map(str, known))}"
            raise InputError([Fault(self._run.folder, "damping", damping, expected)])
        return near

    def _one(self, known: list[str], name: str, what: str) -> str:
        """Return a name that the run has; else an error with the nearest one."""
        if name not in known:
            raise InputError([Fault(self._run.folder, what, name, nearest(name, known))])
        return name


def _axes(ax: Axes | None, size: tuple[float, float] = (7.0, 4.0)) -> Axes:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    with own_style(**{"figure.dpi": 100.0}):
        return plt.subplots(figsize=size, layout="constrained")[1]
