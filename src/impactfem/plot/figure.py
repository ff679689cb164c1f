"""The declaration of a figure: its name, its section and heading in the report, its data.

A function under `figure` is a figure of the stage in whose modules it stands. Its parameters name
the data that it needs; `path` is the file for a function that writes it. File name, order, heading
and the choice of figures follow from the declaration.
"""

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from types import ModuleType
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

BETWEEN = "-"
"""Sign between the name of a figure and its subject in the name of a file; no name has it."""


@dataclass(frozen=True, eq=False)
class Figure:
    """A declared figure, or one for each subject such as a device."""

    name: str  #: in the names of files, and in `[report] figures`
    section: str  #: heading of its group in the report
    title: str  #: its heading
    #: Returns curves, or writes its parameter `path`.
    function: Callable[..., Any]
    when: Callable[..., Any] | None  #: condition, of the same data; None for none
    each: str  #: name of the data that lists its subjects; "" for one figure
    #: Whether it is drawn without a request; of several subjects, the name of the data with those.
    default: bool | str
    ending: str  #: of the file: "svg" for lines, "png" for fields
    in_3d: bool  #: whether VTK draws it, which must not share a process with dolfinx

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the function alone: a condition may be a lambda."""
        return attrgetter("declared"), (self.function,)

    @property
    def writes(self) -> bool:
        """Whether the function writes its file."""
        return "path" in self.needs

    def file(self, subject: str = "") -> str:
        """Return the name of the file of a subject."""
        return f"{self.name}{BETWEEN * bool(subject)}{subject}.{self.ending}"

    def subjects(self, data: object) -> Iterator[tuple[str, bool]]:
        """Yield each subject, "" for the only one, and whether it is drawn without a request."""
        chosen = getattr(data, self.default) if isinstance(self.default, str) else None
        for subject in getattr(data, self.each) if self.each else ("",):
            yield subject, self.default is True if chosen is None else subject in chosen

    @property
    def needs(self) -> tuple[str, ...]:
        """Names of the parameters of its function."""
        return tuple(inspect.signature(self.function).parameters)

    def arguments(self, data: object, subject: str) -> dict[str, Any] | None:
        """Return the data of the function; None if some are missing, or the condition is false."""

        def taken(function: Callable[..., Any]) -> dict[str, Any]:
            names = inspect.signature(function).parameters.keys() - {"path"}
            return {name: subject if name == self.each else getattr(data, name) for name in names}

        values = taken(self.function)
        if any(value is None for value in values.values()):
            return None
        if self.when is not None and not self.when(**taken(self.when)):
            return None
        return values


def figure(
    name: str,
    section: str,
    title: str,
    *,
    when: Callable[..., Any] | None = None,
    each: str = "",
    default: bool | str = True,
    ending: str = "svg",
    in_3d: bool = False,
) -> Callable[[Function], Function]:
    """Declare a function as a figure; arguments as the fields of `Figure`."""

    def declare(function: Function) -> Function:
        declared = Figure(name, section, title, function, when, each, default, ending, in_3d)
        vars(function)["declared"] = declared
        return function

    return declare


def declared(*modules: ModuleType) -> tuple[Figure, ...]:
    """Return the figures of modules, in the order in which they stand there."""
    return tuple(
        value.declared
        for module in modules
        for value in vars(module).values()
        if hasattr(value, "declared") and value.__module__ == module.__name__
    )
