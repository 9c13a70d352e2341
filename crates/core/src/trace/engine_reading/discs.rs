//! Discs at a node of the engine model.

use super::EngineReader;
use crate::engine::{Motion, Plan};
use crate::scene::BodiesScene;
use crate::trace::{BodyState, Sample};

impl EngineReader for BodiesScene {
    fn place(&self, _: &Plan, index: usize) -> usize {
        index
    }

    fn index(&self, _: &Plan, pair: usize) -> Option<usize> {
        Some(pair)
    }

    fn read(&self, motion: &Motion, sample: &mut Sample) {
        // The plan's bodies are the discs that move, in their order.
        let mut bodies = motion.linkage.places.iter().zip(&motion.velocities);
        sample.bodies.clear();
        sample.bodies.extend(self.discs.iter().map(|disc| {
            let moving = if disc.motion.moves() { bodies.next() } else { None };
            moving.map_or(BodyState { centre_m: disc.centre_m, ..BodyState::default() }, |(place, v)| BodyState {
                centre_m: place.com,
                angle_rad: place.angle,
                velocity_m_s: [v[0], v[1]],
                spin_rad_s: v[2],
            })
        }));
    }

    fn fly(&self, sample: &mut Sample, from: &Sample, motion: &Motion) {
        let accelerations = &motion.step_accelerations;
        let time = sample.time_s - from.time_s;
        let moving = self.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
        for ((index, _), a) in moving.zip(accelerations) {
            sample.bodies[index] = from.bodies[index].flown(time, a);
        }
    }
}
