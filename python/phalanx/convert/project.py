"""Projection of a compiled model into its plane.

Frames: the axes of a body are those of the plane in the zero position (qpos0), and its origin is the anchor of its
joint. Every coordinate is therefore that of MuJoCo, with limits, references and signs.
"""

from __future__ import annotations

import re
from typing import Any

import numpy

from ..errors import ConversionError
from .contacts import add_contacts, rounding_of, stop_law
from .drives import add_actuators, add_tendons
from .outlines import ROUNDING_M, outline_of
from .planar import GROUND, Body, Coupling, Joint, Mechanism, Spring, Terms
from .plane import Plane
from .projection import UNLIMITED, Names, Projection
from .read import Numbers, Source, extra, is_below, load_mujoco
from .remarks import add_remarks

# A constraint that is open by more is reported, m or rad.
_OPEN = 1e-6


def project(source: Source, plane: Plane) -> Mechanism:
    """Returns the planar mechanism of a model; the report of the source lists what it lacks."""
    work = Projection(source, plane)
    _check_joints(work)
    _merge_welds(work)
    _merge_pinned(work)
    _add_bodies(work)
    _add_joints(work)
    if not work.joints:
        names = ", ".join(source.label("joint", j) for j in sorted(work.locked))
        raise ConversionError(f"no joint of the mechanism moves: a weld, a second pin or an equality locks {names}; remove it, or choose another part")
    _add_equalities(work)
    add_tendons(work)
    add_actuators(work)
    _choose_starts(work)
    _add_outlines(work)
    add_contacts(work)
    _find_surroundings(work)
    _name_laws(work)
    add_remarks(work)
    return work.mechanism


def _check_joints(work: Projection) -> None:
    mujoco, model, source = load_mujoco(), work.model, work.source
    for body in range(1, model.nbody):
        count, first = model.body_jntnum[body], model.body_jntadr[body]
        if count == 0 or work.is_object(body):
            continue
        names = ", ".join(source.name("joint", j) or str(j) for j in range(first, first + count))
        if any(model.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL for j in range(first, first + count)):
            raise ConversionError(
                f"the joint {names} of {source.label('body', body)} is a ball joint, which is not planar; replace it by a hinge, or choose --root"
            )
        if count > 1:
            raise ConversionError(
                f"{source.label('body', body)} has {count} joints ({names}), but a body of a scene has one; put a body with mass between them, "
                f'or take the body as the ground: --root "{source.name("body", body) or body}"'
            )


def _merge_welds(work: Projection) -> None:
    """Merges bodies that a weld connects, and those of a joint that an equality locks."""
    mujoco, model = load_mujoco(), work.model
    if work.is_disabled("EQUALITY") or work.is_disabled("CONSTRAINT"):
        if model.neq:
            work.report.lost("equalities", "the option of the model disables them")
        return
    for k in range(model.neq):
        if not model.eq_active0[k]:
            continue
        if model.eq_type[k] == mujoco.mjtEq.mjEQ_JOINT and model.eq_obj2id[k] < 0 and abs(model.eq_data[k, 0]) < _OPEN:
            _merge_locked(work, k)
        if model.eq_type[k] != mujoco.mjtEq.mjEQ_WELD:
            continue
        first, second = (_body_of(work, k, side) for side in (0, 1))
        groups = sorted((int(work.group[first]), int(work.group[second])))
        if groups[0] == groups[1]:
            continue
        label = work.source.label("equality", k)
        shift, turn = _weld_error(work, k, first, second)
        if shift > _OPEN or turn > _OPEN:
            opening = f"{1e3 * shift:.3g} mm and {numpy.degrees(turn):.3g} deg"
            work.report.warn(label, f"the weld is open by {opening} in the zero position; the scene keeps the bodies as they are")
        _merge(work, groups[0], groups[1])
        work.report.changed(label, f"{work.source.name('body', first) or 'world'} and {work.source.name('body', second) or 'world'} are one body")


def _merge_pinned(work: Projection) -> None:
    """Merges bodies that two pins in different places hold: hinges of the model, and `connect`."""
    if work.is_disabled("EQUALITY") or work.is_disabled("CONSTRAINT"):
        return
    mujoco, model, plane = load_mujoco(), work.model, work.plane
    pins: dict[tuple[int, int], Numbers] = {}
    for j in range(model.njnt):
        owner = int(model.jnt_bodyid[j])
        if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE and not work.is_object(owner):
            groups = sorted((int(work.group[owner]), int(work.group[model.body_parentid[owner]])))
            pins[groups[0], groups[1]] = plane.point(work.zero.xanchor[j])
    for k in range(model.neq):
        if model.eq_type[k] != mujoco.mjtEq.mjEQ_CONNECT or not model.eq_active0[k]:
            continue
        groups = sorted(int(work.group[_body_of(work, k, side)]) for side in (0, 1))
        place = plane.point(_anchors(work, k, work.zero)[0])
        known = pins.setdefault((groups[0], groups[1]), place)
        if groups[0] != groups[1] and numpy.linalg.norm(place - known) > _OPEN:
            _merge(work, groups[0], groups[1])
            work.report.changed(work.source.label("equality", k), "it is the second pin between its bodies, which are one body in the scene")


def _merge(work: Projection, first: int, second: int) -> None:
    """Makes one body of two; a free body joins the other one."""
    if first and work.is_object(first) and not work.is_object(second):
        first, second = second, first
    work.group[work.group == second] = first


def _merge_locked(work: Projection, k: int) -> None:
    """Merges the bodies of a joint that an equality locks in the zero position."""
    body = int(work.model.jnt_bodyid[work.model.eq_obj1id[k]])
    if not work.is_object(body):
        _merge(work, *sorted((int(work.group[body]), int(work.group[work.model.body_parentid[body]]))))


def _weld_error(work: Projection, k: int, first: int, second: int) -> tuple[float, float]:
    """Opening of a weld in the zero position, m and rad."""
    mujoco, model, data = load_mujoco(), work.model, work.zero
    if model.eq_objtype[k] == mujoco.mjtObj.mjOBJ_SITE:
        sites = model.eq_obj1id[k], model.eq_obj2id[k]
        turn = data.site_xmat[sites[0]].reshape(3, 3).T @ data.site_xmat[sites[1]].reshape(3, 3)
        return float(numpy.linalg.norm(data.site_xpos[sites[0]] - data.site_xpos[sites[1]])), abs(_angle(turn))
    values, frames = model.eq_data[k], [data.xmat[body].reshape(3, 3) for body in (first, second)]
    anchor = data.xpos[second] + frames[1] @ values[0:3]
    expected = data.xpos[first] + frames[0] @ values[3:6]
    rotation = numpy.zeros(9)
    mujoco.mju_quat2Mat(rotation, values[6:10])
    turn = rotation.reshape(3, 3).T @ frames[0].T @ frames[1]
    return float(numpy.linalg.norm(anchor - expected)), abs(_angle(turn))


def _angle(rotation: Numbers) -> float:
    sine = 0.5 * float(numpy.linalg.norm([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]))
    return float(numpy.arctan2(sine, 0.5 * (numpy.trace(rotation) - 1.0)))


def _body_of(work: Projection, equality: int, side: int) -> int:
    """Body of an object of an equality, which may be a site."""
    index = (work.model.eq_obj1id, work.model.eq_obj2id)[side][equality]
    if work.model.eq_objtype[equality] == load_mujoco().mjtObj.mjOBJ_SITE:
        return int(work.model.site_bodyid[index])
    return int(index)


def _add_bodies(work: Projection) -> None:
    mujoco, model, plane = load_mujoco(), work.model, work.plane
    names = Names([GROUND])
    for group in sorted({int(group) for group in work.group} - {0}):
        members = [member for member in range(model.nbody) if work.group[member] == group]
        is_free = work.is_object(group)
        data = work.start if is_free else work.zero
        masses = model.body_mass[members]
        total = float(masses.sum())
        label = work.source.label("body", group)
        if total <= 0.0:
            raise ConversionError(f"{label} moves but has no mass; give it an inertial, or a geom with a density")
        turn = work.start.xmat[group].reshape(3, 3) @ work.zero.xmat[group].reshape(3, 3).T
        anchor = data.xpos[group] if is_free else work.zero.xanchor[model.body_jntadr[group]]
        origin = plane.point(anchor)
        at = plane.point(work.start.xpos[group] + (0.0 if is_free else turn @ (anchor - work.zero.xpos[group])))
        angle = _angle_of_free(work, group) if is_free else plane.angle(turn)
        frame = plane.moved(origin, angle if is_free else 0.0)
        centers = numpy.array([frame.point(data.xipos[member]) for member in members])
        center = masses @ centers / total
        inertia = 0.0
        for member, mass, place in zip(members, masses, centers, strict=True):
            axis = data.ximat[member].reshape(3, 3).T @ plane.n
            inertia += float(axis @ (model.body_inertia[member] * axis) + mass * numpy.sum((place - center) ** 2))
        body = Body(
            name=names.new(work.source.name("body", group), f"body_{group}"),
            origin=_pair(origin),
            mass=total,
            com=_pair(center),
            inertia=inertia,
            members=[work.source.name("body", member) or str(member) for member in members],
            at=_pair(at),
            angle=angle,
            is_free=is_free,
        )
        work.frames[group] = frame
        if is_free:
            velocity = numpy.zeros(6)
            mujoco.mj_objectVelocity(model, work.start, mujoco.mjtObj.mjOBJ_XBODY, group, velocity, 0)
            body.velocity, body.spin = _pair(plane.vector(velocity[3:])), float(plane.n @ velocity[:3])
        if len(members) > 1 and not is_free:
            what = "has no joint that moves, and is a part of it" if len(members) == 2 else "have no joint that moves, and are parts of it"
            work.report.changed(label, f"{', '.join(body.members[1:])} {what}")
        if any(model.body_gravcomp[member] != 0.0 for member in members):
            work.report.lost(label, "its gravity compensation; it weighs as much as its mass")
        work.bodies[group] = body
        work.mechanism.bodies.append(body)


def _angle_of_free(work: Projection, group: int) -> float:
    """Angle of the frame of a free body at the start: that of its first axis, if its third one is the normal of the plane, or
    else its turn since the zero position.
    """
    plane, frame = work.plane, work.start.xmat[group].reshape(3, 3)
    if plane.n @ frame[:, 2] > 1.0 - 1e-9:
        return plane.angle(frame @ numpy.stack([plane.e1, plane.e2, plane.n]))
    turn = frame @ work.zero.xmat[group].reshape(3, 3).T
    return plane.angle(turn) if plane.n @ turn @ plane.n > 1.0 - 1e-9 else 0.0


def _pair(point: Any) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _add_joints(work: Projection) -> None:
    mujoco, model, plane = load_mujoco(), work.model, work.plane
    for j in range(model.njnt):
        owner = int(model.jnt_bodyid[j])
        label, name = work.source.label("joint", j), work.source.name("joint", j)
        if work.is_object(owner):
            _report_joint_of_object(work, j)
            continue
        child, parent = int(work.group[owner]), int(work.group[model.body_parentid[owner]])
        if child == parent:
            work.report.changed(label, "a weld, a second pin or an equality locks it; its bodies are one")
            work.locked.add(j)
            continue
        address = model.jnt_qposadr[j]
        zero, anchor, axis = float(model.qpos0[address]), work.zero.xanchor[j], work.zero.xaxis[j]
        points = [numpy.array(work.local(group, anchor)) for group in (parent, child)]
        joint = Joint(work.names["joint"].new(name, f"joint_{j}"), (work.name_of(parent), work.name_of(child)), (_pair(points[0]), _pair(points[1])))
        if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE:
            along = plane.vector(axis)
            along /= numpy.linalg.norm(along)
            joint.is_slide, joint.axis = True, float(numpy.arctan2(along[1], along[0]))
            joint.points = _pair(points[0] - zero * along), _pair(points[1])
            joint.comment = f"slide {name}"
        else:
            joint.offset, joint.comment = -zero + 0.0, f"hinge {name}"
            if axis @ plane.n < 0.0:
                joint.bodies, joint.points = joint.bodies[::-1], joint.points[::-1]
                joint.comment += ", whose axis points into the plane: the bodies are in reverse order"
        dof = model.jnt_dofadr[j]
        joint.damping = 0.0 if work.is_disabled("DAMPER") else float(model.dof_damping[dof])
        joint.armature = float(model.dof_armature[dof])
        joint.friction = 0.0 if work.is_disabled("FRICTIONLOSS") or work.is_disabled("CONSTRAINT") else float(model.dof_frictionloss[dof])
        if extra(model, "dof_dampingpoly", dof).any():
            work.report.lost(label, "its nonlinear damping")
        if model.jnt_limited[j] and not work.is_disabled("LIMIT") and not work.is_disabled("CONSTRAINT"):
            _add_limits(work, joint, j, label)
        stiffness, rest = float(numpy.ravel(model.jnt_stiffness[j])[0]), float(model.qpos_spring[address])
        if stiffness != 0.0 and not work.is_disabled("SPRING"):
            comment = f"stiffness and springref of {name or label}"
            spring = Spring(
                work.names["spring"].new(name, f"joint_{j}"),
                stiffness,
                0.0,
                rest,
                [(joint.name, 1.0)],
                is_linear=joint.is_slide,
                comment=comment,
            )
            work.mechanism.springs.append(spring)
        if extra(model, "jnt_stiffnesspoly", j).any():
            work.report.lost(label, "its nonlinear stiffness")
        if extra(model, "jnt_springyield", j).any():
            work.report.lost(label, "the yield of its spring")
        joint.index, joint.carrier = j, work.name_of(parent)
        work.joints[j] = joint
        work.mechanism.joints.append(joint)


def _report_joint_of_object(work: Projection, j: int) -> None:
    model, dof = work.model, work.model.jnt_dofadr[j]
    found = {"damping": model.dof_damping[dof], "armature": model.dof_armature[dof], "frictionloss": model.dof_frictionloss[dof]}
    found |= {"limits": model.jnt_limited[j], "stiffness": numpy.ravel(model.jnt_stiffness[j])[0]}
    names = [name for name, value in found.items() if value]
    if names:
        work.report.lost(work.source.label("joint", j), f"{', '.join(names)}; its body moves freely")


def _add_limits(work: Projection, joint: Joint, j: int, label: str) -> None:
    model = work.model
    lower, upper = (float(bound) for bound in model.jnt_range[j])
    position = float(work.start.qpos[model.jnt_qposadr[j]])
    unit = "m" if joint.is_slide else "rad"
    for side, bound, beyond in (("lower", lower, lower - position), ("upper", upper, position - upper)):
        if abs(bound) >= UNLIMITED:
            continue
        if beyond > 1e-9:
            work.report.lost(label, f"its {side} limit of {bound:.6g} {unit}: the start, {position:.6g} {unit}, is beyond it")
        else:
            setattr(joint, side, bound)
    if joint.lower is None and joint.upper is None:
        return
    if model.jnt_margin[j] != 0.0:
        work.report.lost(label, f"the margin of its limits, {model.jnt_margin[j]:.4g} {unit}; the stops act at the limits themselves")
    inverse = float(model.dof_invweight0[model.jnt_dofadr[j]])
    joint.stop = stop_law(work, model.jnt_solref[j], model.jnt_solimp[j], inverse, joint.is_slide)


def _row(work: Projection, terms: Terms) -> Numbers:
    row = numpy.zeros(work.model.njnt)
    index = {joint.name: j for j, joint in work.joints.items()}
    for name, factor in terms:
        row[index[name]] += factor
    return row


def _jacobian(work: Projection, body: int, point: Any) -> Numbers:
    """Velocity and spin of a point of a body over the rates of all joints, at the start; shape (3, joints)."""
    model, plane, data = work.model, work.plane, work.start
    found = numpy.zeros((3, model.njnt))
    while body > 0:
        for j in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            if j in work.joints and work.joints[j].is_slide:
                found[:2, j] = plane.vector(data.xaxis[j])
            elif j in work.joints:
                sign = numpy.sign(data.xaxis[j] @ plane.n)
                arm = plane.vector(point - data.xanchor[j])
                found[:, j] = sign * -arm[1], sign * arm[0], sign
        body = int(model.body_parentid[body])
    return found


def _add_equalities(work: Projection) -> None:
    mujoco, model = load_mujoco(), work.model
    if work.is_disabled("EQUALITY") or work.is_disabled("CONSTRAINT"):
        return
    for k in range(model.neq):
        kind, label = mujoco.mjtEq(model.eq_type[k]), work.source.label("equality", k)
        if not model.eq_active0[k]:
            work.report.lost(label, "it is not active at the start; the scene does not have it")
        elif kind == mujoco.mjtEq.mjEQ_CONNECT:
            _add_connect(work, k, label)
        elif kind == mujoco.mjtEq.mjEQ_WELD:
            _add_weld_rows(work, k)
        elif kind in (mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON):
            _add_coupling(work, k, label, is_of_joints=kind == mujoco.mjtEq.mjEQ_JOINT)
        else:
            work.report.lost(label, f"{kind.name} has no equivalent; what it connects is free")
    if work.exact:
        softest = max(float(model.eq_solref[k, 0]) for k in work.exact)
        text = f"{len(work.exact)} soft constraints (solref up to {softest:.4g} s) are exact in the scene"
        work.report.changed("equalities", text + "; phalanx.compare_mujoco shows how far they open in MuJoCo" if softest > 0.0 else text)


def _anchors(work: Projection, k: int, data: Any) -> tuple[Any, Any]:
    """Both anchors of a `connect` in the world."""
    model = work.model
    if model.eq_objtype[k] == load_mujoco().mjtObj.mjOBJ_SITE:
        return data.site_xpos[model.eq_obj1id[k]], data.site_xpos[model.eq_obj2id[k]]
    bodies = model.eq_obj1id[k], model.eq_obj2id[k]
    first, second = (data.xpos[body] + data.xmat[body].reshape(3, 3) @ model.eq_data[k, 3 * side : 3 * side + 3] for side, body in enumerate(bodies))
    return first, second


def _add_connect(work: Projection, k: int, label: str) -> None:
    bodies = [_body_of(work, k, side) for side in (0, 1)]
    groups = [int(work.group[body]) for body in bodies]
    if groups[0] == groups[1]:
        return
    if any(group and work.bodies[group].is_free for group in groups):
        work.report.lost(label, "it connects a free body; the body stays free")
        return
    anchors = _anchors(work, k, work.zero)
    points = [work.local(group, anchor) for group, anchor in zip(groups, anchors, strict=True)]
    opening = float(numpy.linalg.norm(work.plane.vector(anchors[0] - anchors[1])))
    if opening > 1e-9:
        work.report.changed(
            label,
            f"its anchors are {1e6 * opening:.3g} µm apart in the zero position; phalanx assembles the loop, and moves the links by about as much",
        )
    names = tuple(work.name_of(group) for group in groups)
    for joint in work.mechanism.joints:
        same = joint.bodies == names or joint.bodies == names[::-1]
        own = points if joint.bodies == names else points[::-1]
        if same and not joint.is_slide and numpy.allclose(joint.points, own, rtol=0.0, atol=1e-6):
            work.report.changed(label, f"in the plane it is the same pin as {joint.name}")
            return
    first, second = (_jacobian(work, body, anchor) for body, anchor in zip(bodies, _anchors(work, k, work.start), strict=True))
    work.rows += list((first - second)[:2])
    work.exact.append(k)
    name = work.names["joint"].new(work.source.name("equality", k), "_".join(names))
    work.mechanism.joints.append(
        Joint(
            name,
            (names[0], names[1]),
            (points[0], points[1]),
            comment=f"connect {work.source.name('equality', k)}".rstrip() + ", exact here",
        )
    )


def _add_weld_rows(work: Projection, k: int) -> None:
    bodies = [_body_of(work, k, side) for side in (0, 1)]
    place = work.start.xpos[bodies[0]]
    first, second = (_jacobian(work, body, place) for body in bodies)
    work.rows += list(first - second)


def _add_coupling(work: Projection, k: int, label: str, *, is_of_joints: bool) -> None:
    """Couples joints by the sum of c (q - q0) = a0, with q0 of qpos0; also fixed tendons, whose lengths are such sums."""
    model, data = work.model, work.model.eq_data[k]
    if numpy.any(data[2:5] != 0.0):
        order = 2 + int(numpy.flatnonzero(data[2:5])[-1])
        remedy = "set its coefficients of order 2 to 4 to 0"
        raise ConversionError(f"{label} is a polynomial of order {order}, but a coupling is linear; {remedy}")
    factors: dict[str, float] = {}
    for index, side in ((int(model.eq_obj1id[k]), 1.0), (int(model.eq_obj2id[k]), -float(data[1]))):
        terms = [] if index < 0 else _terms_of(work, index, is_of_joints=is_of_joints)
        if terms is None:
            what = "a joint of a free body" if is_of_joints else "a spatial tendon, whose length cannot be fixed"
            work.report.lost(label, f"it acts on {what}")
            return
        for name, factor in terms:
            factors[name] = factors.get(name, 0.0) + side * factor
    zero = {joint.name: float(model.qpos0[model.jnt_qposadr[j]]) for j, joint in work.joints.items()}
    coupled = [(name, factor) for name, factor in factors.items() if factor != 0.0]
    value = float(data[0]) + sum(factor * zero[name] for name, factor in coupled)
    if not coupled:
        return
    if len(coupled) == 1:
        name, factor = coupled[0]
        remedy = "remove the joint from its body, which is drawn in this position" if abs(data[0]) < _OPEN else "remove it, and draw the body there"
        raise ConversionError(f"{label} locks the joint {name} at {value / factor + 0.0:.6g}; a scene has no locked joints: {remedy}")
    if abs(data[0]) > _OPEN:
        work.report.changed(label, f"it is violated by {abs(data[0]):.4g} in the zero position; phalanx assembles the mechanism with it")
    work.rows.append(_row(work, coupled))
    work.exact.append(k)
    own = work.source.name("equality", k)
    default = "_".join(name for name, _ in coupled)
    name = work.names["coupling"].new(own or ("" if is_of_joints else work.source.name("tendon", int(model.eq_obj1id[k]))), default)
    is_linear = next(joint.is_slide for joint in work.mechanism.joints if joint.name == coupled[0][0])
    comment = f"{'joint' if is_of_joints else 'tendon'} equality {own}".rstrip()
    work.mechanism.couplings.append(Coupling(name, coupled, value, is_linear, comment))


def _terms_of(work: Projection, index: int, *, is_of_joints: bool) -> Terms | None:
    """Joints and factors of a joint or a fixed tendon; none of a locked joint, and None of what is not a sum of joints."""
    if not is_of_joints:
        return work.sum_of_tendon(index)
    if index in work.locked:
        return []
    return [(work.joints[index].name, 1.0)] if index in work.joints else None


def _choose_starts(work: Projection) -> None:
    """Gives a start to as many joints as the mechanism has degrees of freedom: driven and limited joints first."""
    driven = {name for actuator in work.mechanism.actuators for name, _ in actuator.terms}
    order = sorted(
        work.joints, key=lambda j: (work.joints[j].name in driven, work.joints[j].lower is not None or work.joints[j].upper is not None, -j)
    )
    matrix = numpy.array(work.rows).reshape(len(work.rows), work.model.njnt)
    # Rows and columns have different units: scaled, so that ranks do not depend on them.
    scale = numpy.abs(matrix).max(axis=1, keepdims=True) if len(matrix) else matrix
    matrix = matrix / numpy.where(scale > 0.0, scale, 1.0) if len(matrix) else matrix
    basis: list[Numbers] = []
    for j in order:
        column = matrix[:, j].copy()
        length = float(numpy.linalg.norm(column))
        for _ in range(2):
            for vector in basis:
                column -= (vector @ column) * vector
        rest = float(numpy.linalg.norm(column))
        if length > 0.0 and rest > 1e-6 * length:
            basis.append(column / rest)
            continue
        joint = work.joints[j]
        joint.start = float(work.start.qpos[work.model.jnt_qposadr[j]])
        joint.start_rate = float(work.start.qvel[work.model.jnt_dofadr[j]])


def _add_outlines(work: Projection) -> None:
    """Outlines of all geoms that can touch; bodies without such geoms have those that are only drawn."""
    model, pairs = work.model, set(work.model.pair_geom1.tolist()) | set(work.model.pair_geom2.tolist())
    touching = {g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g] or g in pairs}
    if work.is_disabled("CONTACT"):
        touching = set()
    by_group: dict[int, list[int]] = {}
    for geom in range(model.ngeom):
        owner = int(model.geom_bodyid[geom])
        if work.source.name("body", owner) not in work.source.frozen or int(work.group[owner]) != 0:
            by_group.setdefault(int(work.group[owner]), []).append(geom)
    hidden = 0
    work.rounding = rounding_of(work, sorted(touching & {geom for geoms in by_group.values() for geom in geoms}))
    if work.rounding > ROUNDING_M:
        text = f"corners have a rounding of up to {1e3 * work.rounding:g} mm, because the contacts of the model are that soft"
        work.report.changed("outlines", text)
    for group, geoms in by_group.items():
        chosen = [geom for geom in geoms if geom in touching]
        if not chosen and group:
            chosen = geoms
        hidden += len(geoms) - len(chosen)
        body = work.bodies[group] if group else None
        taken = Names()
        for geom in chosen:
            name = _outline_name(work, geom, taken)
            made = outline_of(work.source, geom, work.frames[group], work.data_of(group), name, work.rounding)
            if made is None or (made.type == "polygon" and not made.points):
                continue
            if geom not in touching:
                made.comment += ", drawn only"
            (body.outlines if body else work.mechanism.ground).append(made)
            work.outlines[geom] = (body, made)
    if hidden:
        work.report.lost("visual geoms", f"geoms that touch nothing are not drawn ({hidden})")


def _outline_name(work: Projection, geom: int, taken: Names) -> str:
    """Name of a geom without the name of its body, or name of its mesh or type."""
    mujoco, model = load_mujoco(), work.model
    name, owner = work.source.name("geom", geom), work.source.name("body", int(model.geom_bodyid[geom])) or GROUND
    for prefix in (owner, GROUND):
        if re.match(rf"{re.escape(prefix)}\W", name):
            name = name[len(prefix) + 1 :]
    if not name and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        name = work.source.name("mesh", int(model.geom_dataid[geom]))
    return taken.new(name, mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower())


def _find_surroundings(work: Projection) -> None:
    """Planes do not belong to the hand. If the hand has a base of its own, only what this carries, or stands on, does."""
    mujoco, model, base = load_mujoco(), work.model, work.plane.root
    touched = {name for contact in work.mechanism.contacts for name in contact.between}
    for geom, (body, outline) in work.outlines.items():
        owner = int(model.geom_bodyid[geom])
        is_of_hand = base == 0 or is_below(model, owner, base) or (owner > 0 and is_below(model, base, owner))
        is_plane = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE
        name = f"{GROUND}.{outline.name}"
        if body is None and name in touched and (is_plane or not is_of_hand) and any(other.is_free for other in work.mechanism.bodies):
            work.mechanism.surroundings.append(name)


def _name_laws(work: Projection) -> None:
    """Replaces the keys of laws by names."""
    springs = [law for law in work.mechanism.laws if law.is_spring]
    stops = [law for law in work.mechanism.laws if law.friction is None and not law.is_spring]
    pads = [law for law in work.mechanism.laws if law.friction is not None]
    for laws, base in ((stops, "stop"), (pads, "pad"), (springs, "band")):
        for number, law in enumerate(laws, 1):
            old, law.name = law.name, base if len(laws) == 1 else f"{base}_{number}"
            for joint in work.mechanism.joints:
                joint.stop = law.name if joint.stop == old else joint.stop
            for limit in work.mechanism.limits:
                limit.stop = law.name if limit.stop == old else limit.stop
            for contact in work.mechanism.contacts:
                contact.law = law.name if contact.law == old else contact.law
    if stops or pads:
        text = "solref and solimp have no equivalent: the laws have the stiffness of MuJoCo's static penetration, and a damping that is assumed"
        work.report.changed("contacts and limits", text)
