//! Turns a node of the engine model of discs into a sample.

use super::{BodiesSample, DiscState};
use crate::engine::{Motion, Plan, Twist};
use crate::scene::BodiesScene;
use crate::trace::Energy;
use crate::trace::engine_reading::{EngineReader, contact};

impl EngineReader for BodiesScene {
    type Sample = BodiesSample;

    fn place(&self, _: &Plan, index: usize) -> usize {
        index
    }

    fn index(&self, _: &Plan, pair: usize) -> Option<usize> {
        Some(pair)
    }

    fn sample(&self, motion: &Motion, energy: Energy, impulses: &[f64]) -> BodiesSample {
        // The plan's bodies are the discs that move, in their order.
        let mut bodies = motion.linkage.places.iter().zip(&motion.velocities);
        let discs = self.discs.iter().map(|disc| {
            let moving = if disc.motion.moves() { bodies.next() } else { None };
            moving.map_or(DiscState { centre_m: disc.centre_m, ..DiscState::default() }, |(place, v)| DiscState {
                centre_m: place.com,
                angle_rad: place.angle,
                velocity_m_s: [v[0], v[1]],
                spin_rad_s: v[2],
            })
        });
        BodiesSample {
            time_s: motion.clock.now(),
            discs: discs.collect(),
            contacts: impulses
                .iter()
                .enumerate()
                .map(|(pair, impulse)| contact(motion, Some(pair), *impulse))
                .collect(),
            energy,
        }
    }

    fn fly(&self, sample: &mut BodiesSample, from: &BodiesSample, accelerations: &[Twist]) {
        let time = sample.time_s - from.time_s;
        let moving = self.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
        for ((index, _), a) in moving.zip(accelerations) {
            let (from, to) = (&from.discs[index], &mut sample.discs[index]);
            let free = |axis: usize| {
                let rate = from.velocity_m_s[axis];
                [from.centre_m[axis] + time * (rate + 0.5 * time * a[axis]), rate + time * a[axis]]
            };
            let [[x, vx], [y, vy]] = [free(0), free(1)];
            (to.centre_m, to.velocity_m_s) = ([x, y], [vx, vy]);
            to.angle_rad = from.angle_rad + time * (from.spin_rad_s + 0.5 * time * a[2]);
            to.spin_rad_s = from.spin_rad_s + time * a[2];
        }
    }

    fn take_rates(&self, sample: &mut BodiesSample, from: &BodiesSample) {
        for (state, from) in sample.discs.iter_mut().zip(&from.discs) {
            (state.velocity_m_s, state.spin_rad_s) = (from.velocity_m_s, from.spin_rad_s);
        }
    }
}
