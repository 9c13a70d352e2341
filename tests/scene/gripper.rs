//! Scenes of grippers: what they say when they say little, what one finger alone has, and where both start.

use phalanx::scene::words::SceneKind;
use phalanx::scene::{
    self, Actuation, Bounds, DiscMotion, Integrator, Motor, Place, Placement, Preset, Scene, Side, SpringKind,
    Thresholds, show,
};
use phalanx::shape::Placed;
use phalanx::sizing::{INTERVALS, Rule, Task, size_with};

use crate::support::grippers::anchor;

const DESIGN: &str = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
const DRIVE: &str = "[motor]\ntorque = \"480 N*mm\"\n[spring]\ntorque = \"132.6 N*mm\"\n";

#[track_caller]
fn parse(text: &str) -> Scene {
    scene::parse_any(text, "some/where/test.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Design 95's gripper with `top` above and `rest` below.
#[track_caller]
fn with(top: &str, rest: &str) -> Scene {
    parse(&format!("kind = \"gripper\"\n{top}{DESIGN}{DRIVE}{rest}"))
}

/// `show` then `parse`: the same scene, bit for bit, but for its source.
#[track_caller]
fn comes_back(scene: &Scene) {
    let text = show(scene);
    let back = parse(&text);
    let back = Scene { source: scene.source.clone(), ..back };
    assert_eq!(format!("{back:?}"), format!("{scene:?}"), "{text}");
}

#[test]
fn a_gripper_that_says_little_is_that_of_the_specification() {
    let scene = with("", "");
    let wanted = anchor("a").scene;
    let [right, left] = scene.system.fingers.as_slice() else { panic!("two fingers") };
    assert_eq!(right, left);
    assert_eq!((scene.name.as_str(), scene.duration_s, scene.system.gravity_m_s2), ("test", 0.02, [0.0, 9.81]));
    assert_eq!(
        (scene.system.palm_width_m, scene.system.grasped().centre_m, scene.system.grasped().angle_rad),
        (0.031, [0.0, 0.02], 0.0)
    );
    let mass_and_inertia = |scene: &Scene| match scene.system.grasped().motion {
        DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } => [mass_kg, inertia_kg_m2],
        other => panic!("{other:?}"),
    };
    for (found, wanted) in mass_and_inertia(&scene).into_iter().zip(mass_and_inertia(&wanted)) {
        assert!((found / wanted - 1.0).abs() < 1e-14, "{found} {wanted}");
    }
    let start = &right.initial;
    assert!((start.q11_rad - wanted.system.fingers[0].initial.q11_rad).abs() < 1e-9, "{start:?}");
    assert!((start.q21_rad - wanted.system.fingers[0].initial.q21_rad).abs() < 1e-9, "{start:?}");
    assert!(scene.system.palm.is_some() && scene.system.table.is_none() && scene.system.differential.is_none());
    assert_eq!((right.motor.inertia_kg_m2, right.motor.no_load_speed_rad_s), (0.0, None));
    assert_eq!(scene.bounds, Bounds::over(SceneKind::Gripper, 0.02));
    assert_eq!((scene.integrator.preset, scene.integrator.rtol), (Preset::Engineering, 3e-6));
    comes_back(&scene);
}

#[test]
fn thresholds_of_criteria_follow_from_duration_and_torque_unless_given() {
    let near = |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-12, "{found}, not {wanted}");
    let usual = with("", "").thresholds;
    near(usual.loss_time_s, 1e-4);
    near(usual.held_time_s, 1e-3);
    near(usual.loss_force_n, 1e-4 * 0.48 / 0.02443242165159721);
    let short = with("duration = \"2 ms\"\n", "");
    near(short.thresholds.loss_time_s, 1e-5);
    near(short.thresholds.held_time_s, 1e-4);
    comes_back(&short);
    let given = with("", "[criteria]\nloss_time = \"0 ms\"\nloss_force = \"5 mN\"\nheld_time = \"2 ms\"\n");
    let wanted = Thresholds { loss_time_s: 0.0, loss_force_n: 5e-3, held_time_s: 2e-3 };
    assert_eq!(given.thresholds, wanted);
    comes_back(&given);
    let text = format!("kind = \"gripper\"\n{DESIGN}{DRIVE}[criteria]\nheld_time = \"21 ms\"\n");
    let error = scene::parse_any(&text, "test.toml").expect_err("longer than the run").to_string();
    assert!(error.contains("`criteria.held_time` is 21 ms, but must be at most the duration of 20 ms"), "{error}");
    // A single finger follows the thesis: it has no such section.
    let error = scene::parse_any(&format!("{DESIGN}{DRIVE}[criteria]\nloss_time = \"1 ms\"\n"), "test.toml");
    assert!(error.is_err_and(|error| error.to_string().contains("criteria")));
}

#[test]
fn the_everyday_preset_is_that_of_grippers_by_name_too() {
    let said = |text: &str| with("", &format!("[integrator]\n{text}\n")).integrator;
    assert_eq!(said("preset = \"engineering\""), with("", "").integrator);
    assert_eq!(said("preset = \"engineering\"\nrtol = 1e-5").rtol, 1e-5);
    let mut scene = with("", "[integrator]\npreset = \"reference\"\nmax_steps = 77\n");
    assert_eq!((scene.integrator.rtol, scene.integrator.max_steps), (1e-11, 77));
    scene.integrate_by(Preset::Engineering);
    assert_eq!(scene.integrator, Integrator { max_steps: 77, ..with("", "").integrator });
}

#[test]
fn both_fingers_start_where_the_nearer_one_would() {
    let case_c = with("palm_width = \"34 mm\"\n", "[object]\noffset = \"3.5 mm\"\n[table]\n");
    let wanted = anchor("c").scene;
    for (found, wanted) in case_c.system.fingers.iter().zip(&wanted.system.fingers) {
        assert!((found.initial.q11_rad - wanted.initial.q11_rad).abs() < 1e-9, "{:?}", found.initial);
        assert!((found.initial.q21_rad - wanted.initial.q21_rad).abs() < 1e-9, "{:?}", found.initial);
    }
    assert_eq!(case_c.system.fingers[0].initial, case_c.system.fingers[1].initial);
    // The error that is reckoned with decides, and not where the object happens to lie.
    let starts = |scene: &Scene| scene.system.fingers.iter().map(|finger| finger.initial).collect::<Vec<_>>();
    let start = |offset: &str| {
        let top = "palm_width = \"34 mm\"\npositioning_error = \"3.5 mm\"\n";
        starts(&with(top, &format!("[object]\noffset = \"{offset}\"\n")))
    };
    for offset in ["0 mm", "-1 mm", "3.5 mm", "-3.5 mm"] {
        assert_eq!(start(offset), starts(&case_c), "{offset}");
    }
}

/// A design that reaches the object from 13.5 to 20.5 mm.
const SHORT: &str = "[design]\nbase = \"17 mm\"\nl21_fraction = 0.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";

#[test]
fn motors_and_springs_are_sized_for_both_ends_of_the_error() {
    let top = "palm_width = \"34 mm\"\nsizing = \"rigid\"\npositioning_error = \"3.5 mm\"\n";
    let sized = |design: &str, rest: &str| parse(&format!("kind = \"gripper\"\n{top}{design}{rest}"));
    let at = |scene: &Scene, base_m: f64| {
        let disc = Placed::disc(0.02, [-base_m, 0.02]);
        let task = Task {
            object: disc,
            opening_rad: 25f64.to_radians(),
            gravity_m_s2: scene.system.gravity_m_s2,
            closing_s: 0.01,
        };
        size_with(&scene.system.finger(Side::Right).linkage, &task, Rule::Rigid, Placement::Phalanges, INTERVALS)
    };
    let found = |scene: &Scene| {
        let of = scene.system.finger(Side::Right);
        let SpringKind::Constant { torque_n_m } = of.spring.expect("a spring").kind else { panic!("{of:?}") };
        [scene::torque(&of.motor.actuation, 0.0).0, torque_n_m]
    };
    let same = |found: [f64; 2], wanted: [f64; 2]| {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12 * b), "{found:?} {wanted:?}");
    };
    let scene = sized(SHORT, "");
    let [near, far] = [0.0135, 0.0205].map(|base_m| at(&scene, base_m).expect("a size"));
    assert!(near.motor_n_m != far.motor_n_m && near.spring_n_m != far.spring_n_m, "both ends are not alike");
    same(found(&scene), [near.motor_n_m.max(far.motor_n_m), near.spring_n_m.max(far.spring_n_m)]);
    // The tip of design 95 does not reach around the object at the near end: it is sized for the far one.
    let scene = sized(DESIGN, "");
    let far = at(&scene, 0.0205).expect("a size");
    assert!(at(&scene, 0.0135).is_err());
    same(found(&scene), [far.motor_n_m, far.spring_n_m]);
    // A differential has one motor for both.
    let seesaw = sized(SHORT, "[differential]\n");
    let input = &seesaw.system.differential.as_ref().expect("one").motor;
    let one = found(&sized(SHORT, ""))[0];
    assert_eq!(scene::torque(&input.actuation, 0.0).0, 2.0 * one);
    assert_eq!(seesaw.system.fingers.iter().map(|finger| &finger.motor).collect::<Vec<_>>(), [&Motor::NONE; 2]);
    comes_back(&seesaw);
}

#[test]
fn one_finger_may_be_another() {
    let scene = with(
        "palm_width = \"34 mm\"\nhalf_width = \"2 mm\"\n",
        "[contact.friction]\nmu_static = 0.8\n[contact.distal]\ndamping = \"2e5 N*s/m\"\n[contact.palm.friction]\nmu_static = 0.1\n\
         [right]\nhalf_width = \"3 mm\"\n[right.motor]\nprofile = \"ramp\"\ntorque = \"500 N*mm\"\nrise = \"1 ms\"\n\
         inertia = \"1e-6 kg*m^2\"\n[left.lengths]\nl21 = \"23 mm\"\nl22 = \"7 mm\"\nt22 = \"13 mm\"\nphi22 = \"118 deg\"\n\
         [left.spring]\ntype = \"torsional\"\nstiffness = \"40 N*mm/rad\"\n[left.contact.friction]\nmu_static = 0.3\n",
    );
    let [right, left] = scene.system.fingers.as_slice() else { panic!("two fingers") };
    assert_eq!((right.linkage.lengths.half_width_m, left.linkage.lengths.half_width_m), (0.003, 0.002));
    assert_eq!(right.motor.actuation, Actuation::Ramp { torque_n_m: 0.5, rise_s: 1e-3 });
    assert_eq!((right.motor.inertia_kg_m2, left.motor.inertia_kg_m2), (1e-6, 0.0));
    assert_eq!(left.motor.actuation, Actuation::Constant { torque_n_m: 0.48 });
    assert_eq!((left.linkage.lengths.l21_m, right.linkage.lengths.l22_m), (0.023, 0.0075));
    assert!(matches!(left.spring.expect("one").kind, SpringKind::Torsional { .. }));
    assert!(matches!(right.spring.expect("one").kind, SpringKind::Constant { .. }));
    assert_eq!((right.contact.mu_static(), left.contact.mu_static()), ([0.8; 2], [0.3; 2]));
    assert_eq!(left.contact.distal.normal.damping_max_n_s_per_m, 2e5);
    assert_eq!(scene.system.law(Place::Palm).and_then(|law| law.friction).map(|law| law.mu_static), Some(0.1));
    comes_back(&scene);
}

#[test]
fn table_and_motors_as_bought() {
    let scene = with(
        "",
        "[table]\n[contact.table]\nstiffness_si = 1e6\nexponent = 1.5\n[object]\nheight = \"21 mm\"\n\
         radius = \"20.5 mm\"\n[differential]\ninput_inertia = \"2e-5 kg*m^2\"\nseesaw_inertia = \"5e-6 kg*m^2\"\n",
    );
    let table = scene.system.table.expect("a table");
    assert!((table.level_m - 0.0415).abs() < 1e-17, "it touches the object: {}", table.level_m);
    assert_eq!(table.contact.expect("a law").normal.stiffness_n_per_m_e, 1e6);
    assert_eq!(scene.system.law(Place::Palm).expect("a palm").normal.stiffness_n_per_m_e, 1e8);
    let differential = scene.system.differential.as_ref().expect("one");
    assert_eq!((differential.motor.inertia_kg_m2, differential.seesaw_inertia_kg_m2), (2e-5, 5e-6));
    comes_back(&scene);
    // Nothing of it is there where the scene takes it away from one that it extends.
    let without = with("palm = false\n", "[table]\npresent = false\n[differential]\npresent = false\n");
    assert!(without.system.table.is_none() && without.system.differential.is_none() && without.system.palm.is_none());
    comes_back(&without);
}

#[test]
fn lengths_with_a_base_make_a_palm_and_moves_keep_their_names() {
    let lengths =
        "[lengths]\nbase = \"14 mm\"\nl21 = \"24 mm\"\nl22 = \"7.5 mm\"\nt22 = \"13 mm\"\nphi22 = \"120 deg\"\n";
    let moves = "[moves.lift]\nx = \"1 mm\"\ny = \"-25 mm\"\nstart = \"1 ms\"\nacceleration = \"2 g\"\n\
                 [vibrations.shake]\nx = \"1 um\"\nfrequency = \"1 kHz\"\n";
    let scene = parse(&format!("kind = \"gripper\"\n{lengths}{DRIVE}[object]\nradius = \"18 mm\"\n{moves}"));
    assert_eq!((scene.system.palm_width_m, scene.system.grasped().centre_m), (0.028, [0.0, 0.018]));
    let text = show(&scene);
    assert!(
        text.contains("[moves.lift]\nx = \"1 mm\"\ny = \"-25 mm\"\n") && text.contains("[vibrations.shake]"),
        "{text}"
    );
    comes_back(&scene);
    let text = format!("kind = \"gripper\"\npalm_width = \"28 mm\"\n{lengths}{DRIVE}");
    let error = scene::parse_any(&text, "test.toml").expect_err("twice").to_string();
    assert!(error.contains("`lengths.base` has no effect beside palm_width"), "{error}");
}

#[test]
fn shipped_grippers_say_what_they_are_and_come_back_bit_for_bit() {
    let files = ["scenes/gripper", "scenes/hard"].into_iter().flat_map(|directory| {
        let entries = std::fs::read_dir(directory).expect("scenes");
        let named = entries.map(|entry| entry.expect("entry").path());
        named.filter(|path| path.to_string_lossy().contains("gripper")).collect::<Vec<_>>()
    });
    let files: Vec<_> = files.collect();
    assert!(files.len() >= 17, "{}", files.len());
    for file in files {
        let text = std::fs::read_to_string(&file).expect("text");
        assert!(text.starts_with("# ") && text.contains("\n# Expect: "), "{}", file.display());
        let scene = scene::load_any(&file).unwrap_or_else(|e| panic!("{e}"));
        let stem = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let stem = if stem.starts_with("gripper-") { stem } else { format!("gripper-{stem}") };
        assert_eq!(scene.name, stem);
        assert!(!scene.description.is_empty());
        comes_back(&scene);
    }
}
