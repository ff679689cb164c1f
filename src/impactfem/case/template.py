"""A new case file to start from: complete, commented, and valid."""

import os
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from impactfem.case.base import nearest
from impactfem.system.errors import Fault, InputError


@dataclass(frozen=True)
class TemplatePart:
    """A part of the template that may be in use from the start."""

    adds: str  #: what it adds to the results
    seconds: int  #: estimated time of the whole case, by `impactfem check` [s]
    needs: tuple[str, ...] = ()  #: names of the parts that it needs


PARTS = {
    "structure": TemplatePart("3D model of one building, its modes", 17),
    "calibration": TemplatePart("sticks fitted to a table of frequencies", 8),
    "wall_impact": TemplatePart("stiffness and restitution from a 3D impact", 31, ("structure",)),
    "transient": TemplatePart("3D response, spectra at every point", 69, ("structure",)),
    "devices": TemplatePart("forces on the anchors of equipment", 79, ("transient",)),
    "damping_cases": TemplatePart("equipment with further dampings", 79, ("devices",)),
    "loads": TemplatePart("forces on floors in time", 8),
    "ensemble": TemplatePart("100 motions: percentiles", 47),
    "design": TemplatePart("design spectra over all motions", 110, ("transient", "ensemble")),
    "steel_frame": TemplatePart("beams and columns of rolled sections", 17, ("structure",)),
    "equipment": TemplatePart("list of equipment on floors, with capacities", 9),
    "contact_search": TemplatePart("contact pairs from plans and levels", 8),
    "record": TemplatePart("motion from a file, here of PEER", 8),
}
"""Parts of the template by name."""
EXCLUSIVE = (
    ({"steel_frame", "calibration"}, "the stick of the steel frame is that of its 3D model"),
    ({"record", "ensemble"}, "the ensemble has synthetic motions, or a folder of records"),
)
"""Parts that exclude each other, and why."""


def parts_list() -> str:
    """Return a line for each part: name, required parts, estimated time, and what it adds."""
    return "\n".join(
        f"{name:<14} {part.seconds:>4} s  {part.adds}"
        + (f"; needs {' and '.join(part.needs)}" if part.needs else "")
        for name, part in PARTS.items()
    )


HEAD = 5
"""Lines of the head of a short case."""
_COLUMN = 38  # where comments behind keys begin, if keys leave room
_COMMENTED = re.compile(r"(.*?\S) {2,}(# .*)")


def write_new_case(
    target: str | Path, parts: Sequence[str] = (), *, minimal: bool = False, short: bool = False
) -> list[Path]:
    """Write a commented case file and the tables that it names, and give their paths.

    The target is the name of the case, with or without ``.toml``, in a folder that exists, or an
    existing folder, which gets ``case.toml``.

    Args:
        target: Name of the case, or folder.
        parts: Some of `PARTS`, which stand in the file without a '#', with those that they need.
        minimal: Without comments, and without keys that may be left out.
        short: With comments, without keys that may be left out.

    Raises:
        InputError: A file is there already (nothing is overwritten), the name cannot be used, a
            part is unknown, two parts exclude each other, or the folder cannot be written to.
            Nothing is left behind then.
    """
    if unknown := [part for part in parts if part not in PARTS]:
        raise InputError(
            [
                Fault(
                    "command line",
                    "--with",
                    part,
                    f"{nearest(part, list(PARTS))}; impactfem new --help lists the parts",
                )
                for part in unknown
            ]
        )
    used = _with_needs(parts)
    for both, reason in EXCLUSIVE:
        if both <= used:
            value, expected = ",".join(sorted(both)), f"expected one of both: {reason}"
            raise InputError([Fault("command line", "--with", value, expected)])
    if str(target) == "":
        expected = "expected the name of a case; a folder gets 'case.toml', this one is '.'"
        raise InputError([Fault("command line", "NAME", "", expected)])
    target = Path(target)
    if os.path.isdir(target):  # noqa: PTH112 - false for a name that is too long, no OSError
        target = target / "case.toml"
    name = target.name.removesuffix(".toml")
    if re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name) is None:
        expected = "expected a name of letters, digits, '_', '-' and '.', for example 'my_case'"
        raise InputError([Fault(target, "", None, expected)])
    folder = target.parent
    if not os.path.isdir(folder):  # noqa: PTH112
        raise InputError([Fault(folder, "", None, "no such folder; make it first")])
    # The texts of the case file and of the tables that it names, by the names of the files.
    templates = files("impactfem.case") / "templates"
    template = (templates / "case.toml").read_text(encoding="utf-8")
    case = _composed(template, used, minimal)
    if short:
        case = _shortened(case)
    texts = {f"{name}.toml": case}
    for table in dict.fromkeys(re.findall(r'(?m)^[^#\n]*"@NAME@_(\w+\.\w+)"', case)):
        text = (templates / table).read_text(encoding="utf-8")
        texts[f"{name}_{table}"] = re.sub(r"(?m)^#.*\n", "", text) if minimal else text
    existing = [folder / file for file in texts if os.path.lexists(folder / file)]
    if existing:
        expected = "this file exists already and is not overwritten; choose another name"
        raise InputError([Fault(path, "", None, expected) for path in existing])
    written: list[Path] = []
    for file, text in texts.items():
        path = folder / file
        try:
            with path.open("x", encoding="utf-8") as stream:
                written.append(path)
                stream.write(text.replace("@NAME@", name))
        except OSError as error:
            for half in written:
                half.unlink(missing_ok=True)
            reason = error.strerror or str(error)
            raise InputError([Fault(path, "", None, f"cannot be written ({reason})")]) from error
    return written


def _with_needs(parts: Sequence[str]) -> set[str]:
    needed = {need for part in parts for need in PARTS[part].needs}
    return _with_needs([*parts, *needed]) if needed - set(parts) else set(parts)


def _shortened(case: str) -> str:
    """Leave out commented keys: of comments stay those behind a key and above a table in use."""
    head, *blocks = re.split(r"\n\n+", case.strip())
    kept = ["\n".join(head.splitlines()[:HEAD])]
    for block in blocks:
        lines = block.splitlines()
        used = [k for k, line in enumerate(lines) if not line.startswith("#")]
        if not used:
            continue
        above = lines[: used[0]] if lines[used[0]].startswith("[") else []
        rest = [lines[k] for k in used]
        kept.append("\n".join([*above, *rest]))
    return "\n\n".join(kept) + "\n"


def _composed(template: str, parts: Collection[str], minimal: bool) -> str:
    """The case file with the parts in use, the others behind a '#'."""
    # In the template '@PART' begins a block, which '@' ends. A key behind '?' is optional: it is
    # shown behind a '#'; behind '?PART' it is in use where the part is, behind '?!PART' where it
    # is not.
    lines: list[str] = []
    used = True
    for line in template.splitlines():
        if line.startswith("@"):
            used = line == "@" or line[1:] in parts
            continue
        if optional := re.match(r"\?(!?)(\w*) ", line):
            wanted = (optional[2] in parts) != bool(optional[1])
            shown, line = used and wanted, line[optional.end() :]
        else:
            shown = used
        line = line if shown or not line else f"# {line}"
        if commented := _COMMENTED.fullmatch(line):
            code, comment = commented.groups()
            padded = f"{code}   " if len(code) + 2 > _COLUMN else code.ljust(_COLUMN)
            line = code if minimal else padded + comment
        # Without comments there is one empty line between blocks, and none at the beginning.
        if not minimal or (line and line[0] != "#") or (not line and lines and lines[-1]):
            lines.append(line)
    return "\n".join(lines).rstrip() + "\n"
