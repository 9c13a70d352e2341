"""The conversion of a model into a scene, and its report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

from .._phalanx import Scene
from .cube import adder
from .planar import Mechanism
from .plane import Plane, find_plane
from .project import project
from .read import Source, load_mujoco, read
from .report import Report
from .write import scene_text

# Duration of a scene, in which hands close.
DURATION_S = 0.5
# Mass of the cube that is added on request.
CUBE_KG = 0.1


@dataclass
class Conversion:
    """A scene from a model, and the report on what it lacks."""

    toml: str
    """The scene file."""
    report: Report
    """What is not carried over, what is different, and what is suspicious in the model."""
    mechanism: Mechanism
    """The numbers of the scene."""
    source: Source
    """The compiled model."""
    plane: Plane
    """The plane of motion."""

    @property
    def scene(self) -> Scene:
        """The validated scene. Raises SceneError if phalanx refuses it."""
        return Scene.from_toml(self.toml, f"{self.mechanism.name}.toml")

    def __str__(self) -> str:
        return "\n".join(_header(self.mechanism, self.source, self.plane, self.report))


def _header(mechanism: Mechanism, source: Source, plane: Plane, report: Report) -> list[str]:
    start = f'key frame "{source.key}"' if source.key else "zero position (qpos0)"
    lines = [
        f"{mechanism.name}, from {source.path.name} with MuJoCo {load_mujoco().__version__} (python -m phalanx.convert).",
        f"Plane: {plane.comment}" + (f"; the ground is {source.root}." if source.root else "."),
        f"Start: {start}. Joint coordinates are those of the model. Frames have the axes of the plane, in the zero position.",
    ]
    notes = report.lines()
    return lines + (["", *notes] if notes else [])


def from_mjcf(
    path: str | PathLike[str],
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
) -> Conversion:
    """Converts a MuJoCo model (MJCF), or a URDF, into the scene of a mechanism.

    `conversion = phalanx.from_mjcf("hand.xml")`, `print(conversion)` for the report, `phalanx.run(conversion.scene)`,
    and `conversion.toml` for the text of the scene.

    plane: "xy", "xz", "yz", "yx", "zx" or "zy" of the root's frame; found from the axes of the joints by default. root:
    the body below which the mechanism is, and whose frame is that of the scene; by default the last fixed body that
    carries all joints, or the base of a hand that floats. branch: a body, or several, that move with their own joints and
    everything below them, such as the first link of a finger; all other joints stand still. key: the key frame of the start; the first one by default, ""
    for the zero position. ctrl: control signals by actuator, such as `{"fingers": 255}` (its number, "0", if it has no
    name); those of the key frame, or 0, by default. cube: edge of a cube, m, that is added to the model; cube_mass: its
    mass, kg; cube_at: its place in the plane, m, by default between the ends of the fingers. duration: of the scene, s.

    Needs the package mujoco: `pip install "phalanx[mujoco]"`. Raises ConversionError (a ValueError) if MuJoCo refuses the
    model, or if it is not planar; the message names the joint and its axis.
    """
    source, found, mechanism = _projected(path, plane, root, branch, key, ctrl, None)
    if cube is not None:
        extend = adder(source, found, mechanism, cube, cube_mass, cube_at)
        source, found, mechanism = _projected(path, plane, root, branch, key, ctrl, extend)
        if not mechanism.contacts:
            source.report.warn("the cube", "it touches nothing: the geoms of the model have contype and conaffinity 0, or overlap it at the start")
    toml = scene_text(mechanism, _header(mechanism, source, found, source.report), duration)
    return Conversion(toml, source.report, mechanism, source, found)


def _projected(
    path: str | PathLike[str],
    plane: str | None,
    root: str | None,
    branch: str | Sequence[str],
    key: str | None,
    ctrl: Mapping[str, float] | None,
    extend: Any,
) -> tuple[Source, Plane, Mechanism]:
    source = read(path, root=root, branch=branch, key=key, ctrl=dict(ctrl or {}), extend=extend)
    found = find_plane(source, plane)
    return source, found, project(source, found)
