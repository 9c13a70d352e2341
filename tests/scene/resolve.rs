//! Scenes of a finger are resolved with their defaults and with given keys.

use phalanx::gripper::{self, Design, ProximalLength};
use phalanx::law::{Bristle, FrictionLaw, NormalLaw};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{
    self, Actuation, Bounds, Engine, Integrator, Interpolation, Method, Placement, Preset, Scene, SpringKind,
};
use phalanx::shape::max_radius;

use super::common::{DESIGN, DRIVE, finger_with, parse};

const LENGTHS: &str = "[lengths]\nl21 = \"24 mm\"\nl22 = \"7.5 mm\"\nt22 = \"13 mm\"\nphi22 = \"120 deg\"\n[object]\n\
                       centre = [\"-15.5 mm\", \"20 mm\"]\n";

#[test]
fn a_short_scene_has_the_parameters_of_table_3_2() {
    let scene = finger_with("");
    assert_eq!(scene.name, "test");
    let design = Design::thesis(0.0155, ProximalLength::Fraction(1.0), 120f64.to_radians(), 0.5);
    assert_eq!(Ok(scene.finger().linkage.lengths), gripper::lengths(&design));
    assert_eq!(gripper::bodies(&scene.finger().linkage.lengths, 1070.0, 0.04), Ok(scene.finger().linkage.bodies));
    let object = scene.object().expect("object");
    assert_eq!((max_radius(&object.shape), object.centre_m), (0.02, [-0.0155, 0.02]));
    assert!(scene.system.palm.is_some());
    let limit = NormalLaw { stiffness_n_per_m_e: 1e11, exponent: 2.2, damping_max_n_s_per_m: 1e9, transition_m: 1e-5 };
    assert_eq!(scene.finger().limit, Some(limit));
    let contact = NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };
    for law in [scene.finger().contact.proximal, scene.finger().contact.distal] {
        assert_eq!((law.normal, law.friction), (contact, None));
    }
    assert_eq!((scene.system.gravity_m_s2, scene.duration_s), ([0.0, 9.81], 0.02));
    assert_eq!(scene.finger().motor.actuation, Actuation::Constant { torque_n_m: 0.48 });
    let spring = scene.finger().spring.expect("spring");
    assert_eq!((spring.kind, spring.placement), (SpringKind::Constant { torque_n_m: 0.1326 }, Placement::Phalanges));
    assert_eq!(scene.integrator, Integrator::preset(Preset::Engineering));
    assert_eq!((scene.engine, scene.bounds), (Engine::DEFAULT, Bounds::defaults_for_run(SceneKind::Finger, 0.02)));
    assert_eq!((scene.log.numeric_hz, scene.log.picture_hz), (1e4, 5e3));
    assert_eq!((scene.finger().initial.qd11_rad_s, scene.finger().initial.qd21_rad_s), (0.0, 0.0));
}

#[test]
fn single_keys_override_the_preset() {
    let scene = finger_with("[integrator]\npreset = \"reference\"\nrtol = 1e-9\nmax_steps = 5\n");
    // Absolute tolerances default to multiples of the relative one.
    let expected = Integrator { max_steps: 5, ..Integrator::preset(Preset::Reference).with_rtol(1e-9) };
    assert!((expected.atol_angle_rad / 1e-12 - 1.0).abs() < 1e-12);
    assert_eq!(scene.integrator, expected);
    assert_eq!(expected.method, Method::RadauIIa5);
}

/// One contact may have a bristle while the other has none. The damping of a bristle defaults to that of its normal
/// law.
#[test]
fn stiction_applies_only_to_contacts_with_bristles() {
    let scene = finger_with(
        "[contact.friction]\nmu_static = 0.8\n[contact.proximal]\ndamping = \"5e5 N*s/m\"\n[contact.proximal.friction]\n\
         law = \"bristle\"\nbristle_relaxation = \"2 ms\"\n",
    );
    assert_eq!(scene.finger().contact.proximal.bristle(), Some(Bristle { damping_n_s_per_m: 5e5, relaxation_s: 2e-3 }));
    assert!(scene.finger().contact.distal.bristle().is_none() && scene.system.has_stiction());
    let scene =
        finger_with("[contact.friction]\nmu_static = 0.8\nlaw = \"bristle\"\nbristle_damping = \"3e4 N*s/m\"\n");
    let bristles = [scene.finger().contact.proximal, scene.finger().contact.distal].map(|law| law.bristle());
    assert_eq!(bristles, [Some(Bristle { damping_n_s_per_m: 3e4, relaxation_s: 1e-3 }); 2]);
    assert!(!finger_with("[contact.friction]\nmu_static = 0.8\n").system.has_stiction());
    // A contact that repeats the law keeps the other common keys.
    let scene = finger_with(
        "[contact.friction]\nmu_static = 0.8\nlaw = \"bristle\"\nbristle_relaxation = \"2 ms\"\n[contact.distal.friction]\n\
         law = \"bristle\"\n",
    );
    assert_eq!(scene.finger().contact.distal.bristle(), scene.finger().contact.proximal.bristle());
}

#[test]
fn friction_of_one_contact_overrides_the_common_one() {
    let scene = finger_with(
        "[contact.friction]\nmu_static = 0.8\nmu_dynamic = 0.7\nv_dynamic = \"0.3 m/s\"\n[contact.distal.friction]\n\
         mu_static = 0.4\n[contact.distal]\ndamping = \"5 N*s/m\"\n",
    );
    let proximal =
        FrictionLaw { mu_static: 0.8, mu_dynamic: 0.7, v_static_m_s: 0.1, v_dynamic_m_s: 0.3, bristle: None };
    assert_eq!(scene.finger().contact.proximal.friction, Some(proximal));
    let distal = FrictionLaw { mu_static: 0.4, mu_dynamic: 0.28, ..proximal };
    assert_eq!(scene.finger().contact.distal.friction, Some(distal));
    assert_eq!(scene.finger().contact.proximal.normal.damping_max_n_s_per_m, 1e6);
    assert_eq!(scene.finger().contact.distal.normal.damping_max_n_s_per_m, 5.0);
    assert_eq!(scene.finger().contact.distal.normal.stiffness_n_per_m_e, 1e8);
    // Only one contact is frictionless; the other has the exact default of `mu_dynamic`.
    let scene = finger_with("[contact.friction]\nmu_static = 0.8\n[contact.distal.friction]\nmu_static = 0\n");
    assert_eq!(scene.finger().contact.proximal.friction.map(|f| f.mu_dynamic), Some(0.56));
    assert_eq!(scene.finger().contact.distal.friction, None);
}

#[test]
fn materials_give_the_hertz_law() {
    // Rigid object of radius R on a soft flat: E* = E/(1 − ν²), k = 4/3 E* √R.
    let scene = finger_with(
        "[contact.materials]\nobject = { modulus = \"1e12 GPa\", poisson = 0.3 }\n\
         phalanx = { modulus = \"10 MPa\", poisson = 0.5 }\n[contact.distal]\nstiffness_si = 1e7\n",
    );
    let law = scene.finger().contact.proximal.normal;
    let k = 4.0 / 3.0 * 10e6 / 0.75 * 0.02f64.sqrt();
    assert!((law.stiffness_n_per_m_e / k - 1.0).abs() < 1e-12, "{law:?}");
    assert_eq!(law.exponent, 1.5);
    assert_eq!(scene.finger().contact.distal.normal.stiffness_n_per_m_e, 1e7);
    // A rounded phalanx of the same radius halves R.
    let scene = finger_with(
        "[contact.materials]\nobject = { modulus = \"1e12 GPa\", poisson = 0.3 }\n\
         phalanx = { modulus = \"10 MPa\", poisson = 0.5, radius = \"20 mm\" }\n",
    );
    let ratio = scene.finger().contact.proximal.normal.stiffness_n_per_m_e / k;
    assert!((ratio - 0.5f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_mass_alone_scales_the_inertia() {
    let plain = finger_with("").finger().linkage.bodies;
    let scene = finger_with(
        "[bodies]\nl21 = { mass = \"4.73 g\" }\nl22 = { com = [\"1 mm\", \"-2 mm\"], inertia = \"500 g*mm^2\" }\n",
    );
    let bodies = scene.finger().linkage.bodies;
    assert_eq!((bodies.l11, bodies.l12), (plain.l11, plain.l12));
    assert_eq!(bodies.l21.mass_kg, 4.73e-3);
    assert_eq!(bodies.l21.com_m, plain.l21.com_m);
    let scale = bodies.l21.mass_kg / plain.l21.mass_kg;
    assert!((bodies.l21.inertia_kg_m2 / plain.l21.inertia_kg_m2 / scale - 1.0).abs() < 1e-14);
    assert_eq!((bodies.l22.mass_kg, bodies.l22.com_m), (plain.l22.mass_kg, [1e-3, -2e-3]));
    assert_eq!(bodies.l22.inertia_kg_m2, 5e-7);
}

#[test]
fn a_fully_specified_distal_body_needs_no_outline() {
    let flat = LENGTHS.replace("120 deg", "179.9999999 deg");
    let body = "[bodies.l22]\nmass = \"5 g\"\ncom = [\"0 mm\", \"0 mm\"]\ninertia = \"500 g*mm^2\"\n";
    let scene = parse(&format!("{flat}{DRIVE}{body}"));
    assert_eq!(scene.finger().linkage.bodies.l22.mass_kg, 5e-3);
}

#[test]
fn l12_follows_from_the_straight_configuration() {
    let scene = parse(&format!("{LENGTHS}{DRIVE}"));
    let l = scene.finger().linkage.lengths;
    let (sin, cos) = l.phi22_rad.sin_cos();
    assert_eq!(l.l12_m, (0.015 - 0.0075 * sin).hypot(0.024 + 0.0075 * cos));
    // The initial posture is straight, so l11 is 90° behind l21.
    assert!(
        (scene.finger().initial.q21_rad - scene.finger().initial.q11_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12
    );
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
    let degrees =
        |scene: &Scene| (scene.finger().initial.q11_rad.to_degrees(), scene.finger().initial.q21_rad.to_degrees());
    let assert_near =
        |(a, b): (f64, f64), (c, d): (f64, f64)| assert!((a - c).abs() < 1e-9 && (b - d).abs() < 1e-9, "{a} {b}");
    let default = degrees(&finger_with(""));
    assert_near(degrees(&finger_with("[initial]\noffset = \"20 deg\"\n")), (default.0 + 5.0, default.1 + 5.0));
    assert_near(degrees(&finger_with("[initial]\nq21 = \"30 deg\"\n")), (-60.0, 30.0));
    assert_near(degrees(&finger_with("[initial]\nq21 = \"30 deg\"\nq11 = \"-50 deg\"\n")), (-50.0, 30.0));
    // Without an object, the posture follows from the object of the design.
    assert_near(degrees(&finger_with("[object]\npresent = false\n")), default);
    let scene = finger_with("[initial]\nqd11 = \"60 rpm\"\nqd21 = \"-1 rad/s\"\n");
    assert!((scene.finger().initial.qd11_rad_s - std::f64::consts::TAU).abs() < 1e-14);
    assert_eq!(scene.finger().initial.qd21_rad_s, -1.0);
}

#[test]
fn motor_profiles_are_resolved() {
    let motor = |text: &str| {
        parse(&format!("{DESIGN}[spring]\ntype = \"none\"\n[motor]\n{text}\n")).finger().motor.actuation.clone()
    };
    let (torque_n_m, points) = (0.48, vec![(0.0, 0.0), (0.005, 0.48)]);
    for (text, expected) in [
        (
            "profile = \"table\"\ntimes = [\"0 ms\", \"5 ms\"]\ntorques = [\"0 N*mm\", \"480 N*mm\"]",
            Actuation::Table { points, interpolation: Interpolation::Linear },
        ),
        ("profile = \"ramp\"\ntorque = \"480 N*mm\"\nrise = \"2 ms\"", Actuation::Ramp { torque_n_m, rise_s: 0.002 }),
        (
            "profile = \"half-sine\"\ntorque = \"480 N*mm\"\npulse = \"8 ms\"",
            Actuation::HalfSine { torque_n_m, length_s: 0.008 },
        ),
        (
            "profile = \"reversal\"\ntorque = \"480 N*mm\"\nreverse_at = \"10 ms\"",
            Actuation::Reversal { torque_n_m, at_s: 0.01 },
        ),
    ] {
        assert_eq!(motor(text), expected);
    }
}

#[test]
fn line_endings_and_byte_order_marks_are_ignored() {
    let unix = finger_with("");
    let mut dos = parse(&format!("\u{feff}{DESIGN}{DRIVE}").replace('\n', "\r\n"));
    dos.source = unix.source.clone();
    assert_eq!(dos, unix);
}
