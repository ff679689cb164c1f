"""Records at vertices of floors, and envelopes over them."""

import numpy as np

from impactfem.stages.design.records import Records

SOME = Records(np.array([0, 1, 1]), np.array([2, 0, 0]), np.array([7, 4, 9]))


def test_envelope_is_raised_where_the_records_are():
    envelope = np.full((2, 2, 3, 5), 0.5)
    values = np.random.default_rng(0).random((2, 3, 5))
    found = SOME.raised(envelope, values, axis=1)
    np.testing.assert_array_equal(found[:, 0, 2], np.maximum(0.5, values[:, 0]))
    np.testing.assert_array_equal(found[:, 1, 0], np.maximum(0.5, values[:, 1:].max(axis=1)))
    others = np.ones((2, 3), dtype=bool)
    others[[0, 1], [2, 0]] = False
    assert np.all(found[:, others] == 0.5) and np.all(envelope == 0.5)


def test_without_records_nothing_is_raised():
    envelope = np.random.default_rng(0).random((2, 3))
    found = Records.none().raised(envelope, np.zeros(0), axis=0)
    np.testing.assert_array_equal(found, envelope)


def test_joined_and_taken():
    again = Records.joined([SOME.taken(np.array([0])), SOME.taken(np.array([1, 2]))])
    assert again.key == SOME.key and len(again) == 3 and len(Records.joined([])) == 0
    assert again.at(1, 0).tolist() == [1, 2]
    assert again.counts(2).tolist() == [[0, 0, 1], [2, 0, 0]]


def test_the_key_tells_another_choice():
    keys = {SOME.key, SOME.taken(np.array([0, 1])).key, SOME.taken(np.array([0, 2, 1])).key}
    assert len(keys) == 3
