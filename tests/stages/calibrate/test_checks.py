"""The checks of the stage `calibrate` in words."""

import pytest

from impactfem.stages.calibrate.checks import wall_checks

LINES = [
    "calibrate: floor 8 starts at -20 mm; largest departure of its slab 2e-11 (limit 1e-6)",
    "calibrate: ε = 0.667, ξ_c = 0.128, K_Ceq = 1.2e+11 N/m from the impact of floor 8 at 0.2003 s:"
    " 16 ms, 800.3 kN s, 0.16 m/s before it",
    "calibrate: stick: 5.1 ms later, impulse -2.5 %, duration +3 %, relative to the 3D model",
    "calibrate: floor 6 of the 3D model does not hit the wall, it stays 1 mm away",
    "calibrate: floor 6 of the stick does not hit the wall, it stays 1 mm away",
    "calibrate: complementarity 1e-14 (limit 1e-9)",
    "calibrate: energy identity 1e-13 (limit 1e-9)",
    "calibrate: energy that contact adds in a step 0 (limit 1e-9)",
    "calibrate: error of the reduced basis 0.3 % (limit 0.5 %)",
    "calibrate: first impact of floor 8 of the 3D model, damping under-damped: time steps 30 "
    "(at least 16)",
    "calibrate: first impact of floor 8 of the stick: time steps 33 (at least 16)",
    "calibrate: penetration of the 3D model 0.8 % of the gap (limit 5 %)",
    "calibrate: penetration of the stick 0 % of the gap (limit 50 %)",
]


def missed(folder):
    return [text for met, text in wall_checks(folder) if met is False]


def test_all_is_well(wall_folder):
    """What has no limit, lines 2 to 5, is neither met nor missed."""
    met = [True, *[None] * 4, *[True] * (len(LINES) - 5)]
    assert wall_checks(wall_folder()) == list(zip(met, LINES, strict=True))


def test_how_a_floor_starts(wall_folder):
    """Held as a whole it is even; a load draws it aside unevenly."""
    (text,) = missed(wall_folder(scalars={"start_unevenness": 0.2}))
    assert text.endswith("largest departure of its slab 0.2 (limit 1e-6)")
    folder = wall_folder(pull="even_load", scalars={"start_unevenness": 0.2})
    text = "calibrate: floor 8 starts at -20 mm at its mass centre, its slab within 0.2 of it "
    assert wall_checks(folder)[0] == (None, text + "(pull = even_load)")


def test_a_store_without_the_error_of_the_basis(wall_folder):
    found = wall_checks(wall_folder(scalars={"basis_error": None}))
    assert [text for _, text in found] == [*LINES[:8], *LINES[9:]]


CUT_SHORT = {6: (), 7: (), 8: ((0.2003, 0.016, 800e3), (0.595, 0.016, 100e3))}


@pytest.mark.parametrize(
    ("wanted", "line"),
    [
        ({"scalars": {"complementarity": 1e-6}}, "complementarity 1e-6 (limit 1e-9)"),
        ({"scalars": {"energy_residual": 1e-3}}, "energy identity 0.001 (limit 1e-9)"),
        (
            {"scalars": {"energy_gained": 1e-4}},
            "energy that contact adds in a step 1e-4 (limit 1e-9)",
        ),
        (
            {"scalars": {"basis_error": 0.02}},
            "error of the reduced basis 2 % (limit 0.5 %)",
        ),
        (
            {"scalars": {"penetration": 2e-3}},
            "penetration of the 3D model 20 % of the gap (limit 5 %)",
        ),
        (
            {"durations": (0.016, 0.007, 0.017)},
            "first impact of floor 8 of the 3D model, damping under-damped: time steps 14 "
            "(at least 16)",
        ),
        (
            {"hits": CUT_SHORT},
            "floor 8 of the 3D model is still at the wall when the window ends, since 0.595 s",
        ),
    ],
)
def test_a_number_that_is_missed(wall_folder, wanted, line):
    assert missed(wall_folder(**wanted)) == [f"calibrate: {line}"]


def test_too_few_steps_of_the_stick(wall_folder):
    hits = {6: (), 7: (), 8: ((0.2054, 0.006, 780e3),)}
    folder = wall_folder(stick_hits=hits, dampings=1)
    line = "calibrate: first impact of floor 8 of the stick: time steps 12 (at least 16)"
    assert missed(folder) == [line]
    # Both floors that it leaves alone, and one damping needs no name.
    texts = [text for _, text in wall_checks(folder)]
    assert sum("of the stick does not hit" in text for text in texts) == 2
    assert any("of the 3D model: time steps" in text for text in texts)


def test_a_stick_that_is_before_the_3d_model(wall_folder):
    found = wall_checks(wall_folder(scalars={"stick_delay": -2e-3}))
    assert found[2][1].startswith("calibrate: stick: 2 ms earlier,")
