"""The checks of the stage `calibrate` in words."""

import logging

import pytest

from impactfem.stages.calibrate.checks import wall_checks
from impactfem.stages.check import log_checks

LINES = [
    "calibrate: floor 8 starts at -20 mm, all of its slab within 2.0e-11 (limit 1e-06)",
    "calibrate: ε = 0.667, ξ_c = 0.128, K_Ceq = 1.2e+11 N/m from the impact of floor 8 at 0.2003 s:"
    " 16 ms, 800.3 kN s, 0.16 m/s before it",
    "calibrate: the stick hits 5.1 ms later, with 0.975 of the impulse and 1.03 of the duration",
    "calibrate: floor 6 of the 3D model does not hit the wall, it stays 1 mm away",
    "calibrate: floor 6 of the stick does not hit the wall, it stays 1 mm away",
    "calibrate: complementarity within 1.0e-14, 1e-09 asked",
    "calibrate: energy identity to 1.0e-13, 1e-09 asked",
    "calibrate: contact puts in at most 0.0e+00 of the energy in a step, 1e-09 asked",
    "calibrate: transfer functions of the reduced basis within 0.3 %, 0.5 % asked",
    "calibrate: 30 steps in the first impact of floor 8 of the 3D model with the damping "
    "under-damped, 16 asked",
    "calibrate: 33 steps in the first impact of floor 8 of the stick, 16 asked",
    "calibrate: the 3D model penetrates 0.8 % of the gap, 5 % asked",
    "calibrate: the stick penetrates 0 % of the gap, 50 % asked",
]


def logged(folder, caplog):
    with caplog.at_level(logging.INFO, "impactfem"):
        log_checks(wall_checks(folder))
    return [(record.levelname, record.getMessage()) for record in caplog.records]


def told(folder):
    """Lines without a limit."""
    return [text for good, text in wall_checks(folder) if good is None]


def warned(found):
    return [text for level, text in found if level == "WARNING"]


def test_all_is_well(wall_folder, caplog):
    assert logged(wall_folder(), caplog) == [("INFO", line) for line in LINES]


def test_what_has_no_limit_is_neither_met_nor_missed(wall_folder):
    assert told(wall_folder()) == LINES[1:5]


def test_a_floor_that_does_not_start_as_requested(wall_folder):
    [(met, text)] = [
        line
        for line in wall_checks(wall_folder(scalars={"start_unevenness": 0.2}))
        if "starts at" in line[1]
    ]
    assert met is False and text.endswith("all of its slab within 2.0e-01 (limit 1e-06)")


def test_a_floor_that_a_load_draws_aside(wall_folder):
    folder = wall_folder(pull="even_load", scalars={"start_unevenness": 0.2})
    text = "calibrate: floor 8 starts at -20 mm at its mass centre, its slab within 0.2 of it "
    assert wall_checks(folder)[0] == (None, text + "(pull = even_load)")


def test_a_store_without_the_error_of_the_basis(wall_folder, caplog):
    found = logged(wall_folder(scalars={"basis_error": None}), caplog)
    assert [text for _, text in found] == [*LINES[:8], *LINES[9:]]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"complementarity": 1e-6}, "complementarity within 1.0e-06, 1e-09 asked"),
        ({"energy_residual": 1e-3}, "energy identity to 1.0e-03, 1e-09 asked"),
        (
            {"energy_gained": 1e-4},
            "contact puts in at most 1.0e-04 of the energy in a step, 1e-09 asked",
        ),
        ({"basis_error": 0.02}, "transfer functions of the reduced basis within 2 %, 0.5 % asked"),
        ({"penetration": 2e-3}, "the 3D model penetrates 20 % of the gap, 5 % asked"),
    ],
)
def test_a_number_that_fails_is_a_warning(wall_folder, caplog, change, line):
    found = logged(wall_folder(scalars=change), caplog)
    assert warned(found) == [f"warning: calibrate: {line}"]
    assert len(found) == len(LINES)


def test_too_few_steps_of_the_3d_model(wall_folder, caplog):
    found = logged(wall_folder(durations=(0.016, 0.007, 0.017)), caplog)
    assert warned(found) == [
        "warning: calibrate: 14 steps in the first impact of floor 8 of the 3D model with the "
        "damping under-damped, 16 asked"
    ]


def test_too_few_steps_of_the_stick(wall_folder, caplog):
    hits = {6: (), 7: (), 8: ((0.2054, 0.006, 780e3),)}
    found = logged(wall_folder(stick_hits=hits, dampings=1), caplog)
    assert warned(found) == [
        "warning: calibrate: 12 steps in the first impact of floor 8 of the stick, 16 asked"
    ]
    # Both floors that it leaves alone, and one damping needs no name.
    assert sum("of the stick does not hit" in text for _, text in found) == 2
    assert any("of the 3D model, 16 asked" in text for _, text in found)


def test_an_impact_at_the_end_of_the_window(wall_folder, caplog):
    hits = {6: (), 7: (), 8: ((0.2003, 0.016, 800e3), (0.595, 0.016, 100e3))}
    found = logged(wall_folder(hits=hits), caplog)
    assert warned(found) == [
        "warning: calibrate: floor 8 of the 3D model is still at the wall when the window ends, "
        "since 0.595 s"
    ]


def test_a_stick_that_is_before_the_3d_model(wall_folder, caplog):
    found = logged(wall_folder(scalars={"stick_delay": -2e-3}), caplog)
    assert found[2][1].startswith("calibrate: the stick hits 2 ms before,")
