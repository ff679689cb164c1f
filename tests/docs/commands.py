"""Shell lines of the documentation against the command line of the program."""

import importlib.util
import re
import shlex
from itertools import takewhile
from pathlib import Path

import typer.main

from impactfem.cli import app
from impactfem.study import stage_names
from impactfem.verify.manual import BENCHMARKS, FULL

from .pages import ROOT

PUNCTUATION = ";|&()<>"
FOLDERS = ("scripts", "geometry", "docs", "notebooks")
NAMES = {**BENCHMARKS, **FULL}
PROGRAM = typer.main.get_command(app)


def faults(text, *, whole=True):
    """What is wrong with lines of shell; arguments that are missing count where they are whole."""
    for line in text.replace("\\\n", " ").splitlines():
        lexer = shlex.shlex(line, posix=True, punctuation_chars=PUNCTUATION)
        lexer.whitespace_split = True
        try:
            words = list(lexer)
        except ValueError as error:
            yield f"{line.strip()}: {error}"
            continue
        for i, word in enumerate(words):
            ours = "/" in word and word.split("/")[0] in FOLDERS and "*" not in word
            if ours and not (ROOT / word).exists():
                yield f"there is no {word}"
            module = words[i - 1 : i] == ["-m"] and word.startswith("impactfem")
            if module and importlib.util.find_spec(word) is None:
                yield f"there is no module {word}"
            elif Path(word).name == "impactfem" and not module:
                yield from _of_program(
                    list(takewhile(lambda w: not set(w) <= set(PUNCTUATION), words[i + 1 :])), whole
                )


def _of_program(words, whole):
    """Faults of the words after `impactfem`."""
    options, rest = _split(PROGRAM, words, only_first=True)
    yield from options
    if not rest:
        return
    name, *rest = rest
    if name not in PROGRAM.commands:
        yield f"impactfem {name}: no such command"
        return
    command = PROGRAM.commands[name]
    options, rest = _split(command, rest)
    yield from options
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    most = sum(1e9 if p.nargs < 0 else p.nargs for p in arguments)
    surplus = [word for word in rest if not word.startswith("$")]
    if len(surplus) > most:
        yield f"impactfem {name}: an argument too many, {surplus[-1]}"
    if whole and len(rest) < sum(p.nargs for p in arguments if p.required):
        yield f"impactfem {name}: an argument is missing"


def _split(command, words, only_first=False):
    """Faults of the options of a command, and its other words."""
    known = {o: p for p in command.params for o in (*p.opts, *p.secondary_opts)} | {"--help": None}
    wrong, rest, ahead = [], [], list(words)
    while ahead:
        word = ahead.pop(0)
        option, _, value = word.partition("=")
        if word == "...":
            continue
        if not re.match(r"--?[a-z]", word):
            rest.append(word)
            if only_first:
                return wrong, rest + ahead
        elif option not in known:
            wrong.append(f"impactfem {command.name}: no option {option}")
        elif known[option] is not None and not known[option].is_flag:
            value = value or (ahead.pop(0) if ahead else "")
            if option == "--stage" and value.islower() and value not in stage_names():
                wrong.append(f"--stage {value}: no such stage")
            if option == "--only" and value.islower() and not any(value in n for n in NAMES):
                wrong.append(f"--only {value}: no benchmark has this in its name")
    return wrong, rest
