"""The tables of the stage `transient`."""

import csv

import pytest

from impactfem.stages.transient.tables import transient_tables


def rows(path):
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_tables(transient_folder):
    folder = transient_folder()
    published = {"transient.wave_crossing": 0.006, "transient.wave_speed": 1250.0}
    probes, physics, sides, *densities = transient_tables(folder, published)
    assert [path.stem for path in densities] == [
        "transient_edge_density",
        "transient_force_density",
    ]
    struck = rows(sides)
    assert [row["side"] for row in struck] == ["floor 2", "floor 3"]
    assert [float(row["largest force [MN]"]) for row in struck] == pytest.approx([10.0, 20.0])
    found = {row["probe"]: row for row in rows(probes)}
    assert set(found) == {
        *(f"{kind}_{k}" for kind in ("centre", "edge") for k in (1, 2, 3)),
        *(f"line_{k}" for k in range(1, 6)),
        "corner",
    }
    row = found["edge_3"]
    assert float(row["band [m/s2]"]) == pytest.approx(0.02 * float(row["spectral peak [m/s2]"]))
    assert float(row["peak acceleration [m/s2]"]) == pytest.approx(50.0)
    assert float(row["largest displacement [cm]"]) == pytest.approx(1.0)
    assert (row["y [m]"], row["z [m]"]) == ("6.0", "12.0")
    numbers = {row["name"]: row for row in rows(physics)}
    crossing = numbers["transient.wave_crossing"]
    assert float(crossing["over published"]) == pytest.approx(0.5, rel=0.03)
    assert crossing["unit"] == "s"
    # Of the stage's own scalars those that are published.
    assert float(numbers["transient.wave_speed"]["over published"]) == 1.0
    assert "transient.plate_wave_speed" not in numbers
    assert "transient.loaded_wave_speed" not in numbers
    assert numbers["transient.psd_ratio"]["published"] == ""


def test_without_impact(transient_folder):
    probes, physics, edges = transient_tables(
        transient_folder(loads=(), solver="full", maps=False), {}
    )
    assert {row["band [m/s2]"] for row in rows(probes)} == {"0.0"}
    assert "transient.wave_crossing" not in {row["name"] for row in rows(physics)}
    assert edges.stem == "transient_edge_density"
