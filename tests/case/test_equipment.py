"""The equipment list of a case: its columns, its files, and its faults."""

import math

import pytest

from impactfem.case import load_case

from .faults import by_file
from .sections import Base

LIST = """\
tag,building,floor,x [m],y [m],mass [kg],mass_height [m],fx [Hz],ky [N/m],damping [%],anchors,\
spacing_x [m],spacing_y [m],bolt_area [mm2],tension [kN],shear [kN],required_spectrum,\
spectrum_damping [%]
MCC-1,B1,2,20,5,600,1,9,2e6,5,4,0.8,0.5,157,90.4,60.3,rrs.csv,5
PUMP-2,B2,1,20,20,900,0.5,,,,,,,,,,,
"""
RRS = "frequency [Hz],acceleration [m/s2]\n1,5\n10,50\n100,20\n"


def base(text=LIST, key="equipment"):
    """Return a case with an equipment list."""
    files = {"list.csv": text, "rrs.csv": RRS}
    named = (None, 'title = "', f'{key} = "list.csv"\ntitle = "')
    return Base(structure=False, files=files, edits=(named,))


@pytest.mark.parametrize("key", ["equipment", "devices"])
def test_list(written, key):
    first, second = load_case(written(base(key=key))).equipment
    assert first.frequencies[0] == 9.0
    assert first.frequencies[1] == pytest.approx(math.sqrt(2e6 / 600) / (2 * math.pi))
    assert first.frequencies[2] == math.inf
    assert first.bolts is not None
    corners = [(x, y) for x in (-0.4, 0.4) for y in (-0.25, 0.25)]
    assert sorted(first.bolts.places(0.0)) == corners
    assert first.spectrum is not None
    assert first.spectrum.file[0].acceleration == (5.0, 50.0, 20.0)
    assert second.frequencies == (math.inf,) * 3
    assert second.bolts is None


@pytest.mark.parametrize("absolute", [False, True])
def test_spectrum_is_beside_the_list(written, tmp_path, absolute):
    folder = tmp_path / "lists"
    folder.mkdir()
    (folder / "list.csv").write_text(LIST.replace("rrs.csv", "own.csv"))
    (folder / "own.csv").write_text(RRS)
    name = str(folder / "list.csv") if absolute else "lists/list.csv"
    first, _ = load_case(written(base(), (None, '"list.csv"', f'"{name}"'))).equipment
    assert first.spectrum is not None


def test_spectrum_is_part_of_the_case(written):
    one, other = (load_case(written(one)) for one in (base(), base()))
    assert one.digest == other.digest
    changed = base()
    changed.files["rrs.csv"] = RRS.replace("50", "60")
    assert load_case(written(changed)).digest != one.digest


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("PUMP-2", "MCC-1", "line 3, column tag"),
        ("B2,1", "B9,1", "line 3, column building"),
        ("B2,1", "B2,77", "line 3, column floor"),
        (",9,2e6,5,", ",9,2e6,,", "line 2, column damping [%]"),
        (",90.4,", ",,", "line 2, column tension [kN]"),
        ("4,0.8,0.5", "6,0.8,0.5", "line 2, column anchors"),
        ("4,0.8,0.5", "4,0.8,", "line 2, column circle"),
        ("rrs.csv,5", "rrs.csv,", "line 2, column spectrum_damping [%]"),
        ("rrs.csv,5", "none.csv,5", "line 2, column required_spectrum"),
        (",600,1,", ",-600,1,", "line 2, column mass [kg]"),
    ],
)
def test_faults(written, old, new, key):
    assert f"list.csv: {key}" in by_file(written(base(LIST.replace(old, new, 1))))


def test_fault_of_a_spectrum_is_that_of_its_file(written):
    broken = base()
    broken.files["rrs.csv"] = RRS.replace("50", "fifty")
    assert list(by_file(written(broken))) == ["rrs.csv: line 3, column acceleration [m/s2]"]


def test_item_off_its_floor(written):
    plan = (None, 'name = "B1"', 'name = "B1"\nlength = "46.2 m"\nwidth = "15.6 m"')
    assert len(load_case(written(base(), plan)).equipment) == 2
    off = base(LIST.replace("B1,2,20,5", "B1,2,80,5"))
    assert list(by_file(written(off, plan))) == ["pair.toml: equipment"]
