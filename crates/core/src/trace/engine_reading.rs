//! Converts nodes of the engine model to samples.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::schema::{JointState, TendonState};
use super::{BodyState, ContactSample, Energy, Sample};
use crate::engine::{
    ContactCandidate, JointReactions, Motion, PalmFrame, PlannedActuator, Twist, kinetic_energy, potential_energies,
};
use crate::law::{elastic_energy, normal_force};
use crate::numeric::plane::{perp, rotate, scale, sub};
use crate::scene::{HandContact, Object, ObjectMotion, Scene, Side};

/// Links and joints of a finger in the plan, which start with those of the fingers.
const LINKS: usize = 4;
const FINGER_PINS: usize = 5;
/// Joints of the plan for those of a finger, in the order of its samples.
const PINS_OF_JOINTS: [usize; FINGER_PINS] = [0, 2, 1, 3, 4];
/// Joints q21, q12, q22 and q13 in samples of a finger.
const Q21: usize = 1;
const Q12: usize = 2;
const Q22: usize = 3;
const Q13: usize = 4;

/// Joint of the plan for a joint of a sample.
fn planned_joint(sample: &Sample, joint: usize) -> usize {
    match sample.counts().fingers {
        0 => joint,
        _ => joint - joint % FINGER_PINS + PINS_OF_JOINTS[joint % FINGER_PINS],
    }
}

/// Body of the plan of each body of a sample, or the object if it does not move.
fn reported_bodies<'a>(scene: &'a Scene, sample: &Sample) -> impl Iterator<Item = Result<usize, &'a Object>> + use<'a> {
    let fixed = scene.object().filter(|object| object.motion == ObjectMotion::Fixed);
    let first = LINKS * scene.hand.fingers.len();
    (0..sample.counts().bodies).map(move |index| fixed.map_or(Ok(first + index), Err))
}

/// Reads joints, actuators and bodies of a scene at a node of its motion, relative to a moving palm.
pub(super) fn read_state(scene: &Scene, motion: &Motion, sample: &mut Sample) {
    let (plan, state) = (&motion.plan, (&motion.linkage.poses[..], &motion.velocities[..]));
    let frame = PalmFrame::at(plan, motion.clock.now());
    for index in 0..sample.counts().joints {
        let coordinate = plan.joint_coordinate(&plan.joints[planned_joint(sample, index)]);
        let (angle_rad, rate_rad_s) = (coordinate.value(state.0), coordinate.row(state.0).rate(state.1));
        sample.set_joint(index, &JointState { angle_rad, rate_rad_s, ..sample.joint_state(index) });
    }
    for (finger, (_, of)) in scene.hand.fingers_by_side().enumerate() {
        // Angles of bodies count whole turns, but the passive angles of the analytic model do not.
        for (joint, lowest_rad) in [(Q12, -PI), (Q22, -FRAC_PI_2 - of.linkage.lengths.phi22_rad)] {
            let index = FINGER_PINS * finger + joint;
            let joint = sample.joint_state(index);
            let turns = ((joint.angle_rad - lowest_rad) / TAU).floor();
            sample.set_joint(index, &JointState { angle_rad: joint.angle_rad - TAU * turns, ..joint });
        }
        set_orientation_of_l22(sample, finger);
    }
    let effort = |index: usize| {
        let brakes = plan.brakes.iter().enumerate().filter(|(_, brake)| brake.actuator == Some(index));
        let brake_torque: f64 = brakes.map(|(brake, _)| motion.brake_torque(brake)).sum();
        plan.effort(plan.actuators[index], motion.clock.now(), state) + brake_torque
    };
    for index in 0..sample.counts().actuators {
        // The actuator of a finger stands for the torque of all on q11, which turns a mirrored link by −1.
        let on_link = |actuator: usize| {
            let ratio = plan.shaft(plan.actuators[actuator]).angle_ratio(LINKS * index);
            Side::BOTH[index].mirror() * ratio * effort(actuator)
        };
        sample.set_actuator(
            index,
            match sample.counts().fingers {
                0 => effort(index),
                _ => (0..plan.actuators.len()).map(on_link).sum(),
            },
        );
    }
    for (index, tendon) in plan.tendons.iter().enumerate() {
        let spring = tendon.stop.and_then(|stop| motion.candidate(stop)).map_or(0.0, |stop| motion.normal_force(stop));
        let pull =
            tendon.motor.map_or(0.0, |motor| plan.effort(PlannedActuator::Motor(motor), motion.clock.now(), state));
        let (length_m, rate_m_s) = (tendon.length.value(state.0), tendon.length.row(state.0).rate(state.1));
        sample.set_tendon(index, &TendonState { length_m, rate_m_s, tension_n: spring + pull });
    }
    for (index, body) in reported_bodies(scene, sample).enumerate() {
        let state = match body {
            Ok(body) => {
                // A body is reported by its frame.
                let (pose, v) = (&state.0[body], &state.1[body]);
                let arm = rotate(plan.bodies[body].body.com_m, pose.direction);
                let [x, y] = sub([v[0], v[1]], scale(perp(arm), v[2]));
                let origin = sub(pose.com, arm);
                let [vx, vy, spin_rad_s] = frame.twist(origin, &[x, y, v[2]]);
                let angle_rad = pose.angle - frame.angular_motion()[0];
                BodyState { centre_m: frame.point(origin), angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
            }
            Err(object) => BodyState { centre_m: object.centre_m, angle_rad: object.angle_rad, ..BodyState::default() },
        };
        sample.set_body(index, &state);
    }
}

/// Sets the angle of q13, which in samples of a finger is the orientation of l22.
fn set_orientation_of_l22(sample: &mut Sample, finger: usize) {
    let [q21, q22, q13] = [Q21, Q22, Q13].map(|joint| sample.joint_state(FINGER_PINS * finger + joint));
    let (angle_rad, rate_rad_s) = (q21.angle_rad + q22.angle_rad, q21.rate_rad_s + q22.rate_rad_s);
    sample.set_joint(FINGER_PINS * finger + Q13, &JointState { angle_rad, rate_rad_s, ..q13 });
}

/// Sets coordinates and rates of `sample` by extrapolating from `from`, within the last step of `motion`: to a change, with
/// the forces of contacts, if `from` is the start of the step; otherwise freely.
pub(super) fn extrapolate(
    scene: &Scene,
    sample: &mut Sample,
    from: &Sample,
    motion: &Motion,
    change_from_start: Option<usize>,
) {
    let (plan, poses, velocities) = (&motion.plan, &motion.linkage.poses, &motion.velocities);
    let time_s = sample.time_s - from.time_s;
    let frame = PalmFrame::at(plan, motion.clock.now());
    let [displacing, accelerating] = match change_from_start {
        Some(change) => motion.mean_accelerations(change, time_s),
        None => [(); 2].map(|()| motion.step_accelerations.clone()),
    };
    for index in 0..sample.counts().joints {
        let coordinate = plan.joint_coordinate(&plan.joints[planned_joint(sample, index)]);
        let state = from.joint_state(index);
        let (row, at_rates) = (coordinate.row(poses), coordinate.second_rate(poses, velocities));
        let [a, a_of_rate] = [&displacing, &accelerating].map(|accelerations| row.rate(accelerations) + at_rates);
        let angle_rad = state.angle_rad + time_s * (state.rate_rad_s + 0.5 * time_s * a);
        sample.set_joint(index, &JointState { angle_rad, rate_rad_s: state.rate_rad_s + time_s * a_of_rate, ..state });
    }
    (0..sample.counts().fingers).for_each(|finger| set_orientation_of_l22(sample, finger));
    for (index, body) in reported_bodies(scene, sample).enumerate() {
        let Ok(body) = body else { continue };
        let (v, arm) = (velocities[body], rotate(plan.bodies[body].body.com_m, poses[body].direction));
        let [displaced, accelerated] = [&displacing, &accelerating].map(|accelerations| {
            let [ax, ay, angular] = accelerations[body];
            let [x, y] = sub([ax, ay], sub(scale(perp(arm), angular), scale(arm, v[2] * v[2])));
            let [vx, vy] = sub([v[0], v[1]], scale(perp(arm), v[2]));
            let acceleration = frame.acceleration(sub(poses[body].com, arm), &[vx, vy, v[2]], &[x, y, angular]);
            from.body(index).extrapolate(time_s, &acceleration)
        });
        let BodyState { velocity_m_s, spin_rad_s, .. } = accelerated;
        sample.set_body(index, &BodyState { velocity_m_s, spin_rad_s, ..displaced });
    }
}

/// Contacts whose sampled normal is opposite to that of the plan, which points to the first of its bodies: next to
/// fingers, sampled normals of palm and table point away from the object. In a mechanism they point away from the
/// face.
pub(super) fn flipped_normals(scene: &Scene) -> Vec<bool> {
    if let Some(mechanism) = &scene.mechanism {
        let points = mechanism.point_contacts();
        return points
            .iter()
            .map(|point| !mechanism.points_are_first(&mechanism.contacts[point.pair]))
            .chain(mechanism.limits().iter().map(|_| false))
            .collect();
    }
    scene.hand.contacts().map(|contact| matches!(contact, HandContact::Palm | HandContact::Table)).collect()
}

/// Returns the stored energies of the node.
pub(super) fn stored_energy(motion: &Motion) -> Energy {
    let frame = PalmFrame::at(&motion.plan, motion.clock.now());
    let (gravity_j, spring_j) = potential_energies(&motion.plan, &motion.linkage, &frame);
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
pub(super) fn sample_contact(
    motion: &Motion,
    frame: &PalmFrame,
    index: Option<usize>,
    impulse_n_s: f64,
) -> ContactSample {
    let candidate = index.and_then(|index| motion.candidate(index));
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

/// Forces in the joints during the last step. Without contacts they change linearly between the nodes; those of contacts
/// follow from the contact forces of a sample, so that joint and contact forces of a sample belong together.
#[derive(Clone, Default)]
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
        let frame = PalmFrame::at(&motion.plan, sample.time_s);
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
        for joint in 0..sample.counts().joints {
            let planned = planned_joint(sample, joint);
            let [x, y, moment_n_m] = reaction(sample, planned);
            // The force on the second body of a joint; in a finger, on the link, which is the second in the plan.
            let is_reversed = sample.counts().fingers == 0 && motion.plan.joints[planned].is_reversed;
            let force_n = frame.direction(if is_reversed { [-x, -y] } else { [x, y] });
            let state = JointState { force_n, moment_n_m, ..sample.joint_state(joint) };
            sample.set_joint(joint, &state);
        }
    }
}
