"""Response spectrum analysis of devices: published, closed-form and direct references."""

import math
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from impactfem.device.anchor_force import (
    Quantities,
    anchor_force,
    anchor_forces,
    own_accelerations,
    own_motions,
    own_weight,
    ring_tension,
)
from impactfem.device.combination import (
    Combination,
    Gupta,
    LindleyYow,
    Rules,
    combine_modes,
    correlation,
)
from impactfem.device.models import on_springs
from impactfem.device.modes import device_modes
from impactfem.device.parts import BaseSprings, RigidBody
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.devices import in_line, mass_between, paper_device
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.spectra import SDLD25_FREQUENCY, SDLD25_SOURCE, SDLD25_SPECTRA

SDLD30_SHIFTS = (0.04, 0.06)  # m, of the two supports
SDLD30_TABLE = (
    # Quantity, part of the inertia, part of the supports' displacements, both.
    ("displacement of NO2", "m", 0.0412562, 0.0354306, 0.054382),
    ("displacement of NO3", "m", 6.60152e-3, 0.0571746, 0.0575544),
    ("reaction at NO1", "N", 41.2562, 34.3386, 53.6769),
    ("reaction at NO4", "N", 66.0152, 34.3386, 74.412),
)


def flat(
    component: str, value: float, anchor: int = 1, displacement: float = 0.0
) -> AnchorSpectrum:
    """A spectrum with one ordinate, its zero-period acceleration, at all frequencies."""
    at, damping, psa = np.array([1e-3, 1e5]), np.array([0.0, 0.99]), np.full((2, 2), value)
    return AnchorSpectrum(component, at, damping, psa, value, anchor, displacement)


@benchmark("SDLD25 as a device")
def device_sdld25(rows: Rows) -> None:
    """SDLD25: absolute accelerations of eight masses between two ends that move together."""
    names = tuple(f"P{i} x" for i in range(1, 9))
    masses = [0.0, *[10.0] * 8, 0.0]
    device = in_line("chain", [1e5] * 9, masses, {0: 0, 9: 6}, Rayleigh(0.0, 5e-4), names)
    at, dampings = np.array(SDLD25_FREQUENCY), np.array(list(SDLD25_SPECTRA))
    psa = np.array(list(SDLD25_SPECTRA.values()))
    spectra = [AnchorSpectrum("x", at, dampings, psa, 1.0, anchor) for anchor in (1, 2)]
    modes = device_modes(device)
    n = np.array([1, 4, 8])
    exact = math.sqrt(1e4) * np.sin(n * math.pi / 18.0) / math.pi
    quantities = [f"frequency of mode {number}" for number in n]
    source = "closed form of a uniform chain"
    rows.add(quantities, exact, modes.frequency[n - 1], "Hz", 1e-12, source)
    # The second row was computed for the same model independently of this program. Allowed are
    # five units of the ninth digit, and one of the eighth.
    again = f"independent recomputation of the model of {SDLD25_SOURCE}"
    rules: tuple[tuple[Combination, tuple[float, ...], float, str], ...] = (
        ("srss", (10.4498435, 19.0299477, 25.3176949, 28.9453548), 5e-8, SDLD25_SOURCE),
        ("cqc", (10.455874, 19.031803, 25.317302, 28.942301), 1e-7, again),
    )
    for rule, published, allowed, source in rules:
        used = Rules(modes=rule, supports="algebraic")
        total = spectrum_analysis(device, spectra, used, own_accelerations(device)).total
        quantities = [f"absolute acceleration of P{i}, {rule.upper()}" for i in range(1, 5)]
        rows.add(quantities, published, total[:4], "m/s2", allowed, source)


@benchmark(
    "CQC coefficient",
    "Lyapunov equation of two oscillators under white noise (Der Kiureghian 1981)",
)
def cqc_coefficient(rows: Rows) -> None:
    """CQC's coefficients against the covariance of two oscillators under white noise.

    The covariance P of the states solves A P + P Aᵀ + B Bᵀ = 0; the coefficient is the correlation
    of the two displacements. Nothing of the closed form is used.
    """
    for f, xi in (
        ((10.0, 10.5), (0.02, 0.02)),
        ((10.0, 12.0), (0.05, 0.01)),
        ((30.51, 82.90), (0.0199, 0.0204)),
        ((5.0, 5.0), (0.02, 0.10)),
    ):
        omega, ratio = 2.0 * np.pi * np.array(f), np.array(xi)
        A = np.block(
            [[0.0 * np.eye(2), np.eye(2)], [np.diag(-(omega**2)), np.diag(-2.0 * ratio * omega)]]
        )
        B = np.array([[0.0], [0.0], [1.0], [1.0]])
        P = solve_continuous_lyapunov(A, -B @ B.T)
        exact = P[0, 1] / math.sqrt(P[0, 0] * P[1, 1])
        found = correlation("cqc", np.array(f), ratio)[0, 1]
        quantity = f"{f[0]:g} Hz at {xi[0]:.2%} and {f[1]:g} Hz at {xi[1]:.2%}"
        rows.add(quantity, exact, found, "-", 1e-11)


@benchmark(
    "combination of modes",
    "closed form; US NRC Regulatory Guide 1.92, revisions 1 (1976) and 2 (2006)",
)
def mode_combinations(rows: Rows) -> None:
    """Other rules on three modes, closed form: 10, 10.8 and 11.5 Hz with R = 3, -4 and 12."""
    R, f, xi = np.array([3.0, -4.0, 12.0]), np.array([10.0, 10.8, 11.5]), np.full(3, 0.02)
    rate = [0.02 * 2.0 * math.pi * one + 2.0 / 10.0 for one in f]
    shift = [2.0 * math.pi * one * math.sqrt(1.0 - 0.02**2) for one in f]
    double = 9.0 + 16.0 + 144.0
    for i, j in ((0, 1), (0, 2), (1, 2)):
        gap = (shift[j] - shift[i]) / (rate[i] + rate[j])
        double += 2.0 * R[i] * R[j] / (1.0 + gap**2)
    cases: list[tuple[str, Combination, float]] = [
        ("absolute values", "abs", 19.0),
        ("squares", "srss", 13.0),
        # 10 and 10.8, 10.8 and 11.5 Hz are close; 10 and 11.5 Hz are not.
        ("ten per cent", "ten-percent", math.sqrt(169.0 + 2.0 * 12.0 + 2.0 * 48.0)),
        # The first group ends at 11 Hz.
        ("grouping", "grouping", math.sqrt(49.0 + 144.0)),
        ("double sum, 10 s", "dsc", math.sqrt(double)),
    ]
    for words, rule, reference in cases:
        rows.add(words, reference, combine_modes(R, f, xi, rule, 10.0), "-", 1e-12)


@benchmark("missing mass under a static load", "statics")
def missing_mass(rows: Rows) -> None:
    """Missing mass: a slow acceleration presses on the device as a static load does.

    A spectrum that is flat at 2 m/s2 is that of a motion slow for all modes; whatever modes are
    used, their rigid parts and the missing mass add up to the static force.
    """
    device = paper_device(8.0e7)
    q = anchor_forces(device) + own_motions(device, "base")
    load = -2.0 * device.L[:, 1]
    at_rest = np.linalg.solve(device.K, load)
    names = ("force y", "moment x", "displacement base y", "displacement base rx")
    units = [q.units[q.names.index(name)] for name in names]
    # 1500 kg at 0.46 m and 45.9 kg at half of it; a rotation about x moves it along -y.
    force, moment = 2.0 * 1545.9, 2.0 * (1500.0 * 0.46 + 45.9 * 0.23)
    moved = [at_rest[device.motions.index(name)] for name in ("base y", "base rx")]
    for words, limit in (("no mode", 20.0), ("one pair of modes", 50.0), ("two pairs", 1000.0)):
        rules = Rules(rigid=Gupta(1e-3, 2e-3), maximum_frequency=limit)
        found = spectrum_analysis(device, [flat("y", 2.0)], rules, q)
        quantities, values = [f"{name}, {words} used" for name in names], map(found.value, names)
        rows.add(quantities, [force, moment, *np.abs(moved)], list(values), units, 1e-10)


@benchmark("rigid response")
def rigid_response(rows: Rows) -> None:
    """Two modes above the frequency from which on the floor is rigid: both move in step with it.

    The spectrum has its peak at 4 to 8 Hz and is at its zero-period acceleration of 2 m/s2 from
    25 Hz on; the paper's device has 30.5 and 82.9 Hz. Its shear force is mass times acceleration
    and its moment that of statics, whatever combines the periodic part, of which nothing is left.
    The root of squares without a rigid part is lower by √(m₁² + m₂²) / (m₁ + m₂).
    """
    device, zpa = paper_device(8.0e7), 2.0
    frequency = np.array([0.5, 4.0, 8.0, 25.0, 1e3])
    psa = np.tile([1.0, 9.0, 9.0, zpa, zpa], (2, 1))
    floor = AnchorSpectrum("y", frequency, np.array([0.0, 0.99]), psa, zpa)
    force, moment = 1545.9 * zpa, zpa * (1500.0 * 0.46 + 45.9 * 0.23)
    rows.source = "statics: F = m ZPA, as RG 1.92 (revision 3, C.1.3) has it of rigid modes"
    for method in (Gupta(), LindleyYow()):
        for rule in ("srss", "cqc"):
            rules = Rules(modes=rule, rigid=method, maximum_frequency=1e3)
            found = spectrum_analysis(device, [floor], rules)
            words = f"{type(method).__name__} with {rule.upper()}"
            rows.add(f"force y, {words}", force, found.value("force y"), "N", 1e-9)
            rows.add(f"moment x, {words}", moment, found.value("moment x"), "N m", 1e-9)
    alone = spectrum_analysis(device, [floor], Rules(modes="srss", maximum_frequency=1e3))
    lower, quantity = zpa * math.hypot(1218.9, 327.0), "force y, SRSS without a rigid part"
    source = "√(m₁² + m₂²) ZPA with the masses of table 6: 18 % lower"
    rows.add(quantity, lower, alone.value("force y"), "N", 2e-4, source)
    # At 12 Hz the modes are half periodic: α by hand for both methods, S between 9 and 2 m/s2.
    S = 9.0 * (2.0 / 9.0) ** (math.log(12.0 / 8.0) / math.log(25.0 / 8.0))
    at, xi = np.array([12.0]), np.array([0.02])
    corners = (9.0 / (9.0 / 4.0), (4.0 + 2.0 * 25.0) / 3.0)
    partly = math.log(12.0 / corners[0]) / math.log(corners[1] / corners[0])
    source = "closed form from the spectrum"
    for rigid, reference in ((Gupta(), partly), (LindleyYow(), zpa / S)):
        value = rigid.fraction(floor, at, xi, np.array([S]))[0]
        quantity = f"rigid part at 12 Hz, {type(rigid).__name__}"
        rows.add(quantity, reference, value, "-", 1e-9, source)


@benchmark("net tension at the anchor", "statics")
def net_tension(rows: Rows) -> None:
    """The paper's device under an acceleration that stays: what eight anchors on its rim bear.

    The floor accelerates by 4 m/s2 along y and 3 m/s2 downward. Forces by statics; a rigid plate
    on eight equal springs on the circle, whose forces follow from equilibrium by the least squares
    of its three motions, with the moment turned until one of them is pulled the most.
    """
    device, radius, count = paper_device(8.0e7), 0.5, 8
    moved = np.array([0.0, 4.0, -3.0, 0.0, 0.0, 0.0])
    whole = -device.J @ moved + own_weight(device)
    N = 1545.9 * (3.0 - 9.80665)
    M = 4.0 * (1500.0 * 0.46 + 45.9 * 0.23)
    largest = -math.inf
    for turned in np.linspace(0.0, 2.0 * math.pi, 361):
        angle = turned + 2.0 * math.pi * np.arange(count) / count
        plate = np.column_stack([np.ones(count), radius * np.cos(angle), radius * np.sin(angle)])
        springs = plate @ np.linalg.solve(plate.T @ plate, np.array([N, M, 0.0]))
        largest = max(largest, count * float(springs.max()))
    tension = float(ring_tension(whole, radius))
    rows.add("force z with the weight", N, whole[2], "N", 1e-9, "statics, g = 9.80665 m/s2")
    rows.add("moment x", M, whole[3], "N m", 1e-9)
    rows.add("N + 2 M / r", N + 2.0 * M / radius, tension, "N", 1e-9)
    rows.add("eight springs on a circle", largest, tension, "N", 1e-9, "a rigid plate on springs")


@benchmark("device on a rocking floor", "closed form: one oscillator at the height h")
def rocking_floor(rows: Rows) -> None:
    """Rotational spectra: a mass at the height h feels the rotation θ of its anchor as -h θ."""
    h, mass, blocked = 0.7, 800.0, dict.fromkeys(("x", "z", "rx", "ry", "rz"), math.inf)
    springs = BaseSprings.of_directions(y=mass * (2.0 * math.pi * 12.0) ** 2, **blocked)
    device = on_springs("mass", springs, RigidBody.at_height(mass, h, 1e-6, 1e-6, 1e-6), 0.02)
    translation, rotation = flat("y", 5.0), flat("rx", 5.0 / h)
    independent, in_step = Rules(rotations="srss"), Rules(rotations="abs")
    for words, spectra, rules, acceleration in (
        ("a translation of 5 m/s2", [translation], independent, 5.0),
        ("a rotation of 5/h rad/s2", [rotation], independent, 5.0),
        ("both, as independent", [translation, rotation], independent, math.hypot(5.0, 5.0)),
        ("both, in step", [translation, rotation], in_step, 10.0),
    ):
        found = spectrum_analysis(device, spectra, rules).value("force y")
        rows.add(f"F_y under {words}", mass * acceleration, found, "N", 1e-9)


@benchmark("rigid block on a rotating base", "closed form: a step of the base's acceleration")
def block_on_a_rotating_base(rows: Rows) -> None:
    """A block that rocks on its base, whose angular acceleration jumps from 0 to A and stays.

    With the moment of inertia I about its mass centre at the height h, I_b = I + m h² about the
    base, ω² = k / I_b: its angle against the base is at most A (1 + e^(-π ξ / √(1 - ξ²))) / ω²,
    from the spectrum of the history. So the moment is I_b and the force m h times the ordinate. A
    base that moves along y by the same history, in m/s2, gives the moment m h times the ordinate.
    """
    m, inertia, h, A, ξ, f = 1500.0, 400.0, 0.8, 3.0, 0.05, 12.0
    about_base = inertia + m * h**2
    blocked = dict.fromkeys(("x", "y", "z", "ry", "rz"), math.inf)
    springs = BaseSprings.of_directions(rx=about_base * (2.0 * math.pi * f) ** 2, **blocked)
    block = on_springs("block", springs, RigidBody.at_height(m, h, inertia, 1.0, 1.0), ξ)
    largest = A * (1.0 + math.exp(-math.pi * ξ / math.sqrt(1.0 - ξ**2)))
    dt, listed = 1e-4, [0.5 * f, f, 2.0 * f]
    jump = AnchorSpectrum.of_motion(
        "rx", np.full(round(2.0 / dt), A), dt, listed, [0.02, ξ], method="in-step"
    )
    rows.add("ordinate at its frequency", largest, float(jump.curve(ξ)[1]), "rad/s2", 1e-9)
    found = spectrum_analysis(block, [jump], Rules())
    rows.add("moment x", about_base * largest, found.value("moment x"), "N m", 1e-9)
    rows.add("force y", m * h * largest, found.value("force y"), "N", 1e-9)
    along = spectrum_analysis(block, [replace(jump, component="y")], Rules())
    rows.add("moment x, base along y", m * h * largest, along.value("moment x"), "N m", 1e-9)


@benchmark("device on two supports", "closed form")
def two_supports(rows: Rows) -> None:
    """A mass between two anchors that move independently, and their displacements.

    With springs k₁ and k₂ on either side the mass follows each anchor by k_i / (k₁ + k₂): the
    absolute acceleration is the root of the squares of S_i k_i / (k₁ + k₂), and a displacement Δ of
    one anchor against the other presses both with k₁ k₂ / (k₁ + k₂) Δ.
    """
    k = np.array([3.0e6, 1.0e6])
    device = mass_between(k, 500.0)
    spectra = [flat("y", 6.0, 1, 0.002), flat("y", 4.0, 2)]
    q = own_accelerations(device) + anchor_forces(device)
    apart, step, sums = (
        spectrum_analysis(device, spectra, rules, q)
        for rules in (Rules(), Rules(supports="algebraic"), Rules(supports="abs"))
    )
    share = k / k.sum()
    between = k.prod() / k.sum() * 0.002
    independent = math.hypot(6.0 * share[0], 4.0 * share[1])
    together = 6.0 * share[0] + 4.0 * share[1]
    # Mass times its acceleration, less what the anchors' own springs carry, reaches anchor 1.
    both = math.hypot(500.0 * share[0] * independent, between)
    own, at_anchor = "acceleration mass y", "force y at anchor 1"
    moved = apart.displacement[apart.quantities.names.index(at_anchor)]
    rows.add("acceleration, supports independent", independent, apart.value(own), "m/s2", 1e-10)
    rows.add("acceleration, supports together", together, step.value(own), "m/s2", 1e-10)
    rows.add("acceleration, absolute values", together, sums.value(own), "m/s2", 1e-10)
    rows.add("force at anchor 1 by its displacement of 2 mm", between, moved, "N", 1e-10)
    rows.add("force at anchor 1, both parts", both, apart.value(at_anchor), "N", 1e-10)


@benchmark("SDLD30 as a device", "code_aster validation manual V2.01.030 (SDLD30), analytical")
def sdld30(rows: Rows) -> None:
    """SDLD30: two masses and three springs between two supports with spectra of their own.

    The modes, the supports, and the displacements of the supports each by the root of the sum of
    squares.
    """
    springs, masses = [1000.0, 1000.0, 10000.0], [0.0, 10.0, 10.0, 0.0]
    device = in_line("SDLD30", springs, masses, {0: 0, 3: 6}, 0.05, ("NO2 x", "NO3 x"))
    # Spectra of the supports NO1 and NO4 [m/s2] at the frequencies of the modes.
    at, xi = np.array([2.18815, 5.30485]), np.array([0.05])
    spectra = [
        AnchorSpectrum("x", at, xi, np.array([psa]), psa[-1], anchor, shift)
        for anchor, psa, shift in zip((1, 2), ((7.0, 5.0), (12.0, 6.0)), SDLD30_SHIFTS, strict=True)
    ]
    names, zero = ("displacement of NO2", "displacement of NO3"), np.zeros((2, 12))
    moved = Quantities(names, ("m", "m"), np.eye(2), zero, device.r)
    wanted = moved + anchor_forces(device)
    found = spectrum_analysis(device, spectra, Rules(modes="srss"), wanted)
    for (name, unit, *references), own in zip(
        SDLD30_TABLE, (*names, "force x at anchor 1", "force x at anchor 2"), strict=True
    ):
        k = wanted.names.index(own)
        quantities = [f"{name}, {part}" for part in ("inertia", "supports apart", "both")]
        values = [found.inertial[k], found.displacement[k], found.total[k]]
        # Allowed is what the digits of the reference are worth.
        rows.add(quantities, references, values, unit, 1e-5)


@benchmark(
    "mass on two shaken supports",
    "closed form: steady state of an oscillator on two springs, 15 Hz, 63 degrees apart",
)
def harmonic_supports(rows: Rows) -> None:
    """A mass on two springs whose ends move as u₁ sin Ω t and u₂ sin (Ω t + φ).

    With the springs' share Y = (k₁ U₁ + k₂ U₂) / (k₁ + k₂) of the complex amplitudes U, the mass
    moves against Y by X = Ω² Y / (ω² - Ω² + 2 j ξ ω Ω), and the device pulls at its anchor i with
    k_i (Y + X - U_i) + 2 j ξ ω Ω m X k_i / (k₁ + k₂). The motion begins slowly; it is read once
    what this sets free has died away.
    """
    m, k, damping = 400.0, np.array([5.0e6, 2.0e6]), 0.05
    U, phase, drive = np.array([0.002, 0.003]), 1.1, 2.0 * math.pi * 15.0
    device = mass_between(k, m)
    dt, cycles = 2e-4, 60
    t = np.arange(0.0, cycles * 2.0 * math.pi / drive, dt)
    # A smooth start over 20 cycles, in displacement; its second derivative by the product rule.
    s = np.minimum(t * drive / (40.0 * math.pi), 1.0)
    rate = drive / (40.0 * math.pi)
    rise = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    slope = np.where(s < 1.0, 30.0 * s**2 * (1.0 - s) ** 2 * rate, 0.0)
    bend = np.where(s < 1.0, 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * rate**2, 0.0)
    a, u = np.zeros((2, 12, t.size))
    for row, size, lag in ((1, U[0], 0.0), (7, U[1], phase)):
        angle = drive * t + lag
        u[row] = size * rise * np.sin(angle)
        a[row] = size * (
            (bend - rise * drive**2) * np.sin(angle) + 2.0 * slope * drive * np.cos(angle)
        )
    force = anchor_force(device, a, dt, displacement=u).force
    steady = t > 45.0 * 2.0 * math.pi / drive
    both = U * np.exp(1j * np.array([0.0, phase]))
    # The damper acts on the motion against where the anchors carry the mass.
    carried = k @ both / k.sum()
    omega = math.sqrt(k.sum() / m)
    x = drive**2 * carried / (omega**2 - drive**2 + 2j * damping * omega * drive)
    pull = k * (carried + x - both) + (k / k.sum()) * 2j * damping * omega * m * drive * x
    largest = np.abs(force[[1, 7]][:, steady]).max(axis=1)
    quantities = ["largest force at support 1", "largest force at support 2"]
    rows.add(quantities, np.abs(pull), largest, "N", 2e-4)


@benchmark("spectra against direct integration", "direct integration under white noise")
def device_under_noise(rows: Rows) -> None:
    """Response spectrum analysis against direct integration under white noise.

    The paper's device, whose two modes are far apart: largest forces under 60 motions. A pair of
    close modes, where SRSS is 40 % off: mean squares over one long motion, for which CQC is made.
    """
    rng, dt, limit = np.random.default_rng(11), 1e-3, 1000.0
    pump = paper_device(8.0e7)
    modes = device_modes(pump).below(limit)
    along = modes.effective_mass[1] > 1.0
    direct, cqc, loss = [], [], 0.0
    for _ in range(60):
        motion = np.zeros((6, 6000))
        # At rest at the end: spectra follow the free vibration after it.
        motion[1, 1:-200] = rng.standard_normal(5799)
        response = anchor_force(pump, motion, dt, maximum_frequency=limit)
        spectrum = AnchorSpectrum.of_motion(
            "y", motion[1], dt, modes.frequency, modes.damping, method="in-step"
        )
        found = spectrum_analysis(pump, [spectrum], Rules(maximum_frequency=limit))
        direct.append(response.largest[1])
        cqc.append(found.value("force y"))
        sampled = np.max(np.abs(response.modal), axis=1)[along] * modes.omega[along] ** 2
        exact = (np.abs(modes.participation[1]) * found.inputs[0].ordinate)[along]
        loss = max(loss, float(np.max(1.0 - sampled / exact)))
    quantity = "mean of CQC over largest shear force, 60 motions, device of the paper"
    rows.add(quantity, 1.0, np.mean(cqc) / np.mean(direct), "-", 0.05)
    quantity = "largest loss of a mode's peak at the samples, device of the paper"
    bound = 1.0 - math.cos(math.pi * 82.9 * dt)
    rows.add(quantity, 0.0, loss, "-", bound, "bound of a sampled peak")
    # The modes' root mean squares over that of their sum, in one motion of 800 s: a mass of 1000 kg
    # at 10 Hz carries one of 10 kg at 10 Hz, so that the frequencies are 10 % apart.
    k = np.array([1000.0, 10.0]) * (2.0 * math.pi * 10.0) ** 2
    pair, noise = in_line("pair", k, [0.0, 1000.0, 10.0], {0: 1}, 0.05), np.zeros((6, 400_000))
    noise[1, 1:] = rng.standard_normal(399_999)
    response = anchor_force(pair, noise, 2e-3)
    carried = own_accelerations(pair).own[1] @ response.modes.shape
    parts = carried[:, None] * response.modal
    sizes = parts.std(axis=1) * np.sign(carried * response.modes.participation[1])
    combined = combine_modes(sizes, response.modes.frequency, response.modes.damping, "cqc")
    quantity = "CQC of mean squares, two close modes, over direct integration"
    rows.add(quantity, 1.0, combined / parts.sum(axis=0).std(), "-", 0.03)
