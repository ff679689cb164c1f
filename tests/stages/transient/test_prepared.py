"""What the stage `transient` needs beside the matrices."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import pytest

from impactfem.case import Damping, DampingCase, load_case
from impactfem.stages.transient.prepared import prepare, transient_of


@pytest.mark.parametrize(
    ("served", "ratios", "lightest"),
    [
        (True, ("0.5 %", "9 %"), 0.005),
        (True, ("9 %", "0.5 %"), 0.005),
        (True, ("9 %", "8 %"), 0.05),  # the building's own
        (False, ("0.5 %", "9 %"), 0.05),
    ],
)
def test_lightest_damping(
    begun: Path, served: bool, ratios: tuple[str, str], lightest: float
) -> None:
    case = load_case(begun / "frame.toml")
    assert case.transient is not None
    dampings = [
        DampingCase(name=name, ratio=ratio, frequencies=(1.0, 20.0))
        for name, ratio in zip(("first", "second"), ratios, strict=True)
    ]
    transient = case.transient.model_copy(update={"serve_damping_cases": served})
    case = case.model_copy(update={"damping_cases": tuple(dampings), "transient": transient})
    prepared = prepare(case, begun / "frame.msh", begun / "run" / "forces.nc", 0.5, "")
    assert prepared.damping == case.damping.rayleigh
    ξ = Damping(ratio=lightest, frequencies=(1.0, 20.0))
    assert astuple(prepared.lightest) == pytest.approx(astuple(ξ.rayleigh), rel=1e-14)


def test_a_case_without_the_stage(begun: Path) -> None:
    case = load_case(begun / "frame.toml")
    assert transient_of(case) is case.transient
    with pytest.raises(ValueError, match="no transient part"):
        transient_of(case.model_copy(update={"transient": None}))
