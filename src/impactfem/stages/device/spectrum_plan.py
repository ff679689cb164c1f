"""The response spectrum analyses that are done of a device."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from impactfem.case import DeviceAnalysis, DeviceSetup
from impactfem.case.device_analysis import ModeRule, SupportRule
from impactfem.device.combination import Rules
from impactfem.device.combination import SupportRule as SupportCombination
from impactfem.device.device import Device
from impactfem.device.from_case import first_method, rules_of
from impactfem.device.spectrum import LAST, NO_SHIFT, AnchorSpectrum, NotRigidError, given_spectra
from impactfem.device.spectrum_analysis import SpectrumResponse, spectrum_analysis
from impactfem.stages.device.spectrum_choice import Source, SpectrumChoice
from impactfem.sticks.element import COMPONENTS
from impactfem.system.errors import ImpactfemError

TRANSLATIONS = COMPONENTS[:3]
NO_RIGID_PART = (
    "the rigid part by '{}' is left out where a spectrum ends before it comes down to its "
    "zero-period acceleration, or has its corners the other way round"
)
Analyses = dict[SpectrumChoice, SpectrumResponse]


@dataclass(frozen=True, eq=False)
class SpectrumPlan:
    """What is done with the spectra of a device's anchors.

    Args:
        device: The device.
        rules: By combination of the modes and method of their rigid part.
        rotations: Whether analyses with rotational spectra are done, too.
        broadening: Of the peaks of spectra for further analyses; none when 0.
        supports: Combinations of several supports, the first for all analyses.
        given: Spectra of a file for a further analysis; none when empty.
    """

    device: Device
    rules: Mapping[ModeRule, Rules]
    rotations: bool
    broadening: float
    supports: tuple[SupportRule, ...] = ("srss",)
    given: tuple[AnchorSpectrum, ...] = ()

    @property
    def maximum_frequency(self) -> float | None:
        """Modes above it count as missing mass [Hz]."""
        return next(iter(self.rules.values())).maximum_frequency

    def analyses(self, spectra: Sequence[AnchorSpectrum], source: Source) -> Analyses:
        """All analyses with the spectra of one source.

        Args:
            spectra: Of the components of all anchors that move.
            source: Where they come from.

        Raises:
            ImpactfemError: A spectrum does not reach a mode.
        """
        straight = tuple(s for s in spectra if s.component in TRANSLATIONS)
        inputs = {False: straight, True: tuple(spectra)} if self.rotations else {False: straight}
        found: Analyses = {}
        for turned, chosen in inputs.items():
            found |= self._combined(SpectrumChoice("srss", turned, False, source), chosen)
        if self.broadening > 0.0:
            for turned, chosen in inputs.items():
                broad = tuple(s.broadened(self.broadening) for s in chosen)
                found |= self._combined(SpectrumChoice("srss", turned, True, source), broad)
        if self.device.anchors > 1:
            told = (
                f"several supports are combined by '{self.supports[0]}' where no other is named",
            )
            found = {choice: replace(one, notes=one.notes + told) for choice, one in found.items()}
        if self.device.anchors > 1 and source == "computed":
            for rule in self.supports[1:]:
                for turned, chosen in inputs.items():
                    choice = SpectrumChoice("srss", turned, False, source, rule)
                    found |= self._combined(choice, chosen)
        return found

    def given_analyses(self) -> Analyses:
        """The analyses with the spectra of a file; none without one.

        Raises:
            ImpactfemError: A spectrum does not reach a mode.
        """
        if not self.given:
            return {}
        found = self._combined(SpectrumChoice("srss", False, False, "given"), self.given)
        told = (LAST, NO_SHIFT) if self.device.anchors > 1 else (LAST,)
        return {choice: replace(one, notes=one.notes + told) for choice, one in found.items()}

    def _combined(self, choice: SpectrumChoice, spectra: Sequence[AnchorSpectrum]) -> Analyses:
        """The analyses of a choice with every combination of modes and every rigid part.

        A further rigid part than the first is left out where a spectrum says too little for it.
        """
        rule = choice.supports or self.supports[0]
        inputs = in_step(spectra, self.device.anchors) if rule == "envelope" else spectra
        together: SupportCombination = "algebraic" if rule == "envelope" else rule
        found: Analyses = {}
        missing: dict[str, None] = {}
        for (combination, rigid), rules in self.rules.items():
            whole = replace(rules, supports=together)
            try:
                answer = spectrum_analysis(self.device, inputs, whole)
            except NotRigidError as error:
                if rigid == first_method(self.rules):
                    raise self._named(error) from error
                missing[NO_RIGID_PART.format(rigid)] = None
            except ImpactfemError as error:
                raise self._named(error) from error
            else:
                found[replace(choice, combination=combination, rigid=rigid)] = answer
        return {
            one: replace(answer, notes=(*answer.notes, *missing)) for one, answer in found.items()
        }

    def _named(self, error: ImpactfemError) -> ImpactfemError:
        named = f"device {self.device.name}: "
        return ImpactfemError(named + str(error).removeprefix(named))


def plan_of(device: Device, setup: DeviceSetup, analysis: DeviceAnalysis) -> SpectrumPlan:
    """The analyses that a case asks for.

    Args:
        device: The device.
        setup: It in the case.
        analysis: The section of the case.

    Raises:
        ImpactfemError: Given spectra of several dampings share no frequencies.
    """
    return SpectrumPlan(
        device=device,
        rules=rules_of(analysis, setup.maximum_frequency),
        rotations=analysis.rotations,
        broadening=analysis.broadening,
        supports=analysis.supports,
        given=given_spectra(setup.spectra or ()),
    )


def in_step(spectra: Sequence[AnchorSpectrum], anchors: int) -> tuple[AnchorSpectrum, ...]:
    """The same spectra at all anchors: for each component, the envelope over the anchors.

    Args:
        spectra: Of the components of the anchors that move.
        anchors: Number of the anchors.
    """
    shift = {(s.component, s.anchor): s.displacement for s in spectra}
    found = []
    for component in dict.fromkeys(s.component for s in spectra):
        family = [replace(s, anchor=1) for s in spectra if s.component == component]
        widest = AnchorSpectrum.envelope(family)
        found += [
            replace(widest, anchor=k, displacement=shift.get((component, k), 0.0))
            for k in range(1, anchors + 1)
        ]
    return tuple(found)


def envelopes(families: Sequence[Sequence[AnchorSpectrum]]) -> tuple[AnchorSpectrum, ...]:
    """The envelope of several spectra, component by component and anchor by anchor.

    Args:
        families: Spectra of the components that move, of several points or dampings; a component
            may be missing in some of them.
    """
    return tuple(AnchorSpectrum.envelope(group) for group in _groups(families))


def _groups(families: Sequence[Sequence[AnchorSpectrum]]) -> Iterator[list[AnchorSpectrum]]:
    every = [one for family in families for one in family]
    for place in dict.fromkeys((one.anchor, one.component) for one in every):
        yield [one for one in every if (one.anchor, one.component) == place]
