"""The benchmarks of contact pairs see what is wrong."""

import numpy as np

from impactfem.sticks.stick import Stick
from impactfem.verify import contact


def test_a_storey_that_stays_straight_is_seen(monkeypatch, failed):
    """The floor's motion straight down to the base, in place of the column's bending and shear."""

    def straight(self, number, relative_height):
        return relative_height * np.eye(6, self.n)

    monkeypatch.setattr(Stick, "storey_motion", straight)
    assert failed(contact.missing_pair()) == {"smallest distance"}


def test_a_wrong_period_is_seen(wrong, failed):
    wrong(
        contact,
        "_on_column",
        lambda right: lambda building, time, a, Ω: right(building, time, a, 1.01 * Ω),
    )
    assert failed(contact.missing_pair()) >= {"smallest distance", "its time"}


def test_pairs_that_are_not_looked_for_are_seen(wrong, failed):
    """Contacts that the search does not know: all places are in no pair."""
    wrong(
        contact,
        "facing_floors",
        lambda right: lambda case: right(case.model_copy(update={"contacts": ()})),
    )
    places = {f"places in no pair, with the pair {word}" for word in ("listed", "missing")}
    assert places <= failed(contact.missing_pair())
