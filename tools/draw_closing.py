#!/usr/bin/env python3
"""Draws a closing from its log: the finger at five instants, and joint angles and contact forces over time.

usage: draw_closing.py LOG.mcap OUT.svg      (needs tools/requirements.txt)

`phalanx scene show --resolved` (from $PHALANX or `cargo run`) gives the lengths of the scene that is attached to the
log.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from types import SimpleNamespace

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from dark_scheme import add_dark_scheme
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

# Colours of the page and of all figures, each with its replacement on a dark background.
DARK = {
    "#ffffff": "#1b1f26", "#1b1f26": "#eceff3", "#565e6b": "#a7b0bd", "#0072b2": "#56b4e9", "#c75300": "#ff9a52", "#00875f": "#3ccb9c",
    "#b3261e": "#ff8078", "#b9c2cf": "#4c5766", "#d3d9e2": "#3a4350", "#a9d2ec": "#1f5678", "#f5c7a1": "#7d4316", "#e3dccb": "#4a453a",
    "#e4e7ec": "#262c35",
}
BACKGROUND, TEXT, GREY, BLUE, ORANGE, GREEN, RED, DRIVER, COUPLER, PROXIMAL, DISTAL, OBJECT, PALM = DARK
UNITS = {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1e3, "deg": np.pi / 180, "rad": 1.0}


def quantity(text: str) -> float:
    """Parses a length into mm or an angle into rad."""
    number, unit = text.split()
    return float(number) * UNITS[unit]


def read(path: str):
    """Returns the messages by topic, and the geometry in mm and rad."""
    topics: dict[str, list] = {}
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append(message)
        scene = next(iter(reader.iter_attachments())).data
    with tempfile.NamedTemporaryFile(suffix=".toml") as file:
        file.write(scene)
        file.flush()
        phalanx = [os.environ["PHALANX"]] if "PHALANX" in os.environ else ["cargo", "run", "--release", "--quiet", "--"]
        command = [*phalanx, "scene", "show", file.name, "--resolved"]
        shown = subprocess.run(command, check=True, capture_output=True, text=True, cwd=Path(__file__).parent.parent)
    scene = tomllib.loads(shown.stdout)
    geometry = {name: quantity(value) for name, value in scene["lengths"].items()}
    geometry["w"] = quantity(scene["half_width"])
    geometry["radius"] = quantity(scene["object"]["radius"])
    geometry["centre"] = [quantity(x) for x in scene["object"]["centre"]]
    return topics, geometry


def joint_states(topics) -> list:
    """The coordinates of the finger at each sample, from the messages of its joints."""
    joints = ["11", "21", "12", "22", "13"]
    states = []
    for messages in zip(*(topics[f"/joint/q{index}"] for index in joints)):
        state = {"timestamp": messages[0].timestamp}
        state |= {f"q{index}_rad": message.angle_rad for index, message in zip(joints, messages)}
        state |= {f"qd{index}_rad_s": message.rate_rad_s for index, message in zip(joints, messages)}
        states.append(SimpleNamespace(**state))
    return states


def column(messages, name: str) -> np.ndarray:
    """Returns one field of all messages."""
    return np.array([getattr(message, name) for message in messages])


def e(angle: float) -> np.ndarray:
    """Returns the unit vector at an angle from the x-axis."""
    return np.array([np.cos(angle), np.sin(angle)])


def capsule(axis, a, b, w, **style):
    """Draws a link from `a` to `b` with half width `w` as a rounded polygon."""
    direction = np.arctan2(*(b - a)[::-1])
    arc = np.linspace(-np.pi / 2, np.pi / 2, 24)
    points = [b + w * e(direction + t) for t in arc] + [a + w * e(direction + np.pi + t) for t in arc]
    axis.add_patch(plt.Polygon(points, **style))


def pose(axis, g, state, title: str):
    """Draws the finger, the object and the palm at one instant."""
    q11, q12, q21, q22 = state.q11_rad, state.q12_rad, state.q21_rad, state.q22_rad
    origin = np.zeros(2)
    a12, a22 = g["l11"] * e(q11), g["l21"] * e(q21)
    a13 = a12 + g["l12"] * e(q11 + q12)
    tip = a22 + g["t22"] * e(q21 + q22 + g["phi22"])
    axis.axhspan(-30, 0, color=PALM, lw=0)
    axis.axhline(0, color=GREY, lw=1)
    axis.add_patch(plt.Circle(g["centre"], g["radius"], fc=OBJECT, ec=GREY, lw=1))
    axis.add_patch(plt.Polygon([a22, a13, tip], fc=DISTAL, ec="none"))
    capsule(axis, origin, a12, 1.2, fc=DRIVER, ec=GREY, lw=0.5)
    capsule(axis, a12, a13, 1.2, fc=COUPLER, ec=GREY, lw=0.5)
    capsule(axis, a22, a13, 1.2, fc=DISTAL, ec=GREY, lw=0.5)
    capsule(axis, origin, a22, g["w"], fc=PROXIMAL, ec=TEXT, lw=0.6)
    capsule(axis, a22, tip, g["w"], fc=DISTAL, ec=TEXT, lw=0.6)
    for joint in (origin, a12, a22, a13):
        axis.plot(*joint, "o", ms=3.2, mfc=BACKGROUND, mec=TEXT, mew=0.8)
    axis.set(xlim=(-38, 34), ylim=(-17, 44), aspect="equal")
    axis.axis("off")
    axis.set_title(title, fontsize=8.5, color=TEXT)


def main(log: str, out: str):
    topics, g = read(log)
    states = joint_states(topics)
    time = column(states, "timestamp") * 1e3
    first_contact = {}
    for phalanx in ("proximal", "distal"):
        contact = topics[f"/contact/{phalanx}"]
        gap = column(contact, "gap_m")
        first_contact[phalanx] = column(contact, "timestamp")[np.argmax(gap < 0)] * 1e3
    proximal, distal = first_contact["proximal"], first_contact["distal"]
    instants = [0.0, 0.75 * proximal, proximal, 0.5 * sum(first_contact.values()), distal]
    captions = ["start", "swing", "proximal contact", "distal closes", "distal contact"]

    plt.rcParams.update({"font.size": 8, "font.family": "DejaVu Sans", "svg.hashsalt": "phalanx", "svg.fonttype": "path"})
    plt.rcParams.update({key: TEXT for key in ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")})
    plt.rcParams.update({"axes.facecolor": BACKGROUND})
    figure = plt.figure(figsize=(9.6, 4.3), facecolor=BACKGROUND)
    poses = figure.add_gridspec(1, 5, left=0.01, right=0.99, bottom=0.47, top=0.95, wspace=0.03)
    plots = figure.add_gridspec(1, 2, left=0.065, right=0.985, bottom=0.1, top=0.44, wspace=0.16)
    for i, (instant, caption) in enumerate(zip(instants, captions)):
        state = states[int(np.argmin(abs(time - instant)))]
        pose(figure.add_subplot(poses[i]), g, state, f"{caption}, {instant:.2f} ms")

    angles = figure.add_subplot(plots[0])
    for name, color in (("q11", BLUE), ("q21", ORANGE), ("q22", GREEN)):
        angles.plot(time, np.degrees(column(states, f"{name}_rad")), color=color, lw=1.4)
        final = np.degrees(getattr(states[-1], f"{name}_rad"))
        angles.annotate(name, (time[-1], final), xytext=(-2, 4), textcoords="offset points", ha="right", color=color)
    angles.set(xlabel="time, ms", ylabel="joint angle, deg", xlim=(0, time[-1]))

    forces = figure.add_subplot(plots[1])
    for phalanx, symbol, color, offset in (("proximal", "F21", BLUE, 4), ("distal", "F22", ORANGE, -11)):
        contact = topics[f"/contact/{phalanx}"]
        t, force = column(contact, "timestamp") * 1e3, column(contact, "normal_n")
        positive = np.where(force > 1e-3, force, np.nan)
        forces.plot(t, positive, color=color, lw=1.4)
        forces.annotate(f"{symbol}, {phalanx}", (t[-1], force[-1]), xytext=(-2, offset), textcoords="offset points", ha="right", color=color)
    forces.set(xlabel="time, ms", ylabel="force on phalanx, N", yscale="log", xlim=(0, time[-1]), ylim=(1, 1e6))
    for axis in (angles, forces):
        axis.spines[["top", "right"]].set_visible(False)
        for instant in first_contact.values():
            axis.axvline(instant, color=RED, lw=0.8, ls=(0, (4, 3)), zorder=0)
    figure.savefig(out, metadata={"Date": None})
    add_dark_scheme(Path(out), DARK)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
