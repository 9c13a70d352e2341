//! The programs of `examples/`, run.

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

use phalanx::trace::Site;

use crate::support::cli::{directory, phalanx, stderr};

#[test]
fn a_closing_touches_with_both_phalanges() {
    let outcome = closing::closing().expect("a run");
    assert!((outcome.site(Site::Proximal).first_s.expect("a touch") - 4.501e-3).abs() < 1e-6);
    assert!((outcome.last.contact(Site::Distal).normal_n - 8.26).abs() < 0.01);
}

#[test]
fn a_stronger_motor_closes_sooner_and_grips_harder() {
    let rows = torque::sweep().expect("runs");
    assert_eq!(rows.len(), 5);
    for (weaker, stronger) in rows.iter().zip(&rows[1..]) {
        assert!(stronger.torque_n_m > weaker.torque_n_m);
        assert!(stronger.first_s.expect("a touch") < weaker.first_s.expect("a touch"));
        assert!(stronger.last_n[0] > weaker.last_n[0] && stronger.last_n[1] > weaker.last_n[1]);
    }
}

#[test]
fn the_peak_of_a_column_is_that_of_the_run() {
    let (outcome, recording) = peak_force::closing().expect("a run");
    let (time_s, force_n) = peak_force::peak(&recording, "distal_normal_n").expect("a force");
    assert_eq!(force_n, outcome.site(Site::Distal).peak_normal_n);
    assert!(time_s >= outcome.site(Site::Distal).first_s.expect("a touch"));
    assert_eq!(peak_force::peak(&recording, "colour"), None);
}

#[test]
fn a_log_is_written_read_and_verified() {
    let path = directory("examples_logged").join("run.mcap");
    logged::write(&path).expect("a run");
    let (reading, recording) = logged::read(&path).expect("a log");
    assert_eq!(reading.ended.expect("an end").stopped, None);
    assert_eq!(reading.samples, recording.time().len() as u64);
    assert_eq!(recording.column("motor_torque_n_m").expect("a column").first(), Some(&0.0));
    let output = phalanx(&["replay", path.to_str().expect("text"), "--verify"]);
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn a_faster_disc_presses_harder_and_keeps_more_of_its_speed() {
    let bounces = restitution::bounces().expect("runs");
    let kept: Vec<_> = bounces.iter().map(|bounce| bounce.separation_m_s / bounce.approach_m_s).collect();
    assert_eq!(kept.len(), 3);
    assert!((kept[0] - 0.60104).abs() < 1e-4, "{kept:?}");
    assert!(kept.is_sorted() && bounces.is_sorted_by(|a, b| a.peak_n < b.peak_n));
}
