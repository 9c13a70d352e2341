#!/usr/bin/env python3
"""Draws a closing from its log as one animated SVG.

usage: draw_moving.py LOG.mcap OUT.svg      (needs tools/requirements.txt)

The picture contains both fingers of the gripper, the second as the mirror image of the first. The animation pauses at
each first contact. Arrows show the forces on the object; their length is the logarithm of the force.
"""

import sys
from math import atan2, cos, degrees, log10, sin
from pathlib import Path

from draw_closing import BACKGROUND, COUPLER, DARK, DISTAL, DRIVER, GREY, OBJECT, PALM, PROXIMAL, RED, TEXT, column, e, joint_states, read

# Extent of the picture, mm: the object in the middle, the time axis below.
WIDTH, TOP, BOTTOM = 116.0, 43.0, 27.0
# Durations on the screen, s: the phases of the motion, the pause at each first contact, and the still picture at the
# end.
SWING_S, PAUSE_S, FOLD_S, SETTLE_S, END_S = 2.0, 0.7, 1.6, 0.7, 1.6
FRAMES_PER_PHASE = 40


def schedule(first_contact: dict[str, float], end: float) -> list[tuple[float, float]]:
    """Returns the frames: (time on the screen, time of the run), s."""
    first, second = first_contact["proximal"], first_contact["distal"]
    phases = [(SWING_S, 0.0, first), (PAUSE_S, first, first), (FOLD_S, first, second), (PAUSE_S, second, second), (SETTLE_S, second, end), (END_S, end, end)]
    frames, screen_s = [(0.0, 0.0)], 0.0
    for duration, begin, until in phases:
        count = FRAMES_PER_PHASE if until > begin else 1
        frames += [(screen_s + duration * i / count, begin + (until - begin) * i / count) for i in range(1, count + 1)]
        screen_s += duration
    return frames


def interpolate(time, values, t: float) -> float:
    """Interpolates linearly between two samples."""
    import numpy as np

    return float(np.interp(t, time, values))


def animation(kind: str, frames, values: list[str]) -> str:
    """Returns the animation of one attribute, or of the transform if `kind` is "translate" or "rotate"."""
    total = frames[-1][0]
    times = ";".join(f"{screen_s / total:.4f}" for screen_s, _ in frames)
    common = f'keyTimes="{times}" values="{";".join(values)}" dur="{total:.2f}s" repeatCount="indefinite"'
    if kind in ("translate", "rotate"):
        return f'<animateTransform attributeName="transform" type="{kind}" {common}/>'
    return f'<animate attributeName="{kind}" {common}/>'


def link(length: float, half_width: float, angle: float, css_class: str) -> str:
    """Returns a bar that starts at the origin."""
    x, y = length * e(angle)
    return f'<line x2="{x:.3f}" y2="{y:.3f}" class="rim" stroke-width="{2 * half_width + 0.5:.2f}"/><line x2="{x:.3f}" y2="{y:.3f}" class="{css_class}" stroke-width="{2 * half_width:.2f}"/>'


def finger(g, frames, time, states) -> str:
    """Returns the four bodies with their animated translations and rotations."""
    samples = {name: column(states, f"{name}_rad") for name in ("q11", "q12", "q21", "q22")}
    angles = [{name: interpolate(time, values, t) for name, values in samples.items()} for _, t in frames]

    def body(shapes: str, position, rotation) -> str:
        translations = [f"{x:.3f} {y:.3f}" for x, y in map(position, angles)]
        rotations = [f"{degrees(rotation(q)):.3f}" for q in angles]
        return f'<g>{animation("translate", frames, translations)}<g>{animation("rotate", frames, rotations)}{shapes}</g></g>'

    fixed = lambda q: (0.0, 0.0)
    thin, w, phi = 1.2, g["w"], g["phi22"]
    arm, tip = g["l22"] * e(0.0), g["t22"] * e(phi)
    area = f'<polygon points="0,0 {arm[0]:.3f},{arm[1]:.3f} {tip[0]:.3f},{tip[1]:.3f}" class="distal-fill"/>'
    joint = lambda x, y: f'<circle cx="{x:.3f}" cy="{y:.3f}" r="0.9" class="joint"/>'
    return "".join([
        body(link(g["l11"], thin, 0.0, "driver") + joint(g["l11"], 0), fixed, lambda q: q["q11"]),
        body(link(g["l12"], thin, 0.0, "coupler"), lambda q: g["l11"] * e(q["q11"]), lambda q: q["q11"] + q["q12"]),
        body(area + link(g["l22"], thin, 0.0, "distal") + link(g["t22"], w, phi, "distal") + joint(*arm), lambda q: g["l21"] * e(q["q21"]), lambda q: q["q21"] + q["q22"]),
        body(link(g["l21"], w, 0.0, "proximal") + joint(g["l21"], 0) + joint(0, 0), fixed, lambda q: q["q21"]),
    ])


def arrow(g, frames, time, contact, first_contact: float, contact_point) -> str:
    """Returns the arrow of a force on the object, from the contact point inwards; its length is logarithmic."""
    import numpy as np

    force = column(contact, "normal_n")
    # An impact lasts less than a frame, so each frame shows the largest force since the previous one.
    lengths, previous = [], 0.0
    for _, t in frames:
        recent = force[(time >= previous) & (time <= t)] if t > previous else force[np.abs(time - t).argmin() :][:1]
        size = max(float(recent.max(initial=0.0)), interpolate(time, force, t))
        if abs(t - first_contact) < 1e-9:
            size = float(force[(time >= first_contact - 2e-5) & (time <= first_contact + 2e-5)].max(initial=0.0))
        lengths.append(3.0 * log10(1.0 + size) if size > 0.05 else 0.0)
        previous = t
    x, y = contact_point
    inward = [c - p for c, p in zip(g["centre"], contact_point)]
    angle = degrees(atan2(inward[1], inward[0]))
    opacity = animation("opacity", frames, ["1" if length > 0.2 else "0" for length in lengths])
    ends = animation("x2", frames, [f"{length:.3f}" for length in lengths])
    heads = animation("translate", frames, [f"{length:.3f} 0" for length in lengths])
    return (
        f'<g transform="translate({x:.3f} {y:.3f}) rotate({angle:.3f})" opacity="0">{opacity}'
        f'<line x2="0" y2="0" class="force">{ends}</line><path d="M-2.4,-1.5 L1.2,0 L-2.4,1.5 Z" class="force-head">{heads}</path></g>'
    )


def time_axis(frames, first_contact, end: float, middle: float) -> str:
    """Returns the time axis below the palm, with the first contacts and a cursor."""
    left, right, y = middle - 46, middle + 46, 19.0
    x = lambda t: left + (right - left) * t / end
    ticks = "".join(f'<text x="{x(ms * 1e-3):.2f}" y="{y + 5:.2f}">{ms} ms</text>' for ms in range(0, int(end * 1e3) + 1, 2))
    names = {"proximal": "proximal phalanx touches", "distal": "distal phalanx touches"}
    anchor = {"proximal": "end", "distal": "start"}
    marks = "".join(
        f'<line x1="{x(t):.2f}" x2="{x(t):.2f}" y1="{y - 1.4:.2f}" y2="{y + 1.4:.2f}" class="mark"/>'
        f'<text class="word {anchor[phalanx]}" x="{x(t):.2f}" y="{y - 2.6:.2f}">{names[phalanx]}</text>'
        for phalanx, t in first_contact.items()
    )
    cursor = f'<circle r="1.5" class="cursor" cy="{y}">{animation("cx", frames, [f"{x(t):.3f}" for _, t in frames])}</circle>'
    return f'<line x1="{left}" x2="{right}" y1="{y}" y2="{y}" class="axis"/>{marks}{ticks}{cursor}'


def style() -> str:
    """Returns the style sheet, with the colours of the other figures for the light and the dark scheme."""
    rules = {
        ".ground": ("fill", BACKGROUND), ".palm": ("fill", PALM), ".object": ("fill", OBJECT), "text": ("fill", GREY), ".word": ("fill", RED),
        ".rim": ("stroke", GREY), ".driver": ("stroke", DRIVER), ".coupler": ("stroke", COUPLER), ".distal": ("stroke", DISTAL),
        ".distal-fill": ("fill", DISTAL), ".proximal": ("stroke", PROXIMAL), ".axis": ("stroke", GREY), ".mark": ("stroke", RED), ".cursor": ("fill", TEXT),
        ".force": ("stroke", RED), ".force-head": ("fill", RED), ".joint": ("fill", BACKGROUND), ".edge": ("stroke", GREY),
    }
    light = " ".join(f"{selector} {{ {name}: {colour}; }}" for selector, (name, colour) in rules.items())
    dark = " ".join(f"{selector} {{ {name}: {DARK[colour]}; }}" for selector, (name, colour) in rules.items())
    return (
        "<style>line { stroke-linecap: round; } text { font: 3.1px system-ui, 'DejaVu Sans', sans-serif; text-anchor: middle; } "
        ".end { text-anchor: end; } .start { text-anchor: start; } .edge { fill: none; stroke-width: 0.4; } .joint { stroke: none; } "
        f".axis {{ stroke-width: 0.4; }} .mark {{ stroke-width: 0.6; }} .force {{ stroke-width: 0.9; }} {light} "
        f"@media (prefers-color-scheme: dark) {{ {dark} }}</style>"
    )


def main(log: str, out: str):
    topics, g = read(log)
    states = joint_states(topics)
    time = column(states, "timestamp")
    first_contact, contact_points = {}, {}
    for phalanx in ("proximal", "distal"):
        contact = topics[f"/contact/{phalanx}"]
        first_contact[phalanx] = float(column(contact, "timestamp")[(column(contact, "gap_m") < 0).argmax()])
    end = 10e-3
    frames = schedule(first_contact, end)
    last = states[-1]
    # Contact points of the final state: on the object, in the direction of the nearest point of each phalanx axis.
    joint_21 = g["l21"] * e(last.q21_rad)
    lines = {"proximal": ((0.0, 0.0), joint_21), "distal": (joint_21, joint_21 + g["t22"] * e(last.q21_rad + last.q22_rad + g["phi22"]))}
    for phalanx, (a, b) in lines.items():
        d = (b[0] - a[0], b[1] - a[1])
        s = ((g["centre"][0] - a[0]) * d[0] + (g["centre"][1] - a[1]) * d[1]) / (d[0] ** 2 + d[1] ** 2)
        foot = (a[0] + s * d[0], a[1] + s * d[1])
        angle = atan2(foot[1] - g["centre"][1], foot[0] - g["centre"][0])
        contact_points[phalanx] = (g["centre"][0] + g["radius"] * cos(angle), g["centre"][1] + g["radius"] * sin(angle))
    arrows = "".join(
        arrow(g, frames, column(topics[f"/contact/{phalanx}"], "timestamp"), topics[f"/contact/{phalanx}"], first_contact[phalanx], point)
        for phalanx, point in contact_points.items()
    )
    middle = g["centre"][0]
    x0 = middle - WIDTH / 2
    height = TOP + BOTTOM
    Path(out).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{x0:.2f} {-TOP} {WIDTH} {height}" width="{6 * WIDTH:.0f}" height="{6 * height:.0f}" role="img">\n'
        f"<title>A closing, slowed down: swing, first contact, second contact</title>\n<!-- tools/draw_moving.py -->\n{style()}\n"
        f'<rect class="ground" x="{x0:.2f}" y="{-TOP}" width="{WIDTH}" height="{height}"/>\n<g transform="scale(1 -1)">\n'
        f'<rect class="palm" x="{middle - 50}" y="-3.4" width="100" height="3.4"/><line class="edge" x1="{middle - 50}" x2="{middle + 50}" y1="0" y2="0"/>\n'
        f'<circle class="object" cx="{g["centre"][0]}" cy="{g["centre"][1]}" r="{g["radius"]}"/>\n'
        f'<g id="finger">\n{finger(g, frames, time, states)}\n{arrows}\n</g>\n'
        f'<use href="#finger" transform="translate({2 * middle:.3f} 0) scale(-1 1)"/>\n'
        f"</g>\n{time_axis(frames, first_contact, end, middle)}\n</svg>\n"
    )


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
