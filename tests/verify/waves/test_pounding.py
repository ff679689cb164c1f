"""Reduced models that pound against their meshes: small frames, which the manual has larger."""

import numpy as np
import pytest

from impactfem.verify.waves import pounding
from two_models import write_case

LAW = 'type = "kelvin-voigt"\nstiffness = "5e8 N/m"\nrestitution = 0.5\n'


@pytest.mark.slow
def test_small_frames(tmp_path, wrong):
    """All rows pass; with a softer ground under the reduced models no impulse does."""
    path = write_case(tmp_path)
    text = path.read_text(encoding="utf-8").replace(LAW, 'type = "unilateral"\n')
    models = '[pounding]\nmodels = { A = "structure", B = "structure" }\n'
    text = text.replace("[pounding]\n", models)
    # Equal frames would not meet.
    at = text.rindex("calibration = {")
    text = f"{text[:at]}storey_stiffness_factor = 0.5\n{text[at:]}"
    path.write_text(text, encoding="utf-8")
    pair = []

    wrong(pounding, "FullPair", lambda make, *given: pair.append(make(*given)) or pair[-1])
    rows = pounding.pounding_reduced_against_full(path, 0.4, 1000)
    assert [row.quantity for row in rows if not row.passed] == []
    assert sum(row.quantity.startswith("impulse") for row in rows) == 2
    h = 5e-4
    ground = pounding.PULSE * np.sin(2.0 * np.pi * h * np.arange(801) / pounding.LASTS)
    truth = next(row for row in rows if row.quantity.startswith("impulse"))
    softer = pair[0].reduced(h, 0.95 * ground).impulse.sum(axis=0)
    other = softer[pair[0].pounding.pair_of == 0].sum()
    assert abs(other / truth.reference - 1.0) > 2.0 * truth.tolerance
