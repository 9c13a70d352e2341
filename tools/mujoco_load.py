#!/usr/bin/env python3
"""Loads models in MuJoCo, and compares the ends of some with those of phalanx.

    tools/mujoco_load.py DIRECTORY

Every model NAME.xml in the directory is loaded and simulated for 20 steps, in which nothing may become infinite. A file NAME.json
beside it, {"time_s": ..., "end": {"joint": position, ...}}, contains positions that MuJoCo must reach (RK4, 10 µs) to 1e-5. The exit
status is 1 if a model is refused or differs. `cargo test --test cli mujoco -- --ignored` writes such a directory.
Needs `pip install mujoco`.
"""

import json
import sys
from pathlib import Path

import mujoco
import numpy
from mujoco_beside import commands

# Largest difference of a position, rad or m. Loops are soft constraints, which yield.
TOLERANCE = 1e-5
STEP_S = 1e-5


def run(path):
    """Loads and simulates a model; returns the reason why it is refused or differs, if it is, and the difference."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        return str(error), None
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    expected = path.with_suffix(".json")
    if not expected.exists():
        mujoco.mj_step(model, data, nstep=20)
        return (None if numpy.isfinite(data.qpos).all() and numpy.isfinite(data.qvel).all() else "not finite"), None
    expected = json.loads(expected.read_text())
    model.opt.timestep = STEP_S
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.eq_solref[:] = (2 * STEP_S, 1)
    changing = commands(model)
    for _ in range(round(expected["time_s"] / STEP_S)):
        for actuator, (times, values) in changing.items():
            data.ctrl[actuator] = numpy.interp(data.time + 0.5 * STEP_S, times, values)
        mujoco.mj_step(model, data)
    differences = {}
    for k in range(model.njnt):
        joint = model.joint(k)
        if joint.name in expected["end"]:
            differences[joint.name] = abs(data.qpos[joint.qposadr[0]] - expected["end"][joint.name])
    worst = max(differences, key=differences.get)
    return (None if differences[worst] <= TOLERANCE else f"{worst} differs by {differences[worst]:.1e}"), differences[worst]


def main():
    paths = sorted(Path(sys.argv[1]).glob("*.xml"))
    failures, differences = 0, []
    for path in paths:
        reason, difference = run(path)
        if reason:
            failures += 1
            print(f"{path.name}: {reason}")
        if difference is not None:
            differences.append(difference)
    compared = f", {len(differences)} compared, largest difference {max(differences):.1e}" if differences else ""
    print(f"MuJoCo {mujoco.__version__}: {len(paths)} models, {failures} refused or different{compared}")
    return 1 if failures or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
