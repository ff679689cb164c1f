"""Measures of the tests themselves: how many of them assert sentences."""

import ast
import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
MOST = 271
"""Asserts on sentences in all tests; the number only falls, to 150."""
WORDS = 4
"""Words of at least two letters from which on a text is a sentence."""
SENTENCES = {
    "cli/test_commands.py": "lines that the commands print",
    "cli/test_run.py": "lines that a run prints",
    "records/test_formats.py": "lines of headers of records, which are data",
    "stages/test_check.py": "the one function that writes the sentence of a check",
}
"""Files that may assert sentences, and the reason."""


def texts(node):
    """Texts in an expression that a value is compared with; keys of subscripts are none."""
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, str) else []
    if isinstance(node, ast.JoinedStr):
        return ["".join(p.value if isinstance(p, ast.Constant) else "0" for p in node.values)]
    if isinstance(node, ast.Subscript):
        return []
    if isinstance(node, ast.Call):
        name = getattr(node.func, "attr", "")
        compared = node.args if name in ("count", "startswith", "endswith") else ()
        return [text for argument in compared for text in texts(argument)]
    return [text for child in ast.iter_child_nodes(node) for text in texts(child)]


def is_sentence(text):
    return len(re.findall(r"[^\W\d_]{2,}", text)) >= WORDS and text.strip().count(" ") >= WORDS - 1


def sentences(source):
    """Lines of a test file that assert a sentence, or expect one of an error."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Assert):
            compared = node.test
        elif isinstance(node, ast.keyword) and node.arg == "match":
            compared = node.value
        else:
            continue
        if any(map(is_sentence, texts(compared))):
            yield compared.lineno


def test_asserts_on_sentences():
    found = {
        name: list(sentences(path.read_text(encoding="utf-8")))
        for path in TESTS.rglob("test_*.py")
        if (name := path.relative_to(TESTS).as_posix()) not in SENTENCES
    }
    assert sum(map(len, found.values())) <= MOST, found


def test_declared_files_exist():
    assert all((TESTS / name).is_file() for name in SENTENCES)


@pytest.mark.parametrize(
    ("line", "count"),
    [
        ('assert "gap of 3 mm is too small" in text', 1),
        ('assert "gap" in text and value == 3', 0),
        ('assert row["point of the peak"] == 3', 0),
        ('assert text.startswith("the wall starts inside it")', 1),
        ('with raises(Error, match="the wall starts inside it"):\n    pass', 1),
        ('value = "the wall starts inside it"', 0),
    ],
)
def test_sentences(line, count):
    assert len(list(sentences(line))) == count
