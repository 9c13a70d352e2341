//! Scenes of discs: defaults, keys, round trips, and messages.

use phalanx::law::{ContactLaw, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::mechanism::{Mechanism, OutlineShape, PrescribedMotion};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Bounds, Engine, Integrator, Preset, Response, Scene};
use proptest::prelude::*;
use serde_json::Value;

use super::{assert_round_trip, parse};
use crate::support::cli::{path_text, succeed};

const BALL: &str = "[discs.ball]\nradius = \"20 mm\"\ncentre = [\"1 mm\", \"25 mm\"]\nmass = \"50 g\"\n";

fn mechanism(scene: &Scene) -> &Mechanism {
    scene.mechanism.as_ref().expect("discs")
}

/// Returns the law of all contacts.
fn law(scene: &Scene) -> ContactLaw {
    mechanism(scene).contacts[0].law
}

fn scene_with(rest: &str) -> Scene {
    parse(&format!("kind = \"bodies\"\n{BALL}{rest}"))
}

#[test]
fn a_short_scene_has_the_defaults() {
    let scene = scene_with("[half_plane]\n");
    assert_eq!((scene.name.as_str(), scene.description.as_str(), scene.duration_s), ("test", "", 0.02));
    let mechanism = mechanism(&scene);
    assert_eq!((mechanism.gravity_m_s2, mechanism.joints.len()), ([0.0; 2], 0));
    let [ball] = mechanism.bodies.as_slice() else { panic!("{:?}", mechanism.bodies) };
    assert_eq!((ball.name.as_str(), ball.reach_m(), ball.pose), ("ball", Some(0.02), [0.001, 0.025, 0.0]));
    // A homogeneous disc: m r²/2 = 0.05 × 0.02²/2.
    assert_eq!((ball.mass_kg, ball.rate, ball.motion.as_ref()), (0.05, [0.0; 3], None));
    assert!((ball.inertia_kg_m2 - 1e-5).abs() < 1e-19);
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
    let mechanism = mechanism(&scene);
    assert_eq!(mechanism.gravity_m_s2, [1.0, -9.81]);
    let names: Vec<&str> = mechanism.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "d"], "in the order of their names");
    let spin_rad_s = std::f64::consts::TAU;
    let [free, driven, block] = mechanism.bodies.as_slice() else { panic!("{:?}", mechanism.bodies) };
    assert_eq!((free.mass_kg, free.inertia_kg_m2, free.rate), (2.0, 3.0, [-1.0, 0.0, spin_rad_s]));
    let acceleration_m_s2 = [3.0, 4.0];
    assert_eq!(driven.rate, [1.0, 2.0, 5.0]);
    assert_eq!(driven.motion, Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2 }));
    assert_eq!((block.mass_kg, block.inertia_kg_m2, block.rate), (1e-3, f64::INFINITY, [0.0; 3]));
    let ground: Vec<_> =
        mechanism.ground_outlines.iter().map(|outline| (outline.name.as_str(), &outline.shape)).collect();
    let fixed = OutlineShape::Disc { center_m: [0.0, 0.08], radius_m: 1e-3 };
    let plane = OutlineShape::HalfPlane { point_m: [0.0, -3e-3], normal: [0.0, 1.0] };
    assert_eq!(ground, [("c", &fixed), ("plane", &plane)]);
    let normal = NormalLaw::step(5.0, 1.0, 0.0, 1e-3);
    let friction = FrictionLaw {
        mu_static: 0.5,
        mu_dynamic: 0.35,
        v_static_m_s: 0.1,
        v_dynamic_m_s: 0.2,
        kind: FrictionKind::Regularised,
    };
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
    let names: Vec<String> = mechanism(&scene).point_contacts().into_iter().map(|contact| contact.name).collect();
    assert_eq!(names, ["ball-anvil", "ball-post", "ball-plane"]);
}

#[test]
fn initial_overlaps_and_laws_without_spring_or_damper_are_accepted() {
    let post = "[discs.post]\nradius = \"20 mm\"\ncentre = [\"1 mm\", \"55 mm\"]\nmotion = \"fixed\"\n";
    scene_with(&format!("{post}[half_plane]\nlevel = \"10 mm\"\n"));
    assert_eq!(law(&scene_with("[half_plane]\n[contact]\nstiffness_si = 0\n")).normal.stiffness_n_per_m_e, 0.0);
    assert_eq!(law(&scene_with("[half_plane]\n[contact]\ndamping = \"0 N*s/m\"\n")).normal.damping_max(), 0.0);
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
    // A scene without `kind` is that of a finger, unless it inherits its kind.
    let inherited = &last["else"];
    assert_eq!(inherited["then"]["anyOf"].as_array().map(Vec::len), Some(4));
    let definition = |part: &Value| {
        let path = part["$ref"].as_str().and_then(|path| path.strip_prefix('#')).expect("a reference");
        schema.pointer(path).expect(path)
    };
    for (kind, accepted, rejected) in [
        (&schema["then"], "discs", ["design", "palm_width"]),
        (&rest["then"], "palm_width", ["discs", "half_plane"]),
        (&last["then"], "joints", ["discs", "design"]),
        (&inherited["else"], "design", ["discs", "palm_width"]),
    ] {
        let kind = definition(kind);
        assert_eq!(kind["additionalProperties"], Value::Bool(false));
        assert!(kind["properties"].get(accepted).is_some());
        assert!(rejected.iter().all(|other| kind["properties"].get(other).is_none()));
        assert_eq!(kind["properties"]["kind"]["enum"], serde_json::json!(["finger", "bodies", "gripper", "mechanism"]));
        let parameter = &kind["properties"]["parameters"]["additionalProperties"];
        assert_eq!(parameter["type"], serde_json::json!(["number", "string"]));
        let steps = &kind["properties"]["integrator"]["properties"]["max_steps"];
        assert_eq!((&steps["type"], &steps["pattern"]), (&serde_json::json!(["integer", "string"]), &"^\\s*=".into()));
    }
    assert_eq!(
        definition(&schema["then"])["properties"]["discs"]["additionalProperties"]["additionalProperties"],
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
        checked.ends_with("valid: 1 body, 0 joints, 3 degrees of freedom, 0 actuators, 2 contacts; 20.0 ms\n"),
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
