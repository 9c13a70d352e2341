"""CMA-ES (package cma) over the four variables: minimises the time to stability under the thesis' criteria.

    python cma_es.py [--out cma.png] [--generations 60]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cma
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from grid import DESIGN_95, LOWER, UPPER, evaluate_designs, load_scene

# Cost of one violated criterion, ms: longer than a run.
PENALTY_MS = 100.0


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("cma.png"))
    parser.add_argument("--generations", type=int, default=60)
    parser.add_argument("--quick", action="store_true", help="a few generations")
    args = parser.parse_args(arguments)
    if args.quick:
        args.generations = 4

    base, start = load_scene(), time.perf_counter()
    # All variables are scaled to [0, 1], because CMA-ES uses the same step size for all.
    initial = (DESIGN_95 - LOWER) / (UPPER - LOWER)
    options = {"bounds": [0, 1], "seed": 1, "maxiter": args.generations, "popsize": 16, "verbose": -9}
    search = cma.CMAEvolutionStrategy(np.clip(initial, 0.05, 0.95), 0.25, options)
    best: list[float] = []
    runs = 0
    while not search.stop():
        candidates = search.ask()
        results = evaluate_designs(base, LOWER + np.array(candidates) * (UPPER - LOWER))
        costs = 1e3 * results["tts_s"] + PENALTY_MS * results["violation"]
        search.tell(candidates, costs.tolist())
        runs += len(candidates)
        best.append(float(search.best.f))
    wall_s = time.perf_counter() - start
    design = LOWER + search.best.x * (UPPER - LOWER)
    [final, design_95] = [evaluate_designs(base, values) for values in (design, DESIGN_95)]

    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    axes.plot(np.arange(1, len(best) + 1), best, label="best so far")
    axes.axhline(1e3 * design_95["tts_s"][0], color="0.5", linestyle="--", label="design 95")
    axes.set_xlabel("generation")
    axes.set_ylabel("time to stability, ms (with penalties)")
    axes.legend(frameon=False)
    figure.savefig(args.out, dpi=120)
    values = f"base {1e3 * design[0]:.3f} mm, l21 {design[1]:.3f}, phi22 {np.degrees(design[2]):.2f} deg, r_l {design[3]:.3f}"
    print(f"{args.out}: {1e3 * final['tts_s'][0]:.4f} ms at {values}, criteria {'met' if final['violation'][0] == 0 else 'violated'}")
    print(f"design 95: {1e3 * design_95['tts_s'][0]:.4f} ms; {runs} runs in {wall_s:.1f} s")


if __name__ == "__main__":
    main()
