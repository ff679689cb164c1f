"""Contact pairs as tables of a case file."""

from collections.abc import Iterable, Iterator

from impactfem.case.contact_search import facing_floors, searched
from impactfem.case.contacts import ContactEnd, ContactEntry, ContactSearch
from impactfem.case.model import Case
from impactfem.system.errors import Fault, InputError


def contacts_text(case: Case) -> str:
    """Return the pairs that the contact search makes as tables to paste into the case file.

    Without [contact_search] in the case they have its first contact law. Pairs of [[contacts]] are
    in the file already.

    Raises:
        InputError: The case has no contact law, or a building without a plan.
    """
    search = case.contact_search
    if search is None:
        law = next(iter(case.contact_laws), None)
        if law is None:
            expected = 'expected a contact law: type [contact_laws.floor] with type = "hertz-damp"'
            raise InputError([Fault(case.path, "contact_laws", None, expected)])
        search = ContactSearch.model_construct(law=law)
    bare = case.model_copy(
        update={"contacts": tuple(one for one in case.contacts if one.place != "contact_search")}
    )
    if unknown := facing_floors(bare, search.buildings).unknown_lines:
        raise InputError([Fault(case.path, "buildings", None, line) for line in unknown])
    entries = searched(bare, search)
    if not entries:
        return "# All floors that face each other within the largest gap are in [[contacts]].\n"
    count = sum(entry.a.count for entry in entries)
    head = f"# {count} {'pair' if count == 1 else 'pairs'} of floors"
    head += "\n" if case.contact_search is None else "; they replace [contact_search]\n"
    return head + "\n".join(_table(entry) for entry in entries)


def _table(entry: ContactEntry) -> str:
    """Return a table of [[contacts]], with all digits."""
    lines = ["[[contacts]]"]
    lines += [f"{key} = {_end(end)}" for key, end in (("a", entry.a), ("b", entry.b)) if end]
    lines.append(f"normal = [{', '.join(_numbers(entry.normal))}]")
    lines += [f'gap = "{_number(entry.gap)} m"', f'law = "{entry.law}"']
    lines += [
        f'{key} = "{_number(value)} m"'
        for key, value in (("length", entry.length), ("depth", entry.depth))
        if value is not None
    ]
    lines += [] if entry.points is None else [f"points = {entry.points}"]
    lines += [] if entry.gap_slope == 0.0 else [f"gap_slope = {_number(entry.gap_slope)}"]
    return "\n".join(lines) + "\n"


def _end(end: ContactEnd) -> str:
    """Return an end of a pair as an inline table."""
    key, numbers = ("floor", end.floor) if end.floor else ("storey", end.storey or ())
    heights = [repr(one) for one in end.relative_height or ()]
    height = f", relative_height = {_list(heights)}" if heights else ""
    offset = ", ".join(f'"{text} m"' for text in _numbers(end.offset))
    where = f"{key} = {_list(list(map(str, numbers)))}{height}"
    return f'{{ building = "{end.building}", {where}, offset = [{offset}] }}'


def _list(texts: list[str]) -> str:
    """Return one value, or a list of several."""
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"


def _numbers(values: Iterable[float]) -> Iterator[str]:
    return map(_number, values)


def _number(value: float) -> str:
    """Return a number with all its digits, and without a point where it is whole."""
    return f"{value:.0f}" if value == round(value) else repr(value)
