"""What else a model has without an equivalent, and warnings about numbers that no real gripper has."""

from __future__ import annotations

from typing import Any

import numpy

from .outlines import core_of
from .planar import FRICTION_DEFLECTION, Body
from .projection import Projection
from .read import extra, load_mujoco

# Ratio of armature and own inertia above which the armature is not that of a motor.
_LARGEST_ARMATURE = 100.0
# Ratio of frictionloss and weight of a body above which the friction is not that of a joint.
_LARGEST_FRICTION = 20.0
# Radius of gyration over the extent of a solid body.
_GYRATION = (0.1, 0.7)


def _extent(work: Projection, body: Body) -> float:
    """Largest distance of points of a body, m."""
    points: list[Any] = [
        point for joint in work.mechanism.joints for name, point in zip(joint.bodies, joint.points, strict=True) if name == body.name
    ]
    reach = 0.0
    for outline in body.outlines:
        if outline.type != "half_plane":
            corners, radius = core_of(outline, (0.0, 0.0))
            points, reach = points + list(corners), max(reach, radius)
    if not points:
        return 2.0 * reach
    cloud = numpy.array(points)
    return float(max(numpy.linalg.norm(cloud - point, axis=1).max() for point in cloud)) + 2.0 * reach


def add_remarks(work: Projection) -> None:
    """Adds to the report what the other modules do not see."""
    _report_losses(work)
    _warn_about_joints(work)
    _warn_about_bodies(work)


def _report_losses(work: Projection) -> None:
    model, report = work.model, work.report
    keys = [model.key(k).name or str(k) for k in range(model.nkey)]
    others = [key for key in keys if key != work.source.key]
    if others:
        report.lost("key frames", f"{', '.join(others)}: a scene has one start")
    if model.nsensor:
        report.lost("sensors", f"all {model.nsensor}: results have columns of joints, bodies and contacts instead")
    for body in range(model.nbody):
        if model.body_mocapid[body] >= 0:
            report.lost(work.source.label("body", body), "it is moved from outside (mocap); in the scene it stands still")
    for count, what in ((model.nflex, "flexible bodies"), (model.nplugin, "plugins")):
        if count:
            report.lost(what, "they have no equivalent")
    for name, what in (("geom_adhesion", "adhesion"), ("geom_surfacevel", "moving surfaces")):
        geoms = [work.source.name("geom", geom) or str(geom) for geom in work.outlines if extra(model, name, geom).any()]
        if geoms:
            report.lost(f"geoms {', '.join(geoms)}", f"their {what}")
    for option in ("density", "viscosity"):
        if getattr(model.opt, option) != 0.0:
            report.lost(f"option {option}", "fluid forces have no equivalent")


def _warn_about_joints(work: Projection) -> None:
    mujoco, model = load_mujoco(), work.model
    hinges = [j for j in work.joints if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE and model.jnt_limited[j]]
    if hinges and all(max(abs(model.jnt_range[j])) < numpy.radians(5.0) for j in hinges):
        work.report.warn(
            "ranges of hinges",
            'all are below 5 deg: the file is probably a fragment of a larger model with <compiler angle="radian">; add this line',
        )
    inertias = {body.name: body for body in work.mechanism.bodies}
    for joint in work.joints.values():
        body = inertias[next(name for name in joint.bodies if name != joint.carrier)]
        own = body.mass if joint.is_slide else body.inertia
        if joint.armature > _LARGEST_ARMATURE * own:
            unit = "kg" if joint.is_slide else "kg m^2"
            work.report.warn(
                f"joint {joint.name}",
                f"its armature of {joint.armature:.4g} {unit} is {joint.armature / own:.0f} times the inertia of its body; "
                "check that it is that of the motor, and not a setting for the solver",
            )
        weight = 9.81 * body.mass * (1.0 if joint.is_slide else _extent(work, body))
        if joint.friction > _LARGEST_FRICTION * weight > 0.0:
            unit, lever = ("N", "") if joint.is_slide else ("N m", ", with its extent as lever")
            work.report.warn(
                f"joint {joint.name}",
                f"its frictionloss of {joint.friction:.4g} {unit} is {joint.friction / weight:.0f} times the weight of its body{lever}",
            )
        if joint.friction:
            work.report.changed(
                f"joint {joint.name}",
                f"its frictionloss has a bristle that yields by {FRICTION_DEFLECTION:g} {'m' if joint.is_slide else 'rad'}",
            )
    for k in range(model.neq):
        if model.eq_type[k] == mujoco.mjtEq.mjEQ_TENDON and numpy.ravel(model.tendon_stiffness[model.eq_obj1id[k]])[0] != 0.0:
            work.report.warn(
                work.source.label("equality", k),
                "its tendon also has a spring, which opens the soft constraint: in MuJoCo the joints move differently from an exact coupling",
            )
    if not work.mechanism.actuators and not any(tendon.stiffness and not tendon.is_range for tendon in work.mechanism.tendons):
        efforts = [f"{joint.name} {abs(model.jnt_actfrcrange[j]).max():g}" for j, joint in work.joints.items() if model.jnt_actfrclimited[j]]
        limits = f" (largest efforts of the model: {', '.join(efforts)}, in N m or N)" if efforts else ""
        work.report.warn("actuators", f"the scene has none: add a section [actuators.NAME]{limits}, or nothing closes the hand")


def _warn_about_bodies(work: Projection) -> None:
    for body in work.mechanism.bodies:
        extent, gyration = _extent(work, body), float(numpy.sqrt(body.inertia / body.mass))
        if extent > 1e-6 and not _GYRATION[0] <= gyration / extent <= _GYRATION[1]:
            work.report.warn(
                f"body {body.name}",
                f"its radius of gyration is {1e3 * gyration:.3g} mm, but its extent {1e3 * extent:.3g} mm: the inertia is probably a placeholder",
            )
        if not body.is_free and float(numpy.hypot(*body.com)) < 1e-9:
            work.report.warn(f"body {body.name}", "its centre of mass is exactly in its joint: probably a placeholder")
