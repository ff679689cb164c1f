"""What shell benchmarks are shown to see: models with something wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from impactfem.building import shell


@pytest.fixture
def altered(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Multiply Young's modulus or the thickness of the models that a module makes."""

    def alter(module: ModuleType, E: float = 1.0, thickness: float = 1.0) -> None:
        right = module.shell_model

        def wrong(mesh: Any, material: Any, *t: float, **options: Any) -> Any:
            material = replace(material, E=E * material.E)
            return right(mesh, material, *(thickness * x for x in t), **options)

        monkeypatch.setattr(module, "shell_model", wrong)

    return alter


@pytest.fixture
def wrong_drilling(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Drilling energy of ω = ½ curl u + θ·e3; compiled into a cache of the test's own."""
    right = shell._strains

    def strains(w: Any, frame: Any) -> tuple[Any, ...]:
        _, theta = shell.halves(w)
        *others, omega = right(w, frame)
        return *others, omega + 2.0 * shell.ufl.dot(theta, frame[2])

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(shell, "_strains", strains)


@pytest.fixture
def quadrature(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[int], None]:
    """Set the degree of the shell's reduced integration."""

    def set_degree(degree: int) -> None:
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        monkeypatch.setattr(shell, "REDUCED", degree)

    return set_degree


@pytest.fixture
def failed() -> Callable[[list[Any]], set[str]]:
    """Quantities of the rows that do not pass."""
    return lambda rows: {row.quantity for row in rows if not row.passed}
