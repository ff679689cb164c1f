"""Response spectrum analysis of devices: published, closed-form and direct references."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_continuous_lyapunov

from impactfem.device.anchor_force import anchor_force, own_weight, ring_tension
from impactfem.device.body import Body
from impactfem.device.combination import Combination, combine_modes, correlation
from impactfem.device.device import Device
from impactfem.device.from_matrices import from_matrices
from impactfem.device.modes import device_modes
from impactfem.device.on_springs import on_springs
from impactfem.device.quantity import anchor_forces, own_accelerations, own_motions
from impactfem.device.rigid_response import Gupta, LindleyYow
from impactfem.device.rules import Rules
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.device.springs import BaseSprings
from impactfem.verify.devices.device import chain, paper_device
from impactfem.verify.row import Row
from impactfem.verify.spectra import SDLD25_FREQUENCY, SDLD25_SOURCE, SDLD25_SPECTRA

Array = npt.NDArray[np.float64]

NO_END = np.array([1e-3, 1e5])  # Hz, for flat spectra


def flat(
    component: str, value: float, anchor: int = 1, displacement: float = 0.0
) -> AnchorSpectrum:
    """A spectrum with one ordinate, its zero-period acceleration."""
    damping = np.array([0.0, 0.99])
    return AnchorSpectrum(
        component, NO_END, damping, np.full((2, 2), value), value, anchor, displacement
    )


def sdld25() -> list[Row]:
    """SDLD25: absolute accelerations of eight masses between two ends that move together."""
    device = chain()
    spectra = [
        AnchorSpectrum(
            "x",
            np.array(SDLD25_FREQUENCY),
            np.array(list(SDLD25_SPECTRA)),
            np.array(list(SDLD25_SPECTRA.values())),
            1.0,
            anchor,
        )
        for anchor in (1, 2)
    ]
    modes = device_modes(device)
    rows = [
        Row(
            "SDLD25 as a device",
            f"frequency of mode {n}",
            math.sqrt(1e4) * math.sin(n * math.pi / 18.0) / math.pi,
            float(modes.frequency[n - 1]),
            "Hz",
            1e-12,
            "closed form of a uniform chain",
        )
        for n in (1, 4, 8)
    ]
    # The second row was computed for the same model independently of this program.
    for rule, published, allowed, source in (
        ("srss", (10.4498435, 19.0299477, 25.3176949, 28.9453548), 5e-8, SDLD25_SOURCE),
        (
            "cqc",
            (10.455874, 19.031803, 25.317302, 28.942301),
            1e-7,
            f"independent recomputation of the model of {SDLD25_SOURCE}",
        ),
    ):
        found = spectrum_analysis(
            device,
            spectra,
            Rules(modes="srss" if rule == "srss" else "cqc", supports="algebraic"),
            own_accelerations(device),
        )
        rows += [
            Row(
                "SDLD25 as a device",
                f"absolute acceleration of P{i + 1}, {rule.upper()}",
                reference,
                float(found.total[i]),
                "m/s2",
                allowed,  # five units of the ninth digit, one of the eighth
                source,
            )
            for i, reference in enumerate(published)
        ]
    return rows


def correlation_coefficients() -> list[Row]:
    """CQC's coefficients beside the covariance of two oscillators under white noise.

    The covariance P of the states solves A P + P Aᵀ + B Bᵀ = 0; the coefficient is the correlation
    of the two displacements. Nothing of the closed form is used.
    """
    rows = []
    for f, xi in (
        ((10.0, 10.5), (0.02, 0.02)),
        ((10.0, 12.0), (0.05, 0.01)),
        ((30.51, 82.90), (0.0199, 0.0204)),
        ((5.0, 5.0), (0.02, 0.10)),
    ):
        A, B = np.zeros((4, 4)), np.array([[0.0], [1.0], [0.0], [1.0]])
        for i in range(2):
            omega = 2.0 * np.pi * f[i]
            A[2 * i, 2 * i + 1] = 1.0
            A[2 * i + 1, 2 * i : 2 * i + 2] = -(omega**2), -2.0 * xi[i] * omega
        P = solve_continuous_lyapunov(A, -B @ B.T)
        rows.append(
            Row(
                "CQC coefficient",
                f"{f[0]:g} Hz at {xi[0]:.2%} and {f[1]:g} Hz at {xi[1]:.2%}",
                float(P[0, 2] / math.sqrt(P[0, 0] * P[2, 2])),
                float(correlation("cqc", np.array(f), np.array(xi))[0, 1]),
                "-",
                1e-11,
                "Lyapunov equation of two oscillators under white noise (Der Kiureghian 1981)",
            )
        )
    return rows


def combination_rules() -> list[Row]:
    """The other rules on three modes, by hand: 10, 10.8 and 11.5 Hz with R = 3, -4 and 12."""
    R, f, xi = np.array([3.0, -4.0, 12.0]), np.array([10.0, 10.8, 11.5]), np.full(3, 0.02)
    rate = [0.02 * 2.0 * math.pi * one + 2.0 / 10.0 for one in f]
    shift = [2.0 * math.pi * one * math.sqrt(1.0 - 0.02**2) for one in f]
    double = 9.0 + 16.0 + 144.0
    for i, j in ((0, 1), (0, 2), (1, 2)):
        gap = (shift[j] - shift[i]) / (rate[i] + rate[j])
        double += 2.0 * R[i] * R[j] / (1.0 + gap**2)
    source = "by hand; US NRC Regulatory Guide 1.92, revisions 1 (1976) and 2 (2006)"
    cases: list[tuple[str, Combination, float]] = [
        ("absolute values", "abs", 19.0),
        ("squares", "srss", 13.0),
        # 10 and 10.8, 10.8 and 11.5 Hz are close; 10 and 11.5 Hz are not.
        ("ten per cent", "ten-percent", math.sqrt(169.0 + 2.0 * 12.0 + 2.0 * 48.0)),
        # The first group ends at 11 Hz.
        ("grouping", "grouping", math.sqrt(49.0 + 144.0)),
        ("double sum, 10 s", "dsc", math.sqrt(double)),
    ]
    return [
        Row(
            "combination of modes",
            words,
            reference,
            float(combine_modes(R, f, xi, rule, 10.0)),
            "-",
            1e-12,
            source,
        )
        for words, rule, reference in cases
    ]


def static_load() -> list[Row]:
    """Missing mass: a slow acceleration presses on the device as a static load does.

    A spectrum that is flat at 2 m/s2 is that of a motion slow for all modes; whatever modes are
    used, their rigid parts and the missing mass add up to the static force.
    """
    device = paper_device(8.0e7)
    q = anchor_forces(device) + own_motions(device, "base")
    load = -2.0 * device.L[:, 1]
    at_rest = np.linalg.solve(device.K, load)
    wanted = {
        "force y": -2.0 * 1545.9,
        # 1500 kg at 0.46 m and 45.9 kg at half of it; a rotation about x moves it along -y.
        "moment x": 2.0 * (1500.0 * 0.46 + 45.9 * 0.23),
        "displacement base y": float(at_rest[device.motions.index("base y")]),
        "displacement base rx": float(at_rest[device.motions.index("base rx")]),
    }
    rows = []
    for words, limit in (("no mode", 20.0), ("one pair of modes", 50.0), ("two pairs", 1000.0)):
        rules = Rules(rigid=Gupta(1e-3, 2e-3), maximum_frequency=limit)
        found = spectrum_analysis(device, [flat("y", 2.0)], rules, q)
        rows += [
            Row(
                "missing mass under a static load",
                f"{name}, {words} used",
                abs(reference),
                found.value(name),
                q.units[q.names.index(name)],
                1e-10,
                "statics",
            )
            for name, reference in wanted.items()
        ]
    return rows


def rigid_response() -> list[Row]:
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
    source = "statics: F = m ZPA, as RG 1.92 (revision 3, C.1.3) has it of rigid modes"
    name, rows = "rigid response", []
    for method in (Gupta(), LindleyYow()):
        for rule in ("srss", "cqc"):
            rules = Rules(modes=rule, rigid=method, maximum_frequency=1e3)
            found = spectrum_analysis(device, [floor], rules)
            words = f"{type(method).__name__} with {rule.upper()}"
            for quantity, reference, unit in (("force y", force, "N"), ("moment x", moment, "N m")):
                value = found.value(quantity)
                rows.append(Row(name, f"{quantity}, {words}", reference, value, unit, 1e-9, source))
    alone = spectrum_analysis(device, [floor], Rules(modes="srss", maximum_frequency=1e3))
    lower, what = zpa * math.hypot(1218.9, 327.0), "force y, SRSS without a rigid part"
    masses = "√(m₁² + m₂²) ZPA with the masses of table 6: 18 % lower"
    rows.append(Row(name, what, lower, alone.value("force y"), "N", 2e-4, masses))
    # At 12 Hz the modes are half periodic: α by hand for both methods, S between 9 and 2 m/s2.
    S = 9.0 * (2.0 / 9.0) ** (math.log(12.0 / 8.0) / math.log(25.0 / 8.0))
    at, xi = np.array([12.0]), np.array([0.02])
    corners = (9.0 / (9.0 / 4.0), (4.0 + 2.0 * 25.0) / 3.0)
    partly = math.log(12.0 / corners[0]) / math.log(corners[1] / corners[0])
    for words, found_alpha, reference in (
        ("Gupta", Gupta().fraction(floor, at, xi, np.array([S])), partly),
        ("LindleyYow", LindleyYow().fraction(floor, at, xi, np.array([S])), zpa / S),
    ):
        what = f"rigid part at 12 Hz, {words}"
        value = float(found_alpha[0])
        rows.append(Row(name, what, reference, value, "-", 1e-9, "by hand from the spectrum"))
    return rows


def net_tension() -> list[Row]:
    """The paper's device under an acceleration that stays: what eight anchors on its rim bear.

    The floor accelerates by 4 m/s2 along y and 3 m/s2 downward. Forces by hand; then a rigid plate
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
    return [
        Row("net tension at the anchor", what, reference, value, unit, tolerance, source)
        for what, reference, value, unit, tolerance, source in (
            ("force z with the weight", N, float(whole[2]), "N", 1e-9, "by hand, g = 9.80665 m/s2"),
            ("moment x", M, float(whole[3]), "N m", 1e-9, "by hand"),
            ("N + 2 M / r", N + 2.0 * M / radius, tension, "N", 1e-9, "by hand"),
            ("eight springs on a circle", largest, tension, "N", 1e-9, "a rigid plate on springs"),
        )
    ]


def rocking_floor() -> list[Row]:
    """Rotational spectra: a mass at the height h feels the rotation θ of its anchor as -h θ."""
    h, mass, blocked = 0.7, 800.0, math.inf
    springs = BaseSprings.of_directions(
        x=blocked,
        y=mass * (2.0 * math.pi * 12.0) ** 2,
        z=blocked,
        rx=blocked,
        ry=blocked,
        rz=blocked,
    )
    device = on_springs("mass", springs, Body.at_height(mass, h, 1e-6, 1e-6, 1e-6), 0.02)
    rows = []
    for words, spectra, rule, reference in (
        ("a translation of 5 m/s2", [flat("y", 5.0)], "srss", mass * 5.0),
        ("a rotation of 5/h rad/s2", [flat("rx", 5.0 / h)], "srss", mass * 5.0),
        (
            "both, as independent",
            [flat("y", 5.0), flat("rx", 5.0 / h)],
            "srss",
            mass * math.hypot(5.0, 5.0),
        ),
        ("both, in step", [flat("y", 5.0), flat("rx", 5.0 / h)], "abs", mass * 10.0),
    ):
        rules = Rules(rotations="abs" if rule == "abs" else "srss")
        rows.append(
            Row(
                "device on a rocking floor",
                f"F_y under {words}",
                reference,
                spectrum_analysis(device, spectra, rules).value("force y"),
                "N",
                1e-9,
                "closed form: one oscillator at the height h",
            )
        )
    return rows


def two_supports() -> list[Row]:
    """A mass between two anchors that move independently, and their displacements.

    With springs k₁ and k₂ on either side the mass follows each anchor by k_i / (k₁ + k₂): the
    absolute acceleration is the root of the squares of S_i k_i / (k₁ + k₂), and a displacement Δ of
    one anchor against the other presses both with k₁ k₂ / (k₁ + k₂) Δ.
    """
    k = np.array([3.0e6, 1.0e6])
    K = np.array([[k[0], -k[0], 0.0], [-k[0], k.sum(), -k[1]], [0.0, -k[1], k[1]]])
    device = from_matrices(
        "mass", np.diag([0.0, 500.0, 0.0]), K, {0: 1, 2: 7}, 0.05, anchors=2, motions=("mass y",)
    )
    spectra = [flat("y", 6.0, 1, 0.002), flat("y", 4.0, 2)]
    q = own_accelerations(device) + anchor_forces(device)
    apart = spectrum_analysis(device, spectra, Rules(), q)
    step = spectrum_analysis(device, spectra, Rules(supports="algebraic"), q)
    sums = spectrum_analysis(device, spectra, Rules(supports="abs"), q)
    share = k / k.sum()
    between = k.prod() / k.sum() * 0.002
    name, source = "device on two supports", "closed form"
    # Mass times its acceleration, less what the anchors' own springs carry, reaches anchor 1.
    inertia = 500.0 * share[0] * math.hypot(6.0 * share[0], 4.0 * share[1])
    return [
        Row(name, what, float(reference), float(computed), unit, 1e-10, source)
        for what, reference, computed, unit in (
            (
                "acceleration, supports independent",
                math.hypot(6.0 * share[0], 4.0 * share[1]),
                apart.value("acceleration mass y"),
                "m/s2",
            ),
            (
                "acceleration, supports together",
                6.0 * share[0] + 4.0 * share[1],
                step.value("acceleration mass y"),
                "m/s2",
            ),
            (
                "acceleration, absolute values",
                6.0 * share[0] + 4.0 * share[1],
                sums.value("acceleration mass y"),
                "m/s2",
            ),
            (
                "force at anchor 1 by its displacement of 2 mm",
                between,
                apart.displacement[apart.quantities.names.index("force y at anchor 1")],
                "N",
            ),
            (
                "force at anchor 1, both parts",
                math.hypot(inertia, between),
                apart.value("force y at anchor 1"),
                "N",
            ),
        )
    ]


def close_pair() -> Device:
    """A mass of 1000 kg at 10 Hz that carries one of 10 kg at 10 Hz: two modes 10 % apart."""
    large, small, omega = 1000.0, 10.0, 2.0 * math.pi * 10.0
    k, c = large * omega**2, small * omega**2
    K = np.array([[k, -k, 0.0], [-k, k + c, -c], [0.0, -c, c]])
    return from_matrices("pair", np.diag([0.0, large, small]), K, {0: 1}, 0.05)


def noise_against_spectra() -> list[Row]:
    """Response spectrum analysis beside direct integration under white noise.

    The paper's device, whose two modes are far apart: largest forces under 60 motions. A pair of
    close modes, where SRSS is 40 % off: mean squares over one long motion, for which CQC is made.
    """
    rng = np.random.default_rng(11)
    dt = 1e-3
    mean, loss = _device_under_noise(rng, dt)
    squares = _pair_under_noise(rng)
    name, source = "spectra against direct integration", "direct integration under white noise"
    return [
        Row(
            name,
            "mean of CQC over largest shear force, 60 motions, device of the paper",
            1.0,
            mean,
            "-",
            0.05,
            source,
        ),
        Row(
            name,
            "largest loss of a mode's peak at the samples, device of the paper",
            0.0,
            loss,
            "-",
            1.0 - math.cos(math.pi * 82.9 * dt),
            "bound of a sampled peak",
            absolute=True,
        ),
        Row(
            name,
            "CQC of mean squares, two close modes, over direct integration",
            1.0,
            squares,
            "-",
            0.03,
            source,
        ),
    ]


def _device_under_noise(rng: np.random.Generator, dt: float) -> tuple[float, float]:
    """The paper's device under 60 motions.

    Returns:
        Mean of the largest shear forces by CQC over that by direct integration, and the largest
        loss of a mode's peak at the samples.
    """
    runs, limit = 60, 1000.0
    pump = paper_device(8.0e7)
    modes = device_modes(pump).below(limit)
    along = modes.effective_mass[1] > 1.0
    direct, cqc, loss = [], [], 0.0
    for _ in range(runs):
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
    return float(np.mean(cqc) / np.mean(direct)), loss


def _pair_under_noise(rng: np.random.Generator) -> float:
    """CQC of the modes' root mean squares over that of the sum, in one motion of 800 s."""
    pair = close_pair()
    noise = np.zeros((6, 400_000))
    noise[1, 1:] = rng.standard_normal(399_999)
    response = anchor_force(pair, noise, 2e-3)
    carried = own_accelerations(pair).own[1]
    parts = (carried @ response.modes.shape)[:, None] * response.modal
    sizes = parts.std(axis=1) * np.sign(
        carried @ response.modes.shape * response.modes.participation[1]
    )
    combined = combine_modes(sizes, response.modes.frequency, response.modes.damping, "cqc")
    return float(combined) / float(parts.sum(axis=0).std())
