"""Optimisation of designs by simulation: `phalanx.optimize`, and the command line of `python -m phalanx.optimize`."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from .. import __version__
from ..errors import PhalanxError, SceneError, StudyError
from . import report, search, study
from .search import Found, require
from .study import Optimisation

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Optimum", "main", "optimize"]

_Path: TypeAlias = str | os.PathLike[str]


class Optimum:
    """The results of an optimisation."""

    def __init__(self, found: Found, has_scenes: bool = False) -> None:
        self._found, self._has_scenes = found, has_scenes

    @property
    def designs(self) -> pa.Table:
        """All designs as an Arrow table: `.to_pandas()`, or `polars.from_arrow`.

        Columns: number, generation, variables, objectives, the worst value of each constraint over the conditions, runs
        by status, violation of the constraints, and whether the design meets them (`feasible`) and is on the `front`.
        """
        return self._found.designs()

    @property
    def front(self) -> pa.Table:
        """The Pareto-optimal designs, sorted by the first objective; for one objective, the best design."""
        return self.designs.take(self._found.front)

    @property
    def runs(self) -> pa.Table:
        """All runs, ordered by design and condition, with the columns of `phalanx sweep`."""
        return self._found.runs

    @property
    def hypervolume(self) -> float | None:
        """Hypervolume of the front in units of the start: that of the start alone is 1. None for one objective.

        Objectives are gains over the start; the reference point is worse than the start by 100 % in each.
        """
        return self._found.hypervolume()

    @property
    def summary(self) -> dict[str, Any]:
        """The document of `python -m phalanx.optimize --json`: front, comparison with the start, and counts of runs."""
        return report.document(self._found)

    @property
    def scenes(self) -> dict[str, str]:
        """The scenes of the start and of the front, by file name."""
        return report.scenes(self._found)

    def text(self, best: int = 10) -> str:
        """Returns the report of the command line, with at most `best` designs of the front."""
        return report.text(self._found, best, self._has_scenes)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        found = self._found
        return f"<phalanx.optimization.Optimum of {len(found.generation)} designs, {len(found.front)} on the front>"


def optimize(
    study: _Path,
    out: _Path | None = None,
    *,
    model: Literal["analytic", "engine"] | None = None,
    threads: int = 0,
    plot: _Path | None = None,
    html: _Path | None = None,
    scenes: _Path | None = None,
    restart: bool = False,
    force: bool = False,
    progress: Callable[[int, int, int, int], None] | None = None,
) -> Optimum:
    """Searches for the best designs by varying fields of a scene within bounds; every design is simulated.

    study: path of a study file (TOML) with base scene, variables, conditions, objectives and constraints. NSGA-II finds
    the Pareto front of several objectives, CMA-ES the best design for one objective. The result depends on the seed of
    the study and the versions of pymoo, cma and numpy, not on the number of threads.

    out: write all designs to this file, as CSV or Parquet by its suffix. The runs are written beside it after each
    generation (OUT with the suffix `.runs.parquet`), so that the same call resumes an interrupted search with the same
    result. plot: write a picture (SVG or PNG). html: write a page with picture, tables and scenes. scenes: write each
    design of the front as a scene to this directory: design-N.toml, and start.toml. model: overrides the model of the
    study. threads: 0 for one per core. restart: discard earlier results in out. force: replace existing files that
    phalanx did not write. progress: called after each generation with the number of designs, the largest number of
    designs, the generation, and the number of designs that meet all constraints.

    Needs `pip install phalanx[optimize]`. Raises StudyError for an invalid study or unusable files, and SceneError for
    an invalid base scene.
    """
    optimisation = _load(study, model)
    return _run(optimisation, out, threads, plot, html, scenes, restart, force, progress)


def _load(path: _Path, model: str | None) -> Optimisation:
    require("pyarrow", "a search")
    return study.load(Path(path), model)


def _run(
    optimisation: Optimisation,
    out: _Path | None,
    threads: int,
    plot: _Path | None,
    html: _Path | None,
    scenes: _Path | None,
    restart: bool,
    force: bool,
    progress: search.Progress | None,
) -> Optimum:
    paths = {"out": out, "plot": plot, "html": html}
    targets = {name: Path(path) for name, path in paths.items() if path is not None}
    _require_suffixes(targets)
    if plot is not None or html is not None:
        require("matplotlib", "a picture")
    fingerprint = search.fingerprint(optimisation)
    checkpoint, runs = None, None
    if "out" in targets:
        runs = targets["runs of out"] = targets["out"].with_suffix(".runs.parquet")
        targets["checkpoint of out"] = targets["out"].with_suffix(".runs.partial")
    _require_targets(optimisation, targets, force)
    if scenes is not None:
        _require_scene_targets(optimisation, Path(scenes), force)
    if runs is not None:
        if restart:
            runs.unlink(missing_ok=True)
            targets["checkpoint of out"].unlink(missing_ok=True)
        checkpoint = search.open_checkpoint(targets["checkpoint of out"], runs, fingerprint)
    try:
        found = search.run(optimisation, threads, checkpoint, progress)
    finally:
        if checkpoint:
            checkpoint.close()
    contents: dict[Path, bytes] = {}
    if runs is not None:
        if found.new_runs or not runs.exists():
            contents[runs] = report.table_bytes(runs, found.runs, fingerprint, found.generation)
        contents[targets["out"]] = report.table_bytes(targets["out"], found.designs(), fingerprint)
    if plot is not None:
        contents[targets["plot"]] = report.picture(found, targets["plot"].suffix[1:])
    if html is not None:
        contents[targets["html"]] = report.page(found).encode()
    if scenes is not None:
        Path(scenes).mkdir(parents=True, exist_ok=True)
        contents |= {Path(scenes) / name: text.encode() for name, text in report.scenes(found).items()}
    for path, content in contents.items():
        _write(path, content)
    if "checkpoint of out" in targets:
        targets["checkpoint of out"].unlink(missing_ok=True)
    return Optimum(found, has_scenes=scenes is not None)


def _require_suffixes(targets: dict[str, Path]) -> None:
    for name, suffixes in [("out", (".csv", ".parquet")), ("plot", (".svg", ".png"))]:
        if name in targets and targets[name].suffix not in suffixes:
            allowed = " or ".join(suffixes)
            raise StudyError(
                f"error: {name}: {targets[name]} must end in {allowed}\n  = help: the suffix determines the format"
            )


def _require_targets(optimisation: Optimisation, targets: dict[str, Path], force: bool) -> None:
    """Refuses targets that are inputs, that are the same file, or that phalanx did not write."""
    known = {os.path.realpath(file): "an input of the search" for file in optimisation.files}
    for name, path in targets.items():
        real = os.path.realpath(path)
        if real in known:
            raise StudyError(f"error: {name}: {path} is {known[real]}\n  = help: choose another file")
        known[real] = f"also the file of {name}"
        if not path.parent.is_dir():
            raise StudyError(f"error: {name}: the directory {path.parent} does not exist\n  = help: create it first")
        if not (force or _is_own(path)):
            raise StudyError(
                f"error: {name}: {path} exists, and phalanx did not write it\n"
                "  = help: choose another file, or replace it with --force (force=True)"
            )


def _require_scene_targets(optimisation: Optimisation, directory: Path, force: bool) -> None:
    if directory.exists() and not directory.is_dir():
        raise StudyError(f"error: scenes: {directory} is not a directory\n  = help: choose another directory")
    for path in [directory / "start.toml", *sorted(directory.glob("design-*.toml"))]:
        if any(os.path.realpath(path) == os.path.realpath(file) for file in optimisation.files):
            raise StudyError(f"error: scenes: {path} is an input of the search\n  = help: choose another directory")
        if not (force or _is_own(path)):
            raise StudyError(
                f"error: scenes: {path} exists, and phalanx did not write it\n"
                "  = help: choose another directory, or replace its scenes with --force (force=True)"
            )


def _is_own(path: Path) -> bool:
    """Whether a path is free, or a file that phalanx wrote, which the beginning or the end of the file tells."""
    if not path.exists():
        return True
    if not path.is_file():
        return False
    with path.open("rb") as file:
        start = file.read(1024)
        file.seek(max(path.stat().st_size - 65536, 0))
        # Parquet files have their metadata at the end.
        is_own = b"phalanx" in start or (start.startswith(b"PAR1") and b"phalanx.optimize" in file.read())
    return is_own or start == b"" or start.startswith(b"design,generation,")


def _write(path: Path, content: bytes) -> None:
    """Writes a file atomically: to a temporary file beside it, which is then renamed."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


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
  python -m phalanx.optimize scenes/studies/optimize-95.toml --out front.parquet --html front.html
  python -m phalanx.optimize my-study.toml --out front.csv --scenes front --json
  python -m phalanx.optimize my-study.toml --list
  python -m phalanx.optimize --schema > optimisation.schema.json

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
        prog="python -m phalanx.optimize",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("study", nargs="?", type=Path, metavar="STUDY", help="study file (TOML); --schema describes it")
    add("--out", type=Path, metavar="FILE", help="write all designs to this file, as CSV or Parquet by its suffix")
    add("--model", choices=("analytic", "engine"), help="simulation model, instead of the one in the study")
    add("--threads", type=_count(0), default=0, metavar="N", help="number of threads; 0 (default) uses all cores")
    add("--plot", type=Path, metavar="FILE", help="write a picture of the designs and the front, as SVG or PNG")
    add(
        "--html",
        type=Path,
        metavar="FILE.html",
        help="write a page with the picture, the tables and the scenes of the front",
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
    add("--schema", action="store_true", help="print the JSON Schema of study files, for editors")
    add("--json", action="store_true", help="print one JSON document with SI units in its keys instead of tables")
    add("-q", "--quiet", action="store_true", help="print results and errors only; no progress and no notes")
    add("-V", "--version", action="version", version=f"phalanx {__version__}")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit status."""
    parser = _parser()
    args = parser.parse_args(arguments)
    if args.schema:
        import json

        print(json.dumps(study.schema(), indent=2, ensure_ascii=False))
        return 0
    if args.study is None or (args.out is None and not args.list):
        parser.error(
            "the study file is missing" if args.study is None else "--out FILE is missing, the file of the designs"
        )
    try:
        return _command(args)
    except KeyboardInterrupt:
        hint = "; finished generations are stored, and the same command resumes from there" if args.out else ""
        return _fail(f"error: the search was interrupted{hint}", 3)
    except (SceneError, StudyError) as error:
        return _fail(str(error), 2)
    except PhalanxError as error:
        return _fail(str(error), 2)
    except OSError as error:
        return _fail(f"error: cannot write: {error}; finished generations are stored, and the same command resumes", 3)


def _command(args: argparse.Namespace) -> int:
    optimisation = _load(args.study, args.model)
    if args.list:
        print(report.plan_text(optimisation), end="")
        return 0
    is_shown = not args.quiet and sys.stderr.isatty()

    def progress(designs: int, most: int, generation: int, feasible: int) -> None:
        text = f"{designs} of at most {most} designs, generation {generation}, {feasible} meet all constraints"
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    try:
        result = _run(
            optimisation,
            args.out,
            args.threads,
            args.plot,
            args.html,
            args.scenes,
            args.restart,
            args.force,
            progress if is_shown else None,
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
