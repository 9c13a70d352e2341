//! Turns a node of the engine model into a sample: what that is differs between kinds of scene, and nothing else does.

mod discs;
mod finger;
mod gripper;

pub(super) use finger::FingerReader;

use super::{ContactSample, Energy, Sample};
use crate::engine::{Frame, Motion, Plan, Touch, kinetic, potential};
use crate::law::{elastic_energy, normal_force};

/// Reads the nodes of a motion.
pub(super) trait EngineReader {
    /// The contact of a sample that a stop or contact of the plan is.
    fn place(&self, plan: &Plan, index: usize) -> usize;

    /// The index of a sample's contact among the stops and contacts of the plan; `None` where there is nothing to touch.
    fn index(&self, plan: &Plan, place: usize) -> Option<usize>;

    /// The normal of a contact as a sample has it, given that of the plan, which points to the first of its bodies.
    fn normal(&self, _place: usize, normal: [f64; 2]) -> [f64; 2] {
        normal
    }

    /// Fingers and bodies at the node.
    fn read(&self, motion: &Motion, sample: &mut Sample);

    /// Coordinates and rates of `sample` as free motion from `from` makes them, by the accelerations of all bodies in the last step of
    /// `motion`.
    fn fly(&self, sample: &mut Sample, from: &Sample, motion: &Motion);
}

/// The stored energies of the node.
pub(super) fn stored(motion: &Motion) -> Energy {
    let frame = Frame::at(motion.plan, motion.clock.now());
    let (gravity_j, spring_j) = potential(motion.plan, &motion.linkage, &frame);
    let governed = motion.touches.iter().filter(|touch| touch.governed && touch.has_gap());
    Energy {
        kinetic_j: kinetic(&motion.linkage, &motion.velocities, &frame),
        gravity_j,
        spring_j,
        elastic_j: governed.map(|touch| elastic_energy(&touch.law, -touch.gap)).sum::<f64>() + motion.bristle_energy(),
        ..Energy::default()
    }
}

/// A contact at the node; `index` is that of the plan.
pub(super) fn contact(motion: &Motion, index: Option<usize>, impulse_n_s: f64) -> ContactSample {
    let touch = index.and_then(|index| motion.touches.iter().find(|touch| touch.index == index));
    let frame = Frame::at(motion.plan, motion.clock.now());
    touch.map_or(ContactSample::NONE, |touch| {
        let (normal_n, tangential_n) = pressing(motion, touch);
        ContactSample {
            gap_m: touch.gap,
            gap_rate_m_s: touch.normal_row.rate(&motion.velocities),
            slip_m_s: touch.slip_row.rate(&motion.velocities),
            normal_n,
            tangential_n,
            impulse_n_s,
            point_m: if touch.is_between_surfaces() { frame.point(touch.point) } else { touch.point },
            normal: frame.along(touch.normal),
        }
    })
}

/// Normal and tangential force of a touch at the end of the last step; before the first one, from the laws themselves.
fn pressing(motion: &Motion, touch: &Touch) -> (f64, f64) {
    if motion.last_dt_s > 0.0 {
        return motion.forces(touch.index);
    }
    if !touch.governed {
        return (0.0, 0.0);
    }
    let [rate, slip] = [&touch.normal_row, &touch.slip_row].map(|row| row.rate(&motion.velocities));
    let normal = normal_force(&touch.law, -touch.gap, -rate).force;
    (normal, -touch.friction_after([slip, 0.0, normal], 0.0).pull)
}
