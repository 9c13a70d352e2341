"""A planar mechanism between the projection of a model and its scene file. All values are in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

GROUND = "ground"

Vector: TypeAlias = tuple[float, float]
# Friction that holds: deflection of its bristle at the full friction, rad or m. Larger ones add to the travel.
FRICTION_DEFLECTION = 1e-5
# Names of joints with their factors.
Terms: TypeAlias = list[tuple[str, float]]


@dataclass
class Outline:
    """The projection of a geom, in the frame of its body."""

    name: str
    type: Literal["disc", "capsule", "box", "polygon", "ellipse", "half_plane"]
    points: list[Vector]
    """Centre of a disc, a box or an ellipse; ends of a capsule; corners of a polygon; a point of a half plane."""
    sizes: tuple[float, ...] = ()
    """Radius of a disc or a capsule, width and height of a box, semi-axes of an ellipse, normal of a half plane."""
    angle: float = 0.0
    rounding: float = 0.0
    depth: tuple[float, float] = (0.0, 0.0)
    """Extent along the normal of the plane."""
    comment: str = ""
    geom: int = -1
    """Index of the geom in the model."""


@dataclass
class Body:
    """A group of bodies without joints between them. The axes of its frame are those of the plane in the zero
    position.
    """

    name: str
    origin: Vector
    """Origin of the frame in the zero position."""
    mass: float
    com: Vector
    inertia: float
    members: list[str] = field(default_factory=list)
    """Bodies of the model."""
    outlines: list[Outline] = field(default_factory=list)
    at: Vector = (0.0, 0.0)
    """Position of the origin at the start."""
    angle: float = 0.0
    """Angle of the frame at the start."""
    is_free: bool = False
    velocity: Vector = (0.0, 0.0)
    spin: float = 0.0


@dataclass
class Joint:
    """A hinge, a slide, or the pin of a `connect`."""

    name: str
    bodies: tuple[str, str]
    points: tuple[Vector, Vector]
    is_slide: bool = False
    axis: float = 0.0
    offset: float = 0.0
    start: float | None = None
    start_rate: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    friction: float = 0.0
    lower: float | None = None
    upper: float | None = None
    stop: str = ""
    comment: str = ""
    index: int = -1
    """Index of the joint in the model; -1 for a `connect`."""
    carrier: str = ""
    """The body that carries the other one in the model; empty for a `connect`."""


@dataclass
class Spring:
    """A spring on a sum of joint coordinates, or between two points."""

    name: str
    stiffness: float
    damping: float
    rest: float
    terms: Terms = field(default_factory=list)
    bodies: tuple[str, str] | None = None
    points: tuple[Vector, Vector] | None = None
    is_linear: bool = False
    comment: str = ""


@dataclass
class Coupling:
    """A linear relation of joint coordinates."""

    name: str
    terms: Terms
    value: float
    is_linear: bool
    comment: str = ""


@dataclass
class Rotor:
    """An inertia that turns by a sum of joint coordinates."""

    name: str
    terms: Terms
    inertia: float
    is_linear: bool


@dataclass
class SumLimit:
    """Limits of a sum of joint coordinates."""

    name: str
    terms: Terms
    lower: float | None
    upper: float | None
    stop: str
    is_linear: bool


@dataclass
class Element:
    """An eyelet of a cable, or a pulley if it has a radius."""

    body: str
    at: Vector
    radius: float = 0.0
    turn: Literal["cw", "ccw"] = "ccw"


@dataclass
class Tendon:
    """A cable."""

    name: str
    path: list[Element]
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    comment: str = ""
    rest_comment: str = "springlength"
    is_range: bool = False
    """Whether it is the upper end of a range, at which the cable is taut."""


@dataclass
class Actuator:
    """A constant effort, a servo, or the tension of a cable."""

    name: str
    terms: Terms = field(default_factory=list)
    tendon: str = ""
    is_linear: bool = False
    effort: float | None = None
    target: float = 0.0
    rate: float = 0.0
    """Rate of the target of a servo that only follows a speed."""
    kp: float = 0.0
    kd: float = 0.0
    limit: float | None = None
    times: list[float] = field(default_factory=list)
    """Times of `values`, s; empty for a constant effort or target."""
    values: list[float] = field(default_factory=list)
    """Efforts or targets."""
    comments: dict[str, str] = field(default_factory=dict)
    """Origins of values, by key."""


@dataclass
class Law:
    """A law of contacts, or of stops if it has no friction coefficient."""

    name: str
    stiffness: float
    friction: float | None
    comment: str
    is_linear: bool = True
    """Whether its depth is a length; an angle for stops of hinges."""
    is_spring: bool = False
    """Whether it is a spring beyond a dead band, without damping."""


@dataclass
class Contact:
    """Two outlines, as BODY.OUTLINE, that may touch."""

    between: tuple[str, str]
    law: str


@dataclass
class Mechanism:
    """Content of a scene."""

    name: str
    gravity: Vector
    bodies: list[Body] = field(default_factory=list)
    ground: list[Outline] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    springs: list[Spring] = field(default_factory=list)
    tendons: list[Tendon] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    rotors: list[Rotor] = field(default_factory=list)
    limits: list[SumLimit] = field(default_factory=list)
    actuators: list[Actuator] = field(default_factory=list)
    laws: list[Law] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    surroundings: list[str] = field(default_factory=list)
    """Outlines of the ground, as GROUND.OUTLINE, that are not part of the hand."""


def friction_stiffness(friction: float) -> float:
    """Stiffness of the bristle of a frictionloss, N·m/rad or N/m."""
    return friction / FRICTION_DEFLECTION
