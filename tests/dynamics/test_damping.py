import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics.damping import (
    UNDAMPED,
    Caughey,
    ModeRatios,
    RatioTable,
    Rayleigh,
    checked_ratio,
)
from impactfem.system.errors import ImpactfemError


def test_ratio_by_hand():
    # α / (2 ω) + β ω / 2 at ω = 2π 2 Hz.
    assert Rayleigh(0.5, 0.0).ratio(2.0) == pytest.approx(0.5 / (8 * np.pi))
    assert Rayleigh(0.0, 1e-3).ratio(2.0) == pytest.approx(2 * np.pi * 1e-3)
    assert Rayleigh(0.0, 0.0).ratio(2.0) == 0.0


def test_ratio_is_the_decay_of_the_oscillator():
    alpha, beta, m, k = 0.838, 1.06e-3, 3.0, 3.0 * (2 * np.pi * 7.3) ** 2
    c = alpha * m + beta * k
    pole = np.linalg.eigvals(np.array([[0.0, 1.0], [-k / m, -c / m]]))[0]
    found = Rayleigh(alpha, beta).ratio(7.3)
    assert found == pytest.approx(-pole.real / abs(pole), rel=1e-12)
    assert abs(found - Rayleigh(alpha, 2 * beta).ratio(7.3)) > 0.01


def test_two_per_cent_at_30_and_80_hz():
    damping = Rayleigh.through(0.02, 30.0, 80.0)
    assert damping.ratio([30.0, 80.0]) == pytest.approx([0.02, 0.02], rel=1e-12)
    # The lowest ratio is at the geometric mean.
    assert damping.ratio(np.sqrt(2400.0)) < damping.ratio([45.0, 55.0]).min()
    assert damping.ratio(300.0) > 0.05


LAWS = {
    "rayleigh": Rayleigh(0.5, 2e-3),
    "constant": RatioTable.constant(0.04),
    "table": RatioTable((0.5, 2.0, 8.0), (0.02, 0.08, 0.05)),
    "caughey": Caughey((0.5, 2.0, 8.0, 12.0), (0.05, 0.04, 0.04, 0.05)),
    "modes": ModeRatios((0.01, 0.2), Rayleigh(0.5, 2e-3)),
}


@pytest.mark.parametrize("name", LAWS)
def test_each_mode_decays_by_its_ratio(name, chain):
    """By exp(-2πξ) in a cycle 2π/ω, as the matrix exponential of M, C, K says."""
    law, n = LAWS[name], 5
    M, K = np.diag(np.linspace(1.0, 2.0, n)), 700.0 * chain(n, last=False)
    eigenvalue, shapes = scipy.linalg.eigh(K, M)
    omega, d = np.sqrt(eigenvalue), law.modal(eigenvalue)
    C = law.matrix(K, M)
    assert np.abs(shapes.T @ C @ shapes - np.diag(d)).max() < 1e-12 * d.max()
    inverse = np.linalg.inv(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ C]])
    for k in range(n):
        xi = law.ratios[k] if name == "modes" and k < 2 else float(law.ratio(omega[k] / 2 / np.pi))
        # x = Re exp((-ξ + i√(1-ξ²)) ωt): after one damped cycle it is smaller by a known factor.
        damped = omega[k] * np.sqrt(1.0 - xi**2)
        start = np.concatenate([shapes[:, k], -xi * omega[k] * shapes[:, k]])
        after = scipy.linalg.expm(A * 2.0 * np.pi / damped) @ start
        decay = float(shapes[:, k] @ M @ after[:n]) ** (damped / omega[k])
        assert decay == pytest.approx(np.exp(-2.0 * np.pi * xi), rel=1e-8)
        assert abs(decay / np.exp(-2.0 * np.pi * 1.001 * xi) - 1.0) > 1e-6


def test_a_table_is_straight_in_the_logarithm_of_the_frequency():
    law = RatioTable((1.0, 10.0, 100.0), (0.02, 0.04, 0.10))
    middle = np.sqrt(10.0)
    found = law.ratio([0.0, 0.1, 1.0, middle, 10.0 * middle, 100.0, 1e4])
    assert found == pytest.approx([0.02, 0.02, 0.02, 0.03, 0.07, 0.10, 0.10])
    omega = 2.0 * np.pi * middle
    assert law.modal(np.array([omega**2, 0.0])) == pytest.approx([0.06 * omega, 0.0])


def test_two_terms_of_caughey_are_rayleigh():
    law, same = Caughey((1.0, 20.0), (0.07, 0.07)), Rayleigh.through(0.07, 1.0, 20.0)
    frequency = np.geomspace(0.1, 1e3, 30)
    assert law.ratio(frequency) == pytest.approx(same.ratio(frequency), rel=1e-12)
    # Six points on the curve are no more than two.
    six = np.geomspace(0.5, 300.0, 6)
    on_it = Caughey(tuple(six), tuple(same.ratio(six)))
    assert on_it.ratio(frequency) == pytest.approx(same.ratio(frequency), rel=1e-10)
    many = Caughey((1.0, 4.0, 20.0), (0.07, 0.02, 0.07))
    assert many.ratio([1.0, 4.0, 20.0]) == pytest.approx([0.07, 0.02, 0.07], rel=1e-12)
    # Chopra, Dynamics of Structures, equation 11.4.16: d = 2 ξ ω = Σ a_l ω^2l.
    omega = 2.0 * np.pi * np.array([1.0, 4.0, 20.0])
    a = np.linalg.solve(np.array([[1.0, w**2, w**4] for w in omega]), 2.0 * omega * many.ratios)
    w = 2.0 * np.pi * 9.0
    assert float(many.ratio(9.0)) == pytest.approx((a[0] / w + a[1] * w + a[2] * w**3) / 2.0)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_what_has_no_mass(count, chain):
    """Rayleigh's own curve as a table gives Rayleigh's matrix, massless rows included."""
    n, own = 6, Rayleigh(0.5, 2e-3)
    K, M = 900.0 * chain(n, last=False), np.diag(np.linspace(1.0, 2.0, n))
    M[2, 2] *= count < 1
    M[4, 4] *= count < 2
    c = np.flatnonzero(np.diag(M))
    condensed = np.linalg.inv(np.linalg.inv(K)[np.ix_(c, c)])
    eigenvalue = scipy.linalg.eigvalsh(condensed, M[np.ix_(c, c)])
    frequency = np.sqrt([*eigenvalue, 4.0 * eigenvalue[-1]]) / (2.0 * np.pi)
    table = RatioTable(tuple(frequency), tuple(own.ratio(frequency)))
    C = 0.5 * M + 2e-3 * K
    assert np.abs(table.matrix(K, M) - C).max() < 1e-12 * np.abs(C).max()
    assert np.abs(own.matrix(K, M) - C).max() < 1e-14 * np.abs(C).max()
    other = RatioTable(tuple(frequency), tuple(1.01 * own.ratio(frequency)))
    assert np.abs(other.matrix(K, M) - C).max() > 5e-3 * np.abs(C).max()


def test_what_has_no_mass_is_damped_where_the_ratio_falls():
    """The slope of a law whose ratio falls by more than half within an octave is negative."""
    top = np.array([1.0, (2.0 * np.pi * 50.0) ** 2])
    falling = RatioTable((1.0, 50.0, 100.0), (0.1, 0.1, 0.02))
    ends = falling.modal(top[1] * np.array([1.0, 4.0]))
    assert ends[1] < ends[0]
    constant = RatioTable.constant(0.02).stiffness_part(top)
    assert falling.stiffness_part(top) == pytest.approx(constant, rel=1e-12)
    assert constant > 0.0


def test_only_rayleigh_has_coefficients():
    assert Rayleigh(0.5, 2e-3).coefficients == (0.5, 2e-3)
    assert np.all(np.isnan(LAWS["table"].coefficients))
    assert UNDAMPED.rayleigh is UNDAMPED
    with pytest.raises(ImpactfemError, match="expected Rayleigh damping"):
        _ = LAWS["table"].rayleigh


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("make", "words", "wrong"),
    [
        (checked_ratio, "expected 0 <= ratio < 1", [(xi,) for xi in (1.0, 1.5, -0.01, NAN)]),
        (Rayleigh.through, "expected 0 <= ratio < 1", [(1.0, 30.0, 80.0)]),
        (RatioTable.constant, "expected 0 <= ratio < 1", [(1.0,)]),
        (ModeRatios, "expected 0 <= ratio < 1", [((-0.1,), UNDAMPED)]),
        (
            Rayleigh.through,
            "expected two frequencies, the lower first",
            [(0.02, *f) for f in ((80.0, 30.0), (0.0, 30.0), (30.0, 30.0), (30.0, INF))],
        ),
        (Rayleigh, "finite and not negative", [(-1.0, 0.0), (0.0, -1e-9), (NAN, 0.0)]),
        (
            RatioTable,
            "ascending frequencies above zero",
            [((), ()), ((2.0, 1.0), (0.1, 0.1)), ((0.0, 1.0), (0.1, 0.1))],
        ),
        (RatioTable, "a ratio for each", [((1.0, 2.0), (0.1,))]),
        (RatioTable, "expected 0 or more", [((1.0,), (-0.1,)), ((1.0,), (NAN,))]),
        (Caughey, "expected 0 or more", [((1.0, 2.0), (0.1, -0.2))]),
        # Falls below zero between its points, and above the last one.
        (
            Caughey,
            "is negative at",
            [((1.0, 5.0, 20.0, 40.0), (0.2, 0.01, 0.01, 0.2)), ((1.0, 5.0), (0.1, 0.01))],
        ),
    ],
)
def test_what_is_refused(make, words, wrong):
    assert checked_ratio(0.99) == 0.99
    for arguments in wrong:
        with pytest.raises(ImpactfemError, match=words):
            make(*arguments)
