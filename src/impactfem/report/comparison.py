"""Floor response spectra of two runs of a 3D building, point by point; tables and a figure."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, RED, figure, letter, span
from impactfem.plot.table import Cell, Table, heads
from impactfem.spectra.frequency_list import SAME, interpolate_frequency, merged_frequencies
from impactfem.stages.check import QUIET
from impactfem.stages.stores import names_of
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError

Flags = NDArray[np.bool_]

STORE, FIGURE = "comparison.nc", "comparison_spectra.svg"
CASES, TABLE, DIRECTIONS = "comparison_cases", "comparison_spectra", "comparison_directions"
NEAR = 0.05
"""Difference of which the table of the directions counts the ordinates that are within it."""
ALIKE = 0.05
"""Part of the height, length and width of a building by which another one may differ from it."""
STILL = 1e-3
"""Largest peak acceleration along an axis, over that along all, up to which it is not compared."""
LEAST = 20
"""Least number of frequencies that are compared, where neither run has fewer itself."""


@dataclass(frozen=True)
class Side:
    """One of the two runs."""

    response: xr.Dataset  #: its `transient.nc`
    building: xr.Dataset  #: its `building.nc`
    case_file: str  #: name of its case file
    folder: Path  #: its folder, as the user wrote it
    pounding: str = ""  #: what pounded, in words

    @property
    def frequency(self) -> Array:
        """Frequencies of its spectra, shape (n_f,) [Hz]."""
        return np.asarray(self.response["frequency"].values, dtype=np.float64)

    @property
    def damping(self) -> Array:
        """Dampings of its spectra, shape (n_damping,) [-]."""
        return np.asarray(self.response["damping"].values, dtype=np.float64)

    @property
    def probes(self) -> list[str]:
        """Names of its points."""
        return names_of(self.response, "probe")

    @property
    def element(self) -> float:
        """Mean side of its triangles [m]."""
        nodes, triangles = (self.building[n].values for n in ("node_position", "triangle_node"))
        vertices = nodes[triangles[:, :3]]
        return float(np.linalg.norm(vertices - np.roll(vertices, -1, axis=1), axis=2).mean())

    @property
    def levels(self) -> Array:
        """Heights of the mass centres of its floors, shape (n_floors,) [m]."""
        nodes, centres = (self.building[name].values for name in ("node_position", "centre"))
        return np.asarray(nodes[centres, 2], dtype=np.float64)

    @property
    def plan(self) -> Array:
        """Length and width of the box around its nodes, shape (2,) [m]."""
        nodes = self.building["node_position"].values[:, :2]
        return np.asarray(np.ptp(nodes, axis=0), dtype=np.float64)

    @property
    def shape(self) -> str:
        """Floors, height and plan in words."""
        length, width = self.plan
        count = len(self.levels)
        floors = f"{count} floor{'' if count == 1 else 's'} up to {self.levels[-1]:.4g} m"
        return f"{floors}, {length:.4g} m x {width:.4g} m in plan"


class Comparison:
    """Spectra of one run and of another one, the reference, and their difference.

        δ(f)      = |PSa(f) − PSa_other(f)| / PSa_other(f)
        δ_peak(f) = |PSa(f) − PSa_other(f)| / max PSa_other

    The first is large, too, where a spectrum is small; the second shows what matters to a design.
    Arrays have a row for each of the n spectra that count. The store is from `compare`, or the open
    `comparison.nc`.
    """

    def __init__(self, store: xr.Dataset) -> None:
        self.store = store
        self.highest = float(store.attrs["highest_frequency"])
        self.damping = float(store.attrs["damping"])
        self.probes, self.components = names_of(store, "probe"), names_of(store, "component")
        self.frequency: Array = np.asarray(store["frequency"].values, dtype=np.float64)
        # Whether a frequency is compared, shape (n_f,).
        self.known: Flags = np.asarray(self.frequency <= self.highest * (1.0 + SAME))
        # Numbers of the point and of the axis of each spectrum.
        self.probe, self.component = np.nonzero(store["counts"].values)
        # Of the run and of the other, shape (2, n, n_f), and the largest compared ones [m/s2].
        self.psa: Array = np.stack(
            [store[name].values[self.probe, self.component] for name in ("psa", "psa_other")]
        )
        self.peak: Array = self.psa[..., self.known].max(axis=-1)
        # δ and δ_peak, shape (n, n_f).
        apart = np.abs(self.psa[0] - self.psa[1])
        self.difference: Array = apart / self.psa[1]
        self.over_peak: Array = apart / self.peak[1, :, None]

    def words(self, kind: str = "") -> str:
        """Title, case file and folder of the run, or with "other_" of the other."""
        title, case_file, folder = (
            self.store.attrs[f"{kind}{name}"] for name in ("title", "case_file", "folder")
        )
        return f"'{title}' ({case_file}, {folder})"

    @property
    def range(self) -> str:
        """The frequencies that are compared: how many, from where to where."""
        f = self.frequency[self.known]
        return f"{len(f)} frequencies from {f[0]:.4g} to {f[-1]:.4g} Hz"

    @property
    def cases(self) -> str:
        """Both runs and what was compared, as the end of a title."""
        runs = f"{self.words()} and of {self.words('other_')}"
        return f"{runs}, at {self.range} and {len(self.probes)} points"

    def worst(self, apart: Array) -> tuple[float, int, float]:
        """Largest δ, or δ_peak, that is compared; its spectrum and its frequency [Hz]."""
        largest = apart[:, self.known]
        spectrum, at = np.unravel_index(int(largest.argmax()), largest.shape)
        return float(largest[spectrum, at]), int(spectrum), float(self.frequency[self.known][at])


def compare(one: Side, other: Side, highest: float) -> xr.Dataset:
    """Compare the spectra of two runs of one building, at the points that both have.

    One building is one with as many floors, at the same heights, over the same plan, to `ALIKE`;
    its name, mesh, materials, damping, contacts and motion may differ. A point is one of the same
    name in both runs, at places no farther apart than the elements of the coarser mesh are long. A
    spectrum counts where the peak acceleration of both runs is more than `QUIET` of the largest
    along the axis, and this more than `STILL` of that along all: elsewhere it is that of the mesh.
    InputError where they are of different buildings, share no point or damping, or too few
    frequencies up to the highest [Hz]; or nothing moves.

    Gives PSa of both by point, axis and frequency, at the first damping that both have.
    """
    alike = len(one.levels) == len(other.levels)
    if alike:
        height = np.abs(one.levels - other.levels).max() / np.abs(one.levels).max()
        alike = max(height, *np.abs(other.plan / one.plan - 1.0)) <= ALIKE
    if not alike:
        expected = f"expected a run of the building of {one.folder}, {one.shape}; it has "
        raise InputError([Fault(other.folder, "", None, f"{expected}{other.shape}")])
    both = (one, other)
    apart_most = max(side.element for side in both)
    shared = [name for name in one.probes if name in other.probes]
    here, there = (side.response["probe_position"].sel(probe=shared).values for side in both)
    distance = np.linalg.norm(here - there, axis=1)
    near = distance <= apart_most
    dampings = [d for d in one.damping if np.isclose(d, other.damping).any()]
    # The widest gap depends on the damping; without one in common the fault below says so.
    frequency = common_frequencies(one.frequency, other.frequency, dampings[0] if dampings else 0.0)
    count = int(np.sum(frequency <= highest * (1.0 + SAME)))
    least = min(LEAST, *(int(np.sum(s.frequency <= highest * (1.0 + SAME))) for s in both))
    faults = []
    if not near.any():
        seen = f"all are {distance.min():.3g} m away or more" if shared else "none of its names"
        expected = (
            f"expected points of {one.folder} by name, within {apart_most:.3g} m of their "
            f"places there; found {seen}"
        )
        faults.append(Fault(other.folder, "probe", None, expected))
    if not dampings:
        expected = f"expected a damping of the spectra of {one.folder}, {_percent(one.damping)}"
        faults.append(Fault(other.folder, "damping", _percent(other.damping), expected))
    elif count < max(1, least):
        expected = (
            f"expected at least {max(1, least)} of the frequencies up to {highest:g} Hz known, or "
            f"near enough to interpolate, here and in {one.folder}; found {count}"
        )
        faults.append(Fault(other.folder, "frequency", None, expected))
    if faults:
        raise InputError(faults)
    damping, kept = dampings[0], [name for name, keep in zip(shared, near, strict=True) if keep]
    psa = []
    for side in both:
        chosen = side.response["psa"].sel(damping=damping, method="nearest").sel(probe=kept)
        values = chosen.transpose("probe", "component", "frequency").values
        psa.append(interpolate_frequency(side.frequency, values, frequency))
    known = frequency[frequency <= highest * (1.0 + SAME)]
    widest = float(max(_gap(side.frequency, known).max() for side in both))
    peak = [side.response["pfa"].sel(probe=kept).values for side in both]
    # Along an axis that rounding and the unevenness of a mesh alone move there is no spectrum.
    counts = np.logical_and(
        *((p > QUIET * p.max(axis=0)) & (p.max(axis=0) > STILL * p.max()) for p in peak)
    )
    if not counts.any():
        expected = f"expected a point that moves in {one.folder}, too"
        raise InputError([Fault(other.folder, "pfa", None, expected)])
    axes = ("probe", "component")
    return xr.Dataset(
        {
            "psa": ((*axes, "frequency"), psa[0], {"units": "m/s2"}),
            "psa_other": ((*axes, "frequency"), psa[1], {"units": "m/s2"}),
            "counts": (axes, counts.astype(np.int8)),
            "distance": ("probe", distance[near], {"units": "m"}),
        },
        coords={
            "probe": kept,
            "component": names_of(one.response, "component"),
            "frequency": ("frequency", frequency, {"units": "Hz"}),
        },
        attrs={
            "damping": damping,
            "highest_frequency": highest,
            "farthest": apart_most,
            "moved": ", ".join(
                f"{name} ({d:.3g} m apart)"
                for name, d, keep in zip(shared, distance, near, strict=True)
                if not keep
            ),
            "interpolated_low": resonance_low(widest, damping),
            **_named(one, other, "", highest),
            **_named(other, one, "other_", highest),
        },
    )


def common_frequencies(one: Array, other: Array, damping: float) -> Array:
    """Frequencies [Hz] of either ascending list where both spectra are, or may be interpolated.

    A spectrum may be interpolated between two neighbours f₁ < f₂ of its list with ln(f₂/f₁) ≤ ξ.
    The sharpest peak that oscillators of the damping ξ can have, that of a steady sine, is within
    1 − 1/√(1 + ¼) = 11 % of the larger neighbour then (`resonance_low`); the peaks of a building,
    which is damped itself, are wider.
    """
    merged = merged_frequencies(one, other)
    return np.asarray(merged[np.all([_gap(f, merged) <= damping for f in (one, other)], axis=0)])


def resonance_low(gap: float, damping: float) -> float:
    """How much lower the line between two neighbours may be than a peak between them.

    The amplitude of an oscillator of the damping ξ under a sine of its frequency times
    exp(±Δ/2), over that in resonance, is 1/√(1 + (Δ/2ξ)²) for small Δ = ln(f₂/f₁) and ξ.
    """
    return 0.0 if gap == 0.0 else 1.0 - 1.0 / float(np.hypot(1.0, gap / (2.0 * damping)))


def _gap(f: Array, wanted: Array) -> Array:
    """ln(f₂/f₁) of the neighbours in f of each frequency: 0 where f has it, inf outside of f."""
    k = np.clip(np.searchsorted(f, wanted), 1, max(1, len(f) - 1))
    below, above = f[k - 1], f[np.minimum(k, len(f) - 1)]
    gap = np.where((wanted > below) & (wanted < above), np.log(above / below), np.inf)
    has = np.minimum(np.abs(wanted / below - 1.0), np.abs(wanted / above - 1.0)) <= SAME
    return np.where(has, 0.0, gap)


def _named(side: Side, against: Side, kind: str, highest: float) -> dict[str, object]:
    """A run in contrast to the other, as attributes of the store."""
    store, f = side.response, side.frequency
    return {
        f"{kind}inputs": str(store.attrs["inputs"]),
        f"{kind}title": str(store.attrs["title"]),
        f"{kind}case_file": side.case_file,
        f"{kind}folder": str(side.folder),
        f"{kind}pounding": side.pounding,
        f"{kind}case_hash": str(store.attrs["case_hash"]),
        f"{kind}building": str(store.attrs["building"]),
        f"{kind}shape": side.shape,
        f"{kind}element": side.element,
        f"{kind}frequencies": int(np.sum(f <= highest * (1.0 + SAME))),
        f"{kind}points": len(side.probes),
        f"{kind}alone": ", ".join(name for name in side.probes if name not in against.probes),
    }


def _percent(dampings: Array) -> str:
    return ", ".join(f"{100.0 * d:g} %" for d in dampings)


def cases_table(found: Comparison) -> Table:
    """Which runs are compared, at which points and frequencies, and what is left out."""
    attributes = found.store.attrs
    upto = f"up to {found.highest:g} Hz"
    low = 100.0 * float(attributes["interpolated_low"])
    points = f"{len(found.probes)}, within {float(attributes['farthest']):.3g} m"
    # An attribute of each run, or (after "=") a text for both.
    lines = (
        ("title", "title"),
        ("case file", "case_file"),
        ("folder", "folder"),
        ("what pounds", "pounding"),
        ("building", "building"),
        ("its floors and plan", "shape"),
        ("mean side of its triangles [m]", "element"),
        (f"frequencies {upto}", "frequencies"),
        ("frequencies compared", f"={found.range}"),
        ("interpolated: sharp peaks may be low by", f"={low:.2g} %" if low else "=not"),
        ("points", "points"),
        ("points compared", f"={points}"),
        ("points left out: too far apart", f"={attributes['moved']}"),
        ("points left out: only here", "alone"),
    )
    rows = []
    for words, name in lines:
        if name.startswith("="):
            cells = [name[1:]] * 2
        else:
            values = (attributes[f"{kind}{name}"] for kind in ("", "other_"))
            cells = [v if isinstance(v, str) else f"{v:.4g}" for v in values]
        if any(cells):
            rows.append((words, *cells))
    title = f"floor response spectra ({100.0 * found.damping:g} %) of two runs, {upto}"
    return Table(CASES, title, (("", ""), ("this run", ""), ("the other", "")), tuple(rows))


def comparison_table(found: Comparison) -> Table:
    """The largest differences of each spectrum, at which frequency, and the peaks of both."""
    columns = [
        np.array(found.probes, dtype=object)[found.probe],
        np.array(found.components, dtype=object)[found.component],
        found.store["distance"].values[found.probe],
    ]
    for apart in (found.difference[:, found.known], found.over_peak[:, found.known]):
        columns += [apart.max(axis=1), found.frequency[apart.argmax(axis=1)]]
    rows = zip(*(column.tolist() for column in (*columns, *found.peak)), strict=True)
    header = heads(
        "point; direction; distance of both points [m]; largest difference [-]; at [Hz]; "
        "largest over the peak [-]; at [Hz]; peak [m/s2]; peak of the other [m/s2]"
    )
    title = f"floor response spectra ({100.0 * found.damping:g} %) of {found.cases}"
    return Table(TABLE, title, header, tuple(rows))


def directions_table(found: Comparison) -> Table:
    """Of each direction the largest differences of its spectra and how many ordinates are near."""
    rows: list[tuple[Cell, ...]] = []
    for c, name in enumerate(found.components):
        own = found.component == c
        if own.any():
            apart = found.difference[own][:, found.known]
            numbers = (
                np.abs(found.peak[0, own] / found.peak[1, own] - 1.0).max(),
                found.over_peak[own][:, found.known].max(),
                apart.max(),
                np.percentile(apart, 95.0),
                (apart <= NEAR).mean(),
            )
            whole = int((apart <= NEAR).all(axis=1).sum())
            rows.append((name, len(apart), *map(float, numbers), whole))
    header = heads(
        "direction; spectra; largest of peaks [-]; largest over the peak [-]; "
        "largest difference [-]; 95 % of ordinates [-]; "
        f"ordinates within {NEAR:g} [-]; spectra within {NEAR:g}"
    )
    return Table(DIRECTIONS, f"differences by direction, of {found.cases}", header, tuple(rows))


def comparison_figure(path: Path, found: Comparison) -> None:
    """The spectrum with the largest difference over its peak in both runs, and δ of all spectra."""
    largest, k, at = found.worst(found.over_peak)
    point = found.probes[found.probe[k]].replace("_", " ")
    f, apart = found.frequency, 100.0 * found.difference
    caption = (
        f"Floor response spectra ({100.0 * found.damping:g} % damping) of this run, "
        f"{found.words()}, and of the other, {found.words('other_')}, at {found.range} and "
        f"{len(found.probes)} points. (a) where they differ most, over the peak: "
        f"{point} along $e_{found.components[found.component[k]]}$, "
        f"{100.0 * largest:.2g} % at {at:.3g} Hz. (b) difference over the other one at the same "
        f"frequency, of the {len(apart)} spectra of points that move; dotted: {found.highest:g} Hz."
    )
    with figure(path, (1, 2), (9.0, 3.8), caption) as (_, axes):
        axes[0].semilogx(f, found.psa[0, k], color=BLUE, label="this run")
        axes[0].semilogx(f, found.psa[1, k], color=RED, ls="--", label="the other")
        axes[0].set_ylabel("pseudo-acceleration [m/s²]")
        axes[0].set_ylim(bottom=0.0)
        axes[1].semilogx(f, apart.max(axis=0), color=BLUE, label="largest")
        axes[1].semilogx(f, np.median(apart, axis=0), color=RED, ls="--", label="median")
        axes[1].set_ylabel("difference [%]")
        if apart.any():
            axes[1].set_yscale("log")
        for panel in axes:
            panel.axvline(found.highest, color="0.4", ls=":")
            panel.set_xlabel("frequency [Hz]")
            panel.legend(loc="best")
            span(panel, f)
        letter(axes)
