"""Forward kinematics of the finger from the lengths of a scene; independent reference for the drawings."""

import math
import tomllib
from dataclasses import dataclass

import logs

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "rad": 1.0, "deg": math.pi / 180.0}


def quantity(text):
    """Parses a length or an angle of a scene file; returns SI."""
    number, unit = text.split()
    return float(number) * UNITS[unit]


@dataclass(frozen=True)
class Finger:
    """A finger and the disc on which it closes. Lengths in m, angle in rad."""

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
    """Reads the finger of a scene file, resolved by `phalanx scene show --resolved`."""
    shown = tomllib.loads(logs.phalanx("scene", "show", scene, "--resolved"))
    lengths = {name: quantity(text) for name, text in shown["lengths"].items()}
    disc = shown["object"]
    present = disc.get("present", True)
    centre = tuple(map(quantity, disc["centre"])) if present else (math.nan, math.nan)
    radius = quantity(disc["radius"]) if present else math.nan
    return Finger(**lengths, half_width=quantity(shown["half_width"]), centre=centre, radius=radius)


def along(start, length, angle):
    """The end of a segment with the given start, length and angle."""
    return (start[0] + length * math.cos(angle), start[1] + length * math.sin(angle))


def frames(finger, state):
    """Origin and angle of the frame of every link for the coordinates of a finger."""
    origin = (0.0, 0.0)
    return {
        "l11": (origin, state.q11_rad),
        "l12": (along(origin, finger.l11, state.q11_rad), state.q11_rad + state.q12_rad),
        "l21": (origin, state.q21_rad),
        "l22": (along(origin, finger.l21, state.q21_rad), state.q21_rad + state.q22_rad),
    }


def nearest(point, start, end):
    """The point of a segment that is nearest to a given point."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    fraction = ((point[0] - start[0]) * along_x + (point[1] - start[1]) * along_y) / (along_x**2 + along_y**2)
    fraction = min(1.0, max(0.0, fraction))
    return (start[0] + fraction * along_x, start[1] + fraction * along_y)


def contact(finger, start, end):
    """Contact of a phalanx (a segment with rounded ends and a half width) and the disc: gap, contact point on the phalanx, normal."""
    x, y = nearest(finger.centre, start, end)
    offset_x, offset_y = x - finger.centre[0], y - finger.centre[1]
    distance = math.hypot(offset_x, offset_y)
    normal = (offset_x / distance, offset_y / distance)
    point = (x - finger.half_width * normal[0], y - finger.half_width * normal[1])
    return distance - finger.half_width - finger.radius, point, normal
