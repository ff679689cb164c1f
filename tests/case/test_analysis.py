from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from impactfem.case import FrequencyGrid, Spectra, load_case
from impactfem.spectra import logarithmic_frequencies, rg_1_122_frequencies
from impactfem.system.errors import InputError

GRID = '{ minimum = "0.5 Hz", maximum = "500 Hz", per_decade = 100 }'


def test_logarithmic_list_is_that_of_the_spectra() -> None:
    grid = FrequencyGrid(minimum=0.5, maximum=15.0, per_decade=30)
    np.testing.assert_array_equal(grid.values, logarithmic_frequencies(0.5, 15.0, 30))
    assert FrequencyGrid(minimum=1.0, maximum=10.0).per_decade == 100


def test_list_of_the_regulatory_guide(broken: Callable[..., Path]) -> None:
    case = load_case(broken((None, GRID, '{ list = "rg1.122" }')))
    np.testing.assert_array_equal(case.spectra.frequency_values, rg_1_122_frequencies())
    longer = '{ list = "rg1.122", maximum = "500 Hz", per_decade = 50 }'
    case = load_case(broken((None, GRID, longer)))
    np.testing.assert_array_equal(case.spectra.frequency_values, rg_1_122_frequencies(500.0, 50))


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        ('{ list = "rg1.122", minimum = "1 Hz" }', "minimum", "has its own"),
        ('{ list = "rg1.122", maximum = "34 Hz" }', "maximum", "above the 34 Hz"),
        ('{ maximum = "5 Hz", per_decade = 9 }', "minimum", "missing; expected a frequency"),
        ('{ minimum = "5 Hz", per_decade = 9 }', "maximum", "missing; expected a frequency"),
        ("{ }", "minimum", "or list = 'rg1.122'"),
        ('{ minimum = "5 Hz", maximum = "4 Hz" }', "maximum", "above minimum, 5 Hz"),
        (
            '{ minimum = "1 Hz", maximum = "100 Hz", per_decade = 50001 }',
            "per_decade",
            "at most 100000 frequencies",
        ),
        ('{ list = "rg1.122", frequency = "1 Hz" }', "frequency", "unknown key"),
    ],
)
def test_lists_refused(broken: Callable[..., Path], text: str, key: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        load_case(broken((None, GRID, text)))
    messages = [str(fault) for fault in caught.value.faults]
    assert any(f"spectra.frequencies.{key}" in m and expected in m for m in messages), messages


def test_density_at_the_limit_is_allowed() -> None:
    assert FrequencyGrid(minimum=1.0, maximum=100.0, per_decade=50_000).per_decade == 50_000


def test_design_spectra_by_default() -> None:
    spectra = Spectra(damping=(0.05,), frequencies=(1.0, 2.0))
    assert (spectra.broadening, spectra.clipping) == (0.15, False)
    assert Spectra(damping=(0.05,), frequencies=(1.0,), broadening="10 %").broadening == 0.1
    assert Spectra(damping=(0.05,), frequencies=(1.0,), broadening=0, clipping=True).clipping


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"broadening": 1.0}, "expected a number of at least 0 and below 1"),
        ({"clipping": 1}, "bool"),
    ],
)
def test_design_spectra_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Spectra.model_validate({"damping": (0.05,), "frequencies": (1.0,)} | values)
