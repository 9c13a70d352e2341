"""A capture map: what becomes of an object that lies off the middle of the palm, by offset and length of the proximal phalanx.

    python capture_map.py [--out capture.png] [--offsets 29] [--designs 13]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import phalanx
from matplotlib.colors import BoundaryNorm, ListedColormap

# Design 95 but for its proximal phalanx, without friction. Starts, springs and motors are those for the largest error, for the
# gripper does not know where the object lies.
SCENE = """
kind = "gripper"
name = "design 95 with other proximal phalanges, no friction"
duration = "40 ms"
sizing = "rigid"
palm_width = "34 mm"
positioning_error = "3.5 mm"
contact.friction.mu_static = 0.0

[table]

[design]
base = "15.5 mm"
l21_fraction = 1.0
phi22 = "120 deg"
arm_ratio = 0.5
"""
FATES = ["held", "dropped", "ejected", "not grasped", "not completed"]
COLOURS = ["#2a9d8f", "#e9c46a", "#e76f51", "#b0b0b0", "#000000"]


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("capture.png"))
    parser.add_argument("--offsets", type=int, default=29)
    parser.add_argument("--designs", type=int, default=13)
    parser.add_argument("--quick", action="store_true", help="a coarse map")
    args = parser.parse_args(arguments)
    if args.quick:
        args.offsets, args.designs = 5, 3

    scene = phalanx.Scene.from_toml(SCENE, "design.toml")
    offset_m, length = np.linspace(-3.5e-3, 3.5e-3, args.offsets), np.linspace(0.4, 1.0, args.designs)
    grid = np.meshgrid(offset_m, length)
    fields = {"object.offset": grid[0].ravel(), "design.l21_fraction": grid[1].ravel()}
    found = phalanx.evaluate(scene, fields, columns=["status", "reason", "grasp", "tts_s", "x_m"])
    fate = [grasp if grasp is not None else "not completed" for grasp in found["grasp"]]
    shape = grid[0].shape
    index = np.array([FATES.index(name) for name in fate]).reshape(shape)
    rest_mm = 1e3 * found["x_m"].reshape(shape)

    figure, (map_, rest) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, layout="constrained")
    norm = BoundaryNorm(np.arange(len(FATES) + 1) - 0.5, len(FATES))
    mesh = map_.pcolormesh(1e3 * offset_m, length, index, cmap=ListedColormap(COLOURS), norm=norm, shading="nearest")
    bar = figure.colorbar(mesh, ax=map_, ticks=range(len(FATES)))
    bar.ax.set_yticklabels(FATES)
    map_.set_ylabel("proximal phalanx, as part of its range")
    map_.set_title(f"{scene.name}: {fate.count('held')} of {len(fate)} held")
    held = np.where(index == 0, rest_mm, np.nan)
    mesh = rest.pcolormesh(1e3 * offset_m, length, held, cmap="RdBu", shading="nearest", vmin=-3.5, vmax=3.5)
    figure.colorbar(mesh, ax=rest, label="where it is held, mm off the middle")
    rest.set_xlabel("where the object lies, mm off the middle")
    rest.set_ylabel("proximal phalanx, as part of its range")
    figure.savefig(args.out, dpi=120)
    print(f"{args.out}: " + ", ".join(f"{fate.count(name)} {name}" for name in FATES if name in fate))


if __name__ == "__main__":
    main()
