"""Draws the work-precision diagrams from the results of tools/work_precision.py.

Each panel shows the time of a run over its error, for phalanx's integrators and engine model, published solvers and MuJoCo.

    .venv/bin/python tools/plot_work_precision.py work-precision.json --out tools/figures/work-precision.svg

Needs tools/requirements.txt. The suffix of --out chooses the format (.svg, .png).
"""

import argparse
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from dark_scheme import add_dark_scheme  # noqa: E402
from matplotlib.ticker import LogLocator  # noqa: E402

# The same data gives the same bytes.
plt.rcParams["svg.hashsalt"] = "phalanx"
plt.rcParams["svg.fonttype"] = "none"
plt.rcParams["font.family"] = "sans-serif"

STYLES = {
    "phalanx Rodas5P": dict(color="#0072b2", marker="o", linewidth=2.2),
    "phalanx Radau IIA 5": dict(color="#d55e00", marker="s", linewidth=2.2),
    "phalanx engine model": dict(color="#009e73", marker="^", linewidth=2.2),
    "CVODE BDF": dict(color="#cc79a7", marker="v", linewidth=1.2, linestyle="--"),
    "diffsol BDF": dict(color="#8c6d00", marker="D", linewidth=1.2, linestyle="--"),
    "MuJoCo implicitfast": dict(color="#666666", marker="P", linewidth=1.2, linestyle=":"),
    "MuJoCo RK4": dict(color="#666666", marker="X", linewidth=1.2, linestyle="-."),
}
# Dark scheme: each colour with its replacement on a dark background, as in the other figures.
DARK = {
    "#ffffff": "#1b1f26", "#000000": "#eceff3", "#666666": "#a7b0bd", "#e6e6e6": "#3a424e", "#0072b2": "#56b4e9",
    "#d55e00": "#ff9a52", "#009e73": "#3ccb9c", "#cc79a7": "#dd95c7", "#8c6d00": "#e3b84a",
}


def error(row):
    """The larger of both errors of a row."""
    return max(row["angle_rad"], row["position"] or 0.0)


def draw_panel(axes, case):
    """Draws one case."""
    rows = [row for row in case["rows"] if row["time_s"] and row["angle_rad"]]
    for method, style in STYLES.items():
        of_method = [row for row in rows if row["method"] == method and not row["preset"]]
        points = [(error(row), row["time_s"] * 1e3) for row in of_method]
        if points:
            axes.plot(*zip(*points), markersize=6, **style)
        before = [(row["before_contact_rad"], row["time_s"] * 1e3) for row in of_method if row.get("before_contact_rad")]
        if before:
            axes.plot(*zip(*before), markersize=6, markerfacecolor="white", **(style | {"linewidth": 0.8}))
    for row in rows:
        if row["preset"]:
            axes.plot(error(row), row["time_s"] * 1e3, marker="*", color="black", markersize=12, linestyle="none", zorder=5)
    axes.set(xscale="log", yscale="log")
    axes.set_title(f"{case['title']}, {case['duration_s'] * 1e3:g} ms", fontsize=11)
    axes.xaxis.set_major_locator(LogLocator(numticks=7))
    axes.tick_params(which="minor", left=False, bottom=False)
    axes.grid(True, which="major", color="0.9")
    axes.set_axisbelow(True)


def draw(cases):
    """Returns the figure."""
    figure, panels = plt.subplots(1, len(cases), figsize=(4.0 * len(cases), 4.9), layout="constrained")
    for axes, case in zip(panels, cases):
        draw_panel(axes, case)
    panels[0].set_ylabel("time of one run (ms)")
    panels[len(panels) // 2].set_xlabel("largest error along the run (angles in rad, position of the object over its radius)")
    marks = [plt.Line2D([], [], label=method, markersize=6, **style) for method, style in STYLES.items()]
    hollow = dict(STYLES["MuJoCo implicitfast"], markerfacecolor="white", linewidth=0.8)
    marks.append(plt.Line2D([], [], label="MuJoCo, before the first contact", markersize=6, **hollow))
    marks.append(plt.Line2D([], [], label="presets engineering, reference", marker="*", color="black", markersize=11, linestyle="none"))
    figure.legend(handles=marks, loc="outside lower center", ncols=3, fontsize=10, frameon=False)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figures", type=Path, help="results of tools/work_precision.py")
    parser.add_argument("--out", type=Path, default=Path("tools/figures/work-precision.svg"))
    arguments = parser.parse_args()
    try:
        cases = json.loads(arguments.figures.read_text())["cases"]
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"cannot read {arguments.figures}: {error}")
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    metadata = {"Date": None} if arguments.out.suffix == ".svg" else None
    draw(cases).savefig(arguments.out, metadata=metadata, dpi=130)
    if arguments.out.suffix == ".svg":
        add_dark_scheme(arguments.out, DARK)


if __name__ == "__main__":
    main()
