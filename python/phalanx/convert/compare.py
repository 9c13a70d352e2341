"""A model as MuJoCo simulates it, beside the rigid mechanism with exact loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy

from .._phalanx import Result, run
from ..errors import RunError, SceneError
from .conversion import CUBE_KG, DURATION_S, Conversion, from_mjcf
from .read import Source, load_mujoco
from .rigid import free_motion

# Interval of the samples of both simulations, s.
_SAMPLE_S = 1e-3
# The creep of the object, and whether it is held, are measured over this last part of the run.
_LAST_PART = 0.2
# An object that moves less over that part is held, if two outlines of the hand press on it, m.
_HELD_M = 1e-3
# Duration of the free motion, s.
_FREE_S = 0.05


@dataclass
class Side:
    """What a simulation gives; lengths in m, angles in rad, forces in N. None where there is no object, or the run failed."""

    openings: dict[str, float] = field(default_factory=dict)
    """Largest violation of each loop and coupling."""
    penetration: dict[str, float] = field(default_factory=dict)
    """Largest depth of each pair of outlines."""
    final_penetration: dict[str, float] = field(default_factory=dict)
    """Largest depth at the end."""
    first_touch: dict[str, float] = field(default_factory=dict)
    """Time of the first contact of each pair, s."""
    presses: dict[str, float] = field(default_factory=dict)
    """Normal force of each pair at the end."""
    creep: float | None = None
    """Mean speed of the object over the last fifth of the run, m/s."""
    held: bool | None = None
    reason: str = ""
    """Why it is held or not, or why the run failed."""


@dataclass
class Comparison:
    """Results of `phalanx.compare_mujoco`; its text is one page."""

    title: str
    mujoco: Side
    phalanx: Side
    joints: dict[str, float]
    """Largest difference of each joint coordinate, rad or m."""
    joints_before: dict[str, float]
    """The same before the first contact with the object."""
    free_motion: dict[str, float]
    """Largest differences in free motion over 50 ms, without contacts, limits and friction, from the model as published
    ("published") and from its planar copy with rigid equalities ("rigid").
    """

    def __str__(self) -> str:
        both = (self.mujoco, self.phalanx)
        loops = sorted(self.mujoco.openings, key=lambda name: -self.mujoco.openings[name])
        rows = [[f"opening of {name}, largest", f"{self.mujoco.openings[name]:.2g}", "exact"] for name in loops]
        pairs = sorted({pair for side in both for pair in side.first_touch})
        rows += [[f"first touch of {pair}", *(_time(side.first_touch.get(pair)) for side in both)] for pair in pairs]
        rows += [[f"depth of {pair}, largest", *(_depth(side.penetration.get(pair)) for side in both)] for pair in pairs]
        rows += [[f"depth of {pair}, at the end", *(_depth(side.final_penetration.get(pair)) for side in both)] for pair in pairs]
        rows += [[f"force of {pair}, at the end", *(_force(side.presses.get(pair)) for side in both)] for pair in pairs]
        if self.mujoco.creep is not None or self.phalanx.creep is not None:
            rows.append(["creep of the object", *(_speed(side.creep) for side in both)])
            rows.append(["held at the end", *(_verdict(side.held) for side in both)])
        width = max([len(name) for name, _, _ in rows], default=0)
        lines = [self.title, "", f"{'':{width}}  {'MuJoCo':>12}  {'phalanx':>12}"]
        lines += [f"{name:{width}}  {first:>12}  {second:>12}" for name, first, second in rows]
        lines += ["", *(f"{name}: {side.reason}" for name, side in (("MuJoCo", self.mujoco), ("phalanx", self.phalanx)) if side.reason)]
        if self.joints:
            worst = max(self.joints, key=lambda name: self.joints[name])
            before = max(self.joints_before.values(), default=0.0)
            found = f"largest difference of a joint coordinate: {self.joints[worst]:.2g} of {worst}"
            touches = any(side.first_touch for side in both)
            lines.append(f"{found}{f'; before the first contact with the object {before:.2g}' if touches else ''} (rad or m)")
        if self.free_motion:
            published, exact = (self.free_motion[name] for name in ("published", "rigid"))
            lines.append(f"free motion over 50 ms: MuJoCo differs by {published:.2g} as published, and by {exact:.2g} with rigid equalities and RK4")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        text = str(self).replace("&", "&amp;").replace("<", "&lt;")
        return f"<pre>{text}</pre>"


def _time(value: float | None) -> str:
    return "never" if value is None else f"{1e3 * value:.4g} ms"


def _depth(value: float | None) -> str:
    return "–" if value is None else (f"{1e6 * value:.3g} µm" if value < 1e-3 else f"{1e3 * value:.3g} mm")


def _force(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g} N"


def _speed(value: float | None) -> str:
    if value is None:
        return "–"
    if value < 1e-9:
        return "< 0.001 µm/s"
    return f"{1e6 * value:.2g} µm/s" if value < 1e-4 else f"{1e3 * value:.2g} mm/s"


def _verdict(value: bool | None) -> str:
    return "–" if value is None else ("yes" if value else "no")


def compare(conversion: Conversion, duration_s: float) -> Comparison:
    """Simulates a converted model with MuJoCo, as published, and with phalanx."""
    source = conversion.source
    published, times, positions = _published(conversion, duration_s)
    side, result = _phalanx(conversion, duration_s)
    opt = source.model.opt
    integrator = load_mujoco().mjtIntegrator(opt.integrator).name.removeprefix("mjINT_").lower()
    settings = f"MuJoCo {load_mujoco().__version__} as published ({integrator}, {1e3 * opt.timestep:g} ms)"
    title = f"{source.path.name}, {1e3 * duration_s:g} ms: {settings} beside phalanx, with exact loops"
    joints, before = _differences(conversion, result, times, positions, [*published.first_touch.values(), *side.first_touch.values()])
    return Comparison(title, published, side, joints, before, _free_motion(conversion))


def _free_motion(conversion: Conversion) -> dict[str, float]:
    """Differences of the models in free motion; empty where the scene cannot be simulated without its stops."""
    source, plane, mechanism = conversion.source, conversion.plane, conversion.mechanism
    try:
        found = {name: free_motion(source, plane, mechanism, _FREE_S, model) for name, model in (("published", source.model), ("rigid", None))}
    except (RunError, SceneError):
        return {}
    return {name: max(differences.values(), default=0.0) for name, differences in found.items()}


def _object(conversion: Conversion) -> str | None:
    names = [body.name for body in conversion.mechanism.bodies if body.is_free]
    return "object" if "object" in names else (names[0] if names else None)


def _published(conversion: Conversion, duration_s: float) -> tuple[Side, list[float], list[Any]]:
    mujoco, source, mechanism = load_mujoco(), conversion.source, conversion.mechanism
    model, data = source.model, mujoco.MjData(source.model)
    for name in ("qpos", "qvel", "ctrl", "act"):
        getattr(data, name)[:] = getattr(source.start, name)
    mujoco.mj_forward(model, data)
    side, target = Side(), _object(conversion)
    names = {outline.geom: f"{body.name}.{outline.name}" for body in mechanism.bodies for outline in body.outlines}
    names |= {outline.geom: f"ground.{outline.name}" for outline in mechanism.ground}
    own = next((body for body in mechanism.bodies if body.name == target), None)
    geoms = {outline.geom for outline in own.outlines} if own else set()
    body = int(model.geom_bodyid[next(iter(geoms))]) if geoms else -1
    times, positions, places = [0.0], [data.qpos.copy()], [data.xpos[body].copy()]
    stride, force = max(1, round(_SAMPLE_S / model.opt.timestep)), numpy.zeros(6)
    for step in range(1, round(duration_s / model.opt.timestep) + 1):
        mujoco.mj_step(model, data)
        _record_openings(source, data, side)
        side.presses, side.final_penetration = {}, {}
        for index in range(data.ncon):
            contact = data.contact[index]
            pair = [int(geom) for geom in contact.geom]
            if not geoms & set(pair) or not all(geom in names for geom in pair) or contact.exclude:
                continue
            name = _pair_name(names[pair[0]], names[pair[1]], target or "")
            side.first_touch.setdefault(name, float(data.time))
            side.penetration[name] = max(side.penetration.get(name, 0.0), -float(contact.dist))
            side.final_penetration[name] = max(side.final_penetration.get(name, 0.0), -float(contact.dist))
            mujoco.mj_contactForce(model, data, index, force)
            side.presses[name] = side.presses.get(name, 0.0) + float(force[0])
        if step % stride == 0:
            times.append(float(data.time))
            positions.append(data.qpos.copy())
            places.append(data.xpos[body].copy())
    if not numpy.isfinite(data.qpos).all() or data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
        side.reason = "the simulation became unstable"
    elif body >= 0:
        first = int((1.0 - _LAST_PART) * len(times))
        moved = float(numpy.linalg.norm(places[-1] - places[first]))
        side.creep = moved / (times[-1] - times[first])
        pressing = [name for name, value in side.presses.items() if value > 0.0]
        side.held = len(pressing) >= 2 and moved < _HELD_M
        side.reason = f"{len(pressing)} pairs press; the object moves by {1e3 * moved:.2g} mm in the last fifth of the run"
    return side, times, positions


def _pair_name(first: str, second: str, target: str) -> str:
    """Name of a pair with the object last."""
    return f"{second}/{first}" if first.partition(".")[0] == target else f"{first}/{second}"


def _record_openings(source: Source, data: Any, side: Side) -> None:
    """Largest violations of all active equalities: distances of anchors, and sums of joints."""
    mujoco, model = load_mujoco(), source.model
    rows: dict[int, list[float]] = {}
    for row in range(data.ne):
        rows.setdefault(int(data.efc_id[row]), []).append(float(data.efc_pos[row]))
    for equality, values in rows.items():
        kind = mujoco.mjtEq(model.eq_type[equality])
        label = f"{kind.name.removeprefix('mjEQ_').lower()} {source.name('equality', equality) or equality}"
        name = f"{label}, {'rad' if _is_of_hinges(model, equality, kind) else 'm'}"
        side.openings[name] = max(side.openings.get(name, 0.0), float(numpy.linalg.norm(values)))


def _is_of_hinges(model: Any, equality: int, kind: Any) -> bool:
    """Whether an equality couples angles."""
    mujoco, index = load_mujoco(), int(model.eq_obj1id[equality])
    if kind == mujoco.mjtEq.mjEQ_TENDON:
        first = int(model.tendon_adr[index])
        if model.wrap_type[first] != mujoco.mjtWrap.mjWRAP_JOINT:
            return False
        index = int(model.wrap_objid[first])
    elif kind != mujoco.mjtEq.mjEQ_JOINT:
        return False
    return bool(model.jnt_type[index] == mujoco.mjtJoint.mjJNT_HINGE)


def _phalanx(conversion: Conversion, duration_s: float) -> tuple[Side, Result | None]:
    side, result = Side(), None
    try:
        result = run(conversion.scene, duration=duration_s, numeric_rate=1.0 / _SAMPLE_S)
    except RunError as error:
        result, side.reason = error.result, f"the run ended: {error}"
    if result is None:
        return side, None
    target = _object(conversion)
    for name, contact in result.contacts.items():
        pair = _pair_of_points(name, target)
        if pair is None or contact.get("first_s") is None:
            continue
        first = contact["first_s"]
        assert first is not None
        side.first_touch[pair] = min(side.first_touch.get(pair, numpy.inf), first)
        side.penetration[pair] = max(side.penetration.get(pair, 0.0), contact["max_penetration_m"])
        side.final_penetration[pair] = max(side.final_penetration.get(pair, 0.0), -float(result[f"{name}_gap_m"][-1]))
        side.presses[pair] = side.presses.get(pair, 0.0) + contact["final_normal_n"]
    if target is not None and not side.reason:
        x, y = result[f"{target}_x_m"], result[f"{target}_y_m"]
        since = float(result.time[-1]) * (1.0 - _LAST_PART)
        before = (numpy.interp(since, result.time, x), numpy.interp(since, result.time, y))
        side.creep = float(numpy.hypot(x[-1] - before[0], y[-1] - before[1]) / (result.time[-1] - since))
        grasp = (result.criteria or {}).get("grasp")
        if grasp is not None:
            side.held, side.reason = grasp["fate"] == "held", grasp["answer"]
    return side, result


def _pair_of_points(name: str, target: str | None) -> str | None:
    """Pair of the outlines of a contact such as `a.pad[0]/object.skin`; None without the object."""
    first, _, second = name.partition("/")
    outlines = [part.partition("[")[0] for part in (first, second)]
    if target is None or target not in {outline.partition(".")[0] for outline in outlines}:
        return None
    return _pair_name(outlines[0], outlines[1], target)


def _differences(
    conversion: Conversion, result: Result | None, times: list[float], positions: list[Any], touches: list[float]
) -> tuple[dict[str, float], dict[str, float]]:
    """Largest differences of the joint coordinates, in the whole run and before the first contact."""
    if result is None:
        return {}, {}
    model, grid = conversion.source.model, numpy.array(times)
    grid = grid[grid <= result.time[-1]]
    before = grid < min(touches, default=numpy.inf)
    whole, first = {}, {}
    for joint in conversion.mechanism.joints:
        if joint.index < 0:
            continue
        column = f"{joint.name}_position_m" if joint.is_slide else f"{joint.name}_rad"
        found = numpy.array([position[model.jnt_qposadr[joint.index]] for position in positions[: len(grid)]])
        difference = numpy.abs(numpy.interp(grid, result.time, result[column]) - found)
        whole[joint.name] = float(difference.max())
        first[joint.name] = float(difference[before].max(initial=0.0))
    return whole, first


def compare_mujoco(
    model: str | PathLike[str] | Conversion,
    *,
    plane: str | None = None,
    root: str | None = None,
    branch: str | Sequence[str] = (),
    key: str | None = None,
    ctrl: Mapping[str, float] | None = None,
    cube: float | None = None,
    cube_mass: float = CUBE_KG,
    cube_at: tuple[float, float] | None = None,
    duration: float = DURATION_S,
) -> Comparison:
    """Simulates a model (MJCF or URDF) with MuJoCo, as published, and as a rigid mechanism with exact loops.

    `print(phalanx.compare_mujoco("hand.xml", ctrl={"fingers": 255}, cube=0.04))` prints one page: how far loops open, when
    each pad touches the object, how deep it penetrates, how fast the object creeps, and whether it is held. In MuJoCo, an
    object counts as held if two outlines press on it at the end, and it moves by less than 1 mm in the last fifth of the run;
    phalanx judges it by its own criteria. The other arguments are those of `from_mjcf`; a conversion has them already.

    Needs the package mujoco: `pip install "phalanx[mujoco]"`. Raises ConversionError as `from_mjcf` does, and SceneError if
    the scene cannot be simulated.
    """
    if isinstance(model, Conversion):
        return compare(model, duration)
    settings: dict[str, Any] = {"plane": plane, "root": root, "branch": branch, "key": key, "ctrl": ctrl}
    settings |= {"cube": cube, "cube_mass": cube_mass, "cube_at": cube_at}
    return compare(from_mjcf(model, **settings, duration=duration), duration)
