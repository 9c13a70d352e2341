"""Search: NSGA-II (pymoo) or CMA-ES (cma) proposes generations, which are simulated, scored and stored."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _phalanx
from ..errors import PhalanxError, StudyError
from .study import CLASSES, Constraint, Objective, Optimisation

Array: TypeAlias = npt.NDArray[Any]
ArrowTable: TypeAlias = Any
"""A table of pyarrow, which has no type stubs."""

STATUSES = ["completed", "filtered", "refused", "failed"]
"""Status of a run."""

INITIAL_STEP_SIZE = 0.3
"""Initial step size of CMA-ES, relative to the ranges. With it, the first samples cover most of the ranges."""

CONVERGENCE_TOLERANCE = 1e-6
"""CMA-ES has converged when the standard deviations of a generation are below this fraction of the ranges."""


def require(name: str, purpose: str) -> ModuleType:
    """Imports a package of the extra `optimize`."""
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise PhalanxError(
            f"error: {package} is not installed, but {purpose} needs it\n  = help: pip install phalanx[optimize]"
        ) from error


@dataclass
class Scores:
    """Evaluation of designs from their runs. Arrays have one row or entry per design."""

    values: Array
    """Objectives in SI, without change of sign; NaN if a run does not have the figure. Shape: designs × objectives."""
    minimised: Array
    """Objectives with signs such that all are to be minimised; infinite if missing."""
    violations: Array
    """Violations of each design: the first column counts missing verdicts and figures, then there is one column per
    constraint; 0 if met.
    """
    worst: list[list[Any]]
    """Worst value of each constraint over the conditions; the first index is the constraint, the second the design."""
    by_status: Array
    """Number of runs of each design by status, in the order of STATUSES."""

    @property
    def violation(self) -> Array:
        """Sum of the violations of each design."""
        return np.asarray(sum(self.violations.T))

    @property
    def finite(self) -> Array:
        """Objectives, all to be minimised. They are finite, because an infeasible design is ranked by its violation
        alone.
        """
        return np.where(np.isfinite(self.minimised), self.minimised, np.finfo(float).max)

    @property
    def feasible(self) -> Array:
        """For each design, whether it meets all constraints."""
        return self.violation <= 0.0


def score(optimisation: Optimisation, runs: ArrowTable) -> Scores:
    """Scores designs from their runs. The runs are ordered by design and condition.

    Violations are sums over all conditions. A run without a verdict (not completed, or the finger cannot grasp its
    object) counts 1; a missing figure counts 1; a violated constraint counts from 0 to 1, depending on the deviation.
    """
    shape = (-1, len(optimisation.conditions))

    def numbers(name: str) -> Array:
        column = np.asarray(runs[name].to_numpy(zero_copy_only=False), dtype=float)
        return np.where(np.isfinite(column), column, np.nan).reshape(shape)

    def objects(name: str) -> Array:
        return np.array([*runs[name].to_pylist(), None], dtype=object)[:-1].reshape(shape)

    statuses = objects("status")
    verdict = optimisation.verdict
    is_missing = _equals(objects(verdict), None) if verdict else ~_equals(statuses, "completed")
    results = np.sum(is_missing, axis=1).astype(float)
    values, minimised = [], []
    for objective in optimisation.objectives:
        stacked = np.stack([numbers(name) for name in objective.columns])
        reductions: dict[str, Callable[..., Any]] = {"largest": np.max, "smallest": np.min, "sum": np.sum}
        figures = np.asarray(reductions[objective.of](stacked, axis=0))
        results += np.sum(np.isnan(figures), axis=1)
        value = _aggregate(objective, figures)
        values.append(value)
        minimised.append(np.where(np.isnan(value), np.inf, value if objective.goal == "min" else -value))
    worst, violations = [], [results]
    for constraint in optimisation.constraints:
        is_bound = constraint.at_least is not None or constraint.at_most is not None
        cells = numbers(constraint.column) if is_bound else objects(constraint.column)
        of_runs, margins = _violations(constraint, cells)
        violations.append(np.sum(of_runs, axis=1))
        rows = objects(constraint.column)
        worst.append([row[index] for row, index in zip(rows, np.argmin(margins, axis=1), strict=True)])
    counts = np.column_stack([np.sum(_equals(statuses, status), axis=1) for status in STATUSES])
    return Scores(np.column_stack(values), np.column_stack(minimised), np.column_stack(violations), worst, counts)


def _equals(cells: Array, value: Any) -> Array:
    return np.array([[cell == value for cell in row] for row in cells], dtype=bool).reshape(cells.shape)


def _aggregate(objective: Objective, figures: Array) -> Array:
    """Returns the value of each design over its conditions; NaN if one is missing."""
    if objective.over == "mean":
        return np.asarray(np.mean(figures, axis=1))
    return np.asarray(np.max(figures, axis=1) if objective.goal == "min" else np.min(figures, axis=1))


def _violations(constraint: Constraint, cells: Array) -> tuple[Array, Array]:
    """Returns the violation of each run, from 0 to 1, and its margin; a run without the figure violates by 1."""
    if constraint.worst_class is not None:
        ranks = np.array([[CLASSES.index(cell) if cell in CLASSES else -1 for cell in row] for row in cells])
        excess = np.maximum(ranks - constraint.worst_class, 0) / (len(CLASSES) - 1)
        return np.where(ranks < 0, 1.0, excess), np.where(ranks < 0, -np.inf, -ranks.astype(float))
    if constraint.equals is not None:
        violations = 1.0 - _equals(cells, constraint.equals)
        return violations, -violations
    violations, margins = np.zeros(cells.shape), np.full(cells.shape, np.inf)
    for bound, sign in ((constraint.at_least, 1.0), (constraint.at_most, -1.0)):
        if bound is not None:
            margin = sign * (cells - bound)
            # The deficit relative to the bound, or to one SI unit if the bound is 0, mapped to values below 1.
            ratio = np.maximum(-margin / (abs(bound) or 1.0), 0.0)
            violations, margins = np.maximum(violations, ratio / (1.0 + ratio)), np.minimum(margins, margin)
    missing = np.isnan(cells)
    return np.where(missing, 1.0, violations), np.where(missing, -np.inf, margins)


def dominates(a: Array, b: Array) -> Array:
    """Returns, for each row of `a`, whether it dominates `b`. All objectives are minimised."""
    return np.asarray(np.all(a <= b, axis=-1) & np.any(a < b, axis=-1))


def pareto_front(scores: Scores) -> list[int]:
    """Returns the feasible designs that no other design dominates, sorted by objectives. Of equal designs, only the
    first one is returned.
    """
    minimised, front = scores.minimised, np.zeros(0, dtype=int)
    for index in np.flatnonzero(scores.feasible):
        # Designs of the front that are no worse in every objective exclude this one.
        if np.any(np.all(minimised[front] <= minimised[index], axis=1)):
            continue
        front = np.append(front[~dominates(minimised[index], minimised[front])], index)
    return sorted((int(index) for index in front), key=lambda index: (*minimised[index], index))


class Search(Protocol):
    """A search over the unit cube; it proposes candidates and receives their scores."""

    def ask(self) -> Array:
        """Returns the candidates of the next generation, one per row."""

    def tell(self, scores: Scores) -> None:
        """Receives the scores of the last generation, in the order of its candidates."""

    def has_converged(self) -> bool:
        """Whether the search has converged, so that further generations would not change the result."""


class Nsga2:
    """NSGA-II of pymoo with simulated binary crossover, polynomial mutation and Deb's feasibility rules.

    The first generation contains the start and a Latin hypercube sample.
    """

    def __init__(self, start: list[float], population: int, seed: int, objectives: int) -> None:
        nsga2, problem = require("pymoo.algorithms.moo.nsga2", "NSGA-II"), require("pymoo.core.problem", "NSGA-II")
        random, others, size = np.random.default_rng(seed), population - 1, len(start)
        slices = random.permuted(np.tile(np.arange(others), (size, 1)), axis=1).T
        sample = np.vstack([start, (slices + random.random((others, size))) / others])
        self._problem = problem.Problem(n_var=size, n_obj=objectives, n_ieq_constr=1, xl=0.0, xu=1.0)
        self._algorithm = nsga2.NSGA2(pop_size=population, sampling=sample)
        termination = require("pymoo.core.termination", "NSGA-II").NoTermination()
        self._algorithm.setup(self._problem, termination=termination, seed=seed, verbose=False)
        self._pending: Any = None

    def ask(self) -> Array:
        self._pending = self._algorithm.ask()
        return np.array(self._pending.get("X"), dtype=float)

    def tell(self, scores: Scores) -> None:
        from pymoo.core.evaluator import Evaluator
        from pymoo.problems.static import StaticProblem

        Evaluator().eval(StaticProblem(self._problem, F=scores.finite, G=scores.violation[:, None]), self._pending)
        self._algorithm.tell(infills=self._pending)

    def has_converged(self) -> bool:
        return False


class CmaEs:
    """CMA-ES of the package cma for one objective. The first generation contains the start only.

    The bounds are those of the unit cube. The strategy needs only a ranking, which follows Deb's feasibility rules.
    """

    def __init__(self, start: list[float], population: int, seed: int) -> None:
        cma = require("cma", "CMA-ES")
        random = np.random.default_rng(seed)
        options = {
            "bounds": [0.0, 1.0],
            "popsize": population,
            # Random numbers from one generator; nan leaves the global one of numpy alone.
            "seed": np.nan,
            "randn": lambda *shape: random.standard_normal(shape),
            "verbose": -9,
            "verb_log": 0,
        }
        self._start: Array = np.array([start])
        self._strategy = cma.CMAEvolutionStrategy(start, INITIAL_STEP_SIZE, options)
        self._pending: Array = np.zeros((0, len(start)))
        self._has_started = False

    def ask(self) -> Array:
        if not self._has_started:
            return self._start
        self._pending = np.array(self._strategy.ask())
        return np.clip(self._pending, 0.0, 1.0)

    def tell(self, scores: Scores) -> None:
        if not self._has_started:
            self._has_started = True
            return
        infeasible = ~scores.feasible
        order = np.lexsort((np.where(infeasible, scores.violation, scores.minimised[:, 0]), infeasible))
        ranks = np.empty(len(order))
        ranks[order] = np.arange(len(order))
        self._strategy.tell(list(self._pending), ranks.tolist())

    def has_converged(self) -> bool:
        return len(self._pending) > 0 and bool(np.max(np.std(self._pending, axis=0)) < CONVERGENCE_TOLERANCE)


def _new_search(optimisation: Optimisation) -> Search:
    method, start = optimisation.method, [variable.start_fraction for variable in optimisation.variables]
    if method.algorithm == "nsga2":
        return Nsga2(start, method.population, method.seed, len(optimisation.objectives))
    return CmaEs(start, method.population, method.seed)


@dataclass
class Found:
    """All designs of a search."""

    optimisation: Optimisation
    runs: ArrowTable
    """One row per run, ordered by design and condition, with the columns of `phalanx sweep`."""
    fields: list[dict[str, Any]]
    """For each design, the values of the variables by field, as written in a scene."""
    generation: Array
    """Generation of each design, from 0."""
    converged: bool
    """Whether the search ended by convergence."""
    new_runs: int
    """Number of runs in this call; the other runs were already stored."""
    simulations: int
    """Number of simulations in this call."""
    threads: int
    wall_s: float
    scores: Scores = field(init=False)
    front: list[int] = field(init=False)
    """Indices of the Pareto-optimal feasible designs, sorted by the first objective."""

    def __post_init__(self) -> None:
        self.scores = score(self.optimisation, self.runs)
        self.front = pareto_front(self.scores)

    def best(self, objective: int) -> int | None:
        """Returns the design of the front that is best for an objective."""
        return min(self.front, key=lambda index: float(self.scores.minimised[index, objective]), default=None)

    def compromise(self) -> int | None:
        """Returns the design of the front that is nearest to the best values of all objectives. Distances are relative
        to the extent of the front.

        None with a single objective, or with fewer than three designs on the front.
        """
        if len(self.optimisation.objectives) < 2 or len(self.front) < 3:
            return None
        values = self.scores.minimised[self.front]
        extent = np.ptp(values, axis=0)
        scaled = (values - values.min(axis=0)) / np.where(extent > 0.0, extent, 1.0)
        return self.front[int(np.argmin(np.sum(scaled**2, axis=1)))]

    def gains(self, index: int) -> list[float | None]:
        """Returns the improvement of each objective over the start, relative to the start; positive if better."""
        gains: list[float | None] = []
        for objective, first, value in zip(
            self.optimisation.objectives, self.scores.values[0], self.scores.values[index], strict=True
        ):
            gain = float((first - value) / abs(first)) if first != 0.0 else np.nan
            gains.append((gain if objective.goal == "min" else -gain) if np.isfinite(gain) else None)
        return gains

    def hypervolume(self) -> float | None:
        """Returns the hypervolume of the front, relative to that of the start alone.

        Objectives are gains over the start. The reference point has a gain of -1 in each objective. None for one
        objective, or if the start lacks a figure.
        """
        if len(self.optimisation.objectives) < 2 or any(gain is None for gain in self.gains(0)):
            return None
        points = -np.array([self.gains(index) for index in self.front], dtype=float).reshape(len(self.front), -1)
        indicator = require("pymoo.indicators.hv", "the hypervolume").HV(ref_point=np.ones(points.shape[1]))
        return float(indicator(points)) if len(points) else 0.0

    def point(self, index: int) -> dict[str, float]:
        """Returns the SI values of the variables of a design by column."""
        row = index * len(self.optimisation.conditions)
        return {variable.column: self.runs[variable.column][row].as_py() for variable in self.optimisation.variables}

    def designs(self) -> ArrowTable:
        """Returns one row per design.

        Columns: number, generation, variables, objectives, worst value of each constraint, numbers of runs by status,
        violation, whether the design is feasible, and whether it is on the front.
        """
        import pyarrow as pa

        scores, count, conditions = self.scores, len(self.generation), len(self.optimisation.conditions)
        columns: dict[str, Any] = {"design": np.arange(1, count + 1), "generation": self.generation}
        for variable in self.optimisation.variables:
            columns[variable.column] = self.runs[variable.column].take(np.arange(count) * conditions)
        for objective, values in zip(self.optimisation.objectives, scores.values.T, strict=True):
            columns[objective.name] = pa.array(values, from_pandas=True)
        for constraint, worst in zip(self.optimisation.constraints, scores.worst, strict=True):
            columns[f"worst_{constraint.column}"] = pa.array(worst, type=self.runs.schema.field(constraint.column).type)
        columns |= dict(zip(STATUSES, scores.by_status.T, strict=True))
        on_front = np.isin(np.arange(count), self.front)
        return pa.table({**columns, "violation": scores.violation, "feasible": scores.feasible, "front": on_front})


Progress: TypeAlias = Callable[[int, int, int, int], None]
"""Function that is called after each generation with the number of designs, the largest number of designs, the
generation, and the number of feasible designs.
"""


def run(optimisation: Optimisation, threads: int, checkpoint: Checkpoint | None, progress: Progress | None) -> Found:
    """Runs the search. Generations in the checkpoint are not simulated again, and new ones are appended to it."""
    import pyarrow as pa

    start, search = time.monotonic(), _new_search(optimisation)
    stored = iter(checkpoint.tables if checkpoint else [])
    tables: list[ArrowTable] = []
    designs: list[dict[str, Any]] = []
    generations: list[int] = []
    new_runs = simulations = feasible = generation = 0
    last = optimisation.method.generations + int(optimisation.method.algorithm == "cma-es")
    while generation < last and not search.has_converged():
        candidates = search.ask()
        designs += [
            {
                variable.path: variable.value_at(float(x))
                for variable, x in zip(optimisation.variables, row, strict=True)
            }
            for row in candidates
        ]
        table = next(stored, None)
        if table is None:
            table = simulate(optimisation, designs[len(generations) :], len(generations), threads)
            if checkpoint:
                checkpoint.append(table)
            new_runs += len(table)
            simulations += sum(status in ("completed", "failed") for status in table["status"].to_pylist())
        elif not _matches(optimisation, candidates, table):
            raise StudyError(
                f"error: the stored generation {generation} has other designs than this search\n"
                "  = help: the versions of pymoo, cma or numpy differ; install the earlier ones, or discard the "
                "results with --restart (restart=True)"
            )
        scores = score(optimisation, table)
        search.tell(scores)
        tables.append(table)
        generations += [generation] * len(candidates)
        feasible += int(np.sum(scores.feasible))
        if progress:
            progress(len(generations), optimisation.max_designs, generation, feasible)
        generation += 1
    return Found(
        optimisation,
        pa.concat_tables(tables),
        designs,
        np.array(generations),
        search.has_converged(),
        new_runs,
        simulations,
        threads or os.cpu_count() or 1,
        time.monotonic() - start,
    )


def simulate(optimisation: Optimisation, designs: list[dict[str, Any]], previous: int, threads: int) -> ArrowTable:
    """Simulates designs under all conditions; runs and designs are numbered throughout the search."""
    import pyarrow as pa

    conditions = optimisation.conditions
    rows = [{**design, **condition} for design in designs for condition in conditions]
    fields: dict[str, Any] = {path: [row[path] for row in rows] for path in rows[0]}
    results = _phalanx.evaluate(
        optimisation.scene, fields, model=optimisation.model, preset=optimisation.preset, threads=threads,
        filter=optimisation.filter or None,
    )
    table = pa.table(results)
    runs = np.arange(len(table)) + previous * len(conditions)
    return table.set_column(0, "run", pa.array(runs + 1)).set_column(1, "design", pa.array(runs // len(conditions) + 1))


def _matches(optimisation: Optimisation, candidates: Array, table: ArrowTable) -> bool:
    """Whether stored runs are those of the candidates."""
    conditions = len(optimisation.conditions)
    if len(table) != len(candidates) * conditions:
        return False
    for variable, fractions in zip(optimisation.variables, candidates.T, strict=True):
        expected = [variable.si_at(float(x)) for x in fractions]
        actual = table[variable.column].to_numpy(zero_copy_only=False)[::conditions]
        if not np.allclose(actual, expected, rtol=1e-9, atol=0.0):
            return False
    return True


def fingerprint(optimisation: Optimisation) -> str:
    """Returns a digest that differs between searches with different results."""
    content = {key: value for key, value in optimisation.source.items() if key not in ("name", "description", "scene")}
    parts = [
        _phalanx.__version__,
        optimisation.model,
        *([optimisation.preset] if optimisation.preset else []),
        optimisation.scene.resolved,
        json.dumps(content, sort_keys=True, default=str),
    ]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


class Checkpoint:
    """The runs of a search on disk, as an Arrow stream to which each generation is appended as one batch.

    A kill during a write leaves an incomplete batch, which the next search removes.
    """

    def __init__(self, path: Path, fingerprint: str) -> None:
        import pyarrow as pa

        self.path, self._fingerprint = path, fingerprint
        self.tables: list[ArrowTable] = []
        self._file = path.open("a+b")
        self._lock()
        self._file.seek(0)
        end = 0
        try:
            with pa.ipc.open_stream(pa.PythonFile(self._file, mode="r")) as reader:
                require_same_search(reader.schema.metadata, path, fingerprint)
                end = self._file.tell()
                for batch in reader:
                    self.tables.append(pa.Table.from_batches([batch]))
                    end = self._file.tell()
        except (pa.ArrowInvalid, OSError):
            pass
        self._file.truncate(end)

    def _lock(self) -> None:
        """Prevents two searches from writing the same file, where the system supports locks."""
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            message = f"error: another search is writing {self.path}\n  = help: wait for it, or choose another output"
            raise StudyError(message) from None

    def append(self, table: ArrowTable) -> None:
        """Appends the runs of a generation, and waits until they are on the disk."""
        batch = table.replace_schema_metadata({"phalanx.optimize": self._fingerprint}).combine_chunks().to_batches()[0]
        if self._file.seek(0, os.SEEK_END) == 0:
            self._file.write(batch.schema.serialize())
        self._file.write(batch.serialize())
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Closes the file; an empty one is deleted."""
        is_empty = self._file.seek(0, os.SEEK_END) == 0
        self._file.close()
        if is_empty:
            self.path.unlink(missing_ok=True)


def open_checkpoint(path: Path, runs: Path, fingerprint: str) -> Checkpoint:
    """Opens the checkpoint of a search. If the Parquet file `runs` contains finished results, they replace its
    generations.
    """
    finished = None
    if runs.exists() and not path.exists():
        import pyarrow.parquet

        finished = pyarrow.parquet.read_table(runs)
        require_same_search(finished.schema.metadata, runs, fingerprint)
    checkpoint = Checkpoint(path, fingerprint)
    if finished is not None:
        counts = np.unique(finished["generation"].to_numpy(), return_index=True, return_counts=True)
        finished = finished.drop_columns("generation")
        checkpoint.tables = [finished.slice(int(first), int(count)) for _, first, count in zip(*counts, strict=True)]
    return checkpoint


def require_same_search(metadata: dict[bytes, bytes] | None, path: Path, fingerprint: str) -> None:
    """Raises an error if stored results belong to another search."""
    if (metadata or {}).get(b"phalanx.optimize") != fingerprint.encode():
        raise StudyError(
            f"error: {path} contains the runs of another study, scene, model or version\n"
            "  = help: choose another output, or discard these results with --restart (restart=True)"
        )
