"""The benchmarks of contact pairs see what is wrong."""

import numpy as np

from impactfem.sticks.stick import Stick
from impactfem.verify.contact import pairs


def test_a_storey_that_stays_straight_is_seen(monkeypatch, failed):
    """The floor's motion straight down to the base, in place of the column's bending and shear."""

    def straight(self, number, relative_height):
        return relative_height * np.eye(6, self.n)

    monkeypatch.setattr(Stick, "storey_motion", straight)
    assert failed(pairs.missing_pair()) == {"smallest distance"}


def test_a_wrong_period_is_seen(monkeypatch, failed):
    right = pairs._on_column
    monkeypatch.setattr(
        pairs, "_on_column", lambda building, time, a, Ω: right(building, time, a, 1.01 * Ω)
    )
    assert failed(pairs.missing_pair()) >= {"smallest distance", "its time"}


def test_pairs_that_are_not_looked_for_are_seen(monkeypatch, failed):
    """Contacts that the search does not know: all places are in no pair."""
    found = pairs.facing_floors

    def without_contacts(case):
        return found(case.model_copy(update={"contacts": ()}))

    monkeypatch.setattr(pairs, "facing_floors", without_contacts)
    names = failed(pairs.missing_pair())
    assert "places in no pair, with the pair listed" in names
    assert "places in no pair, with the pair missing" in names
