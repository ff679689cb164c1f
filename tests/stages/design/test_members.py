"""All members: kept one by one, gone on with, those that fail named."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from impactfem.spectra.statistics import STATISTICS, over_members
from impactfem.stages.design import members
from impactfem.stages.design.members import carry_members, stacked, stored_members
from impactfem.system.errors import SolutionError


@pytest.fixture
def carried(carrier, tmp_path):
    """Carry members; gives results, failures, files and keys."""

    def run(loads, key="key"):
        files = {name: tmp_path / f"{name}.npz" for name in loads}
        keys = {name: f"{key} {name}" for name in loads}
        done = []
        with ThreadPoolExecutor(2) as pool:
            found, failed = carry_members(carrier, loads, files, keys, pool, done.append)
        assert done == list(range(1, len(loads) + 1))
        return found, failed, files, keys

    return run


def test_kept_and_gone_on_with(carried, member):
    found, failed, files, keys = carried({"a": member(), "b": member(scale=0.5)})
    assert not failed
    again = stored_members(files, keys)
    assert sorted(again) == ["a", "b"]
    np.testing.assert_array_equal(again["b"]["psa"], found["b"]["psa"])
    # Of other inputs, cut short, or not there: computed again.
    assert stored_members(files, {**keys, "b": "another"}).keys() == {"a"}
    files["a"].write_bytes(files["a"].read_bytes()[:100])
    files["b"].unlink()
    assert stored_members(files, keys) == {}


def test_one_that_fails_is_named(carried, member, monkeypatch):
    def fails(carrier, one):
        if one.peak_force[0] == 0.0:
            raise SolutionError("the response is not finite")
        return carry(carrier, one)

    carry = members.carry
    monkeypatch.setattr(members, "carry", fails)
    bad = member()
    bad.peak_force[0] = 0.0
    found, failed, files, _ = carried({"good": member(), "bad": bad})
    assert list(found) == ["good"] and failed == {"bad": "the response is not finite"}
    assert files["good"].is_file() and not files["bad"].exists()
    with pytest.raises(SolutionError, match=r"fewer than two.*bad: the response is not finite"):
        stacked(["good"], found, failed)


def test_identical_members_have_no_spread(carried, member):
    found, *_ = carried({name: member() for name in "abc"})
    together = stacked(list("abc"), found, {})
    assert together["psa"].shape[0] == 3
    for name in STATISTICS:
        np.testing.assert_allclose(
            over_members(together["psa"], name), found["a"]["psa"], rtol=1e-12
        )
    other, *_ = carried({"d": member(scale=2.0)})
    spread = np.stack([*together["psa"], other["d"]["psa"]])
    assert np.all(over_members(spread, "mean") > 1.2 * found["a"]["psa"])
