"""Scene files of planar mechanisms, as a person would write them."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import degrees

from .contacts import BRISTLE_DAMPING, CONTACT_DAMPING, STOP_DAMPING
from .planar import GROUND, Actuator, Body, Contact, Joint, Law, Mechanism, Outline, Spring, Tendon, Terms, Vector, friction_stiffness

# Digits of a number: an error of 5e-13.
_DIGITS = 12
# Two lengths are the same parameter within this distance, m, and a body is in its zero position within this angle, rad.
_SAME_M = 1e-12
_SAME_RAD = 1e-12
# Time up to which the target of a servo without kp moves, s.
_LONG_S = 1000.0


def number(value: float) -> str:
    """A number with 12 digits, without noise around 0."""
    text = f"{0.0 if abs(value) < 1e-300 else value:.{_DIGITS}g}"
    return "0" if text == "-0" else text


def length(value: float) -> str:
    """A length in mm."""
    return f"{number(1e3 * value if abs(value) > 1e-13 else 0.0)} mm"


def angle(value: float) -> str:
    """An angle in the unit with fewer digits."""
    if abs(value) < 1e-13:
        return "0 rad"
    in_degrees, in_radians = number(degrees(value)), number(value)
    return f"{in_degrees} deg" if len(in_degrees) < len(in_radians) else f"{in_radians} rad"


def _coordinate(value: float, is_linear: bool) -> str:
    return length(value) if is_linear else angle(value)


def _quantity(value: float, is_linear: bool, units: tuple[str, str]) -> str:
    return f"{number(value)} {units[is_linear]}"


# Last lines of the comment at the beginning.
_LEGEND = ("", "Values without a comment have the same name in the model, and outlines are named after their geoms.")
_EFFORT = ("N*m", "N")
_STIFFNESS = ("N*m/rad", "N/m")
_DAMPING = ("N*m*s/rad", "N*s/m")
_INERTIA = ("kg*m^2", "kg")
_RATE = ("rad/s", "m/s")


@dataclass
class _Parameters:
    """Lengths that stand more than once, by name."""

    values: dict[str, tuple[float, str]] = field(default_factory=dict)

    def use(self, name: str, value: float, comment: str) -> str:
        """Text of a value: that of a parameter with the same value or the opposite one, or of a new parameter."""
        if abs(value) <= _SAME_M:
            return '"0 mm"'
        for other, (known, _) in self.values.items():
            if other[-2:] == name[-2:] and abs(known - value) <= _SAME_M:
                return f'"= {other}"'
            if other[-2:] == name[-2:] and abs(known + value) <= _SAME_M:
                return f'"= -{other}"'
        self.values[name] = value, comment
        return f'"= {name}"'


class _Text:
    def __init__(self) -> None:
        self.lines: list[str] = []

    def section(self, title: str, comment: str = "") -> None:
        self.lines.append(f"[{title}]" + (f"    # {comment}" if comment else ""))

    def value(self, key: str, value: str, comment: str = "") -> None:
        self.lines.append(f"{key} = {value}" + (f"    # {comment}" if comment else ""))

    def text(self, key: str, value: str, comment: str = "") -> None:
        self.value(key, f'"{value}"', comment)

    def blank(self) -> None:
        self.lines.append("")


def _list(items: Iterable[str]) -> str:
    return "[" + ", ".join(items) + "]"


def _quoted(items: Iterable[str]) -> str:
    return _list(f'"{item}"' for item in items)


def _point(point: Vector) -> str:
    return _quoted(length(value) for value in point)


def scene_text(mechanism: Mechanism, header: Sequence[str], duration_s: float) -> str:
    """The scene file of a mechanism. `header` are the lines of the comment at its beginning."""
    text = _Text()
    text.lines += [f"# {line}".rstrip() for line in (*header, *(_LEGEND if header else ()))]
    text.blank()
    text.text("kind", "mechanism")
    text.text("duration", f"{number(1e3 * duration_s)} ms")
    if any(abs(value) > 1e-12 for value in mechanism.gravity):
        text.value("gravity", _quoted(f"{number(value if abs(value) > 1e-12 else 0.0)} m/s^2" for value in mechanism.gravity), "option gravity")
    parameters = _Parameters()
    body = _Text()
    pivots = _write_bodies(body, mechanism, parameters)
    _write_joints(body, mechanism, parameters, pivots)
    _write_springs(body, mechanism)
    for tendon in mechanism.tendons:
        _write_tendon(body, tendon)
    for coupling in mechanism.couplings:
        body.section(f"couplings.{coupling.name}", coupling.comment)
        _write_terms(body, coupling.terms)
        if coupling.value != 0.0:
            body.text("value", _coordinate(coupling.value, coupling.is_linear))
        body.blank()
    for rotor in mechanism.rotors:
        body.section(f"rotors.{rotor.name}", "armature of a tendon")
        _write_terms(body, rotor.terms)
        body.text("inertia", _quantity(rotor.inertia, rotor.is_linear, _INERTIA))
        body.blank()
    bands = {law.name for law in mechanism.laws if law.is_spring}
    for limit in mechanism.limits:
        body.section(f"limits.{limit.name}", "dead band of a tendon" if limit.stop in bands else "range of a tendon")
        _write_terms(body, limit.terms)
        for key, bound in (("lower", limit.lower), ("upper", limit.upper)):
            if bound is not None:
                body.text(key, _coordinate(bound, limit.is_linear))
        body.text("stop", limit.stop)
        body.blank()
    for actuator in mechanism.actuators:
        _write_actuator(body, actuator)
    for law in mechanism.laws:
        _write_law(body, law)
    if mechanism.surroundings:
        body.section("grasp")
        body.value("surroundings", _quoted(mechanism.surroundings), "not part of the hand")
        body.blank()
    _write_contacts(body, mechanism)
    text.blank()
    if parameters.values:
        text.section("parameters", "lengths that stand more than once")
        for name, (value, comment) in parameters.values.items():
            text.text(name, length(value), comment)
        text.blank()
    return "\n".join([*text.lines, *body.lines]).rstrip() + "\n"


def _is_at_zero(mechanism: Mechanism) -> bool:
    return all(body.is_free or (abs(body.angle) <= _SAME_RAD and _are_same(body.at, body.origin)) for body in mechanism.bodies)


def _are_same(a: Vector, b: Vector) -> bool:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= _SAME_M


def _write_bodies(text: _Text, mechanism: Mechanism, parameters: _Parameters) -> dict[str, str]:
    """Writes bodies; returns the origins of those that are parameters."""
    pivots = {}
    roundings = [outline.rounding for body in mechanism.bodies for outline in body.outlines] + [outline.rounding for outline in mechanism.ground]
    common = max(roundings, default=0.0)
    if roundings.count(common) > 1 and common > 0.0:
        parameters.values["rounding"] = common, "of corners, which are sharp in MuJoCo"
    is_at_zero = _is_at_zero(mechanism)
    for body in mechanism.bodies:
        merged = f"bodies {', '.join(body.members)}" if len(body.members) > 1 else f"body {body.members[0]}"
        text.section(f"bodies.{body.name}", merged if len(body.members) > 1 or body.members[0] != body.name else "")
        source = "sum of the inertials" if len(body.members) > 1 else "inertial"
        text.text("mass", f"{number(1e3 * body.mass)} g", source)
        text.text("inertia", f"{number(1e9 * body.inertia)} g*mm^2", "about the normal of the plane")
        if any(abs(value) > 1e-13 for value in body.com):
            text.value("com", _point(body.com), "centre of mass")
        if body.is_free:
            _write_start(text, body)
        else:
            if is_at_zero:
                x, y = (
                    parameters.use(f"{body.name}_{letter}", value, f"joint of {body.name}, zero position")
                    for letter, value in zip("xy", body.origin, strict=True)
                )
                pivots[body.name] = f"[{x}, {y}]"
                place = pivots[body.name] if pivots[body.name] != '["0 mm", "0 mm"]' else ""
            else:
                place = _point(body.at)
            turn = f'angle = "{angle(body.angle)}"' if abs(body.angle) > 1e-13 else ""
            settings = ", ".join(part for part in (f"at = {place}" if place else "", turn) if part)
            if settings:
                text.value("guess", f"{{ {settings} }}")
        for outline in body.outlines:
            _write_outline(text, f"bodies.{body.name}.outlines.{outline.name}", outline, parameters)
        text.blank()
    for outline in mechanism.ground:
        _write_outline(text, f"{GROUND}.outlines.{outline.name}", outline, parameters)
        text.blank()
    return pivots


def _write_start(text: _Text, body: Body) -> None:
    settings = [f"at = {_point(body.at)}"]
    if abs(body.angle) > 1e-13:
        settings.append(f'angle = "{angle(body.angle)}"')
    if any(abs(value) > 1e-13 for value in body.velocity):
        settings.append(f"velocity = {_quoted(f'{number(value)} m/s' for value in body.velocity)}")
    if abs(body.spin) > 1e-13:
        settings.append(f'spin = "{number(body.spin)} rad/s"')
    text.value("start", f"{{ {', '.join(settings)} }}", "free joint")


def _write_outline(text: _Text, title: str, outline: Outline, parameters: _Parameters) -> None:
    text.section(title, outline.comment)
    text.text("type", outline.type)
    if outline.type in ("disc", "box", "ellipse") and any(abs(value) > 1e-13 for value in outline.points[0]):
        text.value("center", _point(outline.points[0]))
    if outline.type == "capsule":
        text.value("from", _point(outline.points[0]))
        text.value("to", _point(outline.points[1]))
    if outline.type in ("disc", "capsule"):
        text.text("radius", length(outline.sizes[0]))
    if outline.type == "box":
        text.value("size", _point((outline.sizes[0], outline.sizes[1])))
    if outline.type == "ellipse":
        text.value("semi_axes", _point((outline.sizes[0], outline.sizes[1])))
    if outline.type == "half_plane":
        if any(abs(value) > 1e-13 for value in outline.points[0]):
            text.value("point", _point(outline.points[0]))
        text.value("normal", _list(number(value if abs(value) > 1e-13 else 0.0) for value in outline.sizes))
    if outline.type in ("box", "ellipse") and abs(outline.angle) > 1e-13:
        text.text("angle", angle(outline.angle))
    if outline.type == "polygon":
        text.value("vertices", _list(_point(point) for point in outline.points))
    if outline.rounding:
        key = "radius" if outline.type == "polygon" else "rounding"
        shared = "rounding" in parameters.values and outline.rounding == parameters.values["rounding"][0]
        text.text(key, "= rounding" if shared else length(outline.rounding))


def _world(mechanism: Mechanism, joint: Joint) -> tuple[Vector, Vector]:
    """Points of a joint in the world, in the zero position."""
    origins = {body.name: body.origin for body in mechanism.bodies} | {GROUND: (0.0, 0.0)}
    first, second = ((origins[name][0] + point[0], origins[name][1] + point[1]) for name, point in zip(joint.bodies, joint.points, strict=True))
    return first, second


def _write_joints(text: _Text, mechanism: Mechanism, parameters: _Parameters, pivots: dict[str, str]) -> None:
    origins = {body.name: body.origin for body in mechanism.bodies}
    is_at_zero, has_free = _is_at_zero(mechanism), {body.name for body in mechanism.bodies if body.is_free}
    for joint in mechanism.joints:
        text.section(f"joints.{joint.name}", joint.comment)
        if joint.is_slide:
            text.text("type", "prismatic")
        text.value("bodies", _quoted(joint.bodies))
        first, second = _world(mechanism, joint)
        closed = _are_same(first, second)
        if is_at_zero and closed and not has_free & set(joint.bodies):
            at = next(
                (pivots[name] for name in joint.bodies[::-1] if name in origins and _are_same(origins[name], first)),
                None,
            )
            text.value("at", at or _point(first))
        else:
            text.value("points", _list(_point(point) for point in joint.points))
        if joint.is_slide and abs(joint.axis) > 1e-13:
            text.text("axis", angle(joint.axis))
        if abs(joint.offset) > 1e-13:
            text.text("offset", angle(joint.offset), "minus ref")
        if joint.start is not None:
            text.text("start", _coordinate(joint.start, joint.is_slide), "key frame, or zero position")
            if joint.start_rate:
                text.text("start_rate", _quantity(joint.start_rate, joint.is_slide, _RATE))
        if joint.damping:
            text.text("damping", _quantity(joint.damping, joint.is_slide, _DAMPING))
        if joint.armature:
            text.text("armature", _quantity(joint.armature, joint.is_slide, _INERTIA))
        if joint.friction:
            text.text("friction", _quantity(joint.friction, joint.is_slide, _EFFORT), "frictionloss")
            text.text(
                "friction_stiffness",
                _quantity(friction_stiffness(joint.friction), joint.is_slide, _STIFFNESS),
                "assumed: stiff enough to hold",
            )
        for key, bound in (("lower", joint.lower), ("upper", joint.upper)):
            if bound is not None:
                text.text(key, _coordinate(bound, joint.is_slide), "range")
        if joint.stop:
            text.text("stop", joint.stop)
        text.blank()


def _write_terms(text: _Text, terms: Terms) -> None:
    if len(terms) == 1 and terms[0][1] == 1.0:
        text.text("joint", terms[0][0])
    else:
        text.value("joints", _quoted(name for name, _ in terms))
        text.value("factors", _list(number(factor) for _, factor in terms))


def _write_springs(text: _Text, mechanism: Mechanism) -> None:
    for spring in mechanism.springs:
        _write_spring(text, spring)


def _write_spring(text: _Text, spring: Spring) -> None:
    text.section(f"springs.{spring.name}", spring.comment)
    if spring.bodies is not None and spring.points is not None:
        text.text("type", "linear")
        text.value("bodies", _quoted(spring.bodies))
        text.value("points", _list(_point(point) for point in spring.points))
    else:
        _write_terms(text, spring.terms)
    text.text("stiffness", _quantity(spring.stiffness, spring.is_linear, _STIFFNESS))
    if spring.damping:
        text.text("damping", _quantity(spring.damping, spring.is_linear, _DAMPING))
    if abs(spring.rest) > 1e-13:
        text.text("rest", _coordinate(spring.rest, spring.is_linear), "springlength" if len(spring.terms) != 1 else "springref")
    text.blank()


def _write_tendon(text: _Text, tendon: Tendon) -> None:
    text.section(f"tendons.{tendon.name}", tendon.comment)
    if tendon.stiffness:
        text.text("stiffness", f"{number(tendon.stiffness)} N/m")
        if tendon.damping:
            text.text("damping", f"{number(tendon.damping)} N*s/m")
        text.text("rest", length(tendon.rest), tendon.rest_comment)
    text.lines.append("path = [")
    for element in tendon.path:
        kind = f'pulley = "{element.body}"' if element.radius else f'eyelet = "{element.body}"'
        round_it = f', radius = "{length(element.radius)}", turn = "{element.turn}"' if element.radius else ""
        text.lines.append(f"    {{ {kind}, at = {_point(element.at)}{round_it} }},")
    text.lines.append("]")
    text.blank()


def _write_actuator(text: _Text, drive: Actuator) -> None:
    text.section(f"actuators.{drive.name}")
    comments = drive.comments
    if drive.tendon:
        text.text("tendon", drive.tendon)
        text.text("tension", f"{number(drive.effort or 0.0)} N", comments.get("effort", ""))
        text.blank()
        return
    _write_terms(text, drive.terms)
    if drive.times:
        text.value("times", _quoted(f"{number(1e3 * time)} ms" for time in drive.times), comments.get("times", ""))
    if drive.effort is not None:
        key = "force" if drive.is_linear else "torque"
        if drive.times:
            text.value(f"{key}s", _quoted(_quantity(value, drive.is_linear, _EFFORT) for value in drive.values))
            text.blank()
            return
        text.text(key, _quantity(drive.effort, drive.is_linear, _EFFORT), comments.get("effort", ""))
        text.blank()
        return
    if drive.times:
        text.value("targets", _quoted(_coordinate(value, drive.is_linear) for value in drive.values))
    elif drive.rate:
        text.value("times", _quoted(("0 s", f"{_LONG_S:g} s")))
        text.value(
            "targets",
            _quoted((_coordinate(0.0, drive.is_linear), _coordinate(drive.rate * _LONG_S, drive.is_linear))),
            comments.get("target", ""),
        )
    else:
        text.text("target", _coordinate(drive.target, drive.is_linear), comments.get("target", ""))
    if drive.kp:
        text.text("kp", _quantity(drive.kp, drive.is_linear, _STIFFNESS), comments.get("kp", ""))
    if drive.kd:
        text.text("kd", _quantity(drive.kd, drive.is_linear, _DAMPING), comments.get("kp", ""))
    if drive.limit is not None:
        text.text("limit", _quantity(drive.limit, drive.is_linear, _EFFORT), comments.get("limit", ""))
    text.blank()


def _write_law(text: _Text, law: Law) -> None:
    text.section(f"laws.{law.name}", law.comment)
    text.value("stiffness", number(law.stiffness))
    text.value("exponent", "1")
    if law.is_spring:
        pass
    elif law.friction is None:
        text.text("damping", STOP_DAMPING[law.is_linear], "assumed")
    else:
        text.text("damping", CONTACT_DAMPING, "assumed")
        if law.friction:
            mu = number(law.friction)
            text.value("friction", f'{{ mu_static = {mu}, mu_dynamic = {mu}, law = "bristle", bristle_damping = "{BRISTLE_DAMPING}" }}')
    text.blank()


def _write_contacts(text: _Text, mechanism: Mechanism) -> None:
    for position, (between, law) in enumerate(_grouped(mechanism)):
        text.lines.append("[[contacts]]" + ("" if position else "    # pairs that MuJoCo lets touch"))
        text.value("between", _quoted(between))
        text.text("law", law)
        text.blank()


def _grouped(mechanism: Mechanism) -> list[tuple[tuple[str, str], str]]:
    """Contacts with as few entries as bodies and outlines allow."""
    outlines = {body.name: {f"{body.name}.{outline.name}" for outline in body.outlines} for body in mechanism.bodies}
    outlines[GROUND] = {f"{GROUND}.{outline.name}" for outline in mechanism.ground}

    def key(contact: Contact) -> tuple[str, ...]:
        return (contact.law, *sorted(name.partition(".")[0] for name in contact.between))

    found = []
    for (law, first, second), group in itertools.groupby(sorted(mechanism.contacts, key=key), key):
        pairs = {tuple(sorted(contact.between, key=lambda name: (name.partition(".")[0] != first, name))) for contact in group}
        ones, others = {a for a, _ in pairs}, {b for _, b in pairs}
        if first != second and len(pairs) == len(ones) * len(others):
            sides = [[body] if names == outlines[body] else sorted(names) for body, names in ((first, ones), (second, others))]
            found += [((a, b), law) for a in sides[0] for b in sides[1]]
        else:
            found += [((a, b), law) for a, b in sorted(pairs)]
    return found
