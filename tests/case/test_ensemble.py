"""The section [ensemble] of a case file."""

import shutil
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.system.errors import InputError

DATA = Path(__file__).parent / "data"


@pytest.fixture
def written(tmp_path):
    for file in DATA.iterdir():
        shutil.copy(file, tmp_path)
    case = next(tmp_path.glob("*.toml"))

    def write(section):
        path = tmp_path / "with_ensemble.toml"
        path.write_text(case.read_text(encoding="utf-8") + "\n[ensemble]\n" + section)
        return path

    return write


def test_synthetic(written):
    ensemble = load_case(written("motions = 5\nfirst_seed = 3\n")).ensemble
    assert (ensemble.motions, ensemble.first_seed, ensemble.files()) == (5, 3, ())
    assert ensemble.structure_motions == 0


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("motions = 1\n", "ensemble.motions = 1"),
        ("motions = 5\nfirst_seed = -1\n", "ensemble.first_seed = -1"),
        ("first_seed = 1\n", "expected either motions or records"),
        ('motions = 5\nrecords = "here"\n', "expected either motions or records"),
        ('records = "nowhere"\n', "a folder of records; there is none"),
        ('records = "."\n', "a case with one motion of type 'record'"),
        ("motion = 5\n", "motions"),
        (
            "motions = 5\nstructure_motions = 1\n",
            "structure_motions = 1: expected 0, or at least 2",
        ),
        ("motions = 5\nstructure_motions = 6\n", "expected at most all members, 5"),
        ("motions = 5\nstructure_motions = 3\n", "expected 0, or a section [transient]"),
    ],
)
def test_refused(written, section, words):
    with pytest.raises(InputError) as error:
        load_case(written(section))
    assert words in str(error.value)
