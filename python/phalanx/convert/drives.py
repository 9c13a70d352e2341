"""Tendons and actuators of a model as springs, cables and actuators of a scene."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Literal

import numpy

from .contacts import law_name, stop_law, taut_cable
from .planar import Actuator, Element, Joint, Law, Rotor, Spring, SumLimit, Tendon, Terms
from .projection import UNLIMITED, Projection
from .read import extra, is_below, load_mujoco

# Two times of a table of commands that are closer are a step, s.
_STEP_S = 1e-9


def add_tendons(work: Projection) -> None:
    """Adds springs and cables of tendons."""
    mujoco, model = load_mujoco(), work.model
    for t in range(model.ntendon):
        label = work.source.label("tendon", t)
        kinds = {int(kind) for kind in model.wrap_type[model.tendon_adr[t] : model.tendon_adr[t] + model.tendon_num[t]]}
        if model.tendon_limited[t] and not work.is_disabled("LIMIT"):
            _add_range(work, t, label)
        lost = {"frictionloss": model.tendon_frictionloss[t] != 0.0, "nonlinear stiffness": extra(model, "tendon_stiffnesspoly", t).any()}
        lost |= {
            "nonlinear damping": extra(model, "tendon_dampingpoly", t).any(),
            "spring yield": extra(model, "tendon_springyield", t).any(),
        }
        for what in (name for name, is_lost in lost.items() if is_lost):
            work.report.lost(label, f"its {what}")
        if int(mujoco.mjtWrap.mjWRAP_JOINT) in kinds:
            _add_fixed_tendon(work, t, label)
        else:
            _add_spatial_tendon(work, t, label)


def _add_range(work: Projection, t: int, label: str) -> None:
    """The range of a tendon: limits of its joint, or of a sum of joints; that of a cable is lost."""
    model, joints = work.model, {joint.name: joint for joint in work.mechanism.joints}
    bounds = [float(bound) for bound in model.tendon_range[t]]
    terms = work.sum_of_tendon(t)
    kinds = {joints[name].is_slide for name, _ in terms or []}
    if terms is None and model.wrap_type[model.tendon_adr[t]] != load_mujoco().mjtWrap.mjWRAP_JOINT:
        work.ranges.add(t)
        return
    text = f"its range of {bounds[0]:.6g} to {bounds[1]:.6g}"
    if not terms or len(kinds) > 1:
        work.report.lost(label, f"{text}; nothing stops it at these lengths")
        return
    start = {joint.name: float(work.start.qpos[model.jnt_qposadr[j]]) for j, joint in work.joints.items()}
    length = sum(factor * start[name] for name, factor in terms)
    if _is_fixed(work, terms):
        work.report.changed(label, f"{text} has no effect, because equalities fix its length at {length:.6g}")
        return
    beyond = bounds[0] - length > 1e-9, length - bounds[1] > 1e-9
    if any(beyond):
        work.report.lost(label, f"{text}: its length at the start, {length:.6g}, is beyond it")
    lower, upper = (None if outside or abs(bound) >= UNLIMITED else bound for bound, outside in zip(bounds, beyond, strict=True))
    if lower is None and upper is None:
        return
    (is_linear,) = kinds
    joint, factor = joints[terms[0][0]], terms[0][1]
    ends = [None if bound is None else bound / factor for bound in (lower, upper)]
    ends = ends if factor > 0.0 else ends[::-1]
    if len(terms) == 1 and joint.stop:
        _narrow(work, joint, ends, label)
        return
    settings = model.tendon_solref_lim[t], model.tendon_solimp_lim[t], float(model.tendon_invweight0[t])
    stop = stop_law(work, *settings, is_linear, factor if len(terms) == 1 else 1.0)
    if len(terms) == 1:
        (joint.lower, joint.upper), joint.stop = ends, stop
    else:
        name = work.names["limit"].new(work.source.name("tendon", t), f"tendon_{t}")
        work.mechanism.limits.append(SumLimit(name, terms, lower, upper, stop, is_linear))


def _is_fixed(work: Projection, terms: Terms) -> bool:
    """Whether couplings alone determine a sum of joint coordinates. A limit of such a sum would have no effect, and act at
    rounding errors.
    """
    if not work.mechanism.couplings:
        return False
    names = [joint.name for joint in work.joints.values()]
    rows = numpy.array([[dict(row).get(name, 0.0) for name in names] for row in (*(c.terms for c in work.mechanism.couplings), terms)])
    factors = numpy.linalg.lstsq(rows[:-1].T, rows[-1], rcond=None)[0]
    return bool(numpy.abs(rows[:-1].T @ factors - rows[-1]).max() < 1e-9 * numpy.abs(rows[-1]).max())


def _narrow(work: Projection, joint: Joint, ends: list[float | None], label: str) -> None:
    """Narrows the limits of a joint to those of its tendon; the law stays that of the joint."""
    for side, end, sign in (("lower", ends[0], 1.0), ("upper", ends[1], -1.0)):
        own = getattr(joint, side)
        if end is not None and (own is None or sign * (end - own) > 0.0):
            setattr(joint, side, end)
            work.report.changed(label, f"its range is the {side} limit of the joint {joint.name}, with the stop of this joint")


def _springs_of_tendon(work: Projection, t: int) -> tuple[float, float, float, float]:
    model = work.model
    stiffness = 0.0 if work.is_disabled("SPRING") else float(numpy.ravel(model.tendon_stiffness[t])[0])
    damping = 0.0 if work.is_disabled("DAMPER") else float(model.tendon_damping[t])
    low, high = (float(length) for length in model.tendon_lengthspring[t])
    return stiffness, damping, low, high


def _add_fixed_tendon(work: Projection, t: int, label: str) -> None:
    terms = work.sum_of_tendon(t)
    stiffness, damping, low, high = _springs_of_tendon(work, t)
    armature = float(extra(work.model, "tendon_armature", t)[0])
    if stiffness == damping == armature == 0.0:
        return
    if not terms:
        work.report.lost(label, "it acts on a joint that is locked or belongs to a free body")
        return
    joints, name = {joint.name: joint for joint in work.mechanism.joints}, work.source.name("tendon", t)
    is_linear = joints[terms[0][0]].is_slide
    if high - low > 1e-12 and stiffness != 0.0:
        _add_dead_band(work, t, label, terms, stiffness, (low, high))
        stiffness = 0.0
    if stiffness or damping:
        spring = Spring(work.names["spring"].new(name, f"tendon_{t}"), stiffness, damping, low if stiffness else 0.0, terms, is_linear=is_linear)
        spring.comment = f"spring of the fixed tendon {name}"
        work.mechanism.springs.append(spring)
    if armature:
        if not _is_chain(work, [j for j, joint in work.joints.items() if joint.name in dict(terms)]):
            text = "its armature couples joints of several branches: MuJoCo leaves out the coupling, and the scene has it"
            work.report.changed(label, text)
        work.mechanism.rotors.append(Rotor(work.names["rotor"].new(name, f"tendon_{t}"), terms, armature, is_linear))


def _add_dead_band(work: Projection, t: int, label: str, terms: Terms, stiffness: float, band: tuple[float, float]) -> None:
    """A spring that acts outside of a band of its length: limits with an elastic law."""
    joints = {joint.name: joint for joint in work.mechanism.joints}
    joint, factor = joints[terms[0][0]], terms[0][1]
    text = f"its spring has a dead band from {band[0]:.6g} to {band[1]:.6g}"
    start = {joint.name: float(work.start.qpos[work.model.jnt_qposadr[j]]) for j, joint in work.joints.items()}
    length = sum(each * start[name] for name, each in terms)
    if not band[0] <= length <= band[1]:
        work.report.lost(label, f"{text}: its length at the start, {length:.6g}, is outside, where the scene cannot begin")
        return
    if len(terms) == 1 and joint.stop:
        work.report.lost(label, f"{text}, but the joint {joint.name} has stops; a joint has one pair of limits")
        return
    scale = factor**2 if len(terms) == 1 else 1.0
    law = law_name(work, Law("", scale * stiffness, None, f"spring of {label} beyond its dead band", joint.is_slide, is_spring=True))
    lower, upper = (None if abs(bound) >= UNLIMITED else bound for bound in band)
    if len(terms) > 1:
        name = work.names["limit"].new(work.source.name("tendon", t), f"tendon_{t}")
        work.mechanism.limits.append(SumLimit(name, terms, lower, upper, law, joint.is_slide))
    else:
        ends = [None if bound is None else bound / factor for bound in (lower, upper)]
        (joint.lower, joint.upper), joint.stop = ends if factor > 0.0 else ends[::-1], law
    work.report.changed(label, f"{text}: it is a pair of limits with an elastic law")


def _is_chain(work: Projection, joints: list[int]) -> bool:
    """Whether the bodies of joints carry each other in a row."""
    owners = sorted(int(work.model.jnt_bodyid[j]) for j in joints)
    return all(is_below(work.model, upper, lower) for lower, upper in itertools.pairwise(owners))


def _add_spatial_tendon(work: Projection, t: int, label: str) -> None:
    name = work.source.name("tendon", t)
    stiffness, damping, low, high = _springs_of_tendon(work, t)
    if extra(work.model, "tendon_armature", t).any():
        work.report.lost(label, "its armature")
    branches = _branches(work, t, label)
    moving = [(divisor, path) for divisor, path in branches if len({element.body for element in path}) > 1]
    if not moving:
        work.report.lost(label, "all its points are on one body, so that its length is constant")
        work.ranges.discard(t)
        return
    _report_heights(work, t, label)
    divisor, path = moving[0]
    if len(branches) == 1 and len(path) == 2 and divisor == 1.0 and (stiffness or damping) and (high == low or not stiffness):
        bodies, points = (path[0].body, path[1].body), (path[0].at, path[1].at)
        spring = Spring(
            work.names["spring"].new(name, f"tendon_{t}"),
            stiffness,
            damping,
            low if stiffness else 0.0,
            bodies=bodies,
            points=points,
            is_linear=True,
        )
        spring.comment = f"spatial tendon {name}, which also pushes"
        work.mechanism.springs.append(spring)
        return
    if len(moving) > 1 and (stiffness or damping):
        work.report.lost(label, "its stiffness and damping: its branches share one stretch, but the cables of a scene do not")
        stiffness = damping = 0.0
    if stiffness and low > 0.0:
        work.report.lost(label, f"its spring also pushes below {low:.6g} m; a cable is slack")
    if damping and not stiffness:
        work.report.lost(label, "its damping without a stiffness; a cable has a damper with its spring only")
        damping = 0.0
    for number, (divisor, path) in enumerate(moving, 1):
        own = work.names["tendon"].new(f"{name}_{number}" if len(moving) > 1 and name else name, f"tendon_{t}")
        comment = f"spatial tendon {name}" + (f", branch {number}, tension over {divisor:g}" if divisor != 1.0 else "")
        tendon = Tendon(own, path, stiffness / divisor**2, damping / divisor**2, divisor * high if stiffness else 0.0, comment)
        work.mechanism.tendons.append(tendon)
        work.cables.setdefault(t, []).append((own, divisor))


def _report_heights(work: Projection, t: int, label: str) -> None:
    model, wraps = work.model, range(int(work.model.tendon_adr[t]), int(work.model.tendon_adr[t] + work.model.tendon_num[t]))
    sites = [model.wrap_objid[k] for k in wraps if model.wrap_type[k] == load_mujoco().mjtWrap.mjWRAP_SITE]
    spread = float(numpy.ptp([work.plane.height(work.zero.site_xpos[site]) for site in sites]))
    if spread > 1e-4:
        text = f"its sites are up to {1e3 * spread:.3g} mm apart along the normal; the scene has the length in the plane"
        work.report.changed(label, text)


def _branches(work: Projection, t: int, label: str) -> list[tuple[float, list[Element]]]:
    """Paths of the branches of a spatial tendon, with the divisors of their tension."""
    mujoco, model, data = load_mujoco(), work.model, work.zero
    first, count = int(model.tendon_adr[t]), int(model.tendon_num[t])
    needs_length = _needs_length(work, t)
    branches: list[tuple[float, list[Element]]] = [(1.0, [])]
    for k in range(first, first + count):
        kind, index = mujoco.mjtWrap(model.wrap_type[k]), int(model.wrap_objid[k])
        if kind == mujoco.mjtWrap.mjWRAP_PULLEY:
            branches.append((float(model.wrap_prm[k]), []))
        elif kind == mujoco.mjtWrap.mjWRAP_SITE:
            group = int(work.group[model.site_bodyid[index]])
            branches[-1][1].append(Element(work.name_of(group), work.local(group, data.site_xpos[index])))
        else:
            sites = [int(model.wrap_objid[k - 1]), int(model.wrap_objid[k + 1])]
            pulley = _pulley(work, index, sites, int(model.wrap_prm[k]), label, needs_length)
            if pulley is not None:
                branches[-1][1].append(pulley)
    return [(divisor, path) for divisor, path in branches if len(path) > 1]


def _needs_length(work: Projection, t: int) -> bool:
    """Whether forces depend on the length of a tendon: those of its spring, its range, or a servo."""
    mujoco, model = load_mujoco(), work.model
    servos = [
        k
        for k in range(model.nu)
        if model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_TENDON and model.actuator_trnid[k, 0] == t and model.actuator_biasprm[k, 1] != 0.0
    ]
    return bool(t in work.ranges or servos or _springs_of_tendon(work, t)[0] != 0.0)


def _pulley(work: Projection, geom: int, sites: list[int], side: int, label: str, needs_length: bool) -> Element | None:
    """The pulley of a cylinder or sphere between two sites; None if the cable does not pass it, or if it only adds a constant
    to a length that does not matter.
    """
    model, plane, data = work.model, work.plane, work.zero
    group = int(work.group[model.geom_bodyid[geom]])
    groups = [int(work.group[model.site_bodyid[site]]) for site in sites]
    name = work.source.name("geom", geom) or str(geom)
    if groups == [group, group] and not needs_length:
        return None
    axis = data.geom_xmat[geom].reshape(3, 3)[:, 2]
    if model.geom_type[geom] == load_mujoco().mjtGeom.mjGEOM_CYLINDER and abs(axis @ plane.n) < numpy.cos(numpy.radians(1.0)):
        work.report.lost(label, f"the cylinder {name}: its axis is not perpendicular to the plane; the cable passes straight")
        return None
    radius, center = float(model.geom_size[geom, 0]), plane.point(data.geom_xpos[geom])
    ends = [plane.point(data.site_xpos[site]) for site in sites]
    travel = ends[1] - ends[0]
    if side >= 0:
        away = plane.point(data.site_xpos[side]) - center
        if numpy.linalg.norm(away) < radius:
            work.report.lost(label, f"the pulley {name}: the cable passes inside of it; the cable passes straight")
            return None
        is_left = travel[0] * away[1] - travel[1] * away[0] < 0.0
    else:
        away = center - ends[0]
        is_left = travel[0] * away[1] - travel[1] * away[0] > 0.0
    turn: Literal["cw", "ccw"] = "ccw" if is_left else "cw"
    return Element(work.name_of(group), work.local(group, data.geom_xpos[geom]), radius, turn)


def add_actuators(work: Projection) -> None:
    """Adds actuators with the control signals of the start."""
    mujoco, model = load_mujoco(), work.model
    if work.is_disabled("ACTUATION") and model.nu:
        work.report.lost("actuators", "the option of the model disables them")
    for k in range(0 if work.is_disabled("ACTUATION") else model.nu):
        label, kind = work.source.label("actuator", k), mujoco.mjtTrn(model.actuator_trntype[k])
        target = int(model.actuator_trnid[k, 0])
        if model.actuator_group[k] in range(31) and model.opt.disableactuator >> int(model.actuator_group[k]) & 1:
            work.report.lost(label, "the option of the model disables its group")
            continue
        if not _is_affine(work, k):
            what = mujoco.mjtGain(model.actuator_gaintype[k]).name, mujoco.mjtBias(model.actuator_biastype[k]).name
            work.report.lost(label, f"{' and '.join(what)} have no equivalent; it exerts no force")
            continue
        _report_dynamics(work, k, label)
        gear = float(model.actuator_gear[k, 0])
        if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
            terms: Terms | None = [(work.joints[target].name, 1.0)] if target in work.joints else None
        elif kind == mujoco.mjtTrn.mjTRN_TENDON and target in work.cables:
            _add_pull(work, k, label, gear)
            continue
        elif kind == mujoco.mjtTrn.mjTRN_TENDON:
            terms = work.sum_of_tendon(target) or None
        else:
            terms = None
        if terms is None:
            work.report.lost(
                label,
                f"its transmission {kind.name.removeprefix('mjTRN_').lower()} does not act on joints of the scene; it exerts no force",
            )
            continue
        _add_drive(work, k, label, gear, terms)
    _add_ranges_of_cables(work)
    _drop_idle_cables(work)


def _add_ranges_of_cables(work: Projection) -> None:
    """A cable that is taut at the upper end of its range."""
    model, pulled = work.model, {actuator.tendon for actuator in work.mechanism.actuators}
    tendons = {tendon.name: tendon for tendon in work.mechanism.tendons}
    for t in sorted(work.ranges):
        label, (low, high) = work.source.label("tendon", t), (float(bound) for bound in model.tendon_range[t])
        cables = work.cables.get(t, [])
        if len(cables) != 1:
            work.report.lost(label, f"its range of {low:.6g} to {high:.6g}; nothing stops it at these lengths")
            continue
        if low > 0.0:
            work.report.lost(label, f"the lower end of its range, {low:.6g} m: a cable does not push")
        if high >= UNLIMITED:
            continue
        (name, divisor), tendon = cables[0], tendons[cables[0][0]]
        if tendon.stiffness or name in pulled:
            tendon = replace(tendon, name=work.names["tendon"].new(f"{name}_range", name))
            work.mechanism.tendons.append(tendon)
        stiffness, damping = taut_cable(work, model.tendon_solref_lim[t], model.tendon_solimp_lim[t], float(model.tendon_invweight0[t]))
        tendon.stiffness, tendon.damping = (float(f"{value / divisor**2:.3g}") for value in (stiffness, damping))
        tendon.rest, tendon.rest_comment, tendon.is_range = divisor * high, "upper end of the range", True
        work.report.changed(label, f"the upper end of its range, {high:.6g} m, is the free length of a cable, with MuJoCo's static stretch at 1 N")


def _drop_idle_cables(work: Projection) -> None:
    """Removes cables that nothing tensions, such as those that only measure a length."""
    pulled = {actuator.tendon for actuator in work.mechanism.actuators}
    for tendon in list(work.mechanism.tendons):
        if tendon.name not in pulled and not tendon.stiffness:
            work.report.lost(f"tendon {tendon.name}", "it has neither a stiffness nor an actuator that the scene has, and would never pull")
            work.mechanism.tendons.remove(tendon)


def _is_affine(work: Projection, k: int) -> bool:
    mujoco, model = load_mujoco(), work.model
    gain, bias = mujoco.mjtGain(model.actuator_gaintype[k]), mujoco.mjtBias(model.actuator_biastype[k])
    return gain == mujoco.mjtGain.mjGAIN_FIXED and bias in (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)


def _report_dynamics(work: Projection, k: int, label: str) -> None:
    mujoco, model = load_mujoco(), work.model
    if model.actuator_dyntype[k] == mujoco.mjtDyn.mjDYN_INTEGRATOR:
        work.report.lost(label, "its activation integrates the control signal; in the scene it keeps its value of the start")
    elif model.actuator_dyntype[k] != mujoco.mjtDyn.mjDYN_NONE:
        kind = mujoco.mjtDyn(model.actuator_dyntype[k]).name.removeprefix("mjDYN_").lower()
        work.report.lost(label, f"its activation dynamics ({kind}, {model.actuator_dynprm[k, 0]:.4g} s); its command acts at once")
    for name in ("damping", "armature", "delay"):
        value = float(extra(model, f"actuator_{name}", k)[0])
        if value != 0.0:
            work.report.lost(label, f"its {name} of {value:.4g}")


def _control(work: Projection, k: int) -> tuple[float, float, float, float]:
    """Constant force, and factors of length and rate, at the control signal of the start; and the signal."""
    mujoco, model = load_mujoco(), work.model
    signal = float(work.start.ctrl[k])
    if model.actuator_dyntype[k] == mujoco.mjtDyn.mjDYN_INTEGRATOR:
        signal = float(work.start.act[model.actuator_actadr[k]])
    elif model.actuator_ctrllimited[k] and not work.is_disabled("CLAMPCTRL"):
        low, high = (float(bound) for bound in model.actuator_ctrlrange[k])
        if not low <= signal <= high:
            text = f"its control signal of {signal:g} is outside of its ctrlrange of {low:g} to {high:g}, and is {min(max(signal, low), high):g} in the scene"
            work.report.changed(work.source.label("actuator", k), text)
        signal = min(max(signal, low), high)
    bias = numpy.zeros(3)
    if model.actuator_biastype[k] == mujoco.mjtBias.mjBIAS_AFFINE:
        bias = model.actuator_biasprm[k, :3]
    return float(model.actuator_gainprm[k, 0]) * signal + float(bias[0]), float(bias[1]), float(bias[2]), signal


def _add_drive(work: Projection, k: int, label: str, gear: float, terms: Terms) -> None:
    model = work.model
    constant, by_length, by_rate, signal = _control(work, k)
    joints = {joint.name: joint for joint in work.mechanism.joints}
    name = work.source.name("actuator", k)
    drive = Actuator(work.names["actuator"].new(name, f"actuator_{k}"), terms, is_linear=joints[terms[0][0]].is_slide)
    bounds: tuple[float, float] | None = None
    if model.actuator_forcelimited[k]:
        bounds = float(model.actuator_forcerange[k, 0]), float(model.actuator_forcerange[k, 1])
    limits = [] if bounds is None else [(max(abs(bound) for bound in bounds) * abs(gear), f"forcerange {bounds[0]:g} to {bounds[1]:g}")]
    target = int(model.actuator_trnid[k, 0])
    if model.actuator_trntype[k] == load_mujoco().mjtTrn.mjTRN_TENDON and model.tendon_actfrclimited[target]:
        low, high = model.tendon_actfrcrange[target]
        limits.append((max(abs(low), abs(high)), f"actuatorfrcrange {low:g} to {high:g} of the tendon"))
    if len(terms) == 1:
        j = next(j for j, joint in work.joints.items() if joint.name == terms[0][0])
        if model.jnt_actfrclimited[j]:
            low, high = model.jnt_actfrcrange[j]
            limits.append((max(abs(low), abs(high)) / abs(terms[0][1]), f"actuatorfrcrange {low:g} to {high:g} of the joint"))
    elif any(model.jnt_actfrclimited[j] for j, joint in work.joints.items() if joint.name in dict(terms)):
        work.report.lost(label, "the actuatorfrcrange of its joints")
    geared = f", gear {gear:g}" if gear != 1.0 else ""
    if by_length == by_rate == 0.0:
        force = constant if bounds is None else min(max(constant, bounds[0]), bounds[1])
        drive.effort = gear * force
        if limits and min(limits)[0] < abs(drive.effort):
            drive.effort = float(numpy.sign(drive.effort)) * min(limits)[0]
        drive.comments["effort"] = f"ctrl {signal:g}{geared}"
    elif by_length > 0.0 or by_rate > 0.0 or gear == 0.0:
        work.report.lost(label, "its bias grows with the length or the rate, which no servo does; it exerts no force")
        return
    else:
        drive.kp, drive.kd = -by_length * gear**2 + 0.0, -by_rate * gear**2 + 0.0
        if by_length < 0.0:
            drive.target = constant / (-by_length * gear) + 0.0
            drive.comments["target"] = f"ctrl {signal:g}{geared}" + ("; 0 holds the zero position" if signal == 0.0 else "")
            _warn_about_range(work, k, label, drive)
        else:
            drive.rate = constant / (-by_rate * gear) + 0.0
            drive.comments["target"] = f"ctrl {signal:g}{geared}: a rate of {drive.rate:g}"
        drive.comments["kp"] = "biasprm" + (" and gear" if geared else "")
        if limits:
            drive.limit, drive.comments["limit"] = min(limits)
        if bounds is not None and abs(bounds[0] + bounds[1]) > 1e-9 * max(abs(bounds[0]), abs(bounds[1])):
            work.report.changed(label, f"its force of {bounds[0]:g} to {bounds[1]:g} has one bound for both directions in the scene, the larger one")
    _add_commands(work, k, drive)
    work.mechanism.actuators.append(drive)


def _add_commands(work: Projection, k: int, drive: Actuator) -> None:
    """Commands over time, which `phalanx scene export` writes as the numbers NAME.times and NAME.commands."""
    model, name = work.model, work.source.name("actuator", k)
    numbers = {}
    for n in range(model.nnumeric):
        first, size = model.numeric_adr[n], model.numeric_size[n]
        numbers[work.source.name("numeric", n)] = model.numeric_data[first : first + size]
    times, commands = numbers.get(f"{name}.times"), numbers.get(f"{name}.commands")
    if times is None or commands is None or len(times) != len(commands) or (drive.effort is None and not drive.kp):
        return
    gain, gear = float(model.actuator_gainprm[k, 0]), float(model.actuator_gear[k, 0])
    scale = gear * gain if drive.effort is not None else gain / (-float(model.actuator_biasprm[k, 1]) * gear)
    values = scale * commands
    # The command of a servo contains kd/kp times the rate of its target, which is constant between two nodes.
    lead = drive.kd / drive.kp if drive.effort is None else 0.0
    spans = numpy.diff(times)
    slopes = numpy.divide(numpy.diff(values), spans, out=numpy.zeros(len(spans)), where=spans > _STEP_S)
    for n, time in enumerate(times):
        before = lead * slopes[n - 1] if n > 0 and spans[n - 1] > _STEP_S else None
        after = lead * slopes[n] if n < len(spans) and spans[n] > _STEP_S else None
        value = float(values[n] - ((before or 0.0) if after is None else after))
        if drive.times and time - drive.times[-1] <= _STEP_S:
            if abs(value - drive.values[-1]) <= 1e-9 * max(abs(value), abs(drive.values[-1])):
                continue
            drive.times[-1] = float(time) - 2.0 * _STEP_S
        drive.times.append(float(time))
        drive.values.append(value)
    drive.comments["times"] = f"numbers {name}.times and {name}.commands"


def _warn_about_range(work: Projection, k: int, label: str, drive: Actuator) -> None:
    """Warns about targets of a hinge beyond two turns, which are degrees."""
    largest = max(abs(float(bound)) for bound in work.model.actuator_ctrlrange[k])
    if len(drive.terms) != 1 or drive.is_linear or not work.model.actuator_ctrllimited[k]:
        return
    scale = abs(float(work.model.actuator_gainprm[k, 0]) / (float(work.model.actuator_biasprm[k, 1]) * float(work.model.actuator_gear[k, 0])))
    if largest * scale > 4.0 * numpy.pi:
        work.report.warn(
            label,
            f"its ctrlrange ends at {largest:g}, a target of {largest * scale:.4g} rad: MuJoCo does not convert ctrlrange from degrees",
        )


def _add_pull(work: Projection, k: int, label: str, gear: float) -> None:
    """An actuator that pulls a cable; behind a pulley its tension is divided."""
    constant, by_length, by_rate, signal = _control(work, k)
    if by_length != 0.0 or by_rate != 0.0:
        _add_length_servo(work, k, label, gear)
        return
    if work.model.actuator_forcelimited[k]:
        constant = min(max(constant, float(work.model.actuator_forcerange[k, 0])), float(work.model.actuator_forcerange[k, 1]))
    tension = -gear * constant + 0.0
    if tension < 0.0:
        work.report.lost(label, f"at ctrl {signal:g} it pushes with {-tension:.4g} N; a cable cannot push")
        tension = 0.0
    name, cables = work.source.name("actuator", k), work.cables[int(work.model.actuator_trnid[k, 0])]
    for number, (cable, divisor) in enumerate(cables, 1):
        own = work.names["actuator"].new(f"{name}_{number}" if len(cables) > 1 and name else name, f"actuator_{k}")
        comment = f"ctrl {signal:g}, gear {gear:g}" + (f", divisor {divisor:g}" if divisor != 1.0 else "")
        work.mechanism.actuators.append(Actuator(own, tendon=cable, effort=tension / divisor, comments={"effort": comment}))


def _add_length_servo(work: Projection, k: int, label: str, gear: float) -> None:
    """A servo of the length of a cable, which is a spring and a damper of the cable."""
    constant, by_length, by_rate, signal = _control(work, k)
    cables = work.cables[int(work.model.actuator_trnid[k, 0])]
    tendons = {tendon.name: tendon for tendon in work.mechanism.tendons}
    (name, divisor), tendon = cables[0], tendons[cables[0][0]]
    if len(cables) > 1 or by_length >= 0.0 or by_rate > 0.0 or gear == 0.0 or tendon.stiffness:
        text = "a servo of the length of a cable with branches or a spring, or of its rate alone, has no equivalent; the cable is not pulled"
        work.report.lost(label, text)
        return
    tendon.stiffness, tendon.damping = -by_length * (gear / divisor) ** 2, -by_rate * (gear / divisor) ** 2
    tendon.rest = divisor * constant / (-by_length * gear) + 0.0
    tendon.comment += f", pulled by the servo {work.source.name('actuator', k) or k}"
    tendon.rest_comment = f"target at ctrl {signal:g}"
    if work.model.actuator_forcelimited[k]:
        low, high = work.model.actuator_forcerange[k]
        work.report.lost(label, f"its forcerange of {low:g} to {high:g}; the tension of the cable has no limit")
    work.report.changed(label, f"a servo of the length of a cable is the spring of {name}, which does not push below {tendon.rest:.6g} m")
