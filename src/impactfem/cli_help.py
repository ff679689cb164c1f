"""What the commands share: their list, the ends of help texts, the verdict on a file."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from typer.core import TyperGroup

from impactfem.system import log
from impactfem.system.errors import Fault, InputError


class Commands(TyperGroup):
    """The commands of the program; the error of an unknown one names the nearest."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that the words begin with; InputError where it is unknown."""
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            from impactfem.case.base import nearest

            known = [name for name, command in self.commands.items() if not command.hidden]
            expected = f"no such command; {nearest(args[0], known)}"
            raise InputError([Fault("command line", "COMMAND", args[0], expected)])
        return super().resolve_command(ctx, args)


def ends_with(example: str, codes: str = "") -> str:
    """The end of a help text: an example and exit codes; each paragraph keeps its lines."""
    shown = "\n".join(f"  {line}" for line in example.splitlines())
    return f"\b\nExample:\n{shown}" + (f"\n\n\b\nExit codes: {codes}" if codes else "")


def counted(count: int, noun: str) -> str:
    """The count with its noun: "1 warning", "2 warnings"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


class InvalidFileError(InputError):
    """The faults of a file, and a last line with the verdict on it."""

    def __init__(self, faults: Sequence[Fault], file: Path) -> None:
        super().__init__(faults)
        self.verdict = f"{file}: invalid, {counted(len(self.faults), 'error')}"


def verdict(file: Path, warnings: Sequence[str]) -> str:
    """The last line of a check of a valid file."""
    return f"{file}: valid" + (f", {counted(len(warnings), 'warning')}" if warnings else "")


@contextmanager
def judged(file: Path) -> Iterator[list[str]]:
    """Yield the warnings of a check; its errors end with the verdict on the file."""
    with log.collected_warnings() as warnings:
        try:
            yield warnings
        except InputError as error:
            raise InvalidFileError(error.faults, file) from error
