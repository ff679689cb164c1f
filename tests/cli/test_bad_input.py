"""Input that the program refuses: a line for each fault, an exit code, no traceback."""

import re
from pathlib import Path

import pytest


class TestBadInput:
    @pytest.mark.parametrize(
        ("file", "change", "expected"),
        [
            ("toml", ('gap = "2 cm"', 'gap = "2 kg"'), "gap = '2 kg'.*length"),
            ("toml", ('gap = "2 cm"\n', ""), r"contacts\[0\].gap.*missing"),
            ("toml", ('"small_floors.csv" ', '"absent.csv"  '), "absent.csv.*no such file"),
            ("toml", ("[damping]", "[damping"), "not valid TOML"),
            ("csv", ("3,192,", "3,-192,"), "line 9.*mass.*-192"),
            ("csv", (",3.5\n2,", ",3.5,9\n2,"), "line 7"),  # a column too many
        ],
    )
    def test_a_fault(
        self, program, new_case, edited, tmp_path, monkeypatch, file, change, expected, names
    ):
        monkeypatch.chdir(tmp_path)
        new_case(tmp_path)
        file = {"toml": "small.toml", "csv": "small_floors.csv"}[file]
        edited(tmp_path / file, change)
        before = names(tmp_path)
        for command in ("run", "check"):
            ended = program(command, "small.toml")
            assert ended.code == 2 and ended.out == ""
            *errors, last = ended.err.splitlines()
            if command == "check":
                count = f"{len(errors)} error{'s' if len(errors) > 1 else ''}"
                assert last == f"small.toml: invalid, {count}"
            lines = set(errors if command == "check" else [*errors, last])
            # The table is named twice, by two buildings: so is a table that is not there.
            assert len(lines) == (2 if "absent" in expected else 1)
            for line in lines:
                assert line.startswith(f"error: {file}: ") and re.search(expected, line)
            assert names(tmp_path) == before

    @pytest.mark.parametrize(
        ("content", "expected"),
        [
            (bytes(range(256)), "not a text file"),
            ("directory", "this is a directory"),
            ("device", "not an ordinary file"),
            (b"a = 1", "missing"),
        ],
        ids=["junk", "directory", "device", "another TOML"],
    )
    def test_a_case_file(self, program, tmp_path, monkeypatch, content, expected, names):
        monkeypatch.chdir(tmp_path)
        path = tmp_path / "a.toml"
        if isinstance(content, bytes):
            path.write_bytes(content)
        elif content == "directory":
            path.mkdir()
        elif content == "device":
            path = Path("/dev/null")
        before = names(tmp_path)
        ended = program("run", path)
        assert ended.code == 2 and expected in ended.err and ended.out == ""
        assert all(line.startswith("error: ") for line in ended.err.splitlines())
        assert names(tmp_path) == before

    def test_all_faults_at_once_as_a_process(self, new_case, edited, tmp_path, process, names):
        case = new_case(
            tmp_path,
            ('gap = "2 cm"', 'gap = "2 kg"'),
            ("restitution = 0.65", "restitution = 1.65"),
            ('[spectra]\ndamping = ["5 %"]', "[spectra]\ndampings = []"),
        )
        edited(tmp_path / "small_floors.csv", ("3,192,", "3,-192,"))
        before = names(tmp_path)
        ended = process("run", case.name, cwd=tmp_path)
        assert ended.code == 2 and ended.out == "" and "Traceback" not in ended.err
        for key in ("contacts[0].gap", "restitution", "spectra.dampings", "line 9"):
            assert len([line for line in ended.err.splitlines() if key in line]) == 1, key
        assert names(tmp_path) == before

    def test_options(self, program, finished, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for arguments, expected in (
            (
                ["--stage", "roof"],
                "--stage = 'roof': expected one of the stages building, reduce, calibrate, ",
            ),
            (["--stage", "sticks"], "expected one of the stages building, reduce"),
            (["--stage", "transiant"], "report; did you mean 'transient'?"),
            (
                ["--resume", "--out", "nowhere"],
                "command line: --resume = 'nowhere': expected a folder that holds a run",
            ),
            (["--resume", "--fresh"], "command line: --resume: expected without --fresh"),
            (["--out", finished.case], "small.toml' is a file, not a folder"),
        ):
            ended = program("run", finished.case, *arguments)
            assert ended.code == 2 and ended.out == "" and expected in ended.err
            assert ended.err.startswith("error: ") and ended.err.count("\n") == 1
        assert not list(tmp_path.iterdir())

    @pytest.mark.parametrize("command", ["run", "check", "new", "out"])
    def test_a_name_that_is_too_long(self, program, finished, tmp_path, command):
        path = tmp_path / ("x" * 300)
        arguments = ["run", finished.case, "--out"] if command == "out" else [command]
        ended = program(*arguments, path)
        assert ended.code == 2 and "name too long" in ended.err
