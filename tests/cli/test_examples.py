"""`impactfem examples`: the shipped cases and their copies."""

import pytest

from impactfem.case.load import load_case
from impactfem.examples import copy_example, examples
from impactfem.fit.problem import read_problem
from impactfem.system import files
from impactfem.system.errors import InputError

NAMES = [one.name for one in examples()]


def test_the_list(program):
    ended = program("examples")
    assert ended.code == 0
    lines = ended.out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == NAMES
    assert {"two_frames", "updating", "validation/sdnd102"} <= set(NAMES)
    assert not [name for name in NAMES if name.endswith(("_fit", "_report"))]


@pytest.mark.parametrize("name", NAMES)
def test_a_copy_is_whole(tmp_path, name):
    """The case and its fits can be read in the folder alone."""
    case, *_ = copied = copy_example(name, tmp_path / "copy")
    assert load_case(case).title
    for path in copied:
        assert (tmp_path / "copy") in path.parents
        if path.name.endswith("_fit.toml"):
            assert read_problem(case, path)[0].keys
        if path.suffix == ".toml":
            assert "#:schema" not in path.read_text(encoding="utf-8")


def test_a_copy_is_valid(program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ended = program("examples", "row_of_three")
    assert ended.code == 0 and ended.out.endswith(
        "next: impactfem check row_of_three/row_of_three.toml\n"
    )
    ended = program("check", "row_of_three/row_of_three.toml")
    assert ended.code == 0 and ended.out.splitlines()[-1] == "row_of_three/row_of_three.toml: valid"


def test_nothing_is_overwritten(program, tmp_path, names):
    (tmp_path / "row_of_three_b_floors.csv").write_text("mine")
    ended = program("examples", "row_of_three", tmp_path)
    assert ended.code == 2 and ended.err.count("error: ") == 1 and "not overwritten" in ended.err
    assert names(tmp_path) == ["row_of_three_b_floors.csv"]
    ended = program("examples", "row_of_three", tmp_path / "row_of_three_b_floors.csv")
    assert ended.code == 2 and "not a folder" in ended.err


def test_an_unknown_name(program, tmp_path, monkeypatch, names):
    monkeypatch.chdir(tmp_path)
    ended = program("examples", "two_frame")
    assert ended.code == 2 and "mean 'two_frames'?" in ended.err
    assert names(tmp_path) == []


def test_as_from_a_wheel(tmp_path, monkeypatch):
    """The cases are below share/impactfem of the environment."""
    root = files._ROOT
    monkeypatch.setattr(files, "_ROOT", tmp_path / "nowhere")
    monkeypatch.setattr(files, "_INSTALLED", root)
    assert copy_example("frame", tmp_path / "frame")[0].is_file()
    monkeypatch.setattr(files, "_INSTALLED", tmp_path)
    with pytest.raises(Exception, match="is not there"):
        copy_example("frame", tmp_path / "again")
    assert not (tmp_path / "again").exists()


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError):
        copy_example("frame", tmp_path / "file" / "inner")
