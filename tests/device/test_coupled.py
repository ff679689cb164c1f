import numpy as np
import pytest
import scipy.linalg

from impactfem.device.beam import Beam
from impactfem.device.coupled import coupled
from impactfem.device.from_matrices import from_matrices
from impactfem.system.errors import ImpactfemError

BEAM = Beam(0.46, 8e7, 8e7, mass=45.9)


@pytest.mark.parametrize("coordinates", ["absolute", "relative"])
def test_a_rigid_motion_costs_nothing(pump, coordinates):
    device = pump(BEAM, z=1e9, rz=1e7)
    found = coupled(device, coordinates)
    rigid = np.vstack([np.eye(6), device.r if coordinates == "absolute" else 0 * device.r])
    assert np.abs(found.K @ rigid).max() < 1e-12 * np.abs(found.K).max()
    assert np.abs(found.C @ rigid).max() < 1e-12 * np.abs(found.C).max()
    assert np.abs(found.own @ rigid).max() < 1e-12
    assert rigid.T @ found.M @ rigid == pytest.approx(device.J, abs=1e-9)
    dragged = coupled(device, coordinates, drag=True)
    assert rigid.T @ dragged.C @ rigid == pytest.approx(device.drag_coefficient() * device.J)
    assert np.array_equal(dragged.K, found.K) and np.array_equal(dragged.M, found.M)


def test_drag_is_rayleigh_damping_of_all_degrees_of_freedom(pump):
    device = pump(BEAM)
    found = coupled(device, "absolute", drag=True)
    wanted = device.damping.alpha * found.M + device.damping.beta * found.K
    size = np.abs(wanted).max()
    assert np.abs(found.C - wanted).max() < 1e-12 * size
    assert np.abs(coupled(device).C - wanted).max() > 1e-4 * size


def test_a_device_on_a_floor_is_one_model():
    """A floor and a device of two masses, put together by the interface and as one chain."""
    k, c, m, n = 4e5, 9e4, 30.0, 20.0
    K = np.array([[k, -k, 0.0], [-k, k + c, -c], [0.0, -c, c]])
    device = from_matrices("d", np.diag([0.0, m, n]), K, {0: 1}, 0.02)
    floor_mass, floor_stiffness = 500.0, 7e6
    whole_K = K.copy()
    whole_K[0, 0] += floor_stiffness
    wanted = scipy.linalg.eigvalsh(whole_K, np.diag([floor_mass, m, n]))
    y, others = 1, [6, 7]
    for coordinates in ("absolute", "relative"):
        part = coupled(device, coordinates)
        M, K_all = part.M.copy(), part.K.copy()
        M[y, y] += floor_mass
        K_all[y, y] += floor_stiffness
        keep = np.ix_([y, *others], [y, *others])
        assert scipy.linalg.eigvalsh(K_all[keep], M[keep]) == pytest.approx(wanted, rel=1e-10)
    assert part.interface == 6 and part.coordinates == "relative"


def test_bad_requests_are_refused(pump):
    with pytest.raises(ImpactfemError, match="the coordinates are one of"):
        coupled(pump(), "modal")
    with pytest.raises(ImpactfemError, match="it has no Rayleigh damping"):
        coupled(pump(damping=0.02), drag=True)
    assert coupled(pump(damping=0.02)).C.any()
