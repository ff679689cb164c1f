"""What the files of figures and tables are, whatever wrote them."""

import csv

from PIL import Image

from impactfem.plot.words import read_words


def assert_drawn(path, width, height):
    """Words, and of lines no more than a page can hold, of pixels a picture of such a size."""
    words = read_words(path)
    assert words.caption and words.seen
    if path.suffix == ".svg":
        assert 5_000 < path.stat().st_size < 250_000
        return
    with Image.open(path) as picture:
        assert 150 <= picture.width <= width and 100 <= picture.height <= height
        assert len(picture.convert("RGB").getcolors(maxcolors=10**6)) > 50


def rows(path):
    """The rows of a table, each by the heads of its columns."""
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))
