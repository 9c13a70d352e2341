"""A capture map: the fate of an off-centre object, by its offset and the length of the proximal phalanx.

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

# Design 95 with other proximal phalanges, without friction. Initial angles, springs and motors are sized for the
# largest positioning error, because a gripper does not know the position of the object.
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
    table = phalanx.evaluate(scene, fields, columns=["status", "reason", "grasp", "tts_s", "x_m"])
    fates = [fate if fate is not None else "not completed" for fate in table["grasp"]]
    shape = grid[0].shape
    fate_index = np.array([FATES.index(fate) for fate in fates]).reshape(shape)
    final_mm = 1e3 * table["x_m"].reshape(shape)

    figure, (fate_axes, position_axes) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, layout="constrained")
    norm = BoundaryNorm(np.arange(len(FATES) + 1) - 0.5, len(FATES))
    mesh = fate_axes.pcolormesh(1e3 * offset_m, length, fate_index, cmap=ListedColormap(COLOURS), norm=norm, shading="nearest")
    bar = figure.colorbar(mesh, ax=fate_axes, ticks=range(len(FATES)))
    bar.ax.set_yticklabels(FATES)
    fate_axes.set_ylabel("length of the proximal phalanx, fraction of its range")
    fate_axes.set_title(f"{scene.name}: {fates.count('held')} of {len(fates)} held")
    held_mm = np.where(fate_index == 0, final_mm, np.nan)
    mesh = position_axes.pcolormesh(1e3 * offset_m, length, held_mm, cmap="RdBu", shading="nearest", vmin=-3.5, vmax=3.5)
    figure.colorbar(mesh, ax=position_axes, label="final offset of a held object, mm")
    position_axes.set_xlabel("initial offset of the object, mm")
    position_axes.set_ylabel("length of the proximal phalanx, fraction of its range")
    figure.savefig(args.out, dpi=120)
    print(f"{args.out}: " + ", ".join(f"{fates.count(name)} {name}" for name in FATES if name in fates))


if __name__ == "__main__":
    main()
