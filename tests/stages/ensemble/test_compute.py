"""Ensembles: members, bands, failures that are not fatal, going on after an interruption."""

import csv
import shutil
from concurrent.futures import Executor, Future
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from impactfem.case import load_case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.records.accelerogram import Accelerogram
from impactfem.records.csv import write_csv
from impactfem.stages.drawing import Figures
from impactfem.stages.ensemble import compute as ensemble
from impactfem.stages.ensemble.compute import members_of, run_ensemble
from impactfem.stages.ensemble.figures import bands, ensemble_checks, ensemble_table
from impactfem.stages.ensemble.stage import ENSEMBLE
from impactfem.stages.ensemble.store import OUTPUTS, percentiles, write_ensemble
from impactfem.stages.stores import dataset, open_store
from impactfem.system.errors import SolutionError
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import scalars_of

from ..figure_file import draw_all

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


class Inline(Executor):
    """Runs at once, in this process."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def case(new_case, tmp_path):
    path = new_case(tmp_path)
    text = path.read_text(encoding="utf-8") + "\n[ensemble]\nmotions = 4\nfirst_seed = 7\n"
    path.write_text(text, encoding="utf-8")
    return load_case(path)


@pytest.fixture
def run(case, tmp_path):
    ready = (calibration_of(case), system_of(case, None))

    def call(case=case, progress=lambda done, of: None):
        return run_ensemble(case, ready, tmp_path / "members", "key", Inline(), progress)

    return call


def test_members_have_seeds_of_their_own(case):
    members = members_of(case)
    assert list(members) == ["seed_7", "seed_8", "seed_9", "seed_10"]
    assert [m.motions[0].seed for m in members.values()] == [7, 8, 9, 10]
    assert members_of(case.model_copy(update={"ensemble": None})) == {}


def test_components_never_share_a_seed(case):
    other = case.motions[0].model_copy(update={"direction": "x"})
    two = case.model_copy(update={"motions": (*case.motions, other)})
    seeds = [motion.seed for m in members_of(two).values() for motion in m.motions]
    assert len(set(seeds)) == len(seeds) == 8


def test_percentiles_are_those_of_the_members(run):
    result = run()
    assert list(result.scalars.index) == ["seed_7", "seed_8", "seed_9", "seed_10"]
    assert not result.failed
    column = result.scalars["motion.pgv"]
    assert len(set(column)) == 4
    found = percentiles(result.scalars[["motion.pgv"]].to_numpy())[:, 0]
    assert found[2] == pytest.approx(np.median(column))
    assert found[3] == pytest.approx(np.percentile(column, 84)) and found[1] < found[3]
    psa = result.spectra["psa"]
    assert psa.shape[0] == 4 and np.ptp(psa, axis=0).max() > 0.0
    # Of all buildings, of which any may govern.
    of_all = psa[:, 0].max(axis=(1, 2, 3))
    np.testing.assert_allclose(result.scalars["frs.largest"], of_all, rtol=1e-12)
    of_floor = [name for name in result.scalars if name.endswith("floor_3.peak")]
    assert of_floor == ["frs.floor_3.peak", "frs.east.floor_3.peak"] and psa.shape[2] == 6
    # What all members share is no band.
    assert not [name for name in result.scalars if name.startswith("sticks.")]


def test_what_is_not_known_is_in_no_percentile():
    found = percentiles(np.array([[1.0, np.nan], [3.0, np.nan], [np.nan, np.nan]]))
    assert found[2, 0] == 2.0 and np.isnan(found[:, 1]).all()


def test_a_motion_without_an_impact_has_no_force(case, tmp_path):
    """It counts as zero among forces and impulses; it has no time or duration of an impact."""
    far = [pair.model_copy(update={"gap": 10.0}) for pair in case.contacts]
    case = case.model_copy(update={"contacts": tuple(far)})
    ready = calibration_of(case), system_of(case, None)
    result = run_ensemble(case, ready, tmp_path / "none", "key", Inline(), lambda done, of: None)
    main = result.scalars.filter(like="main_impact_")
    assert (main.filter(regex="force|impulse") == 0.0).all(axis=None)
    assert main.filter(regex="time|duration|restitution").isna().all(axis=None)


def test_a_member_is_the_run_of_its_seed(case, run):
    result = run()
    single = ensemble.run_member((None, system_of(case, None)), members_of(case)["seed_9"])
    np.testing.assert_array_equal(single["psa"], result.spectra["psa"][2])
    assert np.abs(single["psa"] - result.spectra["psa"][1]).max() > 0.0


def test_members_that_move_along_other_directions(run, monkeypatch, tmp_path):
    """One with an impact across moves along x, too; the others have zeros there."""
    one_direction, right = run(), ensemble.run_member

    def turned(ready, member, models=None):
        found = right(ready, member)
        if member.motions[0].seed == 8:
            for part in ensemble.PARTS:
                axis = -1 if part.startswith("pfa") else -2
                found[part] = np.concatenate([2.0 * found[part], found[part]], axis)
            found["directions"] = np.array(["x", "y"])
        return found

    monkeypatch.setattr(ensemble, "run_member", turned)
    shutil.rmtree(tmp_path / "members")
    found = run().spectra
    assert list(found["directions"]) == ["x", "y"]
    for part in ensemble.PARTS:
        x, y = np.moveaxis(found[part], -1 if part.startswith("pfa") else -2, 0)
        right_y = one_direction.spectra[part].reshape(y.shape)
        np.testing.assert_array_equal(y, right_y)
        np.testing.assert_array_equal(x[1], 2.0 * y[1])
        assert not x[[0, 2, 3]].any()


def test_what_is_done_is_not_done_again(run, monkeypatch, tmp_path):
    first = run()
    seen = []
    monkeypatch.setattr(ensemble, "run_member", lambda *_: pytest.fail("done again"))
    again = run(progress=lambda done, of: seen.append((done, of)))
    np.testing.assert_array_equal(again.scalars, first.scalars)
    assert seen == [(4, 4)]


def test_an_interrupted_ensemble_goes_on(run, tmp_path):
    whole = run()
    files = sorted((tmp_path / "members").iterdir())
    files[0].unlink()
    files[1].write_bytes(files[1].read_bytes()[:100])
    seen = []
    again = run(progress=lambda done, of: seen.append(done))
    assert seen == [2, 3, 4]
    np.testing.assert_array_equal(again.spectra["psa"], whole.spectra["psa"])


def test_a_failure_is_named_and_not_fatal(run, monkeypatch, caplog):
    right = ensemble.run_member

    def fail(ready, member, models=None):
        if member.motions[0].seed == 8:
            raise SolutionError("no motion was found")
        return right(ready, member)

    monkeypatch.setattr(ensemble, "run_member", fail)
    result = run()
    assert result.failed == {"seed_8": "no motion was found"}
    assert list(result.scalars.index) == ["seed_7", "seed_9", "seed_10"]


def test_too_few_members_are_an_error(run, monkeypatch):
    def fail(ready, member, models=None):
        raise SolutionError("no motion was found")

    monkeypatch.setattr(ensemble, "run_member", fail)
    with pytest.raises(SolutionError, match=r"two.*seed_7: no motion"):
        run()


def test_records_of_a_folder(case, tmp_path):
    folder = tmp_path / "records"
    folder.mkdir()
    t = np.arange(300) * 0.01
    for k in (1, 2, 3):
        write_csv(Accelerogram(0.01, k * np.sin(7.0 * t), "r", "made"), folder / f"r{k}.csv")
    path = case.path
    text = path.read_text(encoding="utf-8")
    start, end = text.index("[[motions]]"), text.index("# Laws of the contact force")
    motion = '[[motions]]\ndirection = "y"\ntype = "record"\nfile = "records/r1.csv"\n\n'
    text = text[:start] + motion + text[end:]
    text = text.replace("motions = 4\nfirst_seed = 7", 'records = "records"')
    path.write_text(text, encoding="utf-8")
    found = members_of(load_case(path))
    assert list(found) == ["r1.csv", "r2.csv", "r3.csv"]
    assert [m.motions[0].file for m in found.values()] == [folder / name for name in found]


def test_store(case, run, tmp_path):
    result = run()
    write_ensemble(tmp_path / "ensemble.nc", case, result, "the key")
    with xr.open_dataset(tmp_path / "ensemble.nc", engine="netcdf4") as store:
        assert store.attrs["inputs"] == "the key"
        assert list(store["motion"].values) == list(result.scalars.index)
        middle = store["psa_percentile"].sel(percentile=store["percentile"] == 50.0).values[0]
        np.testing.assert_allclose(middle, np.median(result.spectra["psa"], axis=0), rtol=1e-12)
        assert {s.name for s in scalars_of(store)} == {"ensemble.members", "ensemble.failed"}
        found = store["value_percentile"].sel(scalar="motion.pgd").values
        assert np.all(np.diff(found) >= 0.0) and len(set(found)) == 5
    shutil.rmtree(tmp_path / "members")


def test_a_damaged_member_is_computed_again(run, tmp_path, caplog):
    """Also one whose damage is within an array, which shows when that is read."""
    first = run()
    path = sorted((tmp_path / "members").iterdir())[0]
    content = path.read_bytes()
    middle = len(content) // 2
    path.write_bytes(content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :])
    again = run()
    assert f"{path} is damaged" in caplog.text and path.read_bytes() == content
    np.testing.assert_array_equal(again.spectra["psa"], first.spectra["psa"])


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(1)
    f = np.geomspace(0.5, 50.0, 20)
    percentile = np.array([5.0, 16.0, 50.0, 84.0, 95.0])
    psa = 1.0 + rng.random((40, 1, 3, 1, 20))
    bands = np.percentile(psa, percentile, axis=0)
    values = {
        "motion": [f"seed_{k}" for k in range(40)],
        "scalar": ["a.b", "c.d", "e"],
        "unit": ["m", "s", "-"],
        "value": np.column_stack([np.arange(40.0), rng.random(40), np.full(40, np.nan)]),
        "percentile": percentile,
        "value_percentile": percentiles(
            np.column_stack([np.arange(40.0), rng.random(40), np.full(40, np.nan)])
        ),
        "station_building": ["B1", "B1", "B2"],
        "station_floor": [1, 2, 1],
        "direction": ["y"],
        "frequency": f,
        "damping": [0.05],
        "psa_percentile": bands,
        "psa_free_percentile": 0.5 * bands,
    }
    attributes = {"shown_direction": "y", "studied_building": "B1"}
    store = dataset(OUTPUTS, values, attributes=attributes)
    write_netcdf(tmp_path / "ensemble.nc", store)
    return tmp_path


def test_files(folder):
    published = {"a.b": SimpleNamespace(value=20.0, kind="result")}
    some = Figures(
        ENSEMBLE.figures.data,
        tuple(one for one in ENSEMBLE.figures.declared if not one.each),
    )
    drawn = draw_all(some, folder, published=published)
    assert [path.name for path in drawn] == ["ensemble_published.svg", "ensemble_spectra.svg"]
    assert all(path.stat().st_size > 5000 for path in drawn)
    assert [path.name for path in draw_all(some, folder)] == ["ensemble_spectra.svg"]
    (table,) = ensemble_table(folder, {"a.b": 20.0})
    assert table.name == "ensemble.csv"
    with table.open(newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows[1][0] == "a.b" and float(rows[1][5]) == pytest.approx(19.5)
    assert rows[0][2] == "motions" and rows[1][2] == "40"


def test_inside_or_not(folder):
    with open_store(folder / "ensemble.nc") as store:
        table = bands(store, {"a.b": 20.0, "c.d": 5.0})
    assert [(row[0], row[-1]) for row in table.rows] == [("a.b", "yes"), ("c.d", "no")]


@pytest.mark.parametrize("failed", [0, 2])
def test_checks(folder, failed):
    members = xr.load_dataset(folder / "ensemble.nc", engine="netcdf4")
    names = np.array([f"seed_{k}" for k in range(failed)], dtype=object)
    write_netcdf(folder / "ensemble.nc", members.assign_coords(failed=("failed", names)))
    motions, published = ensemble_checks(folder, {"a.b": 20.0, "c.d": 5.0})
    assert (motions.id, motions.place) == ("ensemble.failed_motions", f"of {40 + failed}")
    assert (motions.value, motions.passed) == (failed, failed == 0)
    assert (published.id, published.passed) == ("ensemble.published_inside", None)
    assert (published.value, published.place) == (1.0, "of 2")
    assert len(ensemble_checks(folder, {})) == 1


@pytest.mark.parametrize(
    ("name", "values", "check", "count"),
    [
        ("swing_at_end", np.full(40, 0.5), "swing_at_end", 0),
        ("swing_at_end", np.full(40, 0.51), "swing_at_end", 40),
        # Of their closest approach: below zero they overlap.
        ("facing_distance_min", np.arange(40.0), "facing_overlap", 0),
        ("facing_distance_min", np.arange(40.0) - 2.5, "facing_overlap", 3),
    ],
)
def test_what_no_member_may_do(folder, name, values, check, count):
    members = xr.load_dataset(folder / "ensemble.nc", engine="netcdf4")
    members["scalar"] = np.array([f"pounding.{name}", "c.d", "e"], dtype=object)
    members["value"][:, 0] = values
    write_netcdf(folder / "ensemble.nc", members)
    (found,) = (c for c in ensemble_checks(folder, {}) if c.id == f"ensemble.{check}")
    assert (found.value, found.passed, found.place) == (count, count == 0, "of 40")
