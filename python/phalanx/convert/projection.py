"""State of a projection: the model, its plane, and the planar mechanism so far."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import numpy

from .planar import GROUND, Body, Joint, Mechanism, Outline, Terms
from .plane import Plane
from .read import Numbers, Source, is_free_body, load_mujoco

# Bound of a side without a limit: MJCF has both sides or none.
UNLIMITED = 1e3
# Gravity along the normal that rounded axes leave, m/s^2.
_SMALL_GRAVITY = 1e-2


def valid_name(name: str) -> str:
    """A name of letters, digits and `_`."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)


class Names:
    """Names of one kind, without repetition."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def new(self, name: str, default: str) -> str:
        """A valid name that is not in use."""
        base = valid_name(name) or valid_name(default)
        found = next(name for name in [base, *(f"{base}_{k}" for k in range(2, 10_000))] if name not in self._taken)
        self._taken.add(found)
        return found


class Projection:
    """A model and what is known of its projection so far."""

    def __init__(self, source: Source, plane: Plane) -> None:
        self.source, self.plane, self.model = source, plane, source.model
        self.report = source.report
        self.zero, self.start = source.zero, source.start
        gravity = plane.vector(self.model.opt.gravity)
        if self.is_disabled("GRAVITY"):
            gravity = numpy.zeros(2)
        elif abs(plane.n @ self.model.opt.gravity) > _SMALL_GRAVITY:
            self.report.lost("gravity", f"its part of {plane.n @ self.model.opt.gravity:.4g} m/s^2 along the normal of the plane has no effect")
        self.mechanism = Mechanism(valid_name(source.path.stem) or "model", (float(gravity[0]), float(gravity[1])))
        self.group = self.model.body_weldid.copy()
        """Body that represents each body; 0 for the ground, to which mocap bodies belong."""
        mocap = [body for body in range(self.model.nbody) if self.model.body_mocapid[body] >= 0]
        self.group[numpy.isin(self.group, mocap)] = 0
        self.bodies: dict[int, Body] = {}
        """Bodies of the scene by their group."""
        self.frames = {0: plane}
        """Frames of the bodies of the scene, where they are projected."""
        self.joints: dict[int, Joint] = {}
        """Joints of the scene by their index in the model."""
        self.locked: set[int] = set()
        """Joints whose bodies are one."""
        self.names = {kind: Names() for kind in ("joint", "spring", "coupling", "tendon", "actuator", "rotor", "limit")}
        self.outlines: dict[int, tuple[Body | None, Outline]] = {}
        """Outlines by geom, with their bodies."""
        self.rows: list[Numbers] = []
        """Constraints as rows of factors of the rates of all joints, at the start."""
        self.exact: list[int] = []
        """Equalities that the scene has."""
        self.rounding = 0.0
        """Radius of the corners of outlines, m."""
        self.cables: dict[int, list[tuple[str, float]]] = {}
        """Cables of a spatial tendon, with their divisors."""
        self.ranges: set[int] = set()
        """Spatial tendons with a range."""

    def is_disabled(self, flag: str) -> bool:
        """Whether an option of the model disables a part of the simulation."""
        return bool(self.model.opt.disableflags & int(getattr(load_mujoco().mjtDisableBit, f"mjDSBL_{flag}")))

    def data_of(self, group: int) -> Any:
        """The positions in which a body is projected: a free body at the start, and others in the zero position."""
        return self.start if group in self.bodies and self.bodies[group].is_free else self.zero

    def name_of(self, group: int) -> str:
        """Name of a body of the scene."""
        return self.bodies[group].name if group else GROUND

    def local(self, group: int, point: Any) -> tuple[float, float]:
        """A point of the world in the frame of a body of the scene."""
        x, y = self.frames[group].point(point)
        return float(x), float(y)

    def is_object(self, body: int) -> bool:
        """Whether a body of the model moves freely."""
        return bool(self.model.body_parentid[body] == 0) and is_free_body(load_mujoco(), self.model, body)

    def sum_of_tendon(self, tendon: int) -> Terms | None:
        """Joints and factors of a fixed tendon; None if it is spatial, or has joints that the scene does not have."""
        mujoco, model = load_mujoco(), self.model
        terms: dict[str, float] = {}
        for k in range(model.tendon_adr[tendon], model.tendon_adr[tendon] + model.tendon_num[tendon]):
            if model.wrap_type[k] != mujoco.mjtWrap.mjWRAP_JOINT or model.wrap_objid[k] not in self.joints:
                return None
            name = self.joints[model.wrap_objid[k]].name
            terms[name] = terms.get(name, 0.0) + float(model.wrap_prm[k])
        return [(name, factor) for name, factor in terms.items() if factor != 0.0]
