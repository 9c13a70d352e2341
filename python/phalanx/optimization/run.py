"""Runs a search and writes its files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from ..errors import StudyError
from . import report, search, study
from .search import ArrowTable, Found, require
from .study import Optimisation

_Path: TypeAlias = str | os.PathLike[str]

# Names of the scenes of a front.
_DESIGNS = "design-*.toml"


class Optimum:
    """The results of an optimisation."""

    def __init__(self, found: Found, has_scenes: bool = False) -> None:
        self._found, self._has_scenes = found, has_scenes

    @property
    def designs(self) -> ArrowTable:
        """All designs as an Arrow table: `.to_pandas()`, or `polars.from_arrow`.

        Columns: number, generation, variables, objectives, the worst value of each constraint over the conditions,
        numbers of runs by status, violation of the constraints, whether the design meets them (`feasible`), and whether
        it is on the `front`.
        """
        return self._found.designs()

    @property
    def front(self) -> ArrowTable:
        """The Pareto-optimal designs, sorted by the first objective; for one objective, the best design."""
        return self.designs.take(self._found.front)

    @property
    def runs(self) -> ArrowTable:
        """All runs, ordered by design and condition, with the columns of `phalanx sweep`."""
        return self._found.runs

    @property
    def hypervolume(self) -> float | None:
        """Hypervolume of the front, relative to that of the start alone. None for one objective.

        Objectives are gains over the start. The reference point is worse than the start by 100 % in each objective.
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
        return f"<phalanx.optimization.run.Optimum of {len(found.generation)} designs, {len(found.front)} on the front>"


def load(path: _Path, model: str | None = None, preset: str | None = None) -> Optimisation:
    """Reads and checks a study file. `model` overrides the model of the study, and `preset` replaces the integrator
    settings. For errors, see `phalanx.optimize`.
    """
    require("pyarrow", "a search")
    return study.load(Path(path), model, preset)


@dataclass(frozen=True)
class Outputs:
    """Files of a search."""

    out: Path | None
    plot: Path | None
    html: Path | None
    scenes: Path | None

    @staticmethod
    def of(**paths: _Path | None) -> Outputs:
        """Returns the outputs with these paths."""
        return Outputs(**{name: None if path is None else Path(path) for name, path in paths.items()})

    def files(self) -> dict[str, Path]:
        """Returns all files by name, except the scenes."""
        files = {"out": self.out, "plot": self.plot, "html": self.html}
        if self.out is not None:
            files["runs of out"] = self.out.with_suffix(".runs.parquet")
            files["checkpoint of out"] = self.out.with_suffix(".runs.partial")
        return {name: path for name, path in files.items() if path is not None}


def run(
    optimisation: Optimisation,
    outputs: Outputs,
    threads: int = 0,
    *,
    restart: bool = False,
    force: bool = False,
    progress: search.Progress | None = None,
) -> Optimum:
    """Runs a search and writes its files; see `phalanx.optimize`."""
    files = outputs.files()
    _require_suffixes(files)
    if outputs.plot or outputs.html:
        require("matplotlib", "a picture")
    _require_targets(optimisation, files, force)
    if outputs.scenes:
        _require_scene_targets(optimisation, outputs.scenes, force)
    fingerprint, checkpoint = search.fingerprint(optimisation), None
    runs, partial = files.get("runs of out"), files.get("checkpoint of out")
    if runs and partial:
        if restart:
            runs.unlink(missing_ok=True)
            partial.unlink(missing_ok=True)
        checkpoint = search.open_checkpoint(partial, runs, fingerprint)
    try:
        found = search.run(optimisation, threads, checkpoint, progress)
        contents: dict[Path, bytes] = {}
        if runs and outputs.out:
            if found.new_runs or not runs.exists():
                contents[runs] = report.table_bytes(runs, found.runs, fingerprint, found.generation)
            contents[outputs.out] = report.table_bytes(outputs.out, found.designs(), fingerprint)
        if outputs.plot:
            contents[outputs.plot] = report.picture(found, outputs.plot.suffix[1:])
        if outputs.html:
            contents[outputs.html] = report.page(found).encode()
        if outputs.scenes:
            outputs.scenes.mkdir(parents=True, exist_ok=True)
            contents |= {outputs.scenes / name: text.encode() for name, text in report.scenes(found).items()}
        for path, content in contents.items():
            _write(path, content)
        if outputs.scenes:
            # Designs of an earlier search are not on this front.
            for path in set(outputs.scenes.glob(_DESIGNS)) - set(contents):
                path.unlink()
        if partial:
            partial.unlink(missing_ok=True)
    finally:
        if checkpoint:
            checkpoint.close()
    return Optimum(found, has_scenes=outputs.scenes is not None)


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
    for path in [directory / "start.toml", *sorted(directory.glob(_DESIGNS))]:
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
