import json
import re
import tomllib
from pathlib import Path

import jsonschema
import pytest

from docs._ext.case_reference import json_schema, main, reference_page, schema_text
from impactfem.case import load_case
from impactfem.system.errors import InputError

from .faults import all_faults, check_fault

DOCS = Path(__file__).parents[2] / "docs"
GEOMETRY = Path(__file__).parents[2] / "geometry"


def properties(schema):
    for table in (schema, *schema["$defs"].values()):
        yield from table["properties"].items()


@pytest.mark.parametrize(
    ("name", "text"), [("case-file.md", reference_page), ("case.schema.json", schema_text)]
)
def test_committed_file_is_the_generated_one(name, text):
    committed = (DOCS / name).read_text(encoding="utf-8")
    assert committed == text(), "run: python docs/_ext/case_reference.py docs"


def test_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(json_schema())


def test_every_key_has_title_and_description():
    for key, entry in properties(json_schema()):
        assert entry["title"], key
        assert re.fullmatch(r"[^\n]{8,}\.", entry["description"]), key


def test_schema_says_only_what_toml_can():
    assert "null" not in schema_text()
    for key, entry in properties(json_schema()):
        if "default" in entry:
            schema = {k: v for k, v in entry.items() if k != "$ref"}
            jsonschema.validate(entry["default"], schema)
            assert entry["default"] is not None, key


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ('gap = "1 cm"', "gap = 0.01"),
        ('gap = "1 cm"', 'gap = "0.01"'),
        ('gap = "1 cm"', 'gapp = "1 cm"'),
        ("seed = 1\n", "seed = 1.5\n"),
        ("poisson_ratio = 0.2", "poisson_ratio = 0.5"),
        ('"implicit"', '"implicitly"'),
        ("[0, 1, 0]", "[0, 1]"),
    ],
)
def test_schema_agrees_with_the_loader(pair, old, new):
    text = pair.read_text(encoding="utf-8")
    raw = tomllib.loads(text.replace(old, new) if old else text)
    validator = jsonschema.Draft202012Validator(json_schema())
    assert validator.is_valid(raw) == (not old)


def test_the_paper_s_case_names_the_schema():
    line = (GEOMETRY / "npp_pair.toml").read_text(encoding="utf-8").splitlines()[0]
    path = (GEOMETRY / line.removeprefix("#:schema ")).resolve()
    assert path == (DOCS / "case.schema.json").resolve()


def test_a_table_is_named_by_its_own_key():
    """Also where the keys stand under another heading."""
    page = reference_page()
    assert "`a`</a>|table [`[contacts.a]`](#contactsa)<br>" in page
    assert "table `[contacts.b]`, with" in page


def test_page_has_every_key():
    page = reference_page()
    for key, _ in properties(json_schema()):
        assert f"`{key}`</a>|" in page
    anchors = re.findall(r'id="([^"]+)"', page)
    assert len(anchors) > 300 and len(set(anchors)) == len(anchors)


def test_written_by_the_command(tmp_path, capsys):
    assert main([str(tmp_path)]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2
    assert json.loads((tmp_path / "case.schema.json").read_text(encoding="utf-8")) == json_schema()
    assert main([]) == 2
    assert main([str(tmp_path / "none")]) == 2
    assert "usage" in capsys.readouterr().err


REFERENCE = """title = "A paper"
[[assumptions]]
text = "It is so."
reason = "Nothing is said."
[[items]]
kind = "figure"
number = "1"
title = "A curve"
shows = ["figures/figure_01*"]
[[items.values]]
name = "motion.pga"
tolerance = "5 %"
"""


@pytest.fixture
def with_reference(new_case, tmp_path):
    def write(text):
        path = new_case(tmp_path)
        path.write_text(path.read_text() + '\n[report]\nreference = "paper.toml"\n')
        if text is not None:
            (tmp_path / "paper.toml").write_text(text)
        return path

    return write


def test_a_reference(with_reference):
    report = load_case(with_reference(REFERENCE)).report
    (item,) = report.reference.items
    assert (item.kind, item.number, item.shows) == ("figure", "1", ("figures/figure_01*",))
    assert item.values[0].tolerance == pytest.approx(0.05)
    assert report.reference.assumptions[0].reason == "Nothing is said."
    assert (report.author, report.checker, report.revision) == (None, None, None)


def test_who_made_and_checked_it(edited, with_reference):
    path = with_reference(REFERENCE)
    named = 'reference = "paper.toml"\n'
    edited(path, (named, f'{named}author = "A. Ng"\nrevision = "B, 2 March 2026"\n'))
    report = load_case(path).report
    assert (report.author, report.checker, report.revision) == ("A. Ng", None, "B, 2 March 2026")
    edited(path, ('"A. Ng"', "3"))
    with pytest.raises(InputError, match=r"report\.author"):
        load_case(path)


def test_none(new_case, tmp_path):
    report = load_case(new_case(tmp_path)).report
    assert report.reference is None and report.assumptions == ()


def test_own_assumptions(new_case, tmp_path):
    path = new_case(tmp_path)
    path.write_text(path.read_text() + '\n[[report.assumptions]]\ntext = "a"\nreason = "b"\n')
    assert load_case(path).report.assumptions[0].text == "a"


def test_beside_published_values_that_are_no_file(with_reference):
    path = with_reference(REFERENCE.replace('"5 %"', '"-5 %"'))
    path.write_text(path.read_text().replace('"small_published.csv"', "3"))
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert [fault.key for fault in caught.value.faults] == [
        "published",
        "items[0].values[0].tolerance",
    ]


GIVEN = (
    REFERENCE
    + """
[[given]]
kind = "scaled"
names = ["motion.p*"]
reason = "The motion is scaled to it."
"""
)


def test_what_is_no_result_is_said_once_for_all_names(with_reference):
    case = load_case(with_reference(GIVEN))
    kinds = {name: one.kind for name, one in case.published.items()}
    assert kinds == {"motion.pga": "scaled", "frs.floor_3.pfa": "result"}
    assert case.report.reference.given[0].reason == "The motion is scaled to it."


def test_without_a_word_all_are_results(with_reference):
    case = load_case(with_reference(REFERENCE))
    assert {one.kind for one in case.published.values()} == {"result"}


@pytest.mark.parametrize(
    ("text", "key", "kind"),
    [
        (None, "report.reference", "unreadable"),
        ("title = ", "the end of the file", "toml"),
        (
            'title = "A case"\n[pounding]\n',
            "report.reference",
            "not_a_reference",
        ),
        (f"{REFERENCE}[damping]\n", "damping", "extra_forbidden"),
        (REFERENCE.replace('"figure"', '"picture"'), "kind", "literal_error"),
        (REFERENCE.replace('"5 %"', '"-5 %"'), "tolerance", "greater_than_equal 0"),
        (REFERENCE + REFERENCE[REFERENCE.index("[[items]]") :], "number", ""),
        (REFERENCE.replace("title", "titel", 1), "titel", "extra_forbidden 'title'"),
        (REFERENCE.replace('reason = "Nothing is said."', ""), "reason", "missing"),
        (GIVEN.replace('"scaled"', '"guessed"'), "given[0].kind", "literal_error"),
        (GIVEN.replace("motion.p*", "motions.p*"), "given[0].names[0]", ""),
        (GIVEN.replace('["motion.p*"]', "[]"), "given[0].names", "too_short"),
        (GIVEN.replace('reason = "The', 'cause = "The'), "given[0]", "missing"),
        (GIVEN.replace("motion.pga", "motion.pgaa"), "values[0].name", ""),
    ],
)
def test_what_is_wrong_with_it_is_reported(with_reference, text, key, kind):
    (found,) = [one for one in all_faults(with_reference(text)) if key in one.key][:1]
    check_fault([found], found.key, kind)


def test_a_value_of_two_kinds(with_reference):
    text = GIVEN + GIVEN[GIVEN.index("[[given]]") :].replace("scaled", "fitted", 1)
    with pytest.raises(InputError, match=r"expected motion\.pga"):
        load_case(with_reference(text))


FURTHER = """extends = "published/paper.toml"
[assumptions.so]
text = "It is otherwise."
[given.scaled]
names = ["frs.floor_3.pfa"]
[items."figure 1"]
tells = "Drawn anew."
[items."figure 1".values."motion.pga"]
reason = "Another motion."
"""


@pytest.fixture
def extended(with_reference, tmp_path):
    def write(text):
        (tmp_path / "published").mkdir(exist_ok=True)
        named = GIVEN.replace("[[assumptions]]", '[[assumptions]]\nname = "so"')
        (tmp_path / "published" / "paper.toml").write_text(named)
        return with_reference(text)

    return write


def test_one_that_extends_another(extended):
    found = load_case(extended(FURTHER)).report.reference
    (item,) = found.items
    (assumption,) = found.assumptions
    assert (assumption.text, assumption.reason) == ("It is otherwise.", "Nothing is said.")
    assert (item.title, item.tells) == ("A curve", "Drawn anew.")
    assert (item.values[0].tolerance, item.values[0].reason) == (0.05, "Another motion.")
    assert (found.given[0].kind, found.given[0].names) == ("scaled", ("frs.floor_3.pfa",))


def test_what_it_extends_is_part_of_the_case(extended, tmp_path):
    path = extended(FURTHER)
    before = load_case(path).content_hash()
    below = tmp_path / "published" / "paper.toml"
    below.write_text(below.read_text().replace("5 %", "6 %"))
    assert load_case(path).content_hash() != before


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ("published/", "", "source"),
        ("published/paper", "other", "file"),
        ("figure 1", "figure 2", "source 'figure 1'"),
        ("motion.pga", "motion.pgv", "source 'motion.pga'"),
        ("given.scaled", "given.fitted", "source"),
        ('reason = "Another', 'cause = "Another', "extra_forbidden"),
    ],
)
def test_what_is_wrong_where_it_extends(extended, old, new, kind):
    faults = all_faults(extended(FURTHER.replace(old, new)))
    assert all(Path(fault.file).name == "paper.toml" for fault in faults)
    check_fault(faults, faults[0].key, kind)


def test_the_building_from_printed_data_does_not_count_them():
    """Tables 2 and 3 are its data; what npp_pair.toml says of itself is not said of it."""
    case = load_case(GEOMETRY / "npp_pair_reread.toml")
    kinds = {name: one.kind for name, one in case.published.items()}
    data = [f"building.{of}.{k}" for of in ("frequency", "effective_mass") for k in (1, 2, 3)]
    assert {kinds[name] for name in data} == {"fitted"}
    assert kinds["transient.frs.floor_8.peak"] == "result"
    said = str(case.report.reference)
    assert "walls and columns" not in said and "spread evenly" not in said
    said = str(load_case(GEOMETRY / "npp_pair.toml").report.reference)
    assert "walls and columns" in said and "spread evenly" in said


@pytest.mark.parametrize(
    ("name", "of", "changes"),
    [
        ("npp_pair", "", ()),
        ("npp_pair_reread", "", ()),
        ("npp_pair_soil", "npp_pair.toml", ("buildings[0].soil", "buildings[1].soil")),
        (
            "npp_pair_both",
            "npp_pair.toml",
            ("buildings[1].structure", "wall_impact.building", "devices[0].building"),
        ),
        ("two_frames", "", ()),
    ],
)
def test_whose_reference_it_is(name, of, changes):
    """One that extends a case has its reference, which speaks of that case."""
    case = load_case(GEOMETRY / f"{name}.toml")
    assert (case.reference_of, case.changes) == (of, changes)
