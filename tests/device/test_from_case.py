"""Devices of a case file, and the rules of their analysis."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from impactfem.case import (
    BaseStiffness,
    Case,
    Cylinder,
    Damping,
    DeviceAnalysis,
    DeviceBeam,
    DeviceMode,
    DeviceSetup,
    load_case,
)
from impactfem.case.device_analysis import RigidPart
from impactfem.case.device_tables import DeviceMatrices, GivenSpectrum, NamedMatrix
from impactfem.case.devices import DeviceSupport
from impactfem.device.combination import Gupta, LindleyYow, Rules
from impactfem.device.from_case import checked_devices, device_of, rules_of
from impactfem.device.modes import device_modes
from impactfem.system.errors import ImpactfemError, InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"
RIGID = dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), "rigid")
LIGHT = Damping(ratio=0.02, frequencies=(30.0, 80.0))
PIPE = ("1.y", "tip", "2.y")


@pytest.fixture(scope="module")
def paper() -> Case:
    return load_case(GEOMETRY / "npp_pair.toml")


@pytest.fixture
def setup() -> Callable[..., DeviceSetup]:
    """A mass on one spring along y, 10 Hz; its keys can be altered."""

    def make(**keys: Any) -> DeviceSetup:
        given: dict[str, Any] = {
            "name": "mass",
            "point": (1.0, 2.0, 3.0),
            "radius": 0.5,
            "modes": None,
            "mass": 100.0,
            "mass_height": 0.0,
            "inertia": (1.0, 1.0, 1.0),
            "stiffness": BaseStiffness(**RIGID | {"y": 100.0 * (20.0 * math.pi) ** 2}),
            "damping": LIGHT,
        }
        return DeviceSetup(**given | keys)

    return make


def of_modes(*rows: DeviceMode, **keys: Any) -> dict[str, Any]:
    body = dict.fromkeys(("mass", "mass_height", "inertia", "stiffness"))
    return body | {"modes": rows} | keys


def test_paper_s_device_has_the_modes_of_table_6(paper: Case) -> None:
    (pump,) = checked_devices(paper)
    modes = device_modes(pump).below(paper.devices[0].maximum_frequency)
    published = {name: entry.value for name, entry in paper.published.items()}
    for i in range(4):
        frequency = published[f"device.frequency.{i + 1}"]
        assert modes.frequency[i] == pytest.approx(frequency, rel=2e-4)
        mass = published[f"device.effective_mass.{i + 1}"]
        assert modes.effective_mass[:2, i].sum() == pytest.approx(mass, rel=1e-4)
    # 2 % at 30 and 80 Hz, and so about that at 30.5 and 82.9 Hz.
    assert modes.damping == pytest.approx(4 * [0.02], rel=0.02)


def test_spring_of_each_direction(setup: Callable[..., DeviceSetup]) -> None:
    device = device_of(setup())
    assert device.motions == ("base y",)
    modes = device_modes(device)
    assert modes.frequency == pytest.approx([10.0], rel=1e-12)
    # ξ = (α/ω + β ω)/2 with α = 2 ξ ω₁ ω₂ / (ω₁ + ω₂), β = 2 ξ / (ω₁ + ω₂).
    assert modes.damping == pytest.approx([0.02 * (30.0 * 80.0 / 10.0 + 10.0) / 110.0], rel=1e-12)
    turning = setup(stiffness=BaseStiffness(**RIGID | {"rz": (6.0 * math.pi) ** 2}))
    assert device_modes(device_of(turning)).frequency == pytest.approx([3.0], rel=1e-12)


def test_shape_of_a_cylinder(setup: Callable[..., DeviceSetup]) -> None:
    shape = Cylinder(type="cylinder", radius=2.0, length=6.0)
    device = device_of(setup(inertia=None, shape=shape, mass_height=1.0))
    # Solid cylinder: m (3 R² + l²) / 12 across, m R² / 2 along; and m h² about the anchor.
    assert np.diag(device.J) == pytest.approx([100.0, 100.0, 100.0, 500.0, 500.0, 200.0])


def test_beam_bends_the_right_way(setup: Callable[..., DeviceSetup]) -> None:
    """A massless cantilever with a point mass: ω² = 1 / (m (l³ / 3 E I + l / G A_v))."""
    beam = DeviceBeam(length=2.0, bending=(3e6, 6e6), shear=("rigid", 4e5), mass=0.0, elements=3)
    point = setup(
        mass_height=2.0, inertia=(0.0, 0.0, 0.0), stiffness=BaseStiffness(**RIGID), beam=beam
    )
    modes = device_modes(device_of(point))
    flexibility_x = 8.0 / 3.0 / 6e6
    flexibility_y = 8.0 / 3.0 / 3e6 + 2.0 / 4e5
    expected = {0: 1.0 / flexibility_x, 1: 1.0 / flexibility_y}
    for axis, stiffness in expected.items():
        (mode,) = np.flatnonzero(modes.effective_mass[axis] > 1.0)
        assert modes.omega[mode] ** 2 == pytest.approx(stiffness / 100.0, rel=1e-9)
    # Both stretching and twisting are rigid unless given.
    assert not any(motion.endswith((" z", " rz")) for motion in device_of(point).motions)
    soft = beam.model_copy(update={"stretching": 1e5, "twisting": 1e5})
    motions = device_of(point.model_copy(update={"beam": soft})).motions
    assert {motion.rsplit(" ", 1)[1] for motion in motions} >= {"z", "rz"}


def test_table_of_modes(setup: Callable[..., DeviceSetup]) -> None:
    rows = (
        DeviceMode(frequency=8.0, direction="y", effective_mass=300.0, height=1.1),
        DeviceMode(frequency=12.0, direction="rx", effective_inertia=7.0, damping=0.05),
    )
    modes = device_modes(device_of(setup(**of_modes(*rows))))
    assert modes.frequency == pytest.approx([8.0, 12.0])
    assert modes.effective_mass[1] == pytest.approx([300.0, 0.0])
    assert modes.effective_mass[3] == pytest.approx([300.0 * 1.1**2, 7.0])
    assert modes.height[0] == pytest.approx(1.1)
    assert modes.damping == pytest.approx([float(LIGHT.rayleigh.ratio(8.0)), 0.05])
    whole = {"mass": 500.0, "mass_height": 1.0, "inertia": (200.0, 200.0, 1.0)}
    device = device_of(setup(**of_modes(*rows, **whole)))
    assert device.J[1, 1] == pytest.approx(500.0)
    every = tuple(row.model_copy(update={"damping": 0.03}) for row in rows)
    modes = device_modes(device_of(setup(**of_modes(*every, damping=None))))
    assert modes.damping == pytest.approx([0.03, 0.03])


def test_neither_body_nor_modes(setup: Callable[..., DeviceSetup]) -> None:
    bare = setup().model_copy(update={"stiffness": None})
    with pytest.raises(ValueError, match="device mass has no body, or no springs"):
        device_of(bare)


def test_rules() -> None:
    analysis = DeviceAnalysis(
        combination=("cqc", "dsc"),
        duration=4.0,
        rigid=RigidPart(method=("gupta",), f1=5.0, f2=30.0),
        missing_mass=False,
        directions="100-40-40",
        time_step=1e-4,
    )
    rules = rules_of(analysis, 200.0)
    assert list(rules) == [("cqc", "gupta"), ("dsc", "gupta")]
    assert rules["dsc", "gupta"] == Rules(
        modes="dsc",
        duration=4.0,
        rigid=Gupta(5.0, 30.0),
        missing_mass=False,
        maximum_frequency=200.0,
        directions="100-40-40",
        displacements="abs",
        whole="abs",
    )


@pytest.mark.parametrize(
    ("rigid", "expected"),
    [
        (None, None),
        (RigidPart(method=("none",)), None),
        (RigidPart(method=("gupta",)), Gupta()),
        (RigidPart(method=("lindley-yow",)), LindleyYow()),
    ],
)
def test_rigid_part(rigid: RigidPart | None, expected: object) -> None:
    rules = rules_of(DeviceAnalysis(rigid=rigid), 1e3)
    assert {one.rigid for one in rules.values()} == {expected}


def test_every_method_with_every_combination() -> None:
    """One run shows all: the combinations without and with each rigid part."""
    rigid = RigidPart(method=("none", "gupta", "lindley-yow"), f1=5.0)
    rules = rules_of(DeviceAnalysis(combination=("srss", "cqc"), rigid=rigid), 1e3)
    methods = {"none": None, "gupta": Gupta(5.0), "lindley-yow": LindleyYow()}
    assert {key: one.rigid for key, one in rules.items()} == {
        (combination, method): wanted
        for combination in ("srss", "cqc")
        for method, wanted in methods.items()
    }
    assert list(rules)[:2] == [("srss", "none"), ("srss", "gupta")]


def with_devices(paper: Case, *devices: DeviceSetup, **analysis: Any) -> Case:
    asked = DeviceAnalysis(**analysis)
    return paper.model_copy(update={"devices": devices, "device_analysis": asked})


def faults_of(case: Case) -> dict[str, str]:
    with pytest.raises(InputError) as caught:
        checked_devices(case)
    assert {fault.file for fault in caught.value.faults} == {case.path}
    return {fault.key: f"{fault.value} {fault.expected}" for fault in caught.value.faults}


def test_none(paper: Case) -> None:
    assert checked_devices(with_devices(paper)) == []


def test_every_fault_at_once(paper: Case, setup: Callable[..., DeviceSetup]) -> None:
    heavy = DeviceMode(frequency=8.0, direction="y", effective_mass=120.0)
    body = {"mass": 100.0, "mass_height": 0.0, "inertia": (1.0, 1.0, 1.0)}
    stiff = Damping(mass_coefficient=0.0, stiffness_coefficient=0.04)
    faults = faults_of(
        with_devices(
            paper,
            setup(name="too_much", **of_modes(heavy, **body)),
            setup(),
            setup(name="overdamped", damping=stiff),
        )
    )
    assert set(faults) == {"devices[0]", "devices[2]"}
    assert (
        "too_much device too_much: its modes carry 120 kg along y, more than the 100 kg"
        in (faults["devices[0]"])
    )
    # β ω / 2 = 0.04 s · 20 π / s / 2
    assert "its mode at 10 Hz is damped by 126%; expected less than 100 %" in faults["devices[2]"]


def test_mechanism(paper: Case, setup: Callable[..., DeviceSetup]) -> None:
    springs = BaseStiffness(**RIGID | {"rx": 1.0}).model_copy(update={"rx": 0.0})
    faults = faults_of(with_devices(paper, setup(stiffness=springs)))
    assert "a mechanism, no stiffness holds the motion base rx" in faults["devices[0]"]


def test_overdamped_above_the_maximum_frequency(
    paper: Case, setup: Callable[..., DeviceSetup], caplog: pytest.LogCaptureFixture
) -> None:
    stiff = Damping(mass_coefficient=0.0, stiffness_coefficient=0.04)
    rigid = setup(damping=stiff, maximum_frequency=9.0)
    assert len(checked_devices(with_devices(paper, rigid))) == 1
    assert not caplog.records
    # Without the missing mass these modes are in no response: said, not refused.
    assert len(checked_devices(with_devices(paper, rigid, missing_mass=False))) == 1
    assert "1 of its modes are above maximum_frequency, 9 Hz" in caplog.text


def test_undamped(paper: Case, setup: Callable[..., DeviceSetup]) -> None:
    free = setup(damping=Damping(mass_coefficient=0.0, stiffness_coefficient=0.0))
    faults = faults_of(with_devices(paper, free))
    assert "a mode without damping; expected another combination" in faults["devices[0]"]
    assert len(checked_devices(with_devices(paper, free, combination=("srss",)))) == 1


def test_indefinite_mass(setup: Callable[..., DeviceSetup]) -> None:
    row = DeviceMode(frequency=8.0, direction="y", effective_mass=90.0, height=3.0)
    body = {"mass": 100.0, "mass_height": 0.0, "inertia": (1.0, 1.0, 1.0)}
    with pytest.raises(ImpactfemError, match="its mass is indefinite"):
        device_of(setup(**of_modes(row, **body)))


def pipe(**keys: Any) -> DeviceSetup:
    """500 kg between two anchors, 14.2 Hz."""
    k = ((3e6, -3e6, 0.0), (-3e6, 4e6, -1e6), (0.0, -1e6, 1e6))
    given: dict[str, Any] = {
        "name": "pipe",
        "supports": (
            DeviceSupport(point=(1.0, 2.0, 3.0), radius=0.5),
            DeviceSupport(point=(1.0, 2.0, 6.0), radius=0.5),
        ),
        "modes": None,
        "matrices": DeviceMatrices(
            mass=NamedMatrix(PIPE, ((0.0,) * 3, (0.0, 500.0, 0.0), (0.0,) * 3)),
            stiffness=NamedMatrix(PIPE, k),
        ),
        "damping": LIGHT,
    }
    return DeviceSetup(**given | keys)


def test_matrices_on_two_supports() -> None:
    device = device_of(pipe())
    assert device.anchors == 2 and device.motions == ("tip",)
    assert device.r[0, [1, 7]] == pytest.approx([0.75, 0.25])
    assert device_modes(device).frequency[0] == pytest.approx(
        math.sqrt(4e6 / 500.0) / (2 * math.pi)
    )


def test_matrices_that_hold_the_ground_are_refused(paper: Case) -> None:
    k = ((3e6, -3e6, 0.0), (-3e6, 4e6, -1e6), (0.0, -1e6, 2e6))
    stiffness = NamedMatrix(PIPE, k)
    held = DeviceMatrices(mass=NamedMatrix(PIPE, ((1.0,) * 3,) * 3), stiffness=stiffness)
    mass = NamedMatrix(PIPE, ((0.0,) * 3, (0.0, 500.0, 0.0), (0.0,) * 3))
    wrong = paper.model_copy(
        update={"devices": (pipe(matrices=held.model_copy(update={"mass": mass})),)}
    )
    with pytest.raises(InputError, match="resists a translation of all of them along y"):
        checked_devices(wrong)
    assert len(checked_devices(paper.model_copy(update={"devices": (pipe(),)}))) == 1


def given(support: int, *frequency: float) -> GivenSpectrum:
    return GivenSpectrum(
        support=support,
        direction="y",
        damping=0.0223,
        frequency=frequency,
        acceleration=(5.0,) * len(frequency),
    )


def test_given_spectra_must_reach_the_modes(paper: Case) -> None:
    def with_spectra(*spectra: GivenSpectrum) -> Case:
        return paper.model_copy(update={"devices": (pipe(spectra=spectra),)})

    damping = device_modes(device_of(pipe())).damping[0]
    reaching = [given(k, 1.0, 50.0).model_copy(update={"damping": damping}) for k in (1, 2)]
    assert len(checked_devices(with_spectra(*reaching))) == 1
    far = [given(k, 20.0, 50.0).model_copy(update={"damping": damping}) for k in (1, 2)]
    with pytest.raises(InputError) as caught:
        checked_devices(with_spectra(*far))
    (fault,) = caught.value.faults
    assert fault.key == "devices[0].spectra"
    assert "begins at 20 Hz and does not reach the mode at 14.2" in fault.expected
    # Below the mode at 14.2 Hz: the end of one is flat, that of the other still rises.
    flat = [one.model_copy(update={"frequency": (1.0, 10.0)}) for one in reaching]
    assert len(checked_devices(with_spectra(*flat))) == 1
    steep = [one.model_copy(update={"acceleration": (2.0, 5.0)}) for one in flat]
    with pytest.raises(InputError, match=r"ends at 10 Hz, where it is not flat yet, and does not"):
        checked_devices(with_spectra(*steep))
    with pytest.raises(InputError, match="expected dampings on both sides of the modes'"):
        checked_devices(with_spectra(given(1, 1.0, 50.0).model_copy(update={"damping": 0.5})))
