"""The buildings in 3D, and the lines of the stages."""

import base64
import json
import re
import shutil
import zlib
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from impactfem.report.headlines import headlines
from impactfem.report.scene_page import LEVELS, _outline, at_frequencies, write_scene
from impactfem.stages.stores import open_store
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

from ..stages.device.device_store import WantedDevice, device_store

ADDRESS = re.compile(r"""(?:src|href)\s*[=:,"']+\s*[`"']?https?:|url\(\s*["']?https?:|@import""")
TYPES = {"u1": np.uint8, "u2": np.uint16, "u4": np.uint32, "f4": np.float32}


def run_of(folder):
    """The files of a run with one 3D model and no pounding."""
    run = SimpleNamespace(
        folder=folder,
        has=lambda name: (folder / name).is_file(),
        ran=lambda stage: (folder / f"{stage}.nc").is_file(),
        store=lambda name: open_store(folder / name),
        case={"buildings": []},
    )
    run.models = {"A <&> B": run}
    return run


def scene_of(text):
    """The description of a page, its arrays by name, and its values [m/s2], nan for none."""
    blocks = dict(re.findall(r'<script type="[\w/]+" id="(\w+)">(.*?)</script>', text, re.S))
    header = json.loads(blocks["header"])
    content = zlib.decompress(base64.b64decode(blocks["data"]))
    arrays = {
        one["name"]: np.frombuffer(content, TYPES[one["type"]], one["size"], one["start"])
        for one in header["arrays"]
    }
    low, high = header["range"]
    code = arrays["value"].reshape(2, arrays["floor"].size, -1).astype(float)
    values = low * (high / low) ** ((code - 1.0) / (LEVELS - 1.0))
    return header, arrays, np.where(code > 0.0, values, np.nan)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With peaks of the floors and two devices."""
    from ..stages.conftest import Wanted, _building, _maps, _slab, _transient

    folder = tmp_path_factory.mktemp("scene")
    wanted = Wanted(floors=(2, 3), loads=(3,))
    slab = _slab(wanted.direction)
    building = _building(wanted, slab).assign_attrs(building="A <&> B")
    write_netcdf(folder / "building.nc", building)
    write_netcdf(folder / "transient.nc", _transient(wanted, slab))
    write_netcdf(folder / "transient_maps.nc", _maps(wanted, slab))
    write_netcdf(folder / "device.nc", device_store(WantedDevice(devices=("pump", "a & b"))))
    return folder


@pytest.fixture(scope="module")
def page(folder):
    (path,) = write_scene(run_of(folder))
    assert path == folder / "figures" / "building_scene.html"
    return path.read_text(encoding="utf-8")


def test_it_needs_no_network(page):
    assert ADDRESS.search(page) is None
    assert len(page) < 300_000


def test_peaks_and_spectra_of_each_vertex(page, folder):
    """Peaks are 10 + y; spectra are those of the maps, coded to 0.1 %."""
    header, arrays, values = scene_of(page)
    point = arrays["point"].reshape(-1, 3)
    assert values[0, :, 0] == pytest.approx(10.0 + point[:, 1], rel=1e-3)
    assert values[1] == pytest.approx(0.25 * values[0], rel=1e-3)
    with open_store(folder / "transient_maps.nc") as maps:
        psa = maps["psa"].sel(component="y").load()
        first = psa.values[:, 0], psa.values[:, -1]
        order = np.argsort(maps["node_number"].values)
    assert header["frequency"][0] == pytest.approx(float(psa["frequency"][0]))
    for column, known in zip((1, -1), first, strict=True):
        found, known = values[0, :, column], known[order]
        assert np.isnan(found[known <= 0.0]).all()
        assert found[known > 0.0] == pytest.approx(known[known > 0.0], rel=1e-3)
    assert set(arrays["floor"].tolist()) == {2, 3}
    assert arrays["slab"].max() == len(point) - 1 and arrays["slab"].size % 3 == 0


def test_devices_and_names(page):
    header, _, _ = scene_of(page)
    assert [one["name"] for one in header["devices"]] == ["pump", "a & b"]
    assert all(one["frequencies"] for one in header["devices"])
    (part,) = header["parts"]
    assert (part["name"], part["model"]) == ("A <&> B", "3D model")
    assert 0.0 < part["resolved"] < 1e4
    assert "&lt;&amp;&gt; B" in page and "A <&> B" not in page


def test_without_maps(folder, tmp_path):
    for name in ("building.nc", "transient.nc"):
        shutil.copy(folder / name, tmp_path)
    (path,) = write_scene(run_of(tmp_path))
    header, _, values = scene_of(path.read_text(encoding="utf-8"))
    assert header["frequency"] == [] and np.isnan(values).all()


def test_a_stick_is_a_box_with_its_spectra(finished, tmp_path):
    """A run of sticks alone has no scene; with a 3D model beside it a stick has slabs."""
    from impactfem.report.run_files import RunFiles
    from impactfem.report.scene_page import _sticks

    run, frequency = RunFiles(finished.folder), np.array([1.0, 5.0])
    assert write_scene(run) == []
    (first, *_) = parts = list(_sticks(run, set(), frequency, np.array([20.0, 10.0])))
    assert len(parts) == len(run.case["buildings"])
    with run.store("pounding.nc") as store:
        axis = store.attrs["shown_direction"]
        own = store.isel(station=(store["station_building"] == first.name).values)
        peaks, heights = own["pfa"].sel(direction=axis).values, own["elevation"].values
    assert first.pfa[0] == pytest.approx(np.repeat(peaks, 4))
    assert np.unique(first.point[:, 2]) == pytest.approx(np.unique(heights))
    assert first.psa.shape == (2, len(first.point), 2)
    normal = np.cross(
        *(first.point[first.slab[:, k]] - first.point[first.slab[:, 0]] for k in (1, 2))
    )
    assert (normal[:, 2] > 0.0).all() and np.isfinite(first.line).all()


def test_spectra_between_frequencies_are_powers():
    f = np.array([1.0, 2.0, 8.0])
    psa = xr.DataArray([3.0 * f**2], dims=("node", "frequency"), coords={"frequency": f})
    wanted = np.array([1.0, 1.5, 4.0, 8.0])
    assert at_frequencies(psa, wanted)[0] == pytest.approx(3.0 * wanted**2)


def test_the_outline_of_a_folded_sheet():
    """Two unit squares at a right angle: seven sides and no diagonal; flat squares have six."""
    for z, count in ((1.0, 7), (0.0, 6)):
        far = [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]
        if z == 0.0:
            far = [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]
        nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], *far], dtype=float)
        cells = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
        assert len(_outline(nodes, cells)) == count


def test_a_store_that_is_damaged(tmp_path):
    (tmp_path / "building.nc").write_bytes(b"no store")
    with pytest.raises(ImpactfemError, match=r"cannot read .*building\.nc"):
        write_scene(run_of(tmp_path))


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
