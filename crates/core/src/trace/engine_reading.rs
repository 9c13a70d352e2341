//! Converts nodes of the engine model to samples.

use std::f64::consts::PI;

use super::schema::JointState;
use super::{BodyState, ContactSample, Energy, FingerState, Sample};
use crate::engine::{
    ContactCandidate, JointReactions, L11, L12, L21, L22, LINKS, Motion, PalmFrame, Twist, driven_link_brake_torque,
    first_link, kinetic_energy, potential_energies,
};
use crate::law::{elastic_energy, normal_force};
use crate::mechanism::Mechanism;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{angle_between, nearest_equivalent_angle, opening_angle, perp, rotate, scale, sub};
use crate::scene::{ContactId, Disc, Scene, Side, System};

/// Reads joints, actuators and bodies of a scene at a node of its motion.
pub(super) fn read_state(scene: &Scene, motion: &Motion, sample: &mut Sample) {
    match &scene.mechanism {
        Some(mechanism) => read_mechanism(mechanism, motion, sample),
        None => read_system(&scene.system, motion, sample),
    }
}

fn read_mechanism(mechanism: &Mechanism, motion: &Motion, sample: &mut Sample) {
    let (plan, state) = (motion.plan, (&motion.linkage.poses[..], &motion.velocities[..]));
    for (index, joint) in plan.joints.iter().enumerate() {
        let coordinate = plan.joint_coordinate(joint);
        let (angle_rad, rate_rad_s) = (coordinate.value(state.0), coordinate.row(state.0).rate(state.1));
        sample.set_joint(index, &JointState { angle_rad, rate_rad_s, ..sample.joint_state(index) });
    }
    for (index, actuator) in plan.actuators.iter().enumerate() {
        let brakes = plan.brakes.iter().enumerate().filter(|(_, brake)| brake.actuator == index);
        let brake_torque: f64 = brakes.map(|(brake, _)| motion.brake_torque(brake)).sum();
        sample.set_actuator(index, plan.effort(*actuator, motion.clock.now(), state) + brake_torque);
    }
    for (index, (body, (pose, v))) in mechanism.bodies.iter().zip(state.0.iter().zip(state.1)).enumerate() {
        // A body is reported by its frame.
        let arm = rotate(body.com_m, pose.direction);
        let velocity_m_s = sub([v[0], v[1]], scale(perp(arm), v[2]));
        let centre_m = sub(pose.com, arm);
        sample.set_body(index, &BodyState { centre_m, angle_rad: pose.angle, velocity_m_s, spin_rad_s: v[2] });
    }
}

fn read_system(system: &System, motion: &Motion, sample: &mut Sample) {
    let frame = PalmFrame::at(motion.plan, motion.clock.now());
    for (index, (side, finger)) in system.fingers_by_side().enumerate() {
        let state = (&motion.linkage.poses[..], &motion.velocities[..]);
        let torque = motion.plan.motor_torque(first_link(side) + L11, motion.clock.now(), state);
        let brakes = driven_link_brake_torque(motion.plan, side, |brake| motion.brake_torque(brake));
        let phi22_rad = finger.linkage.lengths.phi22_rad;
        let state = Links::new(side, &frame).read(motion, phi22_rad, side.mirror() * torque + brakes);
        sample.set_finger(index, &state);
    }
    for (index, (disc, body)) in reported_discs(system).enumerate() {
        let state = match body {
            Some(body) => {
                let (pose, v) = (&motion.linkage.poses[body], &motion.velocities[body]);
                let ([vx, vy, spin_rad_s], centre_m) = (frame.twist(pose.com, v), frame.point(pose.com));
                let angle_rad = pose.angle - frame.angular_motion()[0];
                BodyState { centre_m, angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
            }
            None => BodyState { centre_m: disc.centre_m, angle_rad: disc.angle_rad, ..BodyState::default() },
        };
        sample.set_body(index, &state);
    }
}

/// Sets coordinates and rates of `sample` by extrapolating freely from `from` with the accelerations of all bodies in
/// the last step of `motion`.
pub(super) fn extrapolate(scene: &Scene, sample: &mut Sample, from: &Sample, motion: &Motion) {
    match &scene.mechanism {
        Some(mechanism) => extrapolate_mechanism(mechanism, sample, from, motion),
        None => extrapolate_system(&scene.system, sample, from, motion),
    }
}

fn extrapolate_mechanism(mechanism: &Mechanism, sample: &mut Sample, from: &Sample, motion: &Motion) {
    let (plan, poses, velocities) = (motion.plan, &motion.linkage.poses, &motion.velocities);
    let time_s = sample.time_s - from.time_s;
    for (index, joint) in plan.joints.iter().enumerate() {
        let (coordinate, state) = (plan.joint_coordinate(joint), from.joint_state(index));
        let a = coordinate.row(poses).rate(&motion.step_accelerations) + coordinate.second_rate(poses, velocities);
        let angle_rad = state.angle_rad + time_s * (state.rate_rad_s + 0.5 * time_s * a);
        sample.set_joint(index, &JointState { angle_rad, rate_rad_s: state.rate_rad_s + time_s * a, ..state });
    }
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let ([ax, ay, angular], spin) = (motion.step_accelerations[index], velocities[index][2]);
        let arm = rotate(body.com_m, poses[index].direction);
        let [x, y] = sub([ax, ay], sub(scale(perp(arm), angular), scale(arm, spin * spin)));
        sample.set_body(index, &from.body(index).extrapolate(time_s, &[x, y, angular]));
    }
}

fn extrapolate_system(system: &System, sample: &mut Sample, from: &Sample, motion: &Motion) {
    let accelerations = &motion.step_accelerations;
    let time_s = sample.time_s - from.time_s;
    let frame = PalmFrame::at(motion.plan, motion.clock.now());
    for (index, side) in Side::BOTH.into_iter().enumerate().take(sample.counts().fingers) {
        let finger = Links::new(side, &frame).extrapolate(&from.finger(index), time_s, accelerations);
        sample.set_finger(index, &FingerState { motor_torque_n_m: sample.finger(index).motor_torque_n_m, ..finger });
    }
    for (body, (_, moving)) in reported_discs(system).enumerate() {
        if let Some(index) = moving {
            let (pose, v) = (&motion.linkage.poses[index], &motion.velocities[index]);
            let acceleration = frame.acceleration(pose.com, v, &accelerations[index]);
            sample.set_body(body, &from.body(body).extrapolate(time_s, &acceleration));
        }
    }
}

/// Discs contained in samples, each with its body index in the plan; `None` for a disc that does not move.
fn reported_discs(system: &System) -> impl Iterator<Item = (&Disc, Option<usize>)> {
    let mut next = LINKS * system.fingers.len();
    system.reported_discs().iter().map(move |disc| {
        let body = disc.motion.moves().then_some(next);
        next += usize::from(disc.motion.moves());
        (disc, body)
    })
}

/// Contacts whose sampled normal is opposite to that of the plan, which points to the first of its bodies: in scenes
/// with fingers, sampled normals of palm and table point away from the discs. In a mechanism they point away from the
/// face, and the body of the plan is that of the face if the points are fixed.
pub(super) fn flipped_normals(scene: &Scene) -> Vec<bool> {
    if let Some(mechanism) = &scene.mechanism {
        let points = mechanism.point_contacts();
        return points
            .iter()
            .map(|point| point.body.is_none())
            .chain(mechanism.limits().iter().map(|_| false))
            .collect();
    }
    let system = &scene.system;
    let is_plane = |id: &ContactId| matches!(id, ContactId::Palm(_) | ContactId::Table(_));
    system.contact_ids().iter().map(|id| !system.fingers.is_empty() && is_plane(id)).collect()
}

/// Returns the stored energies of the node.
pub(super) fn stored_energy(motion: &Motion) -> Energy {
    let frame = PalmFrame::at(motion.plan, motion.clock.now());
    let (gravity_j, spring_j) = potential_energies(motion.plan, &motion.linkage, &frame);
    let with_law = motion.candidates.iter().filter(|candidate| candidate.uses_contact_law && candidate.has_gap());
    Energy {
        kinetic_j: kinetic_energy(&motion.linkage, &motion.velocities, &frame),
        gravity_j,
        spring_j,
        elastic_j: with_law.map(|candidate| elastic_energy(&candidate.law, -candidate.gap)).sum::<f64>()
            + motion.bristle_energy(),
        ..Energy::default()
    }
}

/// Returns a contact at the node; `index` is its element index in the plan.
pub(super) fn sample_contact(motion: &Motion, index: Option<usize>, impulse_n_s: f64) -> ContactSample {
    let candidate = index.and_then(|index| motion.candidate(index));
    let frame = PalmFrame::at(motion.plan, motion.clock.now());
    candidate.map_or(ContactSample::NONE, |candidate| {
        let (normal_n, tangential_n) = contact_forces(motion, candidate);
        ContactSample {
            gap_m: candidate.gap,
            gap_rate_m_s: candidate.normal_row.rate(&motion.velocities),
            slip_m_s: candidate.slip_row.rate(&motion.velocities),
            normal_n,
            tangential_n,
            impulse_n_s,
            point_m: if candidate.is_between_surfaces() { frame.point(candidate.point) } else { candidate.point },
            normal: frame.direction(candidate.normal),
        }
    })
}

/// Returns normal and tangential force of a candidate at the end of the last step; before the first step, from the
/// contact laws.
fn contact_forces(motion: &Motion, candidate: &ContactCandidate) -> (f64, f64) {
    if motion.last_dt_s > 0.0 {
        return motion.forces(candidate.index);
    }
    if !candidate.uses_contact_law {
        return (0.0, 0.0);
    }
    let [rate, slip] = [&candidate.normal_row, &candidate.slip_row].map(|row| row.rate(&motion.velocities));
    let normal = normal_force(&candidate.law, -candidate.gap, -rate).force;
    (normal, -candidate.friction_at_step_end([slip, 0.0, normal], 0.0).force)
}

/// Number of pins of a finger.
const FINGER_PINS: usize = 5;
/// Pins of the joints of a finger, in the order of its samples.
const PINS_OF_JOINTS: [usize; FINGER_PINS] = [0, 2, 1, 3, 4];

/// Forces in the joints during the last step. Without contacts they change linearly between the nodes; those of contacts
/// follow from the contact forces of a sample, so that joint and contact forces of a sample belong together.
#[derive(Default)]
pub(super) struct JointForces {
    is_required: bool,
    /// Forces without contacts at the start of the step.
    start: Vec<Twist>,
    joints: JointReactions,
}

impl JointForces {
    pub(super) fn new(is_required: bool, motion: &mut Motion) -> Self {
        let mut forces = Self { is_required, ..Self::default() };
        forces.update(motion);
        forces.start.clone_from(&forces.joints.free);
        forces
    }

    /// Reads the forces after a step.
    pub(super) fn update(&mut self, motion: &mut Motion) {
        if self.is_required {
            self.start.clone_from(&self.joints.free);
            motion.read_joint_forces(&mut self.joints);
        }
    }

    /// Sets the joint forces of a sample within the last step, or at its end; they stay 0 if they are not required.
    pub(super) fn set(&self, motion: &Motion, sample: &mut Sample) {
        if !self.is_required {
            return;
        }
        let fraction = match motion.last_dt_s {
            dt if dt > 0.0 => 1.0 - (motion.clock.now() - sample.time_s) / dt,
            _ => 1.0,
        };
        let frame = PalmFrame::at(motion.plan, sample.time_s);
        let reaction = |sample: &Sample, joint: usize| {
            let (start, end) = (self.start[joint], self.joints.free[joint]);
            let mut force: Twist = std::array::from_fn(|k| start[k] + fraction * (end[k] - start[k]));
            for (index, channel) in self.joints.channels.iter().enumerate() {
                let (contact, [normal, tangent]) = (sample.contact(*channel), self.joints.response(index, joint));
                for k in 0..3 {
                    force[k] += contact.normal_n * normal[k] + contact.tangential_n * tangent[k];
                }
            }
            force
        };
        for finger in 0..sample.counts().fingers {
            let force_n = |pin: usize| {
                let [x, y, _] = reaction(sample, FINGER_PINS * finger + pin);
                frame.direction([x, y])
            };
            let forces_n = PINS_OF_JOINTS.map(force_n);
            sample.set_joint_forces(finger, &forces_n);
        }
        if sample.counts().fingers == 0 {
            for joint in 0..sample.counts().joints {
                let [x, y, moment_n_m] = reaction(sample, joint);
                let state = JointState { force_n: [x, y], moment_n_m, ..sample.joint_state(joint) };
                sample.set_joint(joint, &state);
            }
        }
    }
}

/// Links of a finger in the plan: index of the first link, and −1 for a mirrored finger.
#[derive(Clone, Copy)]
struct Links {
    first: usize,
    mirror: f64,
    /// Angle of the base of the finger, and its two time derivatives.
    base_rotation: [f64; 3],
}

impl Links {
    /// Returns the links of the finger on a side, mounted on a palm with the motion of `frame`.
    fn new(side: Side, frame: &PalmFrame) -> Self {
        Self { first: first_link(side), mirror: side.mirror(), base_rotation: frame.angular_motion() }
    }

    /// Reads the state of the finger.
    ///
    /// The angles of bodies count whole turns, but the passive angles of the analytic model do not. For the same values
    /// here, q12 is the equivalent nearest to the angle from l11 to l12, and q22 the one nearest to the bend q22 + φ22
    /// (with a branch cut at −90°) minus φ22.
    fn read(self, motion: &Motion, phi22_rad: f64, motor_torque_n_m: f64) -> FingerState {
        let poses = &motion.linkage.poses;
        let rate = |link: usize| self.mirror * (motion.velocities[self.first + link][2] - self.base_rotation[1]);
        let angle = |link: usize| {
            let angle = poses[self.first + link].angle - self.base_rotation[0];
            if self.mirror > 0.0 { angle } else { PI - angle }
        };
        let direction = |link: usize| {
            let [x, y] = poses[self.first + link].direction;
            [self.mirror * x, y]
        };
        let (sin, cos) = sin_cos(phi22_rad);
        let bend = opening_angle(direction(L21), rotate(direction(L22), [cos, sin]));
        let q12_rad = nearest_equivalent_angle(angle(L12) - angle(L11), angle_between(direction(L11), direction(L12)));
        let q22_rad = nearest_equivalent_angle(angle(L22) - angle(L21), bend - phi22_rad);
        FingerState {
            q11_rad: angle(L11),
            q21_rad: angle(L21),
            q12_rad,
            q22_rad,
            q13_rad: angle(L21) + q22_rad,
            qd11_rad_s: rate(L11),
            qd21_rad_s: rate(L21),
            qd12_rad_s: rate(L12) - rate(L11),
            qd22_rad_s: rate(L22) - rate(L21),
            motor_torque_n_m,
        }
    }

    /// Extrapolates angles and rates over a time at constant accelerations of all bodies.
    fn extrapolate(self, from: &FingerState, time_s: f64, accelerations: &[Twist]) -> FingerState {
        let [a11, a12, a21, a22] = [L11, L12, L21, L22]
            .map(|link| self.mirror * (accelerations[self.first + link][2] - self.base_rotation[2]));
        let angle = |q: f64, rate: f64, a: f64| q + time_s * (rate + 0.5 * time_s * a);
        let q21_rad = angle(from.q21_rad, from.qd21_rad_s, a21);
        let q22_rad = angle(from.q22_rad, from.qd22_rad_s, a22 - a21);
        FingerState {
            q11_rad: angle(from.q11_rad, from.qd11_rad_s, a11),
            q21_rad,
            q12_rad: angle(from.q12_rad, from.qd12_rad_s, a12 - a11),
            q22_rad,
            q13_rad: q21_rad + q22_rad,
            qd11_rad_s: from.qd11_rad_s + time_s * a11,
            qd21_rad_s: from.qd21_rad_s + time_s * a21,
            qd12_rad_s: from.qd12_rad_s + time_s * (a12 - a11),
            qd22_rad_s: from.qd22_rad_s + time_s * (a22 - a21),
            motor_torque_n_m: from.motor_torque_n_m,
        }
    }
}
