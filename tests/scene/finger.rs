//! Scenes of a finger are resolved with their defaults and with given keys.

use phalanx::gripper::{self, Design, ProximalLength};
use phalanx::law::{Bristle, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{
    self, Bounds, Engine, Integrator, Interpolation, Method, Placement, Preset, Profile, Response, Scene, SpringKind,
    Stepping,
};
use phalanx::shape::max_radius;

use super::{DESIGN, DRIVE, finger_with, parse};

const LENGTHS: &str = "[lengths]\nl21 = \"24 mm\"\nl22 = \"7.5 mm\"\nt22 = \"13 mm\"\nphi22 = \"120 deg\"\n[object]\n\
                       centre = [\"-15.5 mm\", \"20 mm\"]\n";

#[test]
fn a_short_scene_has_the_parameters_of_table_3_2() {
    let scene = finger_with("[engine]\n[validate]\n");
    assert_eq!(scene.name, "test");
    let (finger, object) = (scene.finger(), scene.object().expect("object"));
    let design = Design::thesis(0.0155, ProximalLength::Fraction(1.0), 120f64.to_radians(), 0.5);
    assert_eq!(Ok(finger.linkage.lengths), gripper::lengths(&design));
    assert_eq!(gripper::bodies(&finger.linkage.lengths, 1070.0, 0.04), Ok(finger.linkage.bodies));
    assert_eq!((max_radius(&object.shape), object.centre_m), (0.02, [-0.0155, 0.02]));
    assert!(scene.hand.palm.is_some());
    let limit = NormalLaw::step(1e11, 2.2, 1e9, 1e-5);
    assert_eq!(finger.limit, Some(limit));
    let contact = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);
    for law in [finger.contact.proximal, finger.contact.distal] {
        assert_eq!((law.normal, law.friction), (contact, None));
    }
    assert_eq!((scene.hand.gravity_m_s2, scene.duration_s), ([0.0, 9.81], 0.02));
    assert_eq!(finger.motor.actuation, Profile::Constant { value: 0.48 });
    let spring = finger.spring.expect("spring");
    assert_eq!((spring.kind, spring.placement), (SpringKind::Constant { torque_n_m: 0.1326 }, Placement::Phalanges));
    assert_eq!(scene.integrator, Integrator::preset(Preset::Engineering));
    assert_eq!((scene.engine, scene.bounds), (Engine::DEFAULT, Bounds::defaults_for_run(SceneKind::Finger, 0.02)));
    let Engine { response, stepping, iterations, max_steps } = Engine::DEFAULT;
    assert_eq!(response, Response::Laws);
    assert_eq!(stepping, Stepping::Adaptive { tolerance_m: 1e-7, max_step_s: 6e-5 });
    assert_eq!((iterations, max_steps), (2, 10_000_000));
    assert_eq!((scene.log.numeric_hz, scene.log.picture_hz), (1e4, 5e3));
    assert_eq!((finger.initial.qd11_rad_s, finger.initial.qd21_rad_s), (0.0, 0.0));
}

#[test]
fn single_keys_override_the_preset() {
    let scene = finger_with("[integrator]\npreset = \"reference\"\nrtol = 1e-9\nmax_steps = 5\n");
    // Absolute tolerances default to multiples of the relative one.
    let expected = Integrator { max_steps: 5, ..Integrator::preset(Preset::Reference).with_rtol(1e-9) };
    assert!((expected.atol_angle_rad / 1e-12 - 1.0).abs() < 1e-12);
    assert_eq!((scene.integrator, expected.method), (expected, Method::RadauIIa5));
}

#[test]
fn a_draft_has_the_same_tolerances_in_every_kind_of_scene() {
    let finger = finger_with("[integrator]\npreset = \"draft\"\n");
    let mut mechanism = scene::load_any("scenes/mechanisms/two-pivot.toml").expect("a shipped scene");
    mechanism.apply_preset(Preset::Draft);
    assert_eq!([finger.integrator, mechanism.integrator], [Integrator::preset(Preset::Draft); 2]);
    assert_eq!(finger.integrator.rtol, 2e-4);
}

/// One contact may have a bristle while the other has none. The damping of a bristle defaults to that of its normal
/// law.
#[test]
fn stiction_applies_only_to_contacts_with_bristles() {
    let friction = "[contact.friction]\nmu_static = 0.8\n";
    let none = FrictionKind::Regularised;
    let bristle = |damping_n_s_per_m, relaxation_s| FrictionKind::Bristle(Bristle { damping_n_s_per_m, relaxation_s });
    for (keys, kinds) in [
        ("", [none; 2]),
        ("law = \"bristle\"\nbristle_damping = \"3e4 N*s/m\"\n", [bristle(3e4, 1e-3); 2]),
        (
            "[contact.proximal]\ndamping = \"5e5 N*s/m\"\n[contact.proximal.friction]\nlaw = \"bristle\"\n\
             bristle_relaxation = \"2 ms\"\n",
            [bristle(5e5, 2e-3), none],
        ),
        // A contact that repeats the law keeps the other common keys.
        (
            "law = \"bristle\"\nbristle_relaxation = \"2 ms\"\n[contact.distal.friction]\nlaw = \"bristle\"\n",
            [bristle(1e6, 2e-3); 2],
        ),
    ] {
        let scene = finger_with(&format!("{friction}{keys}"));
        let contact = scene.finger().contact;
        assert_eq!([contact.proximal, contact.distal].map(|law| law.friction.expect("friction").kind), kinds, "{keys}");
        assert_eq!(scene.hand.has_stiction(), kinds[0] != none, "{keys}");
    }
}

#[test]
fn friction_of_one_contact_overrides_the_common_one() {
    let scene = finger_with(
        "[contact.friction]\nmu_static = 0.8\nmu_dynamic = 0.7\nv_dynamic = \"0.3 m/s\"\n[contact.distal.friction]\n\
         mu_static = 0.4\n[contact.distal]\ndamping = \"5 N*s/m\"\n",
    );
    let [proximal, distal] = [scene.finger().contact.proximal, scene.finger().contact.distal];
    let common = FrictionLaw {
        mu_static: 0.8,
        mu_dynamic: 0.7,
        v_static_m_s: 0.1,
        v_dynamic_m_s: 0.3,
        kind: FrictionKind::Regularised,
    };
    assert_eq!(proximal.friction, Some(common));
    assert_eq!(distal.friction, Some(FrictionLaw { mu_static: 0.4, mu_dynamic: 0.28, ..common }));
    assert_eq!(proximal.normal.damping_max(), 1e6);
    assert_eq!((distal.normal.damping_max(), distal.normal.stiffness_n_per_m_e), (5.0, 1e8));
    // Only one contact is frictionless; the other has the exact default of `mu_dynamic`.
    let scene = finger_with("[contact.friction]\nmu_static = 0.8\n[contact.distal.friction]\nmu_static = 0\n");
    assert_eq!(scene.finger().contact.proximal.friction.map(|f| f.mu_dynamic), Some(0.56));
    assert_eq!(scene.finger().contact.distal.friction, None);
}

#[test]
fn materials_give_the_hertz_law() {
    // Rigid object of radius R on a soft flat: E* = E/(1 − ν²), k = 4/3 E* √R. A rounded phalanx of the same radius
    // halves R.
    let k = 4.0 / 3.0 * 10e6 / 0.75 * 0.02f64.sqrt();
    for (radius, expected) in [("", k), (", radius = \"20 mm\"", k * 0.5f64.sqrt())] {
        let scene = finger_with(&format!(
            "[contact.materials]\nobject = {{ modulus = \"1e12 GPa\", poisson = 0.3 }}\n\
             phalanx = {{ modulus = \"10 MPa\", poisson = 0.5{radius} }}\n[contact.distal]\nstiffness_si = 1e7\n"
        ));
        let law = scene.finger().contact.proximal.normal;
        assert!((law.stiffness_n_per_m_e / expected - 1.0).abs() < 1e-12, "{law:?}");
        assert_eq!(law.exponent, 1.5);
        assert_eq!(scene.finger().contact.distal.normal.stiffness_n_per_m_e, 1e7);
    }
}

#[test]
fn a_mass_alone_scales_the_inertia() {
    let plain = finger_with("").finger().linkage.bodies;
    let scene = finger_with(
        "[bodies]\nl21 = { mass = \"4.73 g\" }\nl22 = { com = [\"1 mm\", \"-2 mm\"], inertia = \"500 g*mm^2\" }\n",
    );
    let bodies = scene.finger().linkage.bodies;
    assert_eq!((bodies.l11, bodies.l12), (plain.l11, plain.l12));
    assert_eq!((bodies.l21.mass_kg, bodies.l21.com_m), (4.73e-3, plain.l21.com_m));
    let scale = bodies.l21.mass_kg / plain.l21.mass_kg;
    assert!((bodies.l21.inertia_kg_m2 / plain.l21.inertia_kg_m2 / scale - 1.0).abs() < 1e-14);
    assert_eq!((bodies.l22.mass_kg, bodies.l22.com_m), (plain.l22.mass_kg, [1e-3, -2e-3]));
    assert_eq!(bodies.l22.inertia_kg_m2, 5e-7);
    // A fully specified distal body needs no outline.
    let flat = LENGTHS.replace("120 deg", "179.9999999 deg");
    let body = "[bodies.l22]\nmass = \"5 g\"\ncom = [\"0 mm\", \"0 mm\"]\ninertia = \"500 g*mm^2\"\n";
    assert_eq!(parse(&format!("{flat}{DRIVE}{body}")).finger().linkage.bodies.l22.mass_kg, 5e-3);
}

#[test]
fn l12_follows_from_the_straight_configuration() {
    let scene = parse(&format!("{LENGTHS}{DRIVE}"));
    let (l, start) = (scene.finger().linkage.lengths, scene.finger().initial);
    let (sin, cos) = l.phi22_rad.sin_cos();
    assert_eq!(l.l12_m, (0.015 - 0.0075 * sin).hypot(0.024 + 0.0075 * cos));
    // The initial posture is straight, so l11 is 90° behind l21.
    assert!((start.q21_rad - start.q11_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    // A given base places an object of any radius, and so does the base that the message proposes.
    let lengths = LENGTHS.split("[object]").next().unwrap_or_default();
    let missing = format!("{lengths}{DRIVE}[object]\nradius = \"15 mm\"\n");
    let error = scene::parse(&missing, "test.toml").expect_err("no base").to_string();
    assert!(error.contains("base = \"12.8 mm\"") && error.contains("[\"-12.8 mm\", \"15 mm\"]"), "{error}");
    let scene = parse(&missing.replace("[lengths]", "[lengths]\nbase = \"12.8 mm\""));
    assert_eq!(scene.object().expect("an object").centre_m, [-0.0128, 0.015]);
}

#[test]
fn initial_angles_follow_from_offset_or_given_angles() {
    let degrees = |scene: &Scene| {
        let initial = scene.finger().initial;
        [initial.q11_rad, initial.q21_rad].map(f64::to_degrees)
    };
    let default = degrees(&finger_with(""));
    for (keys, expected) in [
        ("[initial]\noffset = \"20 deg\"\n", default.map(|angle| angle + 5.0)),
        ("[initial]\nq21 = \"30 deg\"\n", [-60.0, 30.0]),
        ("[initial]\nq21 = \"30 deg\"\nq11 = \"-50 deg\"\n", [-50.0, 30.0]),
        // Without an object, the posture follows from the object of the design.
        ("[object]\npresent = false\n", default),
    ] {
        let found = degrees(&finger_with(keys));
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{keys}: {found:?}");
    }
    let scene = finger_with("[initial]\nqd11 = \"60 rpm\"\nqd21 = \"-1 rad/s\"\n");
    assert!((scene.finger().initial.qd11_rad_s - std::f64::consts::TAU).abs() < 1e-14);
    assert_eq!(scene.finger().initial.qd21_rad_s, -1.0);
}

#[test]
fn motor_profiles_are_resolved() {
    let (torque_n_m, points) = (0.48, vec![(0.0, 0.0), (0.005, 0.48)]);
    for (keys, expected) in [
        (
            "profile = \"table\"\ntimes = [\"0 ms\", \"5 ms\"]\ntorques = [\"0 N*mm\", \"480 N*mm\"]",
            Profile::Table { points, interpolation: Interpolation::Linear },
        ),
        (
            "profile = \"ramp\"\ntorque = \"480 N*mm\"\nrise = \"2 ms\"",
            Profile::Ramp { value: torque_n_m, rise_s: 0.002 },
        ),
        (
            "profile = \"half-sine\"\ntorque = \"480 N*mm\"\npulse = \"8 ms\"",
            Profile::HalfSine { value: torque_n_m, length_s: 0.008 },
        ),
        (
            "profile = \"reversal\"\ntorque = \"480 N*mm\"\nreverse_at = \"10 ms\"",
            Profile::Reversal { value: torque_n_m, at_s: 0.01 },
        ),
    ] {
        let scene = parse(&format!("{DESIGN}[spring]\ntype = \"none\"\n[motor]\n{keys}\n"));
        assert_eq!(scene.finger().motor.actuation, expected);
    }
}

#[test]
fn line_endings_and_byte_order_marks_are_ignored() {
    let unix = finger_with("");
    let mut dos = parse(&format!("\u{feff}{DESIGN}{DRIVE}").replace('\n', "\r\n"));
    dos.source = unix.source.clone();
    assert_eq!(dos, unix);
}

#[test]
fn every_engine_key_is_applied() {
    let base = Engine::DEFAULT;
    let fixed = Stepping::Fixed { step_s: 1e-5 };
    let adaptive = Stepping::Adaptive { tolerance_m: 1e-6, max_step_s: 2e-5 };
    let contact = "[contact.friction]\nmu_static = 0.8\n[contact.distal.friction]\nmu_static = 0.3\n";
    let rapier = |friction, restitution| {
        let response = Response::Rapier { friction, restitution };
        Engine { response, iterations: Engine::default_iterations(response), ..base }
    };
    for (contact, keys, expected) in [
        ("", "law = \"scene\"\nstepping = \"adaptive\"", base),
        ("", "stepping = \"fixed\"\nstep = \"10 us\"", Engine { stepping: fixed, ..base }),
        ("", "tolerance = \"1e-3 mm\"\nmax_step = \"20 us\"", Engine { stepping: adaptive, ..base }),
        ("", "iterations = 1", Engine { iterations: 1, ..base }),
        ("", "iterations = 10_000", Engine { iterations: 10_000, ..base }),
        ("", "max_steps = 7", Engine { max_steps: 7, ..base }),
        // The friction of rapier's contact defaults to that of the proximal contact.
        ("", "law = \"rapier\"", Engine { iterations: 50, ..rapier(0.0, 0.0) }),
        ("", "law = \"rapier\"\niterations = 7", Engine { iterations: 7, ..rapier(0.0, 0.0) }),
        (contact, "law = \"rapier\"", rapier(0.8, 0.0)),
        (contact, "law = \"rapier\"\nfriction = 0.5\nrestitution = 1", rapier(0.5, 1.0)),
        (contact, "law = \"rapier\"\nfriction = 0", rapier(0.0, 0.0)),
    ] {
        assert_eq!(finger_with(&format!("{contact}[engine]\n{keys}\n")).engine, expected, "{keys}");
    }
}

#[test]
fn every_bound_is_applied_and_until_defaults_to_the_duration() {
    let base = Bounds::defaults_for_run(SceneKind::Finger, 0.02);
    for (keys, expected) in [
        ("angle = \"1e-3 rad\"", Bounds { angle_rad: 1e-3, ..base }),
        ("contact_time = \"2 us\"", Bounds { contact_time_s: 2e-6, ..base }),
        ("final_force = 0.5", Bounds { final_force: 0.5, ..base }),
        ("impulse = 2", Bounds { impulse: 2.0, ..base }),
        ("loop_gap = \"1 mm\"", Bounds { loop_gap_m: 1e-3, ..base }),
        ("until = \"8 ms\"", Bounds { until_s: 0.008, ..base }),
        ("until = \"20 ms\"", base),
    ] {
        assert_eq!(finger_with(&format!("[validate]\n{keys}\n")).bounds, expected, "{keys}");
    }
    let scene = scene::parse(&format!("duration = \"7 ms\"\n{DESIGN}{DRIVE}"), "test.toml").expect("scene");
    assert_eq!(scene.bounds, Bounds::defaults_for_run(SceneKind::Finger, 0.007));
}

/// `tests/broken` has the other messages. Only the wrong value is reported; keys that depend on it are not checked.
#[test]
fn wrong_settings_are_reported_once() {
    let iterations = "`engine.iterations` is 4294967297, but must be a whole number from 1 to 10000";
    for (keys, problem) in [
        ("engine.step = \"10 us\"", "`engine.step` has no effect with stepping = \"adaptive\""),
        ("engine.friction = 0.8", "`engine.friction` has no effect with law = \"scene\""),
        ("engine.law = \"scene\"\nengine.restitution = 0", "`engine.restitution` has no effect with law = \"scene\""),
        ("engine.stepping = \"fixed\"", "`engine.step` is missing"),
        ("engine.max_step = \"-1 us\"", "`engine.max_step` is -1 us, but must be above 0"),
        ("engine.iterations = 10001", "`engine.iterations` is 10001, but must be a whole number from 1 to 10000"),
        ("engine.iterations = 4294967297", iterations),
        ("engine.max_steps = 0", "`engine.max_steps` is 0, but must be a whole number from 1"),
        ("validate.contact_time = \"0 s\"", "`validate.contact_time` is 0 s, but must be above 0"),
        ("validate.impulse = inf", "`validate.impulse` is inf, but must be finite"),
        ("validate.loop_gap = \"-1 mm\"", "`validate.loop_gap` is -1 mm, but must be above 0"),
        ("validate.until = \"21 ms\"", "`validate.until` is 21 ms, but must be at most the duration of 20 ms"),
        ("engine.stepping = \"fix\"\nengine.step = \"10 us\"", "\"fix\" is not a valid value of `engine.stepping`"),
        ("engine.law = \"rapir\"\nengine.friction = 0.8", "\"rapir\" is not a valid value of `engine.law`"),
        ("duration = \"0 ms\"\nvalidate.until = \"30 ms\"", "`duration` is 0 ms, but must be above 0"),
    ] {
        let error = scene::parse(&format!("{keys}\n{DESIGN}{DRIVE}"), "test.toml").expect_err(keys);
        let messages: Vec<&str> = error.problems().iter().map(|p| p.message.as_str()).collect();
        assert_eq!(messages, [problem]);
    }
}
