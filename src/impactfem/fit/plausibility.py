"""Plausibility warnings of the file of a fit; no input is rejected here."""

import itertools
from collections.abc import Iterable, Iterator

import numpy as np

from impactfem.case.place import read_key, value_at
from impactfem.case.plausibility import FIT, unusual
from impactfem.fit.fit_file import (
    FloorTarget,
    Given,
    ModesTarget,
    ScalarTarget,
    SpectrumTarget,
    spread,
    written,
)
from impactfem.fit.pieces import mac
from impactfem.fit.problem import Problem
from impactfem.run.variants import in_si
from impactfem.system.errors import Fault
from impactfem.system.log import LOGGER

ALIKE = 0.95
"""MAC from which on two measured shapes may be one; those of two modes are far below."""
RATIO = 1e3
"""Largest usual ratio of two bounds."""
FAR = 400.0
"""Largest usual size of a building, where that is not given [m]."""
NOTHING = "more than 100 % of the value: the target has no effect on the fit"
"""Warning of a large deviation."""
FACTOR = 10.0
"""Ratio of a datum and the model's value at the start from which on a wrong unit is likely."""
USUAL_HZ = (0.05, 200.0)
"""Usual frequencies of buildings and of their parts [Hz], as in `FIT`."""


def warn_of_implausible(problem: Problem) -> None:
    """Warn of what is probably a mistake in the file of a fit."""
    for one in implausible(problem):
        LOGGER.warning("warning: %s", one)


def warn_of_far_targets(problem: Problem, values: Iterable[float]) -> None:
    """Warn of data that are far from the model at the start.

    Args:
        problem: The problem.
        values: The values of the model at the first start, shape (m,).
    """
    warned = set[str]()
    for datum, model in zip(problem.data, values, strict=True):
        name = datum.group or datum.name
        if name.endswith(".shape") or name in warned or 0.0 in (datum.value, model):
            continue
        ratio = datum.value / float(model)
        if not 1.0 / FACTOR < ratio < FACTOR:
            warned.add(name)
            LOGGER.warning(
                "warning: %s: the target %s = %.4g %s is %.3g times the model's value at the "
                "start, %.4g %s (usual: 0.1 to 10). A wrong unit, sign or mode makes all fitted "
                "keys wrong. Check the value in [[targets]], or set start in [free] nearer to it",
                problem.path,
                datum.name,
                datum.value,
                datum.unit,
                ratio,
                model,
                datum.unit,
            )


def implausible(problem: Problem) -> list[Fault]:
    """Return the implausible values in the file of a fit, with the usual ranges."""
    found = [*_keys(problem), *_coarse(problem), *_twice(problem)]
    found += unusual(problem.fit, problem.said, FIT)
    for k, target in enumerate(problem.fit.targets):
        own: list[tuple[str, str]] = []
        if isinstance(target, ModesTarget):
            own = [*_deviations(target), *_shapes(target), *_sensors(target, problem)]
        else:
            if isinstance(given := target.deviation, Given) and given.unit == "%":
                own = [("deviation", NOTHING)] if given.value > 1.0 else []
            own += _values(target, problem)
        found += [written(problem.said, ("targets", k, key), text) for key, text in own]
    return found


def _values(target: object, problem: Problem) -> Iterator[tuple[str, str]]:
    """Frequencies that no building has, and values of floors far from their table."""
    if isinstance(target, ScalarTarget) and target.value.unit == "Hz":
        if not USUAL_HZ[0] <= target.value.value <= USUAL_HZ[1]:
            yield "value", "usual is 0.3 to 50 Hz"
    elif isinstance(target, FloorTarget) and target.value is not None:
        case = problem.case(problem.start)
        rows = {floor.floor: floor for floor in case.building(target.building).floors}
        for number in target.floors:
            table = getattr(rows[number], target.quantity)
            # A floor table may leave the column out.
            if table and not 1.0 / FACTOR < target.value.value / table < FACTOR:
                text = f"the floor table has {table:.4g} {target.value.unit} of floor {number}"
                yield "value", f"{text}; usual is 0.1 to 10 times that"
                return


def _keys(problem: Problem) -> Iterator[Fault]:
    """Bounds and priors of the free keys, and whether the data can determine all of them."""
    keys, known = len(problem.keys), len(problem.data) + len(problem.priors)
    if keys > known:
        text = f"{keys} keys, but {known} data and priors: they cannot determine all of the keys"
        yield Fault(problem.path, "free", None, text)
    for key, entry in problem.fit.free.items():
        low, high = (one.value for one in entry.bounds)
        if 0.0 < RATIO * low < high:
            text = (
                f"the upper one is {high / low:.3g} times the lower one; usual is below {RATIO:g}"
            )
            yield written(problem.said, ("free", key, "bounds"), text)
        mean, width = entry.scaled_prior or (0.0, 1.0)
        if not 0.0 <= mean <= 1.0:
            beyond = max(-mean, mean - 1.0) / width
            text = f"outside of the bounds, by {beyond:.3g} of its deviations"
            yield written(problem.said, ("free", key, "prior", "mean"), text)


def _coarse(problem: Problem) -> Iterator[Fault]:
    """Sizes of elements of `coarse` that make the case no cheaper."""
    for key, value in problem.fit.coarse.items():
        place = read_key(key) or ()
        own = value_at(place, problem.source.raw)
        here, there = in_si(value)[0], in_si(own)[0]
        sized = key.endswith("size")
        if sized and isinstance(here, float) and isinstance(there, float) and here <= there:
            text = f"not coarser than the case, which has {own!r}"
            yield written(problem.said, ("coarse", key), text)


def _twice(problem: Problem) -> Iterator[Fault]:
    """Results that two targets know."""
    first: dict[str, int] = {}
    for k, target in enumerate(problem.fit.targets):
        if isinstance(target, ScalarTarget):
            key, names = "result", [target.result]
        elif isinstance(target, FloorTarget):
            of = f"{target.quantity} of {target.building}, floor"
            key, names = "floors", [f"{of} {floor}" for floor in target.floors]
        elif isinstance(target, SpectrumTarget):
            place = target.probe or f"floor {target.floor}"
            of = f"{target.building}, {place}, {target.direction}, {target.damping:.3g} damping"
            key, names = "spectrum", [f"the spectrum of {of}"]
        else:
            continue
        told = [name for name in names if first.setdefault(name, k) != k]
        for name in told[:1]:
            text = f"{name} is that of targets[{first[name]}] already, and counts twice"
            yield written(problem.said, ("targets", k, key), text)


def _deviations(target: ModesTarget) -> Iterator[tuple[str, str]]:
    """Deviations of measured modes that are more than what is measured."""
    damping = [one.damping for one in target.modes if one.damping is not None]
    for key, given, values in (
        ("frequency_deviation", target.frequency_deviation, [m.frequency for m in target.modes]),
        ("damping_deviation", target.damping_deviation, damping),
    ):
        if values and spread(given, min(values)) > min(values):
            yield key, NOTHING


def _shapes(target: ModesTarget) -> Iterator[tuple[str, str]]:
    """Measured shapes that are none, or are those of another mode."""
    shapes = {
        mode.mode: {
            (row.x, row.y, row.z, row.direction): row.amplitude
            for row in target.shapes
            if row.mode == mode.mode
        }
        for mode in target.modes
    }
    # A floor may move as a whole; several heights or directions do not move alike.
    flat = [
        mode
        for mode, shape in shapes.items()
        if len(set(shape.values())) == 1 and len({sensor[2:] for sensor in shape}) > 1
    ]
    if flat:
        numbers = ", ".join(map(str, flat))
        yield "shapes", f"all amplitudes of mode {numbers} are the same; expected measured ones"
    alike = []
    for a, b in itertools.combinations([mode for mode in shapes if mode not in flat], 2):
        common = [sensor for sensor in shapes[a] if sensor in shapes[b]]
        one, other = (np.array([shapes[mode][at] for at in common]) for mode in (a, b))
        # Fewer sensors than modes cannot tell all of them apart.
        if len(common) > len(shapes) and mac(one, other) > ALIKE:
            alike.append(f"{a} and {b} (MAC {mac(one, other):.3f})")
    if alike:
        text = f"one shape of modes {', '.join(alike)}: a mode twice, or sensors that cannot tell"
        yield "shapes", text


def _sensors(target: ModesTarget, problem: Problem) -> Iterator[tuple[str, str]]:
    """Sensors away from a stick; of those of a 3D model its mesh tells."""
    case = problem.case(problem.start)
    if target.building in {one.building for one in case.structures}:
        return
    building = case.building(target.building)
    heights = (building.base, *building.elevations)
    sides = building.length or FAR, building.width or FAR  # the axis may be at a corner
    reach = np.array([*sides, max(np.diff(heights))])
    low, high = (np.array([*building.axis, z]) for z in (heights[0], heights[-1]))
    places = np.unique(target.places, axis=0)
    away = places[((places < low - reach) | (places > high + reach)).any(axis=1)]
    if len(away):
        x, y, z = away[0]
        text = f"the sensor at ({x:g}, {y:g}, {z:g}) m is away from {target.building}"
        yield "shapes", text + (f"; so are {len(away) - 1} more" if len(away) > 1 else "")
