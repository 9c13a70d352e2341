//! The anchor case, design 95 of the thesis: model and criteria together.

use phalanx::criteria::{Class, FinalAngles, Tracker};
use phalanx::gripper::final_posture;
use phalanx::scene;
use phalanx::trace::Model;

#[test]
fn design_95_is_stable_from_tip_contact_on_at_every_log_rate() {
    let mut scene = scene::load("scenes/experiment-95.toml").unwrap_or_else(|error| panic!("{error}"));
    let object = scene.object().expect("an object");
    let disc = object.placed();
    let final_grasp =
        final_posture(&scene.finger().linkage.lengths, scene.finger().linkage.assembly, disc).expect("a grasp");
    for numeric_hz in [1e3, 1e4, 1e6] {
        scene.log.numeric_hz = numeric_hz;
        let mut tracker =
            Tracker::new(FinalAngles { q11_rad: final_grasp.posture.q11_rad, q21_rad: final_grasp.posture.q21_rad });
        let outcome = crate::support::checked_run::run(Model::Analytic, &scene, &mut tracker).expect("completed");
        let criteria = tracker.criteria(None).expect("a run");
        // 1-model §1.8: the tip touches at 6.883746 ms, and nothing rebounds.
        let tts = criteria.tts_s.expect("stable");
        assert!((tts - 6.883746e-3).abs() < 1e-7, "{tts}");
        assert_eq!(criteria.tts_s, outcome.contacts[1].first_s);
        // q11 arrives at about 260 rad/s, so the last 0.2° take 13.5 µs.
        let approach = tts - criteria.t_geo_s.expect("in position");
        assert!((approach - 13.5e-6).abs() < 0.1e-6, "{approach}");
        assert_eq!(criteria.rebound_percent, Some(0.0));
        assert_eq!(criteria.class, Class::Stable);
    }
}
