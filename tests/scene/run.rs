//! The shipped scenes give the results that their first lines state, with the analytic model.

use phalanx::scene;
use phalanx::trace::{FingerContact, Model, Outcome};

fn run(name: &str) -> Outcome {
    let scene = scene::load(format!("scenes/{name}.toml")).unwrap_or_else(|e| panic!("{e}"));
    crate::support::checked_run::run(Model::Analytic, &scene, &mut ()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// First contacts in ms and final normal forces in N, to the digits that the scenes state.
#[test]
fn grasps_match_their_documented_times_and_forces() {
    for (name, first_ms, normal_n) in [
        ("experiment-95", [4.50, 6.88], [23.6, 8.26]),
        ("experiment-95-bristle", [4.50, 6.88], [6.66, 9.77]),
        ("experiment-95-frictionless", [4.50, 6.88], [23.6, 8.26]),
        ("experiment-95-cad", [3.41, 5.17], [23.6, 8.24]),
        ("torsional-spring", [4.50, 6.89], [31.2, 4.8]),
        ("long-fingers", [5.62, 8.05], [13.7, 11.1]),
        ("soft-start", [6.84, 9.25], [20.5, 9.1]),
    ] {
        let outcome = run(name);
        let contacts = [
            (FingerContact::Proximal, outcome.last.finger_contact(FingerContact::Proximal)),
            (FingerContact::Distal, outcome.last.finger_contact(FingerContact::Distal)),
        ];
        for (i, (phalanx, last)) in contacts.into_iter().enumerate() {
            let summary = outcome.finger_contact(phalanx);
            let first = summary.first_s.unwrap_or(f64::NAN) * 1e3;
            assert!((first - first_ms[i]).abs() < 0.006, "{name} {phalanx:?}: {first} ms");
            assert!((last.normal_n - normal_n[i]).abs() < 0.06, "{name} {phalanx:?}: {} N", last.normal_n);
            assert_eq!(summary.touchdowns, 1, "{name} {phalanx:?}");
        }
    }
}

#[test]
fn free_fingers_touch_nothing_and_reach_their_documented_angles() {
    for (name, q21_deg) in [("free-swing", 119.0), ("other-assembly", 102.0)] {
        let outcome = run(name);
        assert!(
            (outcome.last.finger(0).q21_rad.to_degrees() - q21_deg).abs() < 0.6,
            "{name}: {}",
            outcome.last.finger(0).q21_rad.to_degrees()
        );
        for phalanx in [FingerContact::Proximal, FingerContact::Distal] {
            assert_eq!(outcome.finger_contact(phalanx).first_s, None, "{name} {phalanx:?}");
        }
    }
}
