//! Samples of the multibody kernel of the analytic model.

use super::{Reader, contact_sample, refill, stored_energy};
use crate::analytic::multibody::Multibody;
use crate::analytic::{Mode, PassiveJoints};
use crate::integrator::State;
use crate::scene::System;
use crate::trace::{BodyState, ContactSample, Energy, FingerState, RequiredData, Sample};

/// A model, and its system, which defines the layout of the samples.
pub struct SystemReader<'a, const N: usize, const C: usize> {
    pub model: &'a Multibody<N, C>,
    pub system: &'a System,
}

impl<const N: usize, const C: usize, const Z: usize> Reader<N, Z> for SystemReader<'_, N, C> {
    type Mode = Mode<C>;

    fn read(
        &self,
        t: f64,
        state: &State<N, Z>,
        mode: &Mode<C>,
        start: &Energy,
        required_data: RequiredData,
        sample: &mut Sample,
    ) {
        let (model, State { q, v, z }) = (self.model, state);
        let torques = if required_data.passive { model.motor_torques(t, v) } else { [0.0; 2] };
        let finger = |finger: usize| {
            let passive =
                if required_data.passive { model.passive_joints(finger, q, v) } else { PassiveJoints::default() };
            let first = 2 * finger;
            FingerState {
                q11_rad: q[first],
                q21_rad: q[first + 1],
                q12_rad: passive.q12,
                q22_rad: passive.q22,
                q13_rad: passive.q13,
                qd11_rad_s: v[first],
                qd21_rad_s: v[first + 1],
                qd12_rad_s: passive.qd12,
                qd22_rad_s: passive.qd22,
                motor_torque_n_m: torques[finger],
            }
        };
        let disc = |disc: usize| {
            let ([x, y, angle_rad], [vx, vy, spin_rad_s]) = (model.disc_pose(disc, q), model.disc_rates(disc, v));
            BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
        };
        sample.time_s = t;
        refill(&mut sample.fingers, (0..self.system.fingers.len()).map(finger));
        refill(&mut sample.bodies, (0..self.system.reported_discs().len()).map(disc));
        refill(&mut sample.contacts, (0..model.contact_count()).map(|contact| self.contact(state, contact, mode)));
        sample.energy = if required_data.energies {
            stored_energy(&model.energies(q, v)).relative_to(start, z[C], z[C + 1])
        } else {
            Energy::default()
        };
    }

    fn is_slipping(&self, index: usize, mode: &Mode<C>) -> Option<bool> {
        mode.is_slipping(index).filter(|_| self.model.has_stiction(index))
    }

    fn contact(&self, state: &State<N, Z>, index: usize, mode: &Mode<C>) -> ContactSample {
        contact_sample(self.model.contact_reading(&state.q, &state.v, index, mode[index]), state.z[index])
    }
}
