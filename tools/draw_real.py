#!/usr/bin/env python3
"""Draws the scenes of real grippers: their outlines at the start (grey) and at the end.

usage: draw_real.py OUT.svg [SCENE.toml ...]      (needs tools/requirements.txt; default: all of scenes/real)

Runs each scene with `phalanx` (from $PHALANX or target/release).
"""

import csv
import io
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from dark_scheme import add_dark_scheme
from draw_closing import BACKGROUND, COUPLER, DARK, DISTAL, GREY, OBJECT, PALM, TEXT, quantity

ROOT = Path(__file__).resolve().parent.parent
PHALANX = os.environ.get("PHALANX", str(ROOT / "target/release/phalanx"))
COLUMNS = 3
# The view of a scene leaves out what is this much further from its bodies than they are large.
MARGIN_MM = 8.0


def call(*arguments: str) -> str:
    """Returns the output of a command of phalanx."""
    return subprocess.run([PHALANX, *arguments], check=True, capture_output=True, text=True).stdout


def arc(centre, radius: float, start: float, turn: float) -> np.ndarray:
    """Returns points on an arc, in mm and rad."""
    angles = start + np.linspace(0.0, turn, 2 + int(40 * abs(turn) / (2 * np.pi)))
    return np.asarray(centre) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def outline(settings: dict) -> np.ndarray | None:
    """Returns the corners of an outline in the frame of its body, in mm; None for a half plane."""
    length = lambda pair: np.array([quantity(value) for value in pair])
    radius = quantity(settings["radius"]) if "radius" in settings else quantity(settings.get("rounding", "0 mm"))
    match settings["type"]:
        case "disc":
            return arc(length(settings["center"]), radius, 0.0, 2 * np.pi)
        case "capsule":
            core = np.array([length(settings["from"]), length(settings["to"])])
        case "ellipse":
            a, b = length(settings["semi_axes"])
            turn = quantity(settings["angle"])
            points = arc((0.0, 0.0), 1.0, 0.0, 2 * np.pi) * [a, b]
            rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            return points @ rotation + length(settings["center"])
        case "polygon":
            core = np.array([length(corner) for corner in settings["vertices"]])
        case _:
            return None
    sides = np.roll(core, -1, axis=0) - core
    normals = np.arctan2(-sides[:, 0], sides[:, 1])
    turns = (normals - np.roll(normals, 1)) % (2 * np.pi)
    return np.concatenate([arc(core[k], radius, normals[k] - turns[k], turns[k]) for k in range(len(core))])


def draw(axes, path: Path) -> None:
    """Draws a scene at its start and at its end."""
    scene = tomllib.loads(call("scene", "show", str(path), "--resolved"))
    rows = list(csv.DictReader(io.StringIO(call("run", str(path), "--csv", "-", "--no-check", "--quiet"))))
    touching = {name for contact in scene.get("contacts", []) for name in (contact["points"], contact["face"])}
    has_free_body = any("start" in body for body in scene["bodies"].values())
    points = []
    for name, settings in scene.get("ground", {}).get("outlines", {}).items():
        shape = outline(settings)
        if shape is None:
            edge, normal = [quantity(value) for value in settings["point"]], np.array(settings["normal"])
            along = np.array([normal[1], -normal[0]]) * 300.0
            corners = np.array([edge - along, edge + along, edge + along - 300 * normal, edge - along - 300 * normal])
            axes.fill(*corners.T, color=PALM, zorder=0)
        else:
            axes.fill(*shape.T, facecolor=PALM if has_free_body else OBJECT, edgecolor=GREY, linewidth=0.6)
            points.append(shape)
    for row, is_end in ((rows[0], False), (rows[-1], True)):
        for name, body in scene["bodies"].items():
            turn = float(row[f"{name}_angle_rad"])
            rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            origin = 1e3 * np.array([float(row[f"{name}_x_m"]), float(row[f"{name}_y_m"])])
            for key, settings in body.get("outlines", {}).items():
                corners = outline(settings) @ rotation + origin
                points.append(corners)
                fill = OBJECT if "start" in body else DISTAL if f"{name}.{key}" in touching else COUPLER
                style = {"facecolor": fill, "edgecolor": TEXT, "linewidth": 0.7} if is_end else {"fill": False, "edgecolor": GREY, "linewidth": 0.5}
                axes.fill(*corners.T, zorder=2 + is_end, **style)
    low, high = np.min(np.concatenate(points), axis=0) - MARGIN_MM, np.max(np.concatenate(points), axis=0) + MARGIN_MM
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.set_title(path.stem, fontsize=10, color=TEXT)
    axes.set_xlabel(f"{high[0] - low[0] - 2 * MARGIN_MM:.0f} mm wide, {1e3 * float(rows[-1]['time_s']):.0f} ms", fontsize=8, color=GREY)
    for side in axes.spines.values():
        side.set_color(GREY)


def main() -> None:
    target, *scenes = sys.argv[1:]
    paths = [Path(scene) for scene in scenes] or sorted((ROOT / "scenes/real").glob("*.toml"))
    lines = -(-len(paths) // COLUMNS)
    figure, grid = plt.subplots(lines, COLUMNS, figsize=(9.6, 3.3 * lines), squeeze=False, facecolor=BACKGROUND)
    for axes, path in zip(grid.flat, paths):
        draw(axes, path)
    for axes in list(grid.flat)[len(paths) :]:
        axes.set_axis_off()
    figure.tight_layout()
    figure.savefig(target, metadata={"Date": None})
    add_dark_scheme(Path(target), DARK)


if __name__ == "__main__":
    main()
