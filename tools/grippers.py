#!/usr/bin/env python3
"""Measures the grippers and puts the tables and the picture into src/docs/grippers.md.

    tools/grippers.py                 everything (some minutes)
    tools/grippers.py --only grippers   the table of scenes alone; also capture, capture-study, hold, questions

Builds in release mode; runs and validates every gripper of scenes/gripper and scenes/hard, asks what one of them captures, and runs the
study of the thesis' designs with a positioning error.
"""

import argparse
import csv
import json
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from readme_figures import PHALANX, ROOT, call, number, put, table

FIGURES = ROOT / "tools" / "figures"
CAPTURED = "scenes/gripper/offset.toml"
HELD = "scenes/gripper/hold.toml"
STUDY = "scenes/studies/capture.toml"
G = 9.80665


def phalanx(*arguments):
    """JSON document of a command."""
    result = subprocess.run([str(PHALANX), *map(str, arguments), "--json"], cwd=ROOT, capture_output=True, text=True)
    if not result.stdout:
        sys.exit(result.stderr)
    return json.loads(result.stdout)


def scene_row(path):
    run = phalanx("run", path)
    engine = phalanx("run", path, "--model", "engine", "--no-check")
    verdict = {check["bound"]: check["measured"] for check in phalanx("validate", path)["verdict"]}
    touches = [[run["contacts"][f"{side}_{site}"]["first_s"] for site in ("proximal", "distal")] for side in ("right", "left")]
    touches = [[time_s for time_s in of if time_s is not None] for of in touches]
    first = " / ".join(f"{min(of) * 1e3:.3f}" if of else "–" for of in touches)
    grasp, at = run["grasp"], run["object"]
    tts = "–" if grasp["tts_s"] is None else f"{grasp['tts_s'] * 1e3:.2f}"
    check = run["check"]
    return [
        f"[`{path.stem}`](../../{path.relative_to(ROOT)})",
        first,
        f"{at['x_m'] * 1e3:z.3f}, {at['y_m'] * 1e3:z.3f}".replace("-", "−"),
        grasp["fate"],
        tts,
        check["verdict"] if check["verdict"] == "chaotic" else number(check["error_rad"]),
        number(verdict["angle_rad"]),
        number(verdict["position_m"] * 1e6, "{:.2g}"),
        f"{run['steps']} / {engine['steps']}",
        f"{run['wall_s'] * 1e3:.1f} / {engine['wall_s'] * 1e3:.0f}",
    ]


def scenes(_):
    paths = sorted((ROOT / "scenes" / "gripper").glob("*.toml")) + sorted((ROOT / "scenes" / "hard").glob("gripper-*.toml"))
    header = [
        "scene",
        "first touch, right / left (ms)",
        "object ends at x, y (mm)",
        "fate",
        "tts (ms)",
        "everyday off by",
        "engine off by (rad)",
        "(µm)",
        "steps",
        "time (ms)",
    ]
    return table(header, [scene_row(path) for path in paths])


def capture(scratch):
    call(PHALANX, "capture", CAPTURED, "--out", scratch / "capture")
    (FIGURES / "capture.svg").write_text((scratch / "capture" / "capture.svg").read_text())
    text = (scratch / "capture" / "capture.txt").read_text()
    return f"```text\n{text}```\n"


def hold(scratch):
    call(PHALANX, "hold", HELD, "--out", scratch / "hold")
    (FIGURES / "hold.svg").write_text((scratch / "hold" / "hold.svg").read_text())
    text = (scratch / "hold" / "hold.txt").read_text()
    shaken = [PHALANX, "hold", HELD, "--vibration", "--along", "x,y,angle"]
    shaken = subprocess.run([*map(str, shaken)], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return f"```text\n{text}```\n\n```text\n{shaken}```\n"


BLOCKED = {"motor.brake": "two-way", "motor.brake_at": "15 ms", "motor.brake_law": "bristle", "motor.brake_torque": "1 N*m"}
QUESTIONS = {
    "Which brake?": [("no brake", {"motor.brake": "none"})] + [(f"{torque} N·m", {"motor.brake_torque": f"{torque} N*m"}) for torque in (0.25, 0.5, 1, 2)],
    "How much friction?": [(f"μ_s = {mu}", {"contact.friction.mu_static": mu}) for mu in (0.1, 0.2, 0.4, 0.8)],
    "What offset?": [(f"{offset} mm", {"object.offset": f"{offset} mm"}) for offset in (0, 1, 2, 3)],
    "What load?": [(f"{mass} g", {"object.mass": f"{mass} g"}) for mass in (5.38, 53.8, 538)],
}


def questions(scratch):
    """What design 95 holds with brakes of 1 N·m, and what of it one change makes."""
    blocked = [part for field, value in BLOCKED.items() for part in ("--set", f"{field}={value}")]
    call(PHALANX, "hold", HELD, "--to", "2000 m/s^2", "--directions", 24, *blocked, "--out", scratch / "blocked")
    (FIGURES / "hold-blocked.svg").write_text((scratch / "blocked" / "hold.svg").read_text())
    directions = ["along the palm", "out of it", "into it"]
    header = ["", "", *directions]
    lines = []
    for question, variants in QUESTIONS.items():
        for name, change in variants:
            blocked = {} if change.get("motor.brake") == "none" else BLOCKED | change
            flags = [part for field, value in blocked.items() for part in ("--set", f"{field}={value}")]
            loads = phalanx("hold", HELD, "--to", "2000 m/s^2", "--directions", 4, *flags)["loads"]
            lines.append([question, name, *(held_in(loads[index]) for index in (0, 1, 3))])
            question = ""
    return table(header, lines)


def held_in(load):
    """The limit of a direction by simulation, in g, and (in brackets) at rest."""
    found, at_rest = load["slips"], load["quasi_static_m_s2"]
    over = "≥ " if found["failed_m_s2"] is None else ""
    simulated = "–" if found["held_m_s2"] is None else over + number(found["held_m_s2"] / G, "{:.3g}")
    at_rest = load["quasi_static"] or "–" if at_rest is None else number(at_rest / G, "{:.3g}")
    return f"{simulated} ({at_rest})"


def study(scratch):
    out = scratch / "capture.csv"
    call(PHALANX, "sweep", STUDY, "--out", out)
    designs = {0.0: defaultdict(list), 0.8: defaultdict(list)}
    for run in csv.DictReader(out.open()):
        designs[float(run["contact.friction.mu_static"])][int(run["design"])].append(run)
    lines, closure = [], []
    for mu, of in designs.items():
        sized = {name: runs for name, runs in of.items() if runs[0]["status"] != "refused"}
        done = [run for runs in sized.values() for run in runs if run["status"] == "completed"]
        held = [run for run in done if run["grasp"] == "held"]
        everywhere = [runs for runs in sized.values() if all(run["grasp"] == "held" for run in runs)]
        ratios = [float(run["offset_ratio"]) for run in held if run["offset_ratio"]]
        closed = [run for run in held if run["form_closed"] == "true"]
        tts = [float(run["tts_s"]) * 1e3 for run in held if run["tts_s"]]
        quantiles = statistics.quantiles(ratios, n=10) if len(ratios) > 1 else [float("nan")] * 9
        lines.append(
            [
                f"{mu}",
                f"{len(sized)} of {len(of)}",
                f"{len(held)} of {len(done)}",
                f"{len(everywhere)}",
                f"{sum(ratio < 1 for ratio in ratios)} of {len(ratios)}",
                f"{statistics.median(ratios):.2f} ({quantiles[0]:.2f} – {quantiles[-1]:.2f})" if ratios else "–",
                f"{len(closed)} of {len(held)}",
                f"{statistics.median(tts):.1f}" if tts else "–",
            ]
        )
        closure.append([f"{mu}", *closed_from_the_middle_and_off(sized.values())])
    header = [
        "μ_s",
        "designs that can be sized",
        "runs held at 40 ms",
        "designs held at all 8 places",
        "brought nearer to the middle",
        "offset left, of that at the start: median (10 % – 90 %)",
        "form-closed at the end",
        "tts, median (ms)",
    ]
    second = [
        "μ_s",
        "designs held from the middle",
        "of them form-closed",
        "open from the middle: held off it, and form-closed there",
        "closed from the middle: held off it, and form-closed there",
    ]
    return table(header, lines) + "\n\n" + table(second, closure)


def closed_from_the_middle_and_off(designs):
    """Of designs: how many are held from the middle, how many are form-closed then, and what becomes of both kinds off the middle."""
    def held(runs):
        return [run for run in runs if run["status"] == "completed" and run["grasp"] == "held"]

    off = {"false": [], "true": []}
    from_the_middle = []
    for runs in designs:
        middle = held(run for run in runs if float(run["object.offset_m"]) == 0.0)
        if middle:
            from_the_middle.append(middle[0]["form_closed"] == "true")
            off[middle[0]["form_closed"]] += held(run for run in runs if float(run["object.offset_m"]) != 0.0)

    def closed(runs):
        return f"{len(runs)}, {sum(run['form_closed'] == 'true' for run in runs)}"

    return [f"{len(from_the_middle)}", f"{sum(from_the_middle)}", closed(off["false"]), closed(off["true"])]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = {"grippers": scenes, "capture": capture, "capture-study": study, "hold": hold, "questions": questions}
    parser.add_argument("--only", choices=parts, action="append")
    chosen = parser.parse_args().only or list(parts)
    call("cargo", "build", "--release", "--locked")
    with tempfile.TemporaryDirectory() as scratch:
        for name in chosen:
            block = f"<!-- figures:begin {name} -->\n{parts[name](Path(scratch))}\n<!-- figures:end {name} -->"
            print(block, flush=True)
            put(name, block)


if __name__ == "__main__":
    main()
