"""Names and patterns of probes that an envelope covers."""

import pytest

from impactfem.case import Probe
from impactfem.case.devices import chosen, unknown_patterns

PROBES = (
    Probe(name="corner", point=(0.0, 0.0, 3.0)),
    Probe.model_validate(
        {"name": "aisle", "from": (0.0, 1.0, 3.0), "to": (5.0, 1.0, 3.0), "count": 3}
    ),
    Probe(name="roof", group="edge_2"),
)


def test_chosen() -> None:
    names = ["corner", "aisle_1", "aisle_2", "centre_1"]
    assert chosen(names, ["aisle_*", "corner"]) == ["corner", "aisle_1", "aisle_2"]
    assert chosen(names, ["aisle_?"]) == ["aisle_1", "aisle_2"]
    assert chosen(names, ["Corner"]) == []


@pytest.mark.parametrize(
    "pattern",
    ["corner", "aisle_3", "aisle*", "roof_17", "roof_*", "centre_2", "edge_*", "line_9", "*"],
)
def test_known(pattern: str) -> None:
    assert list(unknown_patterns([pattern], PROBES, [1, 2])) == []


@pytest.mark.parametrize("pattern", ["korner", "aisle", "aisle_4", "centre_3", "line_10", "roof"])
def test_unknown(pattern: str) -> None:
    assert list(unknown_patterns([pattern, "corner"], PROBES, [1, 2])) == [pattern]


def test_floors_that_are_not_known() -> None:
    assert list(unknown_patterns(["centre_9", "nothing"], PROBES, [])) == ["nothing"]
