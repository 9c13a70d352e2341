"""Optimisation of designs by simulation (`optimize`), and studies in a form for other solvers (`function`, `problem`).

| module | purpose |
|---|---|
| `study` | the problem that a study file describes |
| `search` | NSGA-II and CMA-ES, scores of designs, checkpoints |
| `report` | text, JSON, pictures, pages and scenes |
| `run` | a search with its files |
| `solvers` | a study as a function, and as a problem of pymoo |
| `command` | command line of `python -m phalanx.optimize` |
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    from .run import Optimum
    from .solvers import Function

__all__ = ["function", "optimize", "problem"]

_Path: TypeAlias = str | os.PathLike[str]
_Model: TypeAlias = Literal["analytic", "engine"] | None
_Preset: TypeAlias = Literal["draft", "engineering", "reference"] | None


def optimize(
    study: _Path,
    out: _Path | None = None,
    *,
    model: _Model = None,
    preset: _Preset = None,
    threads: int = 0,
    plot: _Path | None = None,
    html: _Path | None = None,
    scenes: _Path | None = None,
    restart: bool = False,
    force: bool = False,
    progress: Callable[[int, int, int, int], None] | None = None,
) -> Optimum:
    """Searches for the best designs by varying fields of a scene within bounds. Every design is simulated.

    study: path of a study file (TOML) with base scene, variables, conditions, objectives and constraints. NSGA-II finds
    the Pareto front of several objectives, CMA-ES the best design for one objective. The result depends on the seed of
    the study and the versions of pymoo, cma and numpy, not on the number of threads.

    out: write all designs to this file, as CSV or Parquet according to its suffix. After each generation, the runs are
    written to a second file (OUT with the suffix `.runs.parquet`), so that repeating the call resumes an interrupted
    search with the same result. plot: write a picture (SVG or PNG). html: write a page with picture, tables and scenes.
    scenes: write each design of the front as a scene to this directory: design-N.toml, and start.toml. model: overrides
    the model of the study. preset: replaces the integrator settings of the scene; "draft" is the fastest. threads:
    number of threads; 0 for one per core. restart: discard earlier results in `out`. force: replace existing files that
    phalanx did not write. progress: called after each generation with the number of designs, the largest number of
    designs, the generation, and the number of designs that meet all constraints.

    Needs `pip install phalanx[optimize]`. Raises StudyError for an invalid study or unusable files, and SceneError for
    an invalid base scene.
    """
    # `import phalanx` stays fast without these modules.
    from .run import Outputs, load, run

    outputs = Outputs.of(out=out, plot=plot, html=html, scenes=scenes)
    return run(load(study, model, preset), outputs, threads, restart=restart, force=force, progress=progress)


def function(study: _Path, *, model: _Model = None, preset: _Preset = None, threads: int = 0) -> Function:
    """Returns a study as a function that any solver can use.

        f = phalanx.optimization.function("scenes/studies/optimize-95-fastest.toml")
        objectives, violations = f(f.start)
        objectives, violations = f({"design.base": "15 mm"})  # the other variables at their start

    The function takes the variables either as a vector in SI, in the order of `f.variables`, or as a dictionary of
    values in SI or with units. It returns two arrays: the values of `f.objectives` and the violations of
    `f.constraints`. All objectives are to be minimised: those to be maximised have the opposite sign, and missing ones
    are infinite. A violation is 0 if the constraint is met; the first violation counts runs without a verdict and
    missing figures. `f.bounds` are in SI. `f.scores` takes several designs, which run on `threads` threads (0: one per
    core).

    Needs `pip install phalanx[optimize]`. Raises StudyError for an invalid study or an unknown variable.
    """
    from .run import load
    from .solvers import Function

    return Function(load(study, model, preset), threads)


def problem(study: _Path, *, model: _Model = None, preset: _Preset = None, threads: int = 0) -> Any:
    """Returns a study as a `pymoo.core.problem.Problem`, which any algorithm of pymoo can use.

        problem = phalanx.optimization.problem("scenes/studies/optimize-95.toml")
        result = pymoo.optimize.minimize(problem, NSGA2(pop_size=32), ("n_gen", 20), seed=1)

    Variables are in SI; those with spacing = "log" are decadic logarithms of SI values. F contains the objectives, all
    to be minimised. G contains the violations as returned by `function`, so that Deb's feasibility rules rank designs
    as in `optimize`. A generation runs on `threads` threads (0: one per core).

    Needs `pip install phalanx[optimize]`. Raises StudyError for an invalid study.
    """
    from .run import load
    from .solvers import problem as new

    return new(load(study, model, preset), threads)
