"""The figures of the stage `device`, from stores that no solver made."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

from impactfem.plot import style
from impactfem.stages.device.model_figures import (
    device_size,
    drawing_of,
    elements_figure,
    model_figure,
)
from impactfem.stages.device.pictures import Floor
from impactfem.stages.device.selection import input_variants
from impactfem.stages.device.stage import DEVICE
from impactfem.system.files import write_netcdf

from ..figure_file import assert_drawn, draw_all
from .device_store import FREQUENCIES, HEIGHT, WantedDevice, device_folder, device_store

FORCES = ["device_demand-pump", "device_force-pump", "damping_cases"]
FORCES += ["anchor_spectra-pump", "device_force_damping-pump"]
SPRINGS = ["device_elements-pump", "device_modes-pump", "device_model-pump"]
POSITION = ["device_on_floor-pump"]
ONE = [name for name in FORCES if name != "device_force_damping-pump"]
INPUTS = {
    "srss": (0.6, 0.8),
    "cqc": (0.61, 0.81),
    "srss, rotations": (0.7, 0.9),
    "srss, envelope": (0.9, 1.1),
    "srss, envelope, broadened": (0.95, 1.2),
    "srss, given": (math.nan, math.nan),
    "srss, envelope-dampings": (1.1, 1.3),
    "srss, supports abs": (0.8, 0.9),
}
OWN = [name for name in FORCES if name != "damping_cases"]
CASES = {
    "the paper's": ({}, True, [*FORCES, *SPRINGS, *POSITION]),
    "one damping, no building": ({"dampings": 1}, False, [*ONE, *SPRINGS]),
    "two devices from modes": (
        {"devices": ("pump", "fan"), "from_modes": True, "nodes": 1},
        True,
        [*FORCES, *POSITION, *(name.replace("pump", "fan") for name in [*OWN, *POSITION])],
    ),
    "along x, no beam, no cylinder": (
        {"direction": "x", "beam": False, "cylinder": False},
        False,
        [*FORCES, *SPRINGS],
    ),
    "along z, one analysis": (
        {"direction": "z", "choices": {"srss": (0.65, 0.95)}},
        False,
        [*FORCES, *SPRINGS],
    ),
    "other inputs": (
        {"choices": INPUTS, "dampings": 2},
        False,
        [*FORCES, *SPRINGS, "device_inputs-pump"],
    ),
}


@dataclass
class Drawn:
    """What a run of the figures wrote and drew: curves, bars and texts."""

    folder: object
    files: list = field(default_factory=list)
    curves: dict = field(default_factory=dict)
    bars: dict = field(default_factory=dict)
    texts: list = field(default_factory=list)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Each case, drawn once and coarsely."""
    found = {}
    plot, bar, text = Axes.plot, Axes.bar, Axes.text
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style.SETTINGS, "figure.dpi", 40.0)
        for name, (wanted, building, _) in CASES.items():
            one = found[name] = Drawn(device_folder(tmp_path_factory.mktemp("device"), **wanted))
            if building:
                one_floor().to_netcdf(one.folder / "building.nc", engine="netcdf4")

            # Axes with logarithms plot, too.
            def seen_plot(self, x, y, *args, one=one, **options):
                one.curves.setdefault(options.get("label"), []).append((np.array(x), np.array(y)))
                return plot(self, x, y, *args, **options)

            def seen_bar(self, x, height, *args, one=one, **options):
                one.bars.setdefault(options["color"], []).append(np.array(height))
                return bar(self, x, height, *args, **options)

            def seen_text(self, x, y, words, *args, one=one, **options):
                one.texts.append(words)
                return text(self, x, y, words, *args, **options)

            patch.setattr(Axes, "plot", seen_plot)
            patch.setattr(Axes, "bar", seen_bar)
            patch.setattr(Axes, "text", seen_text)
            one.files = draw_all(DEVICE.figures, one.folder)
    return found


def one_floor():
    """Floor 3: a slab of 8 by 6 m in four triangles, with a parapet, a wall and a column."""
    corners = np.array([[0, 0, 12], [8, 0, 12], [8, 6, 12], [0, 6, 12], [4, 3, 12]], dtype=float)
    # Below the slab, above it and at its foot.
    others = np.array([[0, 6, 8], [8, 6, 8], [0, 0, 13], [4, 3, 8]], dtype=float)
    nodes = np.concatenate([corners, others])
    cells = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (3, 2, 5), (0, 3, 7)]
    triangles, lines = [], []
    for a, b, c in cells:
        first = len(nodes)
        middles = [nodes[[p, q]].mean(axis=0) for p, q in ((a, b), (b, c), (c, a))]
        nodes = np.concatenate([nodes, middles])
        triangles.append([a, b, c, first, first + 1, first + 2])
    for a, b in ((4, 8), (0, 4)):
        nodes = np.concatenate([nodes, [nodes[[a, b]].mean(axis=0)]])
        lines.append([a, b, len(nodes) - 1])
    return xr.Dataset(
        {
            "node_position": (("node", "xyz"), nodes),
            "triangle_node": (("triangle", "triangle_corner"), np.array(triangles)),
            "triangle_part": ("triangle", np.array([0, 0, 0, 0, 1, 2])),
            "shell_part_name": ("shell_part", ["floor_3", "storey_3_north", "floor_3_parapet"]),
            "line_node": (("line", "line_corner"), np.array(lines)),
            "line_part": ("line", np.array([0, 1])),
            "beam_part_name": ("beam_part", ["column_3", "beam_3_long"]),
            "edge_line": (("edge", "line_corner"), np.array([[3, 2, 0], [0, 1, 0]])),
            "edge_floor": ("edge", np.array([3, 2])),
        }
    )


@pytest.mark.parametrize("name", CASES)
def test_files(drawn, name):
    one = drawn[name]
    assert [path.stem for path in one.files] == sorted(CASES[name][2])
    assert sorted((one.folder / "figures").iterdir()) == one.files
    for path in one.files:
        assert_drawn(path, 400, 300)


def test_force_of_the_own_damping(drawn):
    one = drawn["the paper's"]
    (time, force), *_ = one.curves["66 kN at 1.200 s"]
    assert (float(time[0]), float(force[0])) == (pytest.approx(1.2), pytest.approx(66.0))
    # By spectrum, to either side: without impact and with impacts.
    lines = (y for found in one.curves.values() for _, y in found if y.shape == (2,))
    levels = {round(float(y[0]), 6) for y in lines}
    assert {6.5, -6.5, 62.7, -62.7} <= levels


def test_forces_by_damping(drawn):
    curves = drawn["the paper's"].curves
    ratio, *forces = curves["under-damped"]
    # Each twice: as a whole, and around the largest one; and without and with impacts.
    assert [y.max() for _, y in forces] == pytest.approx([12.0, 12.0, 116.0, 116.0])
    # That of the case is one of them.
    assert not {"own", "case"} & set(curves)
    # ξ = α / (4 π f) + π β f.
    f, percent = ratio
    expected = 100.0 * (0.838 / (4.0 * np.pi * f) + np.pi * 2.12e-4 * f)
    assert percent == pytest.approx(expected)


def test_spectra_say_their_peaks(drawn):
    curves = drawn["the paper's"].curves
    (label,) = (name for name in curves if name and name.startswith("over-damped, ε = 0.41: 38"))
    ((frequency, spectrum),) = curves[label]
    peak = f"{spectrum.max():.3g} m/s² at {frequency[spectrum.argmax()]:.3g} Hz"
    assert label.endswith(f": {peak}")
    assert spectrum.max() == pytest.approx(3.0 * 64e3 / 5e3, rel=0.01)


def test_demands(drawn):
    one = drawn["the paper's"]
    assert one.bars["black"][0] == pytest.approx([10, 12, 10, 9])
    by_spectrum = one.bars[style.BLUE]
    assert by_spectrum[0] == pytest.approx([6.5, 7.8, 6.5, 5.85])
    assert by_spectrum[1] == pytest.approx([35.0] * 4)
    assert by_spectrum[3] == pytest.approx([5.0] * 4)
    # With rotations, broadened and both.
    assert len(one.bars) == 5
    assert len(drawn["along z, one analysis"].bars) == 2


def test_forces_by_input_over_the_detailed_one(drawn):
    store = device_store(WantedDevice(choices=INPUTS))
    assert input_variants(store, "pump") == {
        "computed spectra": "srss",
        "envelope with further points": "srss, envelope",
        "envelope over all dampings": "srss, envelope-dampings",
        "supports by absolute sum": "srss, supports abs",
    }
    assert list(input_variants(device_store(WantedDevice()), "pump")) == ["computed spectra"]
    every = drawn["other inputs"].curves
    for case in ("own", "under-damped"):
        labels = [name for name in every if name and name.split(",")[0] == case]
        found = [x for name in labels for x, y in every[name] if list(y) == [0, 1, 2, 3]]
        assert found[0] == pytest.approx([0.6, 0.9, 1.1, 0.8])
        assert found[1] == pytest.approx([0.8, 1.1, 1.3, 0.9])


def test_modes_move_as_in_the_store(drawn):
    (beam, base, centre) = (
        drawn["the paper's"].curves[name] for name in ("beam", "base", "mass centre")
    )
    # The elements come last, with both at rest.
    *beam, (at_rest, _) = beam
    assert at_rest == pytest.approx([0.0, 0.0])
    centre = centre[:-1]
    first, second = beam[0][0], beam[1][0]
    # Base and mass centre on one side in the first mode, on two in the second.
    assert first[0] * first[-1] > 0.0 and second[0] * second[-1] < 0.0
    shift = 0.01 + 0.03 * np.array([0.0, 0.5 * HEIGHT, HEIGHT])
    assert first / first[-1] == pytest.approx(shift / shift[-1])
    for k in range(2):
        assert float(base[k][0]) == beam[k][0][0]
        assert float(centre[k][1]) == pytest.approx(HEIGHT)
    texts = drawn["the paper's"].texts
    assert f"f = {FREQUENCIES[3]:.2f} Hz\n327 kg, 21.2 %" in texts


def test_the_body_turns_as_its_mass_centre_does(drawn):
    body = drawn["the paper's"].curves["body"]
    x, z = body[0]
    # The rigid body's middle line has the slope of the straight beam below it.
    line, levels = drawn["the paper's"].curves["beam"][0]
    slope = (line[-1] - line[0]) / (levels[-1] - levels[0])
    assert (x[3] - x[0]) == pytest.approx(slope * 1.0)
    assert (z[1] - z[0]) == pytest.approx(-slope * 1.0)


def test_values_of_the_mechanical_model(drawn):
    texts = "\n".join(drawn["the paper's"].texts)
    for words in (
        "$K_{yy}$ = $1.4 \\cdot 10^{8}$ N/m",
        "$K_{rxx}$ = $3 \\cdot 10^{7}$ N m/rad",
        "$m$ = 1500 kg at 0.46 m\n$J_x$ = 220 kg m²",
        "mode 2: 30.50 Hz, 1219 kg, damping 2 %",
    ):
        assert words in texts
    along_x = "\n".join(drawn["along x, no beam, no cylinder"].texts)
    assert "$K_{xx}$" in along_x and "$K_{ryy}$" in along_x and "mode 1:" in along_x
    assert "beam" not in along_x


def test_a_rigid_spring(tmp_path):
    store = device_store(WantedDevice())
    store["base_stiffness"][0, 1] = np.inf
    drawing = drawing_of(store, "pump")
    assert drawing.value("base_stiffness", component=drawing.axis) == np.inf
    model_figure(tmp_path / "model.png", store, "pump")
    assert (tmp_path / "model.png").is_file()


def test_a_device_that_follows_the_floor(tmp_path):
    store = device_store(WantedDevice(dampings=1))
    store["effective_mass"].loc[{"component": "y"}] = 0.0
    write_netcdf(tmp_path / "device.nc", store)
    drawn = {path.stem: path for path in draw_all(DEVICE.figures, tmp_path)}
    assert {"device_elements-pump", "device_model-pump"} <= set(drawn)
    assert "device_modes-pump" not in drawn
    text = drawn["device_model-pump"].read_text("utf-8")
    assert "along y: it follows" in text


def test_plan_of_a_floor():
    floor = Floor(one_floor(), 3)
    outline = floor.outline()
    # Four sides; neither the diagonals nor the parapet.
    assert len(outline) == 4 and len(floor.mesh()) == 8
    assert np.linalg.norm(outline[:, 1] - outline[:, 0], axis=1).sum() == pytest.approx(28.0)
    assert np.sort(floor.walls()[0], axis=0).tolist() == [[0.0, 6.0], [8.0, 6.0]]
    assert floor.columns().tolist() == [[4.0, 3.0]]
    assert floor.beams().tolist() == [[[0.0, 0.0], [4.0, 3.0]]]
    assert floor.impact_edge().tolist() == [[[0.0, 6.0], [8.0, 6.0]]]
    assert floor.anchor_nodes(np.array([4.1, 3.1, 12.0]), 1).tolist() == [[4.0, 3.0]]


@pytest.mark.slow
def test_pictures_of_two_devices(tmp_path):
    folder = device_folder(tmp_path, devices=("pump", "fan"))
    assert draw_all(DEVICE.figures, folder, in_3d=True) == []
    one_floor().to_netcdf(folder / "building.nc", engine="netcdf4")
    found = draw_all(DEVICE.figures, folder, in_3d=True)
    assert [path.name for path in found] == [
        "device_in_building-fan.png",
        "device_in_building-pump.png",
    ]
    for path in found:
        assert_drawn(path, 2000, 1000)


@pytest.mark.parametrize(
    ("wanted", "size"),
    [
        ({}, (0.5, 1.0)),
        ({"cylinder": False}, (0.25 * HEIGHT, HEIGHT)),
        ({"from_modes": True}, (0.25, 1.0)),
    ],
)
def test_size_of_a_device(wanted, size):
    found = device_size(device_store(WantedDevice(**wanted)), "pump")
    assert found == pytest.approx(size)


@pytest.mark.parametrize(
    ("height", "cylinder", "size", "ends"),
    [
        (-HEIGHT, False, (0.25 * HEIGHT, HEIGHT), (-1.15 * HEIGHT, -0.85 * HEIGHT)),
        (-HEIGHT, True, (0.5, 1.0), (-1.0, 0.0)),
        (0.0, False, (0.25, 1.0), (-0.15, 0.15)),
    ],
)
def test_a_mass_centre_that_is_not_above_the_anchor(tmp_path, height, cylinder, size, ends):
    store = device_store(WantedDevice(cylinder=cylinder, beam=False))
    store["body_height"][:] = height
    store["level_height"][:] *= height / HEIGHT
    assert device_size(store, "pump") == pytest.approx(size)
    drawing = drawing_of(store, "pump")
    low, high = drawing.outline[:, 1].min(), drawing.outline[:, 1].max()
    assert (low, high) == pytest.approx(ends)
    elements_figure(tmp_path / "elements.svg", store, "pump")
    below = "below" if height < 0.0 else "above"
    words = f"centre {abs(height):g} m {below} springs and rigid links"
    assert words in (tmp_path / "elements.svg").read_text("utf-8")
