//! Turns a node of the engine model of discs into a sample.

use super::{BodiesSample, DiscState};
use crate::engine::{Motion, kinetic, potential};
use crate::scene::BodiesScene;
use crate::trace::engine_reading::{elastic, pressing};
use crate::trace::{ContactSample, Energy};

/// Energies at the start of the run, from which works and losses count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    kinetic: f64,
    gravity: f64,
    elastic: f64,
}

impl Start {
    pub fn new(motion: &Motion) -> Self {
        let (gravity, _) = potential(motion.plan, &motion.linkage);
        Self { kinetic: kinetic(&motion.linkage, &motion.velocities), gravity, elastic: elastic(motion) }
    }
}

/// Everything about the node; `impulses` are those of the pairs since the start.
pub(super) fn sample(scene: &BodiesScene, motion: &Motion, start: &Start, impulses: &[f64]) -> BodiesSample {
    // The plan's bodies are the discs that move, in their order.
    let mut bodies = motion.linkage.places.iter().zip(&motion.velocities);
    let discs = scene.discs.iter().map(|disc| {
        let moving = if disc.motion.moves() { bodies.next() } else { None };
        moving.map_or(DiscState { centre_m: disc.centre_m, ..DiscState::default() }, |(place, v)| DiscState {
            centre_m: place.com,
            angle_rad: place.angle,
            velocity_m_s: [v[0], v[1]],
            spin_rad_s: v[2],
        })
    });
    let now = Start::new(motion);
    let gained = (now.kinetic - start.kinetic) + (now.gravity - start.gravity);
    BodiesSample {
        time_s: motion.clock.now(),
        discs: discs.collect(),
        contacts: impulses.iter().enumerate().map(|(pair, impulse)| contact(motion, pair, *impulse)).collect(),
        energy: Energy {
            kinetic_j: now.kinetic,
            gravity_j: now.gravity,
            spring_j: 0.0,
            elastic_j: now.elastic,
            dissipated_j: start.elastic - now.elastic - motion.contact_work_j,
            motor_work_j: motion.motor_work_j,
            balance_j: gained - motion.contact_work_j - motion.motor_work_j,
        },
    }
}

fn contact(motion: &Motion, pair: usize, impulse_n_s: f64) -> ContactSample {
    let Some(touch) = motion.touches.iter().find(|touch| touch.index == pair) else { return ContactSample::NONE };
    let (normal_n, tangential_n) = pressing(motion, touch);
    ContactSample {
        gap_m: touch.gap,
        gap_rate_m_s: touch.normal_row.rate(&motion.velocities),
        slip_m_s: touch.slip_row.rate(&motion.velocities),
        normal_n,
        tangential_n,
        impulse_n_s,
        point_m: touch.point,
        normal: touch.normal,
    }
}
