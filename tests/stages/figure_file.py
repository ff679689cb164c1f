"""What a figure's file is, whatever drew it."""

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
