"""Draws a work-precision diagram from the JSON of the benchmark in benches/solvers.

It shows the median time of a closing over its median angle error, for phalanx's integrators and published solvers.

    cargo run --release --manifest-path benches/solvers/Cargo.toml -- --json solvers.json
    .venv/bin/python tools/plot_work_precision.py solvers.json --out tools/figures/work-precision.svg

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

# The same data gives the same bytes.
plt.rcParams["svg.hashsalt"] = "phalanx"
plt.rcParams["svg.fonttype"] = "none"
plt.rcParams["font.family"] = "sans-serif"

STYLES = {
    "phalanx Rodas5P": dict(color="#0072b2", marker="o", linewidth=2.2),
    "phalanx Radau IIA 5": dict(color="#d55e00", marker="s", linewidth=2.2),
    "differential-equations Radau5": dict(color="#009e73", marker="^", linewidth=1.2, linestyle="--"),
    "numeris RODAS4": dict(color="#cc79a7", marker="v", linewidth=1.2, linestyle="--"),
    "diffsol BDF": dict(color="#8c6d00", marker="D", linewidth=1.2, linestyle="--"),
}
# Dark scheme: each colour with its replacement on a dark background, as in the other figures.
DARK = {
    "#ffffff": "#1b1f26", "#000000": "#eceff3", "#666666": "#a7b0bd", "#8c8c8c": "#7f8998", "#e6e6e6": "#3a424e", "#0072b2": "#56b4e9",
    "#d55e00": "#ff9a52", "#009e73": "#3ccb9c", "#cc79a7": "#dd95c7", "#8c6d00": "#e3b84a",
}
TARGETS = [(1e-4, 0.3), (1e-6, 0.5)]  # rad, ms


def series(rows, method):
    """Returns (error, time in ms, whether all runs are correct) for each tolerance of a method, loosest first."""
    points = [r for r in rows if r["method"] == method and r["preset"] is None]
    points.sort(key=lambda r: -r["rtol"])
    return [
        (r["errors"]["angle_median_rad"], r["time"]["median_s"] * 1e3, r["errors"]["right"] == r["errors"]["of"])
        for r in points
        if r["errors"]["angle_median_rad"]
    ]


def draw(comparison):
    """Returns the diagram."""
    rows = comparison["rows"]
    figure, axes = plt.subplots(figsize=(9.0, 5.2), layout="constrained")
    for method in dict.fromkeys(r["method"] for r in rows):
        points = series(rows, method)
        if not points:
            continue
        style = dict(STYLES.get(method, dict(marker="x", linewidth=1.0)))
        errors, times, _ = zip(*points)
        (line,) = axes.plot(errors, times, label=method, markersize=6, **style)
        for error, time, all_correct in points:
            face = line.get_color() if all_correct else "white"
            axes.plot(error, time, marker=style["marker"], color=line.get_color(), markerfacecolor=face, markersize=6)
    for row in rows:
        if row["preset"]:
            point = (row["errors"]["angle_median_rad"], row["time"]["median_s"] * 1e3)
            axes.plot(*point, marker="*", color="black", markersize=13, linestyle="none", zorder=5)
            axes.annotate(row["preset"], point, xytext=(10, 5), textcoords="offset points", fontsize=9)
    for error, time in TARGETS:
        axes.plot([error / 3, error * 3], [time, time], color="0.55", linewidth=4, solid_capstyle="butt", zorder=0)
        label = f"{time} ms"
        axes.annotate(label, (error, time), xytext=(0, -12), textcoords="offset points", fontsize=8, color="0.4", ha="center")
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("largest angle error along the closing, median of 15 (rad)")
    axes.set_ylabel("time of one 20 ms closing, median (ms)")
    axes.grid(True, which="major", color="0.9")
    axes.set_axisbelow(True)
    axes.plot([], [], marker="o", color="0.4", markerfacecolor="white", linestyle="none", label="not all 15 runs right")
    axes.plot([], [], marker="*", color="black", markersize=11, linestyle="none", label="named preset")
    axes.plot([], [], color="0.55", linewidth=4, label="target")
    figure.legend(loc="outside right center", fontsize=9, frameon=False)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figures", type=Path, help="JSON of the benchmark")
    parser.add_argument("--out", type=Path, default=Path("tools/figures/work-precision.svg"))
    arguments = parser.parse_args()
    try:
        comparison = json.loads(arguments.figures.read_text())
    except (OSError, ValueError) as error:
        sys.exit(f"cannot read {arguments.figures}: {error}")
    comparison = comparison.get("comparison", comparison)
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    metadata = {"Date": None} if arguments.out.suffix == ".svg" else None
    draw(comparison).savefig(arguments.out, metadata=metadata, dpi=130)
    if arguments.out.suffix == ".svg":
        add_dark_scheme(arguments.out, DARK)


if __name__ == "__main__":
    main()
