"""What figures, tables and checks select from `device.nc`: forces, analyses and damping cases.

A value is selected by the names of its device, impact (`WITHOUT`, `WITH`) and damping case, and
is that along the direction that is shown where nothing else is said.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.case.damping import OWN
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.stores import names_of

Array = NDArray[np.float64]

WITHOUT, WITH = "without", "with"
"""Labels of the dimension `impact`."""
IN_NAMES = {WITHOUT: "no_impact", WITH: "impact"}
"""The same in the names of scalars."""
ROTATIONS, BROADENED = "rotations", "broadened"
"""What the names of response spectrum analyses say behind the combination of the modes."""
GUPTA, LINDLEY_YOW = "gupta", "lindley-yow"
RIGID = {GUPTA: "Gupta", LINDLEY_YOW: "Lindley-Yow"}
"""The same of the rigid part of the modes, and whose method it is."""
STIFF = 0.1
"""A mode follows the floor whose pseudo-acceleration is within this part of the ZPA."""


def loaded(store: xr.Dataset) -> xr.Dataset:
    """The store with all but its histories in memory: single values are selected often."""
    for name, variable in store.variables.items():
        if "time" not in variable.dims:
            store[name].load()
    return store


def direction(store: xr.Dataset) -> str:
    """The direction that is shown: "x", "y" or "z"."""
    return str(store.attrs["shown_direction"])


def headline(store: xr.Dataset) -> str:
    """The response spectrum analysis as the paper does it."""
    return str(store.attrs["headline"])


def building_damping(store: xr.Dataset, case: str) -> Rayleigh:
    """The damping of the buildings in a damping case."""
    one = store.sel(case=case)
    return Rayleigh(float(one["mass_coefficient"]), float(one["stiffness_coefficient"]))


def scalar_start(store: xr.Dataset, device: str) -> str:
    """How the names of a device's scalars begin; published values have the same names."""
    return "device" if device == names_of(store, "device")[0] else f"device.{device}"


def scalar_name(store: xr.Dataset, device: str, quantity: str, impact: str, case: str) -> str:
    """Name of a scalar of a device, such as "fy.detailed", under one load with one damping."""
    end = "" if case == OWN else f".{case}"
    return f"{scalar_start(store, device)}.{quantity}.{IN_NAMES[impact]}{end}"


def file_stem(store: xr.Dataset, stem: str, device: str) -> str:
    """A file's name: that of the first device is short, others hold the device's name."""
    return stem if device == names_of(store, "device")[0] else f"{stem}_{device}"


def force_history(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> xr.DataArray:
    """Force of the device on the floor over time [N]."""
    at = {"device": device, "impact": impact, "case": case}
    return store["force"].sel(at | {"component": direction(store)}).astype(np.float64)


def components(
    store: xr.Dataset, device: str, impact: str, case: str = OWN, choice: str | None = None
) -> xr.DataArray:
    """Largest force or moment by component [N, N m].

    By the response spectrum analysis `choice`, or in the detailed analysis when None.
    """
    at = {"device": device, "impact": impact, "case": case}
    if choice is None:
        return store["largest_force"].sel(at)
    return store["spectrum_force"].sel(at | {"choice": choice})


def detailed_force(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> float:
    """Largest force of the detailed analysis [N]."""
    return float(components(store, device, impact, case).sel(component=direction(store)))


def force_by_spectrum(
    store: xr.Dataset, device: str, impact: str, case: str = OWN, choice: str | None = None
) -> float:
    """The same by a response spectrum analysis, the headline when None [N]; nan: not done."""
    found = components(store, device, impact, case, choice or headline(store))
    return float(found.sel(component=direction(store)))


def was_done(store: xr.Dataset, device: str, impact: str, case: str, choice: str) -> bool:
    """Whether an analysis was done of a device: not all have envelopes or given spectra."""
    return math.isfinite(force_by_spectrum(store, device, impact, case, choice))


def relative_difference(
    store: xr.Dataset, device: str, impact: str, case: str = OWN, choice: str | None = None
) -> float | None:
    """(detailed - by spectrum) / detailed, positive where the latter is too low [-].

    None where nothing moves the device.
    """
    whole = detailed_force(store, device, impact, case)
    if not whole > 0.0:
        return None
    return 1.0 - force_by_spectrum(store, device, impact, case, choice) / whole


def variant(store: xr.Dataset, *words: str) -> str | None:
    """Name of the headline analysis with rotations, broadened spectra or both; None if none."""
    name = ".".join([headline(store), *words])
    return name if name in names_of(store, "choice") else None


def rigid_variants(store: xr.Dataset) -> dict[str, str]:
    """Analyses that differ from the headline by the rigid part of the modes: method and name.

    Of these as well where the headline has one itself: "none" without any.
    """
    combination, _, own = headline(store).partition(".")
    names = {"none": combination} | {method: f"{combination}.{method}" for method in RIGID}
    choices = names_of(store, "choice")
    return {
        method: name
        for method, name in names.items()
        if name in choices and method != (own or "none")
    }


@dataclass(frozen=True)
class Pull:
    """How a device pulls at its anchor in the detailed analysis, its weight included.

    Args:
        weight: Its weight at this anchor [N].
        radius: Of the circle that the anchors stand on [m].
        uplift: Largest force upward less the weight [N].
        tension: n times the pull of the most loaded of n anchors, evenly on it [N].
    """

    weight: float
    radius: float
    uplift: float
    tension: float


def pull_of(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> Pull | None:
    """How a device pulls at its anchor; None where its weight is not known."""
    at = {"device": device, "impact": impact, "case": case}
    tension = float(store["net_tension"].sel(at))
    if not math.isfinite(tension):
        return None
    return Pull(
        weight=-float(store["weight_force"].sel(device=device, component="z")),
        radius=float(store["anchor_radius"].sel(device=device)),
        uplift=float(store["net_uplift"].sel(at)),
        tension=tension,
    )


def tension_by_spectrum(
    store: xr.Dataset, device: str, impact: str, case: str, choice: str
) -> float | None:
    """Net tension by a response spectrum analysis, its largest values at one instant [N]."""
    if pull_of(store, device, impact, case) is None:
        return None
    at = {"device": device, "impact": impact, "case": case, "choice": choice}
    return float(store["spectrum_tension"].sel(at))


def anchor_spectrum(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> xr.DataArray:
    """Pseudo-acceleration of the anchor by the device's first damping [m/s2]."""
    at = {"device": device, "impact": impact, "case": case}
    return store["psa"].sel(at | {"axis": direction(store)})


def modes_of(store: xr.Dataset, device: str) -> xr.Dataset:
    """Frequency, damping and effective masses of the modes of a device."""
    one = store[["mode_frequency", "mode_damping", "effective_mass"]].sel(device=device)
    return one.isel(mode=np.isfinite(one["mode_frequency"].values))


def shown_modes(store: xr.Dataset, device: str) -> xr.Dataset:
    """Those of them that carry mass along the shown direction."""
    modes = modes_of(store, device)
    mass = modes["effective_mass"].sel(component=direction(store))
    return modes.isel(mode=(mass > 1e-6 * mass.sum()).values)


def modal_mass(store: xr.Dataset, device: str) -> float:
    """Sum of the effective masses along the shown direction [kg]."""
    modes = modes_of(store, device)
    return float(modes["effective_mass"].sel(component=direction(store)).sum())


def mode_ordinates(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> xr.DataArray:
    """Pseudo-accelerations of the anchor at the device's modes, by component and mode.

    At the modes' dampings [m/s2, rad/s2]; nan where a component is no input.
    """
    at = {"device": device, "impact": impact, "case": case}
    return store["mode_psa"].sel(at).sel(mode=modes_of(store, device)["mode"])


def followed(
    store: xr.Dataset, device: str, impact: str, case: str = OWN
) -> list[tuple[float, float]] | None:
    """Frequency of each shown mode, and its pseudo-acceleration over the ZPA of the floor.

    Returns:
        Pairs [Hz, -]; None where nothing moves the anchor.
    """
    at = {"device": device, "impact": impact, "case": case, "component": direction(store)}
    zpa = float(abs(store["anchor_acceleration"].sel(at)).max())
    if not zpa > 0.0:
        return None
    modes = shown_modes(store, device)
    S = mode_ordinates(store, device, impact, case).sel(
        component=direction(store), mode=modes["mode"]
    )
    return list(
        zip(modes["mode_frequency"].values.tolist(), (S / zpa).values.tolist(), strict=True)
    )


def stiff(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> bool:
    """Whether all shown modes follow the floor: above its peak, and at its ZPA."""
    found = followed(store, device, impact, case)
    if found is None:
        return False
    peak = float(anchor_spectrum(store, device, impact, case).idxmax("frequency"))
    return all(f > peak and abs(ratio - 1.0) <= STIFF for f, ratio in found)


def with_signs(store: xr.Dataset, device: str, impact: str, case: str = OWN) -> float:
    """Sum with their signs of the forces of all modes along the shown direction [N].

    By the spectrum along it alone: M_i S_i with the effective mass M_i, without the missing mass.
    """
    S = mode_ordinates(store, device, impact, case) * modes_of(store, device)["effective_mass"]
    return float(S.sel(component=direction(store)).sum())


@dataclass(frozen=True, eq=False)
class Drawing:
    """A device on springs, seen across a horizontal direction; nan for what it has not.

    Args:
        axis: The direction, "x" or "y".
        spring: Stiffness of the base along it [N/m]; infinite for a rigid one.
        turning: Stiffness of the base about the other axis [N m/rad].
        mass: Of the body [kg].
        inertia: Of the body about the other axis through its mass centre [kg m2].
        height: Of its mass centre above the anchor [m].
        radius: Of a body that is a cylinder [m].
        length: The same.
        beam_length: [m].
        beam_bending: E I for bending along the direction [N m2].
        beam_mass: [kg].
        levels: Heights of the points of the shapes, the mass centre last, shape (n,) [m].
        shift: Displacement of each mode along the direction, shape (n_modes, n) [1/√kg].
        slope: Its derivative along the height by the rotation, shape (n_modes, n) [1/(m √kg)].
    """

    axis: str
    spring: float
    turning: float
    mass: float
    inertia: float
    height: float
    radius: float
    length: float
    beam_length: float
    beam_bending: float
    beam_mass: float
    levels: Array
    shift: Array
    slope: Array


def drawing_of(store: xr.Dataset, device: str) -> Drawing | None:
    """What figures show of a device on springs; None for one that is made of modes."""
    one = store.drop_dims(["case", "impact"]).sel(device=device)
    if math.isnan(one["body_mass"]):
        return None
    # Across a vertical direction, either horizontal one will do.
    axis = direction(store) if direction(store) in "xy" else "y"
    about = {"x": "y", "y": "x"}[axis]
    # u = θ × r: du_x/dz = θ_y, du_y/dz = -θ_x.
    sense = 1.0 if axis == "x" else -1.0
    one = one.isel(
        mode=np.isfinite(one["mode_frequency"].values),
        level=np.isfinite(one["level_height"].values),
    )
    shape = one["mode_shape"].transpose("mode", "level", "component")
    return Drawing(
        axis=axis,
        spring=float(one["base_stiffness"].sel(component=axis)),
        turning=float(one["base_stiffness"].sel(component=f"r{about}")),
        mass=float(one["body_mass"]),
        inertia=float(one["body_inertia"].sel(axis=about)),
        height=float(one["body_height"]),
        radius=float(one["body_radius"]),
        length=float(one["body_length"]),
        beam_length=float(one["beam_length"]),
        beam_mass=float(one["beam_mass"]),
        beam_bending=float(one["beam_bending"].sel(bending_about=about)),
        levels=one["level_height"].values,
        shift=shape.sel(component=axis).values,
        slope=sense * shape.sel(component=f"r{about}").values,
    )


def anchor_of(store: xr.Dataset, device: str) -> tuple[Array, int, int]:
    """Position of the anchor (3,) [m], number of its floor, number of its nodes."""
    one = store[["anchor_position", "anchor_floor", "anchor_nodes"]].sel(device=device)
    return one["anchor_position"].values, int(one["anchor_floor"]), int(one["anchor_nodes"])


def own_is_a_case(store: xr.Dataset) -> bool:
    """Whether a damping case repeats the buildings' own damping, to a hundredth: as printed."""
    both = store[["mass_coefficient", "stiffness_coefficient"]].to_array().transpose("case", ...)
    own, *cases = both.values
    return any(np.allclose(one, own, rtol=0.01, atol=0.0) for one in cases)


def restitution(store: xr.Dataset, case: str) -> float | None:
    """Restitution of the impacts; None where the contact laws keep theirs."""
    found = float(store["epsilon"].sel(case=case))
    return found if math.isfinite(found) else None


def is_calibrated(store: xr.Dataset, case: str) -> bool:
    """Whether it comes from the wall experiment with this damping."""
    return bool(store["epsilon_calibrated"].sel(case=case))
