//! A gripper in a state of the analytic model.

use super::{Reader, contact_sample, refill, stored};
use crate::analytic::Passive;
use crate::analytic::gripper::{GripperMode, GripperModel, PLACES, QUADRATURES};
use crate::integrator::State;
use crate::scene::{Place, Side};
use crate::trace::{BodyState, ContactSample, Energy, FingerState, Sample, Wants};

impl<const N: usize> Reader<N, QUADRATURES> for GripperModel<N> {
    type Mode = GripperMode;

    fn read(
        &self,
        t: f64,
        state: &State<N, QUADRATURES>,
        mode: &GripperMode,
        start: &Energy,
        wants: Wants,
        sample: &mut Sample,
    ) {
        let torques = if wants.passive { self.motor_torques(t, &state.v) } else { [0.0; 2] };
        let finger = |side: Side| {
            let passive = if wants.passive { self.passive(side, &state.q, &state.v) } else { Passive::default() };
            let first = 2 * side as usize;
            FingerState {
                q11_rad: state.q[first],
                q21_rad: state.q[first + 1],
                q12_rad: passive.q12,
                q22_rad: passive.q22,
                q13_rad: passive.q13,
                qd11_rad_s: state.v[first],
                qd21_rad_s: state.v[first + 1],
                qd12_rad_s: passive.qd12,
                qd22_rad_s: passive.qd22,
                motor_torque_n_m: torques[side as usize],
            }
        };
        let ([x, y, angle_rad], [vx, vy, spin_rad_s]) = (self.object_of(&state.q), self.object_rates(&state.v));
        let object = BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s };
        sample.time_s = t;
        refill(&mut sample.fingers, Side::BOTH.into_iter().map(finger));
        refill(&mut sample.bodies, std::iter::once(object));
        refill(&mut sample.contacts, (0..PLACES).map(|place| self.contact(state, place, mode)));
        sample.energy = if wants.energies {
            stored(&self.energies(&state.q, &state.v)).since(start, state.z[PLACES], state.z[PLACES + 1])
        } else {
            Energy::default()
        };
    }

    fn slips(&self, index: usize, mode: &GripperMode) -> Option<bool> {
        mode.slips_at(index).filter(|_| self.holds(Place::ALL[index]))
    }

    fn contact(&self, state: &State<N, QUADRATURES>, index: usize, mode: &GripperMode) -> ContactSample {
        contact_sample(self.reading(&state.q, &state.v, Place::ALL[index], mode[index]), state.z[index])
    }
}
