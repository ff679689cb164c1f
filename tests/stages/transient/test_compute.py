"""The stage `transient` of a study on the shipped frame, with forces of another program."""

import logging
import re
import shutil

import numpy as np
import pytest
import xarray as xr

from impactfem import study
from impactfem.run import loop
from impactfem.stages.transient.checks import samples_check
from impactfem.system.errors import InputError, SolutionError

from .conftest import no_pictures, steps_of, write_forces

pytestmark = pytest.mark.slow
DAMPING_CASES = """
[[damping_cases]]
name = "light"
ratio = "0.5 %"
frequencies = ["1 Hz", "20 Hz"]
[[damping_cases]]
name = "heavy"
ratio = "9 %"
frequencies = ["1 Hz", "20 Hz"]
"""
AFTER = ("spectra", "maps", "stores")


def add_probe(case, height):
    probe = f'\n[[transient.probes]]\nname = "low"\npoint = ["0 m", "0 m", "{height}"]\n'
    case.write_text(case.read_text() + probe)


@pytest.fixture
def case(begun, tmp_path, monkeypatch):
    """A copy of the case before the stage."""
    no_pictures(monkeypatch)
    shutil.copytree(begun, tmp_path, dirs_exist_ok=True)
    return tmp_path / "frame.toml"


@pytest.fixture
def run(caplog):
    """Run the stage of a case, with what the log says of it."""

    def running(case):
        caplog.clear()
        with caplog.at_level(logging.DEBUG, "impactfem"):
            done = loop.run(case, out=case.parent / "run", stage="transient", draw=False)
        messages = [record.getMessage() for record in caplog.records]
        words = ("transient", "reduce", "damaged", "another case")
        return done, [text for text in messages if any(word in text for word in words)]

    return running


def loaded(run, name="transient.nc"):
    return xr.load_dataset(run.folder / name, engine="netcdf4")


def test_reduced(reduced):
    folder, done = reduced
    assert done.reused == ["building", "pounding"]
    assert steps_of(done) == {"inputs", *AFTER} and "reduce: basis" in done.times
    found = loaded(done)
    assert found.attrs["solver"] == "reduced"
    assert float(found.basis_vectors) > 20
    assert found.attrs["main_impact"] == pytest.approx([0.7, 0.72], abs=1.1e-3)
    assert float(found.impulse_error) < 1e-12
    # Floor 1 is never hit, and is no load.
    assert found.edge.values.tolist() == ["floor 2"]
    impulses = found.edge_force.sum("time") * 1e-3
    assert impulses.values == pytest.approx([2 / np.pi * 0.02 * 4e5 * 1.3], rel=1e-3)
    assert found.transfer_load.values.tolist() == ["floor 2"]
    assert 0.0 < float(found.band_max) < 0.1 and "energy_residual" not in found
    assert not (done.folder / "transient_checkpoints").exists()
    log = (folder / "run" / "run.log").read_text()
    assert "reduce: basis of" in log and "of the impulses" in log
    # A step that is too coarse is reported before the time is spent, and once.
    samples = f"transient: {samples_check(1e-3, 50.0).text}"
    assert log.index(samples) < log.index("reduce: basis of") and log.count(samples) == 1
    maps = loaded(done, "transient_maps.nc")
    assert maps.snapshot.values == pytest.approx([0.7, 0.71, 0.72], abs=1.1e-3)
    centre = found.sel(probe="centre_2")
    node = int(np.argmin(np.abs(maps.node_position - centre.probe_position).sum("xyz").values))
    assert maps.pfa[node].values == pytest.approx(centre.pfa.values, rel=1e-6)


def test_full_and_both(run, again, reduced, edited):
    """The same answer, one after the other in the same folder: nothing of the one before stays."""
    known = loaded(reduced[1])
    edited(again, ('solver = "reduced"', 'solver = "full"'))
    full, told = run(again)
    assert full.reused == ["building", "pounding"]  # the reduced building is not asked for
    assert steps_of(full) == {"inputs", "matrices", "time steps", *AFTER} - {"maps"}
    assert "transient: the full model records its probes only; no maps and no waves" in told
    found = loaded(full)
    assert float(found.energy_residual) < 1e-9 and not found.psa_band.any()
    assert not {"band_max", "basis_vectors", "transfer_re"} & set(found)
    assert not (full.folder / "transient_maps.nc").exists()
    assert not (full.folder / "transient_checkpoints").exists()
    # Both at 1 ms: the step counts more than the basis.
    assert known.psa.values == pytest.approx(found.psa.values, rel=0.05)

    edited(again, ('solver = "full"', 'solver = "both"'))
    both, told = run(again)
    assert "time steps" in steps_of(both) and "reduce" in both.reused  # kept since before
    found = loaded(both)
    assert 0.0 < float(found.reduced_against_full) < 0.005 and float(found.energy_residual) < 1e-9
    np.testing.assert_array_equal(loaded(both).psa, known.psa)
    assert (both.folder / "transient_maps.nc").is_file()
    assert any("spectra, reduced" in line for line in told)


def test_second_run_reuses_the_stage(run, again, reduced):
    second, told = run(again)
    assert second.reused == ["building", "reduce", "pounding", "transient"]
    assert second.scalars == reduced[1].scalars
    assert second.times == reduced[1].times
    assert not any("reduce: basis of" in line for line in told)
    assert any("time steps" in line for line in told)


def test_band_by_larger_and_by_smaller_bases(run, again, reduced, edited):
    """One basis tells both; one that was made for the latter does not tell the former."""
    known = loaded(reduced[1])
    assert known.psa_band.attrs["note"] == "by larger bases, safety factor 1.75"
    smaller = 'solver = "reduced"\nband = "smaller"'
    edited(again, ('solver = "reduced"', smaller))
    done, told = run(again)
    assert "reduce: the reduced building of reduce.npz is used again" in told
    found = loaded(done)
    assert found.psa_band.attrs["note"] == "by smaller bases, safety factor 2.5"
    np.testing.assert_array_equal(found.psa, known.psa)
    assert float(found.psa_band.median() / known.psa_band.median()) > 2.0

    for name in ("reduce.npz", "reduce.nc", "transient.nc"):
        (done.folder / name).unlink()
    run(again)
    edited(again, (smaller, 'solver = "reduced"'))
    done, told = run(again)
    expected = "is without the larger models that give its error band, and made again"
    assert f"reduce: the reduced building of reduce.npz {expected}" in told
    assert loaded(done).psa_band.values == pytest.approx(known.psa_band.values, rel=1e-3)


@pytest.mark.parametrize("change", ["motion", "forces and step", "damping", "probe"])
def test_basis_serves_other_motions_and_forces(run, again, reduced, edited, change):
    """And more damping, and a further probe on a floor: 3D model and basis are not made again."""
    if change == "motion":
        edited(again, ("seed = 1", "seed = 2"))
    elif change == "forces and step":
        write_forces(again.with_name("forces_of_another.csv"), 5e5)
        edited(again, ('time_step = "1 ms"\nmaximum', 'time_step = "0.8 ms"\nmaximum'))
    elif change == "damping":
        edited(again, ('ratio = "5 %"', 'ratio = "7 %"'))
    else:
        add_probe(again, "6 m")
    done, told = run(again)
    again_whole = ["reduce"] * (change in ("motion", "forces and step"))
    same_sticks = ["pounding"] * (change not in ("motion", "damping"))
    assert done.reused == ["building", *again_whole, *same_sticks]
    assert again_whole or "reduce: the reduced building of reduce.npz is used again" in told
    assert "reduce" in done.reused or "reduce: basis" not in done.times
    known, found = loaded(reduced[1]), loaded(done)
    assert float(found.time[1]) == pytest.approx(0.8e-3 if "step" in change else 1e-3)
    assert ("low" in found.probe.values) == (change == "probe")
    if change != "probe":
        assert np.abs(found.psa / known.psa - 1.0).max() > 0.01


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("load", None),
        ("probe", "without some of the nodes whose motion is wanted"),
        ("maximum_frequency", "with an error of .* for this damping"),
        ("mesh", None),
        ("damaged", None),
    ],
)
def test_basis_that_does_not_serve_is_made_again(run, again, edited, change, why):
    mesh, path = again.with_name("frame.msh"), again.with_name("forces_of_another.csv")
    if change == "load":  # floor 1 was never hit in the forces before
        values = np.loadtxt(path, delimiter=",", skiprows=1)[:, [0, 2, 2]]
        header = path.read_text().splitlines()[0]
        np.savetxt(path, values, delimiter=",", header=header, comments="")
    elif change == "probe":
        add_probe(again, "1 m")
    elif change == "mesh":
        mesh.write_text(mesh.read_text() + "$Comments\nchanged\n$EndComments\n")
    elif change == "damaged":
        basis = again.parent / "run" / "reduce.npz"
        basis.write_bytes(basis.read_bytes()[:-2000])
        write_forces(path, 5e5)
    else:
        edited(again, ('"50 Hz"\nforces', '"500 Hz"\nforces'))
    done, told = run(again)
    assert "reduce: basis" in done.times and not any("used again" in line for line in told)
    assert ("building" in done.reused) == (change != "mesh")
    said = [line for line in told if "and made again" in line or "is damaged" in line]
    if why is None:
        assert len(said) == (change == "damaged")
    else:
        assert re.search(f"reduce.npz is {why}, and made again", said[0])
    found = loaded(done)
    assert ("floor 1" in found.edge.values) == (change == "load")
    assert ("low" in found.probe.values) == (change == "probe")


def test_basis_that_serves_the_damping_cases(run, again, edited):
    """It is made for the lightest one of them, and the response of the case itself stays."""
    # So that the basis of the case itself is good for its own damping alone.
    edited(again, ('"50 Hz"\nforces', '"50 Hz"\ntolerance = "0.002 %"\nforces'))
    own, told = run(again)
    assert "reduce: the reduced building of reduce.npz is used again" in told
    known = loaded(own)
    again.write_text(again.read_text() + DAMPING_CASES)
    same = ["building", "reduce", "pounding", "transient"]
    assert run(again)[0].reused == same  # they are not served yet
    serving = ("\nforces", "\nserve_damping_cases = true\nforces")
    edited(again, serving)
    served, told = run(again)
    assert served.reused == ["building", "pounding"] and "reduce: basis" in served.times
    assert any("with an error" in line and "and made again" in line for line in told)
    found = loaded(served)
    assert float(found.basis_vectors) > float(known.basis_vectors)
    # Over the largest of each record: what hardly moves is not known to a percent.
    change = np.abs(found.psa - known.psa) / known.psa.max("frequency")
    assert change.max() < 0.01
    assert found.psa_band.max() < known.psa_band.max()

    # A heavier one in its place, or none at all: the basis is good for them, too.
    edited(again, ('ratio = "0.5 %"', 'ratio = "0.6 %"'))
    heavier, told = run(again)
    assert heavier.reused == ["building", "pounding"] and "reduce: basis" not in heavier.times
    assert "reduce: the reduced building of reduce.npz is used again" in told
    edited(again, serving[::-1])
    alone, _ = run(again)
    assert "transient" not in alone.reused and "reduce: basis" not in alone.times
    np.testing.assert_array_equal(loaded(alone).psa, found.psa)


def test_forces_of_an_own_run_by_name(run, again, edited):
    """They are those of this case's sticks, although the case is another one by its content."""
    shutil.copy(again.parent / "run" / "forces.nc", again.parent / "own.nc")
    edited(again, ("forces_of_another.csv", "own.nc"))
    _, told = run(again)
    assert not any("own.nc was made" in line for line in told)


def test_unreadable_forces_are_told_by_check(again):
    """Before the stages that come first are computed."""
    study.check(again)
    path = again.with_name("forces_of_another.csv")
    path.write_text(path.read_text().replace("F.floor_2-G.floor_2 [N]", "F.floor_2-G.floor_2 [m]"))
    with pytest.raises(InputError, match=r"F\.floor_2-G\.floor_2"):
        study.check(again)


def test_forces_of_the_sticks_without_an_impact(run, again, edited):
    """The ground motion alone; there is no main impact and no wave, and nothing of them before."""
    edited(again, ('forces = "forces_of_another.csv"\n', ""))
    done, _ = run(again)
    found, maps = loaded(done), loaded(done, "transient_maps.nc")
    assert found.sizes["edge"] == 0 and found.edge_force.shape == (1001, 0)
    assert np.size(found.attrs["main_impact"]) == 0 and maps.sizes["snapshot"] == 0
    assert float(found.impulse_error) == 0.0
    assert found.psa.sel(component="y").min() > 0.0


@pytest.mark.parametrize(
    ("old", "new", "error", "match"),
    [
        ('"50 Hz"\nforces', '"50 Hz"\nlargest_basis = 12\nforces', SolutionError, "15 vectors"),
        ('forces_of_another.csv"', 'nothing.csv"', InputError, "nothing.csv"),
        (
            '"0.2 s"\n',
            '"0.2 s"\n[[transient.probes]]\nname = "out"\npoint = ["9 m", "0 m", "3 m"]\n',
            InputError,
            r"transient\.probes\[0\]\.point.*: the probe out at \(9\.000, 0\.000, 3\.000\) m is "
            r"outside the building: the nearest node, at \(6\.000, 0\.000, 3\.000\) m, is 3 m away",
        ),
        (
            'time_step = "1 ms"\nmax',
            'time_step = "1 ms"\nduration = "3 s"\nmax',
            InputError,
            "expected forces up to 3 s, which is to be computed",
        ),
    ],
)
def test_bad_input(run, case, edited, old, new, error, match):
    edited(case, (old, new))
    with pytest.raises(error, match=match):
        run(case)
    assert not (case.parent / "run" / "transient.nc").exists()


def test_without_impact_equals_a_run_without_contact_forces(run, again, reduced):
    """Spectra and peaks at probes and over the floors; with impact they are different."""
    known, fields = loaded(reduced[1]), loaded(reduced[1], "transient_maps.nc")
    write_forces(again.with_name("forces_of_another.csv"), 0.0)
    done, _ = run(again)
    quiet, maps = loaded(done), loaded(done, "transient_maps.nc")
    for name in ("psa", "pfa"):
        largest = float(quiet[name].max())
        assert float(abs(known[f"{name}_free"] - quiet[name]).max()) <= 1e-10 * largest
        assert float(abs(known[name] - quiet[name]).max()) > 0.1 * largest
        over_floors = abs(fields[f"{name}_free"] - maps[name]).max() / maps[name].max()
        assert float(over_floors) <= 1e-6  # stored in single precision
