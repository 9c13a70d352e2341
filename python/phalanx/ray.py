"""Sweeps over the machines of a Ray cluster: `pip install phalanx[ray]`.

    import phalanx.ray

    phalanx.ray.sweep("scenes/studies/thesis.toml", "thesis.parquet")

A sweep is made in parts of about a second each, one task a part. Ray gives a part whose worker or machine is gone to another one;
a part that is finished is a file, and is not made again, neither by a retry nor when the sweep is started again. In the end the
parts are joined to the very bytes that `phalanx sweep` writes.

Workers need phalanx of this version, and either see the directory of the parts under the same path (the default: a machine by
itself, or a shared file system), or send their parts to whoever asked (`shared=False`). The study and its scenes are sent along.
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
from ._phalanx import _study_files
from .errors import PhalanxError, StudyError

if TYPE_CHECKING:
    from types import ModuleType

__all__ = ["SHARD_S", "Swept", "sweep"]

SHARD_S = 1.0
"""How long a task should take, in s: long beside the few milliseconds that one costs Ray, short beside what is lost with a worker."""

MOST_SHARD_RUNS = 250_000
"""Runs of a part at most: it is held in the worker's memory, a kilobyte each."""

RETRIES = 20
"""How often Ray makes a part again whose worker or machine is gone."""

AHEAD = 4
"""Tasks that are handed to Ray ahead, for each of the cluster's processors: a scheduler with a million of them would be slow."""


class Swept(NamedTuple):
    """What a sweep came to."""

    out: Path
    """The results; beside them OUT.study.json says of which study they are."""
    runs: int
    """Of the whole study."""
    shards: int
    """Parts that it was made in."""
    made: int
    """Parts that were made now; the others were there already."""
    wall_s: float
    """Time that all of it took, in s."""


class _Plan(NamedTuple):
    """What a worker needs to know of a sweep."""

    study: str
    """Path of the study among the texts."""
    texts: dict[str, str]
    model: str | None
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
    check: bool = False,
    parts: str | os.PathLike[str] | None = None,
    shared: bool = True,
    shard_s: float = SHARD_S,
) -> Swept:
    """Makes every run of a study on a Ray cluster, and writes the results of `phalanx sweep STUDY --out OUT`, byte for byte.

    study: path of a study file (TOML). out: CSV or Parquet by the name. shards: how many parts; if it is not given, a few runs are
    measured here and parts chosen that take about `shard_s` seconds each. model, check: as for `phalanx.sweep`. parts: directory
    of the parts, OUT.parts if it is not given; it stays when the sweep is over. shared: whether workers see that directory under
    this path; if not, their parts come through Ray.

    Uses the cluster that `ray.init` has connected to, or RAY_ADDRESS names, or else makes one of this machine. Started again after
    whatever ended it, it makes what is missing. Raises StudyError for what is wrong with the study or its results, PhalanxError
    where Ray is not installed or a part was not made.
    """
    ray = _ray()
    start = time.monotonic()
    study, out = Path(study), Path(out)
    parts = Path(parts) if parts is not None else out.with_name(out.name + ".parts")
    parts = parts.absolute()
    info = study_info(study, model=_model(model), check=check)
    parts.mkdir(parents=True, exist_ok=True)
    if not ray.is_initialized():
        ray.init()
    cpus = max(1, int(ray.cluster_resources().get("CPU", 1)))
    if shards is None:
        shards = _planned(parts, info) or _measured(study, info, model, check, shard_s, cpus)
    _note(parts, info, shards)
    base, texts = _texts(study)
    plan = _Plan(base, texts, model, check, info["fingerprint"], shards, str(parts), shared)
    missing = [k for k in range(1, shards + 1) if not _part(parts, k, shards).exists()]
    _make(ray, plan, missing, cpus, parts)
    sweep_merge(study, [_part(parts, k, shards) for k in range(1, shards + 1)], out, model=_model(model), check=check)
    return Swept(out, info["runs"], shards, len(missing), time.monotonic() - start)


def _ray() -> ModuleType:
    try:
        import ray
    except ImportError as error:
        raise PhalanxError(
            "error: Ray is not installed, and this sweep runs on it\n"
            "  = help: pip install phalanx[ray]; on one machine phalanx.sweep does without it"
        ) from error
    module: ModuleType = ray
    return module


def _model(model: str | None) -> Any:
    """Whether it is one of the models is the library's to say."""
    return model


def _part(parts: Path, k: int, shards: int) -> Path:
    return parts / f"part-{k}-of-{shards}.parquet"


def _plan_file(parts: Path) -> Path:
    return parts / "plan.json"


def _planned(parts: Path, info: dict[str, Any]) -> int | None:
    """How many parts an earlier sweep of this very study was to have: only such are of use to this one."""
    try:
        found = json.loads(_plan_file(parts).read_text())
        return int(found["shards"]) if found["fingerprint"] == info["fingerprint"] else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _note(parts: Path, info: dict[str, Any], shards: int) -> None:
    """Writes down how many parts there are to be; whole or not at all."""
    text = json.dumps({"study": info["name"], "fingerprint": info["fingerprint"], "shards": shards})
    _replace(_plan_file(parts), text.encode())


def _replace(path: Path, contents: bytes) -> None:
    beside = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        beside.write_bytes(contents)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def _measured(study: Path, info: dict[str, Any], model: str | None, check: bool, shard_s: float, cpus: int) -> int:
    """How many parts take about `shard_s` each: from a few runs at the beginning, in the middle and at the end of the study."""
    runs = int(info["runs"])
    pieces = max(1, runs // 32)
    spent_s, made = 0.0, 0
    with TemporaryDirectory() as directory:
        for k in sorted({1, pieces // 2 + 1, pieces}):
            start = time.monotonic()
            found = sweep_shard(
                study, k, pieces, Path(directory) / f"{k}.parquet", threads=1, model=_model(model), check=check
            )
            spent_s += time.monotonic() - start
            made += int(found["made_now"])
    wanted = math.ceil(runs * (spent_s / max(made, 1)) / shard_s)
    # Nobody waits while others work, as far as that is possible; and a part has to fit into memory.
    return max(1, min(runs, max(wanted, cpus, math.ceil(runs / MOST_SHARD_RUNS))))


def _texts(study: Path) -> tuple[str, dict[str, str]]:
    """The study and its scenes by their paths from a directory that has them all, and the study's own path."""
    files = [Path(os.path.abspath(file)) for file in _study_files(study)]
    root = Path(os.path.commonpath([file.parent for file in files]))
    texts = {file.relative_to(root).as_posix(): file.read_text(encoding="utf-8") for file in files}
    return files[0].relative_to(root).as_posix(), texts


def _make(ray: ModuleType, plan: _Plan, missing: list[int], cpus: int, parts: Path) -> None:
    """Makes parts, never more at a time than keep the cluster busy."""
    task = ray.remote(num_cpus=1, max_retries=RETRIES)(_shard)
    known = ray.put(plan)
    left: Iterator[int] = iter(missing)
    running: dict[Any, int] = {}
    try:
        while True:
            while len(running) < AHEAD * cpus and (k := next(left, None)) is not None:
                running[task.remote(known, k)] = k
            if not running:
                return
            for done in ray.wait(list(running), num_returns=1)[0]:
                k = running.pop(done)
                _take(ray, done, plan, k, parts)
    finally:
        # Whatever ended this: what is still running serves nobody.
        for of in running:
            ray.cancel(of, force=False)


def _take(ray: ModuleType, done: Any, plan: _Plan, k: int, parts: Path) -> None:
    """Takes a finished part."""
    try:
        contents: bytes | None = ray.get(done)
    except ray.exceptions.RayTaskError as error:
        cause = getattr(error, "cause", None)
        raise cause if isinstance(cause, PhalanxError) else error from None
    except ray.exceptions.RayError as error:
        raise PhalanxError(
            f"error: part {k} of {plan.shards} was not made, though Ray tried it {RETRIES + 1} times: {error}\n"
            "  = help: what is finished stays; the same call again makes what is missing"
        ) from error
    path = _part(parts, k, plan.shards)
    if contents is not None:
        _replace(path, contents)
    elif not path.exists():
        raise PhalanxError(
            f"error: a worker has made {path}, but it is not there: the workers have another directory of this name\n"
            "  = help: give parts=… in a directory that all machines share, or shared=False"
        )


_places: dict[str, Any] = {}


def _shard(plan: _Plan, k: int) -> bytes | None:
    """Makes a part, on a worker: into the directory of the parts, or else as bytes."""
    study = _at(plan)
    if plan.shared:
        out = _part(Path(plan.parts), k, plan.shards)
        out.parent.mkdir(parents=True, exist_ok=True)
        sweep_shard(study, k, plan.shards, out, threads=1, model=_model(plan.model), check=plan.check)
        return None
    with TemporaryDirectory() as directory:
        out = _part(Path(directory), k, plan.shards)
        sweep_shard(study, k, plan.shards, out, threads=1, model=_model(plan.model), check=plan.check)
        return out.read_bytes()


def _at(plan: _Plan) -> Path:
    """Where the study is on this worker: its texts are written once, and looked at by all its tasks."""
    place = _places.get(plan.fingerprint)
    if place is None:
        place = TemporaryDirectory(prefix="phalanx-")
        for name, text in plan.texts.items():
            path = Path(place.name) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        found = study_info(Path(place.name) / plan.study, model=_model(plan.model), check=plan.check)
        if found["fingerprint"] != plan.fingerprint:
            raise StudyError(
                f"error: this worker has phalanx {__version__}, whose runs of the study are not those of whoever asked\n"
                "  = help: install the same version on all machines"
            )
        _places[plan.fingerprint] = place
    return Path(place.name) / plan.study
