#!/usr/bin/env python3
"""Measures the figures of the README and of the documents in src/docs, and updates them.

    tools/readme_figures.py                 all blocks
    tools/readme_figures.py scenes memory   only these
    tools/readme_figures.py --dry-run       print only, do not change the pages

Builds what it needs in release mode, measures, prints each block as a Markdown table between its markers, and replaces the
block of the same name in the page that has it; nothing else changes. Blocks: summary, accuracy, scenes, memory, engine,
validate, log, reproduce, design, map, explorer. Needs only Python's own library, GNU time for the block memory, and for the block
explorer what tools/explorer.sh and tools/clients.sh need, and for the block summary libsundials-dev (CVODE) and `pip install mujoco`.
The blocks scenes, engine, reproduce and map also put their pictures into tools/figures. $PHALANX names another program for the block map.
"""

import argparse
import collections
import csv
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "src" / "docs").glob("*.md"))]
PHALANX = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "phalanx"


def call(*command, **options):
    """Runs a command in the project; its failure ends the script."""
    print("$", *command, file=sys.stderr)
    result = subprocess.run([str(part) for part in command], cwd=ROOT, **options)
    if result.returncode != 0:
        sys.exit(f"{command[0]} failed with status {result.returncode}")
    return result


def table(header, rows):
    """A Markdown table."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def number(x, form="{:.1e}"):
    """A figure, or a dash if it is missing."""
    return "–" if x is None else form.format(x)


def method_name(row):
    return row["method"] + (f" (preset `{row['preset']}`)" if row["preset"] else "")


# Tolerances shown in the README; the bench prints all.
SHOWN_RTOLS = ("1e-04", "1e-06", "1e-08", "1e-10")


def comparison_table(rows):
    """Work and precision, one row per solver."""
    rows = [row for row in rows if row["preset"] or f"{row['rtol']:.0e}" in SHOWN_RTOLS]
    header = [
        "method", "rtol", "right of 15", "angle error, median / worst (rad)", "contact time (s)", "impulse",
        "time, median / min (ms)", "ratio", "steps", "right-hand sides",
    ]
    body = []
    for row in rows:
        errors, time = row["errors"], row["time"]
        body.append([
            method_name(row),
            f"{row['rtol']:.0e}",
            f"{errors['right']}" + (f", {errors['stepped_over']} over a contact" if errors["stepped_over"] else ""),
            number(errors["angle_median_rad"]) + " / " + number(errors["angle_worst_rad"]),
            number(errors["touch_worst_s"]),
            number(errors["impulse_worst"]),
            f"{time['median_s'] * 1e3:.3f} / {time['min_s'] * 1e3:.3f}",
            f"{row['ratio']:.2f}",
            str(errors["cost"]["steps"]),
            str(errors["cost"]["rhs"]),
        ])
    return table(header, body)


def design_table(sweeps):
    """Table of the presets over random designs."""
    header = ["designs", "preset", "right", "singular, right", "angle error, median / p99 / worst (rad)", "mean time (ms)"]
    body = []
    for sweep in sweeps:
        chaotic = sweep["designs"] - sweep["judged"]
        for preset in sweep["presets"]:
            angles = [number(preset[f"angle_{key}_rad"]) for key in ("median", "p99", "worst")]
            body.append([
                f"{sweep['designs']}, {sweep['drive']} drive ({chaotic} chaotic)",
                preset["name"],
                f"{preset['right']} of {sweep['judged']}",
                f"{preset['singular_right']} of {sweep['singular']}",
                " / ".join(angles),
                f"{preset['mean_s'] * 1e3:.3f}",
            ])
    return table(header, body)


def accuracy(scratch):
    """Work and precision on design 95, phalanx and published solvers in one run, and the presets over random designs."""
    ours, all_solvers = scratch / "ours.json", scratch / "solvers.json"
    call("cargo", "bench", "--locked", "--bench", "work_precision", "--", "--json", ours, stdout=sys.stderr)
    solvers = ["cargo", "run", "--locked", "--release", "--manifest-path", "benches/solvers/Cargo.toml"]
    call(*solvers, "--", "--json", all_solvers, stdout=sys.stderr)
    comparison = json.loads(all_solvers.read_text())
    designs = json.loads(ours.read_text())["designs"]
    return comparison_table(comparison["rows"]) + "\n\n" + design_table(designs)


def scenes(_):
    """Table of the shipped scenes, and a picture of one with its symbols."""
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    call(PHALANX, "scene", "show", "scenes/experiment-95.toml", "--plot", "tools/figures/linkage.svg", stdout=sys.stderr)
    header = [
        "scene", "contact, proximal / distal (ms)", "q11, q21 at the end (°)", "force, proximal / distal (N)", "class", "tts (ms)",
        "steps", "time (ms)",
    ]
    body = []
    for scene in sorted((ROOT / "scenes").glob("*.toml")):
        # Status 3: the simulation ended early, as its document states.
        result = subprocess.run([PHALANX, "run", scene, "--json"], capture_output=True, text=True, check=False)
        if result.returncode not in (0, 1, 3) or not result.stdout:
            sys.exit(f"{scene.name}: status {result.returncode}\n{result.stderr}")
        body.append(scene_row(scene, json.loads(result.stdout)))
    return table(header, body)


def scene_row(path, run):
    name = f"[`{run['scene']}`](../../scenes/{path.name})"
    if not run["final"] or not run["contacts"]:
        return [name] + ["–"] * 7
    phalanges = [run["contacts"][which] for which in ("proximal", "distal")]
    milli = lambda x: "–" if x is None else f"{x * 1e3:.3f}"  # noqa: E731
    criteria = run["criteria"] or {}
    ended = "" if run["completed"] else f" (ended at {milli(run['end_s'])} ms)"
    return [
        name + ended,
        " / ".join(milli(p["first_s"]) for p in phalanges),
        ", ".join(f"{math.degrees(run['final'][key]):.4f}" for key in ("q11_rad", "q21_rad")),
        " / ".join(f"{p['final_normal_n']:.3f}" for p in phalanges),
        criteria.get("class") or "–",
        milli(criteria.get("tts_s")),
        str(run["steps"]),
        f"{run['wall_s'] * 1e3:.2f}",
    ]


def peak_rss(scratch, command):
    """Peak resident memory of a command, in MiB. Measured by GNU time, because the kernel's figure for a child
    process includes the Python interpreter from which it was forked."""
    report = scratch / "peak"
    call("/usr/bin/time", "-f", "%M", "-o", report, *command, stdout=subprocess.DEVNULL)
    return int(report.read_text().split()[-1]) / 1024


def memory(scratch):
    """Peak memory of a 10 s hold with a log, next to the peak memory of the closing alone."""
    if not Path("/usr/bin/time").exists():
        sys.exit("GNU time is not installed: get it from the packages of the system (apt-get install time)")
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    scene, log = ROOT / "scenes" / "experiment-95.toml", scratch / "hold.mcap"
    body = []
    for duration in ("20 ms", "1 s", "10 s"):
        peak = peak_rss(scratch, [PHALANX, "run", scene, "--duration", duration, "--log", log])
        body.append([duration, f"{peak:.1f}", f"{log.stat().st_size / 1e6:.1f}"])
    return table(["length of the run", "peak memory (MiB)", "log (MB)"], body)


def validation(scene, *options):
    """The JSON document of one `phalanx validate`; status 1 means that a bound is exceeded, as the document states."""
    command = [PHALANX, "validate", scene, "--json", *options]
    print("$", *command, file=sys.stderr)
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode not in (0, 1) or not result.stdout:
        sys.exit(f"{scene.name}: status {result.returncode}\n{result.stderr}")
    return json.loads(result.stdout)


def engine(scratch):
    """Speed and error of every setting on design 95, and their plot."""
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    out = scratch / "validation"
    document = validation(ROOT / "scenes" / "experiment-95.toml", "--ladder-time", "600 s", "--out", out)
    shutil.copy(out / "speed-error.svg", ROOT / "tools" / "figures" / "speed-error.svg")
    header = [
        "setting", "runs", "steps", "time (ms)", "× real time", "× everyday analytic", "angle (rad)", "contact time (µs)", "impulse (%)",
        "final force (%)", "loop gap (m)",
    ]
    body = []
    for row in document["settings"]:
        name = f"{row['family']}: {row['setting']}" + (" (default)" if row["own"] else "")
        if row["status"] != "done" or row["reference"]:
            continue
        differences = row["differences"]
        worst = lambda key: max_known(differences[site][key] for site in ("proximal", "distal"))  # noqa: E731, B023
        scaled = lambda key, factor: number(worst(key) and worst(key) * factor, "{:.3g}")  # noqa: E731, B023
        body.append([
            name,
            str(row["ensemble_runs"]),
            str(row["steps"]),
            f"{row['wall_s'] * 1e3:.3g}",
            f"{row['real_time_factor']:.3g}",
            f"{row['analytic_factor']:.3g}",
            number(row["angle_max_rad"]),
            scaled("first_touch_s", 1e6),
            scaled("impulse", 100),
            scaled("final_force", 100),
            number(differences["loop_gap_m"]),
        ])
    return table(header, body)


def max_known(values):
    known = [value for value in values if value is not None]
    return max(known) if known else None


def validate(_):
    """Comparison of the engine with the analytic model on every shipped scene."""
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    header = [
        "scene", "within bounds", "angle (rad)", "contact time (s)", "final force", "impulse", "loop gap (m)", "steps",
        "time (ms)", "× real time",
    ]
    body = []
    for scene in sorted((ROOT / "scenes").glob("*.toml")):
        document = validation(scene, "--quick", "--ladder")
        measured = {row["bound"]: row["measured"] for row in document["verdict"]}
        run = document["engine"]
        keys = ("angle_rad", "contact_time_s", "final_force", "impulse", "loop_gap_m")
        body.append([
            f"[`{document['scene']}`](../../scenes/{scene.name})",
            "yes" if document["passed"] else "no",
            *(number(measured[key]) for key in keys),
            str(run["steps"]),
            f"{run['wall_s'] * 1e3:.2f}",
            f"{document['duration_s'] / run['wall_s']:.1f}",
        ])
    return table(header, body)


def log(_):
    """Cost of a log in a run of design 95; the bench prints the table."""
    found = call("cargo", "bench", "--locked", "--bench", "log_cost", stdout=subprocess.PIPE, text=True)
    return "\n".join(line for line in found.stdout.splitlines() if line.startswith("|"))


def reproduce(scratch):
    """Figures of the thesis and of phalanx side by side; pictures of a volume and of the selection."""
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    out = scratch / "reproduce"
    command = [PHALANX, "thesis", "reproduce", "--out", out, "--json"]
    print("$", *command, file=sys.stderr)
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    # Status 1: a figure is not as expected, as the document states.
    if result.returncode not in (0, 1) or not result.stdout:
        sys.exit(f"reproduce: status {result.returncode}\n{result.stderr}")
    for ours, theirs in (("volume-19.svg", "volume.svg"), ("criteria.svg", "selection.svg")):
        shutil.copy(out / "figures" / ours, ROOT / "tools" / "figures" / theirs)
    lines = (out / "report.md").read_text().split("**Table 1.**")[1].splitlines()
    rows = [line for line in lines[1:lines.index("", 2)] if line.startswith("|")]
    # Sources and reasons are only in the report.
    return "\n".join("|".join(row.split("|")[:5]) + "|" for row in rows)


def design(scratch):
    """Speed of sweeps, volumes and the reproduction; the benches print the tables of the first two."""
    bench = lambda name: call("cargo", "bench", "--locked", "--bench", name, stdout=subprocess.PIPE, text=True)  # noqa: E731
    tables = []
    for name in ("sweep", "volume"):
        lines = [line for line in bench(name).stdout.splitlines() if line.startswith("|")]
        # A bench can print several tables. Each begins with a header line, followed by a line of dashes.
        for line, after in zip(lines, lines[1:] + [""]):
            tables.append(("\n" if after.startswith("|---") and tables else "") + line)
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    times = []
    for _ in range(3):
        start = time.perf_counter()
        subprocess.run([PHALANX, "thesis", "reproduce", "--out", scratch / "again"], capture_output=True, check=False)
        times.append(time.perf_counter() - start)
    whole = f"The whole of `phalanx thesis reproduce`, with its pictures, takes {sorted(times)[1]:.1f} s on {os.cpu_count()} cores."
    return "\n".join(tables) + "\n\n" + whole


def processor():
    """Name of the processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), "unknown")


def fate_map(scratch):
    """The map of a real gripper over size, friction and offset: its picture, the largest cubes lifted, and the time of the runs."""
    program = Path(os.environ.get("PHALANX", PHALANX))
    if program == PHALANX:
        call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    results, picture = scratch / "map.csv", ROOT / "tools" / "figures" / "2f85-map.svg"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    study = ROOT / "scenes" / "studies" / "2f85-map.toml"
    call(program, "sweep", study, "--threads", "1", "--out", results, "--plot", picture, "--force", "--quiet", stdout=sys.stderr)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    rows = list(csv.DictReader(results.open()))
    fates = collections.Counter(row["fate"] or row["status"] for row in rows)
    held = collections.defaultdict(dict)
    for row in rows:
        place = (float(row["parameters.offset_m"]), round(float(row["parameters.mu"]), 3))
        held[place][float(row["parameters.cube_m"])] = row["fate"] == "held" and float(row["slip_m"]) <= MAX_SLIP_M
    body = []
    for offset in sorted({offset for offset, _ in held}):
        line = [f"{offset * 1e3:g} mm"]
        for mu in SHOWN_MU:
            cubes = held[offset, mu]
            # Every cube up to this one is lifted.
            largest = [cube for cube in cubes if all(cubes[other] for other in cubes if other <= cube)]
            line.append(f"{max(largest) * 1e3:g} mm" if largest else "none")
        body.append(line)
    counts = ", ".join(f"{count} {fate}" for fate, count in fates.most_common())
    header = ["offset", *(f"μ_s = {mu:g}" for mu in SHOWN_MU)]
    measured = (
        f"{len(rows):,} runs: {counts}. They take {seconds:.0f} s of processor time on one thread ({time.strftime('%Y-%m-%d')}, {'release build' if program == PHALANX else 'program of the tests'}, {processor()}, "
        f"{os.cpu_count()} cores shared with other programs)."
    )
    return table(header, body) + f"\n\n{measured}"


# Friction of the columns of the table of the map, and the slip of a cube that counts as lifted.
SHOWN_MU = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
MAX_SLIP_M = 5e-3


# Linkages of the table of the README, and the time steps of MuJoCo, s.
LINKAGES = [("real/2f85-lift.toml", ["5e-4"]), ("mechanisms/two-pivot.toml", ["5e-4"])]

# A solver is represented in the README by its fastest setting with every run of the ensemble below this angle error.
REPRESENTATIVE_RAD = 1e-6


def fastest(rows, methods):
    """The fastest row of some methods whose worst angle error is at most REPRESENTATIVE_RAD."""
    accurate = [
        row for row in rows
        if row["method"] in methods and row["errors"]["right"] == row["errors"]["of"]
        and row["errors"]["angle_worst_rad"] is not None and row["errors"]["angle_worst_rad"] <= REPRESENTATIVE_RAD
    ]  # fmt: skip
    return min(accurate, key=lambda row: row["time"]["median_s"])


def summary(scratch):
    """Time and error of one closing: phalanx, CVODE, the best Rust solver, MuJoCo; and the time of a sweep."""
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    solvers = ["cargo", "run", "--locked", "--release", "--features", "cvode", "--manifest-path", "benches/solvers/Cargo.toml"]
    call(*solvers, "--", "--repetitions", "15", "--json", scratch / "solvers.json", stdout=sys.stderr)
    environment = {**os.environ, "PHALANX": str(PHALANX)}
    # The angles that are compared in the other rows.
    angles = ["--only", "q11_rad", "q21_rad"]
    call(sys.executable, "tools/mujoco_beside.py", "--json", scratch / "mujoco.json", *angles, stdout=sys.stderr, env=environment)
    solvers = json.loads((scratch / "solvers.json").read_text())["rows"]
    mujoco = json.loads((scratch / "mujoco.json").read_text())
    engine_own = next(row for row in validation(ROOT / "scenes" / "experiment-95.toml", "--ladder")["settings"] if row["own"])
    row = lambda name, error, seconds: [name, number(error) + " rad", f"{seconds * 1e3:.2g} ms"]  # noqa: E731
    solver = lambda name, found: row(name, found["errors"]["angle_worst_rad"], found["time"]["median_s"])  # noqa: E731
    preset = lambda name: next(found for found in solvers if found["preset"] == name)  # noqa: E731
    published = {found["method"] for found in solvers if not found["ours"]} - {"CVODE BDF"}
    cvode, rust = fastest(solvers, {"CVODE BDF"}), fastest(solvers, published)
    body = [
        solver("a closing of 20 ms: phalanx, analytic model, `engineering` preset (default)", preset("engineering")),
        row("phalanx, engine model (rapier with the contact hook)", engine_own["angle_max_rad"], engine_own["wall_s"]),
        solver(f"CVODE (BDF, rtol {cvode['rtol']:.0e}), same equations", cvode),
        solver(f"best Rust solver ({rust['method']}, rtol {rust['rtol']:.0e}), same equations", rust),
    ]
    for found in mujoco:
        if found["method"].endswith("RK4") and found["step_s"] >= 1e-4:
            name = f"{found['method']}, step {found['step_s'] * 1e6:.0f} µs, its own contacts"
            body.append([name, f"{number(found['run_rad'])} rad (swing {number(found['swing_rad'])} rad)", f"{found['time_s'] * 1e3:.2g} ms"])
    for scene, steps in LINKAGES:
        beside = ["tools/mujoco_beside.py", ROOT / "scenes" / scene, "--json", scratch / "linkage.json", "--repetitions", "5", "--steps", *steps]
        call(sys.executable, *beside, stdout=sys.stderr, env=environment)
        found = json.loads((scratch / "linkage.json").read_text())
        name = Path(scene).stem
        for own in (found_row for found_row in found if found_row["step_s"] is None):
            body.append(row(f"`{name}`: phalanx, analytic model, default", own["run_rad"], own["time_s"]))
        for other in (found_row for found_row in found if found_row["method"].endswith("implicitfast")):
            step = f"{other['step_s'] * 1e6:.0f} µs"
            body.append(row(f"`{name}`: {other['method']}, step {step}, its own contacts", other["run_rad"], other["time_s"]))
    study, times = ROOT / "scenes" / "studies" / "thesis.toml", []
    for _ in range(5):
        start = time.perf_counter()
        with tempfile.TemporaryDirectory() as results:
            call(PHALANX, "sweep", study, "--out", Path(results) / "thesis.csv", "--quiet", stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - start)
    body.append([f"phalanx, 384 designs sized and simulated, {os.cpu_count()} cores", "", f"{sorted(times)[2]:.2g} s"])
    measured = f"Measured on {time.strftime('%Y-%m-%d')} on {os.cpu_count()} cores of {processor()}, shared with others."
    return table(["one run, one core", "largest angle error", "time"], body) + f"\n\n{measured}"


def explorer(scratch):
    """Size and response time of the explorer's page; the script prints the table."""
    call("tools/clients.sh", "setup", stdout=sys.stderr)
    call("cargo", "build", "--locked", "--release", stdout=sys.stderr)
    call("tools/explorer.sh", stdout=sys.stderr)
    environment = {**os.environ, "PHALANX": str(PHALANX)}
    return call("node", "tools/explorer_cost.mjs", stdout=subprocess.PIPE, text=True, env=environment).stdout.rstrip()


BLOCKS = {
    "summary": summary, "accuracy": accuracy, "scenes": scenes, "memory": memory, "engine": engine, "validate": validate, "log": log,
    "reproduce": reproduce, "design": design, "map": fate_map, "explorer": explorer,
}


def put(name, content):
    """Replaces a block in the page that contains it."""
    pattern = re.compile(rf"<!-- figures:begin {name} -->.*?<!-- figures:end {name} -->", re.DOTALL)
    having = [page for page in PAGES if pattern.search(page.read_text())]
    if len(having) != 1:
        sys.exit(f"block '{name}' is in {len(having)} pages: put its two markers into one of README.md and src/docs/*.md")
    having[0].write_text(pattern.sub(lambda _: content, having[0].read_text()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("blocks", nargs="*", metavar="BLOCK", help="one of those above; all if none is given")
    parser.add_argument("--dry-run", action="store_true", help="leave the pages alone")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.blocks if name not in BLOCKS]
    if unknown:
        parser.error(f"no block '{unknown[0]}'; there are {', '.join(BLOCKS)}")
    with tempfile.TemporaryDirectory() as scratch:
        for name in arguments.blocks or BLOCKS:
            block = f"<!-- figures:begin {name} -->\n{BLOCKS[name](Path(scratch))}\n<!-- figures:end {name} -->"
            print(block, flush=True)
            if not arguments.dry_run:
                put(name, block)


if __name__ == "__main__":
    main()
