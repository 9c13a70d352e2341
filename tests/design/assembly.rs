//! Assembly of mechanisms: start of the reference cases from rough guesses, and what cannot be assembled.

use phalanx::mechanism::{
    AssemblyError, Body, Coupling, Joint, JointCombination, JointKind, Mechanism, Pose, assemble,
};

use crate::support::mechanism_cases::all_cases;
use crate::support::random::Random;

/// Largest error of poses or rates, relative to 1 m, 1 rad, 1 m/s, 1 rad/s and to larger values.
fn error(found: &[Pose], expected: &[Pose]) -> f64 {
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f64::max)
}

#[test]
fn reference_cases_start_as_the_independent_program_says() {
    for case in all_cases() {
        let start = assemble(&case.mechanism).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        let errors = [error(&start.poses, &case.start.poses), error(&start.rates, &case.start.rates)];
        assert!(errors.iter().all(|error| *error < 1e-14), "{}: {errors:?}", case.name);
    }
}

#[test]
fn start_coordinates_that_determine_the_posture_outweigh_rough_guesses() {
    let mut random = Random::for_seed(40);
    for case in all_cases() {
        let free: Vec<bool> = (0..case.mechanism.bodies.len())
            .map(|body| !case.mechanism.joints.iter().any(|joint| joint.bodies.contains(&Some(body))))
            .collect();
        if case.name == "a_andrews" {
            continue; // Its start follows from the guess.
        }
        for _ in 0..20 {
            let mut rough = case.mechanism.clone();
            for (body, _) in rough.bodies.iter_mut().zip(&free).filter(|(_, free)| !**free) {
                for (part, size) in body.pose.iter_mut().zip([0.01, 0.01, 0.2]) {
                    *part += random.within(-size, size);
                }
            }
            let start = assemble(&rough).unwrap_or_else(|error| panic!("{}: {error}", case.name));
            let errors = [error(&start.poses, &case.start.poses), error(&start.rates, &case.start.rates)];
            assert!(errors.iter().all(|error| *error < 1e-14), "{}: {errors:?}", case.name);
        }
    }
}

fn bar(name: &str, pose: Pose) -> Body {
    Body { pose, ..Body::new(name, 0.1, 1e-5) }
}

fn pin(name: &str, bodies: [Option<usize>; 2], points_m: [[f64; 2]; 2]) -> Joint {
    Joint::new(name, JointKind::Revolute, bodies, points_m)
}

/// A four-bar between pivots 100 mm apart: crank of 40 mm, coupler and rocker of these lengths.
fn four_bar(coupler_m: f64, rocker_m: f64) -> Mechanism {
    Mechanism {
        bodies: vec![bar("crank", [0.0, 0.0, 1.5]), bar("coupler", [0.0, 0.04, 0.1]), bar("rocker", [0.1, 0.0, 1.6])],
        joints: vec![
            pin("crank", [None, Some(0)], [[0.0; 2]; 2]),
            pin("A", [Some(0), Some(1)], [[0.04, 0.0], [0.0; 2]]),
            pin("B", [Some(1), Some(2)], [[coupler_m, 0.0], [rocker_m, 0.0]]),
            pin("rocker", [None, Some(2)], [[0.1, 0.0], [0.0; 2]]),
        ],
        ..Mechanism::default()
    }
}

fn message(mechanism: &Mechanism) -> String {
    assemble(mechanism).expect_err("a mechanism that cannot be assembled").to_string()
}

#[test]
fn a_loop_that_is_too_short_names_a_joint_and_its_gap() {
    // The links span 40 + 30 + 29.7 mm of 100 mm.
    let error = assemble(&four_bar(0.03, 0.0297)).expect_err("a loop that is too short");
    let AssemblyError::Open { name, miss, .. } = &error else { panic!("{error}") };
    assert_eq!((name.as_str(), miss.to_string().as_str()), ("joint `rocker`", "0.3 mm"), "{error}");
}

#[test]
fn redundant_and_contradictory_conditions_are_named() {
    let good = four_bar(0.09, 0.06);
    assert!(assemble(&good).is_ok());

    let mut doubled = good.clone();
    doubled.joints.push(pin("A again", [Some(0), Some(1)], [[0.04, 0.0], [0.0; 2]]));
    assert_eq!(
        message(&doubled),
        "joint `A again` is redundant, because in this posture it follows from joint `A`: remove it, or change the loop"
    );

    let mut parallelogram = four_bar(0.1, 0.04);
    parallelogram.bodies[2].pose[2] = 1.5;
    parallelogram.bodies.push(bar("third", [0.05, 0.0, 1.5]));
    parallelogram.joints.push(pin("C", [Some(1), Some(3)], [[0.05, 0.0], [0.04, 0.0]]));
    parallelogram.joints.push(pin("third", [None, Some(3)], [[0.05, 0.0], [0.0; 2]]));
    assert!(
        message(&parallelogram)
            .starts_with("joint `third` is redundant, because in this posture it follows from joint")
    );
    // With a third bar that is 0.2 mm too long the loops do not close.
    parallelogram.joints[4].points_m[1][0] = 0.0402;
    assert!(message(&parallelogram).contains("misses by"), "{}", message(&parallelogram));

    let mut over = good.clone();
    over.joints[0].start = Some(1.5);
    let follows = assemble(&over).expect("one start coordinate").poses[2][2];
    over.joints[3].start = Some(follows);
    let agreeing = assemble(&over).expect("two start coordinates for one degree of freedom that agree");
    assert_eq!((agreeing.poses[2][2], agreeing.implied), (follows, vec![3]));
    over.joints[3].start = Some(follows + 0.1);
    let AssemblyError::RedundantStart { name, given, found, from, .. } = assemble(&over).expect_err("contradiction")
    else {
        panic!("a contradiction")
    };
    assert_eq!(
        (name.as_str(), from.as_slice()),
        ("the start of joint `rocker`", &["the start of joint `crank`".to_owned()][..])
    );
    let degrees = |angle: f64| format!("{angle:.4} deg");
    assert_eq!(given.to_string(), degrees((follows + 0.1).to_degrees()));
    assert_eq!(found.to_string(), degrees(follows.to_degrees()));

    let mut far = good;
    far.joints[3].start = Some(-1.0);
    let error = assemble(&far).expect_err("a posture out of reach");
    assert!(matches!(error, AssemblyError::OutOfReach { .. }), "{error}");
    assert!(
        error.to_string().starts_with("the start of joint `rocker` is -57.2958 deg, but the mechanism reaches only")
    );
}

#[test]
fn couplings_join_in() {
    let mut geared = Mechanism {
        bodies: vec![bar("a", [0.0; 3]), bar("b", [0.05, 0.0, 0.0])],
        joints: vec![pin("a", [None, Some(0)], [[0.0; 2]; 2]), pin("b", [None, Some(1)], [[0.05, 0.0], [0.0; 2]])],
        couplings: vec![Coupling {
            name: "gears".to_owned(),
            on: JointCombination { terms: vec![(0, 2.0), (1, 1.0)], offset: 0.1 },
        }],
        ..Mechanism::default()
    };
    geared.joints[0].start = Some(0.3);
    geared.joints[0].start_rate = 4.0;
    let start = assemble(&geared).expect("two gears");
    assert!((start.poses[1][2] + 0.5).abs() < 1e-15 && (start.rates[1][2] + 8.0).abs() < 1e-14);

    geared.couplings.push(Coupling {
        name: "belt".to_owned(),
        on: JointCombination { terms: vec![(0, -4.0), (1, -2.0)], offset: -0.2 },
    });
    assert!(
        message(&geared)
            .starts_with("coupling `belt` is redundant, because in this posture it follows from coupling `gears`")
    );
}

#[test]
fn free_degrees_stay_near_the_guess() {
    // A bar on a pin: the pin pulls its end back, and nothing turns it.
    let pinned = Mechanism {
        bodies: vec![bar("bar", [1e-3, 0.0, 0.7]), bar("free", [1.0, 2.0, 3.0])],
        joints: vec![pin("pin", [None, Some(0)], [[0.0; 2]; 2])],
        ..Mechanism::default()
    };
    let start = assemble(&pinned).expect("a pinned bar");
    assert_eq!(start.poses, [[0.0, 0.0, 0.7], [1.0, 2.0, 3.0]]);
}

/// The start that is kept from the last assembly is used for the same mechanism only: one that differs in a number is
/// assembled as on a thread that has assembled nothing.
#[test]
fn a_changed_mechanism_is_assembled_anew() {
    let changes: [fn(&mut Mechanism); 9] = [
        |it| it.bodies.iter_mut().for_each(|body| body.com_m[1] += 1e-4),
        |it| it.bodies.iter_mut().for_each(|body| body.pose[0] += 1e-4),
        |it| it.bodies.iter_mut().for_each(|body| body.rate[2] += 1e-2),
        |it| it.bodies[0].inertia_kg_m2 = f64::INFINITY,
        |it| it.joints.iter_mut().for_each(|joint| joint.points_m[0][1] += 1e-4),
        |it| it.joints.iter_mut().for_each(|joint| joint.start = joint.start.map(|start| start + 1e-3)),
        |it| it.joints.iter_mut().for_each(|joint| joint.start_rate += 1e-2),
        |it| it.joints.iter_mut().for_each(|joint| joint.offset_rad += 1e-3),
        |it| it.couplings.iter_mut().for_each(|coupling| coupling.on.offset += 1e-3),
    ];
    let mut differing = [0; 9];
    for case in all_cases() {
        let first = assemble(&case.mechanism);
        for (change, differing) in changes.iter().zip(&mut differing) {
            let mut changed = case.mechanism.clone();
            change(&mut changed);
            let fresh = std::thread::scope(|scope| scope.spawn(|| assemble(&changed)).join().expect("no panic"));
            let _ = assemble(&case.mechanism);
            let found = assemble(&changed);
            assert_eq!(found, fresh, "{}", case.name);
            *differing += usize::from(found != first);
        }
        let mut heavier = case.mechanism.clone();
        heavier.bodies[0].mass_kg *= 2.0;
        assert_eq!(assemble(&heavier), first, "{}", case.name);
    }
    assert!(differing.iter().all(|count| *count > 0), "{differing:?}");
}
