"""The sentences of faults: place, value, what is expected, and one suggestion. Asserted here alone.

All other tests assert key, kind, value and limit.
"""

import pytest

from .faults import all_faults
from .sections import LIGHT, PUMP, TRANSIENT


@pytest.mark.parametrize(
    ("old", "new", "more", "message"),
    [
        ('gap = "1 cm"', "gap = 0.01", "",
         "contacts[0].gap = 0.01: the unit is missing; expected a length of at least 0 with its "
         "unit, for example '1 cm'"),
        ('"33 GPa"', '"0 Gpa"', "",
         "materials.concrete.young_modulus = '0 Gpa': 'Gpa' is not a unit known here; did you "
         "mean 'GPa'?; expected a stress greater than 0 with its unit, for example '33 GPa'"),
        ("starts = 40", "startz = 40", "",
         "calibration.startz: unknown key; did you mean 'starts'?"),
        ('ratio = "7 %"', 'type = "table"\npoints = [["1 Hz", 0.1], ["1 kHz", 0.1]]\nratios = 1',
         "", "damping.ratios: unknown key; a key of type 'modes'"),
        ('frequencies = ["1 Hz", "20 Hz"]', 'frequencies = ["1 Hz"]', "",
         "damping.frequencies = ['1 Hz']: expected a list of 2 values, each a frequency greater "
         "than 0 with its unit, for example '20 Hz', found 1"),
        ('time_step = "0.3358 ms"', "", "",
         "pounding.time_step: missing; expected a time of at least 1e-09 s with its unit, for "
         "example '5 ms': Time step."),
        ('"0.3358 ms"', '"335.8 s"', "",
         "pounding.time_step = '335.8 s': expected a time below the duration, 16.79 s"),
        ('law = "floor"', 'law = "flor"', "",
         "contacts[0].law = 'flor': unknown contact law; did you mean 'floor'?"),
        ("", "", f"{LIGHT}{LIGHT}",
         "damping_cases[1].name = 'light': duplicate name, the first is damping_cases[0].name"),
        ("", "", PUMP,
         "devices: requires [buildings.structure]: the 3D model of their building, and "
         "[transient]: the response of that model in time"),
        ("", "", TRANSIENT,
         "transient: requires [buildings.structure]: the 3D model that moves"),
    ],
)  # fmt: skip
def test_message(broken, old, new, more, message):
    assert message in messages(broken(*([(None, old, new)] if old else []), more=more))


def test_message_of_a_table(broken):
    assert messages(broken(("pair_floors.csv", "1787", "-1787"))) == [
        "line 4, column mass [t] = '-1787': expected a mass greater than 0 with its unit, for "
        "example '2502 t'"
    ]


def messages(path):
    return [str(fault).partition(": ")[2] for fault in all_faults(path)]
