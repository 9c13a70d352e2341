#!/usr/bin/env python3
"""Simulates the closing of one finger with MuJoCo and with phalanx, and prints time and error of both.

    tools/mujoco_beside.py [SCENE] [--json FILE] [--repetitions N]

SCENE is a scene file of one finger with a constant motor torque and a constant-force spring at q22 (default: scenes/experiment-95.toml).
The MuJoCo model has the same masses, lengths, torques and gravity. Its loop is closed by a `connect` constraint, and its contacts and
its joint limit are MuJoCo's own: soft constraints with the shortest time constant that the time step allows (solref = 2 time steps).
MuJoCo does not have the Hertz/STEP contact law of the scene. Therefore the table has two errors: the largest angle error of the swing
(up to 0.1 ms before the first contact), in which only loop, limit and integration err, and that of the whole run, which contains the
different contact law. The reference is phalanx with `--preset reference`. Times are medians of one closing, without loading.
Needs `pip install mujoco` and a release build of phalanx ($PHALANX names another program).
"""

import argparse
import csv
import io
import json
import math
import os
import re
import statistics
import subprocess
import sys
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PHALANX = os.environ.get("PHALANX", str(ROOT / "target" / "release" / "phalanx"))
UNITS = {
    "": 1.0, "m": 1.0, "mm": 1e-3, "um": 1e-6, "s": 1.0, "ms": 1e-3, "us": 1e-6, "rad": 1.0, "deg": math.pi / 180.0, "kg": 1.0,
    "g": 1e-3, "N*m": 1.0, "N*mm": 1e-3, "kg*m^2": 1.0, "g*mm^2": 1e-9, "m/s^2": 1.0, "rad/s": 1.0,
}  # fmt: skip
# Time steps of MuJoCo, s.
STEPS_S = (1e-4, 1e-5, 1e-6)
INTEGRATORS = ("implicitfast", "RK4")


def si(quantity):
    """The value of a quantity such as "12 mm" in SI units."""
    match = re.fullmatch(r"([-+\d.e]+) ?(\S*)", str(quantity))
    if not match or match[2] not in UNITS:
        sys.exit(f"the unit of {quantity!r} is not known here: one of {', '.join(filter(None, UNITS))}")
    return float(match[1]) * UNITS[match[2]]


def phalanx(*arguments):
    """Standard output of a phalanx command."""
    result = subprocess.run([PHALANX, *map(str, arguments)], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        sys.exit(f"phalanx {' '.join(map(str, arguments))} failed: {result.stderr}")
    return result.stdout


def trajectory(scene, preset):
    """Rows (time, q11, q21) of a run of the analytic model, every 0.1 ms and at each event."""
    rows = csv.DictReader(io.StringIO(phalanx("run", scene, "--preset", preset, "--no-check", "--csv", "-")))
    return [[float(row[key]) for key in ("time_s", "q11_rad", "q21_rad")] for row in rows]


def first_contact(scene):
    """Time of the first contact with the object, s."""
    contacts = json.loads(phalanx("run", scene, "--preset", "reference", "--json", "--no-check"))["contacts"]
    return min(contacts[name]["first_s"] for name in ("proximal", "distal") if contacts[name]["first_s"] is not None)


def mjcf(resolved, step_s, integrator):
    """The MuJoCo model of a resolved scene of one finger. Joints start at the scene's initial angles."""
    lengths = {name: si(value) for name, value in resolved["lengths"].items()}
    width = si(resolved["half_width"])
    q11, q21 = si(resolved["initial"]["q11"]), si(resolved["initial"]["q21"])
    object_x, object_y = map(si, resolved["object"]["centre"])
    radius = si(resolved["object"]["radius"])
    gravity = [si(value) for value in resolved["gravity"]]
    friction = resolved["contact"]["proximal"]["friction"]["mu_static"]
    # Passive angles of the start from the closure of the loop: A13 lies on two circles.
    a12 = (lengths["l11"] * math.cos(q11), lengths["l11"] * math.sin(q11))
    a22 = (lengths["l21"] * math.cos(q21), lengths["l21"] * math.sin(q21))
    gap = (a22[0] - a12[0], a22[1] - a12[1])
    distance = math.hypot(*gap)
    base = math.atan2(gap[1], gap[0])
    corner = math.acos((lengths["l12"] ** 2 + distance**2 - lengths["l22"] ** 2) / (2 * lengths["l12"] * distance))
    sign = -1.0 if resolved["assembly"] == "reference" else 1.0
    theta12 = base + sign * corner
    a13 = (a12[0] + lengths["l12"] * math.cos(theta12), a12[1] + lengths["l12"] * math.sin(theta12))
    theta22 = math.atan2(a13[1] - a22[1], a13[0] - a22[0])
    q22 = math.remainder(theta22 - q21, math.tau)

    def inertial(name):
        body = resolved["bodies"][name]
        x, y = map(si, body["com"])
        inertia = si(body["inertia"])
        return f'<inertial pos="{x} {y} 0" mass="{si(body["mass"])}" diaginertia="{inertia} {inertia} {inertia}"/>'

    def capsule(name, angle, length):
        end = f"{length * math.cos(angle)} {length * math.sin(angle)} 0"
        return f'<geom name="{name}" type="capsule" fromto="0 0 0 {end}" size="{width}" contype="1" conaffinity="2"/>'

    def frame(x, y, angle):
        return f'pos="{x} {y} 0" euler="0 0 {angle}"'

    phi22 = lengths["phi22"]
    soft = f'solref="{2 * step_s} 1" solimp="0.99 0.9999 1e-5"'
    hinge = 'type="hinge" axis="0 0 1"'
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step_s}" gravity="{gravity[0]} {gravity[1]} 0" integrator="{integrator}" cone="elliptic" solver="Newton"
          iterations="100" tolerance="1e-12"/>
  <default><geom friction="{friction} 0 0" condim="3" solref="{2 * step_s} 1" mass="0"/></default>
  <worldbody>
    <geom name="object" type="cylinder" pos="{object_x} {object_y} 0" size="{radius} 0.02" contype="2" conaffinity="1"/>
    <body name="l11" {frame(0, 0, q11)}>
      <joint name="q11" {hinge}/>{inertial("l11")}
      <body name="l12" {frame(lengths["l11"], 0, theta12 - q11)}>
        <joint name="q12" {hinge}/>{inertial("l12")}
      </body>
    </body>
    <body name="l21" {frame(0, 0, q21)}>
      <joint name="q21" {hinge}/>{inertial("l21")}{capsule("proximal", 0.0, lengths["l21"])}
      <body name="l22" {frame(lengths["l21"], 0, q22)}>
        <joint name="q22" {hinge} limited="true" range="{-phi22 - q22} 3" solreflimit="{2 * step_s} 1"/>
        {inertial("l22")}{capsule("distal", phi22, lengths["t22"])}
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="l21" body2="l22"/></contact>
  <equality><connect body1="l12" body2="l22" anchor="{lengths["l12"]} 0 0" {soft}/></equality>
  <actuator>
    <motor name="motor" joint="q11"/>
    <motor name="spring" joint="q22"/>
  </actuator>
</mujoco>""", (q11, q21)


def reset(model, data, resolved):
    """Puts the model into its initial state, with the constant torques of motor and spring."""
    import mujoco

    mujoco.mj_resetData(model, data)
    data.ctrl[:] = [si(resolved["motor"]["torque"]), -si(resolved["spring"]["torque"])]


def time_closing(model, data, resolved, duration_s):
    """Wall time of one closing, s."""
    import mujoco

    reset(model, data, resolved)
    start = time.perf_counter()
    mujoco.mj_step(model, data, nstep=round(duration_s / model.opt.timestep))
    return time.perf_counter() - start


def record_closing(model, data, resolved, duration_s):
    """Rows (time, joint positions of q11 and q21) of one closing, every 0.1 ms."""
    import mujoco

    reset(model, data, resolved)
    addresses = [model.joint(name).qposadr[0] for name in ("q11", "q21")]
    stride = round(1e-4 / model.opt.timestep)
    rows = []
    for _ in range(0, round(duration_s / model.opt.timestep), stride):
        mujoco.mj_step(model, data, nstep=stride)
        rows.append((data.time, *(data.qpos[address] for address in addresses)))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=ROOT / "scenes" / "experiment-95.toml")
    parser.add_argument("--json", type=Path, help="also write the rows to this file")
    parser.add_argument("--repetitions", type=int, default=9, help="closings that are timed")
    options = parser.parse_args()
    try:
        import mujoco
        import numpy
    except ImportError:
        sys.exit("this comparison needs MuJoCo: pip install mujoco")
    resolved = tomllib.loads(phalanx("scene", "show", "--resolved", options.scene))
    if resolved["kind"] != "finger" or resolved["motor"]["profile"] != "constant" or resolved["spring"]["placement"] != "q22":
        sys.exit("the scene has to be one finger with a constant motor torque and a constant-force spring at q22")
    duration_s = si(resolved["duration"])
    first_s = first_contact(options.scene)
    times, *reference = zip(*trajectory(options.scene, "reference"))

    def errors_of(positions):
        """Largest angle errors of the swing and of the whole run, rad."""
        errors = [(t, max(abs(q - numpy.interp(t, times, exact)) for q, exact in zip(angles, reference))) for t, *angles in positions]
        return {"swing_rad": max(e for t, e in errors if t < first_s - 1e-4), "run_rad": max(e for _, e in errors)}

    result = []
    for integrator in INTEGRATORS:
        for step_s in STEPS_S:
            text, start = mjcf(resolved, step_s, integrator)
            model = mujoco.MjModel.from_xml_string(text)
            data = mujoco.MjData(model)
            positions = [
                (t, *(q0 + q for q0, q in zip(start, angles))) for t, *angles in record_closing(model, data, resolved, duration_s)
            ]
            seconds = [time_closing(model, data, resolved, duration_s) for _ in range(options.repetitions)]
            result.append({
                "method": f"MuJoCo {mujoco.__version__}, {integrator}",
                "step_s": step_s,
                **errors_of(positions),
                "time_s": statistics.median(seconds),
            })
    ours = [json.loads(phalanx("run", options.scene, "--preset", "engineering", "--json")) for _ in range(options.repetitions)]
    # The grid of the reference, so that nothing is interpolated.
    engineering = [row for row in trajectory(options.scene, "engineering") if row[0] in times]
    seconds = statistics.median(run["wall_s"] for run in ours)
    result.append({"method": "phalanx, analytic model", "step_s": None, **errors_of(engineering), "time_s": seconds})
    print(f"{'method':<32} {'step':>7} {'swing error':>12} {'run error':>12} {'time':>10}")
    for row in result:
        cell = lambda key: "–" if row[key] is None else f"{row[key]:.1e}"  # noqa: E731, B023
        print(f"{row['method']:<32} {cell('step_s'):>7} {cell('swing_rad'):>12} {cell('run_rad'):>12} {row['time_s'] * 1e3:>7.2f} ms")
    if options.json:
        options.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
