"""Geoms as outlines in the plane."""

from __future__ import annotations

from typing import Any

import numpy

from .planar import Outline, Vector
from .plane import Plane
from .read import Numbers, Source, load_mujoco

# Corners of outlines are round, because two outlines without a radius cannot touch. Contacts that are deeper than the
# rounding of their outlines are uncertain, so soft models have more.
ROUNDING_M = 0.5e-3
# Rounding over the width of an outline, at most.
_LARGEST_ROUNDING = 0.1
# Hulls of meshes have up to a hundred corners in the plane.
SIMPLIFICATION_M = 10e-6
# Corners of a polygon in a scene (MAX_CORNERS of the scene reader).
MAX_CORNERS = 32
# Vertices of meshes have single precision.
_MESH_DECIMALS = 7
# Points in place of an ellipse or of a tilted cylinder.
_CIRCLE_POINTS = 32
# Sine of the tilt up to which an axis counts as parallel.
_PARALLEL = 1e-4


def outline_of(source: Source, geom: int, plane: Plane, data: Any, name: str, rounding: float) -> Outline | None:
    """The projection of a geom in a frame of the plane; None if it has none. Corners are rounded within the shape."""
    mujoco, model = load_mujoco(), source.model
    kind = mujoco.mjtGeom(model.geom_type[geom])
    types = mujoco.mjtGeom
    axes = data.geom_xmat[geom].reshape(3, 3).T
    center = plane.point(data.geom_xpos[geom])
    height = plane.height(data.geom_xpos[geom])
    size = model.geom_size[geom]
    flat = [plane.vector(axis) for axis in axes]
    across = numpy.array([float(plane.n @ axis) for axis in axes])
    made = Outline(
        name,
        "disc",
        [_pair(center)],
        geom=geom,
        comment=f"{kind.name.removeprefix('mjGEOM_').lower()} {source.name('geom', geom)}".rstrip(),
    )
    reach = 0.0
    if kind == types.mjGEOM_SPHERE:
        made.sizes, reach = (float(size[0]),), float(size[0])
    elif kind == types.mjGEOM_CAPSULE:
        half = flat[2] * size[1]
        reach = abs(across[2]) * size[1] + size[0]
        made.sizes = (float(size[0]),)
        if numpy.linalg.norm(half) > _PARALLEL * size[1]:
            made.type, made.points = "capsule", [_pair(center - half), _pair(center + half)]
    elif kind == types.mjGEOM_CYLINDER:
        lean = float(numpy.linalg.norm(flat[2]))
        reach = abs(across[2]) * size[1] + size[0] * lean
        if lean < _PARALLEL:
            made.sizes = (float(size[0]),)
        elif abs(across[2]) < _PARALLEL:
            _set_box(made, flat[2], 2.0 * size[1], 2.0 * size[0], rounding)
        else:
            turn = numpy.linspace(0.0, 2.0 * numpy.pi, _CIRCLE_POINTS, endpoint=False)
            ring = numpy.outer(numpy.cos(turn), flat[0]) + numpy.outer(numpy.sin(turn), flat[1])
            _set_polygon(source, made, numpy.concatenate([center + size[0] * ring + side * size[1] * flat[2] for side in (-1, 1)]), rounding)
    elif kind == types.mjGEOM_ELLIPSOID:
        spread = sum(size[k] ** 2 * numpy.outer(flat[k], flat[k]) for k in range(3))
        squares, directions = numpy.linalg.eigh(spread)
        reach = float(numpy.sqrt(numpy.sum((size * across) ** 2)))
        small, large = numpy.sqrt(squares)
        if large - small < 1e-9 * large:
            made.sizes = (float(large),)
        else:
            made.type, made.sizes = "ellipse", (float(large), float(small))
            made.angle = float(numpy.arctan(directions[1, 1] / directions[0, 1])) if directions[0, 1] else 0.5 * numpy.pi
    elif kind == types.mjGEOM_BOX:
        reach = float(numpy.sum(numpy.abs(across) * size))
        normal = int(numpy.argmax(numpy.abs(across)))
        if abs(across[normal]) > 1.0 - _PARALLEL**2:
            first, second = (k for k in range(3) if k != normal)
            _set_box(made, flat[first], 2.0 * size[first], 2.0 * size[second], rounding)
        else:
            signs = numpy.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
            _set_polygon(source, made, center + (signs * size) @ numpy.array(flat), rounding)
    elif kind == types.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        vertices = model.mesh_vert[first : first + count] @ axes + data.geom_xpos[geom]
        heights = (vertices - plane.origin) @ plane.n
        made.comment = f"hull of mesh {source.name('mesh', mesh)}"
        flat_vertices = numpy.array([plane.point(vertex) for vertex in vertices])
        _set_polygon(source, made, numpy.round(flat_vertices, _MESH_DECIMALS), rounding)
        made.depth = float(heights.min()), float(heights.max())
        return made if len(made.points) >= 3 else None
    elif kind == types.mjGEOM_PLANE:
        normal_in_plane = flat[2]
        if numpy.linalg.norm(normal_in_plane) < 1.0 - 1e-6:
            source.report.lost(source.label("geom", geom), "a plane geom that is not perpendicular to the plane of motion; nothing touches it")
            return None
        made.type, made.sizes, reach = "half_plane", _pair(normal_in_plane), numpy.inf
    else:
        source.report.lost(source.label("geom", geom), f"{kind.name} has no outline; nothing touches it")
        return None
    made.depth = height - reach, height + reach
    return made


def _pair(point: Any) -> Vector:
    return float(point[0]), float(point[1])


def _set_box(made: Outline, along: Any, width: float, height: float, rounding: float) -> None:
    """Makes a box with this direction of its first side; turns it by quarters to the smallest angle."""
    angle = float(numpy.arctan2(along[1], along[0]))
    quarters = round(angle / (0.5 * numpy.pi))
    angle -= quarters * 0.5 * numpy.pi
    sizes = (float(width), float(height)) if quarters % 2 == 0 else (float(height), float(width))
    made.type, made.sizes, made.angle = "box", sizes, angle if abs(angle) > 1e-12 else 0.0
    made.rounding = min(rounding, _LARGEST_ROUNDING * min(sizes))


def _set_polygon(source: Source, made: Outline, points: Numbers, rounding: float) -> None:
    """Makes the convex hull, with round corners inside of it."""
    hull = convex_hull(points)
    if len(hull) < 3:
        made.points = []
        return
    corners, tolerance = simplified(hull, SIMPLIFICATION_M), SIMPLIFICATION_M
    while len(corners) > MAX_CORNERS:
        tolerance *= 1.25
        corners = simplified(hull, tolerance)
    if tolerance > SIMPLIFICATION_M:
        source.report.changed(
            made.comment,
            f"its outline of {len(hull)} corners is simplified to {len(corners)}; it deviates by up to {1e6 * tolerance:.0f} µm",
        )
    rounding = min(rounding, _LARGEST_ROUNDING * _width(corners))
    core = simplified(_eroded(corners, rounding), 1e-9)
    made.type, made.points, made.rounding = "polygon", [_pair(numpy.round(point, _MESH_DECIMALS + 1)) for point in core], rounding


def facet(ellipse: Outline, rounding: float) -> float:
    """Makes an ellipse a polygon with round corners, and returns its largest deviation, m."""
    points = core_of(ellipse, (0.0, 0.0))[0]
    # The middle of a chord is nearer to the centre than the arc.
    deviation = max(ellipse.sizes) * (1.0 - float(numpy.cos(numpy.pi / len(points))))
    ellipse.rounding = min(rounding, _LARGEST_ROUNDING * _width(points))
    ellipse.points = [_pair(corner) for corner in _eroded(points, ellipse.rounding)]
    ellipse.type, ellipse.sizes, ellipse.angle = "polygon", (), 0.0
    return deviation


def convex_hull(points: Numbers) -> Numbers:
    """Corners of the convex hull, counter-clockwise."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    halves = []
    for sequence in (ordered, ordered[::-1]):
        half: list[Vector] = []
        for point in sequence:
            while len(half) >= 2 and _cross(half[-2], half[-1], point) <= 1e-15:
                half.pop()
            half.append(point)
        halves += half[:-1]
    return numpy.array(halves).reshape(-1, 2)


def _cross(a: Any, b: Any, c: Any) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def simplified(corners: Numbers, tolerance: float) -> Numbers:
    """Removes corners of a convex polygon that lie within a tolerance of the side that replaces them."""
    kept = [_pair(corner) for corner in corners]

    def distance(k: int) -> float:
        a, b, c = kept[k - 1], kept[k], kept[(k + 1) % len(kept)]
        return abs(_cross(a, b, c)) / max(float(numpy.hypot(c[0] - a[0], c[1] - a[1])), 1e-30)

    while len(kept) > 3:
        distances = [distance(k) for k in range(len(kept))]
        nearest = int(numpy.argmin(distances))
        if distances[nearest] > tolerance:
            break
        del kept[nearest]
    return numpy.array(kept)


def _normals(corners: Numbers) -> Numbers:
    """Outer normals of the sides of a counter-clockwise polygon."""
    sides = numpy.roll(corners, -1, axis=0) - corners
    normals = numpy.stack([sides[:, 1], -sides[:, 0]], axis=1)
    lengths: Numbers = numpy.linalg.norm(normals, axis=1, keepdims=True)
    return normals / numpy.maximum(lengths, 1e-30)


def _width(corners: Numbers) -> float:
    reach = corners @ _normals(corners).T
    return float((reach.max(axis=0) - reach.min(axis=0)).min())


def _eroded(corners: Numbers, radius: float) -> Numbers:
    """The points of a convex polygon that are at least `radius` from its sides."""
    polygon = [corner for corner in corners]
    for normal, corner in zip(_normals(corners), corners, strict=True):
        level = float(normal @ corner) - radius
        clipped: list[Any] = []
        for k, point in enumerate(polygon):
            following = polygon[(k + 1) % len(polygon)]
            here, there = float(normal @ point) - level, float(normal @ following) - level
            if here <= 0.0:
                clipped.append(point)
            if (here < 0.0 < there) or (there < 0.0 < here):
                clipped.append(point + (following - point) * (here / (here - there)))
        polygon = clipped
    return convex_hull(numpy.array(polygon))


def core_of(outline: Outline, at: Any, angle: float = 0.0) -> tuple[Numbers, float]:
    """Points and radius whose hull is an outline, for a body at a pose. A half plane has none."""
    cos, sin = numpy.cos(angle), numpy.sin(angle)
    turn = numpy.array([[cos, -sin], [sin, cos]])
    points, radius = numpy.array(outline.points), 0.0
    if outline.type in ("disc", "capsule"):
        radius = outline.sizes[0]
    elif outline.type == "polygon":
        radius = outline.rounding
    else:
        local = numpy.array([[numpy.cos(outline.angle), -numpy.sin(outline.angle)], [numpy.sin(outline.angle), numpy.cos(outline.angle)]])
        if outline.type == "box":
            signs = numpy.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
            points = points[0] + (signs * outline.sizes) @ local.T
        elif outline.type == "ellipse":
            circle = numpy.linspace(0.0, 2.0 * numpy.pi, _CIRCLE_POINTS, endpoint=False)
            points = points[0] + (numpy.stack([numpy.cos(circle), numpy.sin(circle)], axis=1) * outline.sizes) @ local.T
    return points @ turn.T + numpy.asarray(at), radius


def gap(a: Outline, pose_a: tuple[Any, float], b: Outline, pose_b: tuple[Any, float]) -> float:
    """Distance of two outlines, m; negative if they overlap."""
    if b.type == "half_plane":
        a, pose_a, b, pose_b = b, pose_b, a, pose_a
    points, radius = core_of(b, *pose_b)
    if a.type == "half_plane":
        plane = core_of(a, *pose_a)[0][0]
        return float((points - plane).dot(numpy.array(a.sizes)).min() - radius)
    others, other = core_of(a, *pose_a)
    between = (points[:, None, :] - others[None, :, :]).reshape(-1, 2)
    lengths = numpy.linalg.norm(between, axis=1)
    directions = [between[lengths > 1e-12] / lengths[lengths > 1e-12, None]]
    directions += [_normals(convex_hull(shape)) if len(convex_hull(shape)) > 2 else _sides(shape) for shape in (points, others)]
    candidates = [*directions, -directions[1], -directions[2]]
    along = numpy.concatenate(candidates)
    if len(along) == 0:
        return -radius - other
    separations = (points @ along.T).min(axis=0) - (others @ along.T).max(axis=0)
    return float(separations.max() - radius - other)


def _sides(shape: Numbers) -> Numbers:
    """Normals of a segment; none of a point."""
    if len(shape) < 2:
        return numpy.zeros((0, 2))
    along = shape[1] - shape[0]
    normal = numpy.array([along[1], -along[0]]) / max(float(numpy.linalg.norm(along)), 1e-30)
    return numpy.array([normal, -normal])
