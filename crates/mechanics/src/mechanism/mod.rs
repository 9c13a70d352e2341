//! A planar mechanism: rigid bodies, joints, springs, couplings, actuators and contacts as plain lists with names.
//!
//! Both models read this description, and nothing in it knows of fingers. Units are SI, angles are in radians and
//! counter-clockwise. A body has a frame with origin (x, y) and angle θ; a point p of the frame is at (x, y) + R(θ) p in
//! the world. The ground is `None` and has the frame of the world.
//!
//! | file | job |
//! |---|---|
//! | `frame` | the ground, or a body that stands for it and moves |
//! | `joint` | joints: their kinds, coordinates and constraints |
//! | `mirror` | mirror images: the other side of a gripper |
//! | `outline` | outlines of bodies and their contacts |
//! | `overlap` | overlaps of outlines and excesses of limits, as at a wrong start |
//! | `powertrain` | gears, motors and feedback of actuators |
//! | `structure` | the order in which bodies are placed: joints with coordinates, and dyads that close loops |
//! | `tendon` | segments, wraps and lengths of cables |

pub mod structure;
pub mod tendon;

mod assembly;
mod assur;
mod fold;
mod frame;
mod joint;
mod mirror;
mod outline;
mod overlap;
mod powertrain;

use crate::drive::{Brake, Profile};
use crate::law::{Damping, FrictionLaw, NormalLaw};
use crate::numeric::Real;
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, rotate};
use crate::palm_motion::{self, PalmMotion};

pub use assembly::{AssemblyError, Condition, Measure, Start, assemble};
pub use fold::folded_joints;
pub use frame::GROUND;
pub use joint::{Joint, JointKind, constraint_gradients, coordinate_gradient, coordinate_in};
pub use mirror::Mirror;
pub use outline::{
    ContactPair, ForcePoint, Outline, OutlineId, OutlinePair, OutlinePoint, OutlineShape, PlaneArea, PointContact,
    rounded_core,
};
pub use powertrain::{DistanceFeedback, GearLoss, MIN_DISTANCE_M, Motor, NamedPoint, PointId, Powertrain};

/// Pose (x, y, θ) of a frame, in m and rad, or its rate.
pub type Pose = [f64; 3];

/// Returns a point, given in the frame of a body (`None` is the ground), in world coordinates at these poses.
pub fn point_in(body: Option<usize>, point_m: [f64; 2], poses: &[Pose]) -> [f64; 2] {
    let [x, y, angle] = body.map_or([0.0; 3], |body| poses[body]);
    let (sin, cos) = sin_cos(angle);
    add([x, y], rotate(point_m, [cos, sin]))
}

/// Transforms a pose from a frame to the world; the first argument is the pose of the frame in the world.
pub fn pose_in_world([x, y, turn]: Pose, [u, v, angle]: Pose) -> Pose {
    let (sin, cos) = sin_cos(turn);
    let [u, v] = rotate([u, v], [cos, sin]);
    [x + u, y + v, turn + angle]
}

/// A mechanism. Bodies and joints are referred to by their indices in its lists; `None` instead of a body is the
/// ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mechanism {
    pub gravity_m_s2: [f64; 2],
    pub bodies: Vec<Body>,
    /// Outlines fixed to the ground, in the frame of the world.
    pub ground_outlines: Vec<Outline>,
    /// Named points of the ground.
    pub ground_points: Vec<NamedPoint>,
    pub joints: Vec<Joint>,
    pub couplings: Vec<Coupling>,
    pub springs: Vec<Spring>,
    pub tendons: Vec<Tendon>,
    pub actuators: Vec<Actuator>,
    pub rotors: Vec<Rotor>,
    pub sum_limits: Vec<SumLimit>,
    pub contacts: Vec<ContactPair>,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub name: String,
    pub mass_kg: f64,
    /// Moment of inertia about the centre of mass; infinite for a body that does not rotate.
    pub inertia_kg_m2: f64,
    /// Centre of mass in the frame of the body.
    pub com_m: [f64; 2],
    /// Pose at the start. For a body with joints it is a guess, which selects the assembly mode.
    pub pose: Pose,
    /// Rate of the pose at the start; ignored for a body whose rates follow from its joints.
    pub rate: Pose,
    /// Motion that no force affects; mass and inertia have no effect. `None` for a body that forces move.
    pub motion: Option<PrescribedMotion>,
    pub outlines: Vec<Outline>,
    /// Named points in the frame of the body, to which feedback refers.
    pub points: Vec<NamedPoint>,
    /// Polygons that drawings show for the body, in its frame, instead of bars between its pins.
    pub drawn_m: Vec<Vec<[f64; 2]>>,
    /// Whether samples contain the pose of the body. They omit the links of a hand, whose poses follow from the joints.
    pub is_reported: bool,
}

/// Prescribed motion of the frame of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum PrescribedMotion {
    /// From the pose and rate of the body: x(t) = x + velocity t + ½ acceleration t², angle = angle + spin t.
    ConstantAcceleration { acceleration_m_s2: [f64; 2] },
    /// Motion of a palm, starting at rest from its initial pose, which is the pose of the body. Samples of the other
    /// bodies are relative to the palm.
    Palm(PalmMotion),
}

/// A coordinate q = Σ cᵢ qᵢ − offset over joints i with factors cᵢ: for example the coordinate of one joint, or the
/// mean of two joints at the input of a differential.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointCombination {
    pub terms: Vec<(usize, f64)>,
    pub offset: f64,
}

/// A combination of joint coordinates that stays zero, such as gears or synchronised jaws.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    pub name: String,
    pub on: JointCombination,
}

/// Kinetic energy ½ inertia q̇² of a combination of joint coordinates. [`Joint::armature`] is the same for a single
/// joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotor {
    pub name: String,
    pub on: JointCombination,
    /// kg·m² or kg.
    pub inertia: f64,
}

/// A spring with a linear damper.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    pub name: String,
    pub kind: SpringKind,
    /// k, in N·m/rad or N/m.
    pub stiffness: f64,
    /// c, in N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Coordinate (in the unit of the joint) or length, m, at which the elastic force is zero.
    pub rest: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub enum SpringKind {
    /// Q = −k (q − rest) − c q̇ + preload. The energy is ½ k (q − rest)² − preload q.
    Torsional { on: JointCombination, preload: f64 },
    /// Tension k (ℓ − rest) + c ℓ̇ between two points, one on each body.
    Linear { bodies: [Option<usize>; 2], points_m: [[f64; 2]; 2] },
}

/// A massless cable. Its length L is the sum of the straight segments and arcs of its path, and of joint terms. The tension
/// T ≥ 0 of its first segment is the force of a spring and a damper that cannot push, plus the tension of an actuator.
/// Without friction it is the tension of the whole cable. Friction with the coefficient μ at an element with the wrap ψ
/// reduces it by exp(−μ ψ), where the cable slips towards the first segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Tendon {
    pub name: String,
    /// Eyelets and pulleys in the order of the cable; the first and the last element are eyelets. Empty for a belt between
    /// spools.
    pub path: Vec<PathElement>,
    /// Pairs (joint, c): the length contains the term c q, where q is the coordinate of the joint. For a spool of
    /// radius r, c is ±r. These spools have the tension of the first segment.
    pub joints: Vec<(usize, f64)>,
    /// The same for spools behind the last segment, whose tension they have.
    pub far_joints: Vec<(usize, f64)>,
    /// Stiffness k, N/m: T = max(0, k (L − rest) + c dL/dt) for L > rest. With k = c = 0, only the actuator pulls.
    pub stiffness_n_per_m: f64,
    /// Damping c, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Free length, m.
    pub rest_m: f64,
    pub actuator: Option<TendonActuator>,
    /// Whether the path of the scene is in the opposite order.
    pub is_reversed: bool,
}

/// A path element of a tendon: an eyelet, or a pulley that does not turn with the cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathElement {
    pub body: Option<usize>,
    /// Eyelet, or centre of the pulley, in the frame of its body.
    pub point_m: [f64; 2],
    /// Radius of the pulley; 0 for an eyelet.
    pub radius_m: f64,
    /// +1: the cable passes the pulley counter-clockwise, with the centre on its left; −1: clockwise.
    pub side: f64,
    /// Law of the friction coefficient over the speed of the cable on the element; the coefficient is the force of the law
    /// under a normal force of 1. `None` without friction, and at the ends of the path.
    pub friction: Option<FrictionLaw>,
}

/// An actuator that pulls a tendon.
#[derive(Clone, Debug, PartialEq)]
pub struct TendonActuator {
    pub name: String,
    /// Tension over time, N; negative values count as 0.
    pub tension: Profile,
}

/// A motor, with an optional brake. The command u is limited first; then the torque falls with the speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    pub name: String,
    pub on: JointCombination,
    pub command: Command,
    /// Limit of |u|, N·m or N: the largest torque or force at rest.
    pub limit: Option<f64>,
    /// Rate ω₀ at which the torque has fallen to zero: Q = u − |u| q̇/ω₀. The torque is not clipped: if the joint turns
    /// against it, it is larger than at rest.
    pub no_load_speed: Option<f64>,
    pub brake: Option<Brake>,
    /// With a gear, the command, its limit and the no-load speed are those of the motor shaft; with an electric motor, the
    /// command and its limit are voltages.
    pub powertrain: Powertrain,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Torque or force over time.
    Effort(Profile),
    /// Controller: kp (target − q) + kd (d target/dt − q̇). With a rate, it is evaluated at this rate, and is constant
    /// in between.
    Servo {
        kp: f64,
        kd: f64,
        target: Profile,
        /// Largest rate of the target. The target in a scene already respects it.
        target_rate: Option<f64>,
        rate_hz: Option<f64>,
    },
}

impl Command {
    /// Effort or target over time.
    #[inline]
    pub fn profile(&self) -> &Profile {
        let (Command::Effort(profile) | Command::Servo { target: profile, .. }) = self;
        profile
    }

    /// Mutable access to [`Command::profile`].
    pub fn profile_mut(&mut self) -> &mut Profile {
        let (Command::Effort(profile) | Command::Servo { target: profile, .. }) = self;
        profile
    }
}

/// Limits of a combination of joint coordinates: the play of a gear, or the stroke of two sliders together.
#[derive(Clone, Debug, PartialEq)]
pub struct SumLimit {
    pub name: String,
    pub on: JointCombination,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub law: NormalLaw,
}

/// What a limit bounds: the coordinate of a joint, or a sum by its index in [`Mechanism::sum_limits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limited {
    Joint(usize),
    Sum(usize),
}

/// A limit of a coordinate q. The penetration is δ = side (q − value); the force on the coordinate is −side F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    pub of: Limited,
    /// +1 for the upper limit, −1 for the lower one.
    pub side: f64,
    pub value: f64,
    pub law: NormalLaw,
}

impl PrescribedMotion {
    /// Returns the pose at time `t`; `pose` and `rate` are those of the frame at the start.
    #[inline]
    pub fn at(&self, (pose, rate): (Pose, Pose), t: f64) -> palm_motion::Pose {
        match self {
            PrescribedMotion::ConstantAcceleration { acceleration_m_s2: [ax, ay] } => {
                let acceleration = [*ax, *ay, 0.0];
                palm_motion::Pose {
                    position: std::array::from_fn(|axis| pose[axis] + t * (rate[axis] + 0.5 * t * acceleration[axis])),
                    rate: std::array::from_fn(|axis| rate[axis] + t * acceleration[axis]),
                    acceleration,
                    jerk: [0.0; 3],
                }
            }
            PrescribedMotion::Palm(motion) => motion.pose(t),
        }
    }

    /// Upper bounds of the rates and of the accelerations of x, y and θ between two times; `rate` is that of the frame
    /// at the start.
    pub fn largest_rates(&self, rate: Pose, times: [f64; 2]) -> [[f64; 3]; 2] {
        match self {
            PrescribedMotion::ConstantAcceleration { acceleration_m_s2: [ax, ay] } => {
                let acceleration = [*ax, *ay, 0.0];
                let at = |axis: usize, t: f64| (rate[axis] + t * acceleration[axis]).abs();
                let largest = std::array::from_fn(|axis| at(axis, times[0]).max(at(axis, times[1])));
                [largest, acceleration.map(f64::abs)]
            }
            PrescribedMotion::Palm(motion) => motion.largest_rates(times),
        }
    }

    /// Returns the next time after `t` at which any derivative jumps; infinite if there is none.
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        match self {
            PrescribedMotion::ConstantAcceleration { .. } => f64::INFINITY,
            PrescribedMotion::Palm(motion) => motion.next_discontinuity(t),
        }
    }
}

impl JointCombination {
    /// Returns the combination that is the coordinate of one joint.
    pub fn of_joint(joint: usize) -> Self {
        Self { terms: vec![(joint, 1.0)], offset: 0.0 }
    }

    /// Returns the joint if the combination is the coordinate of one joint.
    #[inline]
    pub fn joint(&self) -> Option<usize> {
        match self.terms[..] {
            [(joint, 1.0)] if self.offset == 0.0 => Some(joint),
            _ => None,
        }
    }

    /// Returns Σ cᵢ qᵢ − offset; `coordinate` gives the coordinates qᵢ of the joints.
    #[inline(always)]
    pub fn value<T: Real>(&self, coordinate: impl Fn(usize) -> T) -> T {
        self.add_terms(T::constant(-self.offset), coordinate)
    }

    /// Returns Σ cᵢ xᵢ without the offset: with the rates of the joints as xᵢ, the rate of the combination.
    #[inline(always)]
    pub fn sum<T: Real>(&self, of_joint: impl Fn(usize) -> T) -> T {
        self.add_terms(T::zero(), of_joint)
    }

    #[inline(always)]
    fn add_terms<T: Real>(&self, start: T, of_joint: impl Fn(usize) -> T) -> T {
        self.terms.iter().fold(start, |sum, (joint, factor)| sum + of_joint(*joint) * *factor)
    }

    /// Factor of a joint; 0 if the joint is not among the terms.
    pub fn factor(&self, joint: usize) -> f64 {
        self.terms.iter().filter(|(other, _)| *other == joint).map(|(_, factor)| factor).sum()
    }
}

impl Body {
    /// Returns a body without outlines, at rest at the origin, with its centre of mass there.
    pub fn new(name: impl Into<String>, mass_kg: f64, inertia_kg_m2: f64) -> Self {
        Self {
            name: name.into(),
            mass_kg,
            inertia_kg_m2,
            com_m: [0.0; 2],
            pose: [0.0; 3],
            rate: [0.0; 3],
            motion: None,
            outlines: Vec::new(),
            points: Vec::new(),
            drawn_m: Vec::new(),
            is_reported: true,
        }
    }

    /// Whether the body can rotate.
    pub fn rotates(&self) -> bool {
        self.inertia_kg_m2.is_finite()
    }

    /// Largest distance from the origin of the frame to a point of the outlines, m; `None` without outlines.
    pub fn reach_m(&self) -> Option<f64> {
        self.outlines.iter().map(|outline| outline.shape.reach_m()).max_by(f64::total_cmp)
    }

    /// Whether forces move the body in x, y and θ.
    pub fn moves_by_forces(&self) -> [bool; 3] {
        [true, true, self.rotates()].map(|moves| moves && self.motion.is_none())
    }
}

impl Spring {
    /// Combination of a torsional spring.
    pub fn on(&self) -> Option<&JointCombination> {
        match &self.kind {
            SpringKind::Torsional { on, .. } => Some(on),
            SpringKind::Linear { .. } => None,
        }
    }
}

impl Tendon {
    /// Spools at both ends of the cable, as pairs (joint, c).
    pub fn spools(&self) -> impl Iterator<Item = &(usize, f64)> {
        self.joints.iter().chain(&self.far_joints)
    }

    /// Law of the spring and damper over the elongation beyond `rest_m`; `None` for a cable without them.
    pub fn law(&self) -> Option<NormalLaw> {
        let damping = Damping::Constant { n_s_per_m: self.damping_n_s_per_m };
        (self.stiffness_n_per_m > 0.0 || self.damping_n_s_per_m > 0.0).then_some(NormalLaw {
            stiffness_n_per_m_e: self.stiffness_n_per_m,
            exponent: 1.0,
            damping,
        })
    }
}

impl Mechanism {
    /// The moving palm and its motion. Bodies are reported relative to the palm.
    pub fn palm(&self) -> Option<(usize, &PalmMotion)> {
        self.bodies.iter().enumerate().find_map(|(index, body)| match &body.motion {
            Some(PrescribedMotion::Palm(motion)) => Some((index, motion)),
            _ => None,
        })
    }

    /// Name of a body; `ground` for `None`.
    pub fn body_name(&self, body: Option<usize>) -> &str {
        body.map_or(GROUND, |body| &self.bodies[body].name)
    }

    /// Whether a body is the ground (`None`) or has a prescribed motion.
    pub fn is_base(&self, body: Option<usize>) -> bool {
        body.is_none_or(|body| self.bodies[body].motion.is_some())
    }

    /// Whether any joint is attached to a body; `None` is the ground.
    pub fn has_joint(&self, body: Option<usize>) -> bool {
        self.joints.iter().any(|joint| joint.bodies.contains(&body))
    }

    /// Whether the body of the points comes before that of the face in the order of bodies; the ground is last.
    pub fn points_are_first(&self, pair: &ContactPair) -> bool {
        let order = |id: OutlineId| id.body.unwrap_or(usize::MAX);
        order(pair.points) < order(pair.face)
    }

    /// Limits of all joints, then of sums, in the order that both models use: the lower limit of each first.
    pub fn limits(&self) -> Vec<Limit> {
        let ends = |of: Limited, ends: [Option<f64>; 2], law: Option<NormalLaw>| {
            let limit = move |(side, value): (f64, Option<f64>)| {
                value.zip(law).map(|(value, law)| Limit { of, side, value, law })
            };
            [-1.0, 1.0].into_iter().zip(ends).filter_map(limit)
        };
        let joints = self.joints.iter().enumerate();
        let of_joints = joints.flat_map(|(index, of)| ends(Limited::Joint(index), [of.lower, of.upper], of.limit));
        let sums = self.sum_limits.iter().enumerate();
        let of_sums = sums.flat_map(|(index, of)| ends(Limited::Sum(index), [of.lower, of.upper], Some(of.law)));
        of_joints.chain(of_sums).collect()
    }

    /// Name of a limit, such as `coupler_upper`.
    pub fn limit_name(&self, limit: &Limit) -> String {
        let side = if limit.side > 0.0 { "upper" } else { "lower" };
        match limit.of {
            Limited::Joint(joint) => {
                let joint = &self.joints[joint];
                joint.limit_name.clone().unwrap_or_else(|| format!("{}_{side}", joint.name))
            }
            Limited::Sum(sum) => format!("{}_{side}", self.sum_limits[sum].name),
        }
    }

    /// The coordinate that a limit bounds.
    pub fn limited(&self, limit: &Limit) -> JointCombination {
        match limit.of {
            Limited::Joint(joint) => JointCombination::of_joint(joint),
            Limited::Sum(sum) => self.sum_limits[sum].on.clone(),
        }
    }

    /// Joints on whose coordinates a limit acts, with their factors.
    pub fn limited_terms(&self, limit: &Limit) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (joint, sum) = match limit.of {
            Limited::Joint(joint) => (Some((joint, 1.0)), &[][..]),
            Limited::Sum(sum) => (None, &self.sum_limits[sum].on.terms[..]),
        };
        joint.into_iter().chain(sum.iter().copied())
    }

    /// Whether the coordinate that a limit bounds is an angle.
    pub fn is_angular(&self, limit: &Limit) -> bool {
        self.limited_terms(limit).next().is_some_and(|(joint, _)| self.joints[joint].kind.is_angle())
    }

    /// Inertias of combinations of joint coordinates: those of [`Mechanism::rotors`] and of the rotors of actuators.
    pub fn reflected_inertias(&self) -> impl Iterator<Item = (&JointCombination, f64)> {
        let rotors = self.rotors.iter().map(|rotor| (&rotor.on, rotor.inertia));
        let motors = self.actuators.iter().map(|actuator| (&actuator.on, actuator.powertrain.reflected_inertia()));
        rotors.chain(motors.filter(|(_, inertia)| *inertia != 0.0))
    }

    /// Indices of the bodies that samples report.
    pub fn reported_bodies(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.bodies.len()).filter(|body| self.bodies[*body].is_reported)
    }

    /// Position of a body among those that samples report; `None` if they do not report it.
    pub fn reported_index(&self, body: usize) -> Option<usize> {
        self.reported_bodies().position(|reported| reported == body)
    }

    /// Shortest distance between two joints of the same body, m; infinite if no body has two joints.
    pub fn shortest_link_m(&self) -> f64 {
        let ends = self.joints.iter().flat_map(|joint| [0, 1].map(|k: usize| (joint.bodies[k], joint.points_m[k])));
        let ends: Vec<_> = ends.filter_map(|(body, point_m)| Some((body?, point_m))).collect();
        let lengths = ends.iter().flat_map(|(body, [x, y])| {
            let others = ends.iter().filter(move |(other, _)| other == body);
            others.map(move |(_, [u, v])| hypot(u - x, v - y))
        });
        lengths.filter(|length| *length > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Narrowest slip range of any friction law of a contact, m/s; infinite without friction.
    pub fn narrowest_slip_range_m_s(&self) -> f64 {
        let laws = self.contacts.iter().filter_map(|contact| contact.law.friction);
        laws.map(|friction| friction.min_slip_scale_m_s()).fold(f64::INFINITY, f64::min)
    }

    /// Number of scalar constraints of the joints and couplings.
    pub fn constraint_count(&self) -> usize {
        2 * self.joints.len() + self.couplings.len()
    }
}
