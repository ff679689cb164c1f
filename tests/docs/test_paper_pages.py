"""README and the pages of the paper's case and of speed have the numbers of a run."""

import json

import pytest

from docs._ext import paper_pages as module
from impactfem.run import loop

from .pages import ROOT

STICKS = ("sticks.", "pounding.", "frs.", "motion.")


@pytest.fixture(scope="module")
def content():
    return json.loads(module.NUMBERS.read_text("utf-8"))


def test_pages_are_made_from_the_numbers(content):
    for page, text in module.pages(content).items():
        remake = f"{page.name}: run python docs/_ext/paper_pages.py"
        assert page.read_text("utf-8") == text, remake


def test_a_result_that_is_not_there_is_an_error(content):
    with pytest.raises(KeyError, match="pounding"):
        module.pages(content | {"results": {}})


def test_numbers_of_the_sticks_are_those_of_a_run(content, tmp_path):
    """The 3D building takes minutes; the sticks of the paper's case take ten seconds."""
    case = ROOT / "geometry" / "npp_pair.toml"
    run = loop.run(case, out=tmp_path, stage="pounding", draw=False, bar=False)
    found = {scalar.name: scalar.value for scalar in run.scalars}
    shown = content["results"] | {
        one["name"]: one["ours"] for item in content["items"] for one in item["values"]
    }
    names = [name for name in shown if name.startswith(STICKS)]
    assert len(names) > 20
    # Contact amplifies rounding, which is that of the machine's linear algebra: 2e-4 were seen.
    for name in names:
        assert found[name] == pytest.approx(shown[name], rel=1e-3), name
