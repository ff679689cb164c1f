"""Fits of a building whose values are known."""

import json
import os
import shutil
import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.integrate
import scipy.stats
from mpi4py import MPI

from fit_texts import FREE, TARGETS
from impactfem import study
from impactfem.building import from_case
from impactfem.case import load_case
from impactfem.fit import modal
from impactfem.fit.evaluate import Evaluation, evaluate
from impactfem.fit.fit import Evaluator, _unlike_modes, identified, search
from impactfem.fit.fit_file import MeasuredMode, ModesTarget
from impactfem.fit.pieces import Pieces, read_off
from impactfem.fit.problem import read_problem
from impactfem.stages.building import compute
from impactfem.stages.building.compute import analysed
from impactfem.system.errors import Fault, InputError, SolutionError
from impactfem.system.log import LOGGER
from impactfem.system.scalar import Scalar
from no_pictures import no_pictures
from one_building import building_of

GEOMETRY = Path(__file__).parents[2] / "geometry"
MODES = """
[[targets]]
type = "modes"
building = "T"
modes = "modes.csv"
shapes = "shapes.csv"
frequency_deviation = "0.5 %"
"""


def test_one_key_to_one_frequency(case, written, tmp_path):
    """Stiffness alone: f goes with the root of E, so E/E₀ = (f/f₀)². A thousandth off is seen."""
    free = FREE.partition('[free."buildings')[0]
    target = TARGETS.split("[[targets]]")[1]
    problem, _ = read_problem(case, written(f"starts = 1\n{free}[[targets]]{target}"))
    (before,) = evaluate(problem, problem.start, tmp_path).values
    result = study.fit(case, problem.path, out=tmp_path / "f")
    assert result.values[0] == pytest.approx(33e9 * (0.93 / before) ** 2, rel=1e-7)
    assert result.values[0] != pytest.approx(33e9 * (0.931 / before) ** 2, rel=1e-4)
    # ± by hand: dE/df = 2 E/f.
    deviation = 2.0 * result.values[0] / 0.93 * 0.01 / 12.0**0.5
    assert result.bound[0] == pytest.approx(1.959964 * deviation, rel=1e-4)


@pytest.fixture
def repeated(kept_case):
    """The stick of the measured frame with four of its own frequencies and a mass as data."""
    data = "".join(
        f'[[targets]]\nresult = "sticks.T.{name}"\nvalue = "1 {unit}"\ndeviation = "1 {unit}"\n'
        for name, unit in (
            *((f"frequency.{k}", "Hz") for k in range(1, 5)),
            ("effective_mass.1", "t"),
        )
    )
    path = kept_case.with_name("some_fit.toml")
    path.write_text(FREE + data)
    return read_problem(kept_case, path)[0]


def both_within(bound, deviation, r):
    """Probability that two Gaussian errors of the correlation r are within ± of them."""
    first, second = bound / deviation
    side = np.sqrt(1.0 - r * r)

    def density(x):
        between = [scipy.stats.norm.cdf((end - r * x) / side) for end in (-second, second)]
        return scipy.stats.norm.pdf(x) * (between[1] - between[0])

    return scipy.integrate.quad(density, -first, first)[0]


def test_the_bounds_hold_95_of_100(repeated, tmp_path):
    """What each datum's error does to the keys, by searches on the sticks, not linearised.

    Errors of the data are independent and Gaussian: variances and covariances of the keys are sums
    of what one deviation of each datum does. From these follows how often both are within the ±.
    """
    truth = np.array([0.35, 0.6])
    value = np.array(evaluate(repeated, truth, tmp_path).values)
    evaluator, deviation = Evaluator(repeated, tmp_path, None), 0.005 * value
    one, none = np.ones_like(value), np.zeros_like(value)

    def found(measured):
        data = zip(repeated.data, measured, deviation, strict=True)
        data = tuple(replace(one, value=x, deviation=σ) for one, x, σ in data)
        evaluator.problem = replace(repeated, data=data)
        return search(evaluator, [truth], one, none)[0].x

    ends = np.array([[found(value + σ), found(value - σ)] for σ in np.diag(deviation)])
    linear = identified(evaluator.problem, value, evaluator.slopes(truth))
    moved = 0.5 * (ends[:, 0] - ends[:, 1])
    covariance = moved.T @ moved
    spread = np.sqrt(np.diag(covariance))
    r = covariance[0, 1] / spread.prod()
    assert linear.deviation == pytest.approx(spread, rel=2e-3)
    assert linear.correlation[0, 1] == pytest.approx(r, abs=2e-3)
    # With one datum left out it would be seen.
    without = np.sqrt([np.square(np.delete(moved, k, axis=0)).sum(axis=0) for k in range(5)])
    assert np.all(np.abs(linear.deviation / without - 1.0).max(axis=1) > 0.01)
    # What bends the way of a key is small beside its deviation.
    assert np.all(np.abs(0.5 * ends.sum(axis=1) - truth) < 0.02 * spread)
    # Šidák: at least 95 in 100, more where keys are correlated; the ± of each alone holds less.
    assert 0.95 <= both_within(linear.bound, spread, r) < 0.97
    assert both_within(1.959964 * linear.deviation, spread, r) < 0.94


def test_a_place_next_to_a_bound_is_on_it(repeated, tmp_path):
    """As a search starts 1e-10 inside: one evaluation for both, and another one farther inside."""
    evaluator = Evaluator(repeated, tmp_path, None)
    counts = []
    for x in (0.0, 1e-10, 1e-7, 1.0, 1.0 - 1e-10, 1.0 - 1e-7):
        evaluator.at(np.array([x, 0.5]))
        counts.append(len((tmp_path / "evaluations.jsonl").read_text().splitlines()))
    assert counts == [1, 1, 2, 3, 3, 4]


def test_slopes_next_to_a_bound(repeated, tmp_path):
    """By runs to one side only: inwards, also where a search is 1e-10 inside the bound."""
    runs = Evaluator(replace(repeated, level="run"), tmp_path, None)
    runs.at = lambda u, slopes=False: Evaluation([float(u @ [3.0, 5.0])], [None, None], {})
    for x in (0.0, 1e-10, 0.5, 1.0 - 1e-10, 1.0):
        assert runs.slopes(np.array([x, 0.5])) == pytest.approx(np.array([[3.0, 5.0]]), rel=1e-6)


@pytest.mark.parametrize(
    ("higher", "alike", "told"),
    [
        (1.205, (0.5, 0.5), ["1 and T.mode_2 are 0.42 % apart in frequency"]),
        (1.3, (0.5, 0.6), ["1 is matched with mode 1 of", "2 is matched with mode 4 of"]),
        (1.205, (0.5, 0.95), ["1 is matched with mode 1 of"]),
        (1.3, (0.9, 1.0), []),
    ],
)
def test_shapes_of_other_modes(higher, alike, told):
    """Of a symmetric building any two shapes at right angles are modes; others are none of it."""
    rows = tuple(MeasuredMode.model_construct(mode=k, frequency=1.2) for k in (1, 2))
    target = ModesTarget.model_construct(building="T", modes=rows)
    data = tuple(SimpleNamespace(name=f"T.mode_{k}.frequency") for k in (1, 2))
    problem = SimpleNamespace(data=data, fit=SimpleNamespace(targets=(target,)))
    shown = {f"T.mode_{k}.mac": one for k, one in enumerate(alike, 1)}
    shown |= {"T.mode_1.mode_of_the_model": 1.0, "T.mode_2.mode_of_the_model": 4.0}
    result = SimpleNamespace(problem=problem, after=np.array([1.2, higher]), shown=shown)
    found = list(_unlike_modes(result))
    assert len(found) == len(told)
    for text, words in zip(found, told, strict=True):
        assert text.startswith(f"T.mode_{words}")


def test_a_start_where_the_case_has_none(repeated, tmp_path, monkeypatch, caplog):
    """Its search is left out with a warning; where all are, their fault is that of the fit."""
    evaluator, true = Evaluator(repeated, tmp_path, None), Evaluator.values

    def values(self, u):
        if u[0] > 0.5:
            raise InputError([Fault("case.toml", "damping", None, "expected another one")])
        return true(self, u)

    monkeypatch.setattr(Evaluator, "values", values)
    one, none = np.ones(5), np.zeros(5)
    outside, inside = np.array([0.9, 0.5]), np.array([0.2, 0.5])
    found = search(evaluator, [outside, inside], one, none)
    assert len(found) == 1
    assert "damping: expected another" in caplog.text
    with pytest.raises(InputError, match="expected another one"):
        search(evaluator, [outside], one, none)


def test_a_key_that_the_data_do_not_see(case, written, tmp_path):
    """The damping changes no frequency: named, without a ±; of the other keys there is one."""
    free = "starts = 1\n" + FREE + '[free."damping.ratio"]\nbounds = ["1 %", "9 %"]\n'
    result = study.fit(case, written(free + TARGETS), out=tmp_path / "f")
    assert result.identification.unseen == [2]
    (text,) = [text for text in result.warnings if "do not see damping.ratio" in text]
    assert result.u[2] == result.problem.start[2]
    assert text.endswith(
        "its value is that of its start"
    )  # of this case, which fits nothing itself
    assert np.isinf(result.bound[2]) and np.isfinite(result.bound[:2]).all()
    assert result.values[2] == pytest.approx(0.05, abs=1e-6)  # as it was
    rows = (tmp_path / "f" / "fit_keys.csv").read_text().splitlines()
    assert rows[3].startswith("damping.ratio,-,0.05,") and rows[3].endswith(",,,no,no")
    few = "some_fit.toml: free: 3 keys, but 2 data and priors"
    assert few in (tmp_path / "f" / "fit.log").read_text("utf-8")
    # With a prior it has the value and the deviation of the prior, and is still not seen.
    prior = free + 'prior = { mean = "3 %", deviation = "0.5 %" }\n'
    known = study.fit(case, written(prior + TARGETS), out=tmp_path / "g")
    assert known.identification.unseen == [2]
    assert "data and priors" not in (tmp_path / "g" / "fit.log").read_text("utf-8")
    assert known.values[2] == pytest.approx(0.03, rel=1e-4)
    assert known.identification.deviation[2] * 0.08 == pytest.approx(0.03 * 0.005, rel=1e-6)


@pytest.mark.parametrize(
    ("most", "seen", "words"), [(20.0, "not here", "is not fitted: at 0.05 the"), (0.5, "no", "")]
)
def test_a_key_that_the_data_see_elsewhere(case, written, tmp_path, monkeypatch, most, seen, words):
    """As a gap where nothing touches: no slope, and so many deviations at the lower bound."""
    free = "starts = 1\n" + FREE + '[free."damping.ratio"]\nbounds = ["1 %", "9 %"]\n'

    def touching(problem, u, folder, slopes=False):
        found = evaluate(problem, u, folder, slopes)
        more = most * problem.data[0].deviation * max(0.0, 1.0 - u[2] / 0.4)
        return replace(found, values=[found.values[0] + more, *found.values[1:]])

    monkeypatch.setattr(sys.modules["impactfem.fit.fit"], "evaluate", touching)
    result = study.fit(case, written(free + TARGETS), out=tmp_path / "f")
    assert result.across[2] == pytest.approx((most, 0.0), rel=1e-6, abs=1e-6)
    assert result.unseen == ([2] if most < 1.0 else [])
    assert (tmp_path / "f" / "fit_keys.csv").read_text().splitlines()[3].endswith(f",no,{seen}")
    (text,) = [text for text in result.warnings if "damping.ratio" in text]
    assert ("not see damping.ratio" in text) == (most < 1.0)
    if words:
        assert words in text and "by 20 standard deviations" in text
    # At a bound where the case is refused nothing is known, and the other one counts.
    assert replace(result, across={2: (np.nan, most)}).unseen == result.unseen
    assert replace(result, across={2: (most, np.nan)}).unseen == result.unseen
    assert replace(result, across={2: (np.nan, np.nan)}).unseen == [2]


def test_a_key_that_the_data_do_not_see_keeps_its_start(case, written, tmp_path, monkeypatch):
    """Where the best search began elsewhere, too; not where that changes what the model gives."""
    free = FREE + '[free."damping.ratio"]\nbounds = ["1 %", "9 %"]\n'
    path = written("starts = 1\n" + free + TARGETS)
    fitting, away = sys.modules["impactfem.fit.fit"], np.array([0.0, 0.0, 0.3])
    monkeypatch.setattr(fitting, "starts_within", lambda first, *_: [first + away])
    result = study.fit(case, path, out=tmp_path / "f")
    assert result.values[2] == pytest.approx(0.05, abs=1e-12)
    monkeypatch.setattr(fitting, "BLIND", 0.0)
    other = study.fit(case, path, out=tmp_path / "g")
    assert other.values[2] == pytest.approx(0.074, abs=1e-6)
    assert any(text.endswith("its value says nothing") for text in other.warnings)
    assert other.after == pytest.approx(result.after, rel=1e-9)


@pytest.mark.parametrize(
    ("free", "target", "words"),
    [
        # A prior that the data contradict, and the same one where they agree.
        (
            'bounds = ["15 GPa", "60 GPa"]\nprior = { mean = "50 GPa", deviation = "1 %" }\n',
            "0.93 Hz",
            "data and priors are not met",
        ),
        (
            'bounds = ["15 GPa", "60 GPa"]\nprior = { mean = "33 GPa", deviation = "1 %" }\n',
            "{before} Hz",
            "",
        ),
        # One datum, one key: missed at a bound, and met.
        ('bounds = ["30 GPa", "36 GPa"]\n', "0.93 Hz", "the data are not met"),
        ('bounds = ["15 GPa", "60 GPa"]\n', "0.93 Hz", ""),
    ],
)
def test_what_is_missed(case, written, tmp_path, free, target, words):
    """Said where χ² of data and priors is too large, with the one that is missed most."""
    head = f'starts = 1\n[free."materials.concrete.young_modulus"]\n{free}'
    end = f'[[targets]]\nresult = "sticks.T.frequency.1"\nvalue = "{target}"\ndeviation = "1 %"\n'
    path = written(head + end.replace("{before}", "1"))
    problem, _ = read_problem(case, path)
    (before,) = evaluate(problem, problem.start, tmp_path).values
    path.write_text(head + end.replace("{before}", f"{before:.6f}"))
    result = study.fit(case, path, out=tmp_path / "f")
    found = [text for text in result.warnings if "not met" in text]
    summary = json.loads((tmp_path / "f" / "fit.json").read_text())["chi_squared"]
    page = (tmp_path / "f" / "fit.md").read_text("utf-8")
    χ2 = float(np.square(result.errors[1]).sum()), result.chi_squared_of_priors[1]
    assert (summary["after"], summary["priors_after"]) == pytest.approx(χ2)
    assert ("of the priors: " in page) == ("prior" in free) == (summary["priors"] == 1)
    assert len(found) == bool(words) and (sum(χ2) > 3.84) == bool(words)
    for text in found:
        assert text.startswith(words) and text in page
        of_data = abs(result.errors[1][0]) > χ2[1] ** 0.5
        name = "" if of_data else "the prior of materials.concrete.young_modulus"
        assert f"missed most is {name or 'sticks.T.frequency.1'}, by" in text


def test_what_is_written(case, written, tmp_path, monkeypatch):
    """The fitted case runs to the data; no place is evaluated twice, nor by the same fit again."""
    folder = tmp_path / "f"
    result = study.fit(case, written(FREE + TARGETS), out=folder)
    assert np.abs(result.errors[1]).max() < 1e-3 < np.abs(result.errors[0]).max()
    fitted = load_case(folder / "fitted.toml")
    assert fitted.materials["concrete"].young_modulus == pytest.approx(result.values[0])
    assert fitted.buildings[0].second_moment_factor == pytest.approx(result.values[1])
    assert (folder / "fit_errors.svg").is_file() and (folder / "fit_correlation.svg").is_file()
    summary = json.loads((folder / "fit.json").read_text())
    assert summary["targets"][0]["after"] == pytest.approx(0.93, rel=1e-4)
    assert "| materials.concrete.young_modulus | Pa |" in (folder / "fit.md").read_text("utf-8")
    lines = (folder / "evaluations.jsonl").read_text().splitlines()
    assert len({json.loads(line)[0] for line in lines}) == len(lines) == result.evaluations
    with (folder / "evaluations.jsonl").open("a") as stream:
        stream.write('["half of a li')  # as a kill leaves it
    monkeypatch.setattr("impactfem.fit.fit.evaluate", None)
    again = study.fit(case, tmp_path / "some_fit.toml", out=folder)
    assert again.evaluations == result.evaluations and np.array_equal(again.u, result.u)


def test_several_at_a_time(case, written, tmp_path):
    path = written("starts = 2\n" + FREE + TARGETS)
    result = study.fit(case, path, out=tmp_path / "b", processes=2)
    assert np.abs(result.errors[1]).max() < 1e-3
    assert len(result.minima) == 2


def test_by_a_run(case, written, tmp_path, monkeypatch):
    """Scalars and ordinates of a run are those of its folder; a spectrum between two of them."""
    no_pictures(monkeypatch)
    text = case.read_text().replace('duration = "10 s"', 'duration = "1 s"')
    text = text.replace('strong_phase = ["2 s", "6 s"]', 'strong_phase = ["0.2 s", "0.8 s"]')
    case.write_text(text.replace("per_decade = 20", "per_decade = 5"))
    (tmp_path / "psa.csv").write_text("frequency [Hz],psa [m/s2]\n1,3\n20,4\n")
    free = '[free."motions[0].pga"]\nbounds = ["0.5 m/s2", "3 m/s2"]\n'
    targets = """
[[targets]]
result = "motion.pga"
value = "2.0 m/s2"
[[targets]]
type = "spectrum"
building = "T"
floor = 4
direction = "y"
damping = "5 %"
spectrum = "psa.csv"
"""
    problem, _ = read_problem(case, written(free + targets))
    assert (problem.level, problem.stages) == ("run", ("pounding",))
    before = LOGGER.handlers[:], LOGGER.propagate, LOGGER.level
    found = evaluate(problem, np.array([0.4]), tmp_path)
    assert before == (
        LOGGER.handlers,
        LOGGER.propagate,
        LOGGER.level,
    )  # what the fit says later is still seen
    run_folder = next((tmp_path / "runs").iterdir())
    run = study.open_run(run_folder)
    assert found.values[0] == run.value("motion.pga") == pytest.approx(1.5, rel=1e-6)
    curve = run.pounding.psa.sel(station="T.floor_4", direction="y", damping=0.05)
    for f, value in zip((1.0, 20.0), found.values[1:], strict=True):
        at = float(np.exp(np.interp(np.log(f), np.log(curve.frequency), np.log(curve))))
        assert value == pytest.approx(at, rel=1e-9)
    # What the run alone knows is refused with the number of the target and its value.
    scalar, spectrum = problem.fit.targets
    ordinate = spectrum.spectrum[0].model_copy(update={"frequency": 900.0})
    for of, update, words in (
        (scalar, {"result": "motion.pgg"}, "targets[0].result = 'motion.pgg': expected the name"),
        (spectrum, {"direction": "x"}, "targets[1].direction = 'x': no spectrum of the run"),
        (spectrum, {"spectrum": (ordinate,)}, "targets[1].spectrum = '900 Hz': expected freq"),
    ):
        changed = of.model_copy(update=update)
        targets = tuple(changed if one is of else one for one in problem.fit.targets)
        other = replace(problem, fit=problem.fit.model_copy(update={"targets": targets}))
        pieces = Pieces({"motion.pga": Scalar("motion.pga", 1.5, "m/s2")}, run=run_folder)
        with pytest.raises(InputError) as error:
            read_off(other, other.case(np.array([0.4])), pieces)
        assert words in str(error.value)
    # A result without a value hides no fault of the others.
    absent = scalar.model_copy(update={"result": "motion.none"})
    none = {"motion.none": Scalar("motion.none", None, "m/s2", "no impact")}
    wrong = scalar.model_copy(update={"result": "motion.pgg"})
    for targets, kind, words in (
        ((absent, wrong), InputError, "motion.pgg"),
        ((absent,), SolutionError, "targets[0]: motion.none has no value. no impact"),
    ):
        other = replace(problem, fit=problem.fit.model_copy(update={"targets": targets}))
        with pytest.raises(kind) as error:
            read_off(other, other.case(np.array([0.4])), Pieces(none))
        assert words in str(error.value)


def test_results_that_are_not_there(case, written, tmp_path):
    for name, value, words in (
        ("frequency.9", "1 Hz", "expected a mode of T from 1 to 6"),
        ("frequency.1", "1 s", "expected a value in Hz, the unit of the result"),
    ):
        target = f'[[targets]]\nresult = "sticks.T.{name}"\nvalue = "{value}"\n'
        with pytest.raises(InputError, match="targets") as error:
            study.fit(case, written(FREE + target), out=tmp_path / "f")
        assert words in str(error.value)


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        ("14,8,12", ""),
        ("14,20,12", "the sensor at (14, 20, 12) m is 12 m from the nearest node of T; expected"),
        ("7,4,17", "the size of an element; so it is of 1 more"),  # in mid-air
    ],
)
def test_a_sensor_outside_the_building(case, written, tmp_path, sensor, words):
    """Named by its target and its place, by `check --fit` and before anything is compared."""
    case.write_text(case.read_text().replace('size = "1 m"', 'size = "3 m"'))
    shapes = (tmp_path / "updating_shapes.csv").read_text().replace("1,14,8,12,y", f"1,{sensor},y")
    if "more" in words:
        shapes = shapes.replace("1,0,0,6,x", "1,0,0,6000,x")  # in mm
    (tmp_path / "shapes.csv").write_text(shapes)
    path = written(FREE + MODES.replace('"modes.csv"', '"updating_modes.csv"'))
    if not words:
        read_problem(case, path, mesh=True)
        return
    for refused in (
        lambda: read_problem(case, path, mesh=True),
        lambda: study.fit(case, path, out=tmp_path / "f"),
    ):
        with pytest.raises(InputError, match=r"targets\[0\].shapes:") as error:
            refused()
        assert words in str(error.value)


def frame(tmp_path, text, factor="storey_stiffness_factor = 0.5\n"):
    """The small frame on a mesh of its own, whose factor is not fitted."""
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, tmp_path)
    path = tmp_path / "frame.toml"
    path.write_text(
        path.read_text().replace('calibration = { frequency = "4 Hz", direction = "y" }\n', "")
    )
    (tmp_path / "frame_fit.toml").write_text(text)
    return path, tmp_path / "frame_fit.toml"


FRAME = """
[free."materials.concrete.young_modulus"]
bounds = ["20 GPa", "45 GPa"]
scale = "log"
[free."materials.concrete.density"]
bounds = ["2200 kg/m3", "2600 kg/m3"]
[free."buildings[0].structure.storey_stiffness_factor"]
bounds = [0.2, 1.2]
[free."buildings[0].structure.mesh.shells[0].thickness"]
bounds = ["15 cm", "25 cm"]
[[targets]]
result = "building.frequency.1"
value = "4.0 Hz"
[[targets]]
result = "building.frequency.2"
value = "12.0 Hz"
[[targets]]
result = "building.effective_mass.1"
value = "50 t"
[[targets]]
result = "building.effective_mass.2"
value = "10 t"
[[targets]]
result = "building.mass"
value = "60 t"
"""


def test_closed_form_slopes(tmp_path):
    """Of frequencies and masses by modulus, density, factor and thickness, against differences."""
    problem, _ = read_problem(*frame(tmp_path, FRAME))
    u = np.array([0.6, 0.5, 0.4, 0.5])
    found = evaluate(problem, u, tmp_path, slopes=True)
    J, h = np.array(found.slopes).T, 2e-4
    for k in range(len(u)):
        low, high = (
            np.array(evaluate(problem, u + s * h * np.eye(4)[k], tmp_path).values) for s in (-1, 1)
        )
        by_differences = (high - low) / (2.0 * h)
        size = np.abs(found.values)
        assert J[:, k] / size == pytest.approx(by_differences / size, rel=1e-6, abs=1e-7)
    # λ goes with the modulus, no mass does.
    assert J[:2, 0] == pytest.approx(
        0.5 * np.log(45.0 / 20.0) * np.array(found.values[:2]), rel=1e-6
    )
    assert np.abs(J[2:, 0]).max() < 1e-6 * found.values[2]


def test_a_model_starts_from_the_last_one(tmp_path, monkeypatch):
    """On the same mesh, which is read once, and with the same results; not that of another fit."""
    problem, _ = read_problem(*frame(tmp_path, FRAME))
    read, near = [], []
    seen = {(from_case, "read_mesh"): read, (compute, "modes_near"): near}
    for (where, name), calls in seen.items():
        own = getattr(where, name)
        monkeypatch.setattr(where, name, lambda *a, f=own, c=calls, **k: c.append(1) or f(*a, **k))
    monkeypatch.setattr(modal, "_KNOWN", {})
    evaluate(problem, np.array([0.6, 0.5, 0.4, 0.5]), tmp_path)
    assert (len(read), len(near)) == (1, 0)
    u = np.array([0.4, 0.6, 0.6, 0.7])
    started = evaluate(problem, u, tmp_path, slopes=True)
    assert (len(read), len(near)) == (1, 1)
    problem.path.write_text(modulus('["20 GPa", "60 GPa"]', hertz=4.0))
    other, _ = read_problem(problem.source.path, problem.path)
    evaluate(other, np.array([0.5]), tmp_path)
    assert (len(read), len(near)) == (2, 1)
    alone = evaluate(problem, u, tmp_path, slopes=True)
    assert (len(read), len(near)) == (3, 1)
    assert started.values == pytest.approx(alone.values, rel=1e-9)
    for slopes, others in zip(started.slopes, alone.slopes, strict=True):
        assert slopes == pytest.approx(others, rel=1e-5, abs=1e-6 * max(alone.values))


def test_a_modulus_that_a_factor_hides(tmp_path):
    """The case fits the factor on walls and columns to the frequency that is the datum: said."""
    path, fit_path = frame(tmp_path, modulus('["32 GPa", "34 GPa"]', hertz=4.0))
    shutil.copy(GEOMETRY / "frame.toml", path)  # with its calibration
    result = study.fit(path, fit_path, out=tmp_path / "f")
    (text,) = [text for text in result.warnings if "do not see" in text]
    assert text.endswith("the case fits the factor on walls and columns anew in each evaluation")


def modulus(bounds, more="", hertz=3.6):
    """A fit of the modulus of the small frame to a frequency."""
    free = f'[free."materials.concrete.young_modulus"]\nbounds = {bounds}\n{more}'
    target = f'[[targets]]\nresult = "building.frequency.1"\nvalue = "{hertz!r} Hz"\n'
    return f'starts = 1\n{free}{target}deviation = "1 %"\n'


def test_the_same_folder_with_other_bounds(tmp_path):
    """Values are used again, closed-form slopes not: the ± is that of a folder of its own."""
    path, fit_path = frame(tmp_path, modulus('["20 GPa", "60 GPa"]'))
    problem, _ = read_problem(path, fit_path)
    # What the frame has: the search ends where it starts, at a place that was evaluated before.
    (has,) = evaluate(problem, problem.start, tmp_path).values
    fit_path.write_text(modulus('["20 GPa", "60 GPa"]', hertz=has))
    first = study.fit(path, fit_path, out=tmp_path / "f")
    for bounds, more in (
        ('["10 GPa", "90 GPa"]', ""),
        ('["10 GPa", "90 GPa"]', 'scale = "log"\n'),
    ):
        fit_path.write_text(modulus(bounds, more, has))
        again = study.fit(path, fit_path, out=tmp_path / "f")
        fresh = study.fit(path, fit_path, out=tmp_path / f"g{len(more)}")
        assert again.bound == pytest.approx(fresh.bound, rel=1e-3)
        assert again.bound == pytest.approx(first.bound, rel=0.01)
    # Written in another way, the same bounds: nothing is computed, and the slopes are theirs.
    kept = (tmp_path / "f" / "evaluations.jsonl").read_bytes()
    fit_path.write_text(modulus('["10000 MPa", "9.0e10 Pa"]', 'scale = "log"\n', has))
    same = study.fit(path, fit_path, out=tmp_path / "f")
    assert (tmp_path / "f" / "evaluations.jsonl").read_bytes() == kept
    assert same.evaluations == again.evaluations and same.bound == pytest.approx(
        again.bound, rel=1e-9
    )


def test_values_serve_other_bounds(repeated, tmp_path):
    """Of sticks nothing kept depends on the bounds; another value of a key is another place."""
    first, u = Evaluator(repeated, tmp_path, None), np.array([0.35, 0.6])
    first.at(u, slopes=True)
    free = {
        key: one.model_copy(update={"step": 5e-4, "scale": "linear"})
        for key, one in repeated.fit.free.items()
    }
    other = replace(repeated, fit=repeated.fit.model_copy(update={"free": free}))
    place = [one.scaled(x) for one, x in zip(free.values(), repeated.values(u), strict=True)]
    again = Evaluator(other, tmp_path, None)
    assert other.scale != repeated.scale
    assert again.at(np.array(place), slopes=True).values == first.at(u).values
    kept = tmp_path / "evaluations.jsonl"
    assert len(kept.read_text().splitlines()) == 1
    again.at(u)
    assert len(kept.read_text().splitlines()) == 2


def test_the_storey_factor_of_the_stage(tmp_path):
    """One key to the first bending mode: the factor that the stage `building` fits by itself."""
    case = load_case(GEOMETRY / "frame.toml")
    (tmp_path / "mesh").mkdir()
    study_of_stage, model, _ = analysed(
        building_of(case), tmp_path / "mesh", MPI.COMM_SELF, nullcontext
    )
    model.mass.destroy()
    free = '[free."buildings[0].structure.storey_stiffness_factor"]\nbounds = [0.05, 2]\n'
    target = '[[targets]]\nresult = "building.frequency.1"\nvalue = "4 Hz"\ndeviation = "1e-6 Hz"\n'
    result = study.fit(*frame(tmp_path, f"starts = 1\n{free}{target}"), out=tmp_path / "f")
    # The stage ends at a frequency within 1e-6.
    assert result.values[0] == pytest.approx(study_of_stage.factor, rel=5e-6)
    assert result.values[0] != pytest.approx(0.5, rel=0.01)  # the start


@pytest.mark.parametrize(("slope", "count"), [(0.0, 2), (1.0, 1)])
def test_two_solutions(case, written, tmp_path, monkeypatch, slope, count):
    """A parabola meets the first datum at two places; a second datum with a slope decides."""

    def parabola(problem, u, folder, slopes=False):
        return Evaluation([0.93 + (u[0] - 0.2) * (u[0] - 0.8), 3.4 + slope * (u[0] - 0.2)], [], {})

    monkeypatch.setattr(sys.modules["impactfem.fit.fit"], "evaluate", parabola)
    monkeypatch.setattr(Evaluator, "slopes", lambda self, u: np.array([[2 * u[0] - 1], [slope]]))
    key, folder = "materials.concrete.young_modulus", tmp_path / "f"
    free = f'starts = 8\n[free."{key}"]\nstart = "20 GPa"\nbounds = ["10 GPa", "50 GPa"]\n'
    result = study.fit(case, written(free + TARGETS), out=folder)
    found = json.loads((folder / "fit.json").read_text())["solutions"]
    told = [text for text in result.warnings if "solutions" in text]
    page, file = (folder / "fit.md").read_text("utf-8"), folder / "fit_solutions.csv"
    assert len(found) == len(result.solutions) == count
    assert (count == 2) == bool(told) == file.is_file() == ("data equally" in page)
    assert found[0]["keys"][key] == pytest.approx(result.values[0], rel=1e-6)
    if count == 2:
        assert sorted(one["keys"][key] for one in found) == pytest.approx([18e9, 42e9], rel=1e-4)
        assert sum(one["starts"] for one in found) == 8 and key in told[0]
        assert len(result.tables) == 3 and len(file.read_text().splitlines()) == 3
        # Another fit in the same folder leaves no list of this one.
        one = written(free.replace("starts = 8", "starts = 1") + TARGETS)
        assert len(study.fit(case, one, out=folder).solutions) == 1
        assert not file.is_file()


def damaged(lines, how):
    """The lines of kept evaluations with the last one damaged, as bytes."""
    key, entry, digest = json.loads(lines[-1])
    if how == "values":
        entry["values"] = [1.5 * x for x in entry["values"]]
    elif how == "nan":
        entry["values"][0] = float("nan")
    elif how == "text":
        entry["values"][0] = "one"
    elif how == "count":
        entry["values"].append(1.0)
    last = {
        "byte": lines[-1].encode().replace(b"e", b"\xff", 1),
        "no hash": json.dumps([key, entry]).encode(),
        "deep": b"[" * 100_000,
    }.get(how, json.dumps([key, entry, digest]).encode())
    return b"\n".join([*(line.encode() for line in lines[:-1]), last]) + b"\n"


@pytest.mark.parametrize(
    "how", ["values", "nan", "text", "count", "byte", "no hash", "deep", "half a line"]
)
def test_damaged_evaluations(repeated, tmp_path, caplog, how):
    """Each is computed again and kept; those of other lines are used."""
    first, places = Evaluator(repeated, tmp_path, None), np.array([[0.3, 0.5], [0.4, 0.5]])
    values = [first.at(u).values for u in places]
    file = tmp_path / "evaluations.jsonl"
    lines = file.read_text().splitlines()
    kept = file.read_bytes()
    file.write_bytes(kept[:-30] if how == "half a line" else damaged(lines, how))
    again = Evaluator(repeated, tmp_path, None)
    assert "damaged lines: 1;" in caplog.text and len(again.known) == 1
    assert [again.at(u).values for u in places] == values
    assert len(Evaluator(repeated, tmp_path, None).known) == 2


def test_a_pipe_in_place_of_the_evaluations(repeated, tmp_path):
    os.mkfifo(tmp_path / "evaluations.jsonl")
    with pytest.raises(InputError, match="regular file"):
        Evaluator(repeated, tmp_path, None)


def test_a_value_that_is_not_finite(repeated, tmp_path, monkeypatch):
    values = [1.0, 2.0, np.nan, 4.0, 5.0]
    monkeypatch.setattr(sys.modules["impactfem.fit.evaluate"], "read_off", lambda *_: (values, {}))
    with pytest.raises(SolutionError, match=r"finite value of sticks\.T\.frequency\.3"):
        evaluate(repeated, np.array([0.3, 0.5]), tmp_path)
