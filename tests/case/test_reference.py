import json
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from docs._ext.case_reference import json_schema, main, reference_page, schema_text

DOCS = Path(__file__).parents[2] / "docs"
GEOMETRY = Path(__file__).parents[2] / "geometry"


def properties(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for table in (schema, *schema["$defs"].values()):
        yield from table["properties"].items()


@pytest.mark.parametrize(
    ("name", "text"), [("case-file.md", reference_page), ("case.schema.json", schema_text)]
)
def test_committed_file_is_the_generated_one(name: str, text: Callable[[], str]) -> None:
    committed = (DOCS / name).read_text(encoding="utf-8")
    assert committed == text(), "run: python docs/_ext/case_reference.py docs"


def test_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(json_schema())


def test_every_key_has_title_and_description() -> None:
    for key, entry in properties(json_schema()):
        assert entry["title"], key
        assert re.fullmatch(r"[^\n]{8,}\.", entry["description"]), key


def test_schema_says_only_what_toml_can() -> None:
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
def test_schema_agrees_with_the_loader(pair: Path, old: str, new: str) -> None:
    text = pair.read_text(encoding="utf-8")
    raw = tomllib.loads(text.replace(old, new) if old else text)
    validator = jsonschema.Draft202012Validator(json_schema())
    assert validator.is_valid(raw) == (not old)


def test_the_paper_s_case_names_the_schema() -> None:
    line = (GEOMETRY / "npp_pair.toml").read_text(encoding="utf-8").splitlines()[0]
    path = (GEOMETRY / line.removeprefix("#:schema ")).resolve()
    assert path == (DOCS / "case.schema.json").resolve()


def test_a_table_is_named_by_its_own_key() -> None:
    """Also where the keys stand under another heading."""
    page = reference_page()
    assert "`a`</a> | table [`[contacts.a]`](#contactsa)<br>" in page
    assert (
        "`b`</a> | table `[contacts.b]`, with the keys of [`[contacts.a]`](#contactsa)<br>" in page
    )


def test_page_has_every_key() -> None:
    page = reference_page()
    for key, _ in properties(json_schema()):
        assert f"`{key}`</a> |" in page
    anchors = re.findall(r'id="([^"]+)"', page)
    assert len(anchors) > 300 and len(set(anchors)) == len(anchors)


def test_written_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path)]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2
    assert json.loads((tmp_path / "case.schema.json").read_text(encoding="utf-8")) == json_schema()
    assert main([]) == 2
    assert main([str(tmp_path / "none")]) == 2
    assert "usage" in capsys.readouterr().err
