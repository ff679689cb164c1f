"""The pages of docs/notebooks: each notebook with the outputs of a run.

python docs/_ext/render_notebooks.py               # all notebooks
python docs/_ext/render_notebooks.py first_steps   # one of them

The notebooks are run in their folder, as a user does; runs that exist in `runs/` are reused.
"""

import base64
import io
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jupytext
from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from PIL import Image

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "notebooks"
FILM = ROOT / "docs" / "figures" / "pounding.gif"
WIDTH, THUMBNAIL = 900, 320
"""Largest width of a picture, and width of a thumbnail [pixel]."""
COLOURS = 255
FIRST = {"film_of_both_buildings": 2, "read_a_run": 2, "own_building": 2}
"""Number of the picture in the thumbnail; the first one by default."""


class _ThisPython(KernelSpecManager):
    """A kernel in the Python that runs this file."""

    def get_kernel_spec(self, kernel_name: str) -> KernelSpec:
        argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        return KernelSpec(argv=argv, display_name="this Python", language="python")


def executed(path: Path) -> Any:
    """Return the notebook with its outputs."""
    notebook = jupytext.read(path, fmt="py:percent")
    with TemporaryDirectory(prefix="kernel") as folder:
        manager = AsyncKernelManager(
            kernel_spec_manager=_ThisPython(),
            transport="ipc",
            ip=f"{folder}/socket",
            connection_file=f"{folder}/connection.json",
        )
        place = {"metadata": {"path": str(path.parent)}}
        client = NotebookClient(notebook, km=manager, timeout=900, resources=place)
        client.execute(env={**os.environ, "IPYTHONDIR": folder}, cleanup_kc=True)
    return notebook


def page(name: str, notebook: Any) -> str:
    """Write the pictures of an executed notebook, and return its page."""
    for old in PAGES.glob(f"{name}_*.png"):
        old.unlink()
    parts = [f"<!-- Made by docs/_ext/render_notebooks.py from notebooks/{name}.py. -->"]
    count = 0
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for kind, content in _outputs(cell):
            if kind == "text":
                parts.append(f"```text\n{content}\n```")
            elif kind == "gif":
                parts.append(f"![Film of the main impact]({_film(name, content)})")
            else:
                count += 1
                file = PAGES / f"{name}_{count}.png"
                _write(content, file, WIDTH)
                if count == FIRST.get(name, 1):
                    _write(content, PAGES / f"{name}_thumbnail.png", THUMBNAIL)
                parts.append(f"![{name.replace('_', ' ')}, picture {count}]({file.name})")
    return "\n\n".join(parts) + "\n"


def _outputs(cell: Any) -> Iterator[tuple[str, Any]]:
    """Yield the kind and the content of the outputs of a cell; adjoining texts are one."""
    text = ""
    for output in cell.get("outputs", []):
        if output.output_type == "stream":
            text += output.text if output.name == "stdout" else ""
            continue
        data = output.get("data", {})
        images = [kind for kind in ("gif", "png") if f"image/{kind}" in data]
        if not images:
            text += data.get("text/plain", "") + "\n"
            continue
        if text.strip():
            yield "text", _tidy(text)
            text = ""
        yield images[0], base64.b64decode(data[f"image/{images[0]}"])
    if text.strip():
        yield "text", _tidy(text)


def _tidy(text: str) -> str:
    lines = [line.rstrip() for line in text.strip("\n").splitlines()]
    return re.sub(r"\n{2,}", "\n\n", "\n".join(lines).strip("\n"))


def _film(name: str, content: bytes) -> str:
    """Return the path of a film from the page; that of the first pages is kept once."""
    if FILM.is_file() and FILM.read_bytes() == content:
        return f"../figures/{FILM.name}"
    (PAGES / f"{name}.gif").write_bytes(content)
    return f"{name}.gif"


def _write(content: bytes, path: Path, width: int) -> None:
    with Image.open(io.BytesIO(content)) as opened:
        picture = opened.convert("RGB")
    if picture.width > width:
        height = round(picture.height * width / picture.width)
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def main(names: list[str]) -> None:
    """Run notebooks and write their pages."""
    PAGES.mkdir(exist_ok=True)
    for name in names or sorted(path.stem for path in (ROOT / "notebooks").glob("*.py")):
        text = page(name, executed(ROOT / "notebooks" / f"{name}.py"))
        (PAGES / f"{name}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
