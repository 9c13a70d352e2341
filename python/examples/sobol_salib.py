"""Sobol's indices (SALib) of time to stability and peak force for the eight variables that make a finger: which of them matter.

The four of the thesis' grid within its ends, and four that it keeps: length of the driven link, height of the gripper beside its
object, least contact angle of the tip, half the width of a phalanx. Spring and motor are sized for each design on its own.

A design that is never stable within its run has no time to stability. It counts as one that takes the whole run (20 ms): the least
that can be said of it, and what it is like in use. How many there are is printed, and Sobol's indices of whether a design is stable
at all stand beside the others. A design whose scene is refused has no figures of any kind; the ranges are such that there is none,
and if there is one after all this ends with its reason instead of making a number up.

    python sobol_salib.py [--out sobol.csv] [--n 512]
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import phalanx
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sample

from grid import DURATION_S, VARIABLES, scene

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
    parser.add_argument("--quick", action="store_true", help="few points: the indices are of no use")
    args = parser.parse_args(arguments)
    count = 16 if args.quick else args.n

    problem = {"num_vars": len(RANGES), "names": list(RANGES), "bounds": [list(ends) for ends in RANGES.values()]}
    points = sample.sample(problem, count, calc_second_order=False, seed=1)
    start = time.perf_counter()
    columns = ["status", "reason", "tts_s", "peak_f21_n", "peak_f22_n"]
    found = phalanx.evaluate(scene(), dict(zip(RANGES, points.T, strict=True)), columns=columns)
    wall_s = time.perf_counter() - start
    failed = [reason for status, reason in zip(found["status"], found["reason"], strict=True) if status != "completed"]
    if failed:
        raise SystemExit(f"{len(failed)} of {len(points)} designs have no figures, the first one for: {failed[0]}")
    unstable = np.isnan(found["tts_s"])
    figures = {
        "tts_s": np.where(unstable, DURATION_S, found["tts_s"]),
        "peak_n": np.fmax(found["peak_f21_n"], found["peak_f22_n"]),
        "is stable": (~unstable).astype(float),
    }
    rows = []
    for name, values in figures.items():
        indices = analysis.analyze(problem, values, calc_second_order=False, seed=1)
        for at, variable in enumerate(RANGES):
            of = [float(indices[key][at]) for key in ("S1", "S1_conf", "ST", "ST_conf")]
            rows.append([name, variable, *of])
    with args.out.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["figure", "variable", "first_order", "first_order_95", "total", "total_95"])
        table.writerows(rows)
    print(f"{args.out}: {len(points)} runs in {wall_s:.1f} s; {unstable.sum()} never stable, counted as {1e3 * DURATION_S:.0f} ms")
    for name, variable, first, first_95, total, total_95 in rows:
        print(f"{name:10} {variable:24} first {first:6.3f} ± {first_95:.3f}   total {total:6.3f} ± {total_95:.3f}")


if __name__ == "__main__":
    main()
