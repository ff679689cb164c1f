"""Variations of a small case, against full runs of the case with the changed keys."""

import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.damping import ConstantDamping
from impactfem.dynamics.damping import RatioTable, Rayleigh
from impactfem.run import loop
from impactfem.run.stages import needed_stages
from impactfem.spectra.resolved import band_limited_zpa
from impactfem.stages.device import capacity
from impactfem.stages.device.selection import loaded
from impactfem.stages.pounding import limits as of_floors
from impactfem.stages.sensitivity.compute import Demand
from impactfem.stages.sensitivity.demands import largest_ordinate
from impactfem.stages.sensitivity.figures import sensitivity_checks, shown_demands
from impactfem.stages.sensitivity.variations import (
    CORNER,
    Source,
    Unknown,
    damping_points,
    variations,
)
from impactfem.stages.stores import open_store, time_step
from impactfem.stages.transient import limits as of_models
from two_models import DEVICE, write_case

ENSEMBLE = "\n[ensemble]\nmotions = 3\n"
# The reduced models serve the changed damping, so that a full run with it has the same ones.
SERVED = (
    '\n[[damping_cases]]\nname = "light"\ntype = "constant"\nratio = "4 %"\nrestitution = 0.4\n'
)
STEPS = (
    ('time_step = "2 ms"', 'time_step = "1 ms"'),
    ('[pounding]\ntime_step = "0.5 ms"', '[pounding]\ntime_step = "0.25 ms"'),
)
POINTS = damping_points(Rayleigh.through(0.05, 1.0, 20.0), rising=False)
TABLE = ", ".join(f'["{f!r} Hz", {ratio!r}]' for f, ratio in POINTS)
CHANGES = {
    "gap: -50 %": (('gap = "1 mm"', 'gap = "0.5 mm"'),),
    "time step: half": STEPS,
    "damping above 20 Hz: constant": (
        (
            'ratio = "5 %"\nfrequencies = ["1 Hz", "20 Hz"]\n\n',
            f'type = "table"\npoints = [{TABLE}]\n\n',
        ),
    ),
}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A run with its sensitivities, and its case."""
    folder = tmp_path_factory.mktemp("sensitivity")
    path = write_case(folder, DEVICE, ENSEMBLE, SERVED)
    text = path.read_text()
    path.write_text(text.replace("[transient]\n", "[transient]\nserve_damping_cases = true\n", 1))
    loop.run(path, out=folder / "run", stage="sensitivity", draw=False)
    return SimpleNamespace(path=path, folder=folder / "run")


def in_band(folder, name, end):
    """The results of a run with ZPA and spectra up to a frequency."""
    history = {"pounding.nc": "acceleration", "transient.nc": "acceleration"}
    with open_store(folder / name) as store:
        store = loaded(store.load())
        values = store[history.get(name, "anchor_acceleration")].transpose("time", ...)
        zpa = band_limited_zpa(values.values.astype(float), time_step(store), end)
        labels = values.isel(time=0).copy(data=zpa)
        if name == "device.nc":
            labels = labels.sel(component=["x", "y", "z"]).rename(component="axis")
        elif name == "pounding.nc":
            labels = labels.sel(component=store["direction"].values).rename(component="direction")
        return store.assign(zpa=labels).assign_attrs(resolved_frequency=end)


def demands(path, folder, ends):
    """The demands of a run, in the resolved bands of another one."""
    case = load_case(path)
    found = of_floors.verdicts_of(case, in_band(folder, "pounding.nc", ends["pounding.nc"]))
    for building in case.in_time:
        own = building.folder(folder)
        start = f"{building.part}/" if building.part else ""
        store = in_band(own, "transient.nc", ends[f"{start}transient.nc"])
        found += of_models.verdicts_of(building, store)
        found.append(largest_ordinate("transient.floor_spectrum", store))
        if building.devices:
            store = in_band(own, "device.nc", ends[f"{start}device.nc"])
            found += capacity.verdicts_of(building, store)
    every = [Demand.of(one) for one in found]
    return np.array([one.value for one in every if np.isfinite(one.value)])


@pytest.fixture(scope="module")
def ends(done):
    """Ends of the resolved bands of the run [Hz]."""
    found = {}
    for path in done.folder.rglob("*.nc"):
        if path.stem in ("pounding", "transient", "device"):
            with open_store(path) as store:
                found[str(path.relative_to(done.folder))] = store.attrs["resolved_frequency"]
    return found


@pytest.mark.slow(4)
@pytest.mark.parametrize("label", CHANGES)
def test_sensitivities_are_those_of_full_runs(done, ends, tmp_path, label):
    # With the same reduced models.
    shutil.copytree(done.folder, tmp_path / "run")
    text = done.path.read_text()
    for old, new in CHANGES[label]:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = done.path.with_name("changed.toml")
    path.write_text(text)
    loop.run(path, out=tmp_path / "run", stage="transient", draw=False)
    loop.run(path, out=tmp_path / "run", stage="device", draw=False)
    expected = demands(path, tmp_path / "run", ends)
    with open_store(done.folder / "sensitivity.nc") as store:
        found = store["varied"].sel(variation=label).values
        value = store["value"].values
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    # The run without the change is another one.
    assert np.abs(expected / value - 1.0).max() > 1e-4


@pytest.mark.slow
def test_results(done):
    with open_store(done.folder / "sensitivity.nc") as store:
        assert not store.sizes["failed"]
        names = store["variation"].values.tolist()
        assert [name.partition(":")[0] for name in names].count("motion") == 1
        assert store["unknown"].values.tolist() == ["model"]
        assert np.isfinite(store["change"]).all()
        # Contact does not change what the run without contact gives; half of the gap does not.
        gap = store["change"].sel(demand=store["demand"].str.startswith("pounding.required_gap"))
        of_contact = np.isin(store["parameter"], ["contact_stiffness", "restitution", "gap"])
        assert np.abs(gap[of_contact]).max() < 1e-12
        assert 2 <= len(shown_demands(store)) <= 9
    checks = {check.id: check for check in sensitivity_checks(done.folder)}
    assert checks["sensitivity.failed"].passed
    assert 0.0 < checks["sensitivity.damping_basis_error"].value < 0.2


@pytest.fixture
def source(tmp_path):
    """What the variations of the small case are made from, without an ensemble."""
    case = load_case(write_case(tmp_path))
    law = SimpleNamespace(target_restitution=0.95, unilateral=False)
    pairs = [SimpleNamespace(law=law) for _ in case.contacts]
    return Source(case, SimpleNamespace(pairs=pairs), {}, {})


def made(source, parameter):
    wanted = source.case.sensitivity.model_copy(update={"parameters": (parameter,)})
    case = source.case.model_copy(update={"sensitivity": wanted})
    return variations(Source(case, source.system, source.impact_forces, source.members))


def test_restitution_stays_within_its_range(source):
    known, _ = made(source, "restitution")
    values = [one.case.contact_laws["floor"].restitution for one in known]
    assert values == pytest.approx([0.85, 1.0])


def test_motion_at_the_percentile(source):
    forces = {f"seed_{k}": float(k) for k in range(101)}
    cases = dict.fromkeys(forces, source.case)
    known, _ = made(Source(source.case, source.system, forces, cases), "motion")
    assert [one.keys for one in known] == ["motions: seed 84"]


def test_what_is_not_known(source):
    for parameter in ("motion", "model"):
        known, unknown = made(source, parameter)
        assert not known
        assert [one.parameter for one in unknown] == [parameter]
        assert isinstance(unknown[0], Unknown)


@pytest.mark.parametrize("rising", [False, True])
def test_damping_changes_above_the_corner_alone(rising):
    law = Rayleigh.through(0.05, 1.0, 20.0)
    changed = RatioTable(*zip(*damping_points(law, rising=rising), strict=True))
    low = np.geomspace(0.2, CORNER, 300)
    np.testing.assert_allclose(changed.ratio(low), law.ratio(low), rtol=2e-3)
    expected = 0.05 * (5.0 if rising else 1.0)
    assert changed.ratio(5.0 * CORNER) == pytest.approx(expected, rel=1e-2)


def test_constant_damping_rises(source):
    damping = ConstantDamping(type="constant", ratio=0.05)
    buildings = tuple(one.model_copy(update={"damping": damping}) for one in source.case.buildings)
    case = source.case.model_copy(update={"buildings": buildings})
    known, _ = made(Source(case, source.system, {}, {}), "damping")
    assert known[0].case.buildings[0].damping.law.ratio(100.0) == pytest.approx(0.25, rel=1e-2)


@pytest.mark.parametrize(
    ("more", "active"),
    [
        ("", True),
        ("[sensitivity]\nactive = false\n", False),
        ("[sensitivity]\nparameters = []\n", False),
    ],
)
def test_the_stage_is_active_by_default(tmp_path, more, active):
    case = load_case(write_case(tmp_path, more))
    names = [stage.name for stage in needed_stages(case, None)]
    assert ("sensitivity" in names) is active
