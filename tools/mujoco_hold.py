#!/usr/bin/env python3
"""Holds the cube of scenes/real/2f85-hold.toml with MuJoCo and with phalanx, and prints how fast it creeps out of the gripper.

    tools/mujoco_hold.py [--picture FILE.svg]

A gripper like the Robotiq 2F-85 holds a 40 mm cube of 100 g, which 1 g or 5 g pulls out of it. The MuJoCo model is written from the
numbers of robotiq_2f85/2f85.xml in mujoco_menagerie (commit 1b428b08): lengths, masses, springs, motor, armature, and the settings of
the solver (impratio 10, pyramidal cone, Euler, 2 ms) and of each constraint (solref, solimp). Its meshes are left out: only the two boxes
of each pad touch the cube. Single settings are varied. MuJoCo's friction is regularised: a contact resists a force by a slip rate,
whatever the time step. Its noslip iterations correct the friction forces after each step. phalanx simulates the scene file with the
bristle law in both models, and with its regularised law. The creep is the mean speed along the pull from 0.5 s to 1 s.

Needs `pip install mujoco matplotlib` and a build of phalanx ($PHALANX names the program).
"""

import argparse
import csv
import datetime
import io
import math
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "scenes" / "real" / "2f85-hold.toml"
PHALANX = os.environ.get("PHALANX", str(ROOT / "target" / "release" / "phalanx"))
PULLS_G = (1, 5)
G_M_S2 = 9.81
# The creep is measured from here to the end, s.
FROM_S, END_S = 0.5, 1.0
SAMPLE_S = 2e-3
# Position of the cube and angle of the drivers at the start, as in the scene.
CUBE_M, DRIVER_RAD = 0.1426, math.radians(25.75)

STIFF = 'solimp="0.95 0.99 0.001" solref="0.005 1"'
LIMIT = 'solimplimit="0.95 0.99 0.001" solreflimit="0.005 1"'
PAD = 'solimp="0.95 0.99 0.001" solref="0.004 1" priority="1"'
# Boxes of a pad: friction, centre along the pad, half length.
TWO_BOXES = ((0.7, 0.028125, 0.009375), (0.6, 0.009375, 0.009375))
ONE_BOX = ((0.6, 0.01875, 0.01875),)
PUBLISHED = {"boxes": TWO_BOXES, "pad": PAD, "cone": "pyramidal", "step_s": 2e-3, "noslip": 0}
VARIANTS = {
    "as published": {},
    "step 1 ms": {"step_s": 1e-3},
    "step 0.1 ms": {"step_s": 1e-4},
    "elliptic cone": {"cone": "elliptic"},
    "one box per pad": {"boxes": ONE_BOX},
    "default solref and solimp of the pads": {"pad": 'priority="1"'},
    "3 noslip iterations": {"noslip": 3},
    "3 noslip iterations, step 0.1 ms": {"noslip": 3, "step_s": 1e-4},
    "3 noslip iterations, one box per pad": {"noslip": 3, "boxes": ONE_BOX},
}
REGULARISED = ("laws.pad.friction.law=regularised", "laws.pad.friction.v_static=1 mm/s", "laws.pad.friction.v_dynamic=2 mm/s")
PHALANX_RUNS = {
    "analytic model, bristle": ("analytic", ()),
    "engine model, bristle": ("engine", ()),
    "analytic model, regularised, v_static 1 mm/s": ("analytic", REGULARISED),
}


def body(name, position, mass, com, inertia, inside, turned=False):
    turn = "0 0 0 1" if turned else "1 0 0 0"
    inertias = f"{inertia} {inertia} {inertia}"
    own = f'<inertial pos="0 {com}" mass="{mass}" diaginertia="{inertias}"/>'
    return f'<body name="{name}" pos="0 {position}" quat="{turn}">{own}{inside}</body>'


def finger(side, settings):
    """Bodies of one finger; the left one is the right one turned about the axis out of the palm."""
    is_left = side == "left"
    sign = -1 if is_left else 1

    def joint(name, rest):
        return f'<joint name="{side}_{name}" axis="1 0 0" {rest}/>'

    pads = "".join(
        f'<geom type="box" pos="0 -0.0215 {0.01352 + centre}" size="0.011 0.004 {half}" mass="0" friction="{mu}" {settings["pad"]}/>'
        for mu, centre, half in settings["boxes"]
    )
    coupler = joint("coupler", f'range="-1.57 0" {LIMIT}')
    coupler = body(f"{side}_coupler", "0.0315 -0.0041", 0.0140974, "0.00301209 0.0232175", 3.52216e-6, coupler)
    driver = joint("driver", f'range="0 0.8" armature="0.005" damping="0.1" {LIMIT}') + coupler
    driver = body(f"{side}_driver", f"{sign * 0.0306011} 0.054904", 0.00899563, "0.0177547 0.00107314", 1.72352e-6, driver, is_left)
    # Follower and pad, which is fixed to it.
    follower = joint("follower", f'pos="0 -0.018 0.0065" range="-0.872664 0.872664" {LIMIT}') + pads
    follower = body(f"{side}_follower", "0.055 0.0375", 0.0160222, "-0.0133078 0.01674736", 4.376557e-6, follower)
    link = joint("spring_link", 'range="-0.29670597283 0.8" stiffness="0.05" springref="2.62" damping="0.00125"') + follower
    return driver + body(f"{side}_link", f"{sign * 0.0132} 0.0609", 0.0221642, "0.0181624 0.0212658", 6.71733e-6, link, is_left)


def model_xml(settings, pull_g):
    """The gripper and the cube; its key frame is the start, with the pads at the cube."""
    sides = ("right", "left")
    connects = "".join(f'<connect anchor="0 0 0" body1="{s}_follower" body2="{s}_coupler" {STIFF}/>' for s in sides)
    drivers = "".join(f'<joint joint="{s}_driver" coef="0.5"/>' for s in sides)
    pose = f"{DRIVER_RAD} 0 {DRIVER_RAD} {-DRIVER_RAD}"
    options = f'timestep="{settings["step_s"]}" cone="{settings["cone"]}" noslip_iterations="{settings["noslip"]}"'
    return f"""<mujoco>
      <compiler angle="radian" autolimits="true"/>
      <option impratio="10" gravity="0 0 {pull_g * G_M_S2}" {options}/>
      <worldbody>
        {"".join(finger(side, settings) for side in sides)}
        <body pos="0 0 {CUBE_M}"><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="0.1"/></body>
      </worldbody>
      <tendon><fixed name="split">{drivers}</fixed></tendon>
      <equality>{connects}<joint joint1="right_driver" joint2="left_driver" polycoef="0 1 0 0 0" {STIFF}/></equality>
      <actuator>
        <general tendon="split" biastype="affine" forcerange="-5 5" ctrlrange="0 255" gainprm="0.3137255 0 0" biasprm="0 -100 -10"/>
      </actuator>
      <keyframe><key qpos="{pose} {pose} 0 0 {CUBE_M} 1 0 0 0" ctrl="255"/></keyframe>
    </mujoco>"""


def mujoco_run(changes, pull_g):
    """Times, and positions of the cube along the pull."""
    import mujoco

    settings = PUBLISHED | changes
    model = mujoco.MjModel.from_xml_string(model_xml(settings, pull_g))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    path = [(data.time, data.qpos[10])]
    for _ in range(round(END_S / SAMPLE_S)):
        mujoco.mj_step(model, data, nstep=round(SAMPLE_S / settings["step_s"]))
        path.append((data.time, data.qpos[10]))
    return path


def phalanx_run(model, changes, pull_g):
    """Times, and positions of the cube along the pull."""
    changes = (*changes, f'gravity=["0 m/s^2", "{pull_g * G_M_S2} m/s^2"]')
    with tempfile.TemporaryDirectory() as directory:
        table = Path(directory) / "run.csv"
        command = [PHALANX, "run", SCENE, "--model", model, "--no-check", "--quiet", "--csv", table]
        command += [part for change in changes for part in ("--set", change)]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode != 0:
            sys.exit(f"{' '.join(map(str, command))} failed: {result.stderr}")
        rows = csv.DictReader(io.StringIO(table.read_text()))
        return [(float(row["time_s"]), float(row["object_y_m"])) for row in rows]


def creep_m_s(path):
    """Mean speed from 0.5 s to the end."""
    first = next(point for point in path if point[0] >= FROM_S - 1e-9)
    return (path[-1][1] - first[1]) / (path[-1][0] - first[0])


def measure():
    """Program, settings and creep at each pull, in µm/s, of each simulation."""
    runs = [("MuJoCo", name, lambda g, changes=changes: mujoco_run(changes, g)) for name, changes in VARIANTS.items()]
    runs += [("phalanx", name, lambda g, run=run: phalanx_run(*run, g)) for name, run in PHALANX_RUNS.items()]
    return [(program, name, [1e6 * creep_m_s(run(pull_g)) for pull_g in PULLS_G]) for program, name, run in runs]


# Smallest creep in the picture, µm/s.
FLOOR_UM_S = 1e-10
DARK = {
    "#ffffff": "#1b1f26", "#000000": "#eceff3", "#666666": "#a7b0bd", "#e6e6e6": "#3a424e", "#0072b2": "#56b4e9", "#d55e00": "#ff9a52",
}


def draw(rows, out):
    """Draws the creep of all simulations at both pulls."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from dark_scheme import add_dark_scheme

    plt.rcParams.update({"svg.hashsalt": "phalanx", "svg.fonttype": "none", "font.family": "sans-serif"})
    figure, axes = plt.subplots(figsize=(9.0, 4.6), layout="constrained")
    # Markers that coincide are both visible.
    for k, style in enumerate(({"color": "#0072b2", "marker": "o"}, {"color": "#d55e00", "marker": "s", "fillstyle": "none"})):
        creeps = [max(abs(creeps[k]), FLOOR_UM_S) for _, _, creeps in rows]
        axes.plot(creeps, range(len(rows)), linestyle="none", markersize=6 + 3 * k, label=f"pull of {PULLS_G[k]} g", **style)
    first = len(VARIANTS) - 0.5
    axes.axhline(first, color="0.4", linewidth=0.8)
    axes.set_yticks(range(len(rows)), [f"{program}: {name}" for program, name, _ in rows])
    axes.invert_yaxis()
    axes.set(xscale="log", xlim=(FLOOR_UM_S / 3, 1e4), xlabel="creep of the cube, µm/s (points at the left edge: 1e-10 or less)")
    axes.grid(True, axis="x", color="0.9")
    axes.set_axisbelow(True)
    figure.legend(loc="outside upper right", ncols=2, frameon=False)
    figure.savefig(out, metadata={"Date": None})
    add_dark_scheme(out, DARK)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--picture", type=Path, help="also draw the creep (.svg)")
    options = parser.parse_args()
    try:
        import mujoco
    except ImportError:
        sys.exit("this comparison needs MuJoCo: pip install mujoco matplotlib")
    rows = measure()
    print("| program | settings | " + " | ".join(f"creep at {g} g (µm/s)" for g in PULLS_G) + " |")
    print("|---|---|" + "---|" * len(PULLS_G))
    for program, name, creeps in rows:
        print(f"| {program} | {name} | " + " | ".join(f"{creep:.3g}" for creep in creeps) + " |")
    version = subprocess.run([PHALANX, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    print(f"\nMuJoCo {mujoco.__version__}, {version}; {platform.machine()}, {platform.system()}; {datetime.date.today()}")
    if options.picture:
        draw(rows, options.picture)


if __name__ == "__main__":
    main()
