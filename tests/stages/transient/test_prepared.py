"""What the stage `transient` needs beside the matrices."""

from __future__ import annotations

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.stages.transient.prepared import transient_of


def test_a_case_without_the_stage(begun: Path) -> None:
    case = load_case(begun / "frame.toml")
    assert transient_of(case) is case.transient
    with pytest.raises(ValueError, match="no transient part"):
        transient_of(case.model_copy(update={"transient": None}))
