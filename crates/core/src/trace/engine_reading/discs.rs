//! Discs at a node of the engine model.

use super::EngineReader;
use crate::engine::{Motion, Plan, Twist};
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

    fn fly(&self, sample: &mut Sample, from: &Sample, accelerations: &[Twist]) {
        let time = sample.time_s - from.time_s;
        let moving = self.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
        for ((index, _), a) in moving.zip(accelerations) {
            let (from, to) = (&from.bodies[index], &mut sample.bodies[index]);
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
}
