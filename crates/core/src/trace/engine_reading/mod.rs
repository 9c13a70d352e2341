//! Turns a node of the engine model into a sample.

mod links;

use super::{BodyState, ContactSample, Energy, Sample};
use crate::engine::{Frame, L11, LINKS, Motion, Touch, base, brake_torque, kinetic, potential};
use crate::law::{elastic_energy, normal_force};
use crate::scene::{Disc, Side, System, Touching};
use links::Links;

/// Fingers and bodies of a system at a node of its motion.
pub(super) fn read(system: &System, motion: &Motion, sample: &mut Sample) {
    let frame = Frame::at(motion.plan, motion.clock.now());
    sample.fingers.clear();
    sample.fingers.extend(system.sided().map(|(side, finger)| {
        let rate = |body: usize| motion.velocities[body][2];
        let torque = motion.plan.motor_torque(base(side) + L11, motion.clock.now(), rate);
        let brakes = brake_torque(motion.plan, side, |hold| motion.hold_torque(hold));
        let phi22_rad = finger.linkage.lengths.phi22_rad;
        Links::of(side, &frame).read(motion, phi22_rad, side.mirror() * torque + brakes)
    }));
    sample.bodies.clear();
    sample.bodies.extend(told(system).map(|(disc, body)| match body {
        Some(body) => {
            let (place, v) = (&motion.linkage.places[body], &motion.velocities[body]);
            let ([vx, vy, spin_rad_s], centre_m) = (frame.twist(place.com, v), frame.point(place.com));
            let angle_rad = place.angle - frame.turning()[0];
            BodyState { centre_m, angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
        }
        None => BodyState { centre_m: disc.centre_m, angle_rad: disc.angle_rad, ..BodyState::default() },
    }));
}

/// Coordinates and rates of `sample` as free motion from `from` makes them, by the accelerations of all bodies in the last step of
/// `motion`.
pub(super) fn fly(system: &System, sample: &mut Sample, from: &Sample, motion: &Motion) {
    let accelerations = &motion.step_accelerations;
    let time_s = sample.time_s - from.time_s;
    let frame = Frame::at(motion.plan, motion.clock.now());
    for (side, (finger, from)) in Side::BOTH.into_iter().zip(sample.fingers.iter_mut().zip(&from.fingers)) {
        Links::of(side, &frame).fly(finger, from, time_s, accelerations);
    }
    for ((body, from), (_, moving)) in sample.bodies.iter_mut().zip(&from.bodies).zip(told(system)) {
        if let Some(index) = moving {
            let (place, v) = (&motion.linkage.places[index], &motion.velocities[index]);
            *body = from.flown(time_s, &frame.acceleration(place.com, v, &accelerations[index]));
        }
    }
}

/// The discs that samples tell of, and which body of the plan each is: `None` where it does not move.
fn told(system: &System) -> impl Iterator<Item = (&Disc, Option<usize>)> {
    let mut next = LINKS * system.fingers.len();
    system.told_discs().iter().map(move |disc| {
        let body = disc.motion.moves().then_some(next);
        next += usize::from(disc.motion.moves());
        (disc, body)
    })
}

/// Which contacts have the normal turned round that the plan has, which points to the first of its bodies: where there are fingers it
/// points away from discs, off palm and table too.
pub(super) fn turned(system: &System) -> Vec<bool> {
    let is_plane = |touching: &Touching| matches!(touching, Touching::Palm(_) | Touching::Table(_));
    system.touching().iter().map(|touching| !system.fingers.is_empty() && is_plane(touching)).collect()
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
