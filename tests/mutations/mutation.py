"""Faults put into a file by a seeded generator: a failure can be made again from its seed."""

import re
import warnings

from impactfem.system.errors import InputError

WORDS = (
    *("nan", "inf", "-1", "0", "1e999", "3 parsecs", "'", '"', "]", "=", "\x00", "é", "-", "1 cm"),
    *("1e308", "1e-320", "9" * 25, "1_0", "\u202e", "true", "{}"),
)
VALUES = (
    *("nan", "-inf", "-1", "0", "1e308", "true", "[]", "{}", "[[1],[2]]", '""', '"nan m"'),
    *('"1e999 m"', '"-3 kg"', '"1e300 Hz"', '"\\u0000"', "1979-05-27", "9" * 25, '["a","a"]'),
    *("{ a = 1 }", "[{}]", '"."', '"' + "x" * 5000 + '"', "[" * 300 + "]" * 300, '"*"', '"50 %"'),
)
NUMBERS = ("0", "-{}", "{}e300", "{}e-300", "nan", "inf", "abc", "", "{}{}", "{}e6", "1e400", ".")
UNITS = ("m", "cm", "kg", "Hz", "ms", "%", "GPa", "m/s2", "t", "-", "furlong", "N/m", "")
INSERTED = (
    *("unknown = 1", 'naem = "x"', "[surprise]", "a.b = 1", '"" = 2', "x,y,z"),
    *("[buildings.structure]", "[transient]", "[[devices]]", "[[motions]]"),
)
ENDS = ("\r", "\r\n", "\n\n", "\u2028")
ENCODINGS = ("utf-16", "latin-1", "utf-8-sig", "utf-32")
KINDS = (
    *("drop", "double", "word", "cut", "swap", "digit", "key", "end", "shuffle", "section"),
    *("value", "value", "number", "number", "unit", "unit", "insert", "separator"),
    *("less", "twice", "turned", "long", "nul", "empty", "ends", "encoding", "bytes"),
)


def mutated(rng, content):
    """The content of a file with faults; it may still be a good one."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        try:
            text = content.decode("utf-8")
        except UnicodeDecodeError:
            content = flipped(rng, content)
        else:
            content = _written(rng, text)
    return content


def flipped(rng, content):
    """The content of a binary file, cut or with other bytes in it."""
    if not content:
        return b"\x00"
    at, size = rng.randrange(len(content)), rng.randrange(1, 100)
    noise = bytes(rng.randrange(256) for _ in range(size))
    return rng.choice(
        (
            content[:at],
            content[at:],
            content[:at] + bytes([content[at] ^ (1 << rng.randrange(8))]) + content[at + 1 :],
            content[:at] + noise + content[at + size :],
            content[:at] + bytes(size) + content[at + size :],
            content[:at] + content[at + size :],
            content[:at] + noise + content[at:],
        )
    )


def _written(rng, text):
    kind = rng.choice(KINDS)
    lines = text.split("\n")
    live = [k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    k = rng.choice(live or [0])
    line, other = lines[k], rng.randrange(len(lines))
    i = rng.randrange(len(line) + 1)
    if kind == "drop":
        del lines[k]
    elif kind == "double":
        lines.insert(other, line)
    elif kind == "swap":
        lines[k], lines[other] = lines[other], line
    elif kind == "shuffle":
        rng.shuffle(lines)
    elif kind == "insert":
        lines.insert(k, rng.choice(INSERTED))
    elif kind == "end":
        lines = lines[:k]
    elif kind == "empty":
        lines = [rng.choice(("", " ", "#"))]
    elif kind == "section":
        starts = [s for s in live if lines[s].startswith("[")] or [k]
        start = rng.choice(starts)
        del lines[start : min((s for s in starts if s > start), default=start + 3)]
    else:
        lines[k] = {
            "word": lambda: _word(rng, line),
            "cut": lambda: line[: len(line) // 2],
            "digit": lambda: "".join(
                rng.choice("0123456789-.eE") if c.isdigit() and rng.random() < 0.4 else c
                for c in line
            ),
            "key": lambda: line.replace("e", "", 1),
            "value": lambda: f"{line.partition('=')[0]}= {rng.choice(VALUES)}",
            "number": lambda: _number(rng, line),
            "unit": lambda: re.sub(r"(?<=\d )[A-Za-z%/\d]+|(?<=\[)[^\]]+", rng.choice(UNITS), line),
            "separator": lambda: line.replace(",", rng.choice((";", "\t", ",,", " "))),
            "less": lambda: line[:i] + line[i + 1 :],
            "twice": lambda: line[:i] + line[i : i + 1] + line[i:],
            "turned": lambda: line[:i] + line[i + 1 : i + 2] + line[i : i + 1] + line[i + 2 :],
            "long": lambda: line + "x" * 100_000,
            "nul": lambda: line + "\0",
        }.get(kind, lambda: line)()
    text = "\n".join(lines)
    if kind == "ends":
        text = text.replace("\n", rng.choice(ENDS))
    if kind == "encoding":
        return text.encode(rng.choice(ENCODINGS), errors="replace")
    content = text.encode()
    return flipped(rng, content) if kind == "bytes" else content


def _word(rng, line):
    separator = "," if "," in line else " "
    parts = line.split(separator)
    parts[rng.randrange(len(parts))] = rng.choice(WORDS)
    return separator.join(parts)


def _number(rng, line):
    found = list(re.finditer(r"\d+\.?\d*", line))
    if not found:
        return line
    match = rng.choice(found)
    new = rng.choice(NUMBERS).replace("{}", match[0])
    return line[: match.start()] + new + line[match.end() :]


LONGEST = 700  # letters of a line that a person reads


def outcome(action, folder, kind):
    """Run an action on a damaged input: "good", or "refused" by an error of a kind.

    AssertionError where it ended in anything else: the files of the folder, which holds the input,
    must be the same afterwards, and refusals name it.
    """
    before = sorted(folder.rglob("*"))
    found = "good"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "`product` is deprecated", DeprecationWarning)
            action()
    except kind as error:
        found = "refused"
        lines = [str(f) for f in error.faults] if isinstance(error, InputError) else [str(error)]
        assert lines and any(str(folder) in line for line in lines), lines
        assert all(len(line) < LONGEST and "\n" not in line for line in lines), lines
        assert not any("Traceback" in line for line in lines), lines
    except Exception as error:
        raise AssertionError(f"a raw {type(error).__name__}: {error}") from error
    assert sorted(folder.rglob("*")) == before, "something was written"
    return found
