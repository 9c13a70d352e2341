"""Sweeps on a Ray cluster: `pip install phalanx[ray]`.

    import phalanx.ray

    phalanx.ray.sweep("scenes/studies/thesis.toml", "thesis.parquet")

Each Ray task simulates one part of the sweep, which takes about a second. Ray retries a part whose worker or machine
has failed. A finished part is a file, and is not simulated again by a retry or a restarted sweep. The merged parts have
the same bytes as the output of `phalanx sweep`.

Workers need the same version of phalanx. They either have access to the directory of the parts under the same path (the
default, for one machine or a shared file system), or send their parts to the driver (`shared=False`). The study and its
scenes are sent to them.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

from . import __version__, study_info, sweep_merge, sweep_shard
from .results import StudyInfo
from ._phalanx import _study_files
from .errors import PhalanxError, StudyError

if TYPE_CHECKING:
    from types import ModuleType

__all__ = ["SHARD_S", "Swept", "sweep"]

SHARD_S = 1.0
"""Target duration of a task, s. It is long compared with Ray's overhead of a few ms, and short enough to lose little
on failure.
"""

MAX_SHARD_RUNS = 250_000
"""Largest number of runs of a part. A worker keeps them in memory (about 1 kB each)."""

MAX_RETRIES = 20
"""Number of times that Ray retries a part whose worker or machine has failed."""

TASKS_PER_CPU = 4
"""Number of tasks in flight for each processor of the cluster. It is limited because Ray's scheduler is slow with a
million tasks.
"""


class Swept(NamedTuple):
    """Summary of a sweep."""

    out: Path
    """Path of the results. The file OUT.study.json identifies the study."""
    runs: int
    """Number of runs of the whole study."""
    shards: int
    """Number of parts."""
    made: int
    """Number of parts simulated in this call; the other parts already existed."""
    wall_s: float
    """Wall time of the call, s."""


class _Plan(NamedTuple):
    """Description of a sweep for the workers."""

    study: str
    """Path of the study, a key of `texts`."""
    texts: dict[str, str]
    """Contents of the study and scene files by relative path."""
    model: str | None
    preset: str | None
    check: bool
    fingerprint: str
    shards: int
    parts: str
    shared: bool


def sweep(
    study: str | os.PathLike[str],
    out: str | os.PathLike[str],
    shards: int | None = None,
    *,
    model: str | None = None,
    preset: str | None = None,
    check: bool = False,
    parts: str | os.PathLike[str] | None = None,
    shared: bool = True,
    shard_s: float = SHARD_S,
) -> Swept:
    """Simulates all runs of a study on a Ray cluster. The results have the same bytes as those of `phalanx sweep`.

    study: path of a study file (TOML). out: path of the results, CSV or Parquet according to its suffix. shards: number
    of parts; by default, a few runs are timed to choose parts that take about `shard_s` seconds each. model, preset,
    check: as in `phalanx.sweep`. parts: directory of the parts, by default OUT.parts; it is not deleted. shared:
    whether workers have access to this directory under the same path; if not, Ray transfers the parts.

    Uses the cluster of `ray.init` or RAY_ADDRESS, or else starts one on this machine. After an interruption, the same
    call simulates only missing parts. Raises StudyError for an invalid study or invalid results, and PhalanxError if
    Ray is not installed or a part failed.
    """
    ray = _import_ray()
    start = time.monotonic()
    study, out = Path(study), Path(out)
    parts = Path(parts) if parts is not None else out.with_name(out.name + ".parts")
    parts = parts.absolute()
    info = study_info(study, model=_any(model), preset=_any(preset), check=check)
    parts.mkdir(parents=True, exist_ok=True)
    if not ray.is_initialized():
        ray.init()
    cpus = max(1, int(ray.cluster_resources().get("CPU", 1)))
    if shards is None:
        shards = _planned_shards(parts, info) or _choose_shards(study, info, (model, preset), check, shard_s, cpus)
    _write_plan_file(parts, info, shards)
    study_path, texts = _read_texts(study)
    plan = _Plan(study_path, texts, model, preset, check, info["fingerprint"], shards, str(parts), shared)
    missing = [k for k in range(1, shards + 1) if not _part_path(parts, k, shards).exists()]
    _run_parts(ray, plan, missing, cpus, parts)
    sweep_merge(study, [_part_path(parts, k, shards) for k in range(1, shards + 1)], out, model=_any(model), preset=_any(preset), check=check)
    return Swept(out, info["runs"], shards, len(missing), time.monotonic() - start)


def _import_ray() -> ModuleType:
    try:
        import ray
    except ImportError as error:
        raise PhalanxError(
            "error: Ray is not installed, but this sweep needs it\n"
            "  = help: pip install phalanx[ray]; on one machine phalanx.sweep works without Ray"
        ) from error
    module: ModuleType = ray
    return module


def _any(name: str | None) -> Any:
    """Removes the type of a name for the type checker; the library validates it."""
    return name


def _part_path(parts: Path, k: int, shards: int) -> Path:
    return parts / f"part-{k}-of-{shards}.parquet"


def _plan_path(parts: Path) -> Path:
    return parts / "plan.json"


def _planned_shards(parts: Path, info: StudyInfo) -> int | None:
    """Returns the number of parts of an earlier sweep of the same study, whose parts can be reused."""
    try:
        plan = json.loads(_plan_path(parts).read_text())
        return int(plan["shards"]) if plan["fingerprint"] == info["fingerprint"] else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _write_plan_file(parts: Path, info: StudyInfo, shards: int) -> None:
    """Stores the number of parts for a later call."""
    text = json.dumps({"study": info["name"], "fingerprint": info["fingerprint"], "shards": shards})
    _write_atomically(_plan_path(parts), text.encode())


def _write_atomically(path: Path, contents: bytes) -> None:
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        partial.write_bytes(contents)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _choose_shards(
    study: Path, info: StudyInfo, settings: tuple[str | None, str | None], check: bool, shard_s: float, cpus: int
) -> int:
    """Returns the number of parts that take about `shard_s` each, from timed runs at the start, middle and end."""
    model, preset = settings
    runs = int(info["runs"])
    shard_count = max(1, runs // 32)
    elapsed_s, completed = 0.0, 0
    with TemporaryDirectory() as directory:
        for k in sorted({1, shard_count // 2 + 1, shard_count}):
            start = time.monotonic()
            part = sweep_shard(
                study, k, shard_count, Path(directory) / f"{k}.parquet", threads=1, model=_any(model), preset=_any(preset), check=check
            )
            elapsed_s += time.monotonic() - start
            completed += int(part["made_now"])
    shards = math.ceil(runs * (elapsed_s / max(completed, 1)) / shard_s)
    # At least one part per processor, and parts that fit into memory.
    return max(1, min(runs, max(shards, cpus, math.ceil(runs / MAX_SHARD_RUNS))))


def _read_texts(study: Path) -> tuple[str, dict[str, str]]:
    """Returns the path of the study and the texts of the study and its scenes, by path in their common directory."""
    files = [Path(os.path.abspath(file)) for file in _study_files(study)]
    root = Path(os.path.commonpath([file.parent for file in files]))
    texts = {file.relative_to(root).as_posix(): file.read_text(encoding="utf-8") for file in files}
    return files[0].relative_to(root).as_posix(), texts


def _run_parts(ray: ModuleType, plan: _Plan, missing: list[int], cpus: int, parts: Path) -> None:
    """Simulates the missing parts, with a limited number of tasks in flight."""
    task = ray.remote(num_cpus=1, max_retries=MAX_RETRIES)(_shard)
    plan_reference = ray.put(plan)
    remaining: Iterator[int] = iter(missing)
    running: dict[Any, int] = {}
    try:
        while True:
            while len(running) < TASKS_PER_CPU * cpus and (k := next(remaining, None)) is not None:
                running[task.remote(plan_reference, k)] = k
            if not running:
                return
            for reference in ray.wait(list(running), num_returns=1)[0]:
                k = running.pop(reference)
                _store_part(ray, reference, plan, k, parts)
    finally:
        # After an error or an interrupt, the remaining tasks are useless.
        for reference in running:
            ray.cancel(reference, force=False)


def _store_part(ray: ModuleType, reference: Any, plan: _Plan, k: int, parts: Path) -> None:
    """Writes the contents of a finished part, or checks that the worker has written them."""
    try:
        contents: bytes | None = ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        cause = getattr(error, "cause", None)
        raise cause if isinstance(cause, PhalanxError) else error from None
    except ray.exceptions.RayError as error:
        raise PhalanxError(
            f"error: part {k} of {plan.shards} failed after {MAX_RETRIES + 1} attempts of Ray: {error}\n"
            "  = help: finished parts are kept; repeat the call to simulate the missing ones"
        ) from error
    path = _part_path(parts, k, plan.shards)
    if contents is not None:
        _write_atomically(path, contents)
    elif not path.exists():
        raise PhalanxError(
            f"error: a worker has written {path}, but the file does not exist here: the workers use another directory with this path\n"
            "  = help: give parts=… in a directory that all machines share, or shared=False"
        )


_directories: dict[str, Any] = {}
"""Temporary directories that contain the files of a study, by its fingerprint. Each worker process has its own."""


def _shard(plan: _Plan, k: int) -> bytes | None:
    """Simulates a part on a worker. Writes it into the directory of the parts, or returns its bytes."""
    study = _local_study(plan)
    if plan.shared:
        out = _part_path(Path(plan.parts), k, plan.shards)
        out.parent.mkdir(parents=True, exist_ok=True)
        sweep_shard(study, k, plan.shards, out, threads=1, model=_any(plan.model), preset=_any(plan.preset), check=plan.check)
        return None
    with TemporaryDirectory() as directory:
        out = _part_path(Path(directory), k, plan.shards)
        sweep_shard(study, k, plan.shards, out, threads=1, model=_any(plan.model), preset=_any(plan.preset), check=plan.check)
        return out.read_bytes()


def _local_study(plan: _Plan) -> Path:
    """Returns the path of the study on this worker, whose first task writes the files."""
    directory = _directories.get(plan.fingerprint)
    if directory is None:
        directory = TemporaryDirectory(prefix="phalanx-")
        for name, text in plan.texts.items():
            path = Path(directory.name) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        info = study_info(Path(directory.name) / plan.study, model=_any(plan.model), preset=_any(plan.preset), check=plan.check)
        if info["fingerprint"] != plan.fingerprint:
            raise StudyError(
                f"error: phalanx {__version__} on this worker gives other results for the study than the version of the driver\n"
                "  = help: install the same version on all machines"
            )
        _directories[plan.fingerprint] = directory
    return Path(directory.name) / plan.study
