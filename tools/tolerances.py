#!/usr/bin/env python3
"""Measures errors and times of settings of the integrator on random mechanisms, with which the presets were chosen.

    tools/tolerances.py [--scenes N] [--first SEED] [--json FILE] [SETTING ...]

A setting is a text of flags of `phalanx run`, such as "--rtol 1e-5" or "--preset draft"; the default settings of the scene are "".
The scenes are those of tools/random_grippers.py. The error of a run is the largest difference of an angle (rad) or of a position
(parts of 20 mm) of a body from `--preset reference`, over samples every millisecond and at the end. A scene counts if the check of its
run with default settings is `sure`; the others, which a check names, are counted. Needs a build of phalanx ($PHALANX names another
program than target/release/phalanx).
"""

import argparse
import csv
import json
import math
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import random_grippers

SETTINGS = ["", "--preset draft"]
POSITION_UNIT_M = random_grippers.UNIT_M
QUANTILES = (0.5, 0.9, 0.99, 1.0)


def table(path, *flags):
    """Angles and positions of all bodies by time, and the document of the run; None if it is not completed."""
    samples_file = path.with_suffix(".csv")
    samples_file.unlink(missing_ok=True)
    result = random_grippers.run(path, "--no-check", "--numeric-rate", "1 kHz", "--csv", str(samples_file), *flags)
    if random_grippers.failure(result):
        return None
    with samples_file.open(newline="") as file:
        header, *rows = csv.reader(file)
    scales = {k: 1 / POSITION_UNIT_M if name.endswith("_m") else 1 for k, name in enumerate(header) if is_pose(name)}
    return {row[0]: [float(row[k]) * scale for k, scale in scales.items()] for row in rows}, result["document"]


def is_pose(name):
    """Whether a column is an angle or a coordinate of a body or a joint."""
    return name.endswith(("_x_m", "_y_m", "_angle_rad")) or (name.startswith("q") and name.endswith("_rad"))


def error(found, exact):
    """Largest difference at the times of both runs. Both have the end."""
    times = found.keys() & exact.keys()
    return max(abs(a - b) for time in times for a, b in zip(found[time], exact[time], strict=True))


def measure(seed, settings, directory):
    """Record of a scene: the verdict of its check, and error, steps, time and fate of each setting."""
    family, scene = random_grippers.random_scene(seed)
    path = directory / f"random-{seed}.toml"
    path.write_text(random_grippers.scene_text(scene), encoding="utf-8")
    checked = random_grippers.run(path)
    record = {"seed": seed, "family": family, "verdict": random_grippers.failure(checked), "settings": {}}
    if record["verdict"]:
        return record
    record["verdict"] = random_grippers.verdict(checked["document"])
    reference = table(path, "--preset", "reference")
    if reference is None:
        record["verdict"] = "no reference"
        return record
    record["fate"] = (reference[1].get("grasp") or {}).get("fate")
    for setting in settings:
        result = table(path, *setting.split())
        if result is None:
            record["settings"][setting] = None
            continue
        samples, document = result
        record["settings"][setting] = {
            "error": error(samples, reference[0]),
            "steps": document["steps"],
            "wall_s": document["wall_s"],
            "fate": (document.get("grasp") or {}).get("fate"),
        }
    return record


def print_table(records, settings):
    sure = [record for record in records if record["verdict"] == "sure"]
    others = [record["verdict"] for record in records if record["verdict"] != "sure"]
    counts = ", ".join(f"{others.count(verdict)} {verdict}" for verdict in sorted(set(others)))
    print(f"{len(records)} scenes: {len(sure)} sure, {counts}\n")
    print("| setting | not completed | error: median | 90 % | 99 % | largest | other fates | steps | time (s) |\n" + "|---" * 9 + "|")
    for setting in settings:
        runs = [(record, record["settings"][setting]) for record in sure]
        done = [(record, run) for record, run in runs if run]
        errors = sorted(run["error"] for _, run in done)
        values = [errors[min(len(errors) - 1, math.ceil(part * len(errors)) - 1)] for part in QUANTILES]
        graspable = [(record, run) for record, run in done if record["fate"]]
        fates = sum(record["fate"] != run["fate"] for record, run in graspable)
        cells = [setting or "default", len(runs) - len(done), *(f"{value:.1e}" for value in values), f"{fates} of {len(graspable)}"]
        cells += [sum(run["steps"] for _, run in done), f"{sum(run['wall_s'] for _, run in done):.2f}"]
        print(f"| {' | '.join(map(str, cells))} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("settings", nargs="*", metavar="SETTING", help="flags of `phalanx run`; default: none, and `--preset draft`")
    parser.add_argument("--scenes", type=int, default=500, help="number of scenes (default: 500)")
    parser.add_argument("--first", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time (default: 2)")
    parser.add_argument("--json", type=Path, help="file for the figures of every seed, one a line")
    arguments = parser.parse_args()
    settings = arguments.settings or SETTINGS
    records = []
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(arguments.jobs) as pool:
        seeds = range(arguments.first, arguments.first + arguments.scenes)
        for record in pool.map(lambda seed: measure(seed, settings, Path(temporary)), seeds):
            records.append(record)
            print(record["seed"], record["family"], record["verdict"], file=sys.stderr, flush=True)
            if arguments.json:
                with arguments.json.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(record) + "\n")
    print_table(records, settings)


if __name__ == "__main__":
    main()
