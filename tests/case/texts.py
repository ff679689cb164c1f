"""Texts of case files."""


def replaced(text, *edits):
    """A text with some of it replaced: the old text, which must be there, and the new one."""
    for old, new in edits:
        if old not in text:
            raise ValueError(f"{old!r} is not there: the test does not test")
        text = text.replace(old, new)
    return text


def added(path, text):
    """Write a text at the end of a file."""
    with path.open("a", encoding="utf-8") as stream:
        stream.write(text)
    return path
