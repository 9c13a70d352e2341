#!/usr/bin/env python3
"""Measures what each setting costs, in instructions relative to a run without it, and prints the tables of src/docs/costs.md.

    tools/setting_costs.py [--python PYTHON] [--only WORD] [--json FILE]

Each number is a ratio of instruction counts under callgrind, of all threads. The instructions of the same command with a run of 1 µs
are subtracted first: those of the start of the program, of the scene and of the report. (Sweeps: the difference of several runs.)
The count does not depend on the load of the machine, and changes by less than 1 % between repetitions. The rows on Python are
ratios of wall times, medians of three runs that alternate.

PYTHON is an interpreter with the package phalanx, for the rows on Python. --only measures the tables with this word in their title.
Needs valgrind and a release build of phalanx ($PHALANX names another program).
"""

import argparse
import datetime
import json
import math
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PHALANX = os.environ.get("PHALANX", str(ROOT / "target" / "release" / "phalanx"))
SCENES = {"finger": "experiment-95", "gripper": "gripper/design-95", "cycle": "gripper/cycle", "mechanism": "mechanisms/f85-finger"}
ALL = tuple(SCENES)
# The duration of a run that only starts.
START = ["--set", "duration=1 us"]
# Numbers of runs of sweeps and in Python, whose difference is measured.
FEW, MANY = 4, 12
# Times of each statement in Python.
TIMES = 3
ENGINE = ["--model", "engine"]


def settings(*fields):
    """Flags that set fields of a scene."""
    return [part for field in fields for part in ("--set", field)]


# The friction of the cycle, and of its brakes, has bristles.
REGULARISED = {"cycle": settings("contact.friction.law=regularised", "motor.brake_law=regularised")}
BRISTLE = {
    "finger": settings("contact.friction.law=bristle"),
    "gripper": settings("contact.friction.law=bristle"),
    "mechanism": settings("laws.pad.friction.law=bristle"),
}


def row(label, gain, flags, base=(), scenes=ALL, command="run"):
    """A setting: its flags, and those of the runs to which it is compared; lists, or lists by scene."""
    return {"label": label, "gain": gain, "flags": flags, "base": base, "scenes": scenes, "command": command}


def polygon(corners, radius_m=0.019, rounding_m=0.001):
    """Fields of an object that is a polygon with rounded corners around the disc of the scene."""
    angles = [math.pi / 2 + 2 * math.pi * (k + 0.5) / corners for k in range(corners)]
    points = ", ".join(f'["{1e3 * radius_m * math.cos(a):.6f} mm", "{1e3 * radius_m * math.sin(a):.6f} mm"]' for a in angles)
    return settings("object.outline.type=polygon", f"object.outline.vertices=[{points}]", f"object.outline.radius={1e3 * rounding_m} mm")


DISC = settings("object.outline.type=disc", "object.outline.radius=20 mm")
LOG = ["--log", "OUT.mcap"]

TABLES = [
    ("The analytic model", "a run with the everyday settings", [
        row("`--rtol 1e-3`", "the error is 100 times larger, 2e-7 rad for the finger", ["--rtol", "1e-3"]),
        row("`--rtol 1e-7`", "the error is 40 times smaller for the finger", ["--rtol", "1e-7"]),
        row("`--rtol 1e-9`", "the error is 300 times smaller for the finger", ["--rtol", "1e-9"]),
        row('`integrator.method = "radau5"`', "about the same error with another method, for comparison", settings("integrator.method=radau5")),
        row("`--preset reference`", "the error is near rounding: 4e-12 rad for the finger, 1e-9 rad for the cycle", ["--preset", "reference"]),
    ]),
    ("The engine model", "a run of the engine model with default settings", [
        row("the analytic model instead", "the error is 16 to 1,200 times smaller; the engine also takes mechanisms beyond the sizes of the analytic model", [], ENGINE),
        row('`--tolerance "1 um"`', "the error is 1.3 to 5 times larger", [*ENGINE, "--tolerance", "1 um"], ENGINE),
        row('`--tolerance "0.01 um"`', "the error is 2 to 19 times smaller", [*ENGINE, "--tolerance", "0.01 um"], ENGINE),
        row('`engine.max_step = "20 us"`', "the error is at most 11 times smaller", [*ENGINE, *settings("engine.max_step=20 us")], ENGINE),
        row('`--step "10 us"`', "equal steps, for studies of the step size; the error is up to 1,500 times larger", [*ENGINE, "--step", "10 us"], ENGINE),
    ]),
    ("Contact", "the same run with the other setting", [
        row("bristle friction in place of regularised, analytic model", "contacts at rest do not creep", BRISTLE, REGULARISED),
        row("bristle friction in place of regularised, engine model", "the same", {k: [*ENGINE, *BRISTLE.get(k, [])] for k in ALL}, {k: [*ENGINE, *REGULARISED.get(k, [])] for k in ALL}),
        row("`object.outline` a disc, analytic model", "none: the default tolerance of a mechanism is finer", DISC, (), ("gripper",)),
        row("… a polygon of 6 corners", "outlines other than discs", polygon(6), (), ("gripper",)),
        row("… of 10 corners", "the same", polygon(10), (), ("gripper",)),
        row("`object.outline` a disc, engine model", "none", [*ENGINE, *DISC], ENGINE, ("gripper",)),
        row("… a polygon of 10 corners", "the same", [*ENGINE, *polygon(10)], ENGINE, ("gripper",)),
        row("… of 32 corners", "the largest number of corners", [*ENGINE, *polygon(32)], ENGINE, ("gripper",)),
    ]),
    ("Check", "a run with `--no-check`", [
        row("`--check`, analytic model", "an error estimate, and whether the outcome is chaotic", ["--check"]),
        row("`--check`, engine model", "the same", [*ENGINE, "--check"], ENGINE, ("finger", "gripper")),
        row("`phalanx validate`", "both models in an ensemble of 5 runs (grippers: 2), and their differences", [], (), ("finger", "gripper"), "validate"),
    ]),
    ("Output", "a run without output", [
        row("`--log`", "all quantities at 10 kHz and pictures at 5 kHz, in Foxglove", LOG),
        row('`--log`, `--picture-rate "0 Hz"`', "no 3-D view", [*LOG, "--picture-rate", "0 Hz"]),
        row('`--log`, both rates 1 kHz', "a smaller log, without the details of motion", [*LOG, "--numeric-rate", "1 kHz", "--picture-rate", "1 kHz"]),
        row('`--log`, `--numeric-rate "100 kHz"`', "a smooth curve of each impact", [*LOG, "--numeric-rate", "100 kHz"]),
        row("`--log`, `log.joint_forces = true`", "forces of joints in the log", [*LOG, *settings("log.joint_forces=true")]),
        row("`--csv`", "all samples as text, with forces of joints", ["--csv", "OUT.csv"]),
        row("`--plot`", "an animated page", ["--plot", "OUT.html"]),
        row("`--log`, engine model", "as above, relative to a run of the engine model", [*ENGINE, *LOG], ENGINE),
    ]),
]

PYTHON_BASE = "phalanx.run(scene)"
# Statements, the number of simulations of each, and their scenes.
PYTHON = [
    ("`evaluate`, one thread, per design of 20", "one row per design, no samples", "phalanx.evaluate(scene, {field: 20 * value}, threads=1)", 20, ("finger", "gripper")),
    ('`numeric_rate="1 kHz"`', "fewer samples", "phalanx.run(scene, numeric_rate='1 kHz')", 1, ALL),
    ('`numeric_rate="100 kHz"`', "more samples", "phalanx.run(scene, numeric_rate='100 kHz')", 1, ALL),
    ("`gradient` with respect to 1 field", "derivatives of the results", "phalanx.run(scene, gradient=[field])", 1, ("finger",)),
    ("`gradient` with respect to 3 fields", "the same", "phalanx.run(scene, gradient=[field, *more])", 1, ("finger",)),
]
FIELDS = {
    "finger": ("contact.friction.mu_static", 0.8, ["design.base", "motor.torque"]),
    "gripper": ("contact.friction.mu_static", 0.8, ["design.base", "motor.torque"]),
    "cycle": ("contact.friction.mu_static", 0.8, []),
    "mechanism": (None, None, []),
}


def count(command):
    """Instructions of a command; None if it fails."""
    with tempfile.TemporaryDirectory() as directory:
        command = [str(part).replace("OUT", f"{directory}/out") for part in command]
        out = Path(directory) / "callgrind"
        valgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", *command]
        result = subprocess.run(valgrind, capture_output=True, text=True, check=False)
        if result.returncode not in (0, 1):
            message = [line for line in result.stderr.splitlines() if not line.startswith("==")]
            print(f"{' '.join(command)}: status {result.returncode}", *message, sep="\n  ", file=sys.stderr)
            return None
        return int(re.findall(r"^(?:summary|totals): (\d+)", out.read_text(), re.MULTILINE)[-1])


def of_scene(flags, scene):
    """Flags of one scene."""
    return list(flags.get(scene, [])) if isinstance(flags, dict) else list(flags)


class Counter:
    """Counts commands, each of them once, on all cores."""

    def __init__(self):
        self.pool = ThreadPoolExecutor(os.cpu_count())
        self.counts = {}

    def count(self, *command):
        key = tuple(map(str, command))
        if key not in self.counts:
            self.counts[key] = self.pool.submit(count, key)
        return self.counts[key]

    def run(self, command, scene, flags):
        """Futures of a run and of its start."""
        check = ["--no-check"] if command == "run" and "--check" not in flags else []
        arguments = [PHALANX, command, ROOT / "scenes" / f"{SCENES[scene]}.toml", "--json", *check, *flags]
        return self.count(*arguments), self.count(*arguments, *START)

    def sweep(self, flags):
        """Futures of sweeps of few and many runs."""
        study = [PHALANX, "sweep", ROOT / "scenes" / "studies" / "sample.toml", "--threads", "1", "--json", "--out", "OUT.csv"]
        return [self.count(*study, "--limit", str(n), *flags) for n in (MANY, FEW)]


def python_ratios(python, scene, statements):
    """Times of statements relative to the first one: medians, in one process that runs them in turn."""
    field, value, more = FIELDS[scene]
    path = str(ROOT / "scenes" / f"{SCENES[scene]}.toml")
    program = f"""
import json, statistics, time, phalanx
scene, field, value, more = phalanx.Scene.load({path!r}), {field!r}, [{value!r}], {more!r}
statements = [compile(text, "statement", "eval") for text in {statements!r}]
times = [[] for _ in statements]
for _ in range({TIMES}):
    for statement, seconds in zip(statements, times):
        start = time.perf_counter()
        eval(statement)
        seconds.append(time.perf_counter() - start)
print(json.dumps([statistics.median(seconds) / statistics.median(times[0]) for seconds in times]))
"""
    return json.loads(subprocess.run([python, "-c", program], capture_output=True, text=True, check=True).stdout)


def difference(futures):
    """Difference of two counts; None if one is missing."""
    large, small = (future.result() for future in futures)
    return None if large is None or small is None else large - small


def ratio(a, b):
    return None if not a or not b else a / b


def number(x):
    return "–" if x is None else f"{x:.2f}" if x < 10 else f"{x:.0f}"


def print_table(title, baseline, columns, rows):
    print(f"\n## {title}\n\nRelative to {baseline}:\n")
    print("| setting | " + " | ".join(columns) + " | effect |\n" + "|---" * (len(columns) + 2) + "|")
    for label, ratios, gain in rows:
        print("| " + " | ".join([label, *(number(ratios.get(column)) for column in columns), gain]) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", help="an interpreter with the package phalanx")
    parser.add_argument("--only", default="", help="measure the tables with this word in their title")
    parser.add_argument("--json", type=Path, help="also write the ratios to this file")
    options = parser.parse_args()
    if shutil.which("valgrind") is None:
        sys.exit("valgrind is not installed (Debian, Ubuntu: sudo apt-get install valgrind)")
    counter, result = Counter(), {}
    wanted = [table for table in TABLES if options.only.lower() in table[0].lower()]
    pending = []
    for title, baseline, rows in wanted:
        for entry in rows:
            futures = {}
            for scene in entry["scenes"]:
                changed = counter.run(entry["command"], scene, of_scene(entry["flags"], scene))
                futures[scene] = changed, counter.run("run", scene, of_scene(entry["base"], scene))
            pending.append((title, entry, futures))
    base = {scene: counter.run("run", scene, []) for scene in ALL}
    sweeps = [counter.sweep(flags) for flags in ([], ["--check"])] if options.only.lower() in "studies" else None
    python = options.python and options.only.lower() in "python"
    costs = {scene: difference(futures) for scene, futures in base.items()}
    print("| | " + " | ".join(ALL) + " |\n" + "|---" * (len(ALL) + 1) + "|")
    print("| instructions of an everyday run (million) | " + " | ".join(number(costs[scene] and costs[scene] / 1e6) for scene in ALL) + " |")
    for title, baseline, _ in wanted:
        rows = []
        for table, entry, futures in pending:
            if table == title:
                ratios = {scene: ratio(difference(changed), difference(before)) for scene, (changed, before) in futures.items()}
                rows.append((entry["label"], ratios, entry["gain"]))
        print_table(title, baseline, ALL, rows)
        result[title] = {label: ratios for label, ratios, _ in rows}
    if sweeps:
        plain, checked = (difference(futures) for futures in sweeps)
        print(f"\n## Studies\n\nA run of `scenes/studies/sample.toml` takes {plain / (MANY - FEW) / 1e6:.1f} million instructions, with `--check` {ratio(checked, plain):.2f} times as many.")
        result["sweep"] = {"instructions": plain / (MANY - FEW), "check": ratio(checked, plain)}
    if python:
        rows = [(label, {}, gain) for label, gain, *_ in PYTHON]
        for scene in ALL:
            indices = [index for index, (*_, scenes) in enumerate(PYTHON) if scene in scenes]
            ratios = python_ratios(options.python, scene, [PYTHON_BASE, *(PYTHON[index][2] for index in indices)])
            for index, of_statement in zip(indices, ratios[1:]):
                rows[index][1][scene] = of_statement / PYTHON[index][3]
        print_table("Python", "`phalanx.run`, in wall time", ALL, rows)
        result["python"] = {label: ratios for label, ratios, _ in rows}
    version = subprocess.run([PHALANX, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    print(f"\n{version}, {platform.machine()}, {datetime.date.today():%-d %B %Y}, valgrind --tool=callgrind.")
    if options.json:
        options.json.write_text(json.dumps({"instructions": costs, "ratios": result}, indent=1) + "\n")


if __name__ == "__main__":
    main()
