//! A synthetic run in closed form for the tests of the sinks.

use phalanx::gripper::{Assembly, Bodies, Body, Finger, Lengths};
use phalanx::law::{ContactLaw, NormalLaw};
use phalanx::scene::{
    FingerContactLaws, HalfPlane, Hand, HandFinger, Initial, Integrator, Method, Motor, Object, Placement, Preset,
    Profile, Scene, Spring, SpringKind, show,
};
use phalanx::shape::PlacedShape;
use phalanx::trace::{ContactSample, Energy, Event, EventKind, FingerContact, FingerState, Sample};

use super::laws::{EMPTY, scene_of};

/// A scene whose source is its resolved text, with a non-ASCII comment.
pub fn scene() -> Scene {
    let scene = resolved();
    Scene { source: format!("# a scene with a µ and no particular meaning\n{}", show(&scene)), ..scene }
}

fn resolved() -> Scene {
    let hand = Hand {
        fingers: vec![finger()],
        object: Some(Object::fixed(PlacedShape::disc(20e-3, [-15.5e-3, 20e-3]))),
        palm: Some(HalfPlane { level_m: 0.0, contact: None }),
        gravity_m_s2: [0.0, 9.81],
        ..EMPTY
    };
    let integrator = Integrator {
        preset: Preset::Engineering,
        method: Method::Rodas5p,
        rtol: 1e-4,
        atol_angle_rad: 1e-10,
        atol_rate_rad_s: 1e-6,
        max_steps: 1_000_000,
    };
    Scene { name: "synthetic".to_string(), integrator, ..scene_of(hand, 20e-3) }
}

fn finger() -> HandFinger {
    let body = Body { mass_kg: 5e-3, com_m: [1e-2, 0.0], inertia_kg_m2: 1e-7 };
    let normal = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);
    let contact = ContactLaw { normal, friction: None };
    HandFinger {
        linkage: Finger {
            lengths: Lengths {
                l11_m: 15e-3,
                l12_m: 22.3628e-3,
                l21_m: 24.4324e-3,
                l22_m: 7.5e-3,
                t22_m: 12.8566e-3,
                phi22_rad: 120f64.to_radians(),
                half_width_m: 2.5e-3,
            },
            bodies: Bodies { l11: body, l12: body, l21: body, l22: body },
            assembly: Assembly::Reference,
        },
        motor: Motor::from_actuation(Profile::Constant { value: 0.48 }),
        spring: Some(Spring { kind: SpringKind::Constant { torque_n_m: 0.1326 }, placement: Placement::Phalanges }),
        limit: Some(normal),
        contact: FingerContactLaws { proximal: contact, distal: contact },
        initial: Initial {
            q11_rad: -50f64.to_radians(),
            q21_rad: 40f64.to_radians(),
            qd11_rad_s: 0.0,
            qd21_rad_s: 0.0,
        },
    }
}

/// A sample in which all figures differ; each is computed from the time.
pub fn sample(time_s: f64) -> Sample {
    let f = |k: u32| (1.0 + k as f64) * (1e3 * time_s + 0.3 * k as f64).sin();
    let contact = |k: u32| ContactSample {
        gap_m: 1e-3 * f(k),
        gap_rate_m_s: f(k + 1),
        slip_m_s: f(k + 2),
        normal_n: f(k + 3).abs(),
        tangential_n: f(k + 4),
        impulse_n_s: f(k + 9),
        point_m: [1e-2 * f(k + 5), 1e-2 * f(k + 6)],
        normal: [f(k + 7), f(k + 8)],
    };
    let finger = FingerState {
        q11_rad: f(0),
        q21_rad: f(1),
        q12_rad: f(2),
        q22_rad: f(3),
        q13_rad: f(4),
        qd11_rad_s: f(5),
        qd21_rad_s: f(6),
        qd12_rad_s: f(7),
        qd22_rad_s: f(8),
    };
    let limit = ContactSample {
        gap_m: f(30),
        gap_rate_m_s: f(31),
        normal_n: f(32),
        impulse_n_s: f(33),
        ..ContactSample::default()
    };
    let mut sample = Sample::of(time_s, &[finger], &[], &[contact(10), contact(20), limit]);
    sample.set_actuator(0, 0.48);
    sample.set_energy(&Energy {
        kinetic_j: f(40),
        gravity_j: f(41),
        spring_j: f(42),
        elastic_j: f(43),
        dissipated_j: f(44),
        motor_work_j: f(45),
        balance_j: 1e-12 * f(46),
        cable_friction_j: 0.0,
    });
    sample
}

/// A sample of a finger at the given angles and rates, with the given normal forces.
pub fn posture(
    time_s: f64,
    (q11_rad, qd11_rad_s): (f64, f64),
    (q21_rad, qd21_rad_s): (f64, f64),
    forces_n: [f64; 2],
) -> Sample {
    let contact = |normal_n: f64| {
        let gap_m = if normal_n > 0.0 { -1e-6 } else { 1e-3 };
        ContactSample { gap_m, normal_n, normal: [1.0, 0.0], ..ContactSample::default() }
    };
    let mut sample = sample(time_s);
    sample.set_finger(0, &FingerState { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s, ..sample.finger(0) });
    forces_n.iter().enumerate().for_each(|(index, force_n)| sample.set_contact(index, &contact(*force_n)));
    sample
}

fn event(time_s: f64, contact: FingerContact, kind: EventKind, approach_speed: f64, impulse: f64) -> Event {
    Event { time_s, contact: contact as usize, kind, approach_speed, impulse }
}

pub fn touch_down(time_s: f64, contact: FingerContact, approach_speed: f64) -> Event {
    event(time_s, contact, EventKind::TouchDown, approach_speed, 0.0)
}

pub fn lift_off(time_s: f64, contact: FingerContact, impulse: f64) -> Event {
    event(time_s, contact, EventKind::LiftOff, 0.0, impulse)
}

pub fn reload(time_s: f64, contact: FingerContact) -> Event {
    event(time_s, contact, EventKind::Reload, 0.0, 0.0)
}
