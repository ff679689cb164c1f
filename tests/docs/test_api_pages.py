"""The code of the pages on the Python interface runs, and gives what it says."""

import numpy as np
import pytest
import scipy.optimize

from no_pictures import no_pictures

from .pages import ROOT, blocks

PAGES = sorted((ROOT / "docs" / "api").glob("*.md"))
ELSEWHERE = {"index", "building"}  # the code of building is that of from-a-mesh.md


@pytest.fixture
def names(tmp_path, monkeypatch):
    """Run the code of a page in an empty folder; gives what it leaves."""
    monkeypatch.chdir(tmp_path)

    def run(name):
        left = {}
        for block in blocks(ROOT / "docs" / "api" / f"{name}.md"):
            if block.language == "python":
                exec(compile(block.text, str(block), "exec"), left)
        return left

    return run


def test_each_page_has_code_that_is_run_here():
    with_code = {p.stem for p in PAGES if any(b.language == "python" for b in blocks(p))}
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {page.stem for page in PAGES} - ELSEWHERE == with_code == with_code & tested


def test_case(names):
    left = names("case")
    assert {path.name for path in left["files"]} >= {"towers.toml", "towers_walls.csv"}
    assert left["case"].contacts[0].gap == 0.02
    assert [fault.key for fault in left["faults"]] == ["motions[0].seed", "contacts[0].gap"]


def test_motion(names):
    left = names("motion")
    assert left["record"].time_step == 0.0025
    assert left["found"].pga == pytest.approx(3.0, rel=0.1)
    assert 4.0 < left["found"].duration_5_95 < 11.0


def test_spectra(names):
    left = names("spectra")
    assert left["psa"].max(axis=1) == pytest.approx([25.0, 10.0], rel=0.02)
    assert left["design"].max() == pytest.approx(left["psa"][1].max())


def test_sticks(names):
    left = names("sticks")
    assert left["response"].force.max() > 0.0 > left["response"].gap.min()


def test_device(names):
    """Resonance of the first mode, 12.5 times 2 m/s2, and the second one by statics, in step."""
    left = names("device")
    force = dict(zip(left["result"].quantities.names, left["result"].total, strict=True))
    assert force["force y"] == pytest.approx(300.0 * 25.0, rel=0.05)


def test_dynamics(names):
    """The impulse is the momentum at the wall of an oscillator that was let go with 1 m/s."""
    left = names("dynamics")
    omega = np.sqrt(left["k"] / left["m"])
    xi = left["damping"].ratio(omega / (2.0 * np.pi)).item()
    rest = omega * np.sqrt(1.0 - xi**2)

    def x(t):
        return np.exp(-xi * omega * t) * np.sin(rest * t) / rest

    meets = scipy.optimize.brentq(lambda t: x(t) - left["gap"], 0.0, 0.5 * np.pi / rest)
    speed = (x(meets + 1e-7) - x(meets - 1e-7)) / 2e-7
    assert left["contact"].impulse.sum() == pytest.approx(left["m"] * speed, rel=0.01)
    assert left["contact"].gap.min() > -1e-4
    assert left["damping"].ratio([5.0, 20.0]) == pytest.approx([0.05, 0.05])


def test_transient(names):
    left = names("transient")
    assert left["kept"] == pytest.approx(left["given"], rel=1e-9)
    assert left["force"].min() < 0.0


def test_wall(names):
    """Equation 5 with the paper's numbers."""
    law = names("wall")["law"]
    assert law.epsilon == pytest.approx(829e3 / (3014e3 * 0.163) - 1.0)
    assert law.K_Ceq == pytest.approx(1.1e11, rel=0.02)


def test_results(names):
    left = names("results")
    assert left["rows"] and all(row.passed for row in left["rows"])


def test_study(names, monkeypatch):
    no_pictures(monkeypatch)
    left = names("study")
    assert left["run"].value("pounding.impacts") > 0 and left["psa"].max() > 3.0
    assert left["frame"].value["motion.pga"] == left["run"].value("motion.pga")
