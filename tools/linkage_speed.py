#!/usr/bin/env python3
"""Measures speed against error of phalanx and MuJoCo for four linkages, and draws them.

    tools/linkage_speed.py --json FILE --out tools/figures/linkage-speed.svg [--repetitions N]
    tools/linkage_speed.py --from FILE --out PICTURE

Each panel is a scene: time per simulated second over the largest error along the run, the larger one of angles (rad) and positions
(parts of 20 mm), from `--preset reference`. phalanx runs at five relative tolerances and with its presets, MuJoCo (implicitfast) at
steps of 2, 0.5, 0.1 and 0.01 ms, with its default softness of constraints and with the stiffest that the step allows. MuJoCo has the
same linkage, but contacts, limits and friction of its own: beyond the first contact its error contains their difference.
Needs `pip install mujoco`, tools/requirements.txt, and a release build of phalanx ($PHALANX names another program).
"""

import argparse
import datetime
import json
import os
import platform
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from dark_scheme import add_dark_scheme  # noqa: E402
from matplotlib.ticker import LogLocator  # noqa: E402
from mujoco_beside import ROOT, mujoco_rows, own_row, reference_of  # noqa: E402

# The same data gives the same bytes.
plt.rcParams["svg.hashsalt"] = "phalanx"
plt.rcParams["svg.fonttype"] = "none"
plt.rcParams["font.family"] = "sans-serif"

SCENES = ["real/2f85-lift", "mechanisms/two-pivot", "real/franka-lift", "mechanisms/gripper-box"]
MUJOCO_STEPS_S = (2e-3, 5e-4, 1e-4, 1e-5)
RTOLS = (1e-2, 1e-3, 1e-5, 1e-7, 1e-9)
PRESETS = ("draft", "engineering")
UNIT_M = 0.02
STYLES = {
    "phalanx": dict(color="#0072b2", marker="o", linewidth=2.2),
    "MuJoCo, stiff constraints": dict(color="#666666", marker="P", linewidth=1.2, linestyle=":"),
    "MuJoCo, default constraints": dict(color="#d55e00", marker="X", linewidth=1.2, linestyle="-."),
}
DARK = {"#ffffff": "#1b1f26", "#000000": "#eceff3", "#666666": "#a7b0bd", "#e6e6e6": "#3a424e", "#0072b2": "#56b4e9", "#d55e00": "#ff9a52"}
# A larger error means that the motion has nothing to do with the exact one.
LARGEST_ERROR = 10.0


def error(row):
    """The larger error of a row, or None where the motion diverges."""
    parts = [row["run_rad"], None if row["run_m"] is None else row["run_m"] / UNIT_M]
    largest = max(part for part in parts if part is not None)
    return largest if 0 < largest < LARGEST_ERROR else None


def measure(name, repetitions):
    """Rows of one scene."""
    scene = ROOT / "scenes" / f"{name}.toml"
    exact = reference_of(scene)
    rows, columns = [], None
    for method, published in [("MuJoCo, stiff constraints", False), ("MuJoCo, default constraints", True)]:
        settings = {"integrators": ("implicitfast",), "steps": MUJOCO_STEPS_S, "published": published, "repetitions": repetitions}
        found, columns = mujoco_rows(scene, exact, None, **settings)
        rows += [{**row, "method": method, "setting": f"{row['step_s'] * 1e3:g} ms"} for row in found]
    flags = {f"rtol {rtol:.0e}": ["--rtol", f"{rtol:g}"] for rtol in RTOLS} | {preset: ["--preset", preset] for preset in PRESETS}
    for setting, flag in flags.items():
        rows.append({**own_row(scene, exact, columns, flag, repetitions), "method": "phalanx", "setting": setting})
    return {"scene": name, "duration_s": exact[0]["time_s"][-1], "rows": rows}


def draw(cases):
    """Returns the figure."""
    figure, panels = plt.subplots(1, len(cases), figsize=(3.6 * len(cases), 4.2), layout="constrained", sharey=True)
    for axes, case in zip(panels, cases):
        for method, style in STYLES.items():
            points = [(error(row), row["time_s"] / case["duration_s"], row["setting"]) for row in case["rows"] if row["method"] == method]
            points = [point for point in points if point[0]]
            line = [point[:2] for point in points if point[2] not in PRESETS]
            axes.plot(*zip(*line), markersize=6, **style)
            for at, time, _ in (point for point in points if point[2] in PRESETS):
                axes.plot(at, time, marker="*", color="black", markersize=11, linestyle="none", zorder=5)
        axes.set(xscale="log", yscale="log")
        axes.set_title(Path(case["scene"]).name, fontsize=11)
        axes.xaxis.set_major_locator(LogLocator(numticks=7))
        axes.tick_params(which="minor", left=False, bottom=False)
        axes.grid(True, which="major", color="0.9")
        axes.set_axisbelow(True)
    panels[0].set_ylabel("time per simulated second (s)")
    # Centred below all panels.
    panels[1].set_xlabel("largest error along the run (rad, or parts of 20 mm)", x=1.05)
    marks = [plt.Line2D([], [], label=method, markersize=6, **style) for method, style in STYLES.items()]
    marks.append(plt.Line2D([], [], label="presets draft, engineering", marker="*", color="black", markersize=11, linestyle="none"))
    figure.legend(handles=marks, loc="outside lower center", ncols=4, fontsize=10, frameon=False)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--from", dest="source", type=Path, help="draw these figures, and measure nothing")
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--out", type=Path, help="picture (.svg, .png)")
    parser.add_argument("--repetitions", type=int, default=15, help="runs that are timed (default: 15)")
    arguments = parser.parse_args()
    if arguments.source:
        found = json.loads(arguments.source.read_text())
    else:
        cases = [measure(name, arguments.repetitions) for name in SCENES]
        found = {"date": str(datetime.date.today()), "machine": f"{os.cpu_count()} cores, {platform.machine()}", "cases": cases}
    if arguments.json:
        arguments.json.write_text(json.dumps(found, indent=1) + "\n")
    for case in found["cases"]:
        print(f"\n{case['scene']}, {case['duration_s'] * 1e3:g} ms\n\n| program | setting | largest error | time |\n|---|---|---|---|")
        for row in case["rows"]:
            of = error(row)
            print(f"| {row['method']} | {row['setting']} | {f'{of:.1e}' if of else 'diverges'} | {row['time_s'] * 1e3:.3g} ms |")
    if arguments.out:
        metadata = {"Date": None} if arguments.out.suffix == ".svg" else None
        draw(found["cases"]).savefig(arguments.out, metadata=metadata, dpi=130)
        if arguments.out.suffix == ".svg":
            add_dark_scheme(arguments.out, DARK)


if __name__ == "__main__":
    main()
