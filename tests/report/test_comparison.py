"""The comparison of two runs: their results in one table, and overlaid spectra."""

from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import xarray as xr

from impactfem.report.comparison import FIGURE, comparison_table, spectra_figure

SCALARS = {"checks.x": 2.0, "frs.largest": 5.0, "pounding.impacts": 0.0, "only.one": None}


def run(name, folder=None, **values):
    every = {k: v for k, v in (SCALARS | values).items() if v is not None}
    summary = [
        {"name": k, "value": v, "unit": "m/s2" if "frs" in k else "-"} for k, v in every.items()
    ]

    @contextmanager
    def store(file):
        with xr.open_dataset(folder / file, engine="netcdf4") as opened:
            yield opened

    has = lambda file: folder is not None and (folder / file).is_file()  # noqa: E731
    return SimpleNamespace(folder=Path(name), values=every, summary=summary, has=has, store=store)


def test_the_table():
    """Decisive results first; no ratio to zero or to a missing value."""
    table = comparison_table(run("a", **{"checks.x": 3.0}), run("b", **{"only.one": 7.0}))
    assert table.rows == (
        ("frs.largest", "m/s2", 5.0, 5.0, 1.0),
        ("pounding.impacts", "-", 0.0, 0.0, None),
        ("checks.x", "-", 3.0, 2.0, 1.5),
        ("only.one", "-", None, 7.0, None),
    )


def test_spectra_of_common_floors(transient_folder, tmp_path):
    """A panel for each common floor, with both runs up to the frequency."""
    (tmp_path / "other").mkdir()
    folders = [transient_folder(), tmp_path / "other"]
    store = xr.load_dataset(folders[0] / "transient.nc", engine="netcdf4")
    floors = store["probe_floor"].where(store["probe_kind"] == "centre").values
    store = store.isel(probe=floors != 3)
    store.to_netcdf(folders[1] / "transient.nc", engine="netcdf4")
    both = [run(name, folder) for name, folder in zip("ab", folders, strict=True)]
    (path,) = spectra_figure(tmp_path, *both, 100.0)
    assert path.stem == FIGURE
    assert path.read_text(encoding="utf-8").count("pseudo-acceleration") >= 1
    assert spectra_figure(tmp_path, both[0], run("c"), 100.0) == []
    store.assign_coords(damping=store["damping"] + 0.3).to_netcdf(folders[1] / "transient.nc")
    assert spectra_figure(tmp_path, *both, 100.0) == []
