"""`impactfem verify` and `bench`."""

import json

import pytest

from bench import suite
from bench.suite import Figure
from impactfem.system import files
from impactfem.verify import manual
from impactfem.verify.row import Row

GOOD = Row("good", "a length", 1.0, 1.0, "m", 1e-3, "nowhere")
BAD = Row("bad", "a length", 1.0, 1.1, "m", 1e-3, "nowhere")
NAN = Row("nan", "a length", 1.0, float("nan"), "m", 1e-3, "nowhere")


class TestVerify:
    def test_rows_and_json(self, program, tmp_path):
        path = tmp_path / "rows é.json"
        ended = program("verify", "--only", "sdll06", "--json", path)
        count = len(json.loads(path.read_text(encoding="utf-8")))
        assert ended.code == 0 and count >= 5
        assert ended.out.endswith(f"\n{count} of {count} within tolerance\n")

    def test_words_are_whole_in_a_pipe(self, program):
        out = program("verify", "--only", "newmark").out
        assert "relative displacement after 3 s in 2400 steps" in out and "…" not in out

    @pytest.mark.parametrize("row", [GOOD, BAD, NAN], ids=["within", "beyond", "nan"])
    def test_a_row_that_fails(self, program, tmp_path, monkeypatch, row):
        monkeypatch.setattr(manual, "BENCHMARKS", {"one": lambda: [GOOD, row]})
        path, passed = tmp_path / "rows.json", row is GOOD
        for words in ((), ("--json", path)):
            ended = program("verify", *words)
            assert ended.code == (0 if passed else 1) and ("FAIL" in ended.out) != passed
            assert ended.out.endswith(f"{1 + passed} of 2 within tolerance\n")
        assert [entry["passed"] for entry in json.loads(path.read_text())] == [True, passed]

    def test_an_unknown_name(self, program):
        ended = program("verify", "--only", "roof")
        assert ended.code == 2 and "--only = 'roof'" in ended.err and "cantilever" in ended.err

    def test_a_file_that_cannot_be_written(self, program, tmp_path):
        ended = program("verify", "--only", "sdll06", "--json", tmp_path / "absent" / "a.json")
        assert ended.code == 1 and ended.err.startswith("error: cannot write")


def test_bench(program, tmp_path, monkeypatch):
    measured = [Figure("a kernel", 0.2, "s", 0.3)]
    monkeypatch.setitem(suite.GROUPS, "sticks", lambda: measured)
    monkeypatch.setitem(suite.GROUPS, "spectra", list)
    ended = program("bench", "--json", tmp_path / "bench.json")
    assert ended.code == 0 and "a kernel" in ended.out and "met" in ended.out
    assert json.loads((tmp_path / "bench.json").read_text())[0]["met"] is True


def test_bench_without_the_source_tree(program, tmp_path, monkeypatch):
    """As from a wheel."""
    monkeypatch.setattr(files, "_ROOT", tmp_path)
    ended = program("bench")
    assert ended.code == 1 and ended.err.startswith("error: ")
    assert "bench/suite.py is not there: this needs a clone of the source tree" in ended.err
