"""Figures of a device: its elements, its modes and its mechanical model."""

import math
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, letter, sheet
from impactfem.stages.device.selection import ALL, anchor_of, direction, shown_modes
from impactfem.system.arrays import Array

GREY = "0.35"
SHOWN = 4
"""Most modes that are drawn."""
AMPLITUDE = 0.3
"""Largest displacement of a drawn mode over the height of the device."""
UNKNOWN = 0.25
"""Radius of a device of unknown size over its height."""


class Drawing:
    """A device on springs, seen across a horizontal direction; nan for what it has not."""

    def __init__(self, store: xr.Dataset, device: str) -> None:
        one = store.drop_dims(["case", "impact"]).sel(device=device)
        self.one = one.isel(
            mode=np.isfinite(one["mode_frequency"].values),
            level=np.isfinite(one["level_height"].values),
        )
        # The direction and the other one; across a vertical one, either horizontal one will do.
        self.axis = direction(store) if direction(store) in "xy" else "y"
        self.about = {"x": "y", "y": "x"}[self.axis]
        # Of the mass centre above the anchor, of a cylindrical body, of the beam, in all [m].
        self.height, self.radius = self.value("body_height"), self.value("body_radius")
        self.length, self.beam = self.value("body_length"), self.value("beam_length")
        # A mass at its anchor has no height; it is drawn as one of 1 m.
        self.top = float(np.nanmax([self.length, abs(self.height), self.beam])) or 1.0
        # Heights of the points of the shapes, the mass centre last [m].
        self.levels: Array = self.one["level_height"].values
        shape = self.one["mode_shape"].transpose("component", "mode", "level")
        # Displacement of each mode along the direction, shape (n_modes, n) [1/√kg], and its
        # derivative along the height by the rotation; u = θ × r: du_x/dz = θ_y, du_y/dz = -θ_x.
        self.shift: Array = shape.sel(component=self.axis).values
        sense = 1.0 if self.axis == "x" else -1.0
        self.slope: Array = sense * shape.sel(component=f"r{self.about}").values

    def value(self, name: str, **labels: str) -> float:
        """A number of the device in the store."""
        return float(self.one[name].sel(labels))

    @property
    def carrier(self) -> str:
        """What is between base and body."""
        return "rigid link" if math.isnan(self.beam) else "beam"

    @property
    def outline(self) -> Array:
        """Outline of the body at rest, from its lower left on, shape (5, 2) [m].

        Of its size if known. A cylinder has its middle where the case has its mass centre only if
        both are as high; it stands on its anchor, or hangs below it.
        """
        if math.isnan(self.radius):
            half = 0.15 * self.top
            low, high = self.height - half, self.height + half
        else:
            half, low = self.radius, 0.0 if self.height >= 0.0 else -self.length
            high = low + self.length
        return np.array([[-half, low], [half, low], [half, high], [-half, high], [-half, low]])

    @property
    def place(self) -> str:
        """Where the mass centre is, in words."""
        return f"{abs(self.height):g} m {'above' if self.height >= 0.0 else 'below'}"


def drawing_of(store: xr.Dataset, device: str) -> Drawing | None:
    """What figures show of a device on springs; None for one that is made of modes."""
    on_springs = np.isfinite(store["body_mass"].sel(device=device))
    return Drawing(store, device) if on_springs else None


def device_size(store: xr.Dataset, device: str) -> tuple[float, float]:
    """Radius and height of the cylinder that shows a device [m]; of its body where that is known.

    A device that is made of modes is shown 1 m high.
    """
    drawn = drawing_of(store, device)
    if drawn is None:
        return UNKNOWN, 1.0
    return (UNKNOWN * drawn.top if math.isnan(drawn.radius) else drawn.radius), drawn.top


def _on_springs(store: xr.Dataset, device: str) -> bool:
    return drawing_of(store, device) is not None


def _has_modes(store: xr.Dataset, device: str) -> bool:
    drawn = drawing_of(store, device)
    return drawn is not None and bool(shown_modes(store, device, drawn.axis).sizes["mode"])


@figure("device_modes", ALL, "Modes of the device", when=_has_modes, each="device", default=False)
def modes_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Draw the modes that move along the shown direction."""
    drawn = Drawing(store, device)
    axis = drawn.axis
    modes = shown_modes(store, device, axis)
    mass = modes["effective_mass"].sel(component=axis)
    whole = float(mass.sum())
    caption = (
        f"Modes of {device} along $e_{axis}$ and about $e_{drawn.about}$ relative to the anchor, "
        f"with their effective masses and the parts of their sum, {whole:.5g} kg. Dashed: at rest."
    )
    modes = modes.isel(mode=slice(SHOWN))
    count, outline, top = modes.sizes["mode"], drawn.outline, drawn.top
    arm, low = outline - np.array([0.0, drawn.height]), min(0.0, float(outline[:, 1].min()))
    # So wide that the width of the panel, not its height, gives the scale.
    reach = max(float(np.abs(outline[:, 0]).max()) + 1.35 * AMPLITUDE * top, 0.95 * top)
    listed = ", ".join(f"{f:.2f} Hz" for f in modes["mode_frequency"].values)
    seen = f"Outlines of {device}, displaced and rotated, over those at rest: modes of {listed}."
    with sheet(path, (1, count), (max(2.9 * count, 4.0), 3.5), caption, seen) as (_, axes):
        for panel, k in zip(axes, modes["mode"], strict=True):
            shift, slope = drawn.shift[int(k) - 1], drawn.slope[int(k) - 1]
            # The body turns about its mass centre, the last level.
            moved = np.column_stack([shift[-1] + slope[-1] * arm[:, 1], -slope[-1] * arm[:, 0]])
            largest = float(max(np.abs(moved[:, 0]).max(), np.abs(shift).max()))
            factor = math.copysign(AMPLITUDE * top / largest, shift[-1])
            x = factor * shift
            for at_rest in (outline, np.array([[0.0, 0.0], [0.0, drawn.height]])):
                panel.plot(at_rest[:, 0], at_rest[:, 1], color=GREY, ls="--", lw=0.8)
            panel.plot(*(outline + factor * moved).T, color=RED, lw=1.0, label="body")
            panel.plot(x, drawn.levels, color=BLUE, lw=2.0, label=drawn.carrier)
            panel.plot(x[0], 0.0, "s", color=ORANGE, ms=5, label="base")
            panel.plot(x[-1], drawn.height, "o", color="black", ms=4, label="mass centre")
            panel.axhline(0.0, color="black", lw=1.5)
            below = min(-0.75 * top, 1.5 * low)
            panel.set(xlim=(-reach, reach), ylim=(below, 1.5 * top), aspect="equal")
            _only_above(panel, low)
            panel.set_xlabel(f"{drawn.axis} [m]")
            panel.grid(False)
            f, m = float(modes["mode_frequency"].sel(mode=k)), float(mass.sel(mode=k))
            words = f"f = {f:.2f} Hz\n{m:.5g} kg, {100.0 * m / whole:.3g} %"
            panel.text(0.03, 0.98, words, transform=panel.transAxes, va="top", fontsize=8.0)
        axes[0].set_ylabel("height [m]")
        axes[0].legend(loc="lower left", fontsize=7.0)
        letter(axes)


@figure(
    "device_elements",
    ALL,
    "Elements of the device",
    when=_on_springs,
    each="device",
    default=False,
)
def elements_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Draw the elements of the device to scale."""
    drawn = Drawing(store, device)
    _, floor, nodes = anchor_of(store, device)
    caption = (
        f"Elements of {device}, in elevation in the plane "
        f"$(e_{drawn.axis}, e_z)$: a body on a {drawn.carrier} on springs, "
        f"anchored by rigid links to {nodes} node{'s' * (nodes > 1)} of floor {floor}. "
        "Parts below 0 are not to scale."
    )
    outline, top = drawn.outline, drawn.top
    half, low = float(np.abs(outline[:, 0]).max()), min(0.0, float(outline[:, 1].min()))
    seen = (
        f"An outline {2.0 * half:.3g} m wide and {np.ptp(outline[:, 1]):.3g} m high, with its mass "
        f"centre {drawn.place} springs and rigid links to the floor."
    )
    with sheet(path, (1, 1), (6.5, 4.4), caption, seen) as (drawing, (panel, *_)):
        panel.fill(outline[:, 0], outline[:, 1], color=RED, alpha=0.12)
        panel.plot(outline[:, 0], outline[:, 1], color=RED, lw=1.0, label="body, rigid")
        if not math.isnan(drawn.beam):
            panel.plot([0.0, 0.0], [0.0, drawn.beam], color=RED, lw=3.0, label="beam")
        panel.plot(0.0, drawn.height, "o", color="black", ms=5, label="mass centre")
        # As wide as high at least, however slim the device is.
        reach = max(1.6 * half, 0.95 * top)
        panel.axhline(-0.16 * top, color=BLUE, lw=4.0, label="floor")
        # Springs have no length: they are drawn apart to be seen.
        for x in np.linspace(-half, half, 5):
            label = "rigid links to the floor" if x == half else None
            panel.plot([0.0, x], [-0.06 * top, -0.15 * top], color=GREEN, lw=1.5, label=label)
        base = [0.0, -0.06 * top]
        panel.plot([0.0, 0.0], base, color=ORANGE, lw=5.0, label="springs of the base")
        beside = half + 0.12 * reach
        arrow = {"arrowstyle": "<->", "color": GREY, "shrinkA": 0.0, "shrinkB": 0.0}
        panel.annotate("", (beside, 0.0), xytext=(beside, drawn.height), arrowprops=arrow)
        panel.text(half + 0.15 * reach, 0.5 * drawn.height, f"{drawn.height:g} m", va="center")
        panel.set(xlim=(-reach, reach), ylim=(min(-0.25 * top, low - 0.1 * top), 1.15 * top))
        panel.set_aspect("equal")
        _only_above(panel, low)
        panel.set(xlabel=f"{drawn.axis} [m]", ylabel="height [m]")
        panel.grid(False)
        drawing.legend(loc="outside upper center", ncols=3)


@figure(
    "device_model",
    ALL,
    "Mechanical model of the device",
    when=_on_springs,
    each="device",
    default=False,
)
def model_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Draw mass, beam and springs of the device with their values and modes, not to scale."""
    drawn = Drawing(store, device)
    axis, about = drawn.axis, drawn.about
    caption = (
        f"Mechanical model of {device} in the plane $(e_{axis}, e_z)$, "
        "and its modes in this plane with their effective masses."
    )
    spring, turning = (drawn.value("base_stiffness", component=c) for c in (axis, f"r{about}"))
    carrier = "rigid"
    if not math.isnan(drawn.beam):
        mass = drawn.value("beam_mass")
        bending = _power(drawn.value("beam_bending", bending_about=about), "N m²")
        carrier = f"beam, {drawn.beam:g} m\n$E I$ = {bending}"
        carrier += f"\n{mass:.4g} kg" if mass > 0.0 else ""
    body = (
        f"$m$ = {drawn.value('body_mass'):.5g} kg at {drawn.height:g} m\n"
        f"$J_{about}$ = {drawn.value('body_inertia', axis=about):.4g} kg m²"
    )
    modes = shown_modes(store, device, axis).isel(mode=slice(SHOWN))
    lines = [
        f"mode {k}: {f:.2f} Hz, {m:.5g} kg, damping {100.0 * damping:.3g} %"
        for k, f, m, damping in zip(
            modes["mode"].values,
            modes["mode_frequency"].values,
            modes["effective_mass"].sel(component=axis).values,
            modes["mode_damping"].values,
            strict=True,
        )
    ] or [f"no mode in use moves it along {axis}: it follows the floor"]
    seen = (
        f"A mass of {drawn.value('body_mass'):.5g} kg, {drawn.place} a spring along "
        f"{axis} and one about {about}, on a {drawn.carrier}; {'; '.join(lines)}."
    )
    with sheet(path, (1, 1), (6.5, 4.4), caption, seen) as (_, (panel, *_)):
        # The spring along: a zigzag from a wall on the left to the base.
        across = np.array([0, 0, 1, -1, 1, -1, 1, -1, 0, 0]) * 0.12
        panel.plot(np.linspace(-1.5, -0.4, across.size), across, color=ORANGE, lw=1.6)
        panel.plot([-0.4, 0.0], [0.0, 0.0], color=ORANGE, lw=1.6)
        panel.plot([-1.5, -1.5], [-0.25, 0.25], color="black", lw=2.5)
        # The spring about: a spiral around the base that ends on its support.
        turn = np.linspace(0.0, 5.0 * math.pi, 240)
        radius = 0.08 + 0.24 * turn / turn[-1]
        x, z = radius * np.sin(turn), radius * np.cos(turn)
        panel.plot(x, z, color=ORANGE, lw=1.6)
        panel.plot([x[-1], x[-1]], [z[-1], -0.55], color=ORANGE, lw=1.6)
        panel.plot([-0.3, 0.3], [-0.55, -0.55], color="black", lw=2.5)
        panel.plot([0.0, 0.0], [0.0, 1.6], color=RED, lw=2.5)
        panel.plot(0.0, 1.6, "o", color="black", ms=13)
        panel.plot(0.0, 0.0, "s", color=ORANGE, ms=6)
        panel.text(0.22, 1.6, body, va="center")
        panel.text(0.15, 0.85, carrier, va="center")
        along = f"$K_{{{axis}{axis}}}$ = {_power(spring, 'N/m')}"
        panel.text(-0.95, 0.33, along, ha="center")
        rocking = f"$K_{{r{about}{about}}}$ = {_power(turning, 'N m/rad')}"
        panel.text(0.42, -0.28, rocking, va="center")
        panel.text(-1.6, -0.85, "\n".join(lines), va="top", fontsize=8.5)
        for end, name in (((-1.0, 1.1), f"$e_{axis}$"), ((-1.5, 1.6), "$e_z$")):
            arrow = {"arrowstyle": "->", "color": GREY}
            panel.annotate("", end, xytext=(-1.5, 1.1), arrowprops=arrow)
            panel.text(end[0] + 0.06, end[1], name, va="center")
        panel.set(xlim=(-1.8, 2.2), ylim=(-1.0 - 0.21 * len(lines), 2.0))
        panel.set_axis_off()


def _only_above(panel: Axes, low: float) -> None:
    """Heights are those of the device: the scale ends at its foot [m]."""
    panel.set_yticks([tick for tick in panel.get_yticks() if low <= tick <= panel.get_ylim()[1]])


def _power(value: float, unit: str) -> str:
    """A number as 1.4·10⁸ with its unit; "rigid" for an infinite one."""
    if math.isinf(value):
        return "rigid"
    if not value > 0.0:
        return f"{value:g} {unit}"
    power = math.floor(math.log10(value))
    return f"${value / 10.0**power:.3g} \\cdot 10^{{{power}}}$ {unit}"
