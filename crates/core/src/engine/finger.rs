//! Plan of a finger: four links, five pins, a spring, a stop, and the contacts of both phalanges.

use std::f64::consts::{FRAC_PI_2, PI};

use super::plan::{
    Capsule, ContactPartner, ContactPointConvention, Plan, PlannedBody, PlannedContact, PlannedPin, PlannedSpring,
    PlannedStop, Shape,
};
use crate::gripper::{Body, Lengths, Posture, Spring, close_loop, straight_posture};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::opening_angle;
use crate::scene::{DrivenFinger, Placement, Side};

/// Index of the driven link l11 in its finger.
pub const L11: usize = 0;
/// Index of the coupler l12 in its finger.
pub const L12: usize = 1;
/// Index of the proximal phalanx l21 in its finger.
pub const L21: usize = 2;
/// Index of the distal phalanx l22 in its finger.
pub const L22: usize = 3;

/// Number of links of a finger.
pub const LINKS: usize = 4;

/// Body index of the first link of a finger; the others follow in order.
pub fn first_link(side: Side) -> usize {
    LINKS * side as usize
}

/// Surfaces that the phalanges of a finger can touch: all discs.
#[derive(Clone, Copy)]
pub(super) struct ContactTargets<'a> {
    pub discs: &'a [ContactPartner],
    pub point_convention: ContactPointConvention,
}

/// Mounting of a finger: its base joint, and −1 for a finger mirrored about the y axis.
#[derive(Clone, Copy)]
pub(super) struct Mount {
    /// Body that carries the finger; `None` is the ground.
    pub on: Option<usize>,
    pub ground_m: [f64; 2],
    pub mirror: f64,
}

/// Adds links, pins, spring, stop and contacts of a finger, but no motor; `None` if its angles do not close the loop.
pub(super) fn add_finger(
    plan: &mut Plan,
    driven: &DrivenFinger,
    targets: ContactTargets<'_>,
    mount: Mount,
) -> Option<()> {
    let DrivenFinger { linkage: finger, initial: start, .. } = driven;
    let (lengths, Mount { mirror, ground_m, .. }) = (&finger.lengths, mount);
    let base = plan.bodies.len();
    let posture = close_loop(lengths, finger.assembly, start.q11_rad, start.q21_rad).ok()?;
    let angles = body_angles(&posture, lengths.phi22_rad);
    let link_end =
        |length: f64, angle: f64| [ground_m[0] + mirror * (length * cos(angle)), ground_m[1] + length * sin(angle)];
    let (a12, a22) = (link_end(lengths.l11_m, angles[L11]), link_end(lengths.l21_m, angles[L21]));
    let rates = body_rates(lengths, &angles, [start.qd11_rad_s, start.qd21_rad_s]);
    let radius_m = lengths.half_width_m;
    let capsules = [
        None,
        None,
        Some(Shape::Capsule(Capsule { length_m: lengths.l21_m, angle_rad: 0.0, radius_m })),
        Some(Shape::Capsule(Capsule { length_m: lengths.t22_m, angle_rad: mirror * lengths.phi22_rad, radius_m })),
    ];
    let masses = [finger.bodies.l11, finger.bodies.l12, finger.bodies.l21, finger.bodies.l22];
    let origins = [ground_m, a12, ground_m, a22];
    plan.bodies.extend((0..LINKS).map(|i| PlannedBody {
        body: Body { com_m: [masses[i].com_m[0], mirror * masses[i].com_m[1]], ..masses[i] },
        origin_m: origins[i],
        angle_rad: if mirror > 0.0 { angles[i] } else { PI - angles[i] },
        velocity_m_s: [0.0; 2],
        rate_rad_s: mirror * rates[i],
        shape: capsules[i].filter(|_| !targets.discs.is_empty()),
    }));
    let pin = |first: Option<usize>, second: usize, length: f64| PlannedPin {
        first: first.map_or(mount.on, |body| Some(base + body)),
        second: base + second,
        anchor_first_m: if first.is_some() { [length, 0.0] } else { ground_m },
        anchor_second_m: [0.0; 2],
        closes_loop: false,
    };
    plan.pins.extend([
        pin(None, L11, 0.0),
        pin(Some(L11), L12, lengths.l11_m),
        pin(None, L21, 0.0),
        pin(Some(L21), L22, lengths.l21_m),
        PlannedPin { anchor_second_m: [lengths.l22_m, 0.0], closes_loop: true, ..pin(Some(L12), L22, lengths.l12_m) },
    ]);
    plan.springs.extend(plan_spring(driven.spring, lengths, mirror, base)?);
    // For a mirrored finger the angle from l21 to l22 becomes the angle from l22 to l21.
    let (on, against) = if mirror > 0.0 { (L22, L21) } else { (L21, L22) };
    let stop = |law| PlannedStop { on: base + on, against: base + against, min_angle_rad: -lengths.phi22_rad, law };
    plan.stops.extend(driven.limit.map(stop));
    for &against in targets.discs {
        for (body, law) in [(L21, driven.contact.proximal), (L22, driven.contact.distal)] {
            plan.contacts.push(PlannedContact {
                body: base + body,
                against,
                point_convention: targets.point_convention,
                law,
            });
        }
    }
    Some(())
}

/// Orientations of the four links. The angle of l22 is measured from the straight line, as q22 is in both models.
fn body_angles(posture: &Posture, phi22: f64) -> [f64; 4] {
    let direction = |angle: f64| [cos(angle), sin(angle)];
    let bend = opening_angle(direction(posture.q21_rad), direction(posture.q21_rad + posture.q22_rad + phi22));
    [posture.q11_rad, posture.q11_rad + posture.q12_rad, posture.q21_rad, posture.q21_rad + bend - phi22]
}

/// Angular rates of the four links from those of the base links; the loop's point A13 has one velocity.
fn body_rates(lengths: &Lengths, angles: &[f64; 4], [w1, w2]: [f64; 2]) -> [f64; 4] {
    // Velocity of the end of a link that rotates at rate 1.
    let end_velocity = |length: f64, angle: f64| [-length * sin(angle), length * cos(angle)];
    let (u1, u2) = (end_velocity(lengths.l11_m, angles[L11]), end_velocity(lengths.l21_m, angles[L21]));
    let (u3, u4) = (end_velocity(lengths.l12_m, angles[L12]), end_velocity(lengths.l22_m, angles[L22]));
    // w3 u3 − w4 u4 = w2 u2 − w1 u1
    let rhs = [w2 * u2[0] - w1 * u1[0], w2 * u2[1] - w1 * u1[1]];
    let determinant = u4[0] * u3[1] - u3[0] * u4[1];
    let w3 = (u4[0] * rhs[1] - rhs[0] * u4[1]) / determinant;
    let w4 = (u3[0] * rhs[1] - rhs[0] * u3[1]) / determinant;
    [w1, w3, w2, w4]
}

/// Returns the spring between the two links of its placement; the outer `None` if the straight posture does not exist.
fn plan_spring(spring: Option<Spring>, lengths: &Lengths, mirror: f64, base: usize) -> Option<Option<PlannedSpring>> {
    let Some(spring) = spring else { return Some(None) };
    let (on, against) = match spring.placement {
        Placement::GroundLinks => (L21, L11),
        Placement::DrivenCoupler => (L12, L11),
        Placement::Phalanges => (L22, L21),
        Placement::CouplerDistal => (L12, L22),
    };
    let angles = body_angles(&straight_posture(lengths, FRAC_PI_2).ok()?, lengths.phi22_rad);
    // Rate of the angle with q11 at constant q21.
    let rates = body_rates(lengths, &angles, [1.0, 0.0]);
    Some(Some(PlannedSpring {
        on: base + on,
        against: base + against,
        kind: spring.kind,
        closing_sign: mirror * (rates[on] - rates[against]).signum(),
        straight_rad: mirror * (angles[on] - angles[against]),
    }))
}
