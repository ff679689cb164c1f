"""The program as an input of a stage: what of its sources counts."""

from pathlib import Path

import pytest

from impactfem.run.stages import STAGES
from impactfem.stages import sources
from impactfem.stages.sources import imported_by, program_key

STEEL = '''"""Of steel."""

from impactfem.girder import E

def stress(strain: float) -> float:
    """Hooke."""
    return E * strain  # [Pa]
'''
GIRDER = "E = 2.1e11\n"


@pytest.fixture
def key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The key of a small program of two modules."""
    monkeypatch.setattr(sources, "ROOT", tmp_path)

    def of(steel: str = STEEL, girder: str = GIRDER) -> str:
        for cached in (program_key, sources._tree, sources._imports, sources._statements):
            cached.cache_clear()
        (tmp_path / "steel.py").write_text(steel, encoding="utf-8")
        (tmp_path / "girder.py").write_text(girder, encoding="utf-8")
        return program_key(("steel",))

    yield of
    for cached in (program_key, sources._tree, sources._imports, sources._statements):
        cached.cache_clear()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[Pa]", "pascal"),
        ("Of steel", "Of any metal"),
        ("Hooke.", "Robert Hooke."),
        ("    return", "\n    return"),
    ],
)
def test_comments_docstrings_and_layout_do_not_count(key, old: str, new: str) -> None:
    assert old in STEEL
    assert key(STEEL.replace(old, new)) == key()


def test_statements_count_and_those_of_what_is_imported(key) -> None:
    assert key(STEEL.replace("E * strain", "E * strain / 2")) != key()
    assert key(girder="E = 2.0e11\n") != key()


def test_an_import_in_a_function_counts(key) -> None:
    within = STEEL.replace("from impactfem.girder import E\n", "").replace(
        "    return", "    from impactfem.girder import E\n    return"
    )
    assert key(within, "E = 2.0e11\n") != key(within)


def test_a_module_that_is_not_there(key) -> None:
    key()
    with pytest.raises(ValueError, match="no module timber"):
        program_key(("timber",))


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_who_computes_does_not_draw(stage) -> None:
    """So that an edited figure computes nothing again; the solvers count where they are used."""
    computing = imported_by(stage.modules)
    assert not {name for name in computing if name.split(".")[-1] in ("figures", "tables")}
    assert not {name for name in computing if name.split(".")[0] in ("plot", "report", "run")}
    assert f"stages.{stage.name}.compute" in computing and "case.model" in computing
    assert not stage.drawn_by or "plot.style" in imported_by(stage.drawing_modules)
