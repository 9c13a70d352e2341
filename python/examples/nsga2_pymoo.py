"""pymoo's NSGA-II over the four variables of the thesis' grid: time to stability against peak force.

    python nsga2_pymoo.py [--out front.png] [--population 64] [--generations 40]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem
from pymoo.optimize import minimize

from grid import DESIGN_95, LOWER, UPPER, evaluate_designs, load_scene


class Closing(Problem):
    """Minimises time to stability and peak force under the criteria of the thesis."""

    def __init__(self) -> None:
        super().__init__(n_var=len(LOWER), n_obj=2, n_ieq_constr=1, xl=LOWER, xu=UPPER)
        self.scene, self.runs = load_scene(), 0

    def _evaluate(self, x: np.ndarray, out: dict, *_: object, **__: object) -> None:
        results = evaluate_designs(self.scene, x)
        self.runs += len(x)
        out["F"] = np.column_stack([1e3 * results["tts_s"], results["peak_n"]])
        out["G"] = results["violation"]


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("front.png"))
    parser.add_argument("--population", type=int, default=64)
    parser.add_argument("--generations", type=int, default=40)
    parser.add_argument("--quick", action="store_true", help="a few generations")
    args = parser.parse_args(arguments)
    if args.quick:
        args.population, args.generations = 16, 3

    problem, start = Closing(), time.perf_counter()
    result = minimize(problem, NSGA2(pop_size=args.population), ("n_gen", args.generations), seed=1)
    wall_s = time.perf_counter() - start
    if result.F is None:
        raise SystemExit("no design meets the criteria; use more generations")
    front = np.atleast_2d(result.F)[np.argsort(np.atleast_2d(result.F)[:, 0])]
    design_95 = evaluate_designs(problem.scene, DESIGN_95)

    figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
    axes.plot(front[:, 0], front[:, 1], "o-", label=f"Pareto front, {len(front)} designs")
    axes.plot(1e3 * design_95["tts_s"], design_95["peak_n"], "k*", markersize=14, label="design 95")
    axes.set_xlabel("time to stability, ms")
    axes.set_ylabel("peak force, N")
    axes.legend(frameon=False)
    axes.set_title(f"{problem.runs} runs in {wall_s:.1f} s")
    figure.savefig(args.out, dpi=120)
    print(f"{args.out}: {len(front)} designs from {front[0, 0]:.3f} ms, {front[0, 1]:.1f} N to {front[-1, 0]:.3f} ms, {front[-1, 1]:.1f} N")
    print(f"design 95: {1e3 * design_95['tts_s'][0]:.3f} ms, {design_95['peak_n'][0]:.1f} N; {problem.runs} runs in {wall_s:.1f} s")


if __name__ == "__main__":
    main()
