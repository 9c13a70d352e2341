"""Reading of MJCF and URDF files with MuJoCo."""

from __future__ import annotations

import contextlib
import warnings
import xml.etree.ElementTree as Tree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy
import numpy.typing

from ..errors import ConversionError
from .report import Report

Numbers = numpy.typing.NDArray[numpy.float64]

# Formats of meshes that MuJoCo reads.
_MESH_SUFFIXES = {".stl", ".obj", ".msh"}


def load_mujoco() -> Any:
    """Returns the module `mujoco`; raises ImportError with the command that installs it."""
    try:
        import mujoco
    except ImportError:
        message = 'reading MuJoCo and URDF models needs the package mujoco: pip install "phalanx[mujoco]"'
        raise ImportError(message) from None
    return mujoco


def extra(model: Any, name: str, index: int) -> Numbers:
    """Values of a field that older versions of MuJoCo do not have; 0 there."""
    values = getattr(model, name, None)
    return numpy.zeros(1) if values is None or index >= len(values) else numpy.ravel(values[index])


@dataclass
class Source:
    """A compiled model, its zero position, and its start."""

    path: Path
    spec: Any
    """The `mujoco.MjSpec` of the compiled model."""
    model: Any
    zero: Any
    """The `mujoco.MjData` at qpos0."""
    start: Any
    """The `mujoco.MjData` at the key frame."""
    key: str
    """Name of the key frame; empty at qpos0."""
    root: str
    """Body whose frame is that of the ground; empty for the world."""
    frozen: set[str] = field(default_factory=set)
    """Bodies outside the root that had joints, and stand still."""
    report: Report = field(default_factory=Report)

    def name(self, kind: str, index: int) -> str:
        """Name of an element, such as `name("joint", 3)`; empty if it has none."""
        mujoco = load_mujoco()
        return mujoco.mj_id2name(self.model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), int(index)) or ""

    def label(self, kind: str, index: int) -> str:
        """Name of an element for messages: "joint finger", or "joint 3" if it has no name."""
        return f"{kind} {self.name(kind, index) or index}"


def read(
    path: str | PathLike[str],
    *,
    root: str | None = None,
    branch: str | Sequence[str] = (),
    key: str | None = None,
    ctrl: dict[str, float] | None = None,
    extend: Any = None,
) -> Source:
    """Reads an MJCF or URDF file, and places it at a key frame.

    root: body below which the mechanism is; all other joints stand still. branch: bodies that move with their own joints
    and everything below them; all other joints stand still. key: key frame of the start; the first one by
    default, "" for the zero position. ctrl: control signals by the names of actuators, or their numbers from 0 if they have none. extend: a function that adds to
    the specification.

    Raises ConversionError if MuJoCo refuses the file, or names are unknown.
    """
    mujoco = load_mujoco()
    file, report = Path(path), Report()
    if not file.is_file():
        raise ConversionError(f"there is no file {file}; give the path of an MJCF or URDF file")
    massless: list[str] = []
    try:
        with _warnings_in(mujoco, report):
            spec = _specification(mujoco, file, report)
            _drop_unreadable_meshes(spec, file, report)
            _drop_textures(spec)
            if extend is not None:
                extend(spec)
            massless = [body.name or "(no name)" for body in spec.bodies if body.joints and not body.explicitinertial and not body.geoms]
            model = _compiled(spec, report)
    except ValueError as error:
        if isinstance(error, ConversionError):
            raise
        raise ConversionError(f"MuJoCo does not read {file}: {str(error).strip()}; {_remedy(str(error), massless, report)}") from None
    numbers, chosen = _start(mujoco, model, key, file)
    names = [model.actuator(k).name or str(k) for k in range(model.nu)]
    for name, value in (ctrl or {}).items():
        if name not in names:
            raise ConversionError(f"{file} has no actuator {name}; its actuators are {', '.join(names) or '(none)'}")
        numbers["ctrl"][names.index(name)] = value
    frozen: set[str] = set()
    branches = [_find_body(mujoco, model, file, name) for name in ([branch] if isinstance(branch, str) else branch)]
    if root is not None:
        top: int | None = _find_body(mujoco, model, file, root)
    else:
        top = _carrier(model, branches) if branches else _base(mujoco, model, file, report)
    if top is not None:
        _check_branches(model, file, top, branches)
        spec, model, numbers, frozen = _isolate(mujoco, spec, model, numbers, top, branches, report)
    _warn_about_visual_mass(mujoco, spec, model, report)
    zero, start = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_forward(model, zero)
    for name, values in numbers.items():
        getattr(start, name)[:] = values
    mujoco.mj_forward(model, start)
    return Source(file, spec, model, zero, start, chosen, "" if top is None else model.body(top).name, frozen, report)


@contextlib.contextmanager
def _warnings_in(mujoco: Any, report: Report) -> Iterator[None]:
    """Adds warnings of MuJoCo to a report, in place of the standard error output and the file MUJOCO_LOG.TXT."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: report.warn("MuJoCo", str(message).strip()))
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        for warning in caught:
            report.warn("MuJoCo", str(warning.message).strip())
    finally:
        mujoco.set_mju_user_warning(previous)


def _compiled(spec: Any, report: Report) -> Any:
    """The model of a specification. Moments of inertia that no rigid body has are balanced by MuJoCo."""
    try:
        return spec.compile()
    except ValueError as error:
        if "balanceinertia" not in str(error):
            raise
    spec.compiler.balanceinertia = True
    names = [body.name or "(no name)" for body in spec.bodies if body.explicitinertial and not _is_of_rigid_body(body)]
    text = "the largest moment of inertia exceeds the sum of the others, which no rigid body has; MuJoCo replaces all three by their mean"
    report.warn(f"body {', '.join(names)}", text)
    return spec.compile()


def _is_of_rigid_body(body: Any) -> bool:
    """Whether the moments of inertia of a body satisfy A + B >= C."""
    moments: Numbers = numpy.array(body.inertia)
    if numpy.isfinite(body.fullinertia[0]):
        xx, yy, zz, xy, xz, yz = body.fullinertia
        moments = numpy.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return bool(2.0 * moments.max() <= moments.sum())


_OF_A_PART = "if the file is a part of a larger model, give the file that includes it; or else correct it"
# Remedies for errors of MuJoCo, by a part of their messages.
_REMEDIES = {
    "not found in": _OF_A_PART,
    "unknown default class": _OF_A_PART,
    "invalid qpos size": _OF_A_PART,
    "repeated name": "give one of them another name, also where it is used",
    "unrecognized attribute": "remove this attribute, which this version of MuJoCo does not have",
    "unrecognized element": "remove this element, which this version of MuJoCo does not have",
}


def _remedy(message: str, massless: list[str], report: Report) -> str:
    """What to do about an error of MuJoCo."""
    if "mass and inertia" not in message:
        known = next((remedy for part, remedy in _REMEDIES.items() if part in message), "correct the file")
        return f"{known}, and open it in MuJoCo's viewer to check it"
    which = f"each of these moving bodies ({', '.join(massless)})" if len(massless) > 1 else "the moving body"
    left_out = any(note.name.startswith("meshes") for note in report.of("lost"))
    because = "; meshes that MuJoCo does not read are left out" if left_out else ""
    return f"give {which} an inertial, or a geom with a density{because}"


def _specification(mujoco: Any, file: Path, report: Report) -> Any:
    try:
        top = Tree.parse(file).getroot()
    except Tree.ParseError as error:
        raise ConversionError(f"{file} is no XML file: {error}; give an MJCF or URDF file") from None
    if "xacro" in file.suffix or any("xacro" in str(element.tag) for element in top.iter()):
        raise ConversionError(f"{file} is a xacro file; convert it to URDF first: xacro {file.name} > model.urdf")
    if top.tag == "mujocoinclude":
        raise ConversionError(f"{file} is a part of a model (mujocoinclude); give the file that includes it")
    if top.tag not in ("mujoco", "robot"):
        raise ConversionError(f"{file} is neither MJCF nor URDF: its first element is <{top.tag}> in place of <mujoco> or <robot>")
    if top.tag != "robot":
        return mujoco.MjSpec.from_file(str(file))
    # Links behind fixed joints keep their names, and visual shapes stay.
    settings = top.find("mujoco")
    settings = Tree.SubElement(top, "mujoco") if settings is None else settings
    compiler = settings.find("compiler")
    compiler = Tree.SubElement(settings, "compiler") if compiler is None else compiler
    for name, value in {"fusestatic": "false", "discardvisual": "false", "strippath": "false"}.items():
        compiler.set(name, value)
    for mesh in top.iter("mesh"):
        mesh.set("filename", str(_mesh_file(mesh.get("filename", ""), file.parent)))
    speeds = {joint.get("name", ""): limit.get("velocity") for joint in top.iter("joint") for limit in joint.findall("limit")}
    limited = [f"{name} {speed}" for name, speed in speeds.items() if speed is not None and float(speed) > 0.0]
    if limited:
        report.lost("velocity limits", f"the joints may turn faster than {', '.join(limited)} (rad/s or m/s)")
    return mujoco.MjSpec.from_string(Tree.tostring(top, encoding="unicode"))


def _mesh_file(name: str, directory: Path) -> Path:
    """The file of a mesh of a URDF. The package of `package://` is searched in the directories above the file."""
    relative = name.partition("://")[2] or name
    if name.startswith("file://") or Path(relative).is_absolute():
        return Path(relative)
    within = relative.partition("/")[2] if name.startswith("package://") else ""
    places = [directory, *directory.resolve().parents]
    candidates = [place / part for place in places for part in (relative, within) if part]
    return next((path for path in candidates if path.is_file()), directory / relative)


def _drop_unreadable_meshes(spec: Any, file: Path, report: Report) -> None:
    """Removes geoms with meshes that are missing or have another format, and reports them by body."""
    base = Path(spec.modelfiledir or file.parent) / (spec.meshdir or "")
    reasons = {}
    for mesh in list(spec.meshes):
        found = base / mesh.file
        if mesh.file and mesh.file not in spec.assets:
            if found.suffix.lower() not in _MESH_SUFFIXES:
                what = f"{found.suffix} is" if found.suffix else "a file without suffix has"
                reasons[mesh.name or found.stem] = f"{what} no format that MuJoCo reads (save them as .stl or .obj)"
            elif not found.is_file():
                reasons[mesh.name or found.stem] = f"the files are not in {found.parent}"
    lost: dict[tuple[str, str], None] = {}
    for geom in list(spec.geoms):
        if geom.meshname in reasons:
            lost[geom.parent.name or "world", reasons[geom.meshname]] = None
            spec.delete(geom)
    for mesh in list(spec.meshes):
        if (mesh.name or Path(mesh.file).stem) in reasons:
            spec.delete(mesh)
    for body, reason in lost:
        report.lost(f"meshes of body {body}", f"{reason}; the outlines, and the mass if the body has no inertial, are missing")


def _drop_textures(spec: Any) -> None:
    """Removes textures and skins, which have no effect on a scene, and whose files may be missing."""
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for element in [*spec.textures, *spec.skins]:
        spec.delete(element)


def _warn_about_visual_mass(mujoco: Any, spec: Any, model: Any, report: Report) -> None:
    """Warns about bodies whose mass comes from geoms that touch nothing."""
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE:
        return
    for index, body in enumerate(spec.bodies):
        mass = model.body_mass[index]
        explicit = body.explicitinertial and spec.compiler.inertiafromgeom != mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
        if explicit or model.body_weldid[index] == 0 or mass == 0.0:
            continue
        geoms = [geom for geom in body.geoms if geom.density > 0.0 and geom.mass != 0.0]
        visual = [geom for geom in geoms if geom.contype == 0 and geom.conaffinity == 0]
        if visual:
            part = "all" if len(visual) == len(geoms) else "a part"
            report.warn(
                f"body {body.name}",
                f"{part} of its mass of {1e3 * mass:.4g} g comes from visual geoms, because it has no inertial; without them it would be missing",
            )


def _start(mujoco: Any, model: Any, key: str | None, file: Path) -> tuple[dict[str, Numbers], str]:
    """Positions, rates, control signals and activations at a key frame, and its name."""
    names = [model.key(k).name or str(k) for k in range(model.nkey)]
    zero = {"qpos": model.qpos0.copy(), "qvel": numpy.zeros(model.nv), "ctrl": numpy.zeros(model.nu), "act": numpy.zeros(model.na)}
    if key == "" or (key is None and not names):
        return zero, ""
    chosen = names[0] if key is None else key
    if chosen not in names:
        raise ConversionError(f"{file} has no key frame {chosen}; its key frames are {', '.join(names) or '(none)'}")
    index = names.index(chosen)
    return {name: getattr(model, f"key_{name}")[index].copy() for name in zero}, chosen


def _find_body(mujoco: Any, model: Any, file: Path, name: str) -> int:
    """Index of a body that the user has chosen."""
    found = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name))
    if found < 0:
        names = ", ".join(name for name in (model.body(k).name for k in range(1, model.nbody)) if name)
        raise ConversionError(f"{file} has no body {name}; its bodies are {names}")
    return found


def _carrier(model: Any, branches: Sequence[int]) -> int:
    """The last body that carries all branches."""
    found = int(model.body_parentid[branches[0]])
    while not all(is_below(model, int(model.body_parentid[body]), found) for body in branches):
        found = int(model.body_parentid[found])
    return found


def _check_branches(model: Any, file: Path, top: int, branches: Sequence[int]) -> None:
    for body in branches:
        if body == top or not is_below(model, body, top):
            raise ConversionError(
                f'{file}: the body {model.body(body).name} of --branch is not below {model.body(top).name}, the body of --root; leave out --root'
            )


def _base(mujoco: Any, model: Any, file: Path, report: Report) -> int | None:
    """The floating base of a hand, which becomes the ground; None if no body with joints below it floats."""
    bases = []
    for body in range(1, model.nbody):
        first, count = model.body_jntadr[body], model.body_jntnum[body]
        floats = count > 1 or (count == 1 and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE)
        if model.body_parentid[body] == 0 and floats and _carries_joints(model, body):
            bases.append(body)
    if len(bases) > 1:
        names = [model.body(body).name for body in bases]
        raise ConversionError(f'{file} has {len(bases)} hands that float ({", ".join(names)}); choose one: --root "{names[0]}"')
    if not bases:
        return None
    name = model.body(bases[0]).name or str(bases[0])
    report.changed(f"body {name}", "the base of the hand floats in the model, and stands still in the scene; [moves.NAME] moves it")
    return bases[0]


def _isolate(
    mujoco: Any, spec: Any, model: Any, numbers: dict[str, Numbers], top: int, branches: Sequence[int], report: Report
) -> tuple[Any, Any, dict[str, Numbers], set[str]]:
    """Removes all joints that do not belong to the mechanism below a body, or to its branches if there are any, and
    everything that acts on them.

    Joints of free objects stay. The root stands where it is at the start.
    """
    root = ", ".join(model.body(body).name or str(body) for body in branches or [top])
    data = mujoco.MjData(model)
    data.qpos[:] = numbers["qpos"]
    mujoco.mj_kinematics(model, data)
    starts = branches or [body for body in range(1, model.nbody) if model.body_parentid[body] == top]
    moving = [any(is_below(model, body, start) for start in starts) for body in range(model.nbody)]
    owner = model.jnt_bodyid
    others = [body for body in range(1, model.nbody) if body != top and not moving[body] and model.body_parentid[body] == 0]
    objects = {body for body in others if is_free_body(mujoco, model, body)}
    removed = [j for j in range(model.njnt) if not moving[owner[j]] and owner[j] not in objects]
    kept = [j for j in range(model.njnt) if j not in removed]
    owners = {int(owner[j]) for j in removed} - {int(model.body_weldid[top])}
    frozen = {model.body(body).name for body in range(model.nbody) if int(model.body_weldid[body]) in owners}
    if removed:
        joints = ", ".join(model.joint(j).name or str(j) for j in removed)
        pose = "at zero" if numpy.array_equal(numbers["qpos"], model.qpos0) else "as at the start"
        report.lost(f"joints outside of {root}", f"{joints}; what they carry stands still, {pose}")
    # Addresses of what stays, in the arrays of the start.
    width = {mujoco.mjtJoint.mjJNT_FREE: (7, 6), mujoco.mjtJoint.mjJNT_BALL: (4, 3)}
    sizes = [width.get(mujoco.mjtJoint(model.jnt_type[j]), (1, 1)) for j in kept]
    positions = [k for j, (n, _) in zip(kept, sizes, strict=True) for k in range(model.jnt_qposadr[j], model.jnt_qposadr[j] + n)]
    rates = [k for j, (_, n) in zip(kept, sizes, strict=True) for k in range(model.jnt_dofadr[j], model.jnt_dofadr[j] + n)]
    lost = _references(mujoco, model, set(removed))
    actuators = [k for k in range(model.nu) if k not in lost["actuator"]]
    for kind, plural in (("actuator", "actuators"), ("equality", "equalities"), ("tendon", "tendons")):
        elements = getattr(spec, plural)
        for index in sorted(lost[kind], reverse=True):
            report.lost(f"{kind} {elements[index].name or index}", f"it acts on joints outside of {root}")
            spec.delete(elements[index])
    for plural in ("sensors", "keys"):
        for element in list(getattr(spec, plural)):
            spec.delete(element)
    elements = spec.joints
    for index in sorted(removed, reverse=True):
        spec.delete(elements[index])
    # Links that stand still elsewhere touch nothing.
    still = [geom for body in spec.bodies if body.name in frozen for geom in body.geoms]
    for geom in still:
        geom.contype = geom.conaffinity = 0
    names = {geom.name for geom in still}
    for pair in list(spec.pairs):
        if {pair.geomname1, pair.geomname2} & names:
            spec.delete(pair)
    # The root keeps its pose of the start, although its parents return to theirs of qpos0.
    parent, body, rest = model.body_parentid[top], spec.bodies[top], mujoco.MjData(model)
    mujoco.mj_kinematics(model, rest)
    inverse, quat = numpy.zeros(4), numpy.zeros(4)
    mujoco.mju_negQuat(inverse, rest.xquat[parent])
    mujoco.mju_mulQuat(quat, inverse, data.xquat[top])
    if not (numpy.allclose(data.xpos[top], rest.xpos[top], atol=1e-12) and numpy.allclose(data.xquat[top], rest.xquat[top], atol=1e-12)):
        body.pos = rest.xmat[parent].reshape(3, 3).T @ (data.xpos[top] - rest.xpos[parent])
        body.quat = quat
        body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    with _warnings_in(mujoco, Report()):
        reduced = spec.compile()
    states = [a for k in actuators for a in range(model.actuator_actadr[k], model.actuator_actadr[k] + model.actuator_actnum[k])]
    kept_numbers = (("qpos", positions), ("qvel", rates), ("ctrl", actuators), ("act", states))
    start = {name: numbers[name][indices] for name, indices in kept_numbers}
    return spec, reduced, start, frozen


def is_free_body(mujoco: Any, model: Any, body: int) -> bool:
    """Whether a body has a free joint, or slides and hinges in its place, and carries no other joints."""
    first, count = model.body_jntadr[body], model.body_jntnum[body]
    kinds = [int(kind) for kind in model.jnt_type[first : first + count]]
    slides, hinges = (kinds.count(int(kind)) for kind in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE))
    if kinds != [int(mujoco.mjtJoint.mjJNT_FREE)] and not (slides >= 2 and hinges >= 1 and slides + hinges == count):
        return False
    return not _carries_joints(model, body)


def _carries_joints(model: Any, body: int) -> bool:
    return any(model.body_jntnum[other] and is_below(model, other, body) for other in range(body + 1, model.nbody))


def is_below(model: Any, body: int, ancestor: int) -> bool:
    """Whether a body is another one, or is carried by it."""
    while body > ancestor:
        body = model.body_parentid[body]
    return bool(body == ancestor)


def _references(mujoco: Any, model: Any, joints: set[int]) -> dict[str, set[int]]:
    """Tendons, equalities and actuators that use any of these joints."""
    tendons = set()
    for tendon in range(model.ntendon):
        wraps = range(model.tendon_adr[tendon], model.tendon_adr[tendon] + model.tendon_num[tendon])
        if any(model.wrap_type[k] == mujoco.mjtWrap.mjWRAP_JOINT and model.wrap_objid[k] in joints for k in wraps):
            tendons.add(tendon)
    users = {int(mujoco.mjtEq.mjEQ_JOINT): joints, int(mujoco.mjtEq.mjEQ_TENDON): tendons}
    equalities = {k for k in range(model.neq) if {model.eq_obj1id[k], model.eq_obj2id[k]} & users.get(int(model.eq_type[k]), set())}
    by_joint = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    actuators = set()
    for k in range(model.nu):
        kind, target = int(model.actuator_trntype[k]), model.actuator_trnid[k, 0]
        if (kind in by_joint and target in joints) or (kind == mujoco.mjtTrn.mjTRN_TENDON and target in tendons):
            actuators.add(k)
    return {"tendon": tendons, "equality": equalities, "actuator": actuators}
