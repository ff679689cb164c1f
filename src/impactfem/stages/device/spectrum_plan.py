"""The response spectrum analyses that are done of a device."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from impactfem.case.devices import ModeRule, RigidMethod, SupportRule
from impactfem.device.combination import Combination, Rules
from impactfem.device.device import Device
from impactfem.device.from_case import first_method
from impactfem.device.spectrum import LAST, NO_SHIFT, AnchorSpectrum, NotRigidError
from impactfem.device.spectrum_analysis import SpectrumResponse, spectrum_analysis
from impactfem.sticks.element import COMPONENTS
from impactfem.system.errors import ImpactfemError

Source = Literal["computed", "envelope", "envelope-dampings", "given"]
"""Spectra that are the input: of the anchor; their envelope with those of further points; the
envelope of either over all damping cases; or spectra of a file."""

PREFERRED: tuple[Combination, ...] = ("srss", "cqc")
"""Combinations of modes that stand for the response spectrum analysis, the first that is there."""


@dataclass(frozen=True)
class SpectrumChoice:
    """One way of doing a response spectrum analysis."""

    combination: Combination  #: of the modes
    rotations: bool = False  #: whether the spectra of the anchor's rotations are inputs, too
    broadened: bool = False  #: whether the peaks of the spectra are broadened
    source: Source = "computed"  #: where the spectra come from
    #: combination of several supports, where it is not the one requested first
    supports: SupportRule | None = None
    rigid: RigidMethod = "none"  #: Method of the rigid part of the modes

    @property
    def label(self) -> str:
        """Its name in results."""
        parts = [
            self.combination,
            self.rigid if self.rigid != "none" else "",
            self.source if self.source != "computed" else "",
            "rotations" * self.rotations,
            "broadened" * self.broadened,
            f"supports-{self.supports}" if self.supports else "",
        ]
        return ".".join(part for part in parts if part)


def headline_of(rules: Iterable[ModeRule]) -> SpectrumChoice:
    """The analysis that stands for all: translations, computed spectra, the first rigid method."""
    known = list(rules)
    combinations = [combination for combination, _ in known]
    best = next((one for one in PREFERRED if one in combinations), combinations[0])
    rigid = next(rigid for combination, rigid in known if combination == best)
    return SpectrumChoice(best, rigid=rigid)


NO_RIGID_PART = (
    "the rigid part by '{}' is left out where a spectrum ends before it comes down to its "
    "zero-period acceleration, or has its corners the other way round"
)
Analyses = dict[SpectrumChoice, SpectrumResponse]


@dataclass(frozen=True, eq=False)
class SpectrumPlan:
    """What is done with the spectra of a device's anchors."""

    device: Device
    rules: Mapping[ModeRule, Rules]  #: by combination of the modes and method of their rigid part
    rotations: bool  #: whether analyses with rotational spectra are done, too
    broadening: float  #: of the peaks of spectra for further analyses; none when 0
    #: Combinations of several supports, the first for all analyses
    supports: tuple[SupportRule, ...] = ("srss",)
    #: Spectra of a file for a further analysis; none when empty
    given: tuple[AnchorSpectrum, ...] = ()

    @property
    def maximum_frequency(self) -> float | None:
        """Modes above it count as missing mass [Hz]."""
        return next(iter(self.rules.values())).maximum_frequency

    def analyses(self, spectra: Sequence[AnchorSpectrum], source: Source) -> Analyses:
        """All analyses with the spectra of one source: of all components of all anchors that move.

        ImpactfemError where a spectrum does not reach a mode.
        """
        straight = [s for s in spectra if s.component in COMPONENTS[:3]]
        inputs = {False: straight, True: spectra} if self.rotations else {False: straight}
        found: Analyses = {}
        for turned, chosen in inputs.items():
            found |= self._combined(SpectrumChoice("srss", turned, False, source), chosen)
        if self.broadening > 0.0:
            for turned, chosen in inputs.items():
                broad = [s.broadened(self.broadening) for s in chosen]
                found |= self._combined(SpectrumChoice("srss", turned, True, source), broad)
        if self.device.anchors == 1:
            return found
        first, *further = self.supports
        note = f"several supports are combined by '{first}' where no other is named"
        found = {choice: _with_notes(one, note) for choice, one in found.items()}
        for rule in further if source == "computed" else ():
            for turned, chosen in inputs.items():
                choice = SpectrumChoice("srss", turned, False, source, rule)
                found |= self._combined(choice, chosen)
        return found

    def given_analyses(self) -> Analyses:
        """The analyses with the spectra of a file; none without one.

        ImpactfemError where a spectrum does not reach a mode.
        """
        if not self.given:
            return {}
        found = self._combined(SpectrumChoice("srss", source="given"), self.given)
        notes = (LAST, NO_SHIFT) if self.device.anchors > 1 else (LAST,)
        return {choice: _with_notes(one, *notes) for choice, one in found.items()}

    def _combined(self, choice: SpectrumChoice, spectra: Sequence[AnchorSpectrum]) -> Analyses:
        """The analyses of a choice with every combination of modes and every rigid part."""
        # A further rigid part than the first is left out where a spectrum says too little for it.
        rule = choice.supports or self.supports[0]
        if rule == "envelope":
            spectra, rule = _in_step(spectra, self.device.anchors), "algebraic"
        found: Analyses = {}
        missing: dict[str, None] = {}
        for (combination, rigid), rules in self.rules.items():
            try:
                answer = spectrum_analysis(self.device, spectra, replace(rules, supports=rule))
            except ImpactfemError as error:
                if isinstance(error, NotRigidError) and rigid != first_method(self.rules):
                    missing[NO_RIGID_PART.format(rigid)] = None
                    continue
                named = f"device {self.device.name}: "
                raise ImpactfemError(named + str(error).removeprefix(named)) from error
            found[replace(choice, combination=combination, rigid=rigid)] = answer
        return {one: _with_notes(answer, *missing) for one, answer in found.items()}


def _with_notes(response: SpectrumResponse, *notes: str) -> SpectrumResponse:
    return replace(response, notes=response.notes + notes)


def _in_step(spectra: Sequence[AnchorSpectrum], anchors: int) -> list[AnchorSpectrum]:
    """The same spectra at all anchors: for each component, the envelope over the anchors."""
    shift = {(s.component, s.anchor): s.displacement for s in spectra}
    return [
        replace(widest, anchor=k, displacement=shift.get((widest.component, k), 0.0))
        for widest in envelopes([[replace(s, anchor=1) for s in spectra]])
        for k in range(1, anchors + 1)
    ]


def envelopes(families: Sequence[Sequence[AnchorSpectrum]]) -> tuple[AnchorSpectrum, ...]:
    """The envelope of several spectra, component by component and anchor by anchor.

    A component may be missing in some of the families of spectra.
    """
    groups: dict[tuple[int, str], list[AnchorSpectrum]] = {}
    for one in (spectrum for family in families for spectrum in family):
        groups.setdefault((one.anchor, one.component), []).append(one)
    return tuple(AnchorSpectrum.envelope(group) for group in groups.values())
