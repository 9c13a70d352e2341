//! Converts nodes of the engine model to samples.

use super::sample::DriveState;
use super::schema::{CableElementState, DistanceState, JointState, MotorState, ShaftState, TendonState};
use super::{BodyState, ContactSample, Energy, Sample};
use crate::engine::{
    CableReading, ContactCandidate, JointReactions, Motion, PalmFrame, PlannedActuator, Twist, kinetic_energy,
    potential_energies,
};
use crate::law::{elastic_energy, normal_force};
use crate::numeric::plane::{perp, rotate, scale, sub};

/// Reads joints, actuators, tendons and bodies at a node of a motion, relative to a moving palm.
pub(super) fn read_state(motion: &Motion, sample: &mut Sample) {
    let (plan, state) = (&motion.plan, (&motion.linkage.poses[..], &motion.velocities[..]));
    let frame = PalmFrame::at(plan, motion.clock.now());
    for index in 0..sample.counts().joints {
        let coordinate = plan.joint_coordinate(&plan.joints[index]);
        let (angle_rad, rate_rad_s) = (coordinate.value(state.0), coordinate.row(state.0).rate(state.1));
        sample.set_joint(index, &JointState { angle_rad, rate_rad_s, ..sample.joint_state(index) });
    }
    for (index, actuator) in plan.actuators.iter().enumerate() {
        let brakes = plan.brakes.iter().enumerate().filter(|(_, brake)| brake.actuator == Some(index));
        let brake_torque: f64 = brakes.map(|(brake, _)| motion.brake_torque(brake)).sum();
        let effort = match actuator {
            PlannedActuator::Powertrain(index) => motion.powertrain(*index).effort,
            _ => plan.effort(*actuator, motion.clock.now(), state),
        };
        sample.set_actuator(index, effort + brake_torque);
    }
    sample.set_drives(plan.powertrains.iter().enumerate().map(|(index, planned)| {
        let (found, distance) = (motion.powertrain(index), planned.distance(state));
        let drive = DriveState {
            shaft: ShaftState { motor_torque_n_m: found.torque, loss_j: motion.loss_work_j[index] },
            motor: MotorState { voltage_v: found.voltage, current_a: found.current() },
            distance: DistanceState { distance_m: distance[0], distance_rate_m_s: distance[1] },
        };
        (&planned.powertrain, drive)
    }));
    for (index, tendon) in plan.tendons.iter().enumerate() {
        let (length_m, rate_m_s) = (tendon.length.value(state.0), tendon.length.row(state.0).rate(state.1));
        sample.set_tendon(index, &TendonState { length_m, rate_m_s, tension_n: motion.tension(tendon) });
    }
    for (index, reading) in motion.read_elements().enumerate() {
        let CableReading { is_on, turn, gap, slip, tension } = reading;
        let state = CableElementState {
            on: f64::from(u8::from(is_on)),
            wrap_rad: turn,
            gap_m: gap,
            // The sum has no negative zero.
            slip_m_s: slip + 0.0,
            tension_n: tension,
        };
        sample.set_cable_element(index, &state);
    }
    for (index, &body) in plan.reported_bodies.iter().enumerate() {
        // A body is reported by its frame.
        let (pose, v) = (&state.0[body], &state.1[body]);
        let arm = rotate(plan.bodies[body].body.com_m, pose.direction);
        let [x, y] = sub([v[0], v[1]], scale(perp(arm), v[2]));
        let origin = sub(pose.com, arm);
        let [vx, vy, spin_rad_s] = frame.twist(origin, &[x, y, v[2]]);
        let angle_rad = pose.angle - frame.angular_motion()[0];
        sample.set_body(
            index,
            &BodyState { centre_m: frame.point(origin), angle_rad, velocity_m_s: [vx, vy], spin_rad_s },
        );
    }
}

/// Sets coordinates and rates of `sample` by extrapolating from `from`, within the last step of `motion`: to a change, with
/// the forces of contacts, if `from` is the start of the step; otherwise freely.
pub(super) fn extrapolate(sample: &mut Sample, from: &Sample, motion: &Motion, change_from_start: Option<usize>) {
    let (plan, poses, velocities) = (&motion.plan, &motion.linkage.poses, &motion.velocities);
    let time_s = sample.time_s - from.time_s;
    let frame = PalmFrame::at(plan, motion.clock.now());
    let [displacing, accelerating] = match change_from_start {
        Some(change) => motion.mean_accelerations(change, time_s),
        None => [(); 2].map(|()| motion.step_accelerations.clone()),
    };
    for index in 0..sample.counts().joints {
        let coordinate = plan.joint_coordinate(&plan.joints[index]);
        let state = from.joint_state(index);
        let (row, at_rates) = (coordinate.row(poses), coordinate.second_rate(poses, velocities));
        let [a, a_of_rate] = [&displacing, &accelerating].map(|accelerations| row.rate(accelerations) + at_rates);
        let angle_rad = state.angle_rad + time_s * (state.rate_rad_s + 0.5 * time_s * a);
        sample.set_joint(index, &JointState { angle_rad, rate_rad_s: state.rate_rad_s + time_s * a_of_rate, ..state });
    }
    for (index, &body) in plan.reported_bodies.iter().enumerate() {
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
            + motion.friction_energy(),
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
        let normal = match motion.plan.is_reported_on_partner(candidate.index) {
            true => [-candidate.normal[0], -candidate.normal[1]],
            false => candidate.normal,
        };
        let (normal_n, tangential_n) = contact_forces(motion, candidate);
        ContactSample {
            gap_m: candidate.gap,
            gap_rate_m_s: candidate.normal_row.rate(&motion.velocities),
            slip_m_s: candidate.slip_row.rate(&motion.velocities),
            normal_n,
            tangential_n,
            impulse_n_s,
            point_m: if candidate.is_between_surfaces() { frame.point(candidate.point) } else { candidate.point },
            normal: frame.direction(normal),
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
            let [x, y, moment_n_m] = reaction(sample, joint);
            // The force on the second body of a joint.
            let is_reversed = motion.plan.joints[joint].is_reversed;
            let force_n = frame.direction(if is_reversed { [-x, -y] } else { [x, y] });
            let state = JointState { force_n, moment_n_m, ..sample.joint_state(joint) };
            sample.set_joint(joint, &state);
        }
    }
}
