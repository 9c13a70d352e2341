//! What a scene needs of the engine, as plain lists: bodies, pins, torques, stops and contacts.
//!
//! Nothing here knows of rapier, and nothing beyond this file knows of fingers: more bodies, pins or contacts are more
//! entries.

use std::f64::consts::FRAC_PI_2;

use crate::gripper::{Body, Lengths, Posture, Site, close, straight};
use crate::law::{ContactLaw, NormalLaw};
use crate::numeric::plane::opening_angle;
use crate::scene::{Placement, Scene, SpringKind};

/// Indices of the finger's bodies.
pub const L11: usize = 0;
pub const L12: usize = 1;
pub const L21: usize = 2;
pub const L22: usize = 3;

/// A moving body: its mass properties, and where it starts.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub body: Body,
    /// Origin of the body's frame (the joint before it) and its orientation at the start.
    pub origin_m: [f64; 2],
    pub angle_rad: f64,
    pub rate_rad_s: f64,
    pub phalanx: Option<Capsule>,
}

/// A capsule in its body's frame: from the origin along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    pub length_m: f64,
    pub angle_rad: f64,
    pub radius_m: f64,
}

/// A revolute joint; `None` is the ground. Anchors are in each body's frame.
#[derive(Clone, Copy, Debug)]
pub struct PlannedPin {
    pub first: Option<usize>,
    pub second: usize,
    pub anchor_first_m: [f64; 2],
    pub anchor_second_m: [f64; 2],
    /// Whether this is the joint that closes a loop of the others.
    pub closes_loop: bool,
}

/// A torque on `on`, and its reaction on `against`, that depends on the angle from `against` to `on`.
#[derive(Clone, Copy, Debug)]
pub struct PlannedSpring {
    pub on: usize,
    pub against: usize,
    pub kind: SpringKind,
    /// +1 where the angle grows as the finger closes: the torque pulls against that.
    pub closing_sign: f64,
    /// The angle in the straight configuration.
    pub straight_rad: f64,
}

/// A one-sided stop: the angle from `against` to `on` stays above `least_rad`.
#[derive(Clone, Copy, Debug)]
pub struct PlannedStop {
    pub on: usize,
    pub against: usize,
    pub least_rad: f64,
    pub law: NormalLaw,
    pub site: Site,
}

/// A phalanx that may touch the object.
#[derive(Clone, Copy, Debug)]
pub struct PlannedContact {
    pub body: usize,
    pub law: ContactLaw,
    pub site: Site,
}

/// Everything the engine builds for a scene, and nothing it does not need.
#[derive(Clone, Debug)]
pub struct Plan {
    pub bodies: Vec<PlannedBody>,
    pub pins: Vec<PlannedPin>,
    pub spring: Option<PlannedSpring>,
    pub stops: Vec<PlannedStop>,
    pub contacts: Vec<PlannedContact>,
    /// Fixed disc: radius and centre. A fixed object is no body, and the palm is left out: nothing that moves can reach it.
    pub disc_m: Option<(f64, [f64; 2])>,
}

/// The plan of a scene; `None` where its initial angles do not close the loop.
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
        Some(Capsule { length_m: lengths.l21_m, angle_rad: 0.0, radius_m }),
        Some(Capsule { length_m: lengths.t22_m, angle_rad: lengths.phi22_rad, radius_m }),
    ];
    let masses = [finger.bodies.l11, finger.bodies.l12, finger.bodies.l21, finger.bodies.l22];
    let origins = [[0.0; 2], a12, [0.0; 2], a22];
    let bodies = (0..4)
        .map(|i| PlannedBody {
            body: masses[i],
            origin_m: origins[i],
            angle_rad: angles[i],
            rate_rad_s: rates[i],
            phalanx: capsules[i].filter(|_| scene.object.is_some()),
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
    let stops = scene.limit.iter().map(|law| PlannedStop {
        on: L22,
        against: L21,
        least_rad: -lengths.phi22_rad,
        law: *law,
        site: Site::Limit,
    });
    let contacts = [(L21, scene.contact.proximal, Site::Proximal), (L22, scene.contact.distal, Site::Distal)];
    Some(Plan {
        bodies,
        pins,
        spring: spring(scene)?,
        stops: stops.collect(),
        contacts: contacts
            .into_iter()
            .filter(|_| scene.object.is_some())
            .map(|(body, law, site)| PlannedContact { body, law, site })
            .collect(),
        disc_m: scene.object.map(|disc| (disc.radius_m, disc.centre_m)),
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
