//! Reference solutions for grippers (tests/anchors/gripper.json), computed by an independent program: absolute
//! coordinates, its own Radau IIA of order 5, rtol 3e-12. Its runs at rtol 1e-12 differ from these by less than 2e-9
//! rad.

use phalanx::shape::Shape;
use std::collections::BTreeMap;

use phalanx::gripper::{Assembly, Bodies, Body, Finger, Lengths, Placement, Spring, SpringKind};
use phalanx::law::{Bristle, ContactLaw, FrictionLaw, NormalLaw};
use phalanx::scene::{
    Axis, Brake, Differential, FingerContactLaws, HalfPlane, Hand, HandFinger, Initial, Integrator, LogSettings, Motor,
    Move, Object, ObjectMotion, PalmMotion, Preset, Profile, Ramp, Scene, Thresholds, Vibration,
};
use serde_json::Value;

use super::laws::scene_of;

/// A scene and its reference solution.
pub struct ReferenceCase {
    pub name: String,
    pub scene: Scene,
    /// Times of first contact of the phalanges, s: right proximal, right distal, left proximal, left distal.
    pub first_contact_s: [f64; 4],
    pub states: Vec<State>,
    /// Normal impulse over the run, N·s, of R21, R22, L21, L22, palm and table.
    pub impulse: [f64; 6],
    /// Bristle deflections at the end: of the six contacts above in m, then of both brakes in rad.
    pub bristle_deflection: [f64; 8],
}

/// Coordinates (q11, q21) of the right finger, (q11, q21) of the left finger, (x, y, θ) of the object, and their rates.
pub struct State {
    pub time_s: f64,
    pub q: [f64; 7],
    pub v: [f64; 7],
}

/// Cases with a palm at rest and without stiction, ordered by their letter in the specification.
pub fn cases_at_rest() -> Vec<ReferenceCase> {
    let is_included = |hand: &Hand| hand.palm_motion.is_none() && !hand.has_stiction();
    all_cases().into_iter().filter(|case| is_included(&case.scene.hand)).collect()
}

fn all_cases() -> Vec<ReferenceCase> {
    let text = std::fs::read_to_string("tests/anchors/gripper.json").expect("the reference solutions");
    let cases: BTreeMap<String, Value> = serde_json::from_str(&text).expect("JSON");
    cases.iter().map(|(letter, case)| parse_case(letter, case)).collect()
}

/// Returns the case with the given letter in the specification.
pub fn reference_case(letter: &str) -> ReferenceCase {
    all_cases().into_iter().find(|case| case.name.starts_with(letter)).expect("a case of that letter")
}

const PAIRS: [&str; 6] = ["R21", "R22", "L21", "L22", "palm", "support"];

fn parse_case(letter: &str, case: &Value) -> ReferenceCase {
    let first_contact = |pair: &str| {
        let contacts = case["touches"].as_array().expect("an array `touches`");
        number(&contacts.iter().find(|contact| contact["pair"] == pair).expect("a first contact")["t"])
    };
    let states = case["states"].as_array().expect("states").iter().map(|state| State {
        time_s: number(&state["t"]),
        q: numbers(&state["q"]),
        v: numbers(&state["v"]),
    });
    ReferenceCase {
        name: format!("{letter}: {}", case["name"].as_str().expect("a name")),
        scene: scene(&case["scene"]),
        first_contact_s: std::array::from_fn(|i| first_contact(PAIRS[i])),
        states: states.collect(),
        impulse: PAIRS.map(|pair| number(&case["impulse"][pair])),
        bristle_deflection: std::array::from_fn(|i| case["s"][i].as_f64().unwrap_or(0.0)),
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| number(&value[i]))
}

fn normal([k, e, c, d]: [f64; 4]) -> NormalLaw {
    NormalLaw::step(k, e, c, d)
}

fn law(value: &Value) -> ContactLaw {
    let [k, e, c, d] = ["k", "e", "c_max", "d_max"].map(|key| number(&value[key]));
    let [mu_static, mu_dynamic, v_static_m_s, v_dynamic_m_s] =
        ["mu_s", "mu_d", "v_s", "v_d"].map(|key| number(&value[key]));
    let friction = FrictionLaw { mu_static, mu_dynamic, v_static_m_s, v_dynamic_m_s, kind: bristle(value).into() };
    ContactLaw { normal: normal([k, e, c, d]), friction: Some(friction) }
}

fn motor(torque: &Value, inertia: &Value, no_load_speed: &Value) -> Motor {
    Motor {
        actuation: Profile::Constant { value: number(torque) },
        inertia_kg_m2: inertia.as_f64().unwrap_or(0.0),
        no_load_speed_rad_s: no_load_speed.as_f64().filter(|speed| *speed > 0.0),
        brake: None,
    }
}

fn bristle(value: &Value) -> Option<Bristle> {
    (value["friction"] == "bristle").then(|| {
        let damping_n_s_per_m = number(&value["c_t"]);
        Bristle { damping_n_s_per_m, relaxation_s: damping_n_s_per_m / number(&value["k_t"]) }
    })
}

fn brake(value: &Value) -> Option<Brake> {
    value.is_object().then(|| Brake {
        torque_n_m: number(&value["T"]),
        start_s: number(&value["t"]),
        rise_s: number(&value["rise"]),
        release_s: None,
        one_way: value["one_way"] == true,
        v_static_rad_s: number(&value["v_s"]),
        bristle: bristle(value),
    })
}

fn palm_motion(scene: &Value) -> Option<PalmMotion> {
    let axis = |value: &Value| [Axis::X, Axis::Y, Axis::Angle][number(value) as usize];
    let moves = scene["moves"].as_array()?.iter().map(|entry| {
        let [_, start_s, length_s, distance] = numbers(entry);
        Move { axis: axis(&entry[0]), distance, start_s, length_s }
    });
    let vibrations = scene["vib"].as_array()?.iter().map(|entry| {
        let [_, amplitude, frequency_hz, start_s, phase_rad, ramp_periods] = numbers(entry);
        let (axis, ramp) = (axis(&entry[0]), Ramp::Cubic);
        Vibration { axis, amplitude, frequency_hz, phase_rad, start_s, ramp_periods, ramp }
    });
    let motion =
        PalmMotion { moves: moves.collect(), vibrations: vibrations.collect(), path: None, ..PalmMotion::default() };
    (motion != PalmMotion::default()).then_some(motion)
}

fn finger(value: &Value, [proximal, distal]: [&Value; 2], brake_data: &Value) -> HandFinger {
    let [l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, half_width_m] =
        ["l11", "l12", "l21", "l22", "t22", "phi22", "w"].map(|key| number(&value[key]));
    let body = |index: usize| {
        let [mass_kg, a, b, inertia_kg_m2] = numbers(&value["bodies"][index]);
        Body { mass_kg, com_m: [a, b], inertia_kg_m2 }
    };
    let ([q11_rad, q21_rad], [qd11_rad_s, qd21_rad_s]) = (numbers(&value["q"]), numbers(&value["v"]));
    HandFinger {
        linkage: Finger {
            lengths: Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, half_width_m },
            bodies: Bodies { l11: body(0), l12: body(1), l21: body(2), l22: body(3) },
            assembly: Assembly::Reference,
        },
        motor: Motor { brake: brake(brake_data), ..motor(&value["tau"], &value["inertia"], &value["no_load_speed"]) },
        spring: Some(Spring {
            kind: SpringKind::Constant { torque_n_m: number(&value["ks"]) },
            placement: Placement::Phalanges,
        }),
        limit: Some(normal(numbers(&value["limit"]))),
        contact: FingerContactLaws { proximal: law(proximal), distal: law(distal) },
        initial: Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s },
    }
}

fn scene(value: &Value) -> Scene {
    let (object, contacts) = (&value["object"], &value["contacts"]);
    let ([x, y, angle_rad], [vx, vy, spin_rad_s]) = (numbers(&object["start"]), numbers(&object["rates"]));
    let has_table = value["support"].as_bool() == Some(true);
    let duration_s = number(&value["T"]);
    let differential = &value["diff"];
    let hand = Hand {
        fingers: vec![
            finger(&value["right"], [&contacts["R21"], &contacts["R22"]], &value["brakes"]["r"]),
            finger(&value["left"], [&contacts["L21"], &contacts["L22"]], &value["brakes"]["l"]),
        ],
        palm_width_m: number(&value["palm"]),
        differential: differential.is_object().then(|| Differential {
            motor: motor(&differential["tau"], &differential["J_in"], &Value::Null),
            seesaw_inertia_kg_m2: number(&differential["J_s"]),
        }),
        object: Some(Object {
            shape: Shape::Disc { radius_m: number(&object["radius"]) },
            centre_m: [x, y],
            angle_rad,
            motion: ObjectMotion::Free {
                mass_kg: number(&object["mass"]),
                inertia_kg_m2: number(&object["inertia"]),
                velocity_m_s: [vx, vy],
                spin_rad_s,
            },
        }),
        palm: Some(HalfPlane { level_m: 0.0, contact: Some(law(&contacts["palm"])) }),
        table: has_table.then(|| HalfPlane { level_m: number(&value["h"]), contact: Some(law(&contacts["support"])) }),
        palm_motion: palm_motion(value),
        gravity_m_s2: numbers(&value["gravity"]),
    };
    Scene {
        integrator: Integrator::preset(Preset::Engineering),
        thresholds: Thresholds::defaults_for_run(duration_s, 0.0),
        grasp: None,
        log: LogSettings { numeric_hz: 1e4, picture_hz: 0.0, joint_forces: false },
        ..scene_of(hand, duration_s)
    }
}
