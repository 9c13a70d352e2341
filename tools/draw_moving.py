#!/usr/bin/env python3
"""Draws a closing in motion from its log: one SVG that moves by itself, wherever pictures are shown.

usage: draw_moving.py LOG.mcap OUT.svg      (needs tools/requirements.txt)

Both fingers of the gripper are shown, the second as the mirror image of the first. Time stands still for a moment at each
touch-down. The forces on the object are drawn with the logarithm of their size.
"""

import sys
from math import atan2, cos, degrees, log10, sin
from pathlib import Path

from draw_closing import DARK, DRIVER, COUPLER, GROUND, INK, OBJECT, PALM, PROXIMAL, DISTAL, SOFT, WARM, column, e, read

# What the picture shows, in mm: the object in the middle, the axis of time below.
WIDTH, TOP, BOTTOM = 116.0, 43.0, 27.0
# Seconds on the screen: each part of the motion, and the rest at its end.
SWING_S, HOLD_S, FOLD_S, SETTLE_S, END_S = 2.0, 0.7, 1.6, 0.7, 1.6
FRAMES = 40


def schedule(touches: dict[str, float], end: float) -> list[tuple[float, float]]:
    """(seconds on the screen, seconds of the run) of the frames."""
    first, second = touches["proximal"], touches["distal"]
    parts = [(SWING_S, 0.0, first), (HOLD_S, first, first), (FOLD_S, first, second), (HOLD_S, second, second), (SETTLE_S, second, end), (END_S, end, end)]
    frames, shown = [(0.0, 0.0)], 0.0
    for length, begin, until in parts:
        pieces = FRAMES if until > begin else 1
        frames += [(shown + length * i / pieces, begin + (until - begin) * i / pieces) for i in range(1, pieces + 1)]
        shown += length
    return frames


def interpolated(time, values, at: float) -> float:
    """A value between two samples."""
    import numpy as np

    return float(np.interp(at, time, values))


def animation(kind: str, frames, values: list[str]) -> str:
    """One animated attribute; a transformation if its kind is one."""
    total = frames[-1][0]
    times = ";".join(f"{shown / total:.4f}" for shown, _ in frames)
    common = f'keyTimes="{times}" values="{";".join(values)}" dur="{total:.2f}s" repeatCount="indefinite"'
    if kind in ("translate", "rotate"):
        return f'<animateTransform attributeName="transform" type="{kind}" {common}/>'
    return f'<animate attributeName="{kind}" {common}/>'


def link(length: float, half: float, angle: float, part: str) -> str:
    """A bar from the origin."""
    x, y = length * e(angle)
    return f'<line x2="{x:.3f}" y2="{y:.3f}" class="rim" stroke-width="{2 * half + 0.5:.2f}"/><line x2="{x:.3f}" y2="{y:.3f}" class="{part}" stroke-width="{2 * half:.2f}"/>'


def finger(g, frames, time, states) -> str:
    """The four bodies, each turned and moved."""
    q = {name: column(states, f"{name}_rad") for name in ("q11", "q12", "q21", "q22")}
    at = [{name: interpolated(time, values, t) for name, values in q.items()} for _, t in frames]

    def body(shapes: str, place, angle) -> str:
        moves = [place(p) for p in at]
        turns = [f"{degrees(angle(p)):.3f}" for p in at]
        return f'<g>{animation("translate", frames, [f"{x:.3f} {y:.3f}" for x, y in moves])}<g>{animation("rotate", frames, turns)}{shapes}</g></g>'

    still = lambda p: (0.0, 0.0)
    thin, w, phi = 1.2, g["w"], g["phi22"]
    arm, tip = g["l22"] * e(0.0), g["t22"] * e(phi)
    web = f'<polygon points="0,0 {arm[0]:.3f},{arm[1]:.3f} {tip[0]:.3f},{tip[1]:.3f}" class="distal-fill"/>'
    joint = lambda x, y: f'<circle cx="{x:.3f}" cy="{y:.3f}" r="0.9" class="joint"/>'
    return "".join([
        body(link(g["l11"], thin, 0.0, "driver") + joint(g["l11"], 0), still, lambda p: p["q11"]),
        body(link(g["l12"], thin, 0.0, "coupler"), lambda p: g["l11"] * e(p["q11"]), lambda p: p["q11"] + p["q12"]),
        body(web + link(g["l22"], thin, 0.0, "distal") + link(g["t22"], w, phi, "distal") + joint(*arm), lambda p: g["l21"] * e(p["q21"]), lambda p: p["q21"] + p["q22"]),
        body(link(g["l21"], w, 0.0, "proximal") + joint(g["l21"], 0) + joint(0, 0), still, lambda p: p["q21"]),
    ])


def arrow(g, frames, time, contact, touch: float, place) -> str:
    """The force on the object: from the touching surface inwards, as long as the logarithm of its size."""
    import numpy as np

    force = column(contact, "normal_n")
    # A frame shows the largest force since the frame before: the impact is over between two of them.
    lengths, before = [], 0.0
    for _, t in frames:
        among = force[(time >= before) & (time <= t)] if t > before else force[np.abs(time - t).argmin() :][:1]
        size = max(float(among.max(initial=0.0)), interpolated(time, force, t))
        if abs(t - touch) < 1e-9:
            size = float(force[(time >= touch - 2e-5) & (time <= touch + 2e-5)].max(initial=0.0))
        lengths.append(3.0 * log10(1.0 + size) if size > 0.05 else 0.0)
        before = t
    x, y = place
    inward = [c - p for c, p in zip(g["centre"], place)]
    angle = degrees(atan2(inward[1], inward[0]))
    opacity = animation("opacity", frames, ["1" if length > 0.2 else "0" for length in lengths])
    ends = animation("x2", frames, [f"{length:.3f}" for length in lengths])
    heads = animation("translate", frames, [f"{length:.3f} 0" for length in lengths])
    return (
        f'<g transform="translate({x:.3f} {y:.3f}) rotate({angle:.3f})" opacity="0">{opacity}'
        f'<line x2="0" y2="0" class="force">{ends}</line><path d="M-2.4,-1.5 L1.2,0 L-2.4,1.5 Z" class="force-head">{heads}</path></g>'
    )


def clock(frames, touches, end: float, middle: float) -> str:
    """The axis of time with what happens on it, below the palm."""
    left, right, y = middle - 46, middle + 46, 19.0
    x = lambda t: left + (right - left) * t / end
    ticks = "".join(f'<text x="{x(ms * 1e-3):.2f}" y="{y + 5:.2f}">{ms} ms</text>' for ms in range(0, int(end * 1e3) + 1, 2))
    names = {"proximal": "proximal phalanx touches", "distal": "distal phalanx touches"}
    anchor = {"proximal": "end", "distal": "start"}
    marks = "".join(
        f'<line x1="{x(t):.2f}" x2="{x(t):.2f}" y1="{y - 1.4:.2f}" y2="{y + 1.4:.2f}" class="mark"/>'
        f'<text class="word {anchor[site]}" x="{x(t):.2f}" y="{y - 2.6:.2f}">{names[site]}</text>'
        for site, t in touches.items()
    )
    cursor = f'<circle r="1.5" class="cursor" cy="{y}">{animation("cx", frames, [f"{x(t):.3f}" for _, t in frames])}</circle>'
    return f'<line x1="{left}" x2="{right}" y1="{y}" y2="{y}" class="axis"/>{marks}{ticks}{cursor}'


def style() -> str:
    """The colours of all other pictures, for both schemes."""
    rules = {
        ".ground": ("fill", GROUND), ".palm": ("fill", PALM), ".object": ("fill", OBJECT), "text": ("fill", SOFT), ".word": ("fill", WARM),
        ".rim": ("stroke", SOFT), ".driver": ("stroke", DRIVER), ".coupler": ("stroke", COUPLER), ".distal": ("stroke", DISTAL),
        ".distal-fill": ("fill", DISTAL), ".proximal": ("stroke", PROXIMAL), ".axis": ("stroke", SOFT), ".mark": ("stroke", WARM), ".cursor": ("fill", INK),
        ".force": ("stroke", WARM), ".force-head": ("fill", WARM), ".joint": ("fill", GROUND), ".edge": ("stroke", SOFT),
    }
    light = " ".join(f"{where} {{ {name}: {colour}; }}" for where, (name, colour) in rules.items())
    dark = " ".join(f"{where} {{ {name}: {DARK[colour]}; }}" for where, (name, colour) in rules.items())
    return (
        "<style>line { stroke-linecap: round; } text { font: 3.1px system-ui, 'DejaVu Sans', sans-serif; text-anchor: middle; } "
        ".end { text-anchor: end; } .start { text-anchor: start; } .edge { fill: none; stroke-width: 0.4; } .joint { stroke: none; } "
        f".axis {{ stroke-width: 0.4; }} .mark {{ stroke-width: 0.6; }} .force {{ stroke-width: 0.9; }} {light} "
        f"@media (prefers-color-scheme: dark) {{ {dark} }}</style>"
    )


def main(log: str, out: str):
    topics, g = read(log)
    states = topics["/state"]
    time = column(states, "timestamp")
    touches, places = {}, {}
    for site in ("proximal", "distal"):
        contact = topics[f"/contact/{site}"]
        touches[site] = float(column(contact, "timestamp")[(column(contact, "gap_m") < 0).argmax()])
    end = 10e-3
    frames = schedule(touches, end)
    last = states[-1]
    # Where each phalanx touches at rest: the point of its axis nearest to the object, half a width nearer.
    knee = g["l21"] * e(last.q21_rad)
    lines = {"proximal": ((0.0, 0.0), knee), "distal": (knee, knee + g["t22"] * e(last.q21_rad + last.q22_rad + g["phi22"]))}
    for site, (a, b) in lines.items():
        d = (b[0] - a[0], b[1] - a[1])
        s = ((g["centre"][0] - a[0]) * d[0] + (g["centre"][1] - a[1]) * d[1]) / (d[0] ** 2 + d[1] ** 2)
        foot = (a[0] + s * d[0], a[1] + s * d[1])
        angle = atan2(foot[1] - g["centre"][1], foot[0] - g["centre"][0])
        places[site] = (g["centre"][0] + g["radius"] * cos(angle), g["centre"][1] + g["radius"] * sin(angle))
    arrows = "".join(
        arrow(g, frames, column(topics[f"/contact/{site}"], "timestamp"), topics[f"/contact/{site}"], touches[site], places[site]) for site in places
    )
    middle = g["centre"][0]
    x0 = middle - WIDTH / 2
    height = TOP + BOTTOM
    Path(out).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{x0:.2f} {-TOP} {WIDTH} {height}" width="{6 * WIDTH:.0f}" height="{6 * height:.0f}" role="img">\n'
        f"<title>A closing, slowed down: swing, first touch, second touch</title>\n<!-- tools/draw_moving.py -->\n{style()}\n"
        f'<rect class="ground" x="{x0:.2f}" y="{-TOP}" width="{WIDTH}" height="{height}"/>\n<g transform="scale(1 -1)">\n'
        f'<rect class="palm" x="{middle - 50}" y="-3.4" width="100" height="3.4"/><line class="edge" x1="{middle - 50}" x2="{middle + 50}" y1="0" y2="0"/>\n'
        f'<circle class="object" cx="{g["centre"][0]}" cy="{g["centre"][1]}" r="{g["radius"]}"/>\n'
        f'<g id="finger">\n{finger(g, frames, time, states)}\n{arrows}\n</g>\n'
        f'<use href="#finger" transform="translate({2 * middle:.3f} 0) scale(-1 1)"/>\n'
        f"</g>\n{clock(frames, touches, end, middle)}\n</svg>\n"
    )


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
