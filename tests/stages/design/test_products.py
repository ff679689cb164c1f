"""Design spectra of the 3D building: envelopes, broadening, statistics, and their tables."""

from dataclasses import replace

import numpy as np
import openpyxl
import pytest
import xarray as xr

from impactfem.spectra import broaden, fractile
from impactfem.stages.design.products import (
    EACH,
    coverage_table,
    design_products_of,
    member_table,
    vertex_table,
    write_design_products,
)
from impactfem.stages.design.stage import DESIGN, design_checks
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

from ..figure_file import draw_all, rows
from .design_store import F, WantedDesign, design_store, ensemble_store, probes_of

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


def test_envelope_broadened(made):
    products, own = made()
    design = products.case
    assert [s.floor for s in design.source.stations] == ["1", "2"]
    assert design.source.stations[1].points == (
        *("centre_2", "edge_2", "line_1"),
        *("1 vertex along x", "2 vertices along y", "1 vertex along z"),
    )
    raw = np.concatenate([own.probes(1, 1), own.upper(1)]).max(axis=0)
    wanted = broaden(F, raw, 0.15, design.frequency)
    np.testing.assert_allclose(design.psa[1, 1, 1], wanted, rtol=1e-12)
    # One point alone is lower, and so are the probes alone.
    for lower in (own.psa[1, 2, 1], own.probes(1, 1).max(axis=0)):
        alone = broaden(F, lower, 0.15, design.frequency)
        assert np.any(wanted > 1.1 * alone) and np.all(wanted >= alone)
    assert "no floor: tower" in design.source.method


def test_rotations(made):
    """Envelope over the probes of a floor whose rotations are known, and its unit."""
    products, _ = made()
    turned, probes = products.rotations, probes_of()
    assert turned.source.unit == "rad/s2" and products.case.source.unit == "m/s2"
    assert turned.source.directions == ("rx", "ry", "rz")
    assert [s.points for s in turned.source.stations] == [("centre_1",), ("centre_2", "line_1")]
    psa, pfa = probes["rotational_psa"].values, probes["rotational_pfa"].values
    raw = psa[1, 1:, 2].max(axis=0)
    assert np.array_equal(turned.raw[1, 1, 2], raw) and np.any(raw > psa[1, 1, 2])
    assert np.array_equal(turned.zpa, [pfa[0], pfa[1:].max(axis=0)])
    wanted = broaden(F, raw, 0.15, turned.frequency)
    np.testing.assert_allclose(turned.psa[1, 1, 2], wanted, rtol=1e-12)
    with pytest.raises(ImpactfemError, match="units of their"):
        replace(turned.source, directions=("x", "ry", "rz"))


def test_tables(made, tmp_path):
    products, _ = made()
    files = write_design_products(tmp_path, products)
    assert {path.name for path in files} == {
        *("design_spectra.csv", "design_peaks.csv", "design_ensemble.csv", "design_coverage.csv"),
        *("design_vertices.csv", "design_members.csv", "design_rotations.csv"),
        *(f"design_spectra.{ending}" for ending in ("xlsx", "nc")),
    }
    table = rows(tmp_path / "products" / "design_spectra.csv")
    design = products.case
    assert len(table) == 2 * 3 * 2 * design.frequency.size
    one = [r for r in table if (r["floor"], r["direction"], r["damping [-]"]) == ("2", "y", "0.02")]
    points = {"centre_2; edge_2; line_1; 2 vertices of tables/design_vertices.csv"}
    assert {r["points"] for r in one} == points
    assert "98 % of the envelope" in one[0]["method"]
    assert {r["unit of the accelerations"] for r in one} == {"m/s2"}
    assert "Regulatory Guide 1.122" in one[0]["method"] and one[0]["building"] == "B1"
    values = [float(r["for design [m/s2]"]) for r in one]
    np.testing.assert_allclose(values, design.psa[0, 1, 1], rtol=1e-5)
    assert all(r["for design, mass centre in the pounding [m/s2]"] for r in one)
    # The sticks have no x, the fields over the floors one damping.
    other = [r for r in table if (r["direction"], r["damping [-]"]) == ("x", "0.05")]
    assert not any(r["for design, mass centre in the pounding [m/s2]"] for r in other)
    assert not any(
        r["computed, all vertices of the floor, without samples between [m/s2]"] for r in other
    )


def test_statistics(made, tmp_path):
    products, _ = made()
    write_design_products(tmp_path, products)
    members = products.members
    assert members is not None and len(members.motions) == 5
    wanted = fractile(members.psa[:, 0, 1, 1], 0.84, "lognormal")
    np.testing.assert_allclose(products.statistics["p84_lognormal"].raw[0, 1, 1], wanted)
    table = rows(tmp_path / "products" / "design_ensemble.csv")
    assert {row["points"].split("; ")[-1] for row in table} == {EACH}
    assert all(row["method"].startswith(f"envelope of the probes and of {EACH}") for row in table)
    for row in table[:: len(table) // 50]:
        assert float(row["84 % fractile [m/s2]"]) >= float(row["median [m/s2]"])
    book = openpyxl.load_workbook(tmp_path / "products" / "design_spectra.xlsx")
    assert len(book.sheetnames) == 1 + 3 * 2


def test_peaks_name_their_point(made, tmp_path):
    products, own = made()
    write_design_products(tmp_path, products)
    row = next(
        r
        for r in rows(tmp_path / "products" / "design_peaks.csv")
        if (r["floor"], r["direction"], r["damping [-]"]) == ("2", "y", "0.02")
    )
    there = np.concatenate([own.probes(0, 1), own.upper(0)]).max(axis=1)
    names = ("centre_2", "edge_2", "line_1", "node 104", "node 106")
    assert row["point of the peak"] == names[int(there.argmax())]
    assert float(row["peak [m/s2]"]) == pytest.approx(there.max(), rel=1e-5)
    assert row["number of points"] == "5"


def test_without_ensemble_and_fields(made, tmp_path):
    products, _ = made(WantedDesign(motions=0, whole=None, still=True))
    files = write_design_products(tmp_path, products)
    assert sorted(path.name for path in files) == [
        *("design_peaks.csv", "design_rotations.csv"),
        *("design_spectra.csv", "design_spectra.nc", "design_spectra.xlsx"),
    ]
    assert products.case.source.directions == ("y", "z") and not products.statistics
    table = rows(tmp_path / "products" / "design_spectra.csv")
    assert all(row["method"].startswith("envelope of the PROBES ALONE") for row in table)
    book = openpyxl.load_workbook(tmp_path / "products" / "design_spectra.xlsx")
    text = " ".join(str(cell.value) for line in book["contents"].iter_rows() for cell in line)
    assert "PROBES ALONE" in text and "1 motion" in text


def test_coverage(made):
    products, own = made()
    table = coverage_table(products)
    assert len(table.rows) == 2 * 3
    row = table.rows[4]
    assert row[:7] == ("B1", "2", "y", 0.02, 3, 2, 60)
    probes, vertices = own.probes(0, 1).max(), own.upper(0).max()
    assert row[7] == pytest.approx(probes, rel=1e-5)
    assert row[8] == pytest.approx(max(probes, vertices), rel=1e-5)
    assert row[9] == pytest.approx(1.02 * vertices, rel=1e-5)
    assert row[11] == pytest.approx(1.0 / 1.02, rel=1e-5) and row[13] == row[11]


def test_vertices(made):
    products, own = made()
    table = vertex_table(products)
    assert len(table.rows) == 7
    assert table.rows[-1][:6] == ("B1", "2", "y", 106, 106.0, 0.0)
    others = np.maximum(own.psa[:, 2:5, 1].max(axis=1), own.vertex_psa[:, 4])
    largest = own.vertex_psa[:, 6] > others
    assert table.rows[-1][-1] == pytest.approx(largest.mean(), rel=1e-5) and largest.any()


def test_no_such_store(tmp_path):
    design_store(tmp_path / "design.nc")
    with pytest.raises(ImpactfemError, match="read floor spectra"):
        design_products_of(loaded(tmp_path), tmp_path / "pounding.nc", 0.15, False)


def loaded(folder):
    return xr.load_dataset(folder / "design.nc", engine="netcdf4")


def checks(folder, passed):
    return [check for check in design_checks(folder) if check.passed is passed]


def test_all_passed(tmp_path):
    design_store(tmp_path / "design.nc")
    ensemble_store(tmp_path / "ensemble.nc", loaded(tmp_path)["member_impact_force"].values)
    assert not checks(tmp_path, False)
    passed = checks(tmp_path, True)
    assert [check.id for check in passed] == [
        *["design.coverage"] * 3,
        "design.failed_motions",
        "design.force_difference",
    ]
    assert [check.place[:7] for check in passed[:3]] == [f"along {c}" for c in "xyz"]
    assert [check.value for check in passed[3:]] == [0.0, 0.0] and passed[3].place == "of 5"


def test_points_that_miss_the_floor(tmp_path):
    """The vertices that govern, too few of them, have two thirds of the envelope."""
    design_store(tmp_path / "design.nc", WantedDesign(motions=0, whole=1.5))
    missed = checks(tmp_path, False)
    assert len(missed) == 3
    assert (missed[1].value, missed[1].lower) == (pytest.approx(2.0 / 3.0), 0.95)
    assert "floor 1, floor 2" in missed[1].detail


def test_a_peak_acceleration_that_the_points_miss(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(motions=0))
    changed = loaded(tmp_path)
    changed["whole_zpa"][1, 2] *= 1.5
    write_netcdf(tmp_path / "design.nc", changed)
    (missed,) = checks(tmp_path, False)
    assert missed.place == "along z, floor 2, of the peak acceleration"


def test_without_fields(tmp_path):
    """The probes alone represent the floors: there is nothing to compare with."""
    design_store(tmp_path / "design.nc", WantedDesign(motions=0, whole=None))
    (missed,) = design_checks(tmp_path)
    assert (missed.id, missed.passed) == ("design.vertices", False)


def test_members_that_failed(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(failed=2))
    (missed,) = checks(tmp_path, False)
    assert (missed.id, missed.value, missed.place) == ("design.failed_motions", 2.0, "of 5")


@pytest.mark.parametrize("building", ["B1", "B2"])
def test_other_impact_forces_than_in_the_ensemble(tmp_path, building):
    """The check fails, unless the ensemble is of another building."""
    design_store(tmp_path / "design.nc")
    force = loaded(tmp_path)["member_impact_force"].values
    force[3, 1] *= 1.01
    ensemble_store(tmp_path / "ensemble.nc", force, building)
    found = [c for c in checks(tmp_path, False) if c.id == "design.force_difference"]
    assert len(found) == (building == "B1")
    assert all(check.value == pytest.approx(0.0099, rel=1e-2) for check in found)


@pytest.fixture
def drawn(made, tmp_path):
    """Draw all figures; gives the store and the names of the files."""

    def make(asked=None):
        products, _ = made(asked, (0.1, 0.15))
        files = draw_all(DESIGN.figures, tmp_path)
        assert all(path.stat().st_size > 10_000 for path in files)
        return products.store, {path.name for path in files}

    return make


def test_a_page_for_each_direction_and_damping(drawn):
    _, files = drawn(WantedDesign(still=True))
    assert files == {
        *("design_device_force.svg", "design_rotations.svg"),
        *(
            f"design_{kind}-{direction}_{damping}pct.svg"
            for kind in ("spectra", "ensemble")
            for direction in "yz"
            for damping in (2, 5)
        ),
    }


def test_no_page_of_an_ensemble_that_is_not_there(drawn):
    _, files = drawn(WantedDesign(motions=0))
    assert len(files) == 7 and not any("ensemble" in name or "force" in name for name in files)


@pytest.mark.parametrize("devices", [(), ("pump", "rack_1", "rack_2", "cabinet")])
def test_members(drawn, devices):
    store, files = drawn(WantedDesign(devices=devices, still=True))
    assert ("design_device_force.svg" in files) == bool(devices)
    table = member_table(store)
    assert len(table.rows) == 5 + 4 and len(table.columns) == 2 + 2 + 2 * len(devices)
    assert [row[0] for row in table.rows[-4:]] == [
        *("median", "mean", "84 % fractile", "lognormal 84 % fractile"),
    ]


def test_statistics_of_members(made):
    store = made()[0].store
    table = member_table(store)
    names = [name for name, _ in table.columns]
    column = names.index("Fy of pump, 3D model")
    force = store["member_device_force"].values[:, 0, 1]
    np.testing.assert_allclose([row[column] for row in table.rows[:5]], force, rtol=1e-5)
    assert table.rows[6][column] == pytest.approx(force.mean(), rel=1e-5)
    # A force that one member does not have has no logarithm.
    store["member_device_force"].values[2, 0, 1] = 0.0
    assert member_table(store).rows[-1][column] is None
