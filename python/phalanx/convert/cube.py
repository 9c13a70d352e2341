"""A cube between the fingers of a model that has no object."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy

from ..errors import ConversionError
from .outlines import core_of
from .planar import Mechanism
from .plane import Plane
from .read import Numbers, Source, load_mujoco

NAME = "object"
# Bits of all groups of geoms that may touch each other.
_ALL = 2**31 - 1


def place_of(mechanism: Mechanism) -> tuple[float, float]:
    """The middle of the outlines of all bodies at the ends of the fingers, at the start."""
    carriers = {joint.carrier for joint in mechanism.joints}
    ends = [body for body in mechanism.bodies if not body.is_free and body.outlines and body.name not in carriers]
    # Pads are usually boxes or capsules beside the hulls of meshes.
    chosen = [(body, outline) for body in ends for outline in body.outlines if not outline.comment.startswith("hull")]
    chosen = chosen or [(body, outline) for body in ends or mechanism.bodies for outline in body.outlines]
    by_body: dict[str, list[Numbers]] = {}
    for body, outline in chosen:
        if outline.type != "half_plane":
            by_body.setdefault(body.name, []).append(core_of(outline, body.at, body.angle)[0])
    middles = [0.5 * (points.min(axis=0) + points.max(axis=0)) for points in map(numpy.concatenate, by_body.values())]
    x, y = numpy.mean(middles, axis=0) if middles else (0.0, 0.0)
    return float(x), float(y)


def adder(source: Source, plane: Plane, mechanism: Mechanism, edge: float, mass: float, at: tuple[float, float] | None) -> Callable[[Any], None]:
    """A function that adds the cube to a specification. Its friction is 0, so that the pads determine that of the pairs."""
    mujoco = load_mujoco()
    free = [body.name for body in mechanism.bodies if body.is_free]
    if free:
        raise ConversionError(f"{source.path} has a free body already ({', '.join(free)}), which is the object; leave out --cube")
    x, y = place_of(mechanism) if at is None else at
    heights = [bound for body in mechanism.bodies for outline in body.outlines for bound in outline.depth if numpy.isfinite(bound)]
    height = 0.5 * (min(heights) + max(heights)) if heights else 0.0
    place = plane.origin + x * plane.e1 + y * plane.e2 + height * plane.n
    quat: Numbers = numpy.zeros(4)
    mujoco.mju_mat2Quat(quat, numpy.stack([plane.e1, plane.e2, plane.n], axis=1).reshape(-1))

    def add(spec: Any) -> None:
        body = spec.worldbody.add_body(name=NAME, pos=place, quat=quat)
        body.add_freejoint()
        body.add_geom(
            name=f"{NAME}.skin", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5 * edge] * 3, mass=mass, friction=[0.0, 0.0, 0.0], contype=1, conaffinity=1
        )
        for key in spec.keys:
            key.qpos = [*key.qpos, *place, *quat] if len(key.qpos) else key.qpos
            key.qvel = [*key.qvel, *numpy.zeros(6)] if len(key.qvel) else key.qvel

    return add
