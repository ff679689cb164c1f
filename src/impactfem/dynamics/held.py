"""What holds memory that Python does not free."""

from __future__ import annotations

from abc import ABC, abstractmethod
from types import TracebackType
from typing import Self


class Held(ABC):
    """A context manager that frees what it holds when its block ends."""

    @abstractmethod
    def destroy(self) -> None:
        """Free the memory. Collective."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.destroy()
