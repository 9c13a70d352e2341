#!/usr/bin/env python3
"""Measures the grippers and writes the tables and figures of src/docs/grippers.md.

    tools/grippers.py                   everything (some minutes)
    tools/grippers.py --only grippers   only the table of scenes; also capture, capture-study, hold, questions

Builds in release mode, runs and validates every gripper of scenes/gripper and scenes/hard, runs `phalanx capture` and
`phalanx hold`, and sweeps the thesis' designs with a positioning error.
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
CAPTURE_SCENE = "scenes/gripper/offset.toml"
HOLD_SCENE = "scenes/gripper/hold.toml"
CAPTURE_STUDY = "scenes/studies/capture.toml"
G = 9.80665


def phalanx(*arguments):
    """Returns the JSON document of a command."""
    result = subprocess.run([str(PHALANX), *map(str, arguments), "--json"], cwd=ROOT, capture_output=True, text=True)
    if not result.stdout:
        sys.exit(result.stderr)
    return json.loads(result.stdout)


def scene_row(path):
    """Returns the table cells of a scene."""
    run = phalanx("run", path)
    engine = phalanx("run", path, "--model", "engine", "--no-check")
    measured = {check["bound"]: check["measured"] for check in phalanx("validate", path)["verdict"]}
    times = [[run["contacts"][f"{side}_{link}"]["first_s"] for link in ("proximal", "distal")] for side in ("right", "left")]
    times = [[time_s for time_s in finger if time_s is not None] for finger in times]
    first_contacts = " / ".join(f"{min(finger) * 1e3:.3f}" if finger else "–" for finger in times)
    grasp, position = run["grasp"], run["object"]
    tts = "–" if grasp["tts_s"] is None else f"{grasp['tts_s'] * 1e3:.2f}"
    check = run["check"]
    return [
        f"[`{path.stem}`](../../{path.relative_to(ROOT)})",
        first_contacts,
        f"{position['x_m'] * 1e3:z.3f}, {position['y_m'] * 1e3:z.3f}".replace("-", "−"),
        grasp["fate"],
        tts,
        check["verdict"] if check["verdict"] == "chaotic" else number(check["error_rad"]),
        number(measured["angle_rad"]),
        number(measured["position_m"] * 1e6, "{:.2g}"),
        f"{run['steps']} / {engine['steps']}",
        f"{run['wall_s'] * 1e3:.1f} / {engine['wall_s'] * 1e3:.0f}",
    ]


def scenes(_):
    paths = sorted((ROOT / "scenes" / "gripper").glob("*.toml")) + sorted((ROOT / "scenes" / "hard").glob("gripper-*.toml"))
    header = [
        "scene",
        "first contact, right / left (ms)",
        "final object position x, y (mm)",
        "fate",
        "tts (ms)",
        "default preset: error",
        "engine: angle error (rad)",
        "position error (µm)",
        "steps",
        "time (ms)",
    ]
    return table(header, [scene_row(path) for path in paths])


def capture(scratch):
    call(PHALANX, "capture", CAPTURE_SCENE, "--out", scratch / "capture")
    (FIGURES / "capture.svg").write_text((scratch / "capture" / "capture.svg").read_text())
    text = (scratch / "capture" / "capture.txt").read_text()
    return f"```text\n{text}```\n"


def hold(scratch):
    call(PHALANX, "hold", HOLD_SCENE, "--out", scratch / "hold")
    (FIGURES / "hold.svg").write_text((scratch / "hold" / "hold.svg").read_text())
    text = (scratch / "hold" / "hold.txt").read_text()
    command = [PHALANX, "hold", HOLD_SCENE, "--vibration", "--along", "x,y,angle"]
    vibration_text = subprocess.run([*map(str, command)], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return f"```text\n{text}```\n\n```text\n{vibration_text}```\n"


BRAKED = {"motor.brake": "two-way", "motor.brake_at": "15 ms", "motor.brake_law": "bristle", "motor.brake_torque": "1 N*m"}
QUESTIONS = {
    "Which brake?": [("no brake", {"motor.brake": "none"})] + [(f"{torque} N·m", {"motor.brake_torque": f"{torque} N*m"}) for torque in (0.25, 0.5, 1, 2)],
    "How much friction?": [(f"μ_s = {mu}", {"contact.friction.mu_static": mu}) for mu in (0.1, 0.2, 0.4, 0.8)],
    "What offset?": [(f"{offset} mm", {"object.offset": f"{offset} mm"}) for offset in (0, 1, 2, 3)],
    "What load?": [(f"{mass} g", {"object.mass": f"{mass} g"}) for mass in (5.38, 53.8, 538)],
}


def questions(scratch):
    """Returns the table of accelerations that design 95 holds with brakes of 1 N·m, and with one change at a time."""
    flags = set_flags(BRAKED)
    call(PHALANX, "hold", HOLD_SCENE, "--to", "2000 m/s^2", "--directions", 24, *flags, "--out", scratch / "blocked")
    (FIGURES / "hold-blocked.svg").write_text((scratch / "blocked" / "hold.svg").read_text())
    header = ["", "", "along the palm", "out of the palm", "into the palm"]
    lines = []
    for question, variants in QUESTIONS.items():
        for name, change in variants:
            flags = set_flags({} if change.get("motor.brake") == "none" else BRAKED | change)
            loads = phalanx("hold", HOLD_SCENE, "--to", "2000 m/s^2", "--directions", 4, *flags)["loads"]
            lines.append([question, name, *(hold_limit(loads[index]) for index in (0, 1, 3))])
            question = ""
    return table(header, lines)


def set_flags(fields):
    """Returns the `--set` flags of a command for these fields."""
    return [argument for field, value in fields.items() for argument in ("--set", f"{field}={value}")]


def hold_limit(load):
    """Returns the limit of a direction by simulation, in g, and (in brackets) the quasi-static one."""
    slips, quasi_static = load["slips"], load["quasi_static_m_s2"]
    at_least = "≥ " if slips["failed_m_s2"] is None else ""
    simulated = "–" if slips["held_m_s2"] is None else at_least + number(slips["held_m_s2"] / G, "{:.3g}")
    quasi_static = load["quasi_static"] or "–" if quasi_static is None else number(quasi_static / G, "{:.3g}")
    return f"{simulated} ({quasi_static})"


def study(scratch):
    out = scratch / "capture.csv"
    call(PHALANX, "sweep", CAPTURE_STUDY, "--out", out)
    designs = {0.0: defaultdict(list), 0.8: defaultdict(list)}
    for run in csv.DictReader(out.open()):
        designs[float(run["contact.friction.mu_static"])][int(run["design"])].append(run)
    lines, closure = [], []
    for mu, runs_by_design in designs.items():
        sized = {name: runs for name, runs in runs_by_design.items() if runs[0]["status"] != "refused"}
        completed = [run for runs in sized.values() for run in runs if run["status"] == "completed"]
        held = [run for run in completed if run["grasp"] == "held"]
        always_held = [runs for runs in sized.values() if all(run["grasp"] == "held" for run in runs)]
        ratios = [float(run["offset_ratio"]) for run in held if run["offset_ratio"]]
        form_closed = [run for run in held if run["form_closed"] == "true"]
        tts = [float(run["tts_s"]) * 1e3 for run in held if run["tts_s"]]
        quantiles = statistics.quantiles(ratios, n=10) if len(ratios) > 1 else [float("nan")] * 9
        lines.append(
            [
                f"{mu}",
                f"{len(sized)} of {len(runs_by_design)}",
                f"{len(held)} of {len(completed)}",
                f"{len(always_held)}",
                f"{sum(ratio < 1 for ratio in ratios)} of {len(ratios)}",
                f"{statistics.median(ratios):.2f} ({quantiles[0]:.2f} – {quantiles[-1]:.2f})" if ratios else "–",
                f"{len(form_closed)} of {len(held)}",
                f"{statistics.median(tts):.1f}" if tts else "–",
            ]
        )
        closure.append([f"{mu}", *form_closure_cells(sized.values())])
    header = [
        "μ_s",
        "designs that can be sized",
        "runs held at 40 ms",
        "designs held at all 8 offsets",
        "runs with a reduced offset",
        "final / initial offset: median (10 % – 90 %)",
        "form-closed at the end",
        "tts, median (ms)",
    ]
    closure_header = [
        "μ_s",
        "designs that hold a centred object",
        "form-closed with a centred object",
        "not form-closed when centred: runs held with an offset, of these form-closed",
        "form-closed when centred: runs held with an offset, of these form-closed",
    ]
    return table(header, lines) + "\n\n" + table(closure_header, closure)


def form_closure_cells(designs):
    """Returns the table cells that compare form closure with a centred and with an offset object.

    These are the numbers of designs held and form-closed with a centred object, then, for open and for form-closed
    designs, the numbers of runs held and form-closed with an offset object.
    """
    def held(runs):
        return [run for run in runs if run["status"] == "completed" and run["grasp"] == "held"]

    # Keys: whether the same design is form-closed with a centred object.
    offset_runs = {"false": [], "true": []}
    centred_form_closed = []
    for runs in designs:
        centred = held(run for run in runs if float(run["object.offset_m"]) == 0.0)
        if centred:
            centred_form_closed.append(centred[0]["form_closed"] == "true")
            offset_runs[centred[0]["form_closed"]] += held(run for run in runs if float(run["object.offset_m"]) != 0.0)

    def counts(runs):
        return f"{len(runs)}, {sum(run['form_closed'] == 'true' for run in runs)}"

    return [f"{len(centred_form_closed)}", f"{sum(centred_form_closed)}", counts(offset_runs["false"]), counts(offset_runs["true"])]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    blocks = {"grippers": scenes, "capture": capture, "capture-study": study, "hold": hold, "questions": questions}
    parser.add_argument("--only", choices=blocks, action="append")
    chosen = parser.parse_args().only or list(blocks)
    call("cargo", "build", "--release", "--locked")
    with tempfile.TemporaryDirectory() as scratch:
        for name in chosen:
            block = f"<!-- figures:begin {name} -->\n{blocks[name](Path(scratch))}\n<!-- figures:end {name} -->"
            print(block, flush=True)
            put(name, block)


if __name__ == "__main__":
    main()
