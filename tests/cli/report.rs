//! The report of a run: the JSON document key by key, and the summary for people.

use crate::support::synthetic::{posture, scene};
use phalanx::criteria::{Class, Criteria};
use phalanx::report::document::{Came, Failure, RunReport};
use phalanx::scene::Scene;
use phalanx::trace::{ContactSummary, Model, Outcome, Sample, Site, Work};
use phalanx::wording::Reported;
use serde_json::Value;

fn last() -> Sample {
    posture(
        20e-3,
        (2.088778f64.to_radians(), -1.5e-4),
        (65.019991f64.to_radians(), 2.5e-9),
        [23.609212345678901, 8.2573],
    )
}

fn outcome() -> Outcome {
    let site = |first_s, touchdowns, peak_normal_n| ContactSummary {
        first_s,
        touchdowns,
        peak_normal_n,
        max_penetration_m: 2.93e-6,
        impulse_n_s: 0.3712,
        slips: 0,
    };
    Outcome {
        last: last(),
        contacts: vec![
            site(Some(4.501315e-3), 1, 98765.4),
            site(Some(6.883746e-3), 2, 51234.5),
            ContactSummary::default(),
        ],
        work: Work {
            steps: 231,
            rejected: 12,
            rhs_evaluations: 1944,
            jacobian_evaluations: 231,
            events: 4,
            ..Work::default()
        },
        loop_gap_m: 0.0,
        ejected_s: None,
    }
}

fn criteria() -> Criteria {
    Criteria {
        t_geo_s: Some(6.87e-3),
        tts_s: Some(6.883746e-3),
        lost_s: 0.0,
        rebound_percent: Some(0.0),
        statically_stable: true,
        class: Class::Stable,
    }
}

fn came(
    scene: &Scene,
    wall_s: f64,
    outcome: Option<&Outcome>,
    criteria: Option<Criteria>,
    failure: Option<Failure>,
) -> RunReport {
    let came = Came { wall_s, outcome, criteria, grasp: None, rebounds: &[], warnings: &[] };
    RunReport::new(scene, Model::Analytic, &came, failure)
}

fn report() -> RunReport {
    came(&scene(), 1.25e-3, Some(&outcome()), Some(criteria()), None)
}

fn parsed(report: &RunReport) -> Value {
    serde_json::from_str(&report.json()).expect("one JSON document")
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn warnings_are_lines_of_the_summary_and_a_list_of_the_document() {
    let mut report = report();
    assert_eq!(parsed(&report)["warnings"], serde_json::json!([]));
    assert!(!report.report().to_string().contains("Warning:"));
    report.warnings = vec!["the energy does not balance".to_string()];
    assert_eq!(parsed(&report)["warnings"], serde_json::json!(["the energy does not balance"]));
    assert!(report.report().to_string().contains("\nWarning: the energy does not balance\n"));
}

#[test]
fn the_document_has_every_promised_key() {
    let document = parsed(&report());
    for key in ["scene", "model", "duration_s", "steps", "wall_s", "final", "contacts", "criteria"] {
        assert!(document.get(key).is_some(), "{key}");
    }
    for key in ["q11_rad", "q21_rad", "q22_rad", "qd11_rad_s", "qd21_rad_s"] {
        assert!(document["final"][key].is_f64(), "{key}");
    }
    for site in ["proximal", "distal"] {
        let contact = &document["contacts"][site];
        for key in
            ["first_s", "touchdowns", "final_normal_n", "final_tangential_n", "peak_normal_n", "max_penetration_m"]
        {
            assert!(contact[key].is_number(), "{site} {key}");
        }
    }
    let limit = keys(&document["contacts"]["limit"]);
    for key in ["first_s", "touchdowns", "final_torque_n_m", "peak_torque_n_m", "max_penetration_rad", "impulse_n_m_s"]
    {
        assert!(limit.contains(&key), "{key}");
    }
    assert_eq!(document["contacts"]["limit"]["first_s"], Value::Null);
    assert_eq!(document["contacts"]["limit"]["touchdowns"], 0);
    assert_eq!(document["criteria"]["class"], "stable");
    assert_eq!(document["criteria"]["rebound_percent"], 0.0);
    assert_eq!(document["error"], Value::Null);
    assert_eq!(document["log"], Value::Null);
}

#[test]
fn keys_come_in_the_documented_order() {
    let text = report().json();
    let place = |key: &str| text.find(&format!("\"{key}\":")).unwrap_or_else(|| panic!("{key}"));
    let order = ["scene", "model", "duration_s", "steps", "wall_s", "final", "contacts", "criteria"].map(place);
    assert!(order.is_sorted(), "{order:?}");
    assert!(text.ends_with("}\n"));
}

#[test]
fn floats_are_not_rounded() {
    // Read by hand: serde_json's own reader may be off by the last bit.
    let text = report().json();
    let numbers = |key: &str| -> Vec<u64> {
        text.match_indices(&format!("\"{key}\": "))
            .map(|(place, found)| {
                let rest = &text[place + found.len()..];
                let end = rest.find([',', '\n']).expect("more lines follow");
                rest[..end].parse::<f64>().expect("a number").to_bits()
            })
            .collect()
    };
    assert_eq!(numbers("q11_rad"), [last().finger().q11_rad.to_bits()]);
    let forces = [last().contact(Site::Proximal).normal_n, last().contact(Site::Distal).normal_n];
    assert_eq!(numbers("final_normal_n"), forces.map(f64::to_bits));
    assert_eq!(numbers("balance_j"), [last().energy.balance_j.to_bits()]);
}

#[test]
fn what_is_not_known_is_null() {
    let mut outcome = outcome();
    outcome.contacts = vec![ContactSummary::default(); 3];
    let mut swing = scene();
    swing.system.discs.clear();
    let document = parsed(&came(&swing, 0.0, Some(&outcome), None, None));
    assert_eq!(document["criteria"], Value::Null);
    for site in ["proximal", "distal"] {
        assert_eq!(document["contacts"][site]["first_s"], Value::Null);
        assert_eq!(document["contacts"][site]["touchdowns"], 0);
    }
}

#[test]
fn a_run_that_broke_off_reports_what_was_seen_of_it() {
    let failure = Failure { time_s: 4.6e-3, reason: "step budget of 10 used up".to_string() };
    let report = came(&scene(), 0.5, Some(&outcome()), None, Some(failure));
    let document = parsed(&report);
    assert_eq!(document["completed"], false);
    assert_eq!(document["error"]["time_s"], 4.6e-3);
    assert_eq!(document["error"]["reason"], "step budget of 10 used up");
    assert_eq!(document["steps"], 231);
    assert_eq!(document["criteria"], Value::Null);
    assert_eq!(document["contacts"]["distal"]["touchdowns"], 2);
    let text = report.report().to_string();
    assert!(text.contains("NOT COMPLETED: stopped at 4.6 ms of 20 ms: step budget of 10 used up"), "{text}");
}

#[test]
fn a_run_that_cannot_say_how_far_it_came_has_nulls() {
    let failure = Failure { time_s: 4.6e-3, reason: "cannot write the log run.mcap: no space left".to_string() };
    let report = came(&scene(), 0.5, None, None, Some(failure));
    let document = parsed(&report);
    for key in ["steps", "final", "contacts", "criteria", "end_s", "energy", "work"] {
        assert_eq!(document[key], Value::Null, "{key}");
    }
    assert!(report.report().to_string().contains("NOT COMPLETED: stopped at 4.6 ms"));
}

#[test]
fn the_summary_says_it_in_units_people_read() {
    let mut report = report();
    report.log = Some("run.mcap".to_string());
    let text = report.report().to_string();
    let line = |start: &str| {
        let line = text.lines().find(|line| line.starts_with(start));
        line.unwrap_or_else(|| panic!("no {start} in\n{text}")).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(line("synthetic"), "synthetic: analytic model, rodas5p (rtol 1e-4, engineering preset)");
    assert_eq!(
        line("20 ms"),
        "20 ms in 231 steps (12 rejected), 1944 evaluations, 231 Jacobians, 4 events; 1.25 ms of wall time"
    );
    assert_eq!(line("log:"), "log: run.mcap");
    assert!(line("angle").starts_with("angle, deg 2.088778 65.019991"));
    assert_eq!(line("proximal"), "proximal 4.501315 1 23.6092 0 98765 2.9300 371.20");
    assert_eq!(line("distal"), "distal 6.883746 2 8.25730 0 51234 2.9300 371.20");
    assert!(line("joint limit").starts_with("joint limit – 0"));
    assert!(text.contains("stable"));
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
}
