//! The plan of a finger: four links, five pins, and the object both phalanges may touch.

use std::f64::consts::FRAC_PI_2;

use super::plan::{
    Against, Capsule, Plan, PlannedBody, PlannedContact, PlannedFixed, PlannedMotor, PlannedPin, PlannedSpring,
    PlannedStop, Shape,
};
use crate::gripper::{Lengths, Posture, Site, close, straight};
use crate::numeric::plane::opening_angle;
use crate::scene::{Placement, Scene};

/// Indices of the finger's bodies.
pub const L11: usize = 0;
pub const L12: usize = 1;
pub const L21: usize = 2;
pub const L22: usize = 3;

/// The site that a stop or contact of a finger's plan is.
pub fn site(plan: &Plan, index: usize) -> Site {
    match index.checked_sub(plan.stops.len()).map(|contact| plan.contacts[contact].body) {
        None => Site::Limit,
        Some(L21) => Site::Proximal,
        Some(_) => Site::Distal,
    }
}

/// The index of a site among the stops and contacts of a finger's plan; `None` where the scene has no such site.
pub fn index_of(plan: &Plan, wanted: Site) -> Option<usize> {
    (0..plan.stops.len() + plan.contacts.len()).find(|index| site(plan, *index) == wanted)
}

/// The plan of a finger; `None` where its initial angles do not close the loop.
pub fn plan(scene: &Scene) -> Option<Plan> {
    let finger = &scene.finger;
    let lengths = &finger.lengths;
    let start = &scene.initial;
    let posture = close(lengths, finger.assembly, start.q11_rad, start.q21_rad).ok()?;
    let angles = body_angles(&posture, lengths.phi22_rad);
    let along = |length: f64, angle: f64| [length * angle.cos(), length * angle.sin()];
    let (a12, a22) = (along(lengths.l11_m, angles[L11]), along(lengths.l21_m, angles[L21]));
    let rates = body_rates(lengths, &angles, [start.qd11_rad_s, start.qd21_rad_s]);
    let radius_m = lengths.half_width_m;
    let capsules = [
        None,
        None,
        Some(Shape::Capsule(Capsule { length_m: lengths.l21_m, angle_rad: 0.0, radius_m })),
        Some(Shape::Capsule(Capsule { length_m: lengths.t22_m, angle_rad: lengths.phi22_rad, radius_m })),
    ];
    let masses = [finger.bodies.l11, finger.bodies.l12, finger.bodies.l21, finger.bodies.l22];
    let origins = [[0.0; 2], a12, [0.0; 2], a22];
    let bodies = (0..4)
        .map(|i| PlannedBody {
            body: masses[i],
            origin_m: origins[i],
            angle_rad: angles[i],
            velocity_m_s: [0.0; 2],
            rate_rad_s: rates[i],
            shape: capsules[i].filter(|_| scene.object.is_some()),
        })
        .collect();
    let pin = |first, second, length: f64| PlannedPin {
        first,
        second,
        anchor_first_m: [length, 0.0],
        anchor_second_m: [0.0; 2],
        closes_loop: false,
    };
    let pins = vec![
        pin(None, L11, 0.0),
        pin(Some(L11), L12, lengths.l11_m),
        pin(None, L21, 0.0),
        pin(Some(L21), L22, lengths.l21_m),
        PlannedPin {
            first: Some(L12),
            second: L22,
            anchor_first_m: [lengths.l12_m, 0.0],
            anchor_second_m: [lengths.l22_m, 0.0],
            closes_loop: true,
        },
    ];
    let stops =
        scene.limit.iter().map(|law| PlannedStop { on: L22, against: L21, least_rad: -lengths.phi22_rad, law: *law });
    let contacts = [(L21, scene.contact.proximal), (L22, scene.contact.distal)];
    // The palm is left out: nothing that moves can reach it.
    let object = scene
        .object
        .map(|disc| PlannedFixed { shape: Shape::Disc { radius_m: disc.radius_m }, origin_m: disc.centre_m });
    Some(Plan {
        bodies,
        fixed: object.into_iter().collect(),
        pins,
        motor: Some(PlannedMotor { on: L11, actuation: scene.actuation.clone() }),
        drives: Vec::new(),
        spring: spring(scene)?,
        stops: stops.collect(),
        contacts: contacts
            .into_iter()
            .filter(|_| scene.object.is_some())
            .map(|(body, law)| PlannedContact { body, against: Against::Fixed(0), law })
            .collect(),
        gravity_m_s2: scene.gravity_m_s2,
    })
}

/// Orientations of the four bodies. That of l22 is counted from the straight line, the way both models count q22.
fn body_angles(posture: &Posture, phi22: f64) -> [f64; 4] {
    let direction = |angle: f64| [angle.cos(), angle.sin()];
    let bend = opening_angle(direction(posture.q21_rad), direction(posture.q21_rad + posture.q22_rad + phi22));
    [posture.q11_rad, posture.q11_rad + posture.q12_rad, posture.q21_rad, posture.q21_rad + bend - phi22]
}

/// Angular rates of the four bodies from those of the ground links: the loop's point A13 moves as one.
fn body_rates(lengths: &Lengths, angles: &[f64; 4], [w1, w2]: [f64; 2]) -> [f64; 4] {
    // Velocity of the end of a link of some length that turns with rate 1.
    let turn = |length: f64, angle: f64| [-length * angle.sin(), length * angle.cos()];
    let (u1, u2) = (turn(lengths.l11_m, angles[L11]), turn(lengths.l21_m, angles[L21]));
    let (u3, u4) = (turn(lengths.l12_m, angles[L12]), turn(lengths.l22_m, angles[L22]));
    // w3 u3 − w4 u4 = w2 u2 − w1 u1
    let rhs = [w2 * u2[0] - w1 * u1[0], w2 * u2[1] - w1 * u1[1]];
    let determinant = u4[0] * u3[1] - u3[0] * u4[1];
    let w3 = (u4[0] * rhs[1] - rhs[0] * u4[1]) / determinant;
    let w4 = (u3[0] * rhs[1] - rhs[0] * u3[1]) / determinant;
    [w1, w3, w2, w4]
}

/// The spring between the two bodies of its placement; the outer `None` where the straight posture does not exist.
fn spring(scene: &Scene) -> Option<Option<PlannedSpring>> {
    let Some(spring) = scene.spring else { return Some(None) };
    let lengths = &scene.finger.lengths;
    let (on, against) = match spring.placement {
        Placement::GroundLinks => (L21, L11),
        Placement::DrivenCoupler => (L12, L11),
        Placement::Phalanges => (L22, L21),
        Placement::CouplerDistal => (L12, L22),
    };
    let angles = body_angles(&straight(lengths, FRAC_PI_2).ok()?, lengths.phi22_rad);
    let straight_rad = angles[on] - angles[against];
    // How the angle changes with q11 at fixed q21.
    let rates = body_rates(lengths, &angles, [1.0, 0.0]);
    let closing_sign = (rates[on] - rates[against]).signum();
    Some(Some(PlannedSpring { on, against, kind: spring.kind, closing_sign, straight_rad }))
}
