//! A synthetic run in closed form for the tests of the sinks.

use phalanx::scene::{Integrator, LogRates, Scene, Thresholds, load, show};
use phalanx::trace::{ContactSample, Energy, Event, EventKind, FingerContact, FingerState, Sample};

/// A scene whose source is its resolved text, with a non-ASCII comment.
pub fn scene() -> Scene {
    let scene = load("scenes/experiment-95-frictionless.toml").unwrap_or_else(|error| panic!("{error}"));
    let scene = Scene {
        name: "synthetic".to_string(),
        description: String::new(),
        integrator: Integrator { rtol: 1e-4, ..scene.integrator },
        thresholds: Thresholds::NONE,
        log: LogRates { numeric_hz: 1e4, picture_hz: 5e3 },
        ..scene
    };
    Scene { source: format!("# a scene with a µ and no particular meaning\n{}", show(&scene)), ..scene }
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
    Sample {
        time_s,
        fingers: vec![FingerState {
            q11_rad: f(0),
            q21_rad: f(1),
            q12_rad: f(2),
            q22_rad: f(3),
            q13_rad: f(4),
            qd11_rad_s: f(5),
            qd21_rad_s: f(6),
            qd12_rad_s: f(7),
            qd22_rad_s: f(8),
            motor_torque_n_m: 0.48,
        }],
        bodies: Vec::new(),
        contacts: vec![
            contact(10),
            contact(20),
            ContactSample {
                gap_m: f(30),
                gap_rate_m_s: f(31),
                normal_n: f(32),
                impulse_n_s: f(33),
                ..ContactSample::default()
            },
        ],
        energy: Energy {
            kinetic_j: f(40),
            gravity_j: f(41),
            spring_j: f(42),
            elastic_j: f(43),
            dissipated_j: f(44),
            motor_work_j: f(45),
            balance_j: 1e-12 * f(46),
        },
    }
}

/// A sample of a finger at the given angles and rates, with the given normal forces.
pub fn posture(
    time_s: f64,
    (q11_rad, qd11_rad_s): (f64, f64),
    (q21_rad, qd21_rad_s): (f64, f64),
    forces_n: [f64; 2],
) -> Sample {
    let contact = |normal_n: f64| ContactSample {
        gap_m: if normal_n > 0.0 { -1e-6 } else { 1e-3 },
        gap_rate_m_s: 0.0,
        slip_m_s: 0.0,
        normal_n,
        tangential_n: 0.0,
        impulse_n_s: 0.0,
        point_m: [0.0; 2],
        normal: [1.0, 0.0],
    };
    let mut sample = sample(time_s);
    sample.fingers[0] = FingerState { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s, ..sample.fingers[0] };
    (sample.contacts[0], sample.contacts[1]) = (contact(forces_n[0]), contact(forces_n[1]));
    sample
}

pub fn touch_down(time_s: f64, finger_contact: FingerContact, approach_speed: f64) -> Event {
    Event { time_s, contact: finger_contact as usize, kind: EventKind::TouchDown, approach_speed, impulse: 0.0 }
}

pub fn lift_off(time_s: f64, finger_contact: FingerContact, impulse: f64) -> Event {
    Event { time_s, contact: finger_contact as usize, kind: EventKind::LiftOff, approach_speed: 0.0, impulse }
}

pub fn reload(time_s: f64, finger_contact: FingerContact) -> Event {
    Event { time_s, contact: finger_contact as usize, kind: EventKind::Reload, approach_speed: 0.0, impulse: 0.0 }
}
