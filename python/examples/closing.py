"""A closing in four plots: angles, normal forces, energies, and the error of the energy balance.

    python closing.py [--out closing.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import phalanx

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("closing.png"))
    parser.add_argument("--quick", action="store_true", help="simulate half the duration")
    args = parser.parse_args(arguments)

    result = phalanx.run(SCENES / "experiment-95.toml", duration="10 ms" if args.quick else None, check=True)
    ms = 1e3 * result.time
    figure, ((angles, forces), (energies, balance)) = plt.subplots(2, 2, figsize=(10, 7), sharex=True, layout="constrained")
    for name in ("q11_rad", "q21_rad", "q22_rad"):
        angles.plot(ms, np.degrees(result[name]), label=name.removesuffix("_rad"))
    angles.set_ylabel("angle, deg")
    for name in ("proximal", "distal"):
        forces.plot(ms, result[f"{name}_normal_n"], label=name)
    forces.set_ylabel("normal force, N")
    # Impact forces are a hundred times the final ones, so a linear scale would hide the latter.
    forces.set_yscale("symlog", linthresh=10)
    for name in ("kinetic", "spring", "dissipated", "motor_work"):
        energies.plot(ms, 1e3 * result[f"{name}_j"], label=name.replace("_", " "))
    energies.set_ylabel("energy, mJ")
    balance.plot(ms, 1e6 * result["balance_j"], color="tab:red", label="balance")
    balance.set_ylabel("error of the energy balance, µJ")
    for event in result.events:
        if event.kind == "touch-down" and event.time_s > 0:
            for axes in (angles, forces, energies, balance):
                axes.axvline(1e3 * event.time_s, color="0.85", zorder=0)
    for axes in (angles, forces, energies, balance):
        axes.legend(frameon=False)
    for axes in (energies, balance):
        axes.set_xlabel("time, ms")
    criteria, check = result.criteria or {}, result.check or {}
    tts_s = criteria.get("tts_s")
    tts = f"stable from {1e3 * tts_s:.3f} ms on" if tts_s else "not stable"
    figure.suptitle(f"{result.summary['scene']}: {criteria.get('class')}, {tts}; check: {check.get('verdict')}")
    figure.savefig(args.out, dpi=120)
    print(f"{args.out}: {len(result.time)} samples, {len(result.events)} events, {tts}")


if __name__ == "__main__":
    main()
