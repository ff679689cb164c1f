"""Points of contact pairs that cannot meet are refused; doubtful ones get a warning."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.alignment import misalignments
from impactfem.case.plausibility import implausible
from impactfem.case.template import write_new_case
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"
B = '["0 m", "-6 m", "0 m"]'
A = '["0 m", "6 m", "0 m"]'


def turned(text):
    """The template with x and y exchanged in plan: the buildings stand in a row along x."""
    for name, axis in (("10", "6"), ("10", "18.02")):
        text = text.replace(f'axis = ["{name} m", "{axis} m"]', f'axis = ["{axis} m", "{name} m"]')
    for y in ("6", "-6"):
        text = text.replace(f'["0 m", "{y} m", "0 m"]', f'["{y} m", "0 m", "0 m"]')
    lines = []
    for line in text.splitlines():
        for one, other in (("length", "width"), ("width", "length")):
            if line.startswith(f"{one} = "):
                line = line.replace(one, other, 1)
                break
        lines.append(line)
    text = "\n".join(lines).replace("normal = [0, 1, 0]", "normal = [1, 0, 0]")
    return text.replace('direction = "y"', 'direction = "x"')


@pytest.fixture
def written(tmp_path):
    """The shortest case, its text changed by a function."""

    def write(change):
        path = write_new_case(tmp_path / "new", minimal=True)[0]
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
        return path

    return write


def outcome(path):
    """The keys of the faults of a case, and those of its warnings about contacts."""
    try:
        case = load_case(path)
    except InputError as error:
        return {fault.key for fault in error.faults}, set()
    found = implausible(case, 10.0)
    return set(), {fault.key for fault in found if fault.key.startswith("contacts")}


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(
    ("old", "new", "wrong", "doubtful"),
    [
        (B, B, set(), set()),
        (B, '["0.5 m", "-6 m", "0 m"]', set(), set()),
        (B, '["60 m", "-6 m", "0 m"]', {"contacts[0].b.offset"}, set()),
        (B, '["-30 m", "-6 m", "0 m"]', {"contacts[0].b.offset"}, set()),
        (A, '["60 m", "6 m", "0 m"]', {"contacts[0].a.offset"}, set()),
        (B, '["3 m", "-6 m", "0 m"]', set(), {"contacts[0]"}),
        # In height: beside the floor, and a little off its depth.
        (B, '["0 m", "-6 m", "20 m"]', {"contacts[0].b.offset"}, set()),
        (A, '["0 m", "6 m", "-3 m"]', {"contacts[0].a.offset"}, set()),
        (A, '["0 m", "6 m", "0.5 m"]', set(), {"contacts[0].a.offset"}),
        (A, '["0 m", "6 m", "-0.4 m"]', set(), set()),
        # The buildings pass each other, and stand a little aside.
        ('axis = ["10 m", "18.02 m"]', 'axis = ["80 m", "18.02 m"]', {"contacts[0]"}, set()),
        ('axis = ["10 m", "18.02 m"]', 'axis = ["13 m", "18.02 m"]', set(), {"contacts[0]"}),
    ],
)
def test_both_directions_across_the_normal(written, known, old, new, wrong, doubtful):
    def change(text):
        assert old in text
        lines = text.replace(old, new).splitlines()
        kept = [x for x in lines if known or not x.startswith(("length = ", "width = "))]
        return "\n".join(kept)

    assert outcome(written(change)) == (wrong, doubtful)


@pytest.mark.parametrize(
    ("new", "wrong"),
    [('["-6 m", "60 m", "0 m"]', {"contacts[0].b.offset"}), ('["-6 m", "0 m", "0 m"]', set())],
)
def test_a_row_along_x(written, new, wrong):
    path = written(lambda text: turned(text).replace('["-6 m", "0 m", "0 m"]', new))
    assert outcome(path)[0] == wrong


def test_the_offset_to_type_is_valid(written):
    """The value that the error names makes the case valid."""
    path = written(lambda text: text.replace(B, '["60 m", "-6 m", "0 m"]'))
    with pytest.raises(InputError) as caught:
        load_case(path)
    (fault,) = caught.value.faults
    assert fault.file == path and "60 m" in str(fault.value)
    typed = fault.expected.split("type ")[1].split("]")[0] + "]"
    path.write_text(path.read_text().replace('["60 m", "-6 m", "0 m"]', typed))
    assert outcome(path) == (set(), set())


def changed(case, name, **keys):
    """One pair of a case with another point b."""
    contacts = tuple(
        c.model_copy(update={"b": c.b.model_copy(update=keys)}) if c.name == name else c
        for c in case.contacts
    )
    (pair,) = [c for c in contacts if c.name == name]
    return list(misalignments(pair, case.model_copy(update={"contacts": contacts})))


@pytest.fixture(scope="module")
def row():
    return load_case(GEOMETRY / "row_of_three.toml")


def test_the_shipped_pairs_are_aligned(row):
    for case in (row, load_case(GEOMETRY / "two_frames.toml")):
        assert [one for pair in case.contacts for one in misalignments(pair, case)] == []


def test_points_of_storeys(row):
    """Along the façade, in height beside their storey, and at another height of it."""
    name = "B.floor_2-C.storey_2_at_0.5"
    assert changed(row, name, relative_height=0.49) == []
    for update in ({"relative_height": 0.9}, {"storey": 1}):
        assert [one.wrong for one in changed(row, name, **update)] == [True]
        allowed = row.model_copy(update={"allow": ("depth",)})
        assert [one.wrong for one in changed(allowed, name, **update)] == [False]
    assert any(one.wrong for one in changed(row, name, offset=(0.0, -6.0, 9.0)))
    (aside,) = changed(row, name, offset=(20.0, -6.0, 0.0))
    assert (aside.wrong, aside.side) == (True, "b")


def test_floors_off_level_by_a_metre(row):
    """Slabs and beams of half a metre: the message names the storey that the floor meets."""
    floors = [f.model_copy(update={"storey_height": 3.25}) for f in row.building("C").floors]
    buildings = tuple(
        b.model_copy(update={"floors": tuple(floors)}) if b.name == "C" else b
        for b in row.buildings
    )
    case = row.model_copy(update={"buildings": buildings})  # B.floor_4 at 12 m, C.floor_3 at 9.75
    (found,) = misalignments(next(c for c in case.contacts if "floor_4" in c.name), case)
    assert found.wrong and "depths" in found.text
    allowed = case.model_copy(update={"allow": ("depth",)})
    (found,) = misalignments(next(c for c in case.contacts if "floor_4" in c.name), allowed)
    assert not found.wrong
    higher = tuple(f.model_copy(update={"storey_height": 3.9}) for f in floors)
    buildings = tuple(
        b.model_copy(update={"floors": higher}) if b.name == "C" else b for b in row.buildings
    )
    case = row.model_copy(update={"buildings": buildings})  # 12 and 11.7 m: they overlap
    assert list(misalignments(next(c for c in case.contacts if "floor_4" in c.name), case)) == []
