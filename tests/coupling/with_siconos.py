"""A structure before rigid walls, stepped by Siconos: `python with_siconos.py CASE RESULTS`.

Run by the fixture `siconos` in a process of its own: Siconos brings a sequential MUMPS, whose
functions have the names of those of PETSc's parallel one.
"""

import sys

import numpy as np
import siconos.kernel as sk


def stepped(case: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Moreau-Jean with θ = 1/2, an impact law of Newton per constraint, an LCP per step."""
    M, K, C, G, h = (case[name] for name in ("M", "K", "C", "G", "h"))
    body = sk.LagrangianLinearTIDS(case["u"].copy(), case["v"].copy(), M, K, C)
    load = case["f"].copy()
    body.setFExtPtr(load)
    system = sk.NonSmoothDynamicalSystem(0.0, float(h) * (int(case["steps"]) + 0.5))
    system.insertDynamicalSystem(body)
    constraints = []
    for column, gap, e in zip(G.T, case["gap"], case["e"], strict=True):
        relation = sk.LagrangianLinearTIR(-column[None, :].copy(), np.array([gap]))
        constraints.append(sk.Interaction(sk.NewtonImpactNSL(float(e)), relation))
        system.link(constraints[-1], body)
    times = sk.TimeDiscretisation(0.0, float(h))
    stepping = sk.TimeStepping(system, times, sk.MoreauJeanOSI(0.5), sk.LCP())
    u, v = [body.q().copy()], [body.velocity().copy()]
    impulse = [np.zeros(len(constraints))]
    for _ in range(int(case["steps"])):
        stepping.computeOneStep()
        u.append(body.q().copy())
        v.append(body.velocity().copy())
        impulse.append(np.array([one.lambda_(1)[0] for one in constraints]))
        stepping.nextStep()
    return {"u": np.array(u), "v": np.array(v), "impulse": np.array(impulse)}


if __name__ == "__main__":
    with np.load(sys.argv[1]) as case:
        np.savez(sys.argv[2], **stepped(dict(case)))
