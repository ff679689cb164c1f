"""The command line; no logic of its own."""

import sys
import traceback
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.console import Console
from rich.table import Table

from impactfem import __version__
from impactfem.case.template import parts_list
from impactfem.cli_help import (
    Commands,
    InvalidFileError,
    counted,
    ends_with,
    judged,
    verdict,
)
from impactfem.system import log
from impactfem.system.errors import ImpactfemError, InputError, file_errors, printable
from impactfem.system.packages import warn_of_foreign_packages
from impactfem.system.parallel import (
    OtherRankError,
    abort,
    all_stop,
    exit_code,
    rank,
    size,
    warn_of_separate_tasks,
)
from impactfem.system.stop import advised, signals_answered

RUN_CODES = "0 done, 1 a computation failed, 2 invalid input, 128 + n stopped by signal n."
app = typer.Typer(
    cls=Commands,
    help="Floor response spectra and anchor forces of equipment in buildings that pound in an "
    "earthquake.",
    epilog=ends_with(
        "impactfem new towers && impactfem check towers.toml && impactfem run towers.toml",
        "0 done, 1 a computation failed, 2 invalid input.",
    ),
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
BENCHMARKS = Path(__file__).parents[2] / "bench" / "suite.py"  # of the source tree alone
COMPARED = 20  # results of two runs on the screen
PIPE_WIDTH = 160  # columns of a table that no terminal limits
CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]
LastStage = Annotated[
    str | None,
    typer.Option(
        metavar="STAGE",
        help="Last stage, with the stages that it needs: building, reduce, calibrate, "
        "pounding, ensemble, transient, device, design, equipment, sensitivity or report. "
        "Default: all for which the case has input.",
    ),
]
NoFigures = Annotated[
    bool,
    typer.Option(
        "--no-figures",
        help="Write results only; the next run without this option adds tables, figures, report.",
    ),
]


def _say(text: str, nl: bool = True) -> None:
    """Print lines, in which control characters of names and of foreign texts are escaped."""
    typer.echo("\n".join(map(printable, text.split("\n"))), nl=nl)


def _show(table: Table) -> None:
    """Print a table: as wide as the terminal, or wide enough for all of it in a pipe."""
    table.box = box.SIMPLE
    console = Console(markup=False)
    (console if console.is_terminal else Console(width=PIPE_WIDTH, markup=False)).print(table)


def _version(wanted: bool) -> None:
    if wanted:
        _say(f"impactfem {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    context: typer.Context,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Show details.")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    del version
    context.obj = verbose
    log.set_up(verbose, rank())
    warn_of_foreign_packages()
    warn_of_separate_tasks()


@app.command(epilog=ends_with("impactfem run towers.toml --out runs/first", RUN_CODES))
def run(
    context: typer.Context,
    case: CaseFile,
    stage: LastStage = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Run folder. Default: runs/<case name>."),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Continue the run in DIR; an error if DIR holds no run, or a run of another case.",
        ),
    ] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Compute finished stages again.")] = False,
    no_figures: NoFigures = False,
) -> None:
    """Run a case: finished stages with the same inputs are reused."""
    from impactfem.run import loop

    draw = not no_figures
    result = loop.run(case, out=out, stage=stage, resume=resume, fresh=fresh, draw=draw)
    if rank() != 0:
        return
    heads = ("result", "value", "published", "unit", "kind")
    table = Table(*heads, title=printable(str(result.folder / "summary.json")))
    for scalar in result.scalars:
        if (theirs := result.published.get(scalar.name)) is not None:
            value = "-" if scalar.value is None else f"{scalar.value:.5g}"
            published = f"{theirs.relation.strip('=')}{theirs.value:.5g}"
            texts = scalar.name, value, published, scalar.unit, theirs.kind
            table.add_row(*map(printable, texts))
    if table.row_count and context.obj:
        _show(table)
    try:
        lines = result.console_lines()
    except ImpactfemError as error:  # a damaged file of an earlier run in the folder
        lines = [f"results: {result.folder}"]
        log.LOGGER.warning("warning: %s", error)
    for line in lines:
        _say(line)


@app.command(
    epilog=ends_with(
        "impactfem sweep towers.toml --set 'contacts[0].gap=1 cm,2 cm,4 cm' --set allow=gap "
        "--show 'pounding.peak_force.*'",
        RUN_CODES,
    )
)
def sweep(
    case: CaseFile,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="A key of the case and its values, separated by commas. Repeat for each key: all "
            "combinations are run.",
        ),
    ] = None,
    variants: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="A table (CSV) in place of --set: keys in the first line, a variant in each "
            "further line.",
        ),
    ] = None,
    stage: LastStage = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the sweep. Default: runs/<case name>_sweep."),
    ] = None,
    show: Annotated[
        str,
        typer.Option(
            metavar="NAMES", help="Results to show, separated by commas; * matches any text."
        ),
    ] = "",
    processes: Annotated[int, typer.Option(min=1, help="Number of variants at the same time.")] = 1,
    no_figures: NoFigures = False,
) -> None:
    """Run variants of a case into one table.

    Each variant has other values of some keys. Also runs under mpirun.
    """
    from impactfem import study

    with advised("run again to go on"):
        result = study.sweep(
            case,
            settings or (),
            variants=variants,
            stage=stage,
            out=out,
            show=[name.strip() for name in show.split(",") if name.strip()],
            draw=not no_figures,
            processes=processes,
        )
    if rank() == 0:
        for text in result.table.texts(result.shown, PIPE_WIDTH):
            _say(text)
        _say(f"results: {', '.join(map(str, result.files))}")
    if result.failed:
        raise typer.Exit(1)


@app.command(epilog=ends_with("impactfem fit updating.toml updating_fit.toml", RUN_CODES))
def fit(
    case: CaseFile,
    targets: Annotated[
        Path,
        typer.Argument(metavar="FIT.toml", help="The free keys of the case, and the targets."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the fit. Default: runs/<name of FIT>."),
    ] = None,
    processes: Annotated[int, typer.Option(min=1, help="Evaluations at the same time.")] = 1,
) -> None:
    """Fit keys of a case to measured data.

    Reports how well the data determine each key. Also runs under mpirun.
    """
    from impactfem import study

    with advised("run again to go on"):
        result = study.fit(case, targets, out=out, processes=processes)
    if result is not None:
        for table in result.tables:
            _say(table.as_text(PIPE_WIDTH))
        _say(f"results: {', '.join(map(str, result.files))}")


@app.command(epilog=ends_with("impactfem report runs/towers"))
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The run folder.")],
) -> None:
    """Make the report of a run again from the files of its folder."""
    from impactfem import study

    _say(f"report: {study.make_report(folder)}")


@app.command(epilog=ends_with("impactfem compare runs/fine runs/coarse --to 100"))
def compare(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The run folder.")],
    other: Annotated[Path, typer.Argument(metavar="OTHER", help="The run folder to compare with.")],
    highest: Annotated[
        float, typer.Option("--to", metavar="HZ", help="Highest frequency of the figure.")
    ] = 100.0,
) -> None:
    """Compare the results of two runs.

    The report of the first run gets a section with the table and the floor spectra of both.
    """
    from impactfem import study

    table, page = study.compare_runs(folder, other, highest)
    _say(replace(table, rows=table.rows[:COMPARED]).as_text(PIPE_WIDTH))
    _say(f"all {len(table.rows)} results: {folder / 'tables' / table.name}.csv")
    _say(f"report: {page}")


@app.command(
    epilog=ends_with(
        "impactfem check towers.toml",
        "0 valid, also with warnings; 2 invalid; 3 warnings with --strict.",
    )
)
def check(
    case: CaseFile,
    fit: Annotated[
        Path | None, typer.Option(metavar="FIT.toml", help="Check this fit of the case as well.")
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with code 3 on warnings.")] = False,
) -> None:
    """Validate a case and all its files; estimate the cost.

    The cost is time, memory and disk space of a run. The last line is the verdict.
    """
    from impactfem.case.motions import RestMotion
    from impactfem.run.check import checked

    verdicts, warned = list[str](), 0
    if fit is not None:  # first: its errors are those of both files
        from impactfem.fit.evaluate import evaluate
        from impactfem.fit.plausibility import warn_of_far_targets, warn_of_implausible
        from impactfem.fit.problem import read_problem

        with judged(fit) as warnings:
            problem = read_problem(case, fit, mesh=True)[0]
            warn_of_implausible(problem)
            if problem.level == "sticks":  # algebra, milliseconds
                values = evaluate(problem, problem.start, Path()).values
                warn_of_far_targets(problem, values)
        keys, data = len(problem.keys), len(problem.data)
        _say(f"{counted(keys, 'parameter')}, {counted(data, 'observation')}")
        verdicts.append(verdict(fit, warnings))
        warned = len(warnings)
    with judged(case) as warnings:
        found, estimate = checked(case, mesh=True)
    counts = (
        (len(found.buildings), "building"),
        (len({contact.pair for contact in found.contacts}), "contact pair"),
        (sum(not isinstance(one, RestMotion) for one in found.motions), "ground motion"),
    )
    _say(", ".join(counted(n, name) for n, name in counts))
    _say(estimate.line)
    for line in (*verdicts, verdict(case, warnings)):
        _say(line)
    if strict and warned + len(warnings):
        raise typer.Exit(3)


@app.command(epilog=ends_with("impactfem contacts towers.toml", "0 done, 2 invalid."))
def contacts(case: CaseFile) -> None:
    """Print the pairs of a contact search as [[contacts]]."""
    from impactfem.case import load_case
    from impactfem.case.contact_toml import contacts_text

    with file_errors():
        _say(contacts_text(load_case(case)), nl=False)


@app.command(
    epilog=ends_with("impactfem new towers --with structure,devices", "0 done, 2 invalid.")
    + f"\n\n\b\nParts of --with, and the time of the case on two cores:\n{parts_list()}"
)
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new case.")],
    parts: Annotated[
        str,
        typer.Option(
            "--with",
            metavar="PARTS",
            help="Parts in use, separated by commas; the parts that they need are added.",
        ),
    ] = "",
    minimal: Annotated[
        bool, typer.Option("--minimal", help="Omit comments and optional keys.")
    ] = False,
    full: Annotated[bool, typer.Option("--full", help="Show all keys, as comments.")] = False,
) -> None:
    """Write a new case file with comments, and its tables."""
    from impactfem.case.template import write_new_case

    chosen = [part.strip() for part in parts.split(",") if part.strip()]
    files = write_new_case(name, chosen, minimal=minimal, short=not (full or minimal))
    for path in files:
        _say(f"wrote {path}")
    _say(f"next: impactfem check {files[0]}")


@app.command(epilog=ends_with("impactfem examples two_frames my_case", "0 done, 2 invalid."))
def examples(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="Case to copy. Default: list all.")
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Argument(metavar="FOLDER", help="Folder of the copy. Default: its name."),
    ] = None,
) -> None:
    """List the shipped cases, or copy one.

    The copy has all files of the case. Nothing is overwritten.
    """
    from impactfem import examples as shipped

    if name is None:
        cases = shipped.examples()
        widths = [max(len(getattr(one, of)) for one in cases) for of in ("name", "size")]
        for one in cases:
            _say(f"{one.name:<{widths[0]}}  {one.size:<{widths[1]}}  {one.title}")
        _say("copy one: impactfem examples NAME [FOLDER]; 'impactfem check' estimates its run time")
        return
    files = shipped.copy_example(name, folder)
    for path in files:
        _say(f"wrote {path}")
    _say(f"next: impactfem check {files[0]}")


@app.command(
    epilog=ends_with(
        "impactfem explain contacts.gap\n"
        "impactfem explain pounding.peak_force.floor_3 --run runs/towers\n"
        "impactfem explain transient.points_per_cycle",
        "0 found, 2 unknown name.",
    )
)
def explain(
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="Key of a case or fit file, result, or check."),
    ],
    folder: Annotated[
        Path | None,
        typer.Option("--run", metavar="DIR", help="Run folder: show the value of the result."),
    ] = None,
) -> None:
    """Print the reference entry of a key, a result or a check."""
    from impactfem.explain import explain

    _say("\n".join(explain(name, folder)))


@app.command(
    epilog=ends_with(
        "impactfem verify --only newmark", "0 all within tolerance, 1 some are not, 2 invalid."
    )
)
def verify(
    only: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Only benchmarks whose name contains NAME."),
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the rows to this file.")
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="Include slow benchmarks.")] = False,
    validation: Annotated[
        bool,
        typer.Option(
            "--validation",
            help="Only the comparisons with other programs and experiments (geometry/validation).",
        ),
    ] = False,
) -> None:
    """Repeat the verification benchmarks on this machine."""
    from impactfem.verify import manual

    rows = manual.verify(only, json_file, full, validation)
    _show(manual.as_table(rows, sources=validation))
    failed = [row for row in rows if not row.passed]
    _say(f"{len(rows) - len(failed)} of {len(rows)} within tolerance")
    if failed:
        raise typer.Exit(1)


@app.command(
    hidden=not BENCHMARKS.is_file(),
    epilog=ends_with("impactfem bench sticks spectra"),
)
def bench(
    groups: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="GROUP...",
            help="Groups: sticks, spectra; basis, wall, pounding, fit (default mesh); building, "
            "transient, dampings (paper-size mesh, some minutes each). Default: sticks, spectra.",
        ),
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the numbers to this file.")
    ] = None,
) -> None:
    """Measure speed on this machine; needs a clone of the source tree."""
    from impactfem.system.files import in_source_tree

    sys.path.insert(0, str(in_source_tree("bench/suite.py").parents[1]))
    from bench import suite

    _show(suite.as_table(suite.measure(groups or (), json_file)))


def main() -> None:
    """Entry point: errors become one clear message each and an exit code, never a traceback.

    Exit codes: 0 done, 1 a computation or check failed, 2 the input is invalid; 128 plus the
    number of the signal that stopped the program. Under `mpirun` a rank that fails alone stops
    the others.
    """
    with signals_answered():
        try:
            with file_errors():
                app()
        except OtherRankError as error:
            all_stop()
            raise SystemExit(error.exit_code) from None
        except ImpactfemError as error:
            together = all_stop()
            if rank() == 0 or not together:
                for line in error.faults if isinstance(error, InputError) else [error]:
                    print(f"error: {printable(str(line))}", file=sys.stderr)
                if isinstance(error, InvalidFileError):
                    print(printable(error.verdict), file=sys.stderr)
            if not together:
                abort(exit_code(error))
            raise SystemExit(exit_code(error)) from None
        except Exception:
            if size() == 1:
                raise
            traceback.print_exc()
            abort(1)


if __name__ == "__main__":
    main()
