from collections.abc import Callable

import numpy as np
import pytest

from impactfem.verify import spectra
from impactfem.verify.row import Row


@pytest.mark.parametrize(
    ("benchmark", "function", "wrong"),
    [
        (spectra.rg_1_122, "rg_1_122_frequencies", lambda *_: np.linspace(0.2, 34.0, 75)),
        (
            spectra.broadening,
            "broaden",
            lambda f, s, _, at: np.exp(np.interp(np.log(at), np.log(f), np.log(s))),
        ),
        (spectra.peak_reduction, "clip_peaks", lambda f, s: (f, s, ())),
        # Linear in the ordinate instead of its logarithm.
        (
            spectra.sdld25,
            "interpolate_damping",
            lambda d, s, at: s[0] + (s[1] - s[0]) * (at - d[0]) / (d[1] - d[0]),
        ),
    ],
)
def test_a_wrong_rule_is_seen(
    monkeypatch: pytest.MonkeyPatch,
    benchmark: Callable[[], list[Row]],
    function: str,
    wrong: Callable[..., object],
) -> None:
    monkeypatch.setattr(spectra, function, wrong)
    assert any(not row.passed for row in benchmark())


def test_a_wrong_oscillator_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    right = spectra.response_spectra
    monkeypatch.setattr(
        spectra,
        "response_spectra",
        lambda a, dt, f, d, **rest: right(a, 1.001 * dt, f, d, **rest),
    )
    assert not all(row.passed for row in spectra.spectrum_sdll06())
