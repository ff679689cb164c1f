"""The page of the command line is that of the program."""

import typer.main

from docs._ext.command_line import command_page, main
from impactfem.cli import app

from .pages import ROOT

PAGE = ROOT / "docs" / "command-line.md"


def test_it_is_current():
    written = PAGE.read_text(encoding="utf-8")
    assert written == command_page(), "run: python docs/_ext/command_line.py docs"


def test_every_option_is_on_it():
    text = PAGE.read_text(encoding="utf-8")
    assert len(text.split()) <= 1200
    for name, command in typer.main.get_command(app).commands.items():
        part = text.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        options = [one for x in command.params for one in x.opts if one.startswith("--")]
        assert part and not [one for one in options if f"`{one}" not in part]
        assert f"\n    impactfem {name} " in part
    assert "--nothing" not in text


def test_usage(tmp_path, capsys):
    assert main([]) == 2 and main([str(tmp_path)]) == 0
    assert (tmp_path / "command-line.md").read_text(encoding="utf-8") == command_page()
    assert "usage" in capsys.readouterr().err
