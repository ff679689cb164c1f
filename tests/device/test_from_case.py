"""Devices of a case file, and the rules of their analysis."""

import math
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import DeviceAnalysis, DeviceSetup, RayleighDamping, load_case
from impactfem.case.device_tables import DeviceMatrices, DeviceMode, GivenSpectrum, NamedMatrix
from impactfem.case.devices import BaseStiffness, Cylinder, DeviceBeam, DeviceSupport, RigidPart
from impactfem.device.combination import Gupta, LindleyYow, Rules
from impactfem.device.from_case import checked_devices, device_of, rules_of
from impactfem.device.modes import device_modes
from impactfem.system.errors import InputError
from one_building import building_of

GEOMETRY = Path(__file__).parents[2] / "geometry"
RIGID = dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), "rigid")
LIGHT = RayleighDamping(ratio=0.02, frequencies=(30.0, 80.0))
# β ω / 2 = 0.04 s · 20 π / s / 2
OVER = RayleighDamping(mass_coefficient=0.0, stiffness_coefficient=0.04)
BODY = {"mass": 100.0, "mass_height": 0.0, "inertia": (1.0, 1.0, 1.0)}


@pytest.fixture(scope="module")
def paper():
    return load_case(GEOMETRY / "npp_pair.toml")


def setup(**keys):
    """A mass on one spring along y, 10 Hz; its keys can be altered."""
    given = {
        "name": "mass",
        "point": (1.0, 2.0, 3.0),
        "radius": 0.5,
        "modes": None,
        "stiffness": BaseStiffness(**RIGID | {"y": 100.0 * (20.0 * math.pi) ** 2}),
        "damping": LIGHT,
    }
    return DeviceSetup(**given | BODY | keys)


def of_modes(*rows, **keys):
    return setup(**dict.fromkeys((*BODY, "stiffness")) | {"modes": rows} | keys)


def test_paper_s_device_has_the_modes_of_table_6(paper):
    (pump,) = checked_devices(building_of(paper))
    modes = device_modes(pump).below(paper.devices[0].maximum_frequency)
    for i in range(4):
        frequency, mass = (
            paper.published[f"device.{name}.{i + 1}"].value
            for name in ("frequency", "effective_mass")
        )
        assert modes.frequency[i] == pytest.approx(frequency, rel=2e-4)
        assert modes.effective_mass[:2, i].sum() == pytest.approx(mass, rel=1e-4)
    # 2 % at 30 and 80 Hz, and so about that at 30.5 and 82.9 Hz.
    assert modes.damping == pytest.approx(4 * [0.02], rel=0.02)


def test_spring_of_each_direction():
    device = device_of(setup())
    assert device.motions == ("base y",)
    modes = device_modes(device)
    assert modes.frequency == pytest.approx([10.0], rel=1e-12)
    # ξ = (α/ω + β ω)/2 with α = 2 ξ ω₁ ω₂ / (ω₁ + ω₂), β = 2 ξ / (ω₁ + ω₂).
    assert modes.damping == pytest.approx([0.02 * (30.0 * 80.0 / 10.0 + 10.0) / 110.0], rel=1e-12)
    turning = setup(stiffness=BaseStiffness(**RIGID | {"rz": (6.0 * math.pi) ** 2}))
    assert device_modes(device_of(turning)).frequency == pytest.approx([3.0], rel=1e-12)


def test_shape_of_a_cylinder():
    shape = Cylinder(type="cylinder", radius=2.0, length=6.0)
    device = device_of(setup(inertia=None, shape=shape, mass_height=1.0))
    # Solid cylinder: m (3 R² + l²) / 12 across, m R² / 2 along; and m h² about the anchor.
    assert np.diag(device.J) == pytest.approx([100.0, 100.0, 100.0, 500.0, 500.0, 200.0])


def test_beam_bends_the_right_way():
    """A massless cantilever with a point mass: ω² = 1 / (m (l³ / 3 E I + l / G A_v))."""
    beam = DeviceBeam(length=2.0, bending=(3e6, 6e6), shear=("rigid", 4e5), mass=0.0, elements=3)
    stiffness = BaseStiffness(**RIGID)
    point = setup(mass_height=2.0, inertia=(0.0, 0.0, 0.0), stiffness=stiffness, beam=beam)
    modes = device_modes(device_of(point))
    for axis, give in ((0, 8.0 / 3.0 / 6e6), (1, 8.0 / 3.0 / 3e6 + 2.0 / 4e5)):
        (mode,) = np.flatnonzero(modes.effective_mass[axis] > 1.0)
        assert modes.omega[mode] ** 2 == pytest.approx(1.0 / give / 100.0, rel=1e-9)
    # Both stretching and twisting are rigid unless given.
    assert not any(motion.endswith((" z", " rz")) for motion in device_of(point).motions)
    soft = beam.model_copy(update={"stretching": 1e5, "twisting": 1e5})
    motions = device_of(point.model_copy(update={"beam": soft})).motions
    assert {motion.rsplit(" ", 1)[1] for motion in motions} >= {"z", "rz"}


def test_table_of_modes():
    rows = (
        DeviceMode(frequency=8.0, direction="y", effective_mass=300.0, height=1.1),
        DeviceMode(frequency=12.0, direction="rx", effective_inertia=7.0, damping=0.05),
    )
    modes = device_modes(device_of(of_modes(*rows)))
    assert modes.frequency == pytest.approx([8.0, 12.0])
    assert modes.effective_mass[1] == pytest.approx([300.0, 0.0])
    assert modes.effective_mass[3] == pytest.approx([300.0 * 1.1**2, 7.0])
    assert modes.damping == pytest.approx([float(LIGHT.rayleigh.ratio(8.0)), 0.05])
    whole = {"mass": 500.0, "mass_height": 1.0, "inertia": (200.0, 200.0, 1.0)}
    assert device_of(of_modes(*rows, **whole)).J[1, 1] == pytest.approx(500.0)
    every = [row.model_copy(update={"damping": 0.03}) for row in rows]
    modes = device_modes(device_of(of_modes(*every, damping=None)))
    assert modes.damping == pytest.approx([0.03, 0.03])


def test_neither_body_nor_modes():
    bare = setup().model_copy(update={"stiffness": None})
    with pytest.raises(ValueError, match="no body"):
        device_of(bare)


def test_rules():
    """One run shows all: the combinations without and with each rigid part."""
    methods = {"none": None, "gupta": Gupta(5.0, 30.0), "lindley-yow": LindleyYow()}
    analysis = DeviceAnalysis(
        combination=("cqc", "dsc"),
        duration=4.0,
        rigid=RigidPart(method=tuple(methods), f1=5.0, f2=30.0),
        missing_mass=False,
        directions="100-40-40",
        time_step=1e-4,
    )
    common = {"duration": 4.0, "missing_mass": False, "maximum_frequency": 200.0}
    common |= {"directions": "100-40-40", "displacements": "abs", "whole": "abs"}
    found = rules_of(analysis, 200.0)
    assert found == {
        (modes, method): Rules(modes=modes, rigid=rigid, **common)
        for modes in ("cqc", "dsc")
        for method, rigid in methods.items()
    }
    assert list(found)[:2] == [("cqc", "none"), ("cqc", "gupta")]
    assert {one.rigid for one in rules_of(DeviceAnalysis(), 1e3).values()} == {None}


def with_devices(paper, *devices, **analysis):
    """The building of the paper with other devices."""
    own = {"building": paper.structure.building}
    update = {"devices": tuple(device.model_copy(update=own) for device in devices)}
    update["device_analysis"] = DeviceAnalysis(**analysis)
    return building_of(paper.model_copy(update=update))


def faults_of(building):
    with pytest.raises(InputError) as caught:
        checked_devices(building)
    assert {fault.file for fault in caught.value.faults} == {building.case.path}
    return {fault.key: f"{fault.value} {fault.expected}" for fault in caught.value.faults}


def test_every_fault_at_once(paper):
    assert checked_devices(with_devices(paper)) == []
    heavy = DeviceMode(frequency=8.0, direction="y", effective_mass=120.0)
    high = DeviceMode(frequency=8.0, direction="y", effective_mass=90.0, height=3.0)
    loose = BaseStiffness(**RIGID | {"rx": 1.0}).model_copy(update={"rx": 0.0})
    free = RayleighDamping(mass_coefficient=0.0, stiffness_coefficient=0.0)
    devices = {
        "too_much": (of_modes(heavy, **BODY), "its modes carry 120 kg along y, more than the 100"),
        "sound": (setup(), None),
        "over": (setup(damping=OVER), "at 10 Hz is damped by 126%; expected less than 100 %"),
        "loose": (setup(stiffness=loose), "a mechanism, no stiffness holds the motion base rx"),
        "high": (of_modes(high, **BODY), "of height 3 to 3 m, leave a part of it with a negative"),
        "free": (setup(damping=free), "a mode without damping; expected another combination"),
    }
    setups = [one.model_copy(update={"name": name}) for name, (one, _) in devices.items()]
    faults = faults_of(with_devices(paper, *setups))
    assert len(faults) == len(devices) - 1
    for k, (name, (_, words)) in enumerate(devices.items()):
        if words is not None:
            assert f"{name} device {name}: " in faults[f"devices[{k}]"]
            assert words in faults[f"devices[{k}]"]
    assert len(checked_devices(with_devices(paper, setups[-1], combination=("srss",)))) == 1


def test_a_maximum_frequency_below_all_modes(paper):
    with pytest.raises(InputError) as refused:
        checked_devices(with_devices(paper, setup(maximum_frequency=9.0)))
    (fault,) = refused.value.faults
    assert fault.key == "devices[0].maximum_frequency"
    assert str(fault).endswith("= '9 Hz': expected one above the first mode of the device, 10 Hz")


def test_overdamped_above_the_maximum_frequency(paper, caplog):
    # 10 Hz by 10 %, and 200 Hz by 200 %.
    law = RayleighDamping(mass_coefficient=0.0, stiffness_coefficient=0.2 / (20.0 * math.pi))
    springs = RIGID | {"y": 100.0 * (20.0 * math.pi) ** 2, "z": 100.0 * (400.0 * math.pi) ** 2}
    rigid = setup(stiffness=BaseStiffness(**springs), damping=law, maximum_frequency=100.0)
    assert len(checked_devices(with_devices(paper, rigid))) == 1
    assert not caplog.records
    # Without the missing mass these modes are in no response: said, not refused.
    assert len(checked_devices(with_devices(paper, rigid, missing_mass=False))) == 1
    assert "maximum_frequency, 100 Hz" in caplog.text


def pipe(held=0.0, **keys):
    """500 kg between two anchors, 14.2 Hz."""
    names = ("1.y", "tip", "2.y")
    k = ((3e6, -3e6, 0.0), (-3e6, 4e6, -1e6), (0.0, -1e6, 1e6 + held))
    m = ((0.0,) * 3, (0.0, 500.0, 0.0), (0.0,) * 3)
    supports = (DeviceSupport(point=(1.0, 2.0, z), radius=0.5) for z in (3.0, 6.0))
    given = {
        "name": "pipe",
        "supports": tuple(supports),
        "modes": None,
        "matrices": DeviceMatrices(mass=NamedMatrix(names, m), stiffness=NamedMatrix(names, k)),
        "damping": LIGHT,
    }
    return DeviceSetup(**given | keys)


def test_matrices_on_two_supports(paper):
    (device,) = checked_devices(with_devices(paper, pipe()))
    assert device.anchors == 2 and device.motions == ("tip",)
    assert device.r[0, [1, 7]] == pytest.approx([0.75, 0.25])
    wanted = math.sqrt(4e6 / 500.0) / (2 * math.pi)
    assert device_modes(device).frequency[0] == pytest.approx(wanted)
    with pytest.raises(InputError, match="them along y"):
        checked_devices(with_devices(paper, pipe(held=1e6)))


@pytest.mark.parametrize(
    ("frequency", "acceleration", "words"),
    [
        ((1.0, 50.0), (5.0, 5.0), None),
        ((20.0, 50.0), (5.0, 5.0), "begins at 20 Hz and does not reach the mode at 14.2"),
        # Below the mode at 14.2 Hz: the end of one is flat, that of the other still rises.
        ((1.0, 10.0), (5.0, 5.0), None),
        ((1.0, 10.0), (2.0, 5.0), "ends at 10 Hz, where it is not flat yet, and does not"),
        (None, (5.0, 5.0), "expected dampings on both sides of the modes'"),
    ],
)
def test_given_spectra_must_reach_the_modes(paper, frequency, acceleration, words):
    damping = 0.5 if frequency is None else device_modes(device_of(pipe())).damping[0]
    spectra = [
        GivenSpectrum(
            support=support,
            direction="y",
            damping=damping,
            frequency=frequency or (1.0, 50.0),
            acceleration=acceleration,
        )
        for support in (1, 2)
    ]
    building = with_devices(paper, pipe(spectra=tuple(spectra)))
    if words is None:
        assert len(checked_devices(building)) == 1
    else:
        assert words in faults_of(building)["devices[0].spectra"]
