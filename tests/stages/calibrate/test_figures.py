"""The figures of the stage `calibrate`, from stores that no solver made."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from matplotlib.axes import Axes

from impactfem.plot import style
from impactfem.stages.calibrate.figures import wall_figures
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

from ..figure_file import assert_drawn
from ..wall_store import WantedWall, calibrate_store

ALL = ["figure_06_wall_impact", "figure_07_wall_stick"]
ALL += ["wall_damping", "wall_energy", "wall_line_load"]
ONE_FLOOR = {8: ((0.2003, 0.016, 800e3),)}
CASES = {
    "three dampings": ({}, ALL),
    "one floor": ({"hits": ONE_FLOOR, "stick_hits": ONE_FLOOR}, ALL),
    "one damping, a scheme that damps": (
        {"dampings": 1, "numerical": 5e3},
        [name for name in ALL if name != "wall_damping"],
    ),
}


@dataclass
class Drawn:
    """What a run of the figures wrote and drew: curves by label, images."""

    folder: object
    files: list = field(default_factory=list)
    curves: dict = field(default_factory=dict)
    images: list = field(default_factory=list)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Each case, drawn once and coarsely."""
    found = {}
    plot, image = Axes.plot, Axes.pcolormesh
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style.SETTINGS, "savefig.dpi", 40.0)
        for name, (wanted, _) in CASES.items():
            one = found[name] = Drawn(tmp_path_factory.mktemp("wall"))

            def kept_plot(self, x, y, *args, one=one, **options):
                one.curves.setdefault(options.get("label"), []).append((np.array(x), np.array(y)))
                return plot(self, x, y, *args, **options)

            def kept_image(self, x, y, values, one=one, **options):
                one.images.append((np.array(x), np.array(y), np.array(values)))
                return image(self, x, y, values, **options)

            patch.setattr(Axes, "plot", kept_plot)
            patch.setattr(Axes, "pcolormesh", kept_image)
            write_netcdf(one.folder / "calibrate.nc", calibrate_store(WantedWall(**wanted)))
            one.files = wall_figures(one.folder)
    return found


@pytest.mark.parametrize("name", CASES)
def test_files(drawn, name):
    one = drawn[name]
    assert [path.stem for path in one.files] == CASES[name][1]
    assert sorted((one.folder / "figures").iterdir()) == one.files
    for path in one.files:
        assert_drawn(path, 500, 300)


def test_forces_and_impulses_around_the_first_impact(drawn):
    curves = drawn["three dampings"].curves
    time, force = curves["floor 8"][0]
    assert force.max() == pytest.approx(0.5 * np.pi * 800e3 / 0.016 / 1e6, rel=3e-3)
    assert 0.19 < time[0] < 0.2003 and 0.2163 < time[-1] < 0.23
    _, impulse = curves["floor 8, 800 kN·s"][0]
    assert impulse[0] == 0.0 and impulse[-1] == pytest.approx(800.0, rel=2e-3)
    assert any(label.startswith("floor 7,") for label in curves)
    # Floor 6 does not hit.
    assert not any(label.startswith("floor 6") for label in curves)


def test_stick_beside_the_3d_model(drawn):
    one = drawn["three dampings"]
    displacement, velocity, impulse = (values for _, values in one.curves["stick"])
    assert one.curves["wall"][0][1] == pytest.approx([1.0, 1.0])
    assert displacement.max() == pytest.approx(1.0)
    assert velocity.max() == pytest.approx(0.16)
    # The stick's second impact adds to its first; the 3D model has one.
    assert impulse[-1] == pytest.approx(817.0, rel=2e-3)
    assert one.curves["3D"][2][1][-1] == pytest.approx(800.0, rel=2e-3)


def test_line_load(drawn):
    # Floors 8 and 7, and the scale of the colours.
    images = drawn["three dampings"].images
    assert (len(images), len(drawn["one floor"].images)) == (3, 2)
    time, position, load = images[0]
    assert position.tolist() == [0.0, 3.0, 6.0, 9.0, 12.0]
    assert load.shape == (5, len(time))
    # An even load on 12 m: ends stand for half the length, and have the same load on a metre.
    expected = 0.5 * np.pi * 800e3 / 0.016 / 12.0 / 1e6
    assert load.max(axis=1) == pytest.approx(np.full(5, expected), rel=3e-3)


@pytest.mark.parametrize("name", ["three dampings", "one damping, a scheme that damps"])
def test_the_sum_of_the_energies(drawn, name):
    curves = drawn[name].curves
    for _, total in curves["sum"]:
        assert total == pytest.approx(np.full(total.shape, 170.0))
    # It has a curve only where the scheme takes something.
    assert ("numerical" in curves) == ("scheme" in name)


def test_dampings(drawn):
    curves = drawn["three dampings"].curves
    epsilon, stiffness, duration = curves["over-damped"]
    # ξ = α / (4 π f) + π β f at f = 1 / (2 · 16 ms).
    ratio = 100.0 * (0.559 / (4.0 * np.pi * 31.25) + np.pi * 3e-3 * 31.25)
    assert float(epsilon[0]) == pytest.approx(ratio)
    assert (float(epsilon[1]), float(stiffness[1])) == (0.4, pytest.approx(1.3))
    assert float(duration[1]) == pytest.approx(17.0)
    assert "own" not in drawn["one damping, a scheme that damps"].curves


def test_a_figure_that_cannot_be_written(wall_folder):
    folder = wall_folder()
    (folder / "figures" / "figure_06_wall_impact.svg" / "full").mkdir(parents=True)
    with pytest.raises(ImpactfemError, match=r"cannot write .*figure_06_wall_impact\.svg"):
        wall_figures(folder)
