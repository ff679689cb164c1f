"""`run.plot.building` on the stores of a small 3D building; pyvista has its own process."""

import json

import matplotlib as mpl
import numpy as np
import pytest

import impactfem
from impactfem.system.errors import InputError

mpl.use("Agg")


@pytest.fixture
def run(transient_folder):
    folder = transient_folder()
    (folder / "summary.json").write_text("[]")
    (folder / "case.json").write_text(json.dumps({"title": "", "structure": {"building": "one"}}))
    with impactfem.open(folder) as opened:
        yield opened


def test_a_field_is_drawn_in_colour(run):
    axes = run.plot.building("pfa")
    (picture,) = axes.get_images()
    pixels = np.asarray(picture.get_array(), dtype=float)[..., :3]
    assert np.ptp(pixels, axis=-1).max() > 30.0  # not grey alone
    (bar,) = [one for one in axes.figure.axes if one is not axes]
    assert bar.get_ylabel().endswith("[m/s²]")
    low, high = bar.get_ylim()
    values = run.maps["pfa"].sel(component=run.transient.attrs["shown_direction"])
    assert (low, high) == pytest.approx((float(values.min()), float(values.max())))


def test_the_ordinate_is_at_the_nearest_frequency(run):
    axes = run.plot.building("psa", frequency=19.0)
    at = float(run.maps["frequency"].sel(frequency=19.0, method="nearest"))
    assert f"{at:.3g} Hz" in axes.figure.axes[-1].get_ylabel()


@pytest.mark.parametrize(
    ("field", "wanted", "key"),
    [
        ("pga", {}, "field"),
        ("psa", {}, "frequency"),
        ("pfa", {"direction": "q"}, "direction"),
        ("pfa", {"building": "two"}, "structure.building"),
    ],
)
def test_an_unknown_field_is_an_error(run, field, wanted, key):
    with pytest.raises(InputError) as error:
        run.plot.building(field, **wanted)
    assert [fault.key for fault in error.value.faults] == [key]
