//! Scenes of grippers: defaults, overrides of one finger, initial postures, sizing.

use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{
    self, Bounds, HandContact, Integrator, Motor, ObjectMotion, Placement, Preset, Profile, Scene, Side, SpringKind,
    Thresholds, show,
};
use phalanx::shape::PlacedShape;
use phalanx::sizing::{INTERVALS, Rule, Task, size_with};

use super::{DESIGN, DRIVE, assert_round_trip, parse};
use crate::support::reference_cases::reference_case;

/// Parses the gripper of design 95, with `top` above and `rest` below its sections.
#[track_caller]
fn scene_with(top: &str, rest: &str) -> Scene {
    parse(&format!("kind = \"gripper\"\n{top}{DESIGN}{DRIVE}{rest}"))
}

#[test]
fn a_minimal_gripper_has_the_specified_defaults() {
    let scene = scene_with("", "");
    let expected = reference_case("a").scene;
    let [right, left] = scene.hand.fingers.as_slice() else { panic!("two fingers") };
    assert_eq!(right, left);
    assert_eq!((scene.name.as_str(), scene.duration_s, scene.hand.gravity_m_s2), ("test", 0.02, [0.0, 9.81]));
    assert_eq!(
        (scene.hand.palm_width_m, scene.hand.grasped().centre_m, scene.hand.grasped().angle_rad),
        (0.031, [0.0, 0.02], 0.0)
    );
    let mass_and_inertia = |scene: &Scene| match scene.hand.grasped().motion {
        ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } => [mass_kg, inertia_kg_m2],
        other => panic!("{other:?}"),
    };
    for (actual, expected) in mass_and_inertia(&scene).into_iter().zip(mass_and_inertia(&expected)) {
        assert!((actual / expected - 1.0).abs() < 1e-14, "{actual} {expected}");
    }
    let start = &right.initial;
    assert!((start.q11_rad - expected.hand.fingers[0].initial.q11_rad).abs() < 1e-9, "{start:?}");
    assert!((start.q21_rad - expected.hand.fingers[0].initial.q21_rad).abs() < 1e-9, "{start:?}");
    assert!(scene.hand.palm.is_some() && scene.hand.table.is_none() && scene.hand.differential.is_none());
    assert_eq!((right.motor.inertia_kg_m2, right.motor.no_load_speed_rad_s), (0.0, None));
    assert_eq!(scene.bounds, Bounds::defaults_for_run(SceneKind::Gripper, 0.02));
    assert_eq!((scene.integrator.preset, scene.integrator.rtol), (Preset::Engineering, 3e-6));
    assert_round_trip(&scene);
}

#[test]
fn criteria_thresholds_default_from_duration_and_torque() {
    let assert_near =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-12, "{found}, not {expected}");
    let defaults = scene_with("", "").thresholds;
    assert_near(defaults.loss_time_s, 1e-4);
    assert_near(defaults.held_time_s, 1e-3);
    assert_near(defaults.loss_force_n, 1e-4 * 0.48 / 0.02443242165159721);
    let short_run = scene_with("duration = \"2 ms\"\n", "");
    assert_near(short_run.thresholds.loss_time_s, 1e-5);
    assert_near(short_run.thresholds.held_time_s, 1e-4);
    assert_round_trip(&short_run);
    let explicit = scene_with("", "[criteria]\nloss_time = \"0 ms\"\nloss_force = \"5 mN\"\nheld_time = \"2 ms\"\n");
    let expected = Thresholds { loss_time_s: 0.0, loss_force_n: 5e-3, held_time_s: 2e-3 };
    assert_eq!(explicit.thresholds, expected);
    assert_round_trip(&explicit);
    let text = format!("kind = \"gripper\"\n{DESIGN}{DRIVE}[criteria]\nheld_time = \"21 ms\"\n");
    let error = scene::parse_any(&text, "test.toml").expect_err("longer than the run").to_string();
    assert!(error.contains("`criteria.held_time` is 21 ms, but must be at most the duration of 20 ms"), "{error}");
    // Scenes of a single finger use the criteria of the thesis and reject [criteria].
    let error = scene::parse_any(&format!("{DESIGN}{DRIVE}[criteria]\nloss_time = \"1 ms\"\n"), "test.toml");
    assert!(error.is_err_and(|error| error.to_string().contains("criteria")));
}

#[test]
fn the_engineering_preset_of_grippers_has_its_own_tolerance() {
    let integrator_with = |text: &str| scene_with("", &format!("[integrator]\n{text}\n")).integrator;
    assert_eq!(integrator_with("preset = \"engineering\""), scene_with("", "").integrator);
    assert_eq!(integrator_with("preset = \"engineering\"\nrtol = 1e-5").rtol, 1e-5);
    let mut scene = scene_with("", "[integrator]\npreset = \"reference\"\nmax_steps = 77\n");
    assert_eq!((scene.integrator.rtol, scene.integrator.max_steps), (1e-11, 77));
    scene.apply_preset(Preset::Engineering);
    assert_eq!(scene.integrator, Integrator { max_steps: 77, ..scene_with("", "").integrator });
}

#[test]
fn both_fingers_start_at_the_posture_of_the_nearer_one() {
    let case_c = scene_with("palm_width = \"34 mm\"\n", "[object]\noffset = \"3.5 mm\"\n[table]\n");
    let expected = reference_case("c").scene;
    for (actual, expected) in case_c.hand.fingers.iter().zip(&expected.hand.fingers) {
        assert!((actual.initial.q11_rad - expected.initial.q11_rad).abs() < 1e-9, "{:?}", actual.initial);
        assert!((actual.initial.q21_rad - expected.initial.q21_rad).abs() < 1e-9, "{:?}", actual.initial);
    }
    assert_eq!(case_c.hand.fingers[0].initial, case_c.hand.fingers[1].initial);
    // The posture depends on the expected positioning error, not on the offset of the object.
    let starts = |scene: &Scene| scene.hand.fingers.iter().map(|finger| finger.initial).collect::<Vec<_>>();
    let start = |offset: &str| {
        let top = "palm_width = \"34 mm\"\npositioning_error = \"3.5 mm\"\n";
        starts(&scene_with(top, &format!("[object]\noffset = \"{offset}\"\n")))
    };
    for offset in ["0 mm", "-1 mm", "3.5 mm", "-3.5 mm"] {
        assert_eq!(start(offset), starts(&case_c), "{offset}");
    }
}

/// A design that reaches the object at bases from 13.5 to 20.5 mm.
const SHORT: &str = "[design]\nbase = \"17 mm\"\nl21_fraction = 0.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";

#[test]
fn motors_and_springs_are_sized_for_the_whole_positioning_error() {
    let top = "palm_width = \"34 mm\"\nsizing = \"rigid\"\npositioning_error = \"3.5 mm\"\n";
    let sized_scene = |design: &str, rest: &str| parse(&format!("kind = \"gripper\"\n{top}{design}{rest}"));
    let size_for_base = |scene: &Scene, base_m: f64| {
        let disc = PlacedShape::disc(0.02, [-base_m, 0.02]);
        let task = Task {
            object: disc,
            opening_rad: 25f64.to_radians(),
            gravity_m_s2: scene.hand.gravity_m_s2,
            closing_s: 0.01,
        };
        size_with(&scene.hand.finger(Side::Right).linkage, &task, Rule::Rigid, Placement::Phalanges, INTERVALS)
    };
    let drive_torques = |scene: &Scene| {
        let driven_finger = scene.hand.finger(Side::Right);
        let SpringKind::Constant { torque_n_m } = driven_finger.spring.expect("a spring").kind else {
            panic!("{driven_finger:?}")
        };
        [driven_finger.motor.actuation.at(0.0).0, torque_n_m]
    };
    let assert_equal = |drive_torques: [f64; 2], expected: [f64; 2]| {
        assert!(
            drive_torques.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12 * b),
            "{drive_torques:?} {expected:?}"
        );
    };
    let scene = sized_scene(SHORT, "");
    let [narrow_base, wide_base] = [0.0135, 0.0205].map(|base_m| size_for_base(&scene, base_m).expect("a size"));
    assert!(
        narrow_base.motor_n_m != wide_base.motor_n_m && narrow_base.spring_n_m != wide_base.spring_n_m,
        "the sizes of both ends differ"
    );
    assert_equal(
        drive_torques(&scene),
        [narrow_base.motor_n_m.max(wide_base.motor_n_m), narrow_base.spring_n_m.max(wide_base.spring_n_m)],
    );
    // With the smallest base, the tip of design 95 does not reach around the object; only the largest base is sized.
    let scene = sized_scene(DESIGN, "");
    let wide_base = size_for_base(&scene, 0.0205).expect("a size");
    assert!(size_for_base(&scene, 0.0135).is_err());
    assert_equal(drive_torques(&scene), [wide_base.motor_n_m, wide_base.spring_n_m]);
    // A differential has one motor for both fingers.
    let seesaw = sized_scene(SHORT, "[differential]\n");
    let input = &seesaw.hand.differential.as_ref().expect("it is given").motor;
    let single_torque_n_m = drive_torques(&sized_scene(SHORT, ""))[0];
    assert_eq!(input.actuation.at(0.0).0, 2.0 * single_torque_n_m);
    assert_eq!(seesaw.hand.fingers.iter().map(|finger| &finger.motor).collect::<Vec<_>>(), [&Motor::NONE; 2]);
    assert_round_trip(&seesaw);
}

#[test]
fn each_finger_can_override_common_keys() {
    let scene = scene_with(
        "palm_width = \"34 mm\"\nhalf_width = \"2 mm\"\n",
        "[contact.friction]\nmu_static = 0.8\n[contact.distal]\ndamping = \"2e5 N*s/m\"\n[contact.palm.friction]\nmu_static = 0.1\n\
         [right]\nhalf_width = \"3 mm\"\n[right.motor]\nprofile = \"ramp\"\ntorque = \"500 N*mm\"\nrise = \"1 ms\"\n\
         inertia = \"1e-6 kg*m^2\"\n[left.lengths]\nl21 = \"23 mm\"\nl22 = \"7 mm\"\nt22 = \"13 mm\"\nphi22 = \"118 deg\"\n\
         [left.spring]\ntype = \"torsional\"\nstiffness = \"40 N*mm/rad\"\n[left.contact.friction]\nmu_static = 0.3\n",
    );
    let [right, left] = scene.hand.fingers.as_slice() else { panic!("two fingers") };
    assert_eq!((right.linkage.lengths.half_width_m, left.linkage.lengths.half_width_m), (0.003, 0.002));
    assert_eq!(right.motor.actuation, Profile::Ramp { value: 0.5, rise_s: 1e-3 });
    assert_eq!((right.motor.inertia_kg_m2, left.motor.inertia_kg_m2), (1e-6, 0.0));
    assert_eq!(left.motor.actuation, Profile::Constant { value: 0.48 });
    assert_eq!((left.linkage.lengths.l21_m, right.linkage.lengths.l22_m), (0.023, 0.0075));
    assert!(matches!(left.spring.expect("it is given").kind, SpringKind::Torsional { .. }));
    assert!(matches!(right.spring.expect("it is given").kind, SpringKind::Constant { .. }));
    assert_eq!((right.contact.mu_static(), left.contact.mu_static()), ([0.8; 2], [0.3; 2]));
    assert_eq!(left.contact.distal.normal.damping_max(), 2e5);
    assert_eq!(scene.hand.law(HandContact::Palm).and_then(|law| law.friction).map(|law| law.mu_static), Some(0.1));
    assert_round_trip(&scene);
}

#[test]
fn table_differential_and_inertias_are_applied() {
    let scene = scene_with(
        "",
        "[table]\n[contact.table]\nstiffness_si = 1e6\nexponent = 1.5\n[object]\nheight = \"21 mm\"\n\
         radius = \"20.5 mm\"\n[differential]\ninput_inertia = \"2e-5 kg*m^2\"\nseesaw_inertia = \"5e-6 kg*m^2\"\n",
    );
    let table = scene.hand.table.expect("a table");
    assert!((table.level_m - 0.0415).abs() < 1e-17, "the table touches the object: {}", table.level_m);
    assert_eq!(table.contact.expect("a law").normal.stiffness_n_per_m_e, 1e6);
    assert_eq!(scene.hand.law(HandContact::Palm).expect("a palm").normal.stiffness_n_per_m_e, 1e8);
    let differential = scene.hand.differential.as_ref().expect("it is given");
    assert_eq!((differential.motor.inertia_kg_m2, differential.seesaw_inertia_kg_m2), (2e-5, 5e-6));
    assert_round_trip(&scene);
    // A scene can remove palm, table and differential of the scene that it extends.
    let without = scene_with("palm = false\n", "[table]\npresent = false\n[differential]\npresent = false\n");
    assert!(without.hand.table.is_none() && without.hand.differential.is_none() && without.hand.palm.is_none());
    assert_round_trip(&without);
}

#[test]
fn the_base_sets_the_palm_width_and_motions_keep_their_names() {
    let lengths =
        "[lengths]\nbase = \"14 mm\"\nl21 = \"24 mm\"\nl22 = \"7.5 mm\"\nt22 = \"13 mm\"\nphi22 = \"120 deg\"\n";
    let moves = "[moves.lift]\nx = \"1 mm\"\ny = \"-25 mm\"\nstart = \"1 ms\"\nacceleration = \"2 g\"\n\
                 [vibrations.shake]\nx = \"1 um\"\nfrequency = \"1 kHz\"\n";
    let scene = parse(&format!("kind = \"gripper\"\n{lengths}{DRIVE}[object]\nradius = \"18 mm\"\n{moves}"));
    assert_eq!((scene.hand.palm_width_m, scene.hand.grasped().centre_m), (0.028, [0.0, 0.018]));
    let text = show(&scene);
    assert!(
        text.contains("[moves.lift]\nx = \"1 mm\"\ny = \"-25 mm\"\n") && text.contains("[vibrations.shake]"),
        "{text}"
    );
    assert_round_trip(&scene);
    let text = format!("kind = \"gripper\"\npalm_width = \"28 mm\"\n{lengths}{DRIVE}");
    let error = scene::parse_any(&text, "test.toml").expect_err("twice").to_string();
    assert!(error.contains("`lengths.base` has no effect with palm_width"), "{error}");
}
