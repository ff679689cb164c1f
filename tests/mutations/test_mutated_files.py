"""Mutated inputs of every kind: refused in plain words that name the file, or still good.

A seeded generator, so that a failure can be made again from its number.
"""

import pickle
import random
import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from impactfem import cli, study
from impactfem.building.mesh_checks import check_mesh
from impactfem.building.read_mesh import assemble
from impactfem.report.run_files import RunFiles
from impactfem.stages.manifest import is_finished, read_manifest
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.files import read_archive, write_archive

from .mutation import flipped, mutated, outcome

CASES, MESHES, STORES, REPORTS, ARCHIVES, MANIFESTS = 300, 30, 1, 100, 60, 50


def cases_of(folder):
    """Each file of a folder, as a case of it names it, with the cases that are read with it."""
    texts = {path: path.read_text(encoding="utf-8") for path in folder.glob("*.toml")}
    # Neither the reference of a report nor a fit.
    no_case = re.compile(r"^(\[\[(items|targets)\]\]|\[items\.|targets = \[)", re.MULTILINE)
    texts = {path: text for path, text in texts.items() if not no_case.search(text)}
    for _ in range(2):  # an extended case names files for the one that extends it
        for path, text in texts.items():
            below = re.search(r'^extends = "(.*)"', text, re.MULTILINE)
            if below is not None:
                texts[path] = f"{text}\n{texts[folder / below[1]]}"
    found = {path: [path] for path in texts if path.suffix == ".toml"}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix != ".msh":
            named = path.parent.name if path.parent != folder else path.name
            users = [case for case, text in texts.items() if f'"{named}"' in text]
            found[path] = sorted({*found.get(path, []), *users})
    return {path: cases for path, cases in found.items() if cases}


def damage(rng, path, content):
    """Put a mutation in the place of a file; now and then a folder, or nothing."""
    path.unlink()
    kind = rng.random()
    if kind < 0.02:
        path.mkdir()
    elif kind > 0.03:
        path.write_bytes(mutated(rng, content))


def mend(path, content):
    if path.is_dir():
        path.rmdir()
    path.write_bytes(content)


def test_cases_and_all_that_they_name(good, tmp_path):
    root = tmp_path / "mutated"
    shutil.copytree(good, root)
    users = {}
    for folder in sorted(root.iterdir()):
        users |= cases_of(folder)
    assert len(users) > 45
    for case in {case for cases in users.values() for case in cases}:
        assert outcome(lambda case=case: study.check(case), case.parent, InputError) == "good", case
    count = {"good": 0, "refused": 0}
    for seed in range(CASES):
        rng = random.Random(seed)
        path = rng.choice(list(users))
        case = rng.choice(users[path])
        content = path.read_bytes()
        damage(rng, path, content)
        try:
            count[outcome(lambda case=case: study.check(case), case.parent, InputError)] += 1
        except AssertionError as error:
            raise AssertionError(f"seed {seed}, {path.name}: {error}") from error
        mend(path, content)
    assert count["refused"] > CASES // 2 and count["good"] > CASES // 20, count


def test_meshes(good, tmp_path):
    frame = (good / "frame" / "frame.msh").read_bytes()
    for seed in range(MESHES):
        rng = random.Random(seed)
        content = flipped(rng, frame) if rng.random() < 0.2 else mutated(rng, frame)
        (tmp_path / f"{seed}.msh").write_bytes(content)
    script = Path(__file__).with_name("raw_meshes.py")
    subprocess.run([sys.executable, str(script), str(tmp_path)], check=True, capture_output=True)
    count = {"good": 0, "refused": 0}
    for path in tmp_path.glob("*.msh"):
        result = path.with_suffix(".pickle")

        def read(path=path, result=result):
            if not result.exists():  # as `read_in_own_process` tells it
                raise InputError([Fault(path, "", None, "gmsh crashed")])
            raw = pickle.loads(result.read_bytes())
            if isinstance(raw, InputError):
                raise raw
            check_mesh(assemble(raw, path), path)

        count[outcome(read, tmp_path, InputError)] += 1
    assert count["refused"] > MESHES // 2, count


def test_given_stores(good, tmp_path, finished):
    """HDF5 crashes on some: they are read in a process of their own."""
    folder = tmp_path / "frame"
    shutil.copytree(good / "frame", folder)
    case = folder / "device.toml"
    case.write_text(case.read_text().replace("forces.csv", "forces.nc"))
    content = (finished.folder / "forces.nc").read_bytes()
    for seed in range(STORES):
        rng = random.Random(seed)
        # Beyond the signature, which is what makes it a file of HDF5.
        (folder / "forces.nc").write_bytes(content[:64] + flipped(rng, content[64:4000]))
        assert outcome(lambda: study.check(case), folder, InputError) == "refused", seed


def test_the_folder_of_a_run(finished, tmp_path):
    run = tmp_path / "run"
    shutil.copytree(finished.folder, run)
    files = [path for path in sorted(run.rglob("*")) if path.is_file()]
    json_files = [path for path in files if path.suffix == ".json"]
    assert outcome(lambda: RunFiles(run), run, ImpactfemError) == "good"
    count = {"good": 0, "refused": 0}
    for seed in range(REPORTS):
        rng = random.Random(seed)
        path = rng.choice(json_files if rng.random() < 0.6 else files)
        content = path.read_bytes()
        damage(rng, path, content)
        count[outcome(lambda: RunFiles(run), run, ImpactfemError)] += 1
        mend(path, content)
    assert count["refused"] > REPORTS // 2, count


def test_what_may_be_reused(finished, tmp_path, caplog):
    """A damaged manifest or archive is computed again, and a good one is read."""
    run = tmp_path / "run"
    shutil.copytree(finished.folder, run)
    manifest = run / "pounding.stage.json"
    content = manifest.read_bytes()
    key = re.search(r'"inputs": "(\w+)"', content.decode())[1]

    def reuse():
        if is_finished(run, "pounding", key):
            seconds = read_manifest(run, "pounding").seconds
            assert all(isinstance(time, float) for time in seconds.values())

    for seed in range(MANIFESTS):
        damage(random.Random(seed), manifest, content)
        assert outcome(reuse, run, ImpactfemError) == "good", seed
        mend(manifest, content)
    assert is_finished(run, "pounding", key)
    archive = tmp_path / "basis.npz"
    write_archive(archive, "key", {"q": np.arange(30.0), "names": np.array(["a", "b"])})
    content = archive.read_bytes()
    for seed in range(ARCHIVES):
        archive.write_bytes(flipped(random.Random(seed), content))
        assert outcome(lambda: read_archive(archive, "key"), tmp_path, ImpactfemError) == "good"
    assert "is damaged" in caplog.text


def _warn():
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)


def _refuse(file, words):
    raise InputError([Fault(file, "key", None, words)])


@pytest.mark.parametrize(
    ("planted", "message"),
    [
        (lambda folder: {}["gap"], "a raw KeyError"),
        (lambda folder: _warn(), "a raw RuntimeWarning"),
        (lambda folder: (folder / "out").touch(), "something was written"),
        (lambda folder: _refuse("elsewhere.toml", "a length"), "elsewhere"),
        (lambda folder: _refuse(folder / "a.toml", "x" * 1000), "xxx"),
        (lambda folder: _refuse(folder / "a.toml", "Traceback (most recent"), "Traceback"),
    ],
)
def test_a_planted_fault_is_found(tmp_path, planted, message):
    with pytest.raises(AssertionError, match=message):
        outcome(lambda: planted(tmp_path), tmp_path, InputError)


def call(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["impactfem", *map(str, words)])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    return caught.value.code or 0, capsys.readouterr().err


def test_the_exit_code_of_a_mutated_case(good, tmp_path, monkeypatch, capsys):
    shutil.copytree(good / "records", tmp_path / "records")
    case = tmp_path / "records" / "csv.toml"
    assert call(monkeypatch, capsys, "check", case)[0] == 0
    (tmp_path / "records" / "record.csv").write_bytes(b"\xff\xfe\x00")
    code, shown = call(monkeypatch, capsys, "check", case)
    *errors, verdict = shown.splitlines()
    assert code == 2 and errors and all(line.startswith("error: ") for line in errors)
    assert "invalid" in verdict
    assert str(tmp_path) in shown


def test_a_refused_case_leaves_no_folder(tmp_path, monkeypatch, capsys):
    case = tmp_path / "bad.toml"
    case.write_text("title = 3\n", encoding="utf-8")
    code, shown = call(monkeypatch, capsys, "run", case, "--out", tmp_path / "out")
    assert code == 2 and not (tmp_path / "out").exists()
    assert "title" in shown
