//! The shipped scenes do what their first lines say, with the analytic model.

use phalanx::scene;
use phalanx::trace::{Model, Outcome, Site};

fn run(name: &str) -> Outcome {
    let scene = scene::load(format!("scenes/{name}.toml")).unwrap_or_else(|e| panic!("{e}"));
    crate::support::held::run(Model::Analytic, &scene, &mut ()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// First contacts in ms and final normal forces in N, to the digits the scenes promise.
#[test]
fn grasps_touch_and_hold_as_promised() {
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
            (Site::Proximal, outcome.last.contact(Site::Proximal)),
            (Site::Distal, outcome.last.contact(Site::Distal)),
        ];
        for (i, (site, last)) in contacts.into_iter().enumerate() {
            let summary = outcome.site(site);
            let first = summary.first_s.unwrap_or(f64::NAN) * 1e3;
            assert!((first - first_ms[i]).abs() < 0.006, "{name} {site:?}: {first} ms");
            assert!((last.normal_n - normal_n[i]).abs() < 0.06, "{name} {site:?}: {} N", last.normal_n);
            assert_eq!(summary.touchdowns, 1, "{name} {site:?}");
        }
    }
}

#[test]
fn free_fingers_touch_nothing_and_turn_as_far_as_promised() {
    for (name, q21_deg) in [("free-swing", 119.0), ("other-assembly", 102.0)] {
        let outcome = run(name);
        assert!(
            (outcome.last.finger().q21_rad.to_degrees() - q21_deg).abs() < 0.6,
            "{name}: {}",
            outcome.last.finger().q21_rad.to_degrees()
        );
        for site in [Site::Proximal, Site::Distal] {
            assert_eq!(outcome.site(site).first_s, None, "{name} {site:?}");
        }
    }
}
