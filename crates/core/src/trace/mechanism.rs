//! Builds the analytic model of a mechanism, and converts its states to samples.

use super::reading::{Kernel, KernelUser, Start, contact_sample, stored_energy};
use super::sample::DriveState;
use super::schema::{CableElementState, DistanceState, MotorState, ShaftState, TendonState};
use super::{BodyState, ContactSample, Energy, Exit, JointState, Outcome, RequiredData, RunError, Sample};
use crate::analytic::mechanism::{ElementReading, JointForces, MechanismMode, MechanismModel};
use crate::drive::Profile;
use crate::integrator::{Dynamic, State};
use crate::mechanism::structure::StructureError;
use crate::mechanism::{Mechanism, assemble};
use crate::scene::Scene;

/// Builds the model of a mechanism.
pub(super) fn build_mechanism<U: KernelUser>(
    scene: &Scene,
    mechanism: &Mechanism,
    user: U,
) -> Result<U::Output, RunError> {
    let rejected = |reason: String| RunError::rejected(reason, Outcome::default());
    let start = assemble(mechanism).map_err(|error| rejected(error.to_string()))?;
    let kernel = MechanismModel::new(mechanism, (&start.poses, &start.rates))
        .map_err(|error: StructureError| rejected(error.to_string()))?;
    let (state, settings, exit) = (kernel.start(), scene.integrator, Exit::from_scene(scene));
    Ok(user.use_kernel(Start { kernel, state, settings, exit }))
}

impl Kernel for MechanismModel {
    type History = JointForces;

    fn read(
        &self,
        (state, mode): (&State<Dynamic>, &MechanismMode),
        start: &Energy,
        required_data: RequiredData,
        joint_forces: &mut Self::History,
        sample: &mut Sample,
    ) {
        let (model, t, counts, qv) = (self, sample.time_s, sample.counts(), (&state.q, &state.v));
        let contacts = model.contact_count();
        model.count_turns_as(mode);
        if required_data.joint_forces {
            model.joint_forces(t, qv, mode, joint_forces);
        }
        model.read_joints(qv, |index, (angle_rad, rate_rad_s)| {
            let force = joint_forces.forces.get(index).copied().unwrap_or_default();
            let (force_n, moment_n_m) = (force.force_n, force.moment_n_m);
            sample.set_joint(index, &JointState { angle_rad, rate_rad_s, force_n, moment_n_m });
        });
        match required_data.passive {
            true => model.read_actuators(t, qv, mode, |index, effort| sample.set_actuator(index, effort)),
            false => (0..counts.actuators).for_each(|index| sample.set_actuator(index, 0.0)),
        }
        for index in 0..counts.tendons {
            let [length_m, rate_m_s, tension_n] = model.tendon(t, qv, mode, index);
            sample.set_tendon(index, &TendonState { length_m, rate_m_s, tension_n });
        }
        model.read_drives(t, qv, mode, |drives| {
            sample.set_drives(drives.map(|(powertrain, reading)| {
                let loss_j = reading.loss_work.map_or(0.0, |work| state.z[work]);
                let drive = DriveState {
                    shaft: ShaftState { motor_torque_n_m: reading.torque_n_m, loss_j },
                    motor: MotorState { voltage_v: reading.voltage_v, current_a: reading.current_a },
                    distance: DistanceState {
                        distance_m: reading.distance_m,
                        distance_rate_m_s: reading.distance_rate_m_s,
                    },
                };
                (powertrain, drive)
            }));
        });
        match required_data.passive {
            true => model.read_elements(t, qv, mode, |index, ElementReading { is_on, turn, gap, slip, tension }| {
                let state = CableElementState {
                    on: f64::from(u8::from(is_on)),
                    wrap_rad: turn.max(0.0),
                    gap_m: gap,
                    // The sum has no negative zero.
                    slip_m_s: slip + 0.0,
                    tension_n: tension,
                };
                sample.set_cable_element(index, &state);
            }),
            false => {
                (0..counts.elements).for_each(|index| sample.set_cable_element(index, &CableElementState::default()));
            }
        }
        model.read_bodies(qv, |index, ([x, y, angle_rad], [vx, vy, spin_rad_s])| {
            sample.set_body(index, &BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s });
        });
        model.read_contacts(qv, mode, counts.contacts, |index, reading| {
            sample.set_contact(index, &contact_sample(Some(&reading), state.z[index]));
        });
        sample.set_energy(&match required_data.energies {
            true => {
                let work = state.z[contacts + 1] + model.frame_work(qv);
                let gap = |index: usize| (index < counts.contacts).then(|| sample.contact(index).gap_m);
                let stored = stored_energy(&model.energies_at_gaps(qv, gap));
                // The difference from zero has no negative zero.
                let cable_friction_j = model.cable_quadrature().map_or(0.0, |index| 0.0 - state.z[index]);
                Energy { cable_friction_j, ..stored.relative_to(start, state.z[contacts], work) }
            }
            false => Energy::default(),
        });
    }

    fn is_slipping(&self, index: usize, mode: &MechanismMode) -> Option<bool> {
        mode.contacts.is_slipping(index).filter(|_| self.has_stiction(index))
    }

    fn contact_count(&self) -> usize {
        self.contact_count()
    }

    fn contact(&self, state: &State<Dynamic>, index: usize, mode: &MechanismMode) -> ContactSample {
        self.count_turns_as(mode);
        let reading = self.contact_reading((&state.q, &state.v), index, mode[index]);
        contact_sample(Some(&reading), state.z[index])
    }

    fn set_input(
        &mut self,
        index: usize,
        input: Profile,
        t: f64,
        (state, mode): (&mut State<Dynamic>, &mut MechanismMode),
    ) {
        self.set_input(index, input, t, (&mut state.q, &mut state.v), mode);
    }

    fn remove_contacts(&mut self, contacts: &[usize], (state, mode): (&mut State<Dynamic>, &mut MechanismMode)) {
        self.remove_contacts(contacts, &mut state.v, mode);
    }

    fn conditioning(&self, state: &State<Dynamic>, mode: &MechanismMode) -> f64 {
        self.conditioning((&state.q, &state.v), mode)
    }

    fn exchanged(&self, state: &State<Dynamic>, mode: &MechanismMode) -> Option<(Self, State<Dynamic>, MechanismMode)> {
        let (kernel, (q, v), mode) = self.exchanged((&state.q, &state.v), mode)?;
        Some((kernel, State { q, v, z: state.z.clone() }, mode))
    }

    fn in_coordinates_of(
        &self,
        other: &Self,
        state: &State<Dynamic>,
        mode: &MechanismMode,
    ) -> Option<(Self, State<Dynamic>, MechanismMode)> {
        let (kernel, (q, v), mode) = self.in_coordinates_of(other, (&state.q, &state.v), mode)?;
        Some((kernel, State { q, v, z: state.z.clone() }, mode))
    }

    fn has_coordinates_of(&self, other: &Self) -> bool {
        self.has_coordinates_of(other)
    }
}
