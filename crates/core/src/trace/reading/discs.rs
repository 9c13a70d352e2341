//! Discs in a state of the analytic model.

use super::{Reader, refill};
use crate::analytic::discs::{DiscMode, Discs, PAIRS, PairReading, QUADRATURES};
use crate::integrator::State;
use crate::scene::System;
use crate::trace::{BodyState, ContactSample, Energy, Sample, Wants};

/// A model, and the system that has the discs which do not move too.
pub struct DiscsReader<'a, const N: usize, const M: usize> {
    pub model: &'a Discs<N, M>,
    pub system: &'a System,
}

impl<const N: usize, const M: usize> Reader<N, QUADRATURES> for DiscsReader<'_, N, M> {
    type Mode = DiscMode;

    fn read(
        &self,
        t: f64,
        state: &State<N, QUADRATURES>,
        mode: &DiscMode,
        start: &Energy,
        _: Wants,
        sample: &mut Sample,
    ) {
        let mut moving = state.q.chunks_exact(3).zip(state.v.chunks_exact(3));
        let discs = self.system.discs.iter().map(|disc| {
            let coordinates = if disc.motion.moves() { moving.next() } else { None };
            let at_rest = BodyState { centre_m: disc.centre_m, angle_rad: disc.angle_rad, ..BodyState::default() };
            coordinates.map_or(at_rest, |(q, v)| BodyState {
                centre_m: [q[0], q[1]],
                angle_rad: q[2],
                velocity_m_s: [v[0], v[1]],
                spin_rad_s: v[2],
            })
        });
        let energies = self.model.energies(&state.q, &state.v);
        let stored = Energy {
            kinetic_j: energies.kinetic,
            gravity_j: energies.gravity,
            elastic_j: energies.elastic,
            ..Energy::default()
        };
        sample.time_s = t;
        refill(&mut sample.bodies, discs);
        refill(&mut sample.contacts, (0..self.model.pairs()).map(|pair| self.contact(state, pair, mode)));
        sample.energy = stored.since(start, state.z[PAIRS], state.z[PAIRS + 1]);
    }

    fn slips(&self, pair: usize, mode: &DiscMode) -> Option<bool> {
        mode.slips_at(pair).filter(|_| self.system.holds())
    }

    fn contact(&self, state: &State<N, QUADRATURES>, pair: usize, mode: &DiscMode) -> ContactSample {
        let PairReading { delta, delta_rate, slip, normal_force, tangential_force, normal, point } =
            self.model.reading(&state.q, &state.v, pair, mode[pair]);
        ContactSample {
            gap_m: -delta,
            gap_rate_m_s: -delta_rate,
            slip_m_s: slip,
            normal_n: normal_force,
            tangential_n: tangential_force,
            impulse_n_s: state.z[pair],
            point_m: point,
            normal,
        }
    }
}
