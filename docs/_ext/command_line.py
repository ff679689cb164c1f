"""The page of the command line, made from the commands of the program.

``python docs/_ext/command_line.py docs`` writes ``docs/command-line.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer.main

from impactfem.cli import app

__all__ = ["command_page"]


def command_page() -> str:
    """The page in Markdown."""
    text = Path(__file__).with_name("command-line.md.in").read_text(encoding="utf-8")
    commands: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    sections = "".join("".join(_section(*entry)) for entry in commands.items())
    return text.replace("@commands@\n", sections)


def _section(name: str, command: Any) -> Iterator[str]:
    """The section of a command: usage, purpose, options, example."""
    places = [one for one in command.params if one.param_type_name == "argument"]
    words = [one.metavar if one.required else f"[{one.metavar}]" for one in places]
    yield f"## {name}\n\n`{' '.join(['impactfem', name, *words])}`\n\n"
    yield " ".join(str(command.help).split()) + "\n\n"
    rows = []
    for one in command.params:
        names = ", ".join((*one.opts, *one.secondary_opts))
        if one.param_type_name == "argument":
            names = one.metavar
        elif not one.is_flag:
            names += f" {one.metavar or 'N'}"
        default = ""
        if isinstance(one.default, int | float) and not isinstance(one.default, bool):
            default = f" Default: {one.default:g}."
        rows.append(f"| `{names}` | {_cell(one.help)}{default} |\n")
    yield f"| Argument or option | Meaning |\n|---|---|\n{''.join(rows)}\n"
    shown = str(command.epilog).replace("\b\n", "").partition("\n\n")[0]
    for line in shown.splitlines()[1:]:
        yield f"    {line.strip()}\n"
    yield "\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")


def main(arguments: list[str]) -> int:
    """Write the page into the folder that is the only argument."""
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        sys.stderr.write("usage: python docs/_ext/command_line.py FOLDER\n")
        return 2
    path = Path(arguments[0]) / "command-line.md"
    path.write_text(command_page(), encoding="utf-8")
    sys.stdout.write(f"{path}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
