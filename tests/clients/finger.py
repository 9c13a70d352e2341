"""Forward kinematics of the finger in ten lines, from nothing but the lengths of a scene; the reference of the pictures."""

import math
import tomllib
from dataclasses import dataclass

import logs

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "rad": 1.0, "deg": math.pi / 180.0}


def quantity(text):
    """A length or an angle of a scene file in SI."""
    number, unit = text.split()
    return float(number) * UNITS[unit]


@dataclass(frozen=True)
class Finger:
    """Lengths in m, angle in rad; the disc it closes on."""

    l11: float
    l12: float
    l21: float
    l22: float
    t22: float
    phi22: float
    half_width: float
    centre: tuple
    radius: float


def finger(scene):
    """The finger of a scene file, as `phalanx scene show --resolved` fills it in."""
    shown = tomllib.loads(logs.phalanx("scene", "show", scene, "--resolved"))
    lengths = {name: quantity(text) for name, text in shown["lengths"].items()}
    disc = shown["object"]
    present = disc.get("present", True)
    centre = tuple(map(quantity, disc["centre"])) if present else (math.nan, math.nan)
    radius = quantity(disc["radius"]) if present else math.nan
    return Finger(**lengths, half_width=quantity(shown["half_width"]), centre=centre, radius=radius)


def along(start, length, angle):
    """The end of a line."""
    return (start[0] + length * math.cos(angle), start[1] + length * math.sin(angle))


def frames(finger, state):
    """Origin and angle of every link's frame for a message of `/state`."""
    origin = (0.0, 0.0)
    return {
        "l11": (origin, state.q11_rad),
        "l12": (along(origin, finger.l11, state.q11_rad), state.q11_rad + state.q12_rad),
        "l21": (origin, state.q21_rad),
        "l22": (along(origin, finger.l21, state.q21_rad), state.q21_rad + state.q22_rad),
    }


def nearest(point, start, end):
    """The point of a segment that is nearest to another."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    share = ((point[0] - start[0]) * along_x + (point[1] - start[1]) * along_y) / (along_x**2 + along_y**2)
    share = min(1.0, max(0.0, share))
    return (start[0] + share * along_x, start[1] + share * along_y)


def touch(finger, start, end):
    """A phalanx, a segment with a round of its half width, against the disc: gap, the point of its surface, the normal."""
    x, y = nearest(finger.centre, start, end)
    away_x, away_y = x - finger.centre[0], y - finger.centre[1]
    distance = math.hypot(away_x, away_y)
    normal = (away_x / distance, away_y / distance)
    point = (x - finger.half_width * normal[0], y - finger.half_width * normal[1])
    return distance - finger.half_width - finger.radius, point, normal
