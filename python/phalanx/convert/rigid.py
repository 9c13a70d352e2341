"""The planar copy of a model in MuJoCo with rigid constraints, as a reference for the motion of a scene."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy

from .._phalanx import Scene, run
from .planar import Mechanism
from .plane import Plane
from .read import Numbers, Source, load_mujoco
from .write import scene_text

# Settings of constraints that are as rigid as a time step of 10 µs allows.
STEP_S = 1e-5
_SOLREF = (2.5e-5, 1.0)
_IMPEDANCE = 0.9999
_SAMPLE_S = 1e-3


def planarised(source: Source, plane: Plane) -> Any:
    """A copy of a model whose axes and loops lie exactly in the plane.

    Rounded axes and anchors leave a part of each `connect` along the normal, which a rigid constraint turns into forces
    of meganewtons.
    """
    mujoco, model, data = load_mujoco(), copy.copy(source.model), source.zero
    for j in range(model.njnt):
        kind, frame = model.jnt_type[j], data.xmat[model.jnt_bodyid[j]].reshape(3, 3)
        if kind == mujoco.mjtJoint.mjJNT_HINGE:
            model.jnt_axis[j] = frame.T @ (plane.n * numpy.sign(data.xaxis[j] @ plane.n))
        elif kind == mujoco.mjtJoint.mjJNT_SLIDE:
            axis = data.xaxis[j] - (data.xaxis[j] @ plane.n) * plane.n
            model.jnt_axis[j] = frame.T @ (axis / numpy.linalg.norm(axis))
    for k in range(model.neq):
        if model.eq_type[k] != mujoco.mjtEq.mjEQ_CONNECT:
            continue
        first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        if model.eq_objtype[k] == mujoco.mjtObj.mjOBJ_SITE:
            shift = plane.height(data.site_xpos[first]) - plane.height(data.site_xpos[second])
            frame = data.xmat[model.site_bodyid[second]].reshape(3, 3)
            model.site_pos[second] += shift * (frame.T @ plane.n)
        else:
            frames = [data.xmat[body].reshape(3, 3) for body in (first, second)]
            places = [
                data.xpos[body] + frame @ model.eq_data[k, 3 * side : 3 * side + 3]
                for side, (body, frame) in enumerate(zip((first, second), frames, strict=True))
            ]
            shift = plane.height(places[0]) - plane.height(places[1])
            model.eq_data[k, 3:6] += shift * (frames[1].T @ plane.n)
    return model


def rigid(source: Source, plane: Plane) -> Any:
    """The planar copy with rigid equalities, for steps of 10 µs with RK4."""
    mujoco, model = load_mujoco(), planarised(source, plane)
    model.opt.timestep, model.opt.integrator = STEP_S, mujoco.mjtIntegrator.mjINT_RK4
    model.eq_solref[:] = _SOLREF
    model.eq_solimp[:, :2] = _IMPEDANCE
    model.opt.tolerance, model.opt.iterations = 1e-14, 200
    return model


def free_motion(source: Source, plane: Plane, mechanism: Mechanism, duration_s: float, model: Any = None) -> dict[str, float]:
    """Largest differences of the joint coordinates of a scene and of a MuJoCo model, by joint, without contacts, limits and
    friction. The model is the rigid copy by default.
    """
    mujoco = load_mujoco()
    model = copy.copy(model) if model is not None else rigid(source, plane)
    for name in ("CONTACT", "LIMIT", "FRICTIONLOSS"):
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))
    data = mujoco.MjData(model)
    for name in ("qpos", "qvel", "ctrl", "act"):
        getattr(data, name)[:] = getattr(source.start, name)
    stride, times, positions = max(1, round(_SAMPLE_S / model.opt.timestep)), [0.0], [data.qpos.copy()]
    for _ in range(round(duration_s / (stride * model.opt.timestep))):
        mujoco.mj_step(model, data, nstep=stride)
        times.append(float(data.time))
        positions.append(data.qpos.copy())
    # Limits that are springs with a dead band act in free motion too.
    springs = [law for law in mechanism.laws if law.is_spring]
    names = {law.name for law in springs}
    without = [joint if joint.stop in names else replace(joint, lower=None, upper=None, stop="") for joint in mechanism.joints]
    joints = [replace(joint, friction=0.0) for joint in without]
    limits = [limit for limit in mechanism.limits if limit.stop in names]
    actuators = [replace(actuator, times=[], values=[]) for actuator in mechanism.actuators]
    free = replace(mechanism, joints=joints, actuators=actuators, contacts=[], laws=springs, limits=limits)
    free.tendons = [tendon for tendon in mechanism.tendons if not tendon.is_range]
    scene = Scene.from_toml(scene_text(free, [], max(duration_s, times[-1])), "free.toml")
    result = run(scene, preset="reference", numeric_rate=1.0 / _SAMPLE_S)
    found: Numbers = numpy.array(positions)
    differences = {}
    for joint in joints:
        column = f"{joint.name}_position_m" if joint.is_slide else f"{joint.name}_rad"
        if joint.index >= 0:
            exact = found[:, model.jnt_qposadr[joint.index]]
            differences[joint.name] = float(numpy.abs(numpy.interp(times, result.time, result[column]) - exact).max())
    return differences
