"""What a stage declares of its outputs, and what later stages read."""

import importlib
import pkgutil

import numpy as np
import pytest
import xarray as xr

from impactfem import stages
from impactfem.plot.table import FACTORS
from impactfem.stages.stores import Output, dataset, number_of, open_store, stores_kept_open
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, scalars_of

OUTPUTS = {
    "probe": Output("probe"),
    "probe_floor": Output("probe", label=True),
    "pfa": Output("probe", "m/s2", "peak acceleration"),
    "factor": Output("", "-"),
}
VALUES = {"probe": ["centre_1", "centre_2"], "probe_floor": [1, 2], "pfa": [1.5, 2.5]}


def stored(path, values=VALUES):
    scalars = [Scalar("a", 1.0, "m")]
    attributes = {"title": "a case"}
    notes = {"pfa": "of the samples"}
    store = dataset(OUTPUTS, values, attributes=attributes, scalars=scalars, notes=notes)
    write_netcdf(path, store)
    return path


def test_labels_units_and_names(tmp_path):
    with open_store(stored(tmp_path / "a.nc")) as store:
        of_scalars = {"result", "result_unit", "result_note", "result_detail"}
        assert set(store.coords) == {"probe", "probe_floor"} | of_scalars
        about = {"units": "m/s2", "long_name": "peak acceleration", "note": "of the samples"}
        assert store["pfa"].attrs == about
        assert store.isel(probe=store["probe_floor"] == 2)["pfa"].values == [2.5]
        assert scalars_of(store) == [Scalar("a", 1.0, "m")] and store.attrs["title"] == "a case"


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({"pga": [1.0]}, "pga is no declared output"),
        ({"probe_floor": [1.5, 2.5]}, "probe_floor is declared without a unit"),
        ({"pfa": [1.0, 2.0, 3.0]}, "conflicting sizes"),
        ({"pfa": 1.0}, "dim"),
    ],
)
def test_what_is_not_as_declared(tmp_path, values, match):
    with pytest.raises(ValueError, match=match):
        stored(tmp_path / "a.nc", VALUES | values)


def test_nothing_of_words(tmp_path):
    path = stored(tmp_path / "a.nc", {"probe": [], "pfa": np.zeros(0)})
    with open_store(path) as store:
        assert store.sizes["probe"] == 0


def test_a_store_of_an_earlier_version(tmp_path):
    write_netcdf(tmp_path / "a.nc", xr.Dataset(attrs={"scalars": "[]"}))
    with (
        pytest.raises(ImpactfemError, match="another version"),
        open_store(tmp_path / "a.nc"),
    ):
        pass


def test_a_store_stays_open(tmp_path, monkeypatch):
    """Until the block ends, unless its file is written again; a fault stays a fault."""
    opened = []
    to_open = xr.open_dataset

    def noticed(path, **how):
        opened.append(path)
        return to_open(path, **how)

    monkeypatch.setattr(xr, "open_dataset", noticed)
    path = stored(tmp_path / "a.nc")
    with stores_kept_open():
        for _ in range(2):
            with open_store(path) as first:
                assert first["pfa"].values[1] == 2.5
        assert opened == [path]
        stored(path, VALUES | {"pfa": [1.5, 3.5]})
        with open_store(path) as second:
            assert second["pfa"].values[1] == 3.5
        assert opened == [path, path]
        with pytest.raises(ImpactfemError, match="cannot read"), open_store(tmp_path / "b.nc"):
            raise AssertionError
    with open_store(path):
        assert len(opened) == 4


def test_numbers_that_others_compute_with(tmp_path):
    path = stored(tmp_path / "a.nc", VALUES | {"factor": 0.4, "pfa": [np.nan, 2.5]})
    with open_store(path) as store:
        assert number_of(store, "factor") == 0.4
        assert number_of(store, "pfa", probe="centre_2") == 2.5
        for name, labels in (("pfa", {"probe": "centre_1"}), ("pfa", {"probe": "3"}), ("b", {})):
            with pytest.raises(ImpactfemError, match=rf"a\.nc has no {name}"):
                number_of(store, name, **labels)
    with pytest.raises(ImpactfemError, match="no factor"):
        number_of(xr.Dataset(), "factor")


@pytest.mark.parametrize("name", ["../../x", "a/../../x", ".."])
def test_a_name_that_leads_out_of_the_folder(tmp_path, name):
    """Names of figures are made of names in a store, which may come from somebody else."""
    path = tmp_path / "a.nc"
    for store in (
        xr.Dataset(coords={"device": ["pump", name]}),
        xr.Dataset(attrs={"building": name}),
    ):
        write_netcdf(path, store)
        with pytest.raises(ImpactfemError, match="another folder"), open_store(path):
            pass
    write_netcdf(path, xr.Dataset(coords={"device": ["pump", "a/b..c"]}))
    with open_store(path):
        pass


def test_every_shown_unit_has_a_factor():
    """A unit without one would leave the SI value under its heading."""
    stores = [
        importlib.import_module(module.name)
        for module in pkgutil.walk_packages(stages.__path__, f"{stages.__name__}.")
        if module.name.endswith(".store")
    ]
    declared = [one for store in stores for one in store.OUTPUTS.values()]
    units = {one.shown for one in declared} - {""}
    assert len(stores) > 8 and {"kN m", "mm"} <= units <= set(FACTORS)
