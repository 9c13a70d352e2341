"""Command line: `phalanx optimize STUDY --out FILE`, or `python -m phalanx.optimize`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from .. import __version__
from ..errors import PhalanxError
from . import report
from .run import Outputs, load, run

_DESCRIPTION = """\
Search for the best designs by varying fields within bounds; objectives and constraints are results of simulations.

The study file (TOML) names a base scene, the variable fields with their bounds, the conditions under which every design
runs (friction, offsets, tolerances), the objectives to minimise or maximise, and the constraints;
scenes/studies/optimize-95.toml is an example to copy. NSGA-II finds the Pareto front of several objectives, CMA-ES the
best design for one objective. The search starts at the base scene and compares all designs with it.

Each design is a row of OUT, with its generation and whether it is on the front. Its runs are rows of a second table
(OUT with the suffix .runs.parquet), with the columns of `phalanx sweep`. Runs are written after each generation;
repeating an interrupted command resumes the search and gives the same result."""

_EPILOG = """\
examples:
  phalanx optimize scenes/studies/optimize-95.toml --out front.parquet --plot front.html
  phalanx optimize my-study.toml --out front.csv --scenes front --json
  phalanx optimize my-study.toml --list

exit status: 0 done; 1 no design meets all constraints; 2 bad input; 3 interrupted (the same command resumes), or files
could not be written."""


def _count(minimum: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not text.isdigit() or int(text) < minimum:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least {minimum}")
        return int(text)

    return parse


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="phalanx optimize",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("study", type=Path, metavar="STUDY", help="study file (TOML); `phalanx schema optimize` describes it")
    add("--out", type=Path, metavar="FILE", help="write all designs to this file, as CSV or Parquet by its suffix")
    add("--model", choices=("analytic", "engine"), help="simulation model, instead of the one in the study")
    add("--preset", choices=("draft", "engineering", "reference"), help="settings of the integrator, instead of those of the scene")
    add("--threads", type=_count(0), default=0, metavar="N", help="number of threads; 0 (default) uses all cores")
    add(
        "--plot",
        type=Path,
        action="append",
        default=[],
        metavar="FILE.svg|png|html",
        help="write a picture of the designs and the front, or a page that also has the tables and the scenes of the "
        "front; can be repeated",
    )
    add(
        "--scenes",
        type=Path,
        metavar="DIR",
        help="write each design of the front as a scene to this directory: design-N.toml, and start.toml",
    )
    add("--best", type=_count(1), default=10, metavar="NUMBER", help="number of designs to print (default: 10)")
    add("--restart", action="store_true", help="discard the results of earlier commands and start again")
    add("--force", action="store_true", help="replace existing files that phalanx did not write")
    add("--list", action="store_true", help="list variables, objectives and constraints without running the search")
    add("--json", action="store_true", help="print one JSON document with SI units in its keys instead of tables")
    add("-q", "--quiet", action="store_true", help="print results and errors only; no progress and no notes")
    add("-V", "--version", action="version", version=f"phalanx {__version__}")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit status."""
    parser = _parser()
    args = parser.parse_args(arguments)
    if args.out is None and not args.list:
        parser.error("--out FILE is missing, the file of the designs")
    pictures = [[path for path in args.plot if (path.suffix == ".html") == is_page] for is_page in (False, True)]
    if any(len(files) > 1 for files in pictures):
        parser.error("--plot takes one picture and one page")
    plot, html = (files[0] if files else None for files in pictures)
    try:
        return _command(args, plot, html)
    except KeyboardInterrupt:
        hint = "; finished generations are stored, and the same command resumes from there" if args.out else ""
        return _fail(f"error: the search was interrupted{hint}", 3)
    except PhalanxError as error:
        return _fail(error._command_message, 2)
    except OSError as error:
        return _fail(f"error: cannot write: {error}; finished generations are stored, and the same command resumes", 3)


def _command(args: argparse.Namespace, plot: Path | None, html: Path | None) -> int:
    optimisation = load(args.study, args.model, args.preset)
    if args.list:
        print(report.plan_text(optimisation), end="")
        return 0
    is_shown = not args.quiet and sys.stderr.isatty()

    def progress(designs: int, most: int, generation: int, feasible: int) -> None:
        text = f"{designs} of at most {most} designs, generation {generation}, {feasible} meet all constraints"
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    try:
        result = run(
            optimisation,
            Outputs(args.out, plot, html, args.scenes),
            args.threads,
            restart=args.restart,
            force=args.force,
            progress=progress if is_shown else None,
        )
    finally:
        if is_shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
    found = result._found
    if found.new_runs == 0 and not args.quiet:
        print(f"{args.out} already contains this search; nothing was run. --restart runs it again.", file=sys.stderr)
    print(report.json_text(found) if args.json else result.text(args.best), end="")
    return 0 if found.front else 1


def _fail(message: str, status: int) -> int:
    print(message, file=sys.stderr)
    return status
