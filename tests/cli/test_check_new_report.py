"""`impactfem check`, `new`, `report` and `compare`."""

import re
import shutil
from pathlib import Path

from impactfem.case.template import PARTS


class TestCheckAndNew:
    def test_a_new_case_is_good(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        ended = program("new", "mine")
        assert ended.code == 0
        assert ended.out == "wrote mine.toml\nwrote mine_floors.csv\n"
        ended = program("check", "mine.toml")
        assert ended.code == 0
        assert ended.out.startswith(
            "mine.toml: good. 2 buildings, 3 contact pairs, 1 ground motion\n"
        )
        assert names(tmp_path) == ["mine.toml", "mine_floors.csv"]

    def test_with_parts(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        assert program("new", "mine", "--minimal", "--with", "devices, ensemble").code == 0
        text = Path("mine.toml").read_text(encoding="utf-8")
        assert "[[devices]]" in text and "[ensemble]" in text and "#" not in text
        assert "mine_walls.csv" in names(tmp_path)
        assert program("check", "mine.toml").code == 0
        words = re.findall(r"\w+", program("new", "--help").out)
        assert set(PARTS) <= set(words)
        ended = program("new", "other", "--with", "roof,")
        assert ended.code == 2 and "--with = 'roof': known: structure" in ended.err

    def test_no_name(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        ended = program("new", "")
        assert ended.code == 2 and "NAME = '': expected the name of a case" in ended.err
        assert names(tmp_path) == []
        assert program("new", ".").code == 0 and "case.toml" in names(tmp_path)

    def test_a_report_of_no_run(self, program, tmp_path, names):
        for folder in (tmp_path, tmp_path / "nowhere"):
            ended = program("report", folder)
            assert ended.code == 2 and ended.err.count("\n") == 1
            assert "the folder holds no run to report on: case.json, " in ended.err
        assert names(tmp_path) == []

    def test_runs_that_cannot_be_compared(self, program, finished, tmp_path):
        """Each fault has a line: no 3D stage, in one folder and the other."""
        shutil.copytree(finished.folder, tmp_path / "other")
        ended = program("compare", finished.folder, tmp_path / "other")
        lines = ended.err.splitlines()
        assert ended.code == 2 and ended.out == "" and len(lines) == 2
        assert all(re.match("error: .*expected a run with the stage transient", x) for x in lines)
        for highest in ("-1.0", "0.0", "nan", "inf"):
            ended = program("compare", finished.folder, tmp_path / "other", "--to", highest)
            assert ended.code == 2
            assert ended.err.startswith(f"error: command line: --to = {highest}: expected a posit")
        for one, other, words in (
            (tmp_path / "other", tmp_path / "." / "other", "expected the folder of another run"),
            (tmp_path, finished.folder, "the folder holds no run"),
        ):
            ended = program("compare", one, other)
            assert ended.code == 2 and words in ended.err
        assert [path.name for path in tmp_path.iterdir()] == ["other"]

    def test_nothing_is_overwritten(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        Path("mine.toml").write_text("precious")
        ended = program("new", "mine")
        assert ended.code == 2 and "exists already" in ended.err
        assert names(tmp_path) == ["mine.toml"] and Path("mine.toml").read_text() == "precious"
