import csv
import gc
import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem import __version__, study
from impactfem.run import loop
from impactfem.stages.drawing import Figures
from impactfem.stages.manifest import file_digest
from impactfem.stages.pounding import stage as sticks
from impactfem.stages.stage import StageOf
from impactfem.system.errors import ImpactfemError, InputError
from no_pictures import one_picture

FILES = {"run.log", "summary.json", "provenance.json", "pounding.nc", "motion.nc", "forces.nc"} | {
    "forces.csv",
    "tables",
    "figures",
}
SI = {"m", "s", "kg", "N", "Pa", "J", "Hz", "-", "m/s", "m/s2", "N s", "m/N", "N/m", "rad"}


def tree(folder):
    return {
        path.relative_to(folder): path.is_dir() or path.read_bytes() for path in folder.rglob("*")
    }


def stamp(folder):
    return (folder / "pounding.nc").stat().st_mtime_ns


def load(path):
    return json.loads(path.read_text(encoding="utf-8"))


def scalars(run):
    return {scalar.name: scalar.value for scalar in run.scalars}


class TestFinished:
    def test_files(self, finished):
        assert {path.name for path in finished.folder.iterdir()} >= FILES
        assert not list(finished.folder.rglob("*.part"))
        assert finished.run.reused == []
        steps = ["motions", "sticks", "pounding", "spectra", "stores", "tables and figures"]
        # Behind the name of the stage.
        assert [name.rsplit(": ")[-1] for name in finished.run.times] == steps

    def test_summary(self, finished):
        entries = load(finished.folder / "summary.json")
        for entry in entries:
            assert list(entry) == ["name", "value", "unit", "paper", "relation", "kind", "note"]
            assert (entry["kind"] is None) == (entry["paper"] is None)
            assert entry["value"] is None or isinstance(entry["value"], float)
            assert isinstance(entry["note"], str)
        assert {entry["unit"] for entry in entries} <= SI
        values = {entry["name"]: entry["value"] for entry in entries}
        assert len(values) == len(entries), "a name twice"
        listed = {one.name for one in finished.run.scalars if not one.detail}
        assert values == {name: x for name, x in scalars(finished.run).items() if name in listed}
        names = [f"sticks.{b}.{q}.{k}" for b in ("west", "east") for k in (1, 2, 3, 4) for q in (
            "frequency", "effective_mass")]  # fmt: skip
        for quantity in ("peak_force",):
            names.append(f"pounding.{quantity}.floor_3")
        for quantity in ("peak", "pfa"):
            names.append(f"frs.floor_3.{quantity}")
        names += ["motion.pga", "motion.sa_max", "motion.sa_max_frequency"]
        names += ["pounding.main_impact_time", "pounding.main_impact_duration"]
        names += ["pounding.steps_per_impact_min", "pounding.energy_residual"]
        names += ["pounding.required_separation"]
        assert not [name for name in names if values.get(name) is None]

    def test_published_values_stand_beside_ours_in_si(self, finished):
        papers = {e["name"]: e["paper"] for e in load(finished.folder / "summary.json")}
        given = {name: paper for name, paper in papers.items() if paper is not None}
        assert given == pytest.approx({"motion.pga": 3.0, "frs.floor_3.pfa": 40.0})

    def test_values_are_those_of_the_stores(self, finished):
        values = scalars(finished.run)
        with (
            xr.open_dataset(finished.folder / "pounding.nc", engine="netcdf4") as sticks,
            xr.open_dataset(finished.folder / "forces.nc", engine="netcdf4") as forces,
            xr.open_dataset(finished.folder / "motion.nc", engine="netcdf4") as motion,
        ):
            force = forces["force"].values
            assert values["pounding.peak_force.floor_3"] == force[:, 2].max() > 1e6
            assert values["pounding.impacts"] == sticks.sizes["impact"] > 1
            top = sticks.isel(station=2).sel(direction="y")
            assert values["frs.floor_3.pfa"] == top["pfa"]
            assert values["frs.floor_3.peak"] == top["psa"].max()
            acceleration = sticks["acceleration"].isel(station=2).sel(component="y")
            assert values["frs.floor_3.pfa"] == pytest.approx(float(abs(acceleration).max()), 0.05)
            assert values["pounding.penetration.floor_3"] == -sticks["gap"].values[:, 2].min()
            pga = abs(motion["acceleration"]).max()
            assert values["motion.pga"] == pga == pytest.approx(3.0)
        with (finished.folder / "forces.csv").open() as stream:
            rows = list(csv.reader(stream))
        pairs = [f"west.floor_{k}-east.floor_{k} [N]" for k in (1, 2, 3)]
        assert rows[0] == ["time [s]", *pairs]
        table = np.array(rows[1:], dtype=float)
        assert np.allclose(table[:, 1:], force, rtol=1e-8)
        # 3 s in steps of 0.5 ms, both ends included.
        assert table[:, 0] == pytest.approx(5e-4 * np.arange(6001))

    def test_provenance(self, finished):
        found = load(finished.folder / "provenance.json")
        case = study.check(finished.case)
        assert found["impactfem"] == __version__
        assert found["case"] == "small.toml" and found["case_hash"] == case.content_hash()
        names = ["small.toml", "small_floors.csv", "small_published.csv"]
        assert sorted(found["input_files"]) == names
        for name, digest in found["input_files"].items():
            assert digest == file_digest(finished.case.parent / name)
        (sticks,) = (stage for stage in study.STAGES if stage.name == "pounding")
        assert found["inputs"] == {"pounding": sticks.key(case)}
        assert found["seeds"] == {"motions[0].seed": 1}
        assert found["ranks"] == 1 and found["reused"] == []
        assert found["packages"]["numpy"] == np.__version__
        assert "unknown" not in found["packages"].values()
        assert set(found["seconds"]) == set(finished.run.times)
        assert found["started"].endswith("+00:00")
        with xr.open_dataset(finished.folder / "forces.nc", engine="netcdf4") as forces:
            assert forces.attrs["case_hash"] == case.content_hash()

    def test_nothing_tells_of_the_machine(self, finished):
        provenance = load(finished.folder / "provenance.json")
        del provenance["command"]  # as it was typed
        texts = [json.dumps(provenance), (finished.folder / "summary.json").read_text()]
        for name in ("pounding.nc", "motion.nc", "forces.nc"):
            with xr.open_dataset(finished.folder / name, engine="netcdf4") as store:
                texts.append(str(store.attrs) + str([v.attrs for v in store.variables.values()]))
        for path in (*finished.folder.glob("tables/*.csv"), finished.folder / "forces.csv"):
            texts.append(path.read_text(encoding="utf-8")[:10_000])
        for word in (str(finished.folder.parent), str(Path.home()) + "/", os.uname().nodename):
            assert not [text for text in texts if word in text], word


class TestReuse:
    def test_a_finished_stage_is_reused(self, copied, tmp_path, finished):
        before = tree(tmp_path / "run")
        when = stamp(tmp_path / "run")
        again = loop.run(copied, out=tmp_path / "run")
        assert again.reused == ["pounding"] and again.times == finished.run.times
        assert again.scalars == finished.run.scalars
        assert stamp(tmp_path / "run") == when
        after = tree(tmp_path / "run")
        changed = {str(path) for path in before if before[path] != after.get(path)}
        assert changed <= {"run.log", "provenance.json", "report.html"}
        assert before.keys() == after.keys()
        assert load(tmp_path / "run" / "provenance.json")["reused"] == ["pounding"]

    @pytest.mark.parametrize("changed", [True, False])
    def test_a_report_of_other_results_does_not_stay(
        self, copied, tmp_path, edited, no_figures, changed
    ):
        if changed:
            edited(copied, ("restitution = 0.65", "restitution = 0.6"))
        loop.run(copied, out=tmp_path / "run", stage="pounding")
        assert (tmp_path / "run" / "report.html").is_file() is not changed

    def test_an_edited_figure_is_drawn_again_and_nothing_is_computed(
        self, copied, tmp_path, finished, monkeypatch
    ):
        one_picture(monkeypatch, "elevation")
        store = tmp_path / "run" / "pounding.nc"
        when = stamp(tmp_path / "run")
        figure = tmp_path / "run" / "figures" / "elevation.svg"
        before = figure.stat().st_mtime_ns, store.stat().st_mtime_ns
        key = StageOf.drawing_key
        monkeypatch.setattr(StageOf, "drawing_key", lambda stage, case: key(stage, case) + "edited")
        again = loop.run(copied, out=tmp_path / "run")
        assert again.reused == ["pounding"] and stamp(tmp_path / "run") == when
        assert figure.stat().st_mtime_ns > before[0] and store.stat().st_mtime_ns == before[1]
        # Drawn once, and its time is that of the drawing.
        drawn = figure.stat().st_mtime_ns
        assert loop.run(copied, out=tmp_path / "run").times == again.times
        assert figure.stat().st_mtime_ns == drawn

    def test_the_case_may_move(self, copied, tmp_path):
        (tmp_path / "other").mkdir()
        for file in tmp_path.glob("small*"):
            shutil.move(file, tmp_path / "other")
        again = loop.run(tmp_path / "other" / copied.name, out=tmp_path / "run")
        assert again.reused == ["pounding"]

    @pytest.mark.parametrize(
        ("file", "change", "reused"),
        [
            ("small.toml", ('title = "Deux', 'title = "Zwei'), True),
            ("small.toml", ("# Materials of", "# The materials of"), True),
            ("small_published.csv", ("motion.pga,300", "motion.pga,290"), True),
            ("small.toml", ('gap = "2 cm"', 'gap = "21 mm"'), False),
            ("small.toml", ("seed = 1 ", "seed = 2 "), False),
            ("small_floors.csv", ("3,192,", "3,191,"), False),
        ],
        ids=["title", "comment", "published", "gap", "seed", "floor table"],
    )
    def test_a_changed_input_is_computed_and_words_are_not(
        self, copied, tmp_path, edited, no_figures, finished, file, change, reused
    ):
        run = tmp_path / "run"
        when = stamp(run)
        edited(tmp_path / file, change)
        again = loop.run(copied, out=run, stage="pounding")
        assert again.reused == (["pounding"] if reused else [])
        assert (stamp(run) == when) == (again.scalars == finished.run.scalars) == reused
        assert load(run / "provenance.json")["case_hash"] == study.check(copied).content_hash()
        papers = {entry["name"]: entry["paper"] for entry in load(run / "summary.json")}
        assert papers["motion.pga"] == pytest.approx(2.9 if "published" in file else 3.0)

    def test_a_record_counts_by_its_content(
        self, with_record, sine, tmp_path, no_figures, monkeypatch
    ):
        case, out = with_record(tmp_path, sine), tmp_path / "run"
        assert loop.run(case, out=out, stage="pounding").reused == []
        with monkeypatch.context() as patch:
            patch.chdir(tmp_path)
            assert loop.run(Path(case.name), out=out, stage="pounding").reused == ["pounding"]
        (tmp_path / "record.csv").write_text(sine.replace("3.0", "3.1", 1) + "2.01,0\n")
        assert loop.run(case, out=out, stage="pounding").reused == []

    def test_fresh(self, copied, tmp_path, no_figures, finished):
        when = stamp(tmp_path / "run")
        again = loop.run(copied, out=tmp_path / "run", stage="pounding", fresh=True)
        assert again.reused == [] and stamp(tmp_path / "run") != when
        # The same case gives the same numbers, to the last digit.
        assert again.scalars == finished.run.scalars

    def test_a_part_of_the_stages_keeps_what_is_finished(
        self, copied, tmp_path, edited, no_figures
    ):
        """The record has what the folder has for the case, and no more."""
        run = tmp_path / "run"
        copied.write_text(f"{copied.read_text('utf-8')}\n[ensemble]\nmotions = 2\n", "utf-8")
        both = ["pounding", "ensemble"]

        def record():
            stages = load(run / "checks.json"), load(run / "summary.json")
            names = {one["stage"] for one in stages[0]}, [one["name"] for one in stages[1]]
            return list(load(run / "provenance.json")["inputs"]), *names

        assert loop.run(copied, out=run, stage="ensemble").reused == ["pounding"]
        whole = record()
        assert whole[0] == both
        assert loop.run(copied, out=run, stage="pounding").reused == ["pounding"]
        assert record() == whole
        # What is computed again gives the same: the rest stands.
        assert loop.run(copied, out=run, stage="pounding", fresh=True).reused == []
        assert record() == whole
        # The files of a stage that is not asked for are not whole, or of another case.
        store = run / "ensemble.nc"
        content = store.read_bytes()
        store.write_bytes(b"")
        assert loop.run(copied, out=run, stage="pounding").reused == ["pounding"]
        part = record()
        assert part[0] == ["pounding"] and part[1] < whole[1] and set(part[2]) < set(whole[2])
        store.write_bytes(content)
        assert loop.run(copied, out=run, stage="pounding").reused == ["pounding"]
        edited(copied, ('gap = "2 cm"', 'gap = "21 mm"'))
        assert loop.run(copied, out=run, stage="pounding").reused == []
        assert record() == part

    @pytest.mark.parametrize(
        ("name", "damage"),
        [
            ("pounding.nc", "overwritten"),
            ("forces.nc", "truncated"),
            ("forces.csv", "empty"),
            ("motion.nc", "missing"),
        ],
    )
    def test_a_damaged_file_is_computed_again(
        self, copied, tmp_path, no_figures, caplog, name, damage, finished
    ):
        path = tmp_path / "run" / name
        content = path.read_bytes()
        damaged = {
            "truncated": content[: len(content) // 2],
            # The header stays: the file opens, what is in it does not.
            "overwritten": content[:96] + bytes(4000) + content[4096:],
            "empty": b"",
            "missing": None,
        }[damage]
        path.unlink() if damaged is None else path.write_bytes(damaged)
        failure = None
        try:
            again = loop.run(copied, out=tmp_path / "run", stage="pounding")
        except Exception as error:
            failure = repr(error)
        gc.collect()  # the destructor, here and not in another test
        assert failure is None
        assert again.reused == [] and again.scalars == finished.run.scalars
        if path.suffix == ".nc":
            assert f"{path} is missing or was changed; not reused" in caplog.text
        assert path.stat().st_size == pytest.approx(len(content), rel=0.01)

    def test_missing_figures_are_drawn_again(self, copied, tmp_path, finished):
        shutil.rmtree(tmp_path / "run" / "tables")
        next((tmp_path / "run" / "figures").glob("*.svg")).unlink()
        assert loop.run(copied, out=tmp_path / "run").reused == ["pounding"]
        assert set(tree(tmp_path / "run")) == set(tree(finished.folder))

    def test_a_run_that_failed_at_its_figures_gets_them(
        self, new_case, tmp_path, monkeypatch, finished
    ):
        """A full disk or an interrupt after the stores are written."""
        case = new_case(tmp_path)

        def fail(*_, **__):
            raise ImpactfemError("no space")

        one_picture(monkeypatch, "elevation")
        with monkeypatch.context() as patch:
            patch.setattr(Figures, "draw", fail)
            with pytest.raises(ImpactfemError, match="no space"):
                loop.run(case, out=tmp_path / "run")
        assert not (tmp_path / "run" / "summary.json").exists()
        loop.run(case, out=tmp_path / "run", resume=True)
        found = set(tree(tmp_path / "run"))
        assert Path("figures/elevation.svg") in found
        others = set(tree(finished.folder)) ^ found
        assert others and {path.parent.name for path in others} == {"figures"}


class TestFolder:
    def test_the_default_is_named_after_the_case(self, copied, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "runs").mkdir()
        (tmp_path / "run").rename(tmp_path / "runs" / "small")
        again = loop.run(Path(copied.name))
        assert again.folder == Path("runs/small") and again.reused == ["pounding"]

    def test_resuming_what_is_not_there(self, copied, tmp_path):
        before = tree(tmp_path)
        for name in ("nowhere", "empty"):
            with pytest.raises(InputError, match=r"--resume = .*expected a folder"):
                loop.run(copied, out=tmp_path / name, resume=True)
            assert tree(tmp_path) == before
            (tmp_path / "empty").mkdir(exist_ok=True)
            before = tree(tmp_path)

    @pytest.mark.parametrize(
        ("place", "message"),
        [
            ("small.toml", "small.toml' is a file"),
            ("small.toml/run", "small.toml' is a file"),
            ("x" * 300, "File name too long"),
        ],
        ids=["a file", "in a file", "long name"],
    )
    def test_a_folder_that_cannot_be_used(self, copied, tmp_path, place, message):
        before = tree(tmp_path)
        with pytest.raises(InputError, match=message) as error:
            loop.run(copied, out=tmp_path / place, fresh=True)
        assert "--out" in str(error.value)
        assert tree(tmp_path) == before

    def test_a_folder_without_permission(self, copied, tmp_path, monkeypatch):
        monkeypatch.setattr(os, "access", lambda *_: False)
        with pytest.raises(InputError, match="written: Permission denied"):
            loop.run(copied, out=tmp_path / "run")

    def test_an_interrupt_leaves_no_half_file(
        self, copied, tmp_path, monkeypatch, edited, no_figures
    ):
        def interrupt(*_):
            raise KeyboardInterrupt

        edited(copied, ('gap = "2 cm"', 'gap = "21 mm"'))
        before = (tmp_path / "run" / "pounding.nc").read_bytes()
        names = set(tree(tmp_path / "run"))
        with monkeypatch.context() as patch:
            patch.setattr(sticks, "write_sticks", interrupt)
            with pytest.raises(KeyboardInterrupt):
                loop.run(copied, out=tmp_path / "run", stage="pounding")
        assert (tmp_path / "run" / "pounding.nc").read_bytes() == before
        assert set(tree(tmp_path / "run")) == names
        again = loop.run(copied, out=tmp_path / "run", stage="pounding", resume=True)
        assert again.reused == []


class TestInput:
    def test_a_device_that_cannot_be_built(self, tmp_path):
        paper = (Path(__file__).parents[1] / "geometry" / "npp_pair.toml").resolve()
        device = """
            [[devices]]
            name = "cabinet"
            point = ["5 m", "5 m", "30.3 m"]
            radius = "0.5 m"
            modes = "modes.csv"
            mass = "300 kg"
            mass_height = "1 m"
            inertia = ["9 kg m2", "9 kg m2", "9 kg m2"]
            damping = { ratio = "2 %", frequencies = ["5 Hz", "30 Hz"] }
        """
        case = tmp_path / "case.toml"
        case.write_text(f'extends = "{paper}"\ntitle = "A cabinet"\n{device}', encoding="utf-8")
        modes = tmp_path / "modes.csv"
        modes.write_text("frequency [Hz],direction,effective_mass [kg],height [m]\n8,y,280,1\n")
        assert study.check(case).devices[0].name == "cabinet"
        modes.write_text("frequency [Hz],direction,effective_mass [kg],height [m]\n8,y,301,1\n")
        with pytest.raises(InputError, match=r"devices\[0\] = 'cabinet'.*301 kg"):
            study.check(case)

    @pytest.mark.parametrize(
        ("record", "message"),
        [
            ("time [s],acceleration [m/s2]\n0,0\n0.02,1\n0.01,1\n", "line 4.*ascend"),
            (bytes(range(256)) * 8, "not a text file"),
        ],
        ids=["unsorted", "junk"],
    )
    def test_a_broken_record(self, with_record, tmp_path, record, message):
        case = with_record(tmp_path, record)
        with pytest.raises(InputError, match=message) as error:
            loop.run(case, out=tmp_path / "deep" / "run")
        assert "record.csv" in str(error.value) and len(error.value.faults) == 1
        assert not (tmp_path / "deep").exists()
