//! Fingers and discs in a state of the analytic model.

use super::{Reader, contact_sample, refill, stored};
use crate::analytic::multibody::Multibody;
use crate::analytic::{Mode, Passive};
use crate::integrator::State;
use crate::scene::System;
use crate::trace::{BodyState, ContactSample, Energy, FingerState, Sample, Wants};

/// A model, and the system that says what samples tell of.
pub struct SystemReader<'a, const N: usize, const C: usize> {
    pub model: &'a Multibody<N, C>,
    pub system: &'a System,
}

impl<const N: usize, const C: usize, const Z: usize> Reader<N, Z> for SystemReader<'_, N, C> {
    type Mode = Mode<C>;

    fn read(&self, t: f64, state: &State<N, Z>, mode: &Mode<C>, start: &Energy, wants: Wants, sample: &mut Sample) {
        let (model, State { q, v, z }) = (self.model, state);
        let torques = if wants.passive { model.motor_torques(t, v) } else { [0.0; 2] };
        let finger = |finger: usize| {
            let passive = if wants.passive { model.passive(finger, q, v) } else { Passive::default() };
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
            let ([x, y, angle_rad], [vx, vy, spin_rad_s]) = (model.place_of(disc, q), model.rates_of(disc, v));
            BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
        };
        sample.time_s = t;
        refill(&mut sample.fingers, (0..self.system.fingers.len()).map(finger));
        refill(&mut sample.bodies, (0..self.system.told_discs().len()).map(disc));
        refill(&mut sample.contacts, (0..model.contacts()).map(|contact| self.contact(state, contact, mode)));
        sample.energy =
            if wants.energies { stored(&model.energies(q, v)).since(start, z[C], z[C + 1]) } else { Energy::default() };
    }

    fn slips(&self, index: usize, mode: &Mode<C>) -> Option<bool> {
        mode.slips_at(index).filter(|_| self.model.holds(index))
    }

    fn contact(&self, state: &State<N, Z>, index: usize, mode: &Mode<C>) -> ContactSample {
        contact_sample(self.model.reading(&state.q, &state.v, index, mode[index]), state.z[index])
    }
}
