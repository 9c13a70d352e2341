//! Runs the programs of `examples/`.

#[path = "../../examples/closing.rs"]
#[allow(dead_code)]
mod closing;
#[path = "../../examples/logged.rs"]
#[allow(dead_code)]
mod logged;
#[path = "../../examples/peak_force.rs"]
#[allow(dead_code)]
mod peak_force;
#[path = "../../examples/restitution.rs"]
#[allow(dead_code)]
mod restitution;
#[path = "../../examples/torque.rs"]
#[allow(dead_code)]
mod torque;

use phalanx::trace::FingerContact;

use crate::support::cli::{directory, path_text, succeed};

#[test]
fn closing_example_contacts_both_phalanges() {
    let outcome = closing::closing().expect("a run");
    assert!((outcome.finger_contact(FingerContact::Proximal).first_s.expect("a contact") - 4.501e-3).abs() < 1e-6);
    assert!((outcome.last.finger_contact(FingerContact::Distal).normal_n - 8.26).abs() < 0.01);
}

#[test]
fn torque_example_closes_sooner_and_grips_harder_with_more_torque() {
    let rows = torque::sweep().expect("runs");
    assert_eq!(rows.len(), 5);
    for (weaker, stronger) in rows.iter().zip(&rows[1..]) {
        assert!(stronger.torque_n_m > weaker.torque_n_m);
        assert!(stronger.first_s.expect("a contact") < weaker.first_s.expect("a contact"));
        assert!(stronger.last_n[0] > weaker.last_n[0] && stronger.last_n[1] > weaker.last_n[1]);
    }
}

#[test]
fn peak_force_example_finds_the_peak_of_the_run() {
    let (outcome, recording) = peak_force::closing().expect("a run");
    let (time_s, force_n) = peak_force::peak(&recording, "distal_normal_n").expect("a force");
    assert_eq!(force_n, outcome.finger_contact(FingerContact::Distal).peak_normal_n);
    assert!(time_s >= outcome.finger_contact(FingerContact::Distal).first_s.expect("a contact"));
    assert_eq!(peak_force::peak(&recording, "colour"), None);
}

#[test]
fn logged_example_writes_and_reads_a_valid_log() {
    let path = directory("examples_logged").join("run.mcap");
    logged::write(&path).expect("a run");
    let (reading, recording) = logged::read(&path).expect("a log");
    assert_eq!(reading.run_end.expect("an end").stopped, None);
    assert_eq!(reading.samples, recording.time().len() as u64);
    assert_eq!(recording.column("motor_torque_n_m").expect("a column").first(), Some(&0.0));
    succeed(&["replay", path_text(&path), "--verify"]);
}

#[test]
fn restitution_example_has_increasing_force_and_restitution() {
    let bounces = restitution::bounces().expect("runs");
    let ratios: Vec<_> = bounces.iter().map(|bounce| bounce.separation_m_s / bounce.approach_m_s).collect();
    assert_eq!(ratios.len(), 3);
    assert!((ratios[0] - 0.60104).abs() < 1e-4, "{ratios:?}");
    assert!(ratios.is_sorted() && bounces.is_sorted_by(|a, b| a.peak_n < b.peak_n));
}
