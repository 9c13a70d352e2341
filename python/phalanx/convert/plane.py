"""The plane of motion of a model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy

from ..errors import ConversionError
from .read import Numbers, Source, is_below, is_free_body, load_mujoco

# Tilts of an axis against the normal of the plane, deg. Rounded quaternions of public models tilt axes by up to 7e-4 deg;
# axes of fingers that fan out tilt by 3 deg or more.
SILENT_DEG = 0.01
LARGEST_DEG = 1.0

_AXES = {"x": 0, "y": 1, "z": 2}
PLANES = ("xy", "xz", "yz", "yx", "zx", "zy")


@dataclass
class Plane:
    """A plane through `origin` with the right-handed axes `e1`, `e2`, `n`, in world coordinates."""

    origin: Numbers
    e1: Numbers
    e2: Numbers
    n: Numbers
    comment: str
    """The plane in words."""
    root: int = 0
    """Body of the model whose frame is that of the scene; 0 for the world."""

    def point(self, x: Any) -> Numbers:
        """Coordinates in the plane of a point of the world."""
        return self.vector(numpy.asarray(x) - self.origin)

    def vector(self, v: Any) -> Numbers:
        """Coordinates in the plane of a vector of the world."""
        return numpy.array([self.e1 @ v, self.e2 @ v])

    def moved(self, point: Numbers, angle: float) -> Plane:
        """The same plane with its origin at a point of it, and turned."""
        cos, sin = float(numpy.cos(angle)), float(numpy.sin(angle))
        origin = self.origin + point[0] * self.e1 + point[1] * self.e2
        return Plane(origin, cos * self.e1 + sin * self.e2, cos * self.e2 - sin * self.e1, self.n, self.comment)

    def height(self, x: Any) -> float:
        """Coordinate along the normal of a point of the world."""
        return float(self.n @ (numpy.asarray(x) - self.origin))

    def angle(self, rotation: Any) -> float:
        """Angle of a rotation matrix about the normal."""
        turned = rotation @ self.e1
        return float(numpy.arctan2(self.e2 @ turned, self.e1 @ turned))


def moving_joints(source: Source) -> tuple[list[int], list[int]]:
    """Hinges and slides of the mechanism; the joints of free bodies are none of them."""
    mujoco, model = load_mujoco(), source.model
    own = [j for j in range(model.njnt) if not _is_of_object(source, model.jnt_bodyid[j])]
    kinds = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    hinges, slides = ([j for j in own if model.jnt_type[j] == kind] for kind in kinds)
    return hinges, slides


def _is_of_object(source: Source, body: int) -> bool:
    return bool(source.model.body_parentid[body] == 0) and is_free_body(load_mujoco(), source.model, body)


def find_plane(source: Source, name: str | None = None) -> Plane:
    """Returns the plane of motion: that of the hinges, or of the slides, or the named plane of the root's frame.

    Raises ConversionError with the joint whose axis contradicts.
    """
    data = source.zero
    hinges, slides = moving_joints(source)
    root = _root(source, hinges + slides)
    origin, frame = data.xpos[root].copy(), data.xmat[root].reshape(3, 3).copy()
    if not hinges and not slides:
        at, remedy = f" below {source.root}", "choose another --root, or take a body with its own joint by --branch"
        if not source.root:
            at, remedy = "", "give a model with joints"
        raise ConversionError(f"{source.path} has no hinge or slide{at}, so that there is no plane of motion; {remedy}")
    name = "auto" if name is None else name.lower()
    if name != "auto":
        if name not in PLANES:
            raise ConversionError(f"there is no plane {name!r}; --plane takes {', '.join(PLANES)} or auto")
        e1, e2 = (frame[:, _AXES[letter]] for letter in name)
    elif hinges:
        e1, e2 = _axes_of(_normal_of_hinges(source, hinges), frame)
    else:
        e1, e2 = _axes_of(_normal_of_slides(source, slides, origin, frame), frame)
    whose = f"the body {source.name('body', root) or root}" if root else "the world"
    letters = [
        next((f"{'-' if axis @ frame[:, k] < 0 else ''}{letter}" for letter, k in _AXES.items() if abs(axis @ frame[:, k]) > 1 - 1e-12), "")
        for axis in (e1, e2)
    ]
    if all(letters):
        words = f"x is {letters[0]} and y is {letters[1]} of {whose}"
    else:
        first, second = (", ".join(f"{number:.6g}" for number in frame.T @ axis) for axis in (e1, e2))
        words = f"x is ({first}) and y is ({second}) of {whose}"
    plane = Plane(origin, e1, e2, numpy.cross(e1, e2), words, root)
    _check_axes(source, plane, hinges, slides)
    return plane


def _root(source: Source, joints: list[int]) -> int:
    """Body whose frame is that of the scene: the root, or the last fixed body that carries all joints."""
    model = source.model
    if source.root:
        return int(load_mujoco().mj_name2id(model, load_mujoco().mjtObj.mjOBJ_BODY, source.root))
    parents = {int(model.body_parentid[model.jnt_bodyid[j]]) for j in joints}
    fixed = [body for body in range(model.nbody) if model.body_weldid[body] == 0]
    return max((body for body in fixed if all(is_below(model, parent, body) for parent in parents)), default=0)


def _axes_of(n: Numbers, frame: Numbers) -> tuple[Numbers, Numbers]:
    """Axes of the plane with this normal. They are axes of the frame where these lie in the plane."""
    for k in range(3):
        if abs(_degrees(n, frame[:, k])) < SILENT_DEG:
            first, second = ((1, 2), (0, 2), (0, 1))[k]
            return frame[:, first], frame[:, second]
    nearest = frame[:, 0] if abs(n @ frame[:, 0]) < 0.9 else frame[:, 1]
    e1 = nearest - (nearest @ n) * n
    e1 /= numpy.linalg.norm(e1)
    e2 = numpy.cross(n, e1)
    # The third axis of the frame usually points up, or out of the hand.
    return e1, e2 if e2 @ frame[:, 2] >= 0.0 else -e2


def _degrees(a: Any, b: Any) -> float:
    """Angle between two lines, deg."""
    cosine, sine = abs(float(a @ b)), float(numpy.linalg.norm(numpy.cross(a, b)))
    return float(numpy.degrees(numpy.arctan2(sine, cosine)))


def _normal_of_hinges(source: Source, hinges: list[int]) -> Numbers:
    axes = [source.zero.xaxis[j] for j in hinges]
    # The direction with which most hinges agree.
    counts = [sum(_degrees(axis, other) <= LARGEST_DEG for other in axes) for axis in axes]
    reference = axes[counts.index(max(counts))]
    near = [axis * numpy.sign(axis @ reference) for axis in axes if _degrees(axis, reference) <= LARGEST_DEG]
    mean: Numbers = numpy.mean(near, axis=0)
    mean /= numpy.linalg.norm(mean)
    return mean


def _normal_of_slides(source: Source, slides: list[int], origin: Numbers, frame: Numbers) -> Numbers:
    data, model = source.zero, source.model
    first = data.xaxis[slides[0]]
    others = [data.xaxis[j] for j in slides if _degrees(data.xaxis[j], first) > LARGEST_DEG]
    if others:
        return _unit(numpy.cross(first, others[0]))
    # All slides are parallel: the direction from the root to the sliding geoms is the second one of the plane.
    bodies = [model.jnt_bodyid[j] for j in slides]
    geoms = [g for g in range(model.ngeom) if model.body_weldid[model.geom_bodyid[g]] in bodies]
    places = [data.geom_xpos[g] for g in geoms] or [data.xipos[body] for body in bodies]
    up = numpy.mean(places, axis=0) - origin
    up -= (up @ first) * first
    axes = [frame[:, k] for k in range(3) if abs(frame[:, k] @ first) < numpy.radians(SILENT_DEG)]
    if axes:
        up = max(axes, key=lambda axis: abs(float(axis @ up)))
    if numpy.linalg.norm(up) < 1e-9:
        raise ConversionError(f'the slides of {source.path} are parallel, so that they do not determine a plane; choose it: --plane "xz"')
    return _unit(numpy.cross(first, up))


def _unit(vector: Numbers) -> Numbers:
    found: Numbers = vector / numpy.linalg.norm(vector)
    return found


def _check_axes(source: Source, plane: Plane, hinges: list[int], slides: list[int]) -> None:
    """Refuses joints that leave the plane, with their axes, and warns about small tilts."""
    tilts = {j: _degrees(source.zero.xaxis[j], plane.n) for j in hinges}
    tilts |= {j: 90.0 - _degrees(source.zero.xaxis[j], plane.n) for j in slides}
    wrong = [j for j, tilt in tilts.items() if tilt > LARGEST_DEG]
    if wrong:
        worst = max(wrong, key=lambda j: tilts[j])
        axis = ", ".join(f"{number:.4g}" for number in source.zero.xaxis[worst])
        what = "turns about" if worst in hinges else "slides along"
        should = "the normal of" if worst in hinges else "the directions in"
        normal = ", ".join(f"{number:.4g}" for number in plane.n)
        others = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
        found = f"{source.label('joint', worst)}{others} {what} the axis ({axis})"
        apart = f"{tilts[worst]:.3g} deg from {should} the plane with normal ({normal})"
        raise ConversionError(f"the model is not planar: {found}, {apart}; {_advice(source)}")
    for j, tilt in tilts.items():
        if tilt > SILENT_DEG:
            source.report.warn(source.label("joint", j), f"its axis is tilted by {tilt:.2g} deg against the plane; the projection neglects the tilt")


def _advice(source: Source) -> str:
    """Parts of a model that are planar."""
    found: list[str] = []
    covered: list[int] = []
    for body in range(1, source.model.nbody):
        name = source.name("body", body)
        if not name or any(is_below(source.model, body, other) for other in covered):
            continue
        own, below = _joints_of(source, body), _joints_below(source, body)
        if not below and not own:
            continue
        if own and _are_planar(source, own + below):
            found.append(f'--branch "{name}"')
        elif below and _are_planar(source, below):
            palm = _palm(source, body)
            found += [f'--root "{source.name("body", other)}"' for other in dict.fromkeys((palm, body)) if source.name("body", other)]
        else:
            continue
        covered.append(body)
    if not found:
        return "phalanx simulates planar mechanisms only"
    return f"a part of it is planar: {found[0]}" + (f" (or {', '.join(found[1:6])})" if len(found) > 1 else "")


def _joints_of(source: Source, body: int) -> list[int]:
    return [j for kind in moving_joints(source) for j in kind if source.model.jnt_bodyid[j] == body]


def _joints_below(source: Source, body: int) -> list[int]:
    model = source.model
    return [j for kind in moving_joints(source) for j in kind if model.jnt_bodyid[j] != body and is_below(model, int(model.jnt_bodyid[j]), body)]


def _palm(source: Source, body: int) -> int:
    """The body below which a part branches into fingers, without the joints that turn it as a whole; the body itself if
    all its joints are in the fingers.
    """
    model, palm = source.model, body
    while True:
        branches = [other for other in range(palm + 1, model.nbody) if model.body_parentid[other] == palm]
        branches = [other for other in branches if _joints_of(source, other) or _joints_below(source, other)]
        if len(branches) != 1:
            break
        palm = branches[0]
    return palm if branches and len(_joints_below(source, palm)) < len(_joints_below(source, body)) else body


def _are_planar(source: Source, joints: list[int]) -> bool:
    """Whether hinges are parallel, slides perpendicular to them, and all bodies have one joint."""
    mujoco, model, axes = load_mujoco(), source.model, source.zero.xaxis
    hinges = [j for j in joints if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE]
    if len({int(model.jnt_bodyid[j]) for j in joints}) < len(joints):
        return False
    return all(
        (_degrees(axes[j], axes[hinges[0]]) if j in hinges else 90.0 - _degrees(axes[j], axes[hinges[0]])) <= LARGEST_DEG for j in joints if hinges
    )
