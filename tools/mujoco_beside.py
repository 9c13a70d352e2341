#!/usr/bin/env python3
"""Simulates a scene with MuJoCo and with phalanx, and prints time and difference of both.

    tools/mujoco_beside.py [SCENE] [--json FILE] [--repetitions N] [--steps S ...] [--published]
    tools/mujoco_beside.py MODEL.xml [--root BODY] [--branch BODY ...] [--plane PLANE] [--ctrl NAME=VALUE ...] [--duration S] [--json FILE]

SCENE is any scene file (default: scenes/experiment-95.toml). `phalanx scene export` writes its MuJoCo model: the same bodies, joints,
springs and actuators. Loops are `connect` constraints, and contacts, limits and friction are MuJoCo's own: soft constraints with the
shortest time constant that the time step allows (solref = 2 time steps), or with MuJoCo's default (--published). MuJoCo does not have
the contact laws of the scene. Therefore the table has two differences of the joint angles: that of the motion up to 0.1 ms before the
first contact, in which only loops, limits and integration differ, and that of the whole run. Free bodies and sliders have a column of
their own. The reference is phalanx with `--preset reference`. Times are medians of one run, without loading.

MODEL.xml (or .urdf) is a model of MuJoCo. The Python package converts it into a scene. The table has the largest differences of its joint
coordinates from those of MuJoCo, in free motion without contacts, limits and friction: with the model as published, and with its planar
copy with rigid equalities, by Euler and by RK4 with 10 µs.
Needs `pip install mujoco` and a release build of phalanx ($PHALANX names another program); for models, also the Python package.
"""

import argparse
import csv
import importlib.util
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PHALANX = os.environ.get("PHALANX", str(ROOT / "target" / "release" / "phalanx"))
# Default time steps of MuJoCo, s.
STEPS_S = (1e-4, 1e-5, 1e-6)
INTEGRATORS = ("implicitfast", "RK4")
# Interval of the compared samples, s.
SAMPLE_S = 1e-4


def phalanx(*arguments):
    """Standard output of a phalanx command."""
    result = subprocess.run([PHALANX, *map(str, arguments)], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        sys.exit(f"phalanx {' '.join(map(str, arguments))} failed: {result.stderr}")
    return result.stdout


def trajectory(scene, *flags):
    """Columns of a run of the analytic model, every 0.1 ms and at each event, by name."""
    text = phalanx("run", scene, *flags, "--no-check", "--numeric-rate", "10 kHz", "--csv", "-")
    header, *rows = csv.reader(io.StringIO(text))
    return {name: [float(row[k]) for row in rows] for k, name in enumerate(header) if rows[0][k]}


def column_of(joint, columns):
    """Name of the column with the position of a MuJoCo joint, if there is one."""
    body, _, axis = joint.partition(".")
    names = [f"{joint}_rad", f"{joint}_angle_rad", f"{joint}_position_m", f"{body}_{axis}_m", f"{body}_{axis}_rad"]
    return next((name for name in names if name in columns), None)


def load(path, step_s, integrator, published):
    """The model with this step and integrator, and its start."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = step_s
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    # Defaults of MuJoCo, or the stiffest constraints that the step allows.
    for solref in (model.eq_solref, model.pair_solref, model.jnt_solref):
        solref[:] = (0.02, 1) if published else (2 * step_s, 1)
    for solimp in (model.eq_solimp, model.pair_solimp, model.jnt_solimp):
        solimp[:, :3] = (0.9, 0.95, 0.001)
    if not published:
        model.eq_solimp[:, :3] = (0.99, 0.9999, 1e-5)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


def commands(model):
    """Times and control signals of the actuators whose command changes over time, by the index of the actuator."""
    import mujoco

    numbers = {}
    for k in range(model.nnumeric):
        first, size = model.numeric_adr[k], model.numeric_size[k]
        numbers[mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_NUMERIC, k)] = model.numeric_data[first : first + size]
    names = {mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, k): k for k in range(model.nu)}
    return {k: (numbers[f"{name}.times"], numbers[f"{name}.commands"]) for name, k in names.items() if f"{name}.times" in numbers}


def simulate(model, data, duration_s, record=lambda: None):
    """Runs to the end, and calls `record` every 0.1 ms."""
    import mujoco
    import numpy

    stride = max(1, round(SAMPLE_S / model.opt.timestep))
    changing = commands(model)
    for _ in range(0, round(duration_s / model.opt.timestep), stride):
        if changing:
            for _ in range(stride):
                for actuator, (times, values) in changing.items():
                    data.ctrl[actuator] = numpy.interp(data.time, times, values)
                mujoco.mj_step(model, data)
        else:
            mujoco.mj_step(model, data, nstep=stride)
        record()


def differences(times, found, exact, joints, first_s):
    """Largest differences of angles before the first contact and in all, and of positions; None where there is nothing to compare."""
    import numpy

    result = {"swing_rad": None, "run_rad": None, "run_m": None}
    before = numpy.array(times) < first_s - 1e-4
    for k, column in joints.items():
        difference = numpy.abs(numpy.array([row[k] for row in found]) - numpy.interp(times, exact["time_s"], exact[column]))
        pairs = {"run_m": difference} if column.endswith("_m") else {"run_rad": difference, "swing_rad": difference[before]}
        for key, values in pairs.items():
            if len(values) > 0:
                result[key] = max(result[key] or 0.0, float(values.max()))
    return result


def first_touch_s(scene, duration_s):
    """Time of the first contact of two surfaces: limits of joints are often touched at the start."""
    run = json.loads(phalanx("run", scene, "--preset", "reference", "--json", "--no-check"))
    surfaces = [contact for contact in run["contacts"].values() if "final_normal_n" in contact]
    return min((contact["first_s"] for contact in surfaces if contact["first_s"] is not None), default=duration_s)


def reference_of(scene):
    """Columns of the reference, and the time of the first contact of two surfaces."""
    reference = trajectory(scene, "--preset", "reference")
    return reference, first_touch_s(scene, reference["time_s"][-1])


def mujoco_rows(scene, exact, only, *, integrators=INTEGRATORS, steps=STEPS_S, published=False, repetitions=9):
    """Rows of MuJoCo with its integrators and time steps: errors of the columns `only` (all if empty), and the time of a run.

    `exact` is the reference with its first contact. Also returns the compared columns of the reference.
    """
    import mujoco

    (reference, first_s), rows = exact, []
    duration_s = reference["time_s"][-1]
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "model.xml"
        print(phalanx("scene", "export", scene, "--mjcf", path).partition("\n")[2], end="", file=sys.stderr)
        for integrator in integrators:
            for step_s in steps:
                model, data = load(path, step_s, integrator, published)
                addresses = {model.joint(k).name: model.joint(k).qposadr[0] for k in range(model.njnt)}
                columns = {address: column_of(name, reference) for name, address in addresses.items()}
                joints = {address: column for address, column in columns.items() if column in (only or reference)}
                times, found = [], []
                simulate(model, data, duration_s, lambda: (times.append(data.time), found.append(data.qpos.copy())))  # noqa: B023
                seconds = []
                for _ in range(repetitions):
                    mujoco.mj_resetDataKeyframe(model, data, 0)
                    start = time.perf_counter()
                    simulate(model, data, duration_s)
                    seconds.append(time.perf_counter() - start)
                rows.append({
                    "method": f"MuJoCo {mujoco.__version__}, {integrator}",
                    "step_s": step_s,
                    **differences(times, found, reference, joints, first_s),
                    "time_s": statistics.median(seconds),
                })
    return rows, list(joints.values())


def own_row(scene, exact, columns, flags, repetitions):
    """The row of the analytic model with these flags of `phalanx run`."""
    runs = [json.loads(phalanx("run", scene, *flags, "--json", "--no-check")) for _ in range(repetitions)]
    (reference, first_s), found = exact, trajectory(scene, *flags)
    # The grid of the reference, so that nothing is interpolated.
    grid = set(reference["time_s"])
    rows = [(t, {name: found[name][k] for name in columns}) for k, t in enumerate(found["time_s"]) if t in grid]
    errors = differences([t for t, _ in rows], [row for _, row in rows], reference, {name: name for name in columns}, first_s)
    seconds = statistics.median(run["wall_s"] for run in runs)
    return {"method": "phalanx, analytic model", "step_s": None, **errors, "time_s": seconds}


def model_rows(path, part, plane, controls, duration_s):
    """Rows of the differences between a model of MuJoCo and its scene. `part` are the arguments root and branch."""
    import mujoco
    from phalanx.convert import from_mjcf
    from phalanx.convert.rigid import free_motion, rigid

    conversion = from_mjcf(path, **part, plane=plane, ctrl=controls)
    slides = {joint.name for joint in conversion.mechanism.joints if joint.is_slide}
    by_euler = rigid(conversion.source, conversion.plane)
    by_euler.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    models = {
        "as published": conversion.source.model,
        "rigid, planar, Euler": by_euler,
        "rigid, planar, RK4": rigid(conversion.source, conversion.plane),
    }
    rows = []
    for name, model in models.items():
        found = free_motion(conversion.source, conversion.plane, conversion.mechanism, duration_s, model)
        angles = [value for joint, value in found.items() if joint not in slides]
        positions = [value for joint, value in found.items() if joint in slides]
        errors = {"run_rad": max(angles, default=None), "run_m": max(positions, default=None)}
        rows.append({"method": name, "step_s": float(model.opt.timestep), **errors, "joints": found})
    return rows


def print_models(path, options):
    """Prints the table of a model of MuJoCo, and returns its rows."""
    controls = dict((name, float(value)) for name, _, value in (text.rpartition("=") for text in options.ctrl))
    rows = model_rows(path, {"root": options.root, "branch": options.branch}, options.plane, controls, options.duration)
    print(f"{'MuJoCo':<24} {'step':>8} {'angles':>12} {'positions':>12}   after {1e3 * options.duration:g} ms of free motion")
    for row in rows:
        cells = ["–" if row[key] is None else f"{row[key]:.1e} {unit}" for key, unit in (("run_rad", "rad"), ("run_m", "m"))]
        print(f"{row['method']:<24} {row['step_s']:>8.1e} {cells[0]:>12} {cells[1]:>12}")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=ROOT / "scenes" / "experiment-95.toml")
    parser.add_argument("--json", type=Path, help="also write the rows to this file")
    parser.add_argument("--repetitions", type=int, default=9, help="runs that are timed")
    parser.add_argument("--steps", nargs="+", type=float, default=STEPS_S, metavar="S", help="time steps of MuJoCo, s")
    parser.add_argument("--only", nargs="+", metavar="COLUMN", help="compare only these columns; default: those of all joints")
    parser.add_argument("--published", action="store_true", help="keep the default softness of MuJoCo's constraints")
    of_models = parser.add_argument_group("models of MuJoCo")
    of_models.add_argument("--root", metavar="BODY", help="body below which the mechanism is")
    of_models.add_argument("--branch", action="append", default=[], metavar="BODY", help="body that moves with its own joint and what is below it")
    of_models.add_argument("--plane", metavar="PLANE", help="axes of the root's frame that are x and y of the scene")
    of_models.add_argument("--ctrl", action="append", default=[], metavar="NAME=VALUE", help="control signal of an actuator")
    of_models.add_argument("--duration", type=float, default=0.05, metavar="S", help="duration of the free motion, s (default: 0.05)")
    options = parser.parse_args()
    if importlib.util.find_spec("mujoco") is None:
        sys.exit("this comparison needs MuJoCo: pip install mujoco")
    if Path(options.scene).suffix in (".xml", ".urdf", ".mjcf"):
        rows = print_models(options.scene, options)
        if options.json:
            options.json.write_text(json.dumps(rows, indent=2) + "\n")
        return
    exact = reference_of(options.scene)
    reference, _ = exact
    if unknown := set(options.only or []) - set(reference):
        parser.error(f"--only names no columns of the run: {', '.join(sorted(unknown))}; they are {', '.join(reference)}")
    settings = {"steps": options.steps, "published": options.published, "repetitions": options.repetitions}
    result, columns = mujoco_rows(options.scene, exact, options.only, **settings)
    result.append(own_row(options.scene, exact, columns, ["--preset", "engineering"], options.repetitions))
    print(f"{'method':<32} {'step':>7} {'before contact':>14} {'angles':>11} {'positions':>11} {'time':>10}")
    for row in result:
        cells = ["–" if row[key] is None else f"{row[key]:.1e}" for key in ("step_s", "swing_rad", "run_rad", "run_m")]
        print("{:<32} {:>7} {:>10} rad {:>7} rad {:>9} m".format(row["method"], *cells), f"{row['time_s'] * 1e3:>7.2f} ms")
    if options.json:
        options.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
