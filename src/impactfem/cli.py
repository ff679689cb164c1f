"""The command line; no logic of its own."""

import sys
import traceback
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.console import Console
from rich.table import Table

from impactfem import __version__
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
from impactfem.system.stop import advise, signals_answered

app = typer.Typer(
    help="Earthquake pounding of adjacent buildings, and what it does to the equipment inside.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
PIPE_WIDTH = 160  # columns of a table that no terminal limits
CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]
LastStage = Annotated[
    str | None,
    typer.Option(
        metavar="STAGE",
        help="Run this stage and those that it needs: building, reduce, calibrate, "
        "pounding, ensemble, transient, device, design or report. All that the case has the input "
        "for when left out.",
    ),
]
NoFigures = Annotated[
    bool,
    typer.Option(
        "--no-figures",
        help="Write results alone; the next run without this option adds tables, figures, report.",
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


@app.command()
def run(
    context: typer.Context,
    case: CaseFile,
    stage: LastStage = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the run; runs/<case name> when left out."),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Go on with the run in DIR; refused where it holds none, or another case.",
        ),
    ] = False,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Compute finished stages again, too.")
    ] = False,
    no_figures: NoFigures = False,
) -> None:
    """Run a case: finished stages with the same inputs are reused."""
    from impactfem.run import loop

    draw = not no_figures
    result = loop.run(case, out=out, stage=stage, resume=resume, fresh=fresh, draw=draw)
    if rank() != 0:
        return
    heads = ("result", "value", "published", "unit", "ours is")
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
        results = result.key_results
    except ImpactfemError as error:  # a damaged file of an earlier run in the folder
        results = []
        log.LOGGER.warning("warning: %s", error)
    width = max((len(value) for value, _ in results), default=0)
    for value, text in results:
        _say(f"  {value:>{width}}  {text}")
    if table.row_count and not context.obj:
        _say(f"  {table.row_count} results have a published value: see -v, or the report")
    _say(f"results: {result.folder}")


@app.command()
def sweep(
    case: CaseFile,
    settings: Annotated[
        list[str],
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="A key of the case and its values, with commas between; start:stop:count is a "
            "range, start:stop:count:log one of equal ratios. Once for each key.",
        ),
    ],
    zipped: Annotated[
        bool, typer.Option("--zip", help="Keys run together, value by value.")
    ] = False,
    stage: LastStage = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder of the sweep; runs/<case name>_sweep when left out."
        ),
    ] = None,
    show: Annotated[
        str,
        typer.Option(
            metavar="NAMES", help="Results to show, with commas between; * for any letters."
        ),
    ] = "",
    processes: Annotated[int, typer.Option(min=1, help="Variants that run at a time.")] = 1,
    no_figures: NoFigures = False,
) -> None:
    """Run a case over values of one key or several, into one table; also over ranks."""
    from impactfem import study

    advise("run again to go on")
    result = study.sweep(
        case,
        settings,
        zipped=zipped,
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


@app.command()
def fit(
    case: CaseFile,
    targets: Annotated[
        Path,
        typer.Argument(metavar="FIT.toml", help="The free keys of the case, and the targets."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the fit; runs/<name of FIT> when left out."),
    ] = None,
    processes: Annotated[int, typer.Option(min=1, help="Evaluations at a time.")] = 1,
) -> None:
    """Fit keys of a case to data, and say how well these determine them; also over ranks."""
    from impactfem import study

    advise("run again to go on")
    result = study.fit(case, targets, out=out, processes=processes)
    if result is not None:
        for table in result.tables:
            _say(table.as_text(PIPE_WIDTH))
        _say(f"results: {', '.join(map(str, result.files))}")


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run.")],
) -> None:
    """Make the report of a run again, from the files of its folder."""
    from impactfem import study

    _say(f"report: {study.make_report(folder)}")


@app.command()
def compare(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run.")],
    other: Annotated[
        Path, typer.Argument(metavar="OTHER", help="The run that it is compared with.")
    ],
    highest: Annotated[
        float, typer.Option("--to", metavar="HZ", help="Highest frequency that is compared.")
    ] = 100.0,
) -> None:
    """Compare two runs of one 3D building, into the report of the first."""
    from impactfem import study

    tables, page = study.compare_runs(folder, other, highest)
    for table in tables:
        _say(table.as_text(PIPE_WIDTH))
    _say(f"report: {page}")


@app.command()
def check(
    case: CaseFile,
    fit: Annotated[
        Path | None, typer.Option(metavar="FIT.toml", help="Check this fit of the case, too.")
    ] = None,
) -> None:
    """Check a case file and all files it names, and estimate what a run takes."""
    from impactfem.case.motions import RestMotion
    from impactfem.run.check import checked

    of_fit = ""
    if fit is not None:  # first, as it tells the faults of both files
        from impactfem.fit.evaluate import evaluate
        from impactfem.fit.plausibility import warn_of_far_targets, warn_of_implausible
        from impactfem.fit.problem import read_problem

        problem = read_problem(case, fit, mesh=True)[0]
        warn_of_implausible(problem)
        if problem.level == "sticks":  # algebra, milliseconds
            values = evaluate(problem, problem.start, Path()).values
            warn_of_far_targets(problem, values)
        of_fit = f"{fit}: good. {len(problem.keys)} keys, {len(problem.data)} data\n"
    found, estimate = checked(case, mesh=True)
    _say(of_fit, nl=False)
    counts = (
        (len(found.buildings), "building"),
        (len(found.contacts), "contact pair"),
        (sum(not isinstance(one, RestMotion) for one in found.motions), "ground motion"),
    )
    counted = ", ".join(f"{n} {name}{'' if n == 1 else 's'}" for n, name in counts)
    _say(f"{case}: good. {counted}")
    for line in estimate.lines():
        _say(f"  {line}")


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new case.")],
    parts: Annotated[
        str,
        typer.Option(
            "--with",
            metavar="PARTS",
            help="Parts in use from the start, with commas between, and those that they need: "
            "structure, calibration, wall_impact, transient, devices, damping_cases, loads, "
            "ensemble or design.",
        ),
    ] = "",
    minimal: Annotated[
        bool, typer.Option("--minimal", help="Without comments and optional keys.")
    ] = False,
) -> None:
    """Write a commented case file to start from."""
    from impactfem.case.template import write_new_case

    chosen = [part.strip() for part in parts.split(",") if part.strip()]
    for path in write_new_case(name, chosen, minimal=minimal):
        _say(f"wrote {path}")


@app.command()
def verify(
    only: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Only the benchmarks with this in their name."),
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the rows to this file.")
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="The heavy benchmarks, too.")] = False,
    validation: Annotated[
        bool,
        typer.Option(
            "--validation",
            help="Only the cases of geometry/validation, against other programs and experiments.",
        ),
    ] = False,
) -> None:
    """Compute the verification manual again on this machine."""
    from impactfem.verify import manual

    rows = manual.verify(only, json_file, full, validation)
    _show(manual.as_table(rows, sources=validation))
    failed = [row for row in rows if not row.passed]
    _say(f"{len(rows) - len(failed)} of {len(rows)} within tolerance")
    if failed:
        raise typer.Exit(1)


@app.command()
def bench(
    groups: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[GROUP]...",
            help="sticks, spectra; on the default mesh basis (factor, solves, orthogonalisation, "
            "beside BLAS at its peak), wall, pounding (two buildings in 3D) and fit (by modes of a "
            "3D model); on the paper-size mesh, some minutes each, building, transient, dampings "
            "(the same with a basis for every damping case). The first two when left out.",
        ),
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the figures to this file.")
    ] = None,
) -> None:
    """Measure speed on this machine, as ratios in one run; needs a clone of the source tree."""
    from impactfem.system.files import in_source_tree

    sys.path.insert(0, str(in_source_tree("bench/suite.py").parents[1]))
    from bench import suite

    _show(suite.as_table(suite.measure(groups or (), json_file)))


def main() -> None:
    """Entry point: errors become one clear message each and an exit code, never a traceback.

    Exit codes: 0 done, 1 a computation or check failed, 2 the input is not usable; 128 plus the
    number of the signal that stopped it. Under `mpirun` a rank that fails alone takes the others
    with it.
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
