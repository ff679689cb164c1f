import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr

from impactfem.case.analysis import Spectra
from impactfem.plot.floor_products import (
    building_page,
    floor_designs,
    floor_store,
    read_floor_spectra,
    write_floor_products,
    write_workbook,
)
from impactfem.spectra import FloorSpectrumSet, Station, broaden, rg_1_122_frequencies
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

# Debian's h5py 3.7 calls what numpy 1.25 deprecates.
pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

F = rg_1_122_frequencies(100.0, 10)


def rules(broadening, *, clipping=False):
    return Spectra.model_construct(broadening=broadening, clipping=clipping)


RULES = rules(0.15)
FLOORS = (("B1", 1, 3.0), ("B1", 2, 6.0), ("B2", 1, 3.5))


def store(path, motions=0, directions="xy", title="a pair", *, turns=False):
    """A store in the form of the stick stage, with one narrow peak a floor."""
    rng = np.random.default_rng(4)
    dampings = np.array([0.02, 0.05])
    shape = (max(motions, 1), dampings.size, len(FLOORS), len(directions), F.size)
    pfa = rng.uniform(1.0, 2.0, (shape[0], *shape[2:4]))
    psa = np.empty(shape)
    for m, d, s, x in np.ndindex(*shape[:-1]):
        peak = rng.uniform(3.0, 20.0)
        psa[m, d, s, x] = pfa[m, s, x] + 8.0 / (1 + d) / (1.0 + (12.0 * (F / peak - 1.0)) ** 2)
    dims = ("motion", "damping", "station", "direction", "frequency")
    if not motions:
        psa, pfa, dims = psa[0], pfa[0], dims[1:]
    data = xr.Dataset(
        {
            "psa": (dims, psa, {"units": "m/s2"}),
            "pfa": (tuple(d for d in dims if d not in ("damping", "frequency")), pfa),
            "frequency": ("frequency", F),
            "damping": ("damping", dampings),
            "direction": ("direction", np.array(list(directions), dtype=object)),
            "station_building": ("station", np.array([b for b, _, _ in FLOORS], dtype=object)),
            "station_floor": ("station", np.array([k for _, k, _ in FLOORS])),
            "elevation": ("station", np.array([z for _, _, z in FLOORS])),
        },
        attrs={"title": title, "inputs": "abc"},
    )
    if turns:
        data["rotation"] = ("rotation", np.array(["rx", "rz"], dtype=object))
        for name, along in (("psa", dims), ("pfa", data["pfa"].dims)):
            axes = tuple("rotation" if one == "direction" else one for one in along)
            data[f"rotational_{name}"] = (axes, 0.1 * data[name].values)
    if motions:
        names = np.array([f"seed {k}" for k in range(motions)], dtype=object)
        data = data.assign_coords(motion=("motion", names))
    write_netcdf(path, data.assign(points_per_cycle=20.0))
    return path


def read(path):
    return pd.read_csv(path)


def of_one(table):
    """The rows of floor 2 of B1 along y at 5 %."""
    return table[(table.iloc[:, :4] == ["B1", 2, "y", 0.05]).all(axis=1)]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_floor_products(folder, store(folder / "pounding.nc"), RULES)
    return folder


def test_files(made):
    found = sorted(str(p.relative_to(made)) for p in made.rglob("*") if p.is_file())
    assert found == [
        "pounding.nc",
        "products/floor_peaks.csv",
        "products/floor_spectra.csv",
        "products/floor_spectra.nc",
        "products/floor_spectra.xlsx",
    ]


def test_table_has_labels_units_and_both_spectra(made):
    table = read(made / "products/floor_spectra.csv")
    assert list(table) == [
        *("building", "floor", "direction", "damping [-]", "frequency [Hz]"),
        *("raw [m/s2]", "broadened [m/s2]"),
    ]
    one = of_one(table)
    with xr.open_dataset(made / "pounding.nc", engine="netcdf4") as source:
        psa = source["psa"].values[1, 1, 1]
    computed = one.dropna()
    np.testing.assert_allclose(computed["frequency [Hz]"], F, rtol=1e-5)
    np.testing.assert_allclose(computed["raw [m/s2]"], psa, rtol=1e-5)
    expected = broaden(F, psa, 0.15, np.clip(one["frequency [Hz]"].to_numpy(), F[0], F[-1]))
    np.testing.assert_allclose(one["broadened [m/s2]"], expected, rtol=1e-4)
    assert len(one) > len(computed) == F.size


def test_rotations_have_products_of_their_own(made, tmp_path):
    """In rad/s2; those of translations are as without them."""
    write_floor_products(tmp_path, store(tmp_path / "pounding.nc", turns=True), RULES)
    names = ["floor_rotations.csv", "floor_rotations.nc"]
    both = sorted(path.name for path in (tmp_path / "products").iterdir())
    assert sorted(set(both) - {path.name for path in (made / "products").iterdir()}) == names
    name = "products/floor_spectra.csv"
    assert (tmp_path / name).read_bytes() == (made / name).read_bytes()
    straight, turned = read(tmp_path / name), read(tmp_path / "products/floor_rotations.csv")
    assert set(turned["direction"]) == {"rx", "rz"}
    known = 0.1 * straight["broadened [m/s2]"]
    np.testing.assert_allclose(turned["broadened [rad/s2]"], known, rtol=1e-4)
    with xr.open_dataset(tmp_path / "products/floor_rotations.nc", engine="netcdf4") as data:
        assert data["broadened"].attrs["units"] == data["zpa"].attrs["units"] == "rad/s2"
    rotations = floor_designs(tmp_path / "pounding.nc", RULES).rotations
    labels = {panel.ylabel for panel in building_page(rotations, "B1").panels}
    assert "acceleration [rad/s²]" in labels and "acceleration [m/s²]" not in labels


def test_peaks(made):
    table = read(made / "products/floor_peaks.csv")
    assert len(table) == len(FLOORS) * 2 * 2
    spectra, *_ = read_floor_spectra(made / "pounding.nc")
    first = table.iloc[0]
    assert (first["building"], first["floor"], first["direction"]) == ("B1", 1, "x")
    assert first["raw peak [m/s2]"] == pytest.approx(spectra.psa[0, 0, 0, 0].max(), rel=1e-5)
    assert first["broadened peak [m/s2]"] == first["raw peak [m/s2]"]
    zpa = pytest.approx(spectra.zpa[0, 0, 0], rel=1e-5)
    assert first["zero-period acceleration [m/s2]"] == zpa
    assert 1.0 < first["within 5 % of it from [Hz]"] <= 100.0


def test_workbook_has_a_sheet_for_each_building_direction_and_damping(made):
    book = openpyxl.load_workbook(made / "products/floor_spectra.xlsx")
    assert book.sheetnames == ["contents"] + [
        f"{b} {x} {d} %" for b in ("B1", "B2") for x in "xy" for d in (2, 5)
    ]
    cells = list(book["B1 y 5 %"].iter_rows(values_only=True))
    head = {row[0]: row[1:] for row in cells if row and isinstance(row[0], str)}
    assert head["building"][0] == "B1"
    assert head["direction"][0] == "y"
    assert head["damping [-]"][0] == 0.05
    assert head["case"][0] == "a pair"
    assert head["floor"] == ("floor 1", "floor 1", "floor 2", "floor 2")
    assert head["points"][0] == "mass centre"
    assert "m/s2" in head["units"][0]
    assert "histories with pounding" in head["method"][0]
    assert "±15 %" in head["design"][0]
    assert head["frequency [Hz]"] == ("raw [m/s2]", "broadened [m/s2]") * 2
    numbers = [row for row in cells if isinstance(row[0], float | int)]
    table = of_one(read(made / "products/floor_spectra.csv"))
    found = np.array([row[3:5] for row in numbers], dtype=float)
    np.testing.assert_array_equal(found, table[["raw [m/s2]", "broadened [m/s2]"]])


def test_store_carries_method_and_inputs(made):
    with xr.open_dataset(made / "products/floor_spectra.nc", engine="netcdf4") as data:
        assert data.attrs["inputs"] == "abc"
        assert data.attrs["title"] == "a pair"
        assert "20 points in a cycle" in data.attrs["method"]
        assert data["broadened"].dims == ("damping", "station", "direction", "design_frequency")
        assert data["raw"].attrs["units"] == "m/s2"
        assert data["station_points"].values.tolist() == ["mass centre"] * 3
        assert np.all(data["broadened"].max("design_frequency") == data["raw"].max("frequency"))


def test_ensemble_has_fractiles(tmp_path):
    """In tables alone."""
    source = store(tmp_path / "ensemble.nc", motions=5)
    files = write_floor_products(tmp_path, source, RULES, statistic=0.84)
    assert [path.name for path in files] == ["floor_spectra.csv", "floor_peaks.csv"]
    data = floor_store(floor_designs(source, RULES, 0.84).translations)
    assert data.attrs["motions"] == "5 motions, 84 % fractile"
    with xr.open_dataset(source, engine="netcdf4") as given:
        psa = given["psa"].values
    np.testing.assert_allclose(data["median"], np.median(psa, axis=0))
    np.testing.assert_allclose(data["mean"], psa.mean(axis=0))
    np.testing.assert_allclose(data["envelope"], psa.max(axis=0))
    np.testing.assert_array_equal(data["84_fractile"], data["raw"])
    assert np.all(data["16_fractile"] <= data["84_fractile"])
    table = read(tmp_path / "products/floor_spectra.csv")
    names = ("mean", "16 % fractile", "median", "84 % fractile", "envelope")
    assert list(table)[-5:] == [f"{name} [m/s2]" for name in names]


def test_broadening_and_clipping_reach_the_files(tmp_path):
    source = store(tmp_path / "pounding.nc")
    write_floor_products(tmp_path, source, rules(0.0, clipping=True))
    with xr.open_dataset(tmp_path / "products/floor_spectra.nc", engine="netcdf4") as data:
        assert np.any(data["broadened"].max("design_frequency") < data["raw"].max("frequency"))
        assert data.attrs["design"].startswith("peaks not broadened; ")
        assert "narrow peaks reduced" in data.attrs["design"]
    write_floor_products(tmp_path, source, rules(0.0))
    with xr.open_dataset(tmp_path / "products/floor_spectra.nc", engine="netcdf4") as data:
        assert data.sizes["design_frequency"] == F.size
        np.testing.assert_allclose(data["broadened"].values, data["raw"].values, rtol=1e-13)


def test_text_in_a_workbook_is_text(tmp_path):
    stations = tuple(
        Station(name, "1", ("p",))
        for name in ("a_very_long_name_of_a_building_1", "a_very_long_name_of_a_building_2")
    )
    spectra = FloorSpectrumSet(
        F, np.array([0.05]), stations, ("x",), np.ones((1, 1, 2, 1, F.size)), np.ones((1, 2, 1)),
        ("m",), "=1+1\x01", "method",
    )  # fmt: skip
    write_workbook(tmp_path / "book.xlsx", spectra.design())
    book = openpyxl.load_workbook(tmp_path / "book.xlsx")
    assert len({name.lower() for name in book.sheetnames}) == 3
    assert all(len(name) <= 31 for name in book.sheetnames)
    cell = book["contents"]["B1"]
    assert (cell.value, cell.data_type) == ("=1+1 ", "s")


def test_store_without_spectra_is_refused(tmp_path):
    write_netcdf(tmp_path / "other.nc", xr.Dataset({"a": ("b", [1.0])}))
    with pytest.raises(ImpactfemError, match=r"floor spectra.*psa"):
        write_floor_products(tmp_path, tmp_path / "other.nc", RULES)
    with pytest.raises(ImpactfemError, match="read floor spectra"):
        write_floor_products(tmp_path, tmp_path / "none.nc", RULES)
    (tmp_path / "text.nc").write_text("text", encoding="utf-8")
    with pytest.raises(ImpactfemError, match="read floor spectra"):
        write_floor_products(tmp_path, tmp_path / "text.nc", RULES)
    assert not (tmp_path / "products").exists()


def test_nothing_is_written_for_a_wrong_argument(tmp_path):
    source = store(tmp_path / "pounding.nc")
    with pytest.raises(ImpactfemError, match="at least 0"):
        write_floor_products(tmp_path, source, rules(2.0))
    assert not (tmp_path / "products").exists()
