#!/usr/bin/env python3
"""Measures errors and times of settings of the integrator on random mechanisms, with which the presets were chosen.

    tools/tolerances.py [--family NAMES] [--scenes N] [--first SEED] [--json FILE] [SETTING ...]

A setting is a text of flags of `phalanx run`, such as "--rtol 1e-5" or "--preset draft"; the default settings of the scene are "".
The scenes are those of the example `campaign`. The error of a run is the largest difference of an angle (rad) or of a position
(parts of 20 mm) of a body from `--preset reference`, over samples every millisecond and at the end. A scene counts if the check of its
run with default settings is `sure`; the others, which a check names, are counted. A run of more than a minute is killed. Needs
`cargo build --release --bin phalanx --example campaign` ($PHALANX and $PHALANX_CAMPAIGN name other programs).
"""

import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

RELEASE = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).resolve().parent.parent / "target")) / "release"
PHALANX = os.environ.get("PHALANX", str(RELEASE / "phalanx"))
CAMPAIGN = os.environ.get("PHALANX_CAMPAIGN", str(RELEASE / "examples" / "campaign"))
TIME_LIMIT_S = 60.0
FAMILIES = "objects,jaws,tendons,linkages,sliders,thrown"
SETTINGS = ["", "--preset draft"]
POSITION_UNIT_M = 0.02
QUANTILES = (0.5, 0.9, 0.99, 1.0)


def run(scene, *options):
    """The JSON document of a run, and why there is no complete result: `killed`, `refused` or `ended early`."""
    command = [PHALANX, "run", str(scene), "--json", "--quiet", *options]
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return None, "killed"
    if result.returncode not in (0, 2, 3):
        raise RuntimeError(f"{scene}: {result.stderr}")
    document = json.loads(result.stdout) if result.stdout.startswith("{") else None
    if result.returncode == 2:
        return None, "refused"
    return document, None if result.returncode == 0 and document["completed"] else "ended early"


def table(path, *flags):
    """Angles and positions of all bodies by time, and the document of the run; None if it is not completed."""
    samples_file = path.with_suffix(".csv")
    samples_file.unlink(missing_ok=True)
    document, failure = run(path, "--no-check", "--numeric-rate", "1 kHz", "--csv", str(samples_file), *flags)
    if failure:
        return None
    with samples_file.open(newline="") as file:
        header, *rows = csv.reader(file)
    scales = {k: 1 / POSITION_UNIT_M if name.endswith("_m") else 1 for k, name in enumerate(header) if is_pose(name)}
    return {row[0]: [float(row[k]) * scale for k, scale in scales.items()] for row in rows}, document


def is_pose(name):
    """Whether a column is an angle or a coordinate of a body or a joint."""
    return name.endswith(("_x_m", "_y_m", "_angle_rad")) or (name.startswith("q") and name.endswith("_rad"))


def error(found, exact):
    """Largest difference at the times of both runs. Both have the end."""
    times = found.keys() & exact.keys()
    return max(abs(a - b) for time in times for a, b in zip(found[time], exact[time], strict=True))


def measure(path, settings):
    """Record of a scene: the verdict of its check, and error, steps, time and fate of each setting."""
    document, failure = run(path)
    record = {"scene": path.stem, "verdict": failure, "settings": {}}
    if failure:
        return record
    # A run of more than 20,000 steps is not checked.
    record["verdict"] = (document["check"] or {"verdict": "not checked"})["verdict"]
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
    parser.add_argument("--family", default=FAMILIES, help=f"families of scenes (default: {FAMILIES})")
    parser.add_argument("--scenes", type=int, default=80, help="number of scenes per family (default: 80)")
    parser.add_argument("--first", type=int, default=0, help="first seed of each family (default: 0)")
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time (default: 2)")
    parser.add_argument("--json", type=Path, help="file for the figures of every seed, one a line")
    arguments = parser.parse_args()
    settings = arguments.settings or SETTINGS
    records = []
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(arguments.jobs) as pool:
        chosen = ["--family", arguments.family, "--first", str(arguments.first), "--scenes", str(arguments.scenes)]
        subprocess.run([CAMPAIGN, *chosen, "--print", "--save", temporary], check=True)
        scenes = sorted(Path(temporary).glob("*.toml"))
        for record in pool.map(lambda path: measure(path, settings), scenes):
            records.append(record)
            print(record["scene"], record["verdict"], file=sys.stderr, flush=True)
            if arguments.json:
                with arguments.json.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(record) + "\n")
    print_table(records, settings)


if __name__ == "__main__":
    main()
