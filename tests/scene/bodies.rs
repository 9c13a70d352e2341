//! Scenes of discs: defaults, keys, round trips, and messages.

use phalanx::law::{ContactLaw, FrictionLaw, NormalLaw};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Bounds, ContactId, DiscMotion, Engine, HalfPlane, Integrator, Preset, Response, Scene};
use phalanx::shape::max_radius;
use proptest::prelude::*;
use serde_json::Value;

use super::{assert_round_trip, parse};
use crate::support::cli::{path_text, succeed};

const BALL: &str = "[discs.ball]\nradius = \"20 mm\"\ncentre = [\"1 mm\", \"25 mm\"]\nmass = \"50 g\"\n";

/// Returns the law of all contacts.
fn law(scene: &Scene) -> ContactLaw {
    scene.system.between_discs.expect("a law")
}

fn scene_with(rest: &str) -> Scene {
    parse(&format!("kind = \"bodies\"\n{BALL}{rest}"))
}

#[test]
fn a_short_scene_has_the_defaults() {
    let scene = scene_with("");
    assert_eq!((scene.name.as_str(), scene.description.as_str()), ("test", ""));
    assert_eq!((scene.system.gravity_m_s2, scene.duration_s, scene.system.palm), ([0.0; 2], 0.02, None));
    let [ball] = scene.system.discs.as_slice() else { panic!("{:?}", scene.system.discs) };
    assert_eq!((ball.name.as_str(), max_radius(&ball.shape), ball.centre_m), ("ball", 0.02, [0.001, 0.025]));
    // A homogeneous disc: m r²/2 = 0.05 × 0.02²/2.
    let DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } = ball.motion else { panic!("{ball:?}") };
    assert_eq!((mass_kg, velocity_m_s, spin_rad_s), (0.05, [0.0; 2], 0.0));
    assert!((inertia_kg_m2.expect("it rotates") - 1e-5).abs() < 1e-19);
    let normal = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);
    assert_eq!((law(&scene).normal, law(&scene).friction), (normal, None));
    assert_eq!((scene.integrator, scene.engine), (Integrator::preset(Preset::Engineering), Engine::DEFAULT));
    assert_eq!((scene.bounds, scene.log.numeric_hz), (Bounds::defaults_for_run(SceneKind::Bodies, 0.02), 1e4));
}

#[test]
fn every_key_is_applied() {
    let scene = parse(
        "name = \"all\"\ndescription = \"of them\"\nkind = \"bodies\"\nduration = \"7 ms\"\n\
         gravity = [\"1 m/s^2\", \"-9.81 m/s^2\"]\n\
         [discs.b]\nradius = \"1 cm\"\ncentre = [\"0 mm\", \"1 mm\"]\nmotion = \"driven\"\nvelocity = [\"1 m/s\", \"2 m/s\"]\n\
         acceleration = [\"3 m/s^2\", \"4 m/s^2\"]\nspin = \"5 rad/s\"\n\
         [discs.a]\nradius = \"2 cm\"\ncentre = [\"0 mm\", \"30 mm\"]\nvelocity = [\"-1 m/s\", \"0 m/s\"]\nspin = \"60 rpm\"\n\
         mass = \"2 kg\"\ninertia = \"3 kg*m^2\"\n\
         [discs.d]\nradius = \"1 mm\"\ncentre = [\"0 mm\", \"90 mm\"]\nmass = \"1 g\"\nrotates = false\n\
         [discs.c]\nradius = \"1 mm\"\ncentre = [\"0 mm\", \"80 mm\"]\nmotion = \"fixed\"\n\
         [half_plane]\nlevel = \"-3 mm\"\n\
         [contact]\nstiffness_si = 5\nexponent = 1\ndamping = \"0 N*s/m\"\ntransition = \"1 mm\"\n[contact.friction]\n\
         mu_static = 0.5\n[engine]\nlaw = \"rapier\"\nrestitution = 0.4\n[validate]\nposition = \"2 um\"\n\
         contact_time = \"3 us\"\nimpulse = 0.04\npeak_force = 0.05\nuntil = \"6 ms\"\n[log]\nnumeric_rate = \"1 kHz\"\n",
    );
    assert_eq!((scene.name.as_str(), scene.description.as_str(), scene.duration_s), ("all", "of them", 7e-3));
    assert_eq!(
        (scene.system.gravity_m_s2, scene.system.palm),
        ([1.0, -9.81], Some(HalfPlane { level_m: -3e-3, contact: scene.system.between_discs }))
    );
    let names: Vec<&str> = scene.system.discs.iter().map(|disc| disc.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "c", "d"], "in the order of their names");
    let motions: Vec<DiscMotion> = scene.system.discs.iter().map(|disc| disc.motion).collect();
    let spin_rad_s = std::f64::consts::TAU;
    let free = |mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s| DiscMotion::Free {
        mass_kg,
        inertia_kg_m2,
        velocity_m_s,
        spin_rad_s,
    };
    assert_eq!(motions[0], free(2.0, Some(3.0), [-1.0, 0.0], spin_rad_s));
    let driven = DiscMotion::Driven { velocity_m_s: [1.0, 2.0], acceleration_m_s2: [3.0, 4.0], spin_rad_s: 5.0 };
    assert_eq!(motions[1], driven);
    assert_eq!(motions[2], DiscMotion::Fixed);
    assert_eq!(motions[3], free(1e-3, None, [0.0; 2], 0.0));
    let normal = NormalLaw::step(5.0, 1.0, 0.0, 1e-3);
    let friction =
        FrictionLaw { mu_static: 0.5, mu_dynamic: 0.35, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: None };
    assert_eq!((law(&scene).normal, law(&scene).friction), (normal, Some(friction)));
    assert_eq!(scene.engine.response, Response::Rapier { friction: 0.5, restitution: 0.4 });
    let bounds = Bounds {
        position_m: 2e-6,
        contact_time_s: 3e-6,
        impulse: 0.04,
        peak_force: 0.05,
        ..Bounds::defaults_for_run(SceneKind::Bodies, 6e-3)
    };
    assert_eq!((scene.bounds, scene.log.numeric_hz), (bounds, 1e3));
    assert_round_trip(&scene);
}

#[test]
fn pairs_include_a_moving_disc_and_are_named() {
    let scene = scene_with(
        "[half_plane]\n[discs.anvil]\nradius = \"10 mm\"\ncentre = [\"60 mm\", \"20 mm\"]\nmotion = \"fixed\"\n\
         [discs.post]\nradius = \"10 mm\"\ncentre = [\"90 mm\", \"20 mm\"]\nmotion = \"fixed\"\n",
    );
    let names: Vec<String> = scene.system.pairs().into_iter().map(|pair| scene.system.contact_name(pair)).collect();
    assert_eq!(names, ["ball-anvil", "ball-post", "ball-plane"]);
    assert_eq!(scene.system.pairs()[2], ContactId::Palm(1));
}

#[test]
fn initial_overlaps_and_laws_without_spring_or_damper_are_accepted() {
    let post = "[discs.post]\nradius = \"20 mm\"\ncentre = [\"1 mm\", \"55 mm\"]\nmotion = \"fixed\"\n";
    scene_with(&format!("{post}[half_plane]\nlevel = \"10 mm\"\n"));
    assert_eq!(law(&scene_with("[contact]\nstiffness_si = 0\n")).normal.stiffness_n_per_m_e, 0.0);
    assert_eq!(law(&scene_with("[contact]\ndamping = \"0 N*s/m\"\n")).normal.damping_max(), 0.0);
}

#[test]
fn scenes_of_discs_are_rejected_where_a_finger_is_required() {
    let text = format!("kind = \"bodies\"\n{BALL}");
    let error = scene::parse(&text, "ball.toml").expect_err("discs");
    assert_eq!(
        error.to_string(),
        "error: this is a scene of kind \"bodies\", but a scene of kind \"finger\" is required\n --> ball.toml:1:8\n  |\n\
         1 | kind = \"bodies\"\n  |        ^^^^^^^^ another kind\n  = help: give the scene of a finger; \
         `phalanx run`, `validate` and `scene` accept the other kinds"
    );
}

/// One schema covers all kinds, and rejects keys of other kinds.
#[test]
fn the_schema_separates_the_scene_kinds() {
    let schema: Value = serde_json::from_str(&scene::schema()).expect("JSON");
    assert_eq!(
        schema["if"],
        serde_json::json!({ "properties": { "kind": { "const": "bodies" } }, "required": ["kind"] })
    );
    let rest = &schema["else"];
    assert_eq!(rest["if"]["properties"]["kind"]["const"], "gripper");
    let last = &rest["else"];
    assert_eq!(last["if"]["properties"]["kind"]["const"], "mechanism");
    let [discs, gripper, mechanism, finger] = [&schema["then"], &rest["then"], &last["then"], &last["else"]];
    for (kind, accepted, rejected) in [
        (discs, "discs", ["design", "palm_width"]),
        (gripper, "palm_width", ["discs", "half_plane"]),
        (mechanism, "joints", ["discs", "design"]),
        (finger, "design", ["discs", "palm_width"]),
    ] {
        assert_eq!(kind["additionalProperties"], Value::Bool(false));
        assert!(kind["properties"].get(accepted).is_some());
        assert!(rejected.iter().all(|other| kind["properties"].get(other).is_none()));
        assert_eq!(kind["properties"]["kind"]["enum"], serde_json::json!(["finger", "bodies", "gripper", "mechanism"]));
    }
    assert_eq!(
        schema["then"]["properties"]["discs"]["additionalProperties"]["additionalProperties"],
        Value::Bool(false)
    );
}

#[test]
fn scene_commands_accept_discs() {
    let file = std::env::temp_dir().join(format!("phalanx-{}-discs.toml", std::process::id()));
    let text = format!(
        "kind = \"bodies\"\n{BALL}[half_plane]\n[discs.anvil]\nradius = \"10 mm\"\ncentre = [\"60 mm\", \"20 mm\"]\n\
         motion = \"fixed\"\n"
    );
    std::fs::write(&file, text).expect("write");
    let [shown, checked] = ["show", "check"].map(|command| succeed(&["scene", command, path_text(&file)]));
    let _ = std::fs::remove_file(&file);
    assert_round_trip(&parse(&shown));
    assert!(
        checked.ends_with("valid: discs: free ball; fixed anvil; half plane at 0.00 mm; 2 pairs; 20.0 ms\n"),
        "{checked}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_numbers_round_trip_exactly(
        radius in 1e-6..1.0f64, x in -1.0..1.0f64, mass in 1e-9..1e3f64, velocity in -1e3..1e3f64, spin in -1e4..1e4f64,
        gravity in -1e2..1e2f64, level in -10.0..-2.0f64, k in 0.0..1e25f64, exponent in 1.0..3.0f64, c in 1e-9..1e9f64,
        bound in 1e-12..1e3f64, duration in 1e-9..1e3f64, rotates in proptest::bool::ANY, driven in proptest::bool::ANY,
        name in "[A-Za-z][A-Za-z0-9_]{0,12}",
    ) {
        prop_assume!(name != "plane" && name != "other");
        let motion = match (driven, rotates) {
            (true, _) => format!("motion = \"driven\"\nspin = \"{spin} deg/s\"\nacceleration = [\"{gravity} m/s^2\", \"{x} cm/s^2\"]"),
            (false, true) => format!("mass = \"{mass} g\"\nspin = \"{spin} rpm\""),
            (false, false) => format!("mass = \"{mass} g\"\nrotates = false"),
        };
        let text = format!(
            "kind = \"bodies\"\nduration = \"{duration} s\"\ngravity = [\"{gravity} m/s^2\", \"{x} m/s^2\"]\n\
             [discs.{name}]\nradius = \"{radius} m\"\ncentre = [\"{x} m\", \"0.1 m\"]\nvelocity = [\"{velocity} cm/s\", \"1 m/s\"]\n\
             {motion}\n[discs.other]\nradius = \"1 mm\"\ncentre = [\"9 m\", \"0 m\"]\nmass = \"{mass} kg\"\n\
             [half_plane]\nlevel = \"{level} mm\"\n\
             [contact]\nstiffness_si = {k:?}\nexponent = {exponent:?}\ndamping = \"{c} N*s/m\"\n[log]\npicture_rate = \"1 Hz\"\n[validate]\n\
             position = \"{bound} um\"\npeak_force = {bound:?}\nuntil = \"{duration} s\"\n"
        );
        assert_round_trip(&parse(&text));
    }
}
