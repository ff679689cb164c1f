"""What a screen reader or a keyboard would miss in a page, as far as its text shows it."""

import re
from collections import Counter
from html.parser import HTMLParser

VOID = {"meta", "img", "br", "link", "input", "hr", "source"}
HEADINGS = {f"h{level}" for level in range(1, 7)}
LABELLED = {"iframe": "title", "video": "aria-label", "nav": "aria-label"}
"""Elements that need a name, and which attribute gives it."""
LEAST = 4.5
"""Contrast of text to what is behind it: WCAG 2.2, 1.4.3."""
PAIRS = [(t, b) for t in ("ink", "soft", "good", "warn", "none", "link") for b in ("paper", "back")]


class Page(HTMLParser):
    """The tags of a page: what is open, which anchors, addresses and faults it has."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open = []
        self.ids = []
        self.links = []
        self.addresses = []
        self.words = []
        self.headings = []
        self.faults = []
        self._svg = False  # whether one is open that has no title yet
        self.feed(text)
        named = {link[1:] for link in self.links if link.startswith("#")}
        self.faults += [f"id {name} twice" for name, n in Counter(self.ids).items() if n > 1]
        self.faults += [f"no place {name}" for name in sorted(named - set(self.ids))]
        steps = zip([0, *self.headings], self.headings, strict=False)
        self.faults += [f"h{low} before h{high}" for low, high in steps if high > low + 1]

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.ids += [found["id"]] if "id" in found else []
        if tag == "a":
            self.links.append(found["href"])
        self.addresses += [found[k] for k in ("src", "poster") if k in found]
        self.addresses += [found["href"]] if tag == "link" else []
        if tag in HEADINGS:
            self.headings.append(int(tag[1]))
        if tag == "html" and not found.get("lang"):
            self.faults.append("no language")
        if tag == "img" and not found.get("alt"):
            self.faults.append("img without alt")
        if tag == "svg":
            self._svg = True
            if found.get("role") != "img":
                self.faults.append("svg without its role")
        if tag in LABELLED and not found.get(LABELLED[tag]):
            self.faults.append(f"{tag} without {LABELLED[tag]}")
        if tag == "th" and "scope" not in found:
            self.faults.append("th without scope")
        if found.get("tabindex") == "0" and not ("role" in found and found.get("aria-label")):
            self.faults.append("in the order of the keyboard without role and label")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag == "svg" and self._svg:
            self.faults.append("svg without a title")
            self._svg = False
        if self.open[-1] != tag:
            raise ValueError(f"</{tag}> closes <{self.open[-1]}>")
        self.open.pop()

    def handle_data(self, data):
        if self.open[-2:] == ["svg", "title"] and data.strip():
            self._svg = False
        if not {"script", "style"} & set(self.open):
            self.words.append(data.strip())


def schemes(css):
    """The colours of a style sheet by their names: light, dark and of paper."""
    light, *others = re.findall(r":root \{(.*?)\}", css, re.S)
    colours = {"light": dict(re.findall(r"--(\w+): (#\w{6})", light))}
    for name, text in zip(("dark", "paper"), others, strict=True):
        colours[name] = dict(re.findall(r"--(\w+): (#\w{6})", text))
    return colours


def contrast(one, other):
    """Contrast of two colours (WCAG 2.2)."""

    def luminance(colour):
        parts = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)
