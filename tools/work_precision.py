#!/usr/bin/env python3
"""Measures work and precision of phalanx beside other programs, for a closing finger, a closing gripper and a grasp cycle.

    tools/work_precision.py --json FILE [--repetitions N]
    tools/plot_work_precision.py FILE --out tools/figures/work-precision.svg

The equations of the analytic model are integrated by phalanx (Rodas5P and Radau IIA) and, with clamped force laws and the exact
Jacobian, by CVODE and diffsol, from a relative tolerance of 1e-3 to 1e-10 (`benches/solvers --cases`). The solvers restart where a torque or
the motion of the palm is discontinuous in time, and have the absolute tolerances of phalanx. The engine model runs at several
tolerances. MuJoCo runs the exported model at several steps with its own contacts, with the two integrators and the stiff constraints of
tools/mujoco_beside.py; tools/mujoco_cycle.py adds the motion of the palm and the brakes in Python, whose time is included.

The error is the largest difference from phalanx with tight tolerances, at multiples of 0.1 ms: of an angle of a finger or of the object,
in rad, and of the object's position over its radius. The solvers have the median of five runs, whose torques differ by 1e-9, and the larger difference from two
references of different methods (Radau IIA at 1e-11, Rodas5P at 1e-12). Times are medians, without loading and logging. The
table is printed as Markdown.

Needs libsundials-dev (CVODE), `pip install mujoco`, and a release build of phalanx. $PHALANX and $PHALANX_SOLVERS name other programs.
"""

import argparse
import csv
import datetime
import io
import itertools
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mujoco_beside
import mujoco_cycle
from mujoco_beside import ROOT, SAMPLE_S, phalanx

SCENES = {"finger": "experiment-95", "gripper": "gripper/design-95", "cycle": "gripper/cycle"}
TITLES = {"finger": "A finger closes", "gripper": "A gripper closes on a free object", "cycle": "A grasp cycle"}
ENGINE_TOLERANCES_M = (1e-5, 1e-6, 1e-7, 1e-8)
MUJOCO_STEPS_S = (1e-3, 1e-4, 1e-5, 1e-6)
# A run of MuJoCo that takes longer is timed once, and one with more steps is left out.
SLOW_S = 1.0
MAX_MUJOCO_STEPS = 100_000
# Relative tolerances in the printed table.
SHOWN_RTOLS = (1e-4, 1e-7, 1e-10)


def scene_path(case):
    return ROOT / "scenes" / f"{SCENES[case]}.toml"


def is_angle(name):
    """Whether a column is an angle of a finger or of the object."""
    return name.endswith(("_q11_rad", "_q21_rad", "object_angle_rad")) or name in ("q11_rad", "q21_rad")


def compare(rows, exact, radius_m, until_s=float("inf")):
    """Largest differences of the angles, and of the object's position over its radius, of rows by time index."""
    angle, position = 0.0, None
    for index, row in rows.items():
        at = exact.get(index)
        if at is None or index * SAMPLE_S > until_s:
            continue
        for name, value in row.items():
            difference = abs(value - at[name])
            if is_angle(name):
                angle = max(angle, difference)
            else:
                position = max(position or 0.0, difference / radius_m)
    return angle, position


def by_index(columns):
    """Rows of compared columns, by their index on the grid of 0.1 ms."""
    names = [name for name in columns if is_angle(name) or name in ("object_x_m", "object_y_m")]
    rows = {}
    for k, t in enumerate(columns["time_s"]):
        index = round(t / SAMPLE_S)
        if abs(t - index * SAMPLE_S) < 1e-12:
            rows[index] = {name: columns[name][k] for name in names}
    return rows


def solver_rows(diagram):
    """Rows of the program in benches/solvers."""
    for row in diagram["rows"]:
        median = {key: row[key] and row[key]["median"] for key in ("angle_rad", "position")}
        worst = {f"worst_{key}": row[key] and row[key]["worst"] for key in ("angle_rad", "position")}
        cost = row["cost"] or {}
        yield {
            "method": row["method"],
            "preset": row["preset"],
            "rtol": row["rtol"],
            "setting": f"rtol {row['rtol']:.0e}",
            **median,
            **worst,
            "steps": cost.get("steps"),
            "right_hand_sides": cost.get("rhs"),
            "time_s": row["time_s"],
            "failure": row["failure"] and f"{row['failed']} of {diagram['members']} runs failed: {row['failure']}",
        }


def engine_rows(case, exact, radius_m, repetitions):
    """The engine model at several tolerances."""
    for tolerance_m in ENGINE_TOLERANCES_M:
        flags = [scene_path(case), "--no-check", "--model", "engine", "--tolerance", f"{tolerance_m * 1e6:g} um"]
        runs = [json.loads(phalanx("run", *flags, "--json")) for _ in range(repetitions)]
        angle, position = compare(by_index(columns_of(*flags)), exact, radius_m)
        yield {
            "method": "phalanx engine model",
            "preset": None,
            "setting": f"tolerance {tolerance_m:.0e} m",
            "angle_rad": angle,
            "position": position,
            "steps": runs[0]["steps"],
            "time_s": statistics.median(run["wall_s"] for run in runs),
            "failure": None,
        }


def columns_of(*flags):
    """Columns of a run, every 0.1 ms and at each event, by name."""
    header, *rows = csv.reader(io.StringIO(phalanx("run", *flags, "--numeric-rate", "10 kHz", "--csv", "-")))
    return {name: [float(row[k]) for row in rows] for k, name in enumerate(header) if rows[0][k]}


def mujoco_model(case, path, step_s, integrator, duration_s):
    """A model of MuJoCo, its data, and the function that simulates it."""
    if case == "cycle":
        cycle = mujoco_cycle.Cycle(scene_path(case), step_s, integrator)
        return cycle.model, cycle.data, lambda *record: cycle.simulate(duration_s, *record)
    phalanx("scene", "export", scene_path(case), "--mjcf", path)
    model, data = mujoco_beside.load(path, step_s, integrator, False)
    return model, data, lambda *record: mujoco_beside.simulate(model, data, duration_s, *record)


def mujoco_rows(case, exact, radius_m, first_s, repetitions):
    """MuJoCo at several steps, with two integrators."""
    import mujoco

    duration_s = max(exact) * SAMPLE_S
    steps_s = [step_s for step_s in MUJOCO_STEPS_S if duration_s / step_s < MAX_MUJOCO_STEPS]
    for integrator, step_s in itertools.product(mujoco_beside.INTEGRATORS, steps_s):
        with tempfile.TemporaryDirectory() as directory:
            model, data, simulate = mujoco_model(case, Path(directory) / "model.xml", step_s, integrator, duration_s)
        names = {model.joint(k).qposadr[0]: mujoco_beside.column_of(model.joint(k).name, exact[0]) for k in range(model.njnt)}
        compared = {address: name for address, name in names.items() if name}
        rows = {}

        def record():
            rows[round(data.time / SAMPLE_S)] = {name: float(data.qpos[address]) for address, name in compared.items()}  # noqa: B023

        simulate(record)
        angle, position = compare(rows, exact, radius_m)
        swing, _ = compare(rows, exact, radius_m, first_s - SAMPLE_S)
        seconds = []
        while len(seconds) < repetitions and not (seconds and seconds[-1] > SLOW_S):
            mujoco.mj_resetDataKeyframe(model, data, 0)
            start = time.perf_counter()
            simulate()
            seconds.append(time.perf_counter() - start)
        yield {
            "method": f"MuJoCo {integrator}",
            "preset": None,
            "setting": f"step {step_s:.0e} s",
            "angle_rad": angle,
            "position": position,
            "before_contact_rad": swing,
            "steps": round(duration_s / step_s),
            "time_s": statistics.median(seconds),
            "failure": None,
        }


def measure(case, diagram, repetitions):
    """All rows of one case."""
    exact = by_index(columns_of(scene_path(case), "--preset", "reference", "--no-check"))
    run = json.loads(phalanx("run", scene_path(case), "--preset", "reference", "--json", "--no-check"))
    surfaces = [contact for contact in run["contacts"].values() if "final_normal_n" in contact]
    # The object may lie on the palm or the table from the start.
    first_s = min(contact["first_s"] for contact in surfaces if contact["first_s"])
    radius_m = diagram["object_radius_m"]
    rows = [*solver_rows(diagram), *engine_rows(case, exact, radius_m, repetitions)]
    rows += mujoco_rows(case, exact, radius_m, first_s, repetitions)
    return {
        "case": case,
        "title": TITLES[case],
        "scene": SCENES[case],
        "duration_s": diagram["duration_s"],
        "first_contact_s": first_s,
        "floor_angle_rad": diagram["floor_angle_rad"],
        "floor_position": diagram["floor_position"],
        "rows": rows,
    }


def cells(row):
    """Error and time of a row in the printed table."""
    if row is None:
        return ["–", "–"]
    if row["failure"]:
        return [row["failure"].partition(":")[0].replace("runs ", ""), "–"]
    errors = f"{row['angle_rad']:.1e}"
    if row["position"] is not None:
        errors += f" / {row['position']:.1e}"
    if row.get("before_contact_rad") is not None:
        errors += f" (before contact {row['before_contact_rad']:.1e})"
    return [errors, f"{row['time_s'] * 1e3:.3g}" if row["time_s"] else "–"]


def table(diagrams):
    """Markdown of all cases, one row per method and setting."""
    by_setting = {}
    for diagram in diagrams:
        for row in diagram["rows"]:
            if row.get("rtol") in (None, *SHOWN_RTOLS) or row["preset"]:
                setting = f"preset `{row['preset']}`" if row["preset"] else row["setting"]
                by_setting.setdefault((row["method"], setting), {})[diagram["case"]] = row
    header = ["method", "setting"]
    for diagram in diagrams:
        header += [f"{diagram['case']}: error", "time (ms)"]
    lines = ["| " + " | ".join(header) + " |", "|---" * len(header) + "|"]
    for (method, setting), rows in by_setting.items():
        columns = [cell for diagram in diagrams for cell in cells(rows.get(diagram["case"]))]
        lines.append("| " + " | ".join([method, setting, *columns]) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, required=True, help="write the results to this file")
    parser.add_argument("--repetitions", type=int, default=9, help="runs that are timed")
    parser.add_argument("--cases", nargs="+", choices=SCENES, default=list(SCENES))
    options = parser.parse_args()
    try:
        import mujoco
    except ImportError:
        sys.exit("this comparison needs MuJoCo: pip install mujoco")
    build = ["cargo", "run", "--release", "--quiet", "--features", "cvode", "--manifest-path", ROOT / "benches" / "solvers" / "Cargo.toml", "--"]
    solvers = [os.environ["PHALANX_SOLVERS"]] if "PHALANX_SOLVERS" in os.environ else build
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "solvers.json"
        command = [*solvers, "--repetitions", options.repetitions, "--json", path, "--cases", *options.cases]
        subprocess.run([str(part) for part in command], check=True)
        diagrams = json.loads(path.read_text())
    result = {
        "date": datetime.date.today().isoformat(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "mujoco": mujoco.__version__,
        "cases": [measure(case, diagram, options.repetitions) for case, diagram in zip(options.cases, diagrams)],
    }
    options.json.write_text(json.dumps(result, indent=1) + "\n")
    print(table(result["cases"]))
    failures = {f"{row['method']}, {row['setting']}, {diagram['case']}: {row['failure']}" for diagram in result["cases"] for row in diagram["rows"] if row["failure"]}
    print("", *sorted(failures), sep="\n")
    print(f"\n{phalanx('--version').strip()}, MuJoCo {result['mujoco']}, {result['machine']}, {result['date']}.")


if __name__ == "__main__":
    main()
