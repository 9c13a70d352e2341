#!/usr/bin/env python3
"""Simulates random grippers and mechanisms in both models, and looks for results that are wrong without a warning.

    tools/random_grippers.py [--scenes N] [--first SEED] [--minutes M] [--json FILE]
    tools/random_grippers.py --seed SEED --keep DIRECTORY

A seed determines a scene: jaws, tendon fingers, linkages, sliders, thrown bodies, and fingers and grippers whose object is no disc,
with masses, stiffness, damping and friction over decades. Each scene is simulated with the analytic model and with the engine, each
with its check. Where the check of the analytic model says `sure`, its end is compared with that of `--preset reference` and with that
of the engine. A run of more than a minute is killed.

An outcome is suspicious if a `sure` run is wrong beyond its bar, the models differ, a model fails or is killed, a message is missing,
or the energy does not balance. The names and messages of these seeds are printed; `--keep` saves the scene and its results.
Needs a build of phalanx ($PHALANX names another program than target/release/phalanx).
"""

import argparse
import json
import math
import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PHALANX = os.environ.get("PHALANX", str(ROOT / "target" / "release" / "phalanx"))
TIME_LIMIT_S = 60.0
# A check measures lengths of mechanisms with joints in this unit, in m.
UNIT_M = 0.02
# Bar of the check of bodies without joints, relative to the reach of the smallest one; the bar itself is in m.
FREE_BODIES_BAR = 2e-3
# Smallest differences that count, whatever the bar is.
ANGLE_RAD, POSITION_M = 1e-5, 1e-6
# Differences of the models that count, if the check of the engine is not sure.
MODELS_RAD, MODELS_M = 1e-4, 1e-5
# Relative difference of peak forces that counts.
PEAK = 0.02
# Settings of the engine in a second run after such a difference.
FINE = ("--set", "engine.tolerance=1e-6 mm", "--set", "engine.max_step=6 us")
# Outlines that an ellipse can touch.
FACES = ("box", "polygon", "capsule", "disc")


# ---------------------------------------------------------------------------------------------------------------- scenes


def decades(rng, low, high):
    """A number whose logarithm is uniform."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def quantity(value, unit):
    return f"{value:.6g} {unit}"


def point(x_mm, y_mm):
    return [quantity(x_mm, "mm"), quantity(y_mm, "mm")]


def bulk(rng, mass_g, size_mm):
    """Mass and inertia of a body of this size."""
    return {"mass": quantity(mass_g, "g"), "inertia": quantity(mass_g * size_mm**2 * rng.uniform(0.1, 0.3), "g*mm^2")}


def law(rng, unit="m"):
    """A normal law for contacts (unit m) or stops (unit rad)."""
    exponent = rng.choice([1, 1.5, 1.5, 2, 2.2])
    stiff = {1: (1e4, 1e7), 1.5: (1e5, 1e9), 2: (1e6, 1e10), 2.2: (1e7, 1e11)}[exponent]
    low, high = stiff if unit == "m" else (10 * 10**exponent, 1e3 * 20**exponent)
    result = {"stiffness": float(f"{decades(rng, low, high):.4g}"), "exponent": exponent}
    result["type"] = rng.choice(["hunt_crossley", "hunt_crossley", "restitution", "spring_damper", "step"])
    if result["type"] == "hunt_crossley":
        result["damping"] = quantity(decades(rng, 0.05, 10) * (1 if unit == "m" else 0.1), f"s/{unit}")
    elif result["type"] == "restitution":
        result["restitution"] = round(rng.uniform(0.2, 1), 3)
        result["speed"] = quantity(decades(rng, 0.05, 2) * (1 if unit == "m" else 10), f"{unit}/s")
    else:
        damping = decades(rng, 1, 300) if unit == "m" else decades(rng, 1e-4, 1e-2)
        result["damping"] = quantity(damping, "N*s/m" if unit == "m" else "N*m*s/rad")
    if result["type"] == "step":
        result["transition"] = quantity(decades(rng, 1e-6, 5e-5) * (1 if unit == "m" else 30), unit)
    if unit == "m" and rng.random() < 0.85:
        mu = round(rng.uniform(0, 1.5), 3)
        if rng.random() < 0.4:
            result["friction"] = {"mu_static": mu, "law": "bristle", "bristle_damping": quantity(decades(rng, 10, 1000), "N*s/m")}
            if rng.random() < 0.5:
                result["friction"]["bristle_relaxation"] = quantity(decades(rng, 0.2, 2), "ms")
        else:
            slow = decades(rng, 1e-3, 0.1)
            result["friction"] = {"mu_static": mu, "mu_dynamic": round(mu * rng.uniform(0.5, 1), 3)}
            result["friction"] |= {"v_static": quantity(slow, "m/s"), "v_dynamic": quantity(2 * slow, "m/s")}
    return result


def contact(rng, first, second, name="pad"):
    entry = {"between": [first, second], "law": name}
    if rng.random() < 0.2:
        entry["rolling_arm"] = quantity(decades(rng, 0.01, 1), "mm")
        entry["rolling_rate"] = quantity(decades(rng, 0.1, 3), "rad/s")
    if rng.random() < 0.2:
        entry["at"] = rng.choice(["points", "middle", "each"])
    return entry


def outline(rng, size_mm, center=(0.0, 0.0), kinds=("box", "polygon", "ellipse", "capsule", "disc")):
    """An outline within a circle about `center` whose diameter is `size_mm`."""
    half, (x, y) = size_mm / 2, center
    kind = rng.choice(kinds)
    if kind == "disc":
        return {"type": kind, "center": point(x, y), "radius": quantity(half, "mm")}
    if kind == "ellipse":
        result = {"type": kind, "center": point(x, y), "semi_axes": point(half, half * rng.uniform(0.35, 0.95))}
        return result | {"angle": quantity(rng.uniform(0, 180), "deg")}
    if kind == "capsule":
        radius, turn = half * rng.uniform(0.2, 0.6), rng.uniform(0, math.pi)
        dx, dy = (half - radius) * math.cos(turn), (half - radius) * math.sin(turn)
        return {"type": kind, "from": point(x - dx, y - dy), "to": point(x + dx, y + dy), "radius": quantity(radius, "mm")}
    rounding = quantity(half * decades(rng, 0.02, 0.2), "mm")
    if kind == "box":
        turn = rng.uniform(0.4, 1.2)
        result = {
            "type": kind,
            "center": point(x, y),
            "rounding": rounding,
            "size": point(2 * half * math.cos(turn), 2 * half * math.sin(turn)),
        }
        return result | ({"angle": quantity(rng.uniform(0, 90), "deg")} if rng.random() < 0.4 else {})
    corners = rng.randint(3, 6)
    angles = [2 * math.pi * (index + rng.uniform(-0.25, 0.25)) / corners for index in range(corners)]
    vertices = [point(x + half * math.cos(angle), y + half * math.sin(angle)) for angle in angles]
    return {"type": kind, "vertices": vertices, "rounding": rounding}


def free_body(rng, size_mm, kinds=(*FACES, "ellipse"), **start):
    """A free body of one or two outlines, with mass properties or a density."""
    if rng.random() < 0.25:
        quarter = size_mm / 4
        outlines = {"a": outline(rng, 0.95 * size_mm / 2, (-quarter, 0), kinds), "b": outline(rng, 0.95 * size_mm / 2, (quarter, 0), kinds)}
    else:
        outlines = {"skin": outline(rng, size_mm, kinds=kinds)}
    if rng.random() < 0.5:
        bulk_keys = {"density": quantity(decades(rng, 300, 8000), "kg/m^3"), "depth": quantity(decades(rng, 5, 60), "mm")}
    else:
        bulk_keys = bulk(rng, decades(rng, 5, 500), size_mm)
        if rng.random() < 0.3:
            bulk_keys["com"] = point(rng.uniform(-0.1, 0.1) * size_mm, rng.uniform(-0.1, 0.1) * size_mm)
    return bulk_keys | {"start": start, "outlines": outlines}


def joint_losses(rng, torque, unit="N*m", rate="rad/s"):
    """Damping and friction of a joint whose drive has this torque or force."""
    angle = "rad" if unit == "N*m" else "m"
    result = {}
    if rng.random() < 0.4:
        result["damping"] = quantity(torque * decades(rng, 1e-4, 1e-2), "N*m*s/rad" if unit == "N*m" else "N*s/m")
    if rng.random() < 0.4:
        friction = torque * decades(rng, 0.01, 0.3)
        result["friction"] = quantity(friction, unit)
        if rng.random() < 0.4:
            result["static_friction"] = quantity(friction * rng.uniform(1, 1.6), unit)
        if rng.random() < 0.5:
            result["friction_stiffness"] = quantity(friction * decades(rng, 1e2, 1e5), f"{unit}/rad" if unit == "N*m" else "N/m")
        elif rng.random() < 0.5:
            slow = decades(rng, 1e-3, 0.1)
            result["friction_rates"] = [quantity(slow, rate), quantity(2 * slow, rate)]
    if rng.random() < 0.2:
        result["armature"] = quantity(torque * decades(rng, 1e-6, 1e-4), "kg*m^2" if angle == "rad" else "kg")
    return result


def drive(rng, torque, inertia, start, travel, duration_ms, unit="N*m"):
    """A drive that moves an inertia by `travel` from `start`, in SI units: a torque, a servo, or a servo with a rate."""
    is_turn = unit == "N*m"
    name, angle, rate = ("torque", "rad", "rad/s") if is_turn else ("force", "m", "m/s")
    sign = math.copysign(1, travel)
    speed = abs(travel) / (duration_ms * 1e-3)
    how = rng.choice(["constant", "table", "target", "targets", "servo"])
    if how == "constant":
        result = {name: quantity(sign * torque, unit)}
    elif how == "table":
        times = sorted(rng.uniform(0, duration_ms) for _ in range(3))
        result = {"times": [quantity(time, "ms") for time in times]}
        result[f"{name}s"] = [quantity(sign * torque * rng.uniform(-0.5, 1.5), unit) for _ in times]
    else:
        omega = decades(rng, 3, 30) / (duration_ms * 1e-3)
        result = {
            "kp": quantity(inertia * omega**2, "N*m/rad" if is_turn else "N/m"),
            "limit": quantity(torque * decades(rng, 0.5, 3), unit),
        }
        result["kd"] = quantity(2 * rng.uniform(0.3, 1.2) * inertia * omega, "N*m*s/rad" if is_turn else "N*s/m")
        if how == "targets":
            result |= {
                "times": ["0 ms", quantity(rng.uniform(0.4, 1) * duration_ms, "ms")],
                "targets": [quantity(start, angle), quantity(start + travel, angle)],
            }
        else:
            result["target"] = quantity(start + travel, angle)
            result |= {"target_rate": quantity(speed * decades(rng, 0.5, 5), rate)} if rng.random() < 0.6 else {}
        if how == "servo":
            result["rate"] = quantity(omega * rng.uniform(4, 20), "Hz")
    if rng.random() < 0.25:
        result["no_load_speed"] = quantity(speed * decades(rng, 1, 10), rate)
    if rng.random() < 0.35:
        brake = {"limit": quantity(torque * decades(rng, 0.3, 10), unit), "at": quantity(rng.uniform(0, 0.8) * duration_ms, "ms")}
        if rng.random() < 0.4:
            brake["release"] = quantity(rng.uniform(0.85, 1) * duration_ms + 1, "ms")
        if rng.random() < 0.5:
            brake["rise"] = quantity(decades(rng, 0.1, 3), "ms")
        if rng.random() < 0.5:
            brake["stiffness"] = quantity(torque * decades(rng, 1e2, 1e5), "N*m/rad" if is_turn else "N/m")
        if rng.random() < 0.3:
            brake["one_way"] = True
        result["brake"] = brake
    return result


def base(rng, duration_ms):
    scene = {"kind": "mechanism", "duration": quantity(duration_ms, "ms")}
    if rng.random() < 0.6:
        scene["gravity"] = [quantity(0, "m/s^2"), quantity(rng.choice([-9.81, 9.81]), "m/s^2")]
    return scene | {"bodies": {}, "joints": {}, "laws": {"pad": law(rng)}, "contacts": []}


def jaws(rng):
    """Two parallel jaws on sliders grip a body, free or on a floor."""
    duration, width = decades(rng, 15, 80), decades(rng, 10, 60)
    scene = base(rng, duration)
    mass = decades(rng, 10, 500)
    gap = width / 2 + decades(rng, 0.2, 10)
    travel = 1.5 * gap * 1e-3
    force = mass * 1e-3 * 2 * travel / (duration * 1e-3) ** 2 * decades(rng, 1, 50)
    scene["bodies"]["object"] = free_body(
        rng, width, at=point(rng.uniform(-0.2, 0.2), 0), angle=quantity(rng.choice([0, 0, rng.uniform(-90, 90)]), "deg")
    )
    mirrored = rng.random() < 0.4
    for side, sign in [("right", 1)] if mirrored else [("right", 1), ("left", -1)]:
        pad = {
            "type": "box",
            "center": point(sign * 5, 0),
            "size": point(10, width * rng.uniform(0.3, 1.5)),
            "rounding": quantity(decades(rng, 0.2, 2), "mm"),
        }
        scene["bodies"][side] = bulk(rng, mass, width) | {"guess": {"at": point(sign * gap, 0)}, "outlines": {"skin": pad}}
        scene["joints"][side] = {"type": "prismatic", "bodies": ["ground", side], "points": [point(0, 0), point(0, 0)]}
        scene["joints"][side] |= {"start": quantity(sign * gap, "mm")} | joint_losses(rng, force, "N", "m/s")
    actuators = scene["actuators"] = {"right": {"joint": "right"} | drive(rng, force, mass * 1e-3, gap * 1e-3, -travel, duration, "N")}
    if mirrored:
        scene["mirror"] = {"from": "right", "to": "left"}
    elif rng.random() < 0.4:
        scene["couplings"] = {"mimic": {"joints": ["left", "right"], "factors": [1, 1]}}
        del scene["joints"]["left"]["start"]
    else:
        actuators["left"] = {"joint": "left"} | drive(rng, force, mass * 1e-3, -gap * 1e-3, travel, duration, "N")
    if "couplings" not in scene and rng.random() < 0.3:
        scene["rotors"] = {
            "seesaw": {"joints": ["left", "right"], "factors": [0.5, 0.5], "inertia": quantity(mass * decades(rng, 0.1, 3), "g")}
        }
    if rng.random() < 0.4:
        scene["ground"] = {"outlines": {"floor": {"type": "half_plane", "point": point(0, -0.55 * width), "normal": [0, 1]}}}
        scene["laws"]["floor"] = law(rng)
        scene["contacts"].append(contact(rng, "object", "ground.floor", "floor"))
    scene["contacts"] += [contact(rng, "right.skin", "object"), *([] if mirrored else [contact(rng, "left.skin", "object")])]
    return scene


def finger(rng, scene, side, sign, duration, mirrored, torque):
    """A finger of two phalanges closed by a tendon, to the right (sign 1) or to the left of the object."""
    lower, upper = rng.uniform(35, 60), rng.uniform(25, 45)
    foot, lean = rng.uniform(28, 45), math.radians(rng.uniform(60, 85))
    turn = lean if sign > 0 else math.pi - lean
    knee = (sign * foot + lower * math.cos(turn), lower * math.sin(turn))
    width = rng.uniform(4, 8)
    mass = decades(rng, 10, 100)
    for name, at, length, share in [("proximal", (sign * foot, 0), lower, 1), ("distal", knee, upper, 0.6)]:
        pad = {"type": "capsule", "from": point(6, 0), "to": point(length - 6, 0), "radius": quantity(width, "mm")}
        if rng.random() < 0.4:
            pad = {
                "type": "box",
                "center": point(length / 2, 0),
                "size": point(length - 4, 2 * width),
                "rounding": quantity(decades(rng, 0.3, 3), "mm"),
            }
        body = bulk(rng, mass * share, length) | {"com": point(length / 2, 0), "outlines": {"pad": pad}}
        scene["bodies"][f"{side}_{name}"] = body | {"guess": {"at": point(*at), "angle": quantity(turn, "rad")}}
    limit = ("lower", -2) if sign > 0 else ("upper", 2)
    for name, parent, points in [
        ("base", "ground", [point(sign * foot, 0), point(0, 0)]),
        ("middle", f"{side}_proximal", [point(lower, 0), point(0, 0)]),
    ]:
        child = f"{side}_{'proximal' if name == 'base' else 'distal'}"
        joint = {"bodies": [parent, child], "points": points, "offset": quantity(turn if name == "base" else 0, "rad"), "start": "0 deg"}
        joint |= {limit[0]: quantity(limit[1] if rng.random() < 0.5 else 0, "deg"), "stop": "stop"}
        scene["joints"][f"{side}_{name}"] = joint | joint_losses(rng, torque)
        spring = {"joint": f"{side}_{name}", "stiffness": quantity(torque * decades(rng, 0.05, 1), "N*m/rad")}
        scene.setdefault("springs", {})[f"{side}_{name}"] = spring | {
            "rest": quantity(-sign * rng.uniform(0, 1), "rad"),
            "damping": quantity(torque * decades(rng, 1e-4, 1e-2), "N*m*s/rad"),
        }
    inner = sign * width * rng.uniform(0.5, 0.9)
    path = [{"eyelet": "ground", "at": point(sign * (foot + 25), -10)}]
    if rng.random() < 0.7:
        path.append(
            {
                "pulley": "ground",
                "at": point(sign * foot, 0),
                "radius": quantity(rng.uniform(4, 8), "mm"),
                "turn": "cw" if sign > 0 else "ccw",
            }
        )
    else:
        path.append({"eyelet": "ground", "at": point(sign * (foot - 8), 0)})
    path += [
        {"eyelet": f"{side}_proximal", "at": point(lower * rng.uniform(0.5, 0.9), inner)},
        {"eyelet": f"{side}_distal", "at": point(upper * rng.uniform(0.3, 0.6), inner)},
    ]
    tendon = {"path": path}
    if rng.random() < 0.7:
        tendon |= {"stiffness": quantity(decades(rng, 3e3, 3e5), "N/m"), "damping": quantity(decades(rng, 0.1, 30), "N*s/m")}
        if rng.random() < 0.6:
            tendon["pretension"] = quantity(decades(rng, 0.1, 5), "N")
    return f"{side}_flexor", tendon


def tendon_fingers(rng):
    """One or two tendon fingers close on a disc or another outline, pulled over time or by a winch."""
    duration, torque = decades(rng, 20, 60), decades(rng, 0.03, 1)
    scene = base(rng, duration)
    scene["laws"]["stop"] = law(rng, "rad")
    hands = rng.choice(["one", "mirror", "two"])
    sides = [("right", 1)] + ([("left", -1)] if hands == "two" else [])
    tendons = scene["tendons"] = dict(finger(rng, scene, side, sign, duration, hands == "mirror", torque) for side, sign in sides)
    scene["actuators"] = {}
    pull = torque / 0.006
    if hands != "mirror" and all("stiffness" in tendon for tendon in tendons.values()) and rng.random() < 0.7:
        scene["bodies"]["winch"] = bulk(rng, 20, 15) | {"guess": {"at": point(0, -40)}}
        scene["joints"]["shaft"] = {
            "bodies": ["ground", "winch"],
            "points": [point(0, -40), point(0, 0)],
            "start": "0 deg",
            "armature": quantity(decades(rng, 1e-6, 1e-5), "kg*m^2"),
        } | joint_losses(rng, torque)
        for tendon in tendons.values():
            tendon["spools"] = [{"joint": "shaft", "radius": quantity(rng.uniform(4, 10), "mm")}]
        scene["actuators"]["motor"] = {"joint": "shaft"} | drive(rng, torque, 1e-5, 0, 3, duration)
    else:
        for name in tendons:
            if rng.random() < 0.5:
                scene["actuators"][name] = {"tendon": name, "tension": quantity(pull, "N")}
            else:
                times = sorted(rng.uniform(0, duration) for _ in range(3))
                scene["actuators"][name] = {
                    "tendon": name,
                    "times": [quantity(time, "ms") for time in times],
                    "tensions": [quantity(pull * rng.uniform(0, 1), "N") for _ in times],
                }
    if hands == "mirror":
        scene["mirror"] = {"from": "right", "to": "left"}
    size = rng.uniform(20, 34)
    if rng.random() < 0.3:
        scene["ground"] = {"outlines": {"object": outline(rng, size, (0, 45))}}
        target = "ground.object"
    else:
        scene["bodies"]["object"] = free_body(
            rng, size, at=point(rng.uniform(-2, 2), rng.uniform(30, 50)), angle=quantity(rng.uniform(-90, 90), "deg")
        )
        target = "object"
        if rng.random() < 0.5:
            scene["ground"] = {"outlines": {"palm": {"type": "half_plane", "normal": [0, 1]}}}
            scene["contacts"].append(contact(rng, "object", "ground.palm"))
    scene["contacts"] += [contact(rng, f"{side}_*.pad", target) for side, _ in sides]
    return scene


def linkage(rng):
    """A four-bar with springs, friction, brake and rotor whose coupler hits a body; some have a second drive on a sum of coordinates."""
    duration = decades(rng, 10, 60)
    scene = base(rng, duration)
    crank, coupler, rocker, span = rng.uniform(20, 40), rng.uniform(50, 80), rng.uniform(40, 70), rng.uniform(50, 70)
    start = rng.uniform(0.6, 1.6)
    x, y = crank * math.cos(start), crank * math.sin(start)
    dx, dy = span - x, -y
    distance = math.hypot(dx, dy)
    if not abs(coupler - rocker) + 5 < distance < coupler + rocker - 5:
        return linkage(rng)
    along = (coupler**2 - rocker**2 + distance**2) / (2 * distance)
    across = math.sqrt(coupler**2 - along**2)
    px, py = x + (along * dx - across * dy) / distance, y + (along * dy + across * dx) / distance
    slope, lift = math.atan2(py - y, px - x), math.atan2(py, px - span)
    mass = decades(rng, 5, 200)
    inertia = 1e-9 * mass * (crank**2 / 3 + coupler**2)
    torque = inertia * 2 / (duration * 1e-3) ** 2 * decades(rng, 1, 30)
    for name, length, at, angle in [
        ("crank", crank, (0, 0), start),
        ("coupler", coupler, (x, y), slope),
        ("rocker", rocker, (span, 0), lift),
    ]:
        scene["bodies"][name] = bulk(rng, mass * rng.uniform(0.5, 2), length) | {
            "com": point(length / 2, 0),
            "guess": {"at": point(*at), "angle": quantity(angle, "rad")},
        }
    for name, bodies, points in [
        ("a", ["ground", "crank"], [point(0, 0), point(0, 0)]),
        ("b", ["crank", "coupler"], [point(crank, 0), point(0, 0)]),
        ("c", ["coupler", "rocker"], [point(coupler, 0), point(rocker, 0)]),
        ("d", ["ground", "rocker"], [point(span, 0), point(0, 0)]),
    ]:
        scene["joints"][name] = {"bodies": bodies, "points": points} | joint_losses(rng, torque)
    scene["joints"]["a"]["start"] = quantity(start, "rad")
    scene["actuators"] = {
        "motor": {"joint": "a"} | drive(rng, torque, inertia, start, rng.choice([-1, 1]) * rng.uniform(0.3, 1.5), duration)
    }
    if rng.random() < 0.3:
        scene["springs"] = {
            "sum": {
                "joints": ["a", "d"],
                "factors": [1, -1],
                "offset": quantity(start - lift, "rad"),
                "stiffness": quantity(torque * decades(rng, 0.1, 3), "N*m/rad"),
                "damping": quantity(torque * decades(rng, 1e-4, 1e-2), "N*m*s/rad"),
            }
        }
    elif rng.random() < 0.5:
        scene["springs"] = {
            "linear": {
                "type": "linear",
                "bodies": ["ground", "coupler"],
                "points": [point(span / 2, -20), point(coupler / 2, 5)],
                "rest": "30 mm",
                "stiffness": quantity(decades(rng, 10, 1000), "N/m"),
                "damping": quantity(decades(rng, 0.01, 1), "N*s/m"),
            }
        }
    if rng.random() < 0.3:
        scene["rotors"] = {
            "gear": {"joints": ["a", "d"], "factors": [0.5, 0.5], "inertia": quantity(inertia * decades(rng, 0.1, 3), "kg*m^2")}
        }
    if rng.random() < 0.3:
        mean = drive(rng, torque, inertia, (start + lift) / 2, rng.uniform(-0.5, 0.5), duration)
        scene["actuators"]["mean"] = {"joints": ["a", "d"], "factors": [0.5, 0.5]} | mean
    scene["bodies"]["coupler"]["outlines"] = {"pad": outline(rng, coupler / 3, (coupler / 2, coupler / 5), FACES)}
    side, beyond = rng.choice([-1, 1]), coupler / 5 + coupler / 6 + 10 + decades(rng, 0.2, 3)
    if side < 0:
        beyond -= 2 * coupler / 5
    normal = (-side * math.sin(slope), side * math.cos(slope))
    at = point(x + coupler / 2 * math.cos(slope) + beyond * normal[0], y + coupler / 2 * math.sin(slope) + beyond * normal[1])
    speed = decades(rng, 0.1, 3)
    velocity = [quantity(-speed * axis + rng.uniform(-0.1, 0.1), "m/s") for axis in normal]
    scene["bodies"]["object"] = free_body(rng, 20, at=at, velocity=velocity, spin=quantity(rng.uniform(-20, 20), "rad/s"))
    scene["contacts"].append(contact(rng, "coupler.pad", "object"))
    return scene


def sliders(rng):
    """A slider carries a pendulum, with brake, friction, stop and a tendon; a body lies on the slider or hits the pendulum."""
    duration = decades(rng, 15, 80)
    scene = base(rng, duration)
    scene["laws"] |= {"end": {"stiffness": 1e6, "damping": "1 s/m"}, "stop": law(rng, "rad")}
    mass, length = decades(rng, 20, 500), rng.uniform(25, 60)
    travel = rng.choice([-1, 1]) * decades(rng, 1, 20) * 1e-3
    force = mass * 1e-3 * 2 * abs(travel) / (duration * 1e-3) ** 2 * decades(rng, 1, 30)
    inertia = 1e-9 * mass * 0.3 * length**2 / 3
    torque = inertia * 2 / (duration * 1e-3) ** 2 * decades(rng, 1, 50)
    plate = {"type": "box", "center": point(0, 0), "size": point(60, 10), "rounding": "1 mm"}
    scene["bodies"]["slider"] = bulk(rng, mass, 40) | {"outlines": {"plate": plate}}
    tip = outline(rng, length / 3, (0.8 * length, 0), FACES)
    scene["bodies"]["arm"] = bulk(rng, 0.3 * mass, length) | {
        "com": point(length / 2, 0),
        "guess": {"at": point(-40, 0), "angle": "90 deg"},
        "outlines": {"tip": tip},
    }
    scene["joints"]["rail"] = {
        "type": "prismatic",
        "bodies": ["ground", "slider"],
        "points": [point(0, 0), point(0, 0)],
        "axis": quantity(rng.choice([0, 0, rng.uniform(-30, 30)]), "deg"),
        "start": "0 mm",
    }
    scene["joints"]["rail"] |= joint_losses(rng, force, "N", "m/s")
    scene["joints"]["rail"] |= {"lower": "-15 mm", "upper": "15 mm", "stop": "end"} if rng.random() < 0.5 else {}
    scene["joints"]["pin"] = {
        "bodies": ["slider", "arm"],
        "points": [point(-40, 0), point(0, 0)],
        "offset": "90 deg",
        "start": "0 rad",
        "start_rate": quantity(rng.uniform(-5, 5), "rad/s"),
    }
    scene["joints"]["pin"] |= joint_losses(rng, torque) | (
        {"lower": "-60 deg", "upper": "60 deg", "stop": "stop"} if rng.random() < 0.5 else {}
    )
    scene["actuators"] = {"rail": {"joint": "rail"} | drive(rng, force, mass * 1e-3, 0, travel, duration, "N")}
    how = rng.choice(["drive", "tendon", "spring", "none"])
    if how == "drive":
        scene["actuators"]["pin"] = {"joint": "pin"} | drive(rng, torque, inertia, 0, rng.uniform(-1, 1), duration)
    elif how == "tendon":
        path = [
            {"eyelet": "ground", "at": point(-70, 30)},
            {"eyelet": "slider", "at": point(-52, 5)},
            {"eyelet": "arm", "at": point(length / 2, rng.choice([-4, 4]))},
        ]
        scene["tendons"] = {
            "cord": {
                "path": path,
                "stiffness": quantity(decades(rng, 1e3, 1e5), "N/m"),
                "damping": quantity(decades(rng, 0.1, 30), "N*s/m"),
                "pretension": quantity(decades(rng, 0.1, 5), "N"),
            }
        }
    elif how == "spring":
        scene["springs"] = {"pin": {"joint": "pin", "stiffness": quantity(torque, "N*m/rad"), "rest": quantity(rng.uniform(-1, 1), "rad")}}
    if rng.random() < 0.6:
        scene["bodies"]["object"] = free_body(
            rng,
            24,
            at=point(rng.uniform(-10, 15), 5 + 12 + decades(rng, 0.02, 5)),
            velocity=[quantity(rng.uniform(-0.3, 0.3), "m/s"), quantity(-decades(rng, 0.01, 1), "m/s")],
        )
        scene["contacts"] += [contact(rng, "object", "slider.plate"), contact(rng, "object", "arm.tip")]
    else:
        scene["ground"] = {"outlines": {"wall": outline(rng, 20, (-40 + 18 + length / 6, 0.8 * length))}}
        scene["contacts"].append(contact(rng, "arm.tip", "ground.wall"))
    return scene


def thrown(rng):
    """One to three free bodies fall on a floor or hit each other."""
    scene = base(rng, decades(rng, 10, 100))
    count, size = rng.randint(1, 3), decades(rng, 10, 50)
    names = [f"part_{index}" for index in range(count)]
    for index, name in enumerate(names):
        velocity = [quantity(rng.uniform(-1, 1), "m/s"), quantity(-decades(rng, 0.05, 3), "m/s")]
        gap = decades(rng, 0.05, 5)
        kinds = FACES if index % 2 else (*FACES, "ellipse")
        scene["bodies"][name] = free_body(
            rng,
            size,
            kinds,
            at=point(rng.uniform(-0.2, 0.2) * size, size / 2 + gap + index * (size + gap)),
            angle=quantity(rng.choice([0, rng.uniform(-180, 180)]), "deg"),
            velocity=velocity,
            spin=quantity(rng.choice([0, rng.uniform(-30, 30)]), "rad/s"),
        )
    floor = (
        {"type": "half_plane", "normal": [round(rng.uniform(-0.3, 0.3), 3), 1]}
        if rng.random() < 0.6
        else {"type": "box", "center": point(0, -5), "size": point(5 * size, 10), "rounding": "1 mm"}
    )
    scene["ground"] = {"outlines": {"floor": floor}}
    scene["laws"]["floor"] = law(rng)
    scene["contacts"].append(contact(rng, "part_*", "ground.floor", "floor"))
    scene["contacts"] += [contact(rng, first, second) for first, second in zip(names, names[1:])]
    return scene


def finger_or_gripper(rng):
    """A scene of kind "finger" or "gripper" whose object is no disc."""
    kind = rng.choice(["finger", "gripper"])
    scene = {"kind": kind, "duration": quantity(decades(rng, 10, 30), "ms")}
    shape = outline(rng, rng.uniform(30, 40))
    scene["object"] = {"radius": "20 mm", "outline": shape}
    if kind == "finger":
        scene["object"]["centre"] = point(-15.5 + rng.uniform(-1, 1), rng.uniform(19.5, 22))
    else:
        scene["object"] |= {
            "height": quantity(rng.uniform(20.5, 23), "mm"),
            "angle": quantity(rng.uniform(-90, 90), "deg"),
            "mass": quantity(decades(rng, 10, 200), "g"),
        }
    scene["design"] = {
        "base": "15.5 mm",
        "l21_fraction": round(rng.uniform(0.3, 1), 3),
        "phi22": quantity(rng.uniform(90, 130), "deg"),
        "arm_ratio": round(rng.uniform(0.4, 0.7), 3),
    }
    scene["motor"] = {"torque": quantity(decades(rng, 100, 600), "N*mm")}
    scene["spring"] = {"torque": quantity(decades(rng, 30, 130), "N*mm")}
    stiffness, damping = float(f"{decades(rng, 1e7, 1e9):.4g}"), decades(rng, 1e4, 1e6)
    scene["contact"] = {
        "stiffness_si": stiffness,
        "damping": quantity(damping, "N*s/m"),
        "friction": {"mu_static": round(rng.uniform(0, 1.2), 3)},
    }
    if rng.random() < 0.4:
        scene["contact"]["friction"] |= {"law": "bristle", "bristle_damping": quantity(decades(rng, 10, 1000), "N*s/m")}
    if kind == "finger":
        return scene
    if rng.random() < 0.4:
        at = quantity(rng.uniform(2, 10), "ms")
        scene["motor"] |= {"brake": "two-way", "brake_torque": quantity(decades(rng, 50, 2000), "N*mm"), "brake_at": at}
        scene["motor"] |= {"brake_law": "bristle"} if rng.random() < 0.5 else {}
    if rng.random() < 0.3:
        scene["differential"] = {"seesaw_inertia": quantity(decades(rng, 1e-7, 1e-5), "kg*m^2")}
    if rng.random() < 0.3:
        scene["table"] = {"level": "46 mm"}
    return scene


FAMILIES = [jaws, tendon_fingers, linkage, sliders, thrown, finger_or_gripper]


def random_scene(seed):
    rng = random.Random(seed)
    family = FAMILIES[seed % len(FAMILIES)]
    return family.__name__, family(rng)


def toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def scene_text(scene):
    """The scene as a file: one section for every part."""
    lines = [f"{key} = {toml(value)}" for key, value in scene.items() if not isinstance(value, dict) and key != "contacts"]
    for key, value in scene.items():
        if isinstance(value, dict):
            parts = (
                {f"{key}.{name}": part for name, part in value.items()}
                if all(isinstance(part, dict) for part in value.values())
                else {key: value}
            )
            for name, part in parts.items():
                lines += ["", f"[{name}]", *(f"{item} = {toml(content)}" for item, content in part.items())]
    for entry in scene.get("contacts", []):
        lines += ["", "[[contacts]]", *(f"{item} = {toml(content)}" for item, content in entry.items())]
    return "\n".join(lines) + "\n"


# ----------------------------------------------------------------------------------------------------------------- runs


def run(scene, *options):
    """Status, JSON document and message of a run. The status of a killed run is "killed"."""
    begin = time.monotonic()
    try:
        result = subprocess.run(
            [PHALANX, "run", str(scene), "--json", "--quiet", *options], capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return {"status": "killed", "document": None, "message": f"more than {TIME_LIMIT_S:.0f} s", "wall_s": TIME_LIMIT_S}
    document = json.loads(result.stdout) if result.stdout.startswith("{") else None
    return {"status": result.returncode, "document": document, "message": result.stderr.strip(), "wall_s": time.monotonic() - begin}


def difference(first, second):
    """Largest differences of angles (rad) and positions (m) of the bodies at the end."""
    angle = position = 0.0
    for name, body in first["bodies"].items():
        other = second["bodies"][name]
        angle = max(angle, abs(body["angle_rad"] - other["angle_rad"]))
        position = max(position, math.hypot(body["x_m"] - other["x_m"], body["y_m"] - other["y_m"]))
    return angle, position


def peak_difference(first, second):
    """Largest relative difference of the peak forces of contacts, of those above a twentieth of the largest."""
    peaks = {name: contact.get("peak_normal_n") or 0 for name, contact in second["contacts"].items()}
    large = {name: peak for name, peak in peaks.items() if peak > max(peaks.values()) / 20}
    return max((abs(first["contacts"][name]["peak_normal_n"] / peak - 1) for name, peak in large.items()), default=0)


def corner_m(scene, name):
    """Radius of the corners of an outline `body.outline[corner]`: no contact should be deeper than those of its two outlines."""
    body, outline = name.split("[")[0].split(".")
    mirror = scene.get("mirror")
    if mirror and body.startswith(mirror["to"]):
        body = mirror["from"] + body.removeprefix(mirror["to"])
    shape = (scene["ground"] if body == "ground" else scene["bodies"][body])["outlines"][outline]
    corner = shape.get("rounding", shape.get("radius"))
    return float(corner.split()[0]) * 1e-3 if corner else math.inf


def is_deep(scene, contacts):
    """Whether a contact is deeper than the corners of its outlines, where the direction of its force jumps."""
    depths = [(name.split("/"), contact.get("max_penetration_m", 0)) for name, contact in contacts.items() if "/" in name]
    return any(depth > sum(corner_m(scene, outline) for outline in outlines) for outlines, depth in depths)


def is_beyond(angle_rad, position_m, check):
    """Whether a difference exceeds the bar of a check."""
    bar = check["bar"]
    angle_bar, position_bar = (FREE_BODIES_BAR, bar) if check.get("error_m") is not None else (bar, bar * UNIT_M)
    return angle_rad > max(angle_bar, ANGLE_RAD) or position_m > max(position_bar, POSITION_M)


def failure(result):
    """Outcome of a run without a complete result."""
    status, message = result["status"], result["message"]
    if status == "killed":
        return "killed"
    if "panicked" in message or status not in (0, 2, 3):
        return "panic"
    if status == 2:
        return "refused" if message else "no message"
    document = result["document"]
    if status == 3 or not document["completed"]:
        return "ended early" if (document or {}).get("error") or message else "no message"
    return None


def verdict(document):
    """Verdict of the check. A run of more than 20,000 steps has none."""
    return (document["check"] or {"verdict": "not checked"})["verdict"]


def judge(scene, path):
    """Outcome of a scene, suspicions, and the figures behind them."""
    analytic = run(path)
    record = {"suspicions": [], "runs": {"analytic": analytic}}
    record["outcome"] = failure(analytic)
    suspicions = record["suspicions"]
    engine = record["runs"]["engine"] = run(path, "--model", "engine") if record["outcome"] != "refused" else analytic
    failed = failure(engine)
    for model, outcome in [("analytic", record["outcome"]), ("engine", failed)]:
        if outcome in ("panic", "killed", "no message"):
            suspicions.append(f"{model}: {outcome}")
    if record["outcome"] == "refused" and "help:" not in analytic["message"]:
        suspicions.append("refused without a remedy")
    if failed and not record["outcome"]:
        suspicions.append(f"the engine alone fails: {failed}")
    if record["outcome"]:
        return record
    document, check = analytic["document"], analytic["document"]["check"]
    record["outcome"] = verdict(document)
    record["engine_outcome"] = failed or verdict(engine["document"])
    record["touches"] = any(contact["touchdowns"] for contact in document["contacts"].values())
    if scene["kind"] == "mechanism":
        record["deep"] = is_deep(scene, document["contacts"])
    suspicions += [f"analytic: {warning}" for warning in document["warnings"]]
    if not failed:
        suspicions += [f"engine: {warning}" for warning in engine["document"]["warnings"]]
    if record["outcome"] != "sure":
        return record
    reference = record["runs"]["reference"] = run(path, "--preset", "reference", "--no-check")
    if failure(reference):
        suspicions.append(f"the reference fails: {failure(reference)}")
        return record
    angle, position = record["reference"] = difference(document, reference["document"])
    if is_beyond(angle, position, check):
        suspicions.append(f"silently wrong: {angle:.1e} rad, {position:.1e} m from the reference")
    record["peak"] = peak_difference(document, reference["document"])
    if record["peak"] > PEAK:
        suspicions.append(f"silently wrong: a peak force {record['peak']:.0%} from the reference")
    if failed:
        return record
    angle, position = record["engine"] = difference(engine["document"], reference["document"])
    if record["engine_outcome"] == "sure":
        if is_beyond(angle, position, engine["document"]["check"]):
            suspicions.append(f"silently wrong engine: {angle:.1e} rad, {position:.1e} m from the reference")
    elif angle > MODELS_RAD or position > MODELS_M:
        fine = record["runs"]["fine"] = run(path, "--model", "engine", "--no-check", *FINE)
        record["fine"] = None if failure(fine) else difference(fine["document"], reference["document"])
        if not record["fine"] or max(record["fine"]) > 0.5 * max(angle, position):
            suspicions.append(f"models differ: {angle:.1e} rad, {position:.1e} m; with finer steps {record['fine']}")
    return record


def print_table(records):
    families = sorted({record["family"] for record in records})
    outcomes = ["sure", "uncertain", "chaotic", "unknown", "not checked", "ended early", "refused", "killed", "panic", "no message"]
    outcomes = [outcome for outcome in outcomes if any(record["outcome"] == outcome for record in records)]
    titles = ["scenes", "tried", "with contact", "deep contact", *outcomes, "engine sure"]
    titles += ["reference: median, largest", "engine: median, largest"]
    print(f"\n| {' | '.join(titles)} |\n{'|---' * len(titles)}|")
    for family in [*families, "all"]:
        chosen = [record for record in records if family in (record["family"], "all")]
        counts = Counter(record["outcome"] for record in chosen)
        columns = [
            family,
            len(chosen),
            *(sum(record.get(key, False) for record in chosen) for key in ("touches", "deep")),
            *(counts[outcome] for outcome in outcomes),
        ]
        columns.append(sum(record.get("engine_outcome") == "sure" for record in chosen))
        for key in ("reference", "engine"):
            values = [max(record[key]) for record in chosen if key in record]
            columns.append(f"{statistics.median(values):.1e}, {max(values):.1e}" if values else "")
        print(f"| {' | '.join(map(str, columns))} |")
    print("\nDifferences are those of the poses at the end, in rad or m, where the analytic model is sure.")
    messages = Counter(re.sub(r"\d[\d.e-]*", "#", record["message"]) for record in records if record.get("message"))
    for message, count in messages.most_common():
        print(f"{count} x {message}")
    print("\nSuspicious seeds:")
    for record in records:
        for suspicion in record["suspicions"]:
            deep = ", deep contact" if record.get("deep") else ""
            print(f"  {record['seed']} ({record['family']}{deep}): {suspicion}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=300, help="number of scenes (default: 300)")
    parser.add_argument("--first", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--seed", type=int, help="this seed only")
    parser.add_argument("--minutes", type=float, default=math.inf, help="start no scene after this time")
    parser.add_argument("--keep", type=Path, help="directory for scenes and results")
    parser.add_argument("--json", type=Path, help="file for the figures of every seed, one a line")
    arguments = parser.parse_args()
    seeds = [arguments.seed] if arguments.seed is not None else range(arguments.first, arguments.first + arguments.scenes)
    begin, records = time.monotonic(), []
    with tempfile.TemporaryDirectory() as temporary:
        directory = arguments.keep or Path(temporary)
        directory.mkdir(parents=True, exist_ok=True)
        for seed in seeds:
            if time.monotonic() - begin > 60 * arguments.minutes:
                break
            family, scene = random_scene(seed)
            path = directory / f"random-{seed}.toml"
            path.write_text(scene_text(scene), encoding="utf-8")
            record = {"seed": seed, "family": family} | judge(scene, path)
            runs = record.pop("runs")
            record["wall_s"] = {name: round(result["wall_s"], 2) for name, result in runs.items()}
            for name, result in runs.items():
                if failure(result):
                    error = (result["document"] or {}).get("error") or {"reason": result["message"]}
                    record.setdefault("message", f"{name}: {error['reason']}")
                if arguments.keep:
                    (directory / f"random-{seed}-{name}.json").write_text(json.dumps(result, indent=2), encoding="utf-8")
            records.append(record)
            print(seed, family, record["outcome"], *record["suspicions"], sep=" | ", file=sys.stderr, flush=True)
            if arguments.json:
                with arguments.json.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(record) + "\n")
    print_table(records)


if __name__ == "__main__":
    main()
