"""Unilateral contact on the ranks of this program, for test_unilateral_full.py.

On three ranks the one in the middle holds no row.
"""

import numpy as np

from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.unilateral_full import FullMotion
from impactfem.system.errors import SolutionError
from ranks import COMM, distributed, my_rows


def results(**given):
    n = len(given["K"])
    mine = my_rows(n)
    K, M = distributed(given["K"]), distributed(given["M"])
    with FullMotion(
        K,
        M,
        given["G"][mine],
        given["h"],
        damping=Rayleigh(given["alpha"], given["beta"]),
        patterns=given["patterns"][mine],
        probes=given["probes"][mine],
    ) as motion:
        history = unilateral_response(
            motion,
            given["gap"],
            len(given["loads"]) - 1,
            velocity=given["v"][mine],
            amplitudes=given["loads"],
        )
        ended = COMM.gather(motion.displacement)
        try:
            unilateral_response(motion, -1.0, 3)
            refused = ""
        except SolutionError as error:
            refused = str(error)
    copies = COMM.gather((history.impulse, history.displacement))
    if ended is None or copies is None:
        return {}
    return {
        "impulse": history.impulse,
        "gap": history.gap,
        "displacement": history.displacement,
        "velocity": history.velocity,
        "residual": history.residual,
        "energy": vars(history.energy),
        "of energy": history.energy.residual,
        "end": np.concatenate(ended),
        "same": all(np.array_equal(copies[0][k], other[k]) for other in copies for k in range(2)),
        "refused": refused,
    }
