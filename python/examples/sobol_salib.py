"""Sobol indices (SALib) of time to stability and peak force for the eight variables of a finger.

The variables are the four of the thesis' grid within its ranges, and four that are constant there: length of the driven
link, height of the gripper beside its object, smallest contact angle of the tip, and half the width of a phalanx.
Spring and motor are sized separately for each design.

A design that does not become stable has no time to stability; the duration of the run (20 ms), a lower bound, is used
instead. The number of such designs is printed, together with the Sobol indices of whether a design is stable. The
ranges are chosen so that all scenes are valid; if a scene is refused or a run fails, the script ends with the reason.

    python sobol_salib.py [--out sobol.csv] [--n 512]
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path
from typing import Any

import numpy as np
import phalanx
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sample

from grid import DURATION_S, VARIABLES, load_scene

RANGES = {
    **VARIABLES,
    "design.l11": (13.5e-3, 16.5e-3),
    "design.height_ratio": (0.92, 0.96),
    "design.tip_contact_min": (np.radians(3), np.radians(7)),
    "half_width": (2.0e-3, 3.0e-3),
}


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("sobol.csv"))
    parser.add_argument("--n", type=int, default=512, help="base points, a power of 2; ten times as many runs")
    parser.add_argument("--quick", action="store_true", help="few points, for tests only: the indices are inaccurate")
    args = parser.parse_args(arguments)
    count = 16 if args.quick else args.n

    problem = {"num_vars": len(RANGES), "names": list(RANGES), "bounds": [list(bounds) for bounds in RANGES.values()]}
    points = sample.sample(problem, count, calc_second_order=False, seed=1)
    start = time.perf_counter()
    columns = ["status", "reason", "tts_s", "peak_f21_n", "peak_f22_n"]
    results = phalanx.evaluate(load_scene(), dict(zip(RANGES, points.T, strict=True)), columns=columns)
    wall_s = time.perf_counter() - start
    failed = [reason for status, reason in zip(results["status"], results["reason"], strict=True) if status != "completed"]
    if failed:
        raise SystemExit(f"{len(failed)} of {len(points)} designs have no results; reason of the first one: {failed[0]}")
    unstable = np.isnan(results["tts_s"])
    figures = {
        "tts_s": np.where(unstable, DURATION_S, results["tts_s"]),
        "peak_n": np.fmax(results["peak_f21_n"], results["peak_f22_n"]),
        "is stable": (~unstable).astype(float),
    }
    rows: list[list[Any]] = []
    for name, values in figures.items():
        indices = analysis.analyze(problem, values, calc_second_order=False, seed=1)
        for index, variable in enumerate(RANGES):
            rows.append([name, variable, *(float(indices[key][index]) for key in ("S1", "S1_conf", "ST", "ST_conf"))])
    with args.out.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["figure", "variable", "first_order", "first_order_95", "total", "total_95"])
        writer.writerows(rows)
    print(f"{args.out}: {len(points)} runs in {wall_s:.1f} s; {unstable.sum()} never stable, counted as {1e3 * DURATION_S:.0f} ms")
    for figure, variable, first, first_95, total, total_95 in rows:
        print(f"{figure:10} {variable:24} first {first:6.3f} ± {first_95:.3f}   total {total:6.3f} ± {total_95:.3f}")


if __name__ == "__main__":
    main()
