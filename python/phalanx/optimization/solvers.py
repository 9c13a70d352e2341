"""Optimisations for other solvers: a plain function, and a problem of pymoo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..errors import StudyError
from .search import Array, Scores, require, score, simulate
from .study import Optimisation

Design: TypeAlias = Mapping[str, str | float] | Sequence[float] | Array
"""Values of the variables, in SI or as in a scene: either by field, or in the order of the study."""


class Function:
    """Maps a design to its objectives and constraint violations; see `phalanx.optimization.function`."""

    def __init__(self, optimisation: Optimisation, threads: int = 0) -> None:
        self._optimisation, self._threads = optimisation, threads
        variables = optimisation.variables
        self.variables = [variable.path for variable in variables]
        """Fields of the variables."""
        self.bounds: list[tuple[float, float]] = [(min(v.ends_si), max(v.ends_si)) for v in variables]
        """Smallest and largest value of each variable in SI."""
        self.start: Array = np.array([variable.si_at(variable.start_fraction) for variable in variables])
        """Start value of each variable in SI."""
        self.objectives = [objective.name for objective in optimisation.objectives]
        self.constraints = ["results", *(constraint.column for constraint in optimisation.constraints)]
        """Names of the violations: missing results, then the columns of the constraints."""

    def __call__(self, design: Design) -> tuple[Array, Array]:
        """Simulates a design. Returns its objectives, all to be minimised, and its violations, which are 0 if a
        constraint is met.
        """
        scores = self.scores([design])
        return scores.minimised[0], scores.violations[0]

    def scores(self, designs: Sequence[Design]) -> Scores:
        """Simulates several designs together, on all threads."""
        rows = [self._fields(design) for design in designs]
        return score(self._optimisation, simulate(self._optimisation, rows, 0, self._threads))

    def _fields(self, design: Design) -> dict[str, str | float]:
        """Returns the value of each variable; those that a mapping lacks have their start value."""
        help = f"the variables are {', '.join(self.variables)}"
        if not isinstance(design, Mapping):
            if len(design) != len(self.variables):
                message = f"a design has {len(design)} values, but the study has {len(self.variables)} variables"
                raise StudyError(f"error: {message}\n  = help: {help}")
            return dict(zip(self.variables, map(float, design), strict=True))
        for name in design:
            if name not in self.variables:
                raise StudyError(f"error: `{name}` is not a variable of the study\n  = help: {help}")
        start = {v.path: v.value_at(v.start_fraction) for v in self._optimisation.variables}
        return {**start, **design}


def problem(optimisation: Optimisation, threads: int = 0) -> Any:
    """Returns a problem of pymoo; see `phalanx.optimization.problem`."""
    base: Any = require("pymoo.core.problem", "a problem of pymoo").Problem
    function = Function(optimisation, threads)
    low, high = np.array(function.bounds).T
    is_log = np.array([variable.is_log for variable in optimisation.variables])

    def evaluate(_: Any, x: Array, out: dict[str, Any], *__: Any, **___: Any) -> None:
        designs = x.astype(float)
        designs[:, is_log] = 10.0 ** designs[:, is_log]
        scores = function.scores(list(np.clip(designs, low, high)))
        out["F"], out["G"] = scores.finite, scores.violations

    def scaled(values: Array) -> Array:
        return np.array([np.log10(value) if log else value for value, log in zip(values, is_log, strict=True)])

    counts = {"n_var": len(low), "n_obj": len(function.objectives), "n_ieq_constr": len(function.constraints)}
    # Its base class is only imported here.
    return type("Problem", (base,), {"_evaluate": evaluate})(**counts, xl=scaled(low), xu=scaled(high))
