"""Studies of an optimisation, as `phalanx` reads them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from .. import _phalanx

CLASSES = ["stable", "semi-stable", "semi-unstable", "unstable"]
"""Classes of a closing, from good to bad."""


@dataclass(frozen=True)
class Objective:
    """A figure that is minimised or maximised."""

    name: str
    columns: list[str]
    of: Literal["largest", "smallest", "sum"]
    """Aggregation of the columns."""
    goal: Literal["min", "max"]
    over: Literal["worst", "mean"]
    """Aggregation over the conditions."""


@dataclass(frozen=True)
class Constraint:
    """A requirement that must be met under every condition. Bounds are numbers in SI."""

    column: str
    at_least: float | None = None
    at_most: float | None = None
    equals: bool | str | None = None
    worst_class: int | None = None
    """Index of the worst allowed class, in the order of CLASSES."""


@dataclass(frozen=True)
class Method:
    """Parameters of the search."""

    algorithm: Literal["nsga2", "cma-es"]
    population: int
    generations: int
    seed: int

    @property
    def name(self) -> str:
        """Name in reports."""
        return {"nsga2": "NSGA-II", "cma-es": "CMA-ES"}[self.algorithm]


@dataclass
class Optimisation:
    """A validated optimisation."""

    name: str
    description: str
    model: Literal["analytic", "engine"]
    preset: Literal["draft", "engineering", "reference"] | None
    """Preset that replaces the integrator settings of the scene; None without a preset."""
    scene: _phalanx.Scene
    files: list[Path]
    """The study file, and the files of the base scene."""
    variables: list[_phalanx.Variable]
    conditions: list[dict[str, Any]]
    """For each condition, the values of its fields; one empty condition if there are none."""
    objectives: list[Objective]
    constraints: list[Constraint]
    method: Method
    verdict: str | None
    """Name of the column with the verdict of a run: "class", "grasp" or "fate"; None for scenes without a grasp."""
    source: dict[str, Any] = field(repr=False)
    """Keys of the study file without its base scene."""

    @property
    def filter(self) -> dict[str, bool]:
        """Static criteria for the designs that are simulated."""
        return dict(self.source.get("filter", {}))

    @property
    def max_designs(self) -> int:
        """Largest number of designs; CMA-ES evaluates the start as a separate generation."""
        return int(self.method.algorithm == "cma-es") + self.method.population * self.method.generations

    @property
    def max_runs(self) -> int:
        """Largest number of runs."""
        return self.max_designs * len(self.conditions)


def load(path: Path, model: str | None = None, preset: str | None = None, text: str | None = None) -> Optimisation:
    """Reads and checks a study file and its base scene.

    `model` overrides the model of the study. `preset` replaces the integrator settings of the scene.

    `text` is the content of the file; by default, the file is read. With `text`, `path` only appears in messages and
    determines the directory to which the base scene is relative. Raises StudyError with file, line and field of the
    errors.
    """
    read = _phalanx._read_optimisation(path, text, model, preset)
    lists: dict[str, Any] = {
        "objectives": [Objective(**objective) for objective in read["objectives"]],
        "constraints": [Constraint(**constraint) for constraint in read["constraints"]],
    }
    return Optimisation(**{**read, **lists, "method": Method(**read["method"])})
