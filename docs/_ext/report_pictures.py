"""Pictures of the first page of reports for the documentation, with numbers.

    python docs/_ext/report_pictures.py runs/towers runs/towers_3d

The folders hold runs of `impactfem new towers` and of `impactfem new towers --with
structure,devices`. Needs Debian's chromium.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

FIGURES = Path(__file__).parents[1] / "figures"
COLOURS = 64
"""Colours of the pictures."""
MARKS = """
<style>nav { display: none; } main { margin: 0 auto !important; }
.mark-of-docs { position: absolute; z-index: 9; width: 27px; height: 27px;
  border-radius: 14px; background: #b3261e; color: #fff; font: bold 15px/27px sans-serif;
  text-align: center; }</style>
<script>
const marked = SELECTORS.map(one => document.querySelector(one)).filter(Boolean);
marked.forEach((part, k) => {
  const box = part.getBoundingClientRect(), mark = document.createElement("div");
  mark.className = "mark-of-docs";
  mark.textContent = k + 1;
  mark.style.left = `${Math.max(8, box.right + scrollX - 34)}px`;
  mark.style.top = `${box.top + scrollY + 4}px`;
  document.body.append(mark);
});
</script>
"""
ANSWERS = [f".answers > div:nth-child({k})" for k in range(1, 7)]
PICTURES = {
    "report_first_screen": (0, [], (1400, 760)),
    "report_annotated": (0, [*ANSWERS[:5], "#verdict h3", "#verdict figure"], (1060, 1150)),
    "report_annotated_3d": (1, [*ANSWERS, "#verdict h3", "#verdict figure"], (1060, 1440)),
}
"""Number of the run, what is numbered, and the size in pixels of each picture."""


def take(report: Path, selectors: list[str], size: tuple[int, int], into: Path) -> None:
    """Take a picture of the upper end of a report, with numbers beside some of its parts."""
    text = report.read_text(encoding="utf-8")
    # The page runs its own scripts only: a copy without this rule has numbers.
    policy = text.index('<meta http-equiv="Content-Security-Policy"')
    text = text[:policy] + text[text.index(">", policy) + 1 :]
    head, tail = text.rsplit("</body>", 1)
    marks = MARKS.replace("SELECTORS", repr(selectors)) if selectors else ""
    with tempfile.TemporaryDirectory() as folder:
        page, picture = Path(folder) / "page.html", Path(folder) / "page.png"
        page.write_text(f"{head}{marks}</body>{tail}", encoding="utf-8")
        width, height = size
        browser = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
        shot = [f"--window-size={width},{height}", f"--screenshot={picture}", page.as_uri()]
        subprocess.run([*browser, "--virtual-time-budget=3000", *shot], check=True)
        with Image.open(picture) as image:
            few = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
            few.save(into, optimize=True)


if __name__ == "__main__":
    runs = [Path(name) for name in sys.argv[1:3]]
    for name, (number, selectors, size) in PICTURES.items():
        take(runs[number] / "report.html", selectors, size, FIGURES / f"{name}.png")
