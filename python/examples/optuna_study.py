"""Optuna's TPE sampler over the four variables, with batches of trials that are evaluated together.

    python optuna_study.py [--out optuna.png] [--trials 400]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import optuna

from grid import DESIGN_95, VARIABLES, evaluate_designs, load_scene

# Trials per evaluation.
BATCH_SIZE = 20
# Cost of one violated criterion, ms.
PENALTY_MS = 100.0


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("optuna.png"))
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--quick", action="store_true", help="a few trials")
    args = parser.parse_args(arguments)
    if args.quick:
        args.trials = 40

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    base, start = load_scene(), time.perf_counter()
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=1, multivariate=True, constant_liar=True))
    distributions = {path: optuna.distributions.FloatDistribution(low, high) for path, (low, high) in VARIABLES.items()}
    # The first trial is design 95, for comparison.
    study.enqueue_trial(dict(zip(VARIABLES, DESIGN_95.tolist(), strict=True)))
    while len(study.trials) < args.trials:
        trials = [study.ask(distributions) for _ in range(min(BATCH_SIZE, args.trials - len(study.trials)))]
        results = evaluate_designs(base, np.array([[trial.params[path] for path in VARIABLES] for trial in trials]))
        for trial, cost in zip(trials, 1e3 * results["tts_s"] + PENALTY_MS * results["violation"], strict=True):
            study.tell(trial, float(cost))
    wall_s = time.perf_counter() - start

    values = np.array([trial.value for trial in study.trials])
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    met = values < PENALTY_MS / 10
    axes.plot(np.flatnonzero(met), values[met], ".", color="0.7", label="trials that meet the criteria")
    axes.plot(np.minimum.accumulate(values), label="best so far")
    axes.set_ylim(values.min() - 0.05, values[0] + 0.5)
    axes.set_xlabel("trial")
    axes.set_ylabel("time to stability, ms")
    axes.legend(frameon=False)
    figure.savefig(args.out, dpi=120)
    best = ", ".join(f"{path.removeprefix('design.')} {value:.5g}" for path, value in study.best_params.items())
    print(f"{args.out}: {study.best_value:.4f} ms at {best}; design 95: {values[0]:.4f} ms; {len(values)} runs in {wall_s:.1f} s")


if __name__ == "__main__":
    main()
