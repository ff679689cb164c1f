"""The section [transient] of a case file, and its probes."""

from dataclasses import replace
from pathlib import Path

import pytest
from pydantic import ValidationError

from impactfem.building.mesh import parse_group
from impactfem.case import load_case
from impactfem.case.transient import Probe, Transient, transient_files

from .faults import all_faults, own_faults, refused
from .sections import EVERY_KEY, GROUP, LINE, OTHERS, POINT, RECORDED, TRANSIENT
from .texts import replaced

GEOMETRY = Path(__file__).parents[2] / "geometry"
OF_STICKS = '[pounding]\nduration = "16.79 s"\n'


def transient_of(path):
    transient = load_case(path).transient
    assert transient is not None
    return transient


def test_defaults(structured):
    transient = transient_of(structured(more=TRANSIENT))
    assert transient == Transient(time_step=1e-3)
    assert transient_files(transient) == ()


def test_every_key(structured, monkeypatch):
    path = structured(more=EVERY_KEY + POINT + LINE + GROUP, files=OTHERS)
    monkeypatch.chdir(path.parent.parent)
    case = load_case(Path(path.parent.name) / path.name)
    transient = case.transient
    forces = Path(path.parent.name) / "others.nc"  # relative to the working folder
    assert transient.forces == forces
    assert transient_files(transient) == (forces,)
    assert transient == Transient(
        solver="both",
        duration=10.0,
        time_step=1e-3,
        maximum_frequency=300.0,
        tolerance=0.01,
        shift=50.0,
        largest_basis=500,
        floors=(6, 7, 8),
        eccentricity=-2.0,
        forces=forces,
        fields=("psa",),
        field_frequencies=(10.0, 20.0),
        snapshots=False,
        export=True,
        export_nodes="all",
        export_start=1.0,
        export_duration=2.0,
        export_step=5e-3,
        checkpoint_every=0.5,
        probes=transient.probes,
    )
    assert [probe.name for probe in transient.probes] == ["corner", "row", "top"]


def test_points_of_probes(structured):
    corner, row, top = transient_of(structured(more=TRANSIENT + POINT + LINE + GROUP)).probes
    assert corner.points == (("corner", (0.0, 15.6, 30.3)),)
    assert [name for name, _ in row.points] == ["row_1", "row_2", "row_3", "row_4", "row_5"]
    assert [place for _, place in row.points] == [
        (0.0, 1.0, 3.0), (2.0, 1.0, 4.0), (4.0, 1.0, 5.0), (6.0, 1.0, 6.0), (8.0, 1.0, 7.0),
    ]  # fmt: skip
    assert (top.points, top.group, top.numbered(3)) == ((), "edge_8", "top_3")


def test_ends_of_a_line_are_met_exactly():
    probe = Probe.model_validate({"name": "a", "from": (0.1, 0, 0), "to": (46.2, 1, 0), "count": 9})
    assert (probe.points[0][1], probe.points[-1][1]) == ((0.1, 0.0, 0.0), (46.2, 1.0, 0.0))


def test_no_maps(structured):
    none = f"{TRANSIENT}fields = []\nfield_frequencies = []\n"
    transient = transient_of(structured(more=none))
    assert (transient.fields, transient.field_frequencies) == ((), ())


def test_with_a_structure_at_fault(structured):
    factor = "storey_stiffness_factor = 0"
    path = structured((None, f"{factor}.13", factor), more=TRANSIENT)
    assert list(own_faults(path)) == ["buildings[1].structure.storey_stiffness_factor"]


@pytest.mark.parametrize(
    ("section", "pounding", "fault"),
    [
        (TRANSIENT, "16.79 s", None),
        (f'{TRANSIENT}duration = "16.79 s"\n', "16.79 s", None),
        (f'{TRANSIENT}duration = "16.8 s"\n', "16.79 s",
         ("duration", "transient_times 16.79 s")),
        # Forces of another program may last longer than the sticks are computed.
        (f'{TRANSIENT}duration = "20 s"\nforces = "others.nc"\n', "16.79 s", None),
        (f'{TRANSIENT.replace("1 ms", "0.2 s")}forces = "others.nc"\n', "0.39 s", None),
        # That of the longest motion, where the sticks have none of their own.
        (f'{TRANSIENT}duration = "16.8 s"\n', None,
         ("duration", "transient_times 16.79 s")),
        (TRANSIENT.replace("1 ms", "0.2 s"), "0.4 s", None),
        (f'{TRANSIENT}export_start = "17 s"\n', "16.79 s", None),
        (f'{TRANSIENT}compression = "negative"\nforces = "others.nc"\n', "16.79 s", None),
        (f'{TRANSIENT}compression = "negative"\n', "16.79 s",
         ("compression", "of_given_forces")),
        (f'{TRANSIENT}export = true\nexport_start = "16.79 s"\n', "16.79 s",
         ("export_start", "transient_times 16.79 s")),
        (f'{TRANSIENT}export = true\nexport_start = "17 s"\nforces = "others.nc"\n', "16.79 s",
         None),
        (TRANSIENT.replace("1 ms", "0.2 s"), "0.39 s",
         ("time_step", "transient_times 0.39 s")),
    ],
)  # fmt: skip
def test_against_what_is_computed_of_the_sticks(structured, section, pounding, fault):
    new = "[pounding]\n" if pounding is None else f'[pounding]\nduration = "{pounding}"\n'
    path = structured((None, OF_STICKS, new), more=section, files=OTHERS)
    if fault is None:
        load_case(path)
    else:
        refused(path, f"transient.{fault[0]}", fault[1])


def test_a_record_s_duration_is_not_known_yet(written):
    base = replace(RECORDED, more=f'{TRANSIENT}duration = "1000 s"\n', structure=True)
    component = 'file = "motion.csv"\ncomponent = "NS"\n'
    path = written(
        base, (None, OF_STICKS, "[pounding]\n"), (None, 'file = "motion.csv"\n', component)
    )
    assert transient_of(path).duration == 1000.0


PLACE = 'offset = ["0 m", "7.8 m", "0 m"]'


def test_a_vertical_normal_and_a_spread_that_is_not_known(tmp_path):
    """Of a mesh from a file, whose sides are not known yet, both sides of a floor may be struck."""
    for file in GEOMETRY.glob("two_frames*"):
        (tmp_path / file.name).symlink_to(file)
    text = (GEOMETRY / "two_frames.toml").read_text(encoding="utf-8")
    path = tmp_path / "three.toml"
    path.write_text(text + OPPOSITE, encoding="utf-8")
    assert len(load_case(path).contacts) == 6
    vertical = replaced(text, ("normal = [0, 1, 0]", "normal = [0, 0, 1]"))
    path.write_text(vertical, encoding="utf-8")
    faults = own_faults(path)
    # Floors one above the other have to overlap in plan as well, which these do not.
    assert {f"contacts[{index}].normal" for index in range(5)} <= set(faults)
    assert all("horizontal normal" in faults[key] for key in faults if key.endswith("normal"))
    path.write_text(
        replaced(text, ("[transient]", '[transient]\nspread = "calibrated"')), encoding="utf-8"
    )
    refused(path, "transient.spread", "of_struck_sides floor")


OPPOSITE = """
[[buildings]]
name = "D"
material = "concrete"
floors = "two_frames_b_floors.csv"
axis = ["9 m", "-5.04 m"]
rigid_below = "0.675 m"
rigid_above = "0.125 m"
[[contacts]]
a = { building = "D", floor = 4, offset = ["0 m", "5 m", "0 m"] }
b = { building = "A", floor = 5, offset = ["0 m", "-6 m", "0 m"] }
normal = [0, 1, 0]
gap = "4 cm"
law = "column"
"""


@pytest.mark.parametrize(
    ("offset", "eccentricity", "good"),
    [("-20 m", "3 m", True), ("-20 m", "-3.1 m", True), ("-20 m", "-3.2 m", False)],
)
def test_forces_that_are_moved(structured, offset, eccentricity, good):
    """In addition to the offsets of their pairs, and not beyond the corners."""
    section = f'{TRANSIENT}eccentricity = "{eccentricity}"\n'
    moved = PLACE.replace('"0 m", "7', f'"{offset}", "7')
    path = structured((None, PLACE, moved), more=section)
    if good:
        load_case(path)
    else:
        refused(path, "transient.eccentricity", "of_struck_sides -3.1 to 43.1 m")


@pytest.fixture
def row(tmp_path):
    """Write a case that extends the one of three buildings in a row."""
    for file in GEOMETRY.glob("row_of_three*"):
        (tmp_path / file.name).symlink_to(file)

    def write(text):
        path = tmp_path / "row.toml"
        path.write_text(f'extends = "row_of_three_3d.toml"\n{text}', encoding="utf-8")
        return path

    return write


def test_pairs_moved_off_their_sides_are_one_fault(row):
    """The worst of them says how far all may be moved: those on y+ are 1 m beside the middle."""
    load_case(row('[transient]\neccentricity = "6.0 m"\n'))
    path = row('[transient]\neccentricity = "6.5 m"\n')
    refused(path, "transient.eccentricity", "of_struck_sides -8 to 6 m")


def test_a_building_without_a_3d_model_cannot_pound_in_3d(row):
    """Nor is that a fault of its neighbour, which is a stick beside a stick then."""
    load_case(row('[pounding]\nmodels = { B = "structure" }\n'))
    path = row('[pounding]\nmodels = { A = "structure" }\n')
    assert list(own_faults(path)) == ["pounding.models.A"]


@pytest.mark.parametrize(
    ("models", "key"),
    [
        ('{ Bee = "structure" }', "pounding.models.Bee"),
        ('{ A = "structure" }', "pounding.models.A"),
        ('{ B = "frame" }', "pounding.models.B"),
        ('{ B = "stick" }', "contacts[0].law"),
    ],
)
def test_a_wrong_model_is_no_fault_of_the_law(row, models, key):
    """That edges are unilateral is at fault where it is known that nothing pounds in 3D."""
    laws = "".join(f'[contact_laws.{k}]\ntype = "unilateral"\n' for k in ("slab", "column"))
    first, *others = all_faults(row(f"[pounding]\nmodels = {models}\n{laws}"))
    assert first.key == key
    assert not others or key == "contacts[0].law"


def test_without_the_3d_building_in_time_any_pair_will_do(structured):
    load_case(structured((None, PLACE, PLACE.replace('"0 m", "7', '"-15 m", "7'))))


def test_a_contact_inside_a_storey_of_the_3d_building(structured):
    """Of either building; whether walls take the force is known of the mesh."""
    inside = '"B2", storey = [1, 2, 3, 4, 5, 6, 7, 8], relative_height = 0.5'
    whole = '"B2", floor = [1, 2, 3, 4, 5, 6, 7, 8]'
    allowed = (None, "\ntitle = ", '\nallow = ["depth"]\ntitle = ')
    load_case(structured((None, whole, inside), allowed, more=TRANSIENT))


def test_probes_that_are_none(structured):
    for value, key in (("3", "transient.probes"), ("[3]", "transient.probes[0]")):
        faults = own_faults(structured(more=f"{TRANSIENT}probes = {value}\n"))
        assert list(faults) == [key] and "expected" in faults[key]


def test_group_names():
    for name in ("edge_8", "floor_8_parapet", "storey_12", "base", "centre_1"):
        assert Probe(name="a", group=name).group == name
        assert parse_group(name) is not None
    wrong = ("edge_0", "edge", "edge_8_a", "floor_8_", "floor_8_A", "floor_8__a", "base_1", "roof")
    for name in wrong:
        with pytest.raises(ValidationError, match="name of a physical"):
            Probe(name="a", group=name)
        assert parse_group(name) is None


def point(name):
    return Probe(name=name, point=(0.0, 0.0, 0.0))


def line(name, count=3):
    return Probe.model_validate(
        {"name": name, "from": (0.0, 0.0, 0.0), "to": (1.0, 0.0, 0.0), "count": count}
    )


def group(name):
    return Probe(name=name, group="edge_1")


UNIQUE = "expected unique names"
THERE = "are always there"


@pytest.mark.parametrize(
    ("probes", "expected"),
    [
        ((point("a"), point("b"), line("c"), group("d")), None),
        ((point("a"), point("a")), UNIQUE),
        ((point("a"), line("a")), UNIQUE),
        ((line("a"), group("a")), UNIQUE),
        ((line("a"), point("a_3")), UNIQUE),
        ((point("a_3"), line("a")), UNIQUE),
        ((line("a"), point("a_4")), None),  # it ends at a_3
        ((group("a"), point("a_4")), UNIQUE),  # it may have four nodes
        ((line("a"), point("a_03")), None),
        ((line("a"), line("a_1")), None),  # a_1_1
        ((line("a"), line("a_1"), point("a_1_2")), UNIQUE),
        ((point("centre_3"),), THERE),
        ((point("edge_8"),), THERE),
        ((point("line_12"),), THERE),
        ((point("line"), point("edge"), point("centre")), None),
        ((line("line"),), THERE),
        ((group("edge"),), THERE),
        ((point("edges_8"), point("my_edge_8"), point("edge_8_b"), point("Edge_8")), None),
    ],
)
def test_names_of_probes(probes, expected):
    if expected is None:
        assert Transient(time_step=1e-3, probes=probes).probes == probes
        return
    with pytest.raises(ValidationError, match=expected):
        Transient(time_step=1e-3, probes=probes)


def test_names_of_probes_in_a_file(structured):
    faults = own_faults(structured((None, '"row"', '"corner"'), more=TRANSIENT + POINT + LINE))
    expected = "corner expected unique names, found corner and corner"
    assert faults == {"transient.probes[1].name": expected}
    faults = own_faults(structured((None, '"corner"', '"edge_8"'), more=TRANSIENT + POINT))
    assert list(faults) == ["transient.probes[0].name"]
    assert load_case(structured(more=TRANSIENT + POINT + LINE)).transient.probes


@pytest.mark.parametrize("key", ["time_step", "maximum_frequency", "tolerance", "eccentricity"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_made_from_python(key, value):
    with pytest.raises(ValidationError, match="finite"):
        Transient.model_validate({"time_step": 1e-3, key: value})
