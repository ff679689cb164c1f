"""The building in 3D that one can turn, and the lines of the stages."""

import base64
import io
import json
import re
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.report.headlines import headlines
from impactfem.report.scene_page import write_scene
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

from ..stages.device.device_store import WantedDevice, device_store

ADDRESS = re.compile(r"""(?:src|href)\s*[=:,"']+\s*[`"']?https?:|url\(\s*["']?https?:|@import""")


def scene_of(text):
    """The description that the viewer reads."""
    (content,) = re.findall(r'base64Str = "([A-Za-z0-9+/=]+)"', text)
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(content))) as archive:
        return json.loads(archive.read("index.json"))


@pytest.fixture(scope="module")
def page(tmp_path_factory, request):
    """With peaks of the floors and two devices; in one process, for all tests."""
    from ..stages.conftest import Wanted, _building, _maps, _slab, _transient

    folder = tmp_path_factory.mktemp("scene")
    asked = Wanted(floors=(2, 3), loads=(3,))
    slab = _slab(asked.direction)
    building = _building(asked, slab).assign_attrs(building="A <&> B")
    write_netcdf(folder / "building.nc", building)
    write_netcdf(folder / "transient.nc", _transient(asked, slab))
    write_netcdf(folder / "transient_maps.nc", _maps(asked, slab))
    write_netcdf(folder / "device.nc", device_store(WantedDevice(devices=("pump", "a & b"))))
    (path,) = write_scene(folder)
    assert path == folder / "figures" / "building_scene.html"
    return path.read_text(encoding="utf-8")


@pytest.mark.slow
def test_it_needs_no_network(page):
    assert ADDRESS.search(page) is None
    assert "favicon" not in page or "kitware.github.io/vtk-js/icon" not in page
    # The viewer as it is delivered would fetch its icons.
    from importlib.resources import files

    viewer = (files("trame_vtk.tools") / "static_viewer.html").read_text(encoding="utf-8")
    assert "kitware.github.io/vtk-js/icon" in viewer


@pytest.mark.slow
def test_it_holds_the_scene(page):
    scene = scene_of(page)
    arrays = scene["hashes"].values()
    assert all(array["content"] for array in arrays)
    numbers = [
        np.frombuffer(base64.b64decode(array["content"]), dtype=np.float32)
        for array in arrays
        if array["type"] == "Float32Array"
    ]
    # Of the 25 vertices of each of two slabs peaks, which are 10 + y, and positions.
    peaks = [values for values in numbers if values.size == 50 and values.min() == 10.0]
    places = [values.reshape(-1, 3) for values in numbers if values.size == 150]
    assert any(peak == pytest.approx(10.0 + at[:, 1]) for peak in peaks for at in places)
    assert scene["scene"]["type"].endswith("RenderWindow")
    assert len(page) < 3_000_000


@pytest.mark.slow
def test_it_says_what_it_shows(page):
    assert "&lt;&amp;&gt; B</title>" in page and "A <&> B" not in page
    for words in ("acceleration along y [m/s²]", "impact edges", "columns", "a &amp; b, floor"):
        assert words in page
    # 10 + y over 6 m.
    assert "<span>10</span><span>13</span><span>16</span>" in page
    assert page.index('class="content"') < page.index('id="notes"') < page.index("</body>")


@pytest.mark.slow
def test_without_peaks_and_devices(transient_folder):
    folder = transient_folder(maps=False, loads=())
    (path,) = write_scene(folder)
    page = path.read_text(encoding="utf-8")
    notes = page[page.index('id="notes"') :]
    assert "slabs" in notes and "linear-gradient" not in notes and "floor 3" not in notes


def test_without_a_building(tmp_path):
    assert write_scene(tmp_path) == []
    assert not list(tmp_path.iterdir())


def test_a_store_that_is_damaged(tmp_path):
    (tmp_path / "building.nc").write_bytes(b"no store")
    with pytest.raises(ImpactfemError, match=r"cannot read .*building\.nc"):
        write_scene(tmp_path)


def test_lines_of_a_stage():
    stage = SimpleNamespace(headlines=("{a.b} at {a.t}", "up to {f.floor_*.peak}", "{gone}"))
    values = {"a.b": (2e6, "N"), "f.floor_1.peak": (3.0, "m/s2"), "f.floor_2.peak": (4.0, "m/s2")}
    results = [{"name": n, "value": v, "unit": u} for n, (v, u) in values.items()]
    results.append({"name": "gone", "value": None, "unit": "-"})
    assert headlines(stage, results) == ["up to 4 m/s²"]
    results.append({"name": "a.t", "value": 0.0135, "unit": "s"})
    assert headlines(stage, results) == ["2 MN at 13.5 ms", "up to 4 m/s²"]
    # The first one, with its letter, though another is larger.
    stage = SimpleNamespace(headlines=("F? {d.f?.whole}",))
    forces = (("d.fy.whole", 8e3), ("d.fx.whole", 9e3))
    results = [{"name": name, "value": value, "unit": "N"} for name, value in forces]
    assert headlines(stage, results) == ["Fy 8 kN"]
