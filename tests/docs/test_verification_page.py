import csv
import json
import re
import sys

import pytest

from docs._ext import verification as module
from docs._ext.verification import description, main, page, read_entries, section, table
from impactfem.system.errors import ImpactfemError, InputError
from impactfem.verify.manual import BENCHMARKS, FULL, verify
from impactfem.verify.row import Row
from impactfem.verify.validation import cases

from .pages import ROOT

REMAKE = "run: impactfem verify --json FILE; python docs/_ext/verification.py FILE"
QUICK = ("decree_ordinates", "cqc_coefficient", "mode_combinations", "rg_1_122", "two_supports")


@pytest.fixture(scope="module")
def committed():
    return module.PAGE.read_text(encoding="utf-8")


def entry(name, quantity="force", **values):
    row = Row(name, quantity, **{"reference": 2.0, "computed": 2.002, "unit": "N"} | values)
    return {"benchmark": name, **row.as_dict()}


@pytest.fixture
def few(monkeypatch):
    """Two benchmarks and a heavy one in place of all."""

    def one():
        """About one: |a| < b_c.

            F = K p * v

        That is all.
        """

    def two():
        """About two, see `one`."""

    one.__module__ = "impactfem.verify.shells.beams"
    two.__module__ = "impactfem.verify.motion"
    monkeypatch.setattr(module, "BENCHMARKS", {"one": one, "two": two})
    monkeypatch.setattr(module, "FULL", {"heavy": two})


def test_the_page_has_the_benchmarks_of_the_program(committed):
    names = re.findall(r"(?m)^### `(\w+)`$", committed)
    assert sorted(names) == sorted({**BENCHMARKS, **FULL}), REMAKE
    for name in names:
        assert description(name).strip() in committed, REMAKE


@pytest.fixture(scope="module")
def rows():
    with module.PAGE.with_suffix(".csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", QUICK)
def test_the_table_has_the_rows_of_the_program(rows, name):
    entries = [{"benchmark": name, **row.as_dict()} for row in BENCHMARKS[name]()]
    made = list(csv.DictReader(table(entries).splitlines()))
    listed = [row for row in rows if row["benchmark"] == name]
    # Errors of rounding differ from machine to machine.
    for row in (*made, *listed):
        row["deviation"] = re.sub(r"\d\.\de-1[0-9]", "tiny", row["deviation"])
    assert listed == made, REMAKE


def test_the_page_counts_the_rows_of_the_table(rows, committed):
    counts = dict(re.findall(r"(?m)^\| \[(\w+)\]\(#\1\) \| (\d+) \|", committed))
    listed = [row["benchmark"] for row in rows]
    assert counts == {name: str(listed.count(name)) for name in dict.fromkeys(listed)}
    assert f"\n{len(rows)} rows of {len(counts)} benchmarks, {len(rows)} within" in committed
    assert {row["passed"] for row in rows} == {"yes"}


def test_pages_of_benchmarks_show_rows_of_the_table(rows):
    for path in (ROOT / "docs" / "benchmarks").glob("*.csv"):
        assert f":file: {path.name}\n" in path.with_suffix(".md").read_text(encoding="utf-8")
        with path.open(encoding="utf-8") as file:
            shown = list(csv.DictReader(file))
        listed = [row for row in rows if row["benchmark"] == path.stem]
        assert [row | short for row, short in zip(listed, shown, strict=True)] == listed


def test_the_page_of_cases_beside_other_programs():
    text = module.VALIDATION.read_text(encoding="utf-8")
    names = re.findall(r"(?m)^### `(\w+)`$", text)
    assert names == list(cases()), REMAKE.replace("verify", "verify --validation", 1)
    assert f"of {len(names)} cases" in text and "fails**" not in text
    name = "sdnl104"
    made = section(name, [{"benchmark": name, **row.as_dict()} for row in cases()[name]()])
    assert made.strip() in text, REMAKE.replace("verify", "verify --validation", 1)
    template = (ROOT / "docs" / "_ext" / "validation.md.in").read_text(encoding="utf-8")
    for part in re.split(r"\{\{ \w+ \}\}", template):
        assert part.strip() in text, REMAKE.replace("verify", "verify --validation", 1)


def test_a_long_case_shows_its_largest_errors():
    computed = {f"q{k}": 2.0 + 1e-4 * k for k in range(12)}
    values = {"tolerance": 0.01, "source": "s"}
    rows = [entry("sdnl104", q, computed=c, **values) for q, c in computed.items()]
    text = module.shortened("sdnl104", rows, rows=3)
    assert [q for q in computed if f"| {q} |" in text] == ["q9", "q10", "q11"]
    assert "9 further rows" in text
    # A failed row is shown, however many others there are; a short case is whole.
    failed = [entry("sdnl104", f"f{k}", computed=3.0, **values) for k in range(5)]
    text = module.shortened("sdnl104", rows + failed, rows=3)
    assert all(f"| f{k} |" in text for k in range(5)) and "| q11 |" not in text
    assert module.shortened("sdnl104", rows) != module.shortened("sdnl104", rows, rows=12)
    assert "further" not in module.shortened("sdnl104", rows, rows=12)


def test_the_page_says_that_all_is_well(committed):
    rows, count, passed = re.search(
        r"(\d+) rows of (\d+) benchmarks, (\d+) within tolerance", committed
    ).groups()
    assert rows == passed and int(count) >= len(BENCHMARKS)
    assert "fail**" not in committed


def test_groups(few):
    entries = [
        entry("one", tolerance=0.01, source="a|b"),
        entry("two", "x", tolerance=1e-6, source="s", absolute=True),
        entry("two", "y", tolerance=0.01, source="t", computed=float("nan")),
    ]
    text = page(entries)
    assert text.index("## Ground") < text.index("### `two`") < text.index("## Beams")
    assert text.index("## Beams") < text.index("### `one`") and "## Shells" not in text
    assert "3 rows of 2 benchmarks, 1" in text
    assert "1 | 1 | 1" in text
    assert "About one: \\|a\\| \\< b\\_c.\n" in text and "That is all." not in text
    assert "| [one](#one) | 1 | 0.1 | a\\|b |\n" in text
    assert "two, see `one`." in text
    assert "[two](#two) | 2 | **2 rows" in text
    assert "[heavy](#heavy) | - | runs" in text
    assert "### `heavy`" in text
    lines = table(entries).splitlines()
    assert lines[1:] == [
        "one,,force,N,2,2.002,1.0e-03,0.01,yes,a|b",
        "two,,x,N,2,2.002,2.0e-03 abs,1e-06 abs,no,s",
        "two,,y,N,2,no number,no number,0.01,no,t",
    ]


def test_a_lower_bound():
    values = {"tolerance": 0.1, "source": "s", "at_least": True, "unit": "-"}
    enough, short = (
        table([entry("cqc_coefficient", "order", computed=c, **values)]) for c in (3.0, 1.8)
    )
    assert "order,-,2,3,0.0e+00 short,0.1 short,yes,s\n" in enough
    assert "order,-,2,1.8,2.0e-01 short,0.1 short,no,s\n" in short


def test_rows_of_other_benchmarks(few):
    one, two = (entry(n, tolerance=0.01, source="s") for n in ("one", "two"))
    with pytest.raises(ImpactfemError, match="benchmarks two: run"):
        page([one])
    with pytest.raises(ImpactfemError, match="benchmarks that do"):
        page([one, two, {**two, "benchmark": "three"}])


@pytest.mark.parametrize("text", ["", "{}", '[{"name": "a"}]', "[1]"])
def test_a_file_of_something_else(tmp_path, text):
    path = tmp_path / "rows.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"rows\.json.*impactfem verify --json"):
        read_entries(path)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        read_entries(tmp_path / "none.json")


def test_written_by_the_command(few, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(module, "PAGE", tmp_path / "verification.md")
    rows, heavy = tmp_path / "rows.json", tmp_path / "heavy.json"
    one, two, long = (entry(n, tolerance=0.01, source="s") for n in ("one", "two", "heavy"))
    rows.write_text(json.dumps([one, two]), encoding="utf-8")
    assert main([str(rows)]) == 0
    assert module.PAGE.read_text(encoding="utf-8") == page([one, two])
    csv_file = module.PAGE.with_suffix(".csv")
    assert csv_file.read_text(encoding="utf-8") == table([one, two])
    assert capsys.readouterr().out == f"{module.PAGE}\n{csv_file}\n"
    rows.write_text(json.dumps([one]), encoding="utf-8")
    assert main([str(rows)]) == 1
    heavy.write_text(json.dumps([two, long]), encoding="utf-8")
    assert main([str(rows), str(heavy)]) == 0
    assert "runs with `--full` only" not in module.PAGE.read_text(encoding="utf-8")
    assert main([str(tmp_path)]) == main([]) == 2
    assert "usage" in capsys.readouterr().err


def test_it_reads_what_verify_writes(tmp_path):
    path = tmp_path / "rows.json"
    rows = verify("cqc", path)
    assert [e["quantity"] for e in read_entries(path)] == [row.quantity for row in rows]


def test_written_by_the_command_benchmark_figures(monkeypatch, tmp_path, capsys):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import benchmark_figures as figures

    monkeypatch.setattr(figures, "FOLDER", tmp_path)
    rows = tmp_path / "rows.json"
    name = "newmark_order"
    entries = [{"benchmark": name, **row.as_dict()} for row in BENCHMARKS[name]()]
    rows.write_text(json.dumps(entries), encoding="utf-8")
    assert figures.main([str(rows)]) == 0
    made = {path.stem: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.svg")}
    assert set(made) == {*figures.DRAWINGS, "newmark_order_convergence"}
    committed = ROOT / "docs" / "benchmarks"
    assert {path.name for path in committed.glob("*.svg")} >= {f"{stem}.svg" for stem in made}
    convergence = made["newmark_order_convergence"]
    assert "order 2.00" in convergence and "time step [s]" in convergence
    assert "diaphragm" in made["scordelis_lo"]
    assert figures.main([]) == figures.main([str(tmp_path)]) == 2
    assert "usage" in capsys.readouterr().err
    del sys.modules["benchmark_figures"]
