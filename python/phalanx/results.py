"""Types of the dictionaries in results, for annotations and editors.

Keys carry their SI unit. A class with `total=False` has keys that depend on the kind of scene.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, TypedDict, final

__all__ = [
    "BalancedLoad",
    "CapturePlace",
    "CaptureResult",
    "Check",
    "ContactResult",
    "Criteria",
    "Derivative",
    "Derivatives",
    "Displacement",
    "Energies",
    "Fate",
    "FingerStatics",
    "ForceClosure",
    "Gradient",
    "GradientEvent",
    "Grasp",
    "GripperStatics",
    "HoldLimit",
    "HoldLoad",
    "HoldResult",
    "Margin",
    "MechanismStatics",
    "MergeInfo",
    "OffsetPlace",
    "OffsetsResult",
    "Pair",
    "PartInfo",
    "RunSummary",
    "SizingResult",
    "Statics",
    "StudyInfo",
    "TableSummary",
    "ValidationResult",
]

Fate: TypeAlias = Literal["held", "carried", "placed", "dropped", "ejected", "escaped", "not grasped"]


class Displacement(TypedDict):
    """A displacement in the plane. The sign of the rotation is kept."""

    displacement_m: float
    rotation_rad: float


class Energies(TypedDict):
    """Energies and work at the end, J."""

    kinetic_j: float
    gravity_j: float
    spring_j: float
    elastic_j: float
    dissipated_j: float
    motor_work_j: float
    balance_j: float
    """Error of the energy balance."""


class ContactResult(TypedDict, total=False):
    """Results of a contact of two surfaces (forces) or of a joint limit (torques)."""

    first_s: float | None
    """Time of the first touch-down, s; None if there was none."""
    touchdowns: int
    final_normal_n: float
    final_tangential_n: float
    peak_normal_n: float
    max_penetration_m: float
    impulse_n_s: float
    slips: int
    """Number of transitions from stiction to slip; only with bristle friction."""
    final_torque_n_m: float
    final_force_n: float
    peak_torque_n_m: float
    peak_force_n: float
    max_penetration_rad: float
    impulse_n_m_s: float
    restitution: float | None
    """Coefficient of restitution of a pair of discs, with its speeds; None if it is not meaningful."""
    approach_m_s: float | None
    separation_m_s: float | None


class ForceClosure(TypedDict):
    """Force closure and its quality."""

    closed: bool
    q1_l1: float
    q1_linf: float
    weakest: list[float]
    """Weakest direction of the load: force along x, force along y, and torque divided by the radius."""


class BalancedLoad(TypedDict, total=False):
    """Largest acceleration for which contacts can balance the object in its weakest directions."""

    acceleration_m_s2: float | str
    """Largest acceleration, m/s²; "any" if there is no limit."""
    directions_rad: list[float]
    failure: dict[str, list[str]]
    """Names of what moves beyond this acceleration, by kind of motion: `slipping`, `tilting`, `separating`,
    `yielding`.
    """


class Margin(TypedDict):
    """Margin of a grasp, both with the actuators as they are and with all of them blocked."""

    driven: BalancedLoad
    blocked: BalancedLoad


class Pair(TypedDict):
    """A pair of bodies that touched; one of them is the object."""

    role: str
    first_touch_s: float | None
    presses_since_s: float | None
    times_lost: int
    lost_s: float
    gap_m: float
    normal_n: float
    friction_n: float
    friction_used: float | None
    """Friction force as a fraction of the largest possible friction force."""
    pressure_centre_m: list[float] | None
    slips: bool


class Grasp(TypedDict, total=False):
    """The fate of the object of a hand, and the grasp at the end of the run."""

    fate: Fate
    fate_reason: str
    answer: str
    """Sentence that states the fate."""
    object: str
    base: str
    assumed_hand: list[str]
    states: list[tuple[float, str]]
    """States of the object, each with the time at which it begins, s: "free", "carried", "gripped", …"""
    grasped_s: float | None
    held_since_s: float | None
    tts_s: float | None
    until_s: float | None
    escaped_s: float | None
    left_s: float | None
    contacts_lost: int
    slip: Displacement | None
    creep_m_s: float | None
    grip_n: float
    friction_used: float | None
    margin: Margin | None
    form_closed: bool | None
    q1: float | None
    force_closure: ForceClosure | None
    speed_m_s: float
    travel: Displacement
    pairs: dict[str, Pair]
    never_touched: list[str]
    actuators: dict[str, dict[str, Any]]
    x_start_m: float
    x_end_m: float
    offset_ratio: float | None
    cycle: dict[str, Any]


# "class" is a keyword.
_Class = TypedDict("_Class", {"class": str}, total=False)


class Criteria(Grasp, _Class, total=False):
    """Criteria of a finger, or of a hand (in `grasp`). For a gripper, it also contains the entries of its `grasp`
    itself.
    """

    rebound_percent: float | None
    class_reason: str
    t_geo_s: float | None
    lost_s: float
    statically_stable: bool | None
    grasp: Grasp


class Check(TypedDict, total=False):
    """Error estimate from a second, independent resolution."""

    verdict: str
    """ "sure", or what is uncertain."""
    error_rad: float
    error_m: float
    sensitivity_rad: float
    sensitivity_m: float
    push: float
    bar: float
    bar_of: str
    motion_rad: float | None
    motion_m: float | None
    energy_error: float
    energy_bar: float
    final_errors: list[float]
    first_errors_s: list[float | None]
    normal_errors_n: list[float]
    restitution_errors: list[float | None]
    against: str
    reason: str | None


class RunSummary(TypedDict, total=False):
    """The document of a run (`Result.summary`), or of the run in a log."""

    scene: str
    kind: Literal["finger", "gripper", "bodies", "mechanism"]
    model: str
    duration_s: float
    steps: int
    wall_s: float
    completed: bool | None
    end_s: float
    error: dict[str, Any] | None
    contacts: dict[str, ContactResult]
    energy: Energies
    warnings: list[str]
    check: Check | None
    work: dict[str, int]
    integrator: dict[str, Any] | None
    engine: dict[str, Any] | None
    loop_gap_m: float | None
    log: str | None
    page: str | None
    csv: str | None
    # Of a finger.
    final: dict[str, float]
    criteria: Criteria | None
    no_criteria: str | None
    # Of a gripper.
    fingers: dict[str, dict[str, float]]
    object: dict[str, Any]
    palm_peak_acceleration_m_s2: float | None
    # Of a gripper or a mechanism with a grasp.
    grasp: Grasp
    no_grasp: str
    # Of a mechanism or discs.
    joints: dict[str, dict[str, float]]
    actuators: dict[str, dict[str, float]]
    tendons: dict[str, dict[str, float]]
    bodies: dict[str, dict[str, Any]]


class Derivative(TypedDict):
    """A derivative in SI units. If there is none, `reason` is a sentence."""

    value: float | None
    error: float | None
    reason: str | None


class Derivatives(TypedDict):
    """Derivatives of all columns. If there are none, `reason` is a sentence."""

    values: dict[str, float] | None
    errors: dict[str, float] | None
    reason: str | None


class GradientEvent(TypedDict):
    """Derivatives at a contact event."""

    contact: str
    kind: str
    time_s: float
    time: Derivative
    state: Derivatives


class Gradient(TypedDict):
    """Derivatives of a run with respect to one field."""

    value: float
    """Value of the field, in SI."""
    unit: str
    end: Derivatives
    events: list[GradientEvent]
    tts_s: Derivative


class TableSummary(TypedDict):
    """Counts of the runs of a table."""

    runs: int
    by_status: dict[str, int]
    by_class: dict[str, int]
    no_class: int
    reasons: list[Any]


class StudyInfo(TypedDict):
    """Description of a study."""

    name: str
    model: str
    runs: int
    designs: int
    fingerprint: str


class PartInfo(TypedDict, total=False):
    """Description of a part of a study."""

    study: str
    fingerprint: str
    model: str
    checked: bool
    version: str
    shard: int
    of: int
    first_run: int
    last_run: int
    runs: int
    """Number of runs of the whole study."""
    made_now: int


class MergeInfo(TypedDict):
    """Result of merging the parts of a study."""

    parts: int
    bytes: int
    runs: int


@final
class FingerStatics(TypedDict):
    """Static grasp of a finger."""

    scene: str
    final: dict[str, Any]
    drive: dict[str, Any]
    forces: list[dict[str, Any]]
    forces_per_n_m: list[float]
    form_closure: dict[str, Any]


@final
class GripperStatics(TypedDict):
    """Static grasp of a gripper."""

    scene: str
    posture: dict[str, Any]
    motors: list[dict[str, Any]]
    contacts: list[dict[str, Any]]
    form_closure: list[dict[str, Any]]
    holds: list[dict[str, Any]]


@final
class MechanismStatics(TypedDict):
    """Static grasp of the hand of a mechanism."""

    scene: str
    time_s: float
    object: dict[str, Any]
    base: str
    actuators: list[dict[str, Any]]
    left_out: list[str]
    surroundings: list[str]
    contacts: list[dict[str, Any]]
    form_closure: dict[str, Any]
    holds: list[dict[str, Any]]


Statics: TypeAlias = FingerStatics | GripperStatics | MechanismStatics


class SizingResult(TypedDict):
    """Spring and motor of a finger for a test trajectory."""

    scene: str
    rule: str
    motor_n_m: float
    spring_n_m: float
    rigid: dict[str, float]
    whole: dict[str, float]
    given: dict[str, float]
    convergence_relative: float
    intervals: int
    trajectory: dict[str, float]
    placements: list[dict[str, Any]]
    spring_types: list[dict[str, Any]]


class HoldLimit(TypedDict):
    """Largest acceleration at which the object is held, and smallest acceleration at which it is not."""

    held_m_s2: float | None
    failed_m_s2: float | None
    held_size: dict[str, float] | None
    ended_by: str | None
    monotone: bool
    held_above_m_s2: float | None
    unfinished: int


class HoldLoad(TypedDict):
    """Limits of one load."""

    load: str
    direction_rad: float | None
    length_s: float | None
    axis: str | None
    frequency_hz: float | None
    to_m_s2: float
    quasi_static: str
    quasi_static_m_s2: float | None
    slips: HoldLimit
    drops: HoldLimit
    runs: list[dict[str, Any]]


class HoldResult(TypedDict):
    """Accelerations up to which a gripper holds its object."""

    scene: str
    model: str
    begins_s: float
    begins: str
    slip_bound_m: float
    from_m_s2: float
    to_m_s2: float
    scan: int
    tolerance: float
    unloaded_slip: Displacement
    runs: int
    unfinished: int
    loads: list[HoldLoad]


class CapturePlace(TypedDict):
    """The run at one position of the object."""

    offset_m: float
    form_closed_there: bool | None
    fate: str
    tts_s: float | None
    x_m: float | None
    y_m: float | None
    angle_rad: float | None
    speed_m_s: float | None
    slip: Displacement | None
    form_closed: bool | None
    steps: int
    reason: str | None


@final
class CaptureResult(TypedDict):
    """Positioning errors that a gripper captures."""

    scene: str
    model: str
    palm_width_m: float
    positioning_error_m: float
    captured_from_m: float | None
    captured_to_m: float | None
    lost_left_m: float | None
    lost_right_m: float | None
    places: list[CapturePlace]


class OffsetPlace(TypedDict):
    """The run at one offset of the object."""

    offset_x_m: float
    offset_y_m: float
    offset_angle_rad: float
    fate: str
    fate_reason: str | None
    tts_s: float | None
    x_m: float | None
    y_m: float | None
    angle_rad: float | None
    slip: Displacement | None
    steps: int
    reason: str | None


@final
class OffsetsResult(TypedDict, total=False):
    """Offsets of the object that the hand of a mechanism captures."""

    scene: str
    model: str
    object: str
    base: str
    along: list[str]
    largest: list[float]
    captured_from_m: float | None
    captured_to_m: float | None
    lost_below_m: float | None
    lost_above_m: float | None
    captured_from_rad: float | None
    captured_to_rad: float | None
    lost_below_rad: float | None
    lost_above_rad: float | None
    places: list[OffsetPlace]


class ValidationResult(TypedDict, total=False):
    """Comparison of the engine with the analytic model."""

    scene: str
    kind: str
    passed: bool
    duration_s: float
    until_s: float
    ensemble_runs: int
    ensemble_torque_step: float | None
    verdict: list[dict[str, Any]]
    reference_error: float
    trusted: str | None
    finer: list[Any]
    criteria: list[dict[str, Any]]
    criteria_unjudged: str | None
    analytic: dict[str, Any]
    engine: dict[str, Any]
    statistics: dict[str, Any] | None
    impacts: list[dict[str, Any]]
    differences: dict[str, Any]
    quick: bool
    ladder_time_s: float | None
    settings: list[dict[str, Any]]
    directory: str | None
    files: dict[str, str] | None
