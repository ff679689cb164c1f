"""The program, run in this process or as one of its own."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from impactfem import cli

PROGRAM = Path(sys.executable).parent / "impactfem"


@dataclass(frozen=True)
class Ended:
    """How the program ended, and what it said."""

    code: int
    out: str
    err: str


@pytest.fixture
def program(monkeypatch, capsys):
    """Run the program in this process, from its entry point on."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["impactfem", *map(str, arguments)])
        monkeypatch.setattr(os, "_exit", sys.exit)  # how a signal ends it
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = end.code or 0
        found = capsys.readouterr()
        assert "Traceback" not in found.out + found.err
        return Ended(code, found.out, found.err)

    return run


@pytest.fixture(scope="session")
def process():
    """Run the program as a process of its own, in a pipe."""

    def run(*arguments, joined=False, **options):
        err = subprocess.STDOUT if joined else subprocess.PIPE
        ended = subprocess.run(
            [PROGRAM, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=err,
            check=False,
            **options,
        )
        return Ended(ended.returncode, ended.stdout.decode(), (ended.stderr or b"").decode())

    return run


@pytest.fixture(scope="session")
def names():
    """Names of all files below a folder."""

    def found(folder):
        return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))

    return found
