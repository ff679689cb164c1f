"""Cases against other programs and experiments."""

import shutil

import pytest

from impactfem.system.errors import InputError
from impactfem.system.files import in_source_tree
from impactfem.verify import manual, validation

FOLDER = in_source_tree(validation.FOLDER)
CASES = validation.cases()


@pytest.mark.parametrize("name", CASES)
def test_a_case(name):
    rows = CASES[name]()
    assert rows and CASES[name].__doc__
    assert [f"{row.quantity}: {row.computed}" for row in rows if not row.passed] == []


WRONG = {
    "opensees_kelvin_voigt": '[contact_laws.slab]\ntype = "kelvin-voigt"\nrestitution = 0.6501',
    "opensees_hertz_damp": '[contact_laws.slab]\ntype = "hertz-damp"\nrestitution = 0.66',
    "opensees_jankowski": '[contact_laws.slab]\ntype = "jankowski"\nrestitution = 0.6501',
    # A point of contact 1 cm off.
    "opensees_eccentric": "".join(
        (FOLDER / "opensees_eccentric.toml").read_text().partition("[[contacts]]")[1:]
    ).replace('["2 m",', '["2.01 m",'),
    "sdnd102": '[contact_laws.stop]\nstiffness = "2.4e7 N/m"',
    "sdnl104": '[contact_laws.spring]\nstiffness = "1.2e8 N/m"',
    "sdnl105": '[contact_laws.stop]\nstiffness = "4.8e7 N/m"',
}


@pytest.fixture
def variant(tmp_path):
    """Write a case over one of the folder, with a table of displacements of its own."""

    def write(name, changes, histories=None):
        path = tmp_path / f"{name}.toml"
        path.write_text(f'# A variant.\n\nextends = "{FOLDER / path.name}"\n{changes}\n')
        published = FOLDER / f"{name}_histories.csv"
        if published.exists():
            shutil.copy(published, tmp_path)
        if histories is not None:
            (tmp_path / published.name).write_text(histories)
        return path

    return write


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_contact_is_seen(variant, name):
    rows = validation.compared(variant(name, WRONG[name]))
    assert not all(row.passed for row in rows)


def test_displacements_that_cannot_be_compared(variant):
    head = "building,floor,component,time [s],displacement [m],tolerance [m],source\n"
    lines = ("W,20,y,0.1,0,1e-6,s", "N,21,y,0.1,0,1e-6,s", "N,20,y,0.2,0,1e-6,s")
    path = variant("sdnl104", "", head + "\n".join(lines))
    with pytest.raises(InputError) as refused:
        validation.compared(path)
    faults = [str(fault) for fault in refused.value.faults]
    assert len(faults) == 3 and all("sdnl104_histories.csv" in fault for fault in faults)
    assert "floor = 20" in faults[0] and "at most 0.16 s" in faults[2]


def test_nothing_to_compare(variant, tmp_path):
    path = variant("sdnl104", "")
    (tmp_path / "sdnl104_histories.csv").unlink()
    with pytest.raises(InputError, match="expected published results"):
        validation.compared(path)


def test_they_alone_are_run(tmp_path):
    rows = manual.verify("sdnl104", tmp_path / "rows.json", validation_cases=True)
    assert {row.name for row in rows} == {"sdnl104"}
    shown = [column.header for column in manual.as_table(rows, sources=True).columns]
    assert shown[-1] == "source"
    with pytest.raises(InputError, match=r"opensees_jankowski.*sdnl105$"):
        manual.verify("shock_on_wall", validation_cases=True)
