#!/usr/bin/env python3
"""Counts the instructions of `run --no-check` for every shipped scene with two builds of phalanx, under valgrind.

    tools/scene_instructions.py BEFORE AFTER [--jobs N] [--preset NAME]

Prints a table of the scenes whose counts differ by more than 3 %, with the steps of both builds, and one row for the others. A
scene that takes more than two minutes under valgrind is named and left out. Needs valgrind.
"""

import argparse
import json
import re
import statistics
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TIME_LIMIT_S = 120
# Relative difference that is listed.
LISTED = 0.03


def count(program, scene, flags):
    """Instructions of a run, or None if it takes too long."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, "run", str(scene), "--no-check", "--quiet", *flags]
    try:
        output = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return None
    return int(re.search(r"Collected : (\d+)", output.stderr)[1])


def steps(program, scene, flags):
    command = [program, "run", str(scene), "--no-check", "--quiet", "--json", *flags]
    return json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout)["steps"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--preset", action="append", default=[])
    arguments = parser.parse_args()
    flags = [flag for preset in arguments.preset for flag in ("--preset", preset)]
    programs = [str(Path(program).resolve()) for program in (arguments.before, arguments.after)]
    scenes = sorted(path for path in (ROOT / "scenes").rglob("*.toml") if "studies" not in path.parts)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        counts = [list(pool.map(lambda scene: count(program, scene, flags), scenes)) for program in programs]
    rows, ratios, slow = [], [], []
    for scene, before, after in zip(scenes, *counts):
        name = scene.relative_to(ROOT / "scenes").with_suffix("")
        if before is None or after is None:
            slow.append(str(name))
            continue
        ratios.append(after / before)
        if abs(ratios[-1] - 1) > LISTED:
            taken = [steps(program, scene, flags) for program in programs]
            rows.append((ratios[-1], f"| `{name}` | {taken[0]} | {taken[1]} | {before / 1e6:.1f} | {after / 1e6:.1f} | {ratios[-1]:.2f} |"))
    print("| scene | steps before | after | M instructions before | after | ratio |\n|---|---|---|---|---|---|")
    print("\n".join(row for _, row in sorted(rows)))
    others = [ratio for ratio in ratios if abs(ratio - 1) <= LISTED]
    print(f"| {len(others)} others | | | | | {min(others):.2f} to {max(others):.2f} |")
    print(f"\nMedian ratio of {len(ratios)} scenes: {statistics.median(ratios):.3f}; too slow to count: {', '.join(slow) or 'none'}.")


if __name__ == "__main__":
    main()
