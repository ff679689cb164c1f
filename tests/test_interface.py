"""The public Python interface: one run, read, plotted, changed."""

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

import impactfem
from impactfem.system.errors import InputError

mpl.use("Agg")


@pytest.fixture
def opened(finished):
    with impactfem.open(str(finished.folder)) as run:
        yield run


def test_run_and_open_return_the_same_class(new_case, tmp_path):
    case = new_case(tmp_path)
    run = impactfem.run(str(case), out=str(tmp_path / "run"), stage="pounding", draw=False)
    again = impactfem.open(tmp_path / "run")
    assert type(run) is type(again)
    name = "pounding.main_impact_force"
    assert run.value(name) == again.value(name) > 0.0
    run.close()
    again.close()


@pytest.mark.parametrize(
    "call",
    [
        lambda path: impactfem.sweep(path, ["gap=1"]),
        lambda path: impactfem.fit(path, path),
        impactfem.make_report,
        lambda path: impactfem.compare_runs(path, path, 100.0),
    ],
)
def test_paths_may_be_texts(tmp_path, call):
    """A missing file is an input error for a text, too, and no AttributeError."""
    for path in (str(tmp_path / "absent"), tmp_path / "absent"):
        with pytest.raises(InputError, match="absent"):
            call(path)


def test_an_unknown_result_names_the_nearest(opened):
    with pytest.raises(InputError, match=r"pounding\.main_impact_force"):
        opened.value("pounding.main_impact_forse")


def test_repr_and_dataframe(opened):
    assert "impacts" in repr(opened) and "pounding" in repr(opened)
    frame = opened.to_dataframe()
    assert list(frame.columns) == ["value", "unit", "published", "note"]
    name = "pounding.main_impact_force"
    assert (frame.value[name], frame.unit[name]) == (opened.value(name), "N")


def test_a_floor_spectrum(opened):
    """With and without impact; above the resolved band it is hatched."""
    building, floor = opened.pounding["station"].values[-1].split(".floor_")
    axes = opened.plot.floor_spectrum(building, int(floor))
    lines = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    store = opened.pounding.isel(station=-1, damping=0).sel(
        direction=opened.pounding.attrs["shown_direction"]
    )
    np.testing.assert_array_equal(lines["with impact"], store["psa"])
    np.testing.assert_array_equal(lines["without impact"], store["psa_free"])
    with pytest.raises(InputError, match="station"):
        opened.plot.floor_spectrum(building, 77)
    with pytest.raises(InputError, match="damping"):
        opened.plot.floor_spectrum(building, int(floor), damping=0.77)


def test_a_gap(opened):
    """By default that of the pair with the largest required gap."""
    (line, contact) = opened.plot.gap().get_lines()
    pair = opened.pounding["pair_required_separation"].argmax("pair")
    np.testing.assert_allclose(line.get_ydata(), 1e3 * opened.pounding["gap"].isel(pair=pair))
    assert set(contact.get_ydata()) == {0.0}


def test_no_field_without_a_3d_model(opened):
    with pytest.raises(InputError, match="transient_maps"):
        opened.plot.building()


class TestChangedCase:
    def test_keys(self, new_case, tmp_path):
        path = new_case(tmp_path)
        before = path.read_bytes()
        case = impactfem.load(str(path))
        assert case.get("contacts[0].gap") == "2 cm"
        case.set("contacts[0].gap", "1 cm").set("allow", "gap").set("title", "narrow")
        assert (case.get("contacts[0].gap"), case.get("title")) == ("1 cm", "narrow")
        values = impactfem.check(case)
        assert (values.title, values.contacts[0].gap) == ("narrow", pytest.approx(0.01))
        assert path.read_bytes() == before

    def test_invalid_values_are_those_of_the_case_file(self, new_case, tmp_path):
        case = impactfem.load(new_case(tmp_path))
        case.set("contacts[0].gap", "1 kg")
        with pytest.raises(InputError) as error:
            case.check()
        (fault,) = error.value.faults
        assert (fault.file, fault.key) == (case.path, "contacts[0].gap")
        with pytest.raises(InputError, match="contacts"):
            case.set("contact[0].gap", "1 cm")

    def test_a_run(self, new_case, tmp_path):
        """The changed case is written beside the run folder, and runs again from there."""
        case = impactfem.load(new_case(tmp_path)).set("contacts[0].gap", "5 m")
        case.set("allow", "gap")
        with impactfem.run(case, out=tmp_path / "wide", stage="pounding", draw=False) as run:
            assert run.case["contacts"][0]["gap"] == pytest.approx(5.0)
        assert impactfem.check(tmp_path / "wide.toml").contacts[0].gap == pytest.approx(5.0)


def test_a_key_of_a_section_that_the_case_leaves_out(new_case, tmp_path):
    case = impactfem.load(new_case(tmp_path)).set("limits.gap", "asce7")
    written = impactfem.load(case.write(tmp_path / "with_limits.toml"))
    assert written.get("limits") == {"gap": "asce7"}


def test_the_names_of_packages_can_be_called():
    """`impactfem.run` is a package and a function, whatever was imported before."""
    text = "import impactfem.run.loop, impactfem; assert callable(impactfem.run); "
    text += "assert impactfem.run.loop.run; assert callable(impactfem.fit)"
    subprocess.run([sys.executable, "-c", text], check=True)


def test_the_import_loads_nothing_heavy():
    """The import must take less than 1.5 s on any machine: it loads none of these."""
    heavy = ("numpy", "xarray", "pandas", "matplotlib", "pydantic", "dolfinx", "pyvista")
    text = f"import sys, impactfem; print([n for n in {heavy!r} if n in sys.modules])"
    told = subprocess.run([sys.executable, "-c", text], check=True, capture_output=True, text=True)
    assert told.stdout.strip() == "[]"


@pytest.mark.parametrize("name", impactfem.__all__)
def test_public_names_are_documented(name):
    function = (
        getattr(impactfem.study, name) if name in ("run", "fit") else getattr(impactfem, name)
    )
    assert function.__doc__ and not function.__doc__.startswith(("What", "Whether", "As "))
