"""Optimisation of designs by simulation: `phalanx.optimize`.

| module | purpose |
|---|---|
| `study` | study files: keys, checks, and the resulting problem |
| `search` | NSGA-II and CMA-ES, scores of designs, checkpoints |
| `report` | text, JSON, pictures, pages and scenes |
| `run` | a search with its files |
| `command` | command line of `python -m phalanx.optimize` |
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from .run import Optimum

__all__ = ["optimize"]

_Path: TypeAlias = str | os.PathLike[str]


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
    # `import phalanx` stays fast without these modules.
    from .run import Outputs, load, run

    outputs = Outputs.of(out=out, plot=plot, html=html, scenes=scenes)
    return run(load(study, model), outputs, threads, restart=restart, force=force, progress=progress)
