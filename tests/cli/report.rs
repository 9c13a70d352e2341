//! Report of a run: the keys of the JSON document, and the text summary.

use crate::support::synthetic::{posture, scene};
use phalanx::criteria::{Class, ClassReason, Criteria};
use phalanx::format::ToReport;
use phalanx::report::document::{Failure, RunData, RunReport};
use phalanx::trace::{ContactSummary, FingerContact, Model, Outcome, Sample, Work};
use serde_json::{Value, json};

fn last() -> Sample {
    posture(
        20e-3,
        (2.088778f64.to_radians(), -1.5e-4),
        (65.019991f64.to_radians(), 2.5e-9),
        [23.609212345678901, 8.2573],
    )
}

fn outcome() -> Outcome {
    let contact_summary = |first_s, touchdowns, peak_normal_n| ContactSummary {
        first_s,
        touchdowns,
        peak_normal_n,
        max_penetration_m: 2.93e-6,
        impulse_n_s: 0.3712,
        slips: 0,
    };
    let (steps, rejected, rhs_evaluations, jacobian_evaluations, events) = (231, 12, 1944, 231, 4);
    Outcome {
        last: last(),
        contacts: vec![
            contact_summary(Some(4.501315e-3), 1, 98765.4),
            contact_summary(Some(6.883746e-3), 2, 51234.5),
            ContactSummary::default(),
        ],
        work: Work { steps, rejected, rhs_evaluations, jacobian_evaluations, events, ..Work::default() },
        loop_gap_m: 0.0,
        ejected_s: None,
    }
}

fn build_report(wall_s: f64, outcome: Option<&Outcome>, failure: Option<Failure>) -> RunReport {
    let criteria = Criteria {
        t_geo_s: Some(6.87e-3),
        tts_s: Some(6.883746e-3),
        lost_s: 0.0,
        rebound_percent: Some(0.0),
        statically_stable: true,
        class: Class::Stable,
        class_reason: ClassReason::Settled { tts_s: 6.883746e-3, rebound_percent: 0.0, loss: None },
    };
    let criteria = Some(criteria).filter(|_| failure.is_none());
    let data = RunData { wall_s, outcome, criteria, grasp: None, rebounds: &[], cable_events: &[], warnings: &[] };
    RunReport::new(&scene(), Model::Analytic, &data, failure)
}

fn report() -> RunReport {
    build_report(1.25e-3, Some(&outcome()), None)
}

fn parsed(report: &RunReport) -> Value {
    serde_json::from_str(&report.json()).expect("one JSON document")
}

#[test]
fn document_has_every_documented_key() {
    let document = parsed(&report());
    let contact = "first_s touchdowns final_normal_n final_tangential_n peak_normal_n max_penetration_m";
    let limit = "first_s touchdowns final_torque_n_m peak_torque_n_m max_penetration_rad impulse_n_m_s";
    for (path, keys) in [
        ("", "scene model duration_s steps wall_s final contacts criteria"),
        ("/final", "q11_rad q21_rad q22_rad qd11_rad_s qd21_rad_s"),
        ("/contacts/proximal", contact),
        ("/contacts/distal", contact),
        ("/contacts/limit", limit),
    ] {
        let object = document.pointer(path).and_then(Value::as_object).expect("an object");
        for key in keys.split(' ') {
            let is_limit_time = path.ends_with("limit") && key == "first_s";
            let is_number = path.is_empty() || is_limit_time || object[key].is_number();
            assert!(object.contains_key(key) && is_number, "{path} {key}");
        }
    }
    let expected_reason =
        "in position with both contacts active from 6.88 ms on, in less than 15 ms, without a rebound";
    for (path, expected) in [
        ("/contacts/limit/first_s", Value::Null),
        ("/contacts/limit/touchdowns", 0.into()),
        ("/criteria/class", "stable".into()),
        ("/criteria/class_reason", expected_reason.into()),
        ("/criteria/rebound_percent", 0.0.into()),
        ("/error", Value::Null),
        ("/log", Value::Null),
        ("/warnings", json!([])),
    ] {
        assert_eq!(document.pointer(path), Some(&expected), "{path}");
    }
}

#[test]
fn keys_come_in_the_documented_order_and_floats_are_not_rounded() {
    // Parsed here, because the parser of serde_json may be off by the last bit.
    let text = report().json();
    let position = |key: &str| text.find(&format!("\"{key}\":")).unwrap_or_else(|| panic!("{key}"));
    let order = ["scene", "model", "duration_s", "steps", "wall_s", "final", "contacts", "criteria"].map(position);
    assert!(order.is_sorted() && text.ends_with("}\n"), "{order:?}");
    let numbers = |key: &str| -> Vec<f64> {
        let number = |rest: &str| rest.split([',', '\n']).next().and_then(|number| number.parse().ok());
        text.split(&format!("\"{key}\": ")).skip(1).map(|rest| number(rest).expect("a number")).collect()
    };
    let forces = [FingerContact::Proximal, FingerContact::Distal].map(|site| last().finger_contact(site).normal_n);
    for (key, expected) in [
        ("q11_rad", vec![last().finger(0).q11_rad]),
        ("final_normal_n", forces.to_vec()),
        ("balance_j", vec![last().energy().balance_j]),
    ] {
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(numbers(key)), bits(expected), "{key}");
    }
}

#[test]
fn incomplete_runs_report_their_partial_outcome() {
    for (outcome, reason) in
        [(Some(outcome()), "step budget of 10 used up"), (None, "cannot write the log run.mcap: no space left")]
    {
        let failure = Failure { time_s: 4.6e-3, reason: reason.to_string() };
        let report = build_report(0.5, outcome.as_ref(), Some(failure));
        let document = parsed(&report);
        assert_eq!((&document["completed"], &document["criteria"]), (&false.into(), &Value::Null));
        assert_eq!(document["error"], json!({ "time_s": 4.6e-3, "reason": reason }));
        for key in ["steps", "final", "contacts", "end_s", "energy", "work"] {
            assert_eq!(document[key].is_null(), outcome.is_none(), "{key}");
        }
        if outcome.is_some() {
            assert_eq!((&document["steps"], &document["contacts"]["distal"]["touchdowns"]), (&231.into(), &2.into()));
        }
        let text = report.report().to_string();
        assert!(text.contains(&format!("NOT COMPLETED: stopped at 4.6 ms of 20 ms: {reason}")), "{text}");
    }
}

#[test]
fn summary_uses_practical_units() {
    let mut report = report();
    report.log = Some("run.mcap".to_string());
    assert!(!report.report().to_string().contains("Warning"));
    report.warnings = vec!["the energy does not balance".to_string()];
    assert_eq!(parsed(&report)["warnings"], json!(report.warnings));
    let text = report.report().to_string();
    let line = |start: &str| {
        let line = text.lines().find(|line| line.starts_with(start));
        line.unwrap_or_else(|| panic!("no {start} in\n{text}")).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (start, expected) in [
        ("synthetic", "synthetic: analytic model, rodas5p (rtol 1e-4, engineering preset)"),
        ("20 ms", "20 ms in 231 steps (12 rejected), 1944 evaluations, 231 Jacobians, 4 events; 1.25 ms of wall time"),
        ("log:", "log: run.mcap"),
        ("Warning:", "Warning: the energy does not balance"),
        ("proximal", "proximal 4.501315 1 23.6092 0 98765 2.9300 371.20"),
        ("distal", "distal 6.883746 2 8.25730 0 51234 2.9300 371.20"),
    ] {
        assert_eq!(line(start), expected);
    }
    assert!(line("angle").starts_with("angle, deg 2.088778 65.019991"));
    assert!(line("joint limit").starts_with("joint limit – 0"));
    assert!(text.contains("stable"));
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
}
