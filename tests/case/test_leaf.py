import math
import re
from pathlib import Path
from typing import Annotated

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from impactfem.case import base, leaf, load_case, quantity
from impactfem.case.model import CaseFile
from impactfem.case.place import key_fault, read_key
from impactfem.case.reading import Reading
from impactfem.case.source import Source
from one_building import building_of

FILE = Reading()  # the context of a case file, in which units must be stated


def read(kind, value):
    return TypeAdapter(kind).validate_python(value, context=FILE)


def refusal(kind, value):
    with pytest.raises(ValidationError) as caught:
        read(kind, value)
    error = caught.value.errors()[0]
    return error["type"], error["msg"]


ONE_OR_MORE = Annotated[int, leaf.Whole(1)]
LIST = leaf.FloorNumbers


@pytest.mark.parametrize(
    ("kind", "value", "read_as"),
    [
        (quantity.Length, "1 cm", 0.01),
        (quantity.Length, " -1.5e1mm ", -0.015),
        (quantity.Length, "+.5 m", 0.5),
        (quantity.Length, "0 m", 0.0),
        (quantity.Stress, "33 GPa", 33e9),
        (quantity.Acceleration, "0.2 g", 1.96133),
        (quantity.Rate, "0.838 1/s", 0.838),
        (quantity.Density, "2400 kg/m3", 2400.0),
        (quantity.Frequency, "0.5 kHz", 500.0),
        (quantity.Duration, "1e5 s", 1e5),
        (quantity.TimeStep, "1e-9 s", 1e-9),
        (quantity.ElementSize, "1 cm", 0.01),
        (quantity.Extent, "2000 m", 2000.0),
        *((quantity.DampingRatio, value, 0.05) for value in (0.05, "5 %", "5%")),
        (quantity.DampingRatio, 0, 0),
        (quantity.Number, -3, -3.0),
    ],
)
def test_numbers(kind, value, read_as):
    assert read(kind, value) == pytest.approx(read_as, rel=1e-15)


def test_what_is_held_as_it_is():
    assert read(quantity.Time, "0.3358 ms") == 0.3358e-3  # the nearest float
    assert read(Annotated[int, leaf.Whole(1, 1000)], 1000) == 1000
    assert (read(LIST, 8), read(LIST, [1, 2])) == ((8,), (1, 2))
    assert read(leaf.File, "./a/b.csv") == Path("a/b.csv")
    assert read(leaf.Name, "B" * 64) and read(leaf.Name, "CONSOLE") and read(leaf.Name, "lpt")


@pytest.mark.parametrize(
    ("kind", "values", "fault"),
    [
        (quantity.Length, (1, 0.5, "1"), "unit_missing"),
        (quantity.Length, ("1 s", "1 parsnip", "1,000.5 m"), "unit"),
        (quantity.Length, ("one cm", "nan m", "inf m", ""), "quantity"),
        (quantity.Length, (True, None, ["1 m"], {"value": 1}), "quantity"),
        (quantity.Length, ("1,5 cm",), "decimal_comma"),
        (quantity.Length, ("1e999 m",), "finite_number"),
        (quantity.Length, ("-1e61 m",), "greater_than_equal"),
        (quantity.PositiveLength, ("0 m",), "greater_than"),
        (quantity.Depth, ("-1 mm",), "greater_than_equal"),
        (quantity.Frequency, ("6.28 rad/s",), "unit"),
        (quantity.Duration, ("1e9 s",), "less_than_equal"),
        (quantity.TimeStep, ("1e-12 s",), "greater_than_equal"),
        (quantity.DampingRatio, ("0.05", "5 m", "x %", True, None), "quantity"),
        (quantity.DampingRatio, (math.nan, math.inf), "finite_number"),
        (quantity.DampingRatio, (1, "100 %"), "less_than"),
        (quantity.Number, ("5 %",), "quantity"),
        (ONE_OR_MORE, (0, -1), "greater_than_equal"),
        (ONE_OR_MORE, (1.5, 1.0, "1", True, None), "int_type"),
        (Annotated[int, leaf.Whole(1, 1000)], (1001,), "less_than_equal"),
        (Annotated[int, leaf.Whole(0)], (2**31,), "less_than_equal"),
        (LIST, ([],), "too_short"),
        (LIST, ([1.5], "1", True, [True], None), "int_type"),
        (leaf.Name, ("", "8th", "a b", "a/b", 3, None, "B1\n"), "text"),
        (leaf.Name, ("B" * 65,), "text_too_long"),
        (leaf.Name, ("CON", "lpt1"), "reserved"),
        (leaf.File, ("", "  ", "a\0b", 3), "file_name"),
    ],
)
def test_refused(kind, values, fault):
    for value in values:
        assert refusal(kind, value)[0] == fault, value


def test_from_python_floats_are_si():
    adapter = TypeAdapter(quantity.PositiveLength)
    assert adapter.validate_python(2.5) == 2.5
    assert adapter.validate_python("2.5 cm") == 0.025
    for value in (math.nan, math.inf, 0.0, 10**400):
        with pytest.raises(ValidationError):
            adapter.validate_python(value)


@given(
    st.floats(min_value=-1e30, max_value=1e30),
    st.sampled_from([("m", 1.0), ("km", 1e3), ("ft", 0.3048)]),
)
def test_round_trip(value, symbol):
    name, factor = symbol
    assert read(quantity.Length, f"{value!r} {name}") == pytest.approx(value * factor, rel=1e-15)


@settings(deadline=None, max_examples=50)
@given(st.text(max_size=30) | st.text("0123456789.eE+- /*^²kgmsNPat", max_size=12))
def test_any_text_is_read_or_refused(text):
    try:
        value = read(quantity.Length, text)
    except ValidationError as error:
        assert error.error_count() == 1
    else:
        assert math.isfinite(value)


@pytest.mark.parametrize("sign", ["\n", "\t", "\x1b", "\x7f", "\x85", "\u2028", "\u202e"])
def test_text_without_control_characters(sign):
    assert refusal(leaf.Text, f"a{sign}b")[0] == "control_character"
    assert refusal(leaf.File, f"a{sign}b")[0] == "file_name"
    if sign in "\n\t":
        assert read(leaf.Prose, f"a{sign}b") == f"a{sign}b"
    else:
        assert refusal(leaf.Prose, f"a{sign}b")[0] == "control_character"


def test_reference_names_the_nearest():
    adapter = TypeAdapter(leaf.LawName)
    laws = {"contact_laws": {"concrete": {}, "steel": {}}}
    known = Reading(Source(Path("case.toml"), laws))
    assert adapter.validate_python("steel", context=known) == "steel"
    with pytest.raises(ValidationError, match=r"mean 'concrete'\?"):
        adapter.validate_python("Concret", context=known)
    with pytest.raises(ValidationError, match="known: concrete, steel"):
        adapter.validate_python("timber", context=known)
    unknown = Reading(Source(Path("case.toml"), {"contact_laws": 3}))
    assert adapter.validate_python("timber", context=unknown) == "timber"


def test_nearest():
    meant = "did you mean 'gap'?"
    for name, words in (("gapp", meant), ("GAP", meant), ("zzz", "known: gap, law")):
        assert base.nearest(name, ["gap", "law"]) == words
    assert base.nearest("gap", []) == "none is defined"


def test_schema_pattern_agrees_with_the_reader():
    schema = TypeAdapter(quantity.Length).json_schema()
    for text in ("1 cm", "-1e-3m", "+.5 ft"):
        assert re.search(schema["pattern"], text)
    for text in ("1", "15", "1.5", "cm", ""):
        assert not re.search(schema["pattern"], text)
    assert schema["x-unit"] == "m"


RAW = {
    "damping": {"ratio": "5 %"},
    "materials": {"concrete": {"young_modulus": "30 GPa"}},
    "buildings": [{"name": "A"}, {"name": "B"}],
    "structure": {"mesh": {"type": "generated", "slab_thickness": "25 cm"}},
}


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("title", ("title",)),
        (" damping.ratio ", ("damping", "ratio")),
        ("buildings[0].stiffness_factor", ("buildings", 0, "stiffness_factor")),
        ("a[1][12].b-c", ("a", 1, 12, "b-c")),
        *((text, None) for text in ("", ".", "a.", "a..b", "[0]", "a[-1]", "a[x]", "a b", "a[0")),
        ("é", None),
    ],
)
def test_a_key(text, place):
    assert read_key(text) == place


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("damping.ratio", None),
        ("damping.frequencies", None),  # left to its default
        ("materials.concrete.density", None),
        ("buildings[1].stiffness_factor", None),
        ("structure.mesh.slab_thickness", None),
        ("wall_impact", None),
        ("dampin.ratio", "unknown key; did you mean 'damping'?"),
        ("damping.rato", r"unknown key; did you mean 'damping\.ratio'?"),
        ("materials.concret.density", r"unknown key; did you mean 'materials\.concrete'?"),
        ("materials.concrete.densit", r"did you mean 'materials\.concrete\.density'?"),
        ("structure.mesh.slab", "unknown key; known: type, "),
        ("buildings[2].name", "an index below 2"),
        ("buildings.name", r"an index: buildings\[0\]"),
        ("damping[0].ratio", "no index: damping is no list"),
        ("damping.ratio.x", "no key below damping.ratio"),
        ("limits.gap", None),
        ("wall_impact.gap", "a table or list wall_impact in this case; it has none"),
    ],
)
def test_keys_of_a_case(text, expected):
    fault = key_fault(read_key(text) or (), RAW, CaseFile)
    assert (fault is None) == (expected is None)
    assert fault is None or re.search(expected, fault)


GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def frames():
    return load_case(GEOMETRY / "two_frames.toml")


def turned(case, *normals):
    """The case with contacts along these normals only."""
    contacts = tuple(case.contacts[0].model_copy(update={"normal": n}) for n in normals)
    return case.model_copy(update={"contacts": contacts})


def test_results_are_given_along_the_pounding(frames):
    """The first motion is along x, the buildings pound along y."""
    assert [motion.direction for motion in frames.motions] == ["x", "y"]
    assert frames.shown_direction == "y"
    assert turned(frames, (-1.0, 0.0, 0.0)).shown_direction == "x"
    assert turned(frames, (0.6, 0.8, 0.0)).shown_direction == "y"


def test_without_a_motion_along_the_pounding_the_first_one_is_given(frames):
    assert turned(frames).shown_direction == "x"
    assert turned(frames, (0.0, 0.0, 1.0)).shown_direction == "x"
    alone = frames.model_copy(update={"motions": frames.motions[:1]})
    assert alone.shown_direction == "x"


def test_waves_are_evaluated_where_the_building_may_be_struck(frames):
    fewer = frames.model_copy(update={"contacts": frames.contacts[1:]})
    paper = load_case(GEOMETRY / "npp_pair.toml")
    cases = (frames, fewer, turned(frames), paper)
    assert [building_of(case).wave_floor for case in cases] == [5, 4, 6, 8]


def test_levels_that_no_building_has():
    """Numbers are compared before they are listed."""
    assert read(leaf.Storeys, "1-200") == tuple(range(1, 201))
    for text in ("1-201", "1-9999", "9999", "1 3 5-9999"):
        with pytest.raises(ValidationError, match="up to 200"):
            read(leaf.Storeys, text)


@pytest.mark.parametrize("name", ["..\base.AT2", "records\test.AT2", "records\rsn1.AT2"])
def test_a_backslash_that_became_a_control_character(name):
    with pytest.raises(ValidationError, match="control character: write"):
        read(leaf.File, name)


def test_a_path_as_windows_writes_it(tmp_path):
    reading = Reading(Source(tmp_path / "case.toml"))
    record = Annotated[Path, leaf.FileName("a record")]
    with pytest.raises(ValidationError, match=r"paths: .*/records/RSN1\.AT2"):
        TypeAdapter(record).validate_python(r"records\RSN1.AT2", context=reading)
