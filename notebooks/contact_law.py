# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A contact law of your own
#
# What this notebook teaches: what a contact law is for the program, how to write one, how to
# compare its restitution with a closed form, and how to let two buildings pound under it.
#
# A **contact law** gives the force $F$ between two points from their penetration $p > 0$, its rate
# $v$ and the speed of approach $v_0$ with which this contact began; $F$ is positive in
# compression. The paper's law is that of Kelvin and Voigt, $F = K p + C v$. It has two weak
# points: the force jumps to $C v_0$ at the first touch, which no wave in the buildings can follow,
# and it pulls at the end of the contact.

# %% tags=["parameters"]
case_file = "../geometry/npp_pair.toml"  # the case whose buildings pound
epsilon = 0.687  # restitution that is asked [-]

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from impactfem import study
from impactfem.coupling.contact import effective_mass, kelvin_voigt
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.impacts import impacts
from impactfem.coupling.own_law import own_law
from impactfem.coupling.restitution import exact_chi, kelvin_voigt_xi
from impactfem.stages.pounding.compute import run_sticks
from impactfem.system import log
from impactfem.system.errors import InputError
from impactfem.verify.contact import collision

log.set_up(verbose=False)

# %% [markdown]
# ## The law
#
# A spring whose damping grows with the penetration,
#
# $$F = K p \left(1 + \chi \frac{v}{v_0}\right),$$
#
# begins at zero and never pulls. It is Hunt and Crossley's law with the power 1 in the place of
# 1.5, so that its stiffness is one in N/m, as that of Kelvin and Voigt.
#
# For the program a law is a function of its parameters, $p$, $v$ and $v_0$ that returns $F$ and
# its derivatives $\partial F/\partial p$ and $\partial F/\partial v$: the contact force is taken
# at the new time of each step, by Newton's method. It is compiled, so it may use numbers, `math`
# and numpy, and nothing else of Python. A contact that begins at rest has $v_0 = 0$: the third
# parameter is the slowest approach that counts.


# %%
def soft_start(parameters, p, v, v0):
    """F = K p (1 + χ v / v₀) [N], with dF/dp [N/m] and dF/dv [N s/m]."""
    K, chi, slowest = parameters[0], parameters[1], parameters[2]
    mu = chi / max(v0, slowest)
    factor = 1.0 + mu * v
    if factor <= 0.0:
        return 0.0, 0.0, 0.0
    return K * p * factor, K * factor, K * p * mu


# %% [markdown]
# ## Which χ gives which restitution
#
# Two free masses with the effective mass $m = m_1 m_2 / (m_1 + m_2)$ obey $m v\,dv = -F\,dp$. With
# $s = v / v_0$, from $s = 1$ at the first touch to $s = -\varepsilon$ when $p = 0$ again, $\int
# s\,ds / (1 + \chi s) = 0$, which is
#
# $$\ln \frac{1 + \chi}{1 - \chi \varepsilon} = \chi (1 + \varepsilon).$$
#
# The power of $p$ does not matter, so this is the relation that the program has for Hertz's
# contact with damping: `exact_chi` solves it.

# %%
m1, m2 = 1574e3, 3014e3  # kg
K = 1e11  # N/m
m = effective_mass(m1, m2)
chi = exact_chi(epsilon)
law = own_law("soft start", soft_start, (K, chi, 1e-3), m, asked=epsilon)
print(law.describe())
print(f"χ = {chi:.6f}; an impact at 0.3 m/s lasts {1e3 * law.duration(0.3):.2f} ms")

# %% [markdown]
# `own_law` tests the function along a collision of two free masses. A force whose derivatives are
# wrong, or that falls where it may not, is refused:


# %%
def wrong(parameters, p, v, v0):
    """The derivative to p is forgotten."""
    return parameters[0] * p, 0.0, 0.0


try:
    own_law("wrong", wrong, (K,), m)
except InputError as error:
    print(error)

# %% [markdown]
# ## A collision, step by step
#
# `collision` lets two free masses collide in the program's own time loop: the same test by which
# the verification manual measures all laws. Beside it Kelvin and Voigt's law with the same
# restitution and stiffness.

# %%
speed = 0.3  # m/s
known = kelvin_voigt(K, kelvin_voigt_xi(epsilon), m)
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
for one, style in ((known, "--"), (law, "-")):
    step = one.duration(speed) / 200
    response = collision(one, m1, m2, speed, step, phase=0.5)
    (impact,) = impacts(response)
    force = 1e-6 * response.force[:, 0]
    penetration = np.maximum(-1e3 * response.gap[:, 0], 0.0)
    left.plot(1e3 * response.time, force, style, label=one.name)
    right.plot(penetration, force, style, label=one.name)
    print(f"{one.name}: restitution requested {epsilon}, found {impact.restitution:.5f}")
left.set(xlabel="time [ms]", ylabel="force [MN]", title=f"two floors at {speed} m/s")
right.set(xlabel="penetration [mm]", ylabel="force [MN]", title="the loop is the energy lost")
for panel in (left, right):
    panel.grid(alpha=0.3)
    panel.legend()
plt.show()

# %% [markdown]
# ## Restitution against the closed form
#
# How far the restitution that comes out of the time loop is from the one asked, with few and with
# many steps an impact. The paper takes 16 or more. The error falls with the square of the step, as
# the force begins at zero.

# %%
asked = np.linspace(0.2, 0.95, 9)
figure, axes = plt.subplots(figsize=(5.5, 3.8), layout="constrained")
for steps, marker in ((8, "v-"), (16, "s-"), (64, "^-"), (256, "o-")):
    found = []
    for value in asked:
        one = own_law("soft start", soft_start, (K, exact_chi(value), 1e-3), m, asked=value)
        step = one.duration(speed) / steps
        found.append(impacts(collision(one, m1, m2, speed, step, phase=0.5))[0].restitution)
    error = np.abs(np.array(found) - asked)
    axes.semilogy(asked, error, marker, ms=4, lw=0.8, label=f"{steps} steps an impact")
    print(f"{steps} steps an impact: largest difference {error.max():.1e}")
axes.set(xlabel="restitution requested, closed form [-]", ylabel="difference of the one found [-]")
axes.grid(alpha=0.3)
axes.legend(fontsize=8)
plt.show()

# %% [markdown]
# ## Buildings that pound under it
#
# A case file names the laws that the program has; one of your own comes in from Python.
# `system_of` makes the sticks and the contact pairs of a case, `with_laws` gives each pair another
# law, for its own effective mass, and `run_sticks` does what the stage `pounding` does, without
# files. Both runs share the ground motion and the sticks; stiffness and restitution of each pair
# stay what the case says.

# %%
case = study.check(Path(case_file))
calibration = calibration_of(case)
system = system_of(case, calibration)


def softly(pair):
    """The law above with the stiffness and the restitution that the pair has."""
    K, epsilon, m = pair.law.stiffness, pair.law.epsilon, pair.law.mass
    return own_law("soft start", soft_start, (K, exact_chi(epsilon), 1e-3), m, asked=epsilon)


before = run_sticks(case, ready=(calibration, system))
after = run_sticks(case, ready=(calibration, system.with_laws(softly)))

stations = before.stations
building = case.buildings[0].name
station = max(k for k, (name, _) in enumerate(stations) if name == building)
print(f"{'':24} {'of the case':>12} {'soft start':>12}")
top = f"{building}.floor_{stations[station][1]}"
for told, unit, value in (
    ("impacts", "", lambda run: len(run.impacts)),
    ("largest force", "MN", lambda run: 1e-6 * run.main_impact.peak_force),
    ("its duration", "ms", lambda run: 1e3 * run.main_impact.duration),
    ("its impulse", "kN s", lambda run: 1e-3 * run.main_impact.impulse),
    (f"PFA {top}", "m/s²", lambda run: run.floors.pfa[station, 0]),
    ("FRS peak there", "m/s²", lambda run: run.floors.psa[0, station, 0].max()),
):
    print(f"{told:>18} {unit:>5} {value(before):12.4g} {value(after):12.4g}")

# %%
pair = before.main_impact.index
at = before.main_impact.peak_time
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
for run, label, style in ((before, "law of the case", "--"), (after, "soft start", "-")):
    time, force = run.response.time, run.response.force[:, pair]
    near = np.abs(time - at) < 0.02
    left.plot(1e3 * (time[near] - at), 1e-6 * force[near], style, label=label)
    spectra = run.floors.spectra
    right.semilogx(spectra.frequency, run.floors.psa[0, station, 0], style, label=label)
left.set(xlabel=f"time after {at:.3f} s [ms]", ylabel="impact force [MN]", title="main impact")
right.set(
    xlabel="frequency [Hz]",
    ylabel="pseudo-acceleration [m/s²]",
    title=f"{top}, along {before.floors.directions[0]}, "
    f"damping {100 * case.spectra.damping[0]:g} %",
)
for panel in (left, right):
    panel.grid(alpha=0.3)
    panel.legend()
plt.show()
