//! The powertrain of an actuator: electric motor and gear between its command and its coordinate, and the distance that
//! its controller measures in place of the coordinate.
//!
//! With the gear ratio n, the motor turns at n q̇. Its torque u drives the coordinate with n u, less the loss of the gear.

use super::{
    Actuator, Command, JointCombination, Mechanism, Pose, constraint_gradients, coordinate_gradient, coordinate_in,
    point_in,
};
use crate::law::{Bristle, FrictionLaw};
use crate::numeric::dense;
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{cross, rotate, scale, sub};

/// Smallest distance of the points of a [`DistanceFeedback`], m. A run ends there: a distance has no sign, so the
/// controller would drive points that have passed each other apart.
pub const MIN_DISTANCE_M: f64 = 1e-6;

/// Gear, motor and feedback of an actuator. The default drives the coordinate directly.
#[derive(Clone, Debug, PartialEq)]
pub struct Powertrain {
    /// n, motor rate per rate of the coordinate: a ratio, or rad/m.
    pub gear: f64,
    /// J, moment of inertia of the rotor, kg·m². It adds n² J to the inertia of the coordinate.
    pub rotor_kg_m2: f64,
    pub loss: Option<GearLoss>,
    pub motor: Option<Motor>,
    pub feedback: Option<DistanceFeedback>,
}

/// Loss of a gear: (1 − η) |n u| S(q̇) against the motion, where S is the law of friction with μ_s = μ_d = 1. A gear that
/// drives gives η n u, and one that is driven back resists with (2 − η) n u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearLoss {
    /// η, above 0 and at most 1.
    pub efficiency: f64,
    /// Rate of the coordinate from which on S = ±1, rad/s or m/s.
    pub rate: f64,
    /// Bristle in units of the coordinate, with which the gear holds without creep; `None` for S(q̇), which creeps.
    pub bristle: Option<Bristle>,
}

/// A DC motor. The command of its actuator is the voltage V, whose bounds are ± the limit of the actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// k_t, N·m/A: the torque is u = k_t i.
    pub torque_constant: f64,
    /// R, Ω.
    pub resistance: f64,
    /// Largest |i|, A.
    pub current_limit: Option<f64>,
    /// k_e, V·s/rad.
    pub back_emf: f64,
    /// L, H: L di/dt = V − R i − k_e n q̇ within the limit. `None` for i = (V − k_e n q̇)/R.
    pub inductance: Option<f64>,
}

/// A point of the list of a body, or of the ground (`None`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointId {
    pub body: Option<usize>,
    pub point: usize,
}

/// A point with a name, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    pub name: String,
    pub at_m: [f64; 2],
}

/// The distance d of two points, which takes the place of the coordinate in a controller:
/// u = sign (kp (target − d) + kd (d target/dt − ḋ)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceFeedback {
    pub points: [PointId; 2],
    /// +1 if a positive effort opens, −1 if it closes.
    pub sign: f64,
}

impl Default for Powertrain {
    fn default() -> Self {
        Self { gear: 1.0, rotor_kg_m2: 0.0, loss: None, motor: None, feedback: None }
    }
}

impl Powertrain {
    /// Whether the effort on the coordinate is the command with its limit and its decrease with the rate.
    #[inline]
    pub fn is_direct(&self) -> bool {
        self.gear == 1.0 && self.loss.is_none() && self.motor.is_none() && self.feedback.is_none()
    }

    /// Whether the current is a state.
    pub fn has_charge(&self) -> bool {
        self.motor.is_some_and(|motor| motor.inductance.is_some())
    }

    /// n² J, kg·m² or kg.
    pub fn reflected_inertia(&self) -> f64 {
        self.gear * self.gear * self.rotor_kg_m2
    }

    /// Whether samples contain the torque of the motor, because it is not the effort on the coordinate.
    pub fn has_shaft(&self) -> bool {
        self.gear != 1.0 || self.loss.is_some() || self.motor.is_some()
    }
}

impl Actuator {
    /// Largest magnitude of the effort on the coordinate at rest, with the whole loss of the gear against it;
    /// `None` without a bound.
    pub fn effort_limit(&self) -> Option<f64> {
        let Powertrain { gear, motor, .. } = &self.powertrain;
        let torque = match motor {
            None => self.limit,
            Some(Motor { torque_constant, resistance, current_limit, .. }) => {
                let stall = self.limit.map(|voltage| voltage / resistance);
                let current = match (stall, *current_limit) {
                    (Some(stall), Some(limit)) => Some(stall.min(limit)),
                    (stall, limit) => stall.or(limit),
                };
                current.map(|current| torque_constant * current)
            }
        };
        torque.map(|torque| gear.abs() * torque)
    }

    /// Effort on the coordinate at rest for a command, without the loss of the gear, which is 0 at rest.
    pub fn effort_at_rest(&self, command: f64) -> f64 {
        let limit = self.limit.unwrap_or(f64::INFINITY);
        let command = command.clamp(-limit, limit);
        let torque = match &self.powertrain.motor {
            None => command,
            Some(motor) => motor.torque_constant * motor.limited(command / motor.resistance),
        };
        self.powertrain.gear * torque
    }
}

impl Motor {
    /// A current within the limit, A.
    pub fn limited(&self, current: f64) -> f64 {
        let limit = self.current_limit.unwrap_or(f64::INFINITY);
        current.clamp(-limit, limit)
    }
}

impl GearLoss {
    /// The law of friction whose normal force is (1 − η) |n u|.
    pub fn law(&self) -> FrictionLaw {
        FrictionLaw {
            mu_static: 1.0,
            mu_dynamic: 1.0,
            v_static_m_s: self.rate,
            v_dynamic_m_s: 2.0 * self.rate,
            kind: self.bristle.into(),
        }
    }
}

impl Mechanism {
    /// A named point, in the frame of its body.
    pub fn point(&self, id: PointId) -> &NamedPoint {
        let points = id.body.map_or(&self.ground_points, |body| &self.bodies[body].points);
        &points[id.point]
    }

    /// Name of a point with its body, such as `left.tip`.
    pub fn point_name(&self, id: PointId) -> String {
        format!("{}.{}", self.body_name(id.body), self.point(id).name)
    }

    /// Distance of the points of a feedback in these poses, m.
    pub fn distance(&self, feedback: &DistanceFeedback, poses: &[Pose]) -> f64 {
        let [a, b] = feedback.points.map(|id| point_in(id.body, self.point(id).at_m, poses));
        let [x, y] = sub(b, a);
        hypot(x, y)
    }

    /// Value that the controller of an actuator measures in these poses: its coordinate, or a distance.
    pub fn measured(&self, actuator: &Actuator, poses: &[Pose]) -> f64 {
        match &actuator.powertrain.feedback {
            Some(feedback) => self.distance(feedback, poses),
            None => actuator.on.value(|joint| coordinate_in(&self.joints[joint], poses)),
        }
    }

    /// Command of an actuator at rest in these poses at time `t`, before its limit.
    pub fn command_at_rest(&self, actuator: &Actuator, poses: &[Pose], t: f64) -> f64 {
        match &actuator.command {
            Command::Effort(profile) => profile.at(t).0,
            Command::Servo { kp, target, .. } => {
                let sign = actuator.powertrain.feedback.map_or(1.0, |feedback| feedback.sign);
                sign * kp * (target.at(t).0 - self.measured(actuator, poses))
            }
        }
    }

    /// Acceleration of a measured distance at rest per unit effort of its actuator, m/s² per N·m or N: above 0 if a positive
    /// effort opens. `None` without feedback, or if the constraints are singular.
    pub fn opening(&self, actuator: usize, poses: &[Pose]) -> Option<f64> {
        let actuator = &self.actuators[actuator];
        let feedback = actuator.powertrain.feedback?;
        let (free, mut constraints) = (3 * self.bodies.len(), Vec::new());
        let row = |parts: &mut dyn Iterator<Item = (Option<usize>, Pose)>| {
            let mut row = vec![0.0; free];
            for (body, by_pose) in parts.filter_map(|(body, by_pose)| Some((body?, by_pose))) {
                row[3 * body..3 * body + 3].iter_mut().zip(by_pose).for_each(|(sum, part)| *sum += part);
            }
            row
        };
        let combination = |on: &JointCombination| {
            row(&mut on.terms.iter().flat_map(|(joint, factor)| {
                let joint = &self.joints[*joint];
                joint.bodies.into_iter().zip(coordinate_gradient(joint, poses).map(|part| part.map(|x| factor * x)))
            }))
        };
        for joint in &self.joints {
            constraints.extend(constraint_gradients(joint, poses).map(|by| row(&mut joint.bodies.into_iter().zip(by))));
        }
        constraints.extend(self.couplings.iter().map(|coupling| combination(&coupling.on)));
        for (index, body) in self.bodies.iter().enumerate() {
            let fixed = body.moves_by_forces().map(|moves| !moves);
            constraints.extend(
                (0..3).filter(|axis| fixed[*axis]).map(|axis| {
                    row(&mut std::iter::once((Some(index), [0, 1, 2].map(|other| f64::from(other == axis)))))
                }),
            );
        }
        let count = free + constraints.len();
        let mut matrix = vec![0.0; count * count];
        for (index, body) in self.bodies.iter().enumerate() {
            let inertia = if body.rotates() { body.inertia_kg_m2 } else { 1.0 };
            let (sin, cos) = sin_cos(poses[index][2]);
            let ([x, y], m) = (rotate(body.com_m, [cos, sin]), body.mass_kg.max(f64::MIN_POSITIVE));
            let block = [[m, 0.0, -m * y], [0.0, m, m * x], [-m * y, m * x, inertia + m * (x * x + y * y)]];
            for (i, entries) in block.iter().enumerate() {
                matrix[(3 * index + i) * count + 3 * index..][..3].copy_from_slice(entries);
            }
        }
        for (on, inertia) in self.reflected_inertias() {
            let of = combination(on);
            for i in 0..free {
                (0..free).for_each(|j| matrix[i * count + j] += inertia * of[i] * of[j]);
            }
        }
        for (index, constraint) in constraints.iter().enumerate() {
            for (j, part) in constraint.iter().enumerate() {
                matrix[j * count + free + index] = *part;
                matrix[(free + index) * count + j] = *part;
            }
        }
        let mut accelerations = combination(&actuator.on);
        accelerations.resize(count, 0.0);
        if !dense::solve(&mut matrix, &mut accelerations, count, |_| true) {
            return None;
        }
        let [a, b] = feedback.points.map(|id| point_in(id.body, self.point(id).at_m, poses));
        let [x, y] = sub(b, a);
        let along = scale([x, y], 1.0 / hypot(x, y));
        let by_pose = |id: PointId, sign: f64| {
            let origin = id.body.map_or([0.0; 2], |body| [poses[body][0], poses[body][1]]);
            let [u, v] = scale(along, sign);
            (id.body, [u, v, cross(sub(point_in(id.body, self.point(id).at_m, poses), origin), [u, v])])
        };
        let [first, second] = feedback.points;
        let distance = row(&mut [by_pose(first, -1.0), by_pose(second, 1.0)].into_iter());
        Some(distance.iter().zip(&accelerations).map(|(by, acceleration)| by * acceleration).sum())
    }

    /// Sentence for points that meet.
    pub fn describe_met_points(&self, actuator: usize) -> String {
        let of = &self.actuators[actuator];
        let names = of.powertrain.feedback.map(|feedback| feedback.points.map(|id| self.point_name(id)));
        let [a, b] = names.unwrap_or_default();
        format!(
            "the points {a} and {b} met: the actuator {} controls their distance, which has no sign; stop the motion before, \
             or move the points so that they stay apart by more than 1 um",
            of.name
        )
    }
}
