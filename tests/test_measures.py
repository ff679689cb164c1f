"""Measures of the sources and of the tests: sizes of functions, splats, asserts on sentences."""

import ast
import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
MOST = 150
"""Asserts on sentences in all tests; not more than this."""
WORDS = 4
"""Words of at least two letters from which on a text is a sentence."""
SENTENCES = {
    "cli/test_commands.py": "lines that the commands print",
    "cli/test_run.py": "lines that a run prints",
    "records/test_formats.py": "lines of headers of records, which are data",
    "stages/test_check.py": "the one function that writes the sentence of a check",
}
"""Files that may assert sentences, and the reason."""


SOURCES = TESTS.parent / "src" / "impactfem"
PARAMETERS, LINES = (8, 3), (80, 10)
"""Most parameters of a function and lines of it, and how many functions may have more."""
CAPTION = 40
"""Words of a caption, at most; a number with its unit, or a name, in place of a brace has two."""


def functions():
    """Each function of the sources with its place."""
    for path in sorted(SOURCES.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{path.relative_to(SOURCES)}:{node.name}", node


def parameters(function):
    """Number of its parameters, without the instance or the class."""
    given = function.args
    names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


def splats(tree):
    """Lines with a literal that is unpacked where it stands: f(*(a, b)), (*(a, b), *(c, d))."""
    for node in ast.walk(tree):
        given = node.args if isinstance(node, ast.Call) else getattr(node, "elts", ())
        for one in given:
            if isinstance(one, ast.Starred) and isinstance(one.value, ast.Tuple | ast.List):
                yield one.lineno


def test_functions_have_few_parameters():
    most, allowed = PARAMETERS
    found = [name for name, node in functions() if parameters(node) > most]
    assert len(found) <= allowed, found


def test_functions_are_short():
    most, allowed = LINES
    found = [name for name, node in functions() if node.end_lineno - node.lineno + 1 > most]
    assert len(found) <= allowed, found


def test_no_literal_is_unpacked_where_it_stands():
    found = {
        path.name: lines
        for path in SOURCES.rglob("*.py")
        if (lines := [*splats(ast.parse(path.read_text(encoding="utf-8")))])
    }
    assert found == {}


@pytest.mark.parametrize(
    ("line", "count"), [("f(*(a, b), c)", 1), ("x = (*(a, b), *[c])", 2), ("f(*a, *b())", 0)]
)
def test_splats(line, count):
    assert len([*splats(ast.parse(line))]) == count


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


def longest(node, notes):
    """The longest text of an expression; "a b" in place of a brace."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(longest(part, notes) for part in node.values)
    if isinstance(node, ast.FormattedValue):
        return longest(node.value, notes) or "a b"
    if isinstance(node, ast.IfExp):
        branches = (longest(branch, notes) for branch in (node.body, node.orelse))
        return max(branches, key=count_words)
    if isinstance(node, ast.BinOp):
        return longest(node.left, notes) + longest(node.right, notes)
    return notes.get(getattr(getattr(node, "func", None), "id", ""), "")


def count_words(text):
    return len(re.findall(r"\S*\w\S*", text))


def captions(tree, notes):
    """Name and longest caption of each function that sets one."""
    for function in (one for one in ast.walk(tree) if isinstance(one, ast.FunctionDef)):
        found = ""
        for node in ast.walk(function):
            targets = getattr(node, "targets", [getattr(node, "target", None)])
            if getattr(targets[0], "id", "") == "caption" and getattr(node, "value", None):
                text = longest(node.value, notes)
                more = isinstance(node, ast.AugAssign)
                found = f"{found} {text}" if more else max(found, text, key=count_words)
        if found:
            yield function.name, found


def test_captions_are_short():
    texts = [path.read_text("utf-8") for path in SOURCES.rglob("*.py")]
    trees = [ast.parse(text) for text in texts if "caption" in text or "_note(" in text]
    notes = {
        node.name: max((longest(r.value, {}) for r in returns), key=count_words)
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name.endswith("_note")
        if (returns := [r for r in ast.walk(node) if isinstance(r, ast.Return) and r.value])
    }
    every = [one for tree in trees for one in captions(tree, notes)]
    assert len(every) > 40
    long = {name: count_words(text) for name, text in every if count_words(text) > CAPTION}
    assert long == {}


@pytest.mark.parametrize(
    ("body", "count"),
    [
        ('caption = f"Force of {name} over time."', 6),
        ('caption = "One two" if x else "one"\n    caption += " three."', 3),
        ('caption = f"Force.{last_note(x)}"', 3),
        ('text = "no caption"', None),
    ],
)
def test_words_of_captions(body, count):
    found = dict(captions(ast.parse(f"def f():\n    {body}"), {"last_note": " and end"}))
    assert (count_words(found["f"]) if found else None) == count
