//! Grasp criteria of the gripper reference cases, and form closure of their final grasps.

use phalanx::criteria::{Fate, ObjectCriteria, ObjectTracker, PairCriteria, grasp_configuration, normal_forces};
use phalanx::gripper::{FingerContact, final_posture};
use phalanx::scene::{HandContact, Scene, Side, Thresholds};
use phalanx::shape::PlacedShape;
use phalanx::statics::{Blocked, Decision, FormClosure, PerContact, form_closure, gripper_closure, gripper_unilateral};
use phalanx::trace::{Model, Sample, run};

use crate::support::reference_cases::{cases_at_rest, reference_case};
use crate::support::runs::assert_near;
use crate::support::statics::check_certificate;

fn run_with_tracker(scene: &Scene) -> (ObjectCriteria, Sample) {
    let mut tracker = ObjectTracker::for_scene(scene).expect("a grasp");
    let outcome = run(Model::Analytic, scene, &mut tracker).expect("a completed run");
    (tracker.criteria().expect("samples"), outcome.last)
}

fn criteria_of(criteria: &ObjectCriteria, id: HandContact) -> &PairCriteria {
    criteria.pairs.iter().find(|pair| pair.name == id.name()).expect("criteria of this contact")
}

const PHALANGES: [HandContact; 4] = [
    HandContact::Finger(Side::Right, FingerContact::Proximal),
    HandContact::Finger(Side::Right, FingerContact::Distal),
    HandContact::Finger(Side::Left, FingerContact::Proximal),
    HandContact::Finger(Side::Left, FingerContact::Distal),
];

#[test]
fn every_case_is_held_and_first_contacts_match_the_independent_program() {
    for case in cases_at_rest() {
        let (criteria, _) = run_with_tracker(&case.scene);
        let name = &case.name;
        assert_eq!(criteria.fate, Fate::Held, "{name}");
        for (id, expected) in PHALANGES.into_iter().zip(case.first_contact_s) {
            let contact = criteria_of(&criteria, id);
            let first = contact.first_s.expect("a first contact");
            // Errors grow through impacts. Only the reference preset gives contact times after the first to 1e-8 s.
            assert_near(first, expected, 5e-8, format!("{name}: {id:?}"));
            assert!(contact.active_since_s.expect("a lasting contact") <= criteria.tts_s.expect("a stable grasp"));
        }
        let second_finger_s = case.first_contact_s[0].max(case.first_contact_s[2]);
        assert_near(criteria.grasped_s.expect("a grasp"), second_finger_s, 5e-8, format!("{name}: grasped"));
        let end = case.states.last().expect("states");
        (0..2).for_each(|axis| assert_near(criteria.last.centre_m[axis], end.q[4 + axis], 2e-7, name));
    }
}

/// Without a table the object is held by the four phalanges alone. They never lose contact, and the grasp is stable
/// from the last first contact on.
#[test]
fn case_a_is_held_by_four_contacts() {
    let (criteria, last) = run_with_tracker(&reference_case("a").scene);
    assert_eq!(criteria_of(&criteria, HandContact::Palm).first_s, None);
    assert!(criteria.pairs.iter().all(|pair| pair.name != HandContact::Table.name()), "there is no table");
    let first_contacts = PHALANGES.map(|contact| criteria_of(&criteria, contact).first_s.expect("a first contact"));
    assert_eq!(criteria.tts_s, Some(first_contacts.into_iter().fold(0.0, f64::max)));
    assert!(PHALANGES.iter().all(|contact| criteria_of(&criteria, *contact).times_lost == 0));
    assert_eq!(criteria.offset_ratio(), None, "the object starts at the centre");
    // With regularised friction the object creeps; the criteria report its speed and displacement.
    assert!((criteria.end_speed_m_s() - 0.0186).abs() < 1e-4, "{}", criteria.end_speed_m_s());
    assert!((criteria.travel.displacement_m - (last.body(0).centre_m[1] - 0.02)).abs() < 1e-9);
    let slip = criteria.slip.expect("a grasp").displacement_m;
    assert!(slip > 5e-5 && slip < criteria.travel.displacement_m, "{slip}");
}

/// The grasp centres its object: the offset decreases from 3.5 mm to 0.550 mm.
#[test]
fn case_c_centres_its_object() {
    // Without thresholds every loss of contact counts.
    let (criteria, _) = run_with_tracker(&Scene { thresholds: Thresholds::NONE, ..reference_case("c").scene });
    assert!((criteria.last.centre_m[0] - 0.5504e-3).abs() < 2e-7, "{:?}", criteria.last.centre_m);
    let ratio = criteria.offset_ratio().expect("an initial offset");
    assert!((ratio - 0.5504 / 3.5).abs() < 1e-4, "{ratio}");
    // The object still moves at the end, and has moved since the grasp.
    assert!(criteria.end_speed_m_s() > 0.03, "{}", criteria.end_speed_m_s());
    assert!(criteria.slip.expect("a grasp").displacement_m > 1e-3);
    // The table is the last contact to close for good, because the impacts have thrown the object off it.
    assert_eq!(criteria.tts_s, criteria_of(&criteria, HandContact::Table).active_since_s);
    assert!(criteria_of(&criteria, HandContact::Finger(Side::Left, FingerContact::Proximal)).lost_s > 4e-3);
}

/// Before the left finger arrives there is no grasp. Without friction and table, the fingers press from both sides but never
/// balance each other: the object is not gripped, and ejected.
#[test]
fn lost_objects_are_reported_with_their_fate() {
    let mut early_end = reference_case("c").scene;
    early_end.duration_s = 6e-3;
    assert_eq!(run_with_tracker(&early_end).0.fate, Fate::NotGrasped);

    let mut frictionless = reference_case("a").scene;
    for finger in &mut frictionless.hand.fingers {
        (finger.contact.proximal.friction, finger.contact.distal.friction) = (None, None);
    }
    let mut run_for = |duration_s: f64| {
        frictionless.duration_s = duration_s;
        run_with_tracker(&frictionless)
    };
    let (criteria, _) = run_for(25e-3);
    assert_eq!((criteria.fate, criteria.held_since_s), (Fate::NotGrasped, None));
    assert!((criteria.end_speed_m_s() - 1.5).abs() < 0.1, "thrown out at {} m/s", criteria.end_speed_m_s());

    let (criteria, _) = run_for(80e-3);
    let Fate::Ejected { at_s } = criteria.fate else { panic!("{:?}", criteria.fate) };
    assert_eq!((criteria.grasped_s, criteria.tts_s, criteria.until_s), (None, None, Some(at_s)));
    let [x, y] = run_for(at_s).1.body(0).centre_m;
    let reach_m = 0.02 + 0.02443242165159721 + 0.012856584748806986 + 0.0025;
    assert!(((x.abs() - 0.0155).hypot(y) - reach_m).abs() < 1e-6, "out of reach at {at_s}: {x}, {y}");
}

fn checked_closure(scene: &Scene, last: &Sample, active_contacts: &PerContact<bool>, blocked: Blocked) -> FormClosure {
    let configuration = grasp_configuration(scene, last);
    let closure = gripper_closure(&configuration, active_contacts, blocked).expect("a decision");
    check_certificate(&gripper_unilateral(&configuration, active_contacts, blocked).expect("a posture"), &closure);
    closure
}

/// At the end of every case all four phalanges are in contact with the object; the palm is not, because a table
/// supports the object instead. The count 4 + 2 < 7 excludes form closure. An object within 10 µm of the palm would
/// rest on the palm without the table, which makes case b form-closed. On a palm of 34 mm, design 95 is not
/// form-closed, even with a centred object.
#[test]
fn form_closure_of_final_grasps_with_and_without_the_palm() {
    for (letter, palm_is_close, closed) in
        [("a", false, false), ("b", true, true), ("c", true, false), ("f", true, false)]
    {
        let scene = reference_case(letter).scene;
        let (_, last) = run_with_tracker(&scene);
        let active_contacts = normal_forces(&scene, &last).map(|force| force > 0.0);
        assert_eq!(active_contacts, PerContact { phalanges: [[true; 2]; 2], palm: false }, "{letter}");
        let without_palm = checked_closure(&scene, &last, &active_contacts, Blocked::Outputs);
        assert!(!without_palm.closed && !without_palm.necessary.is_met(), "{letter}");

        let close_contacts = grasp_configuration(&scene, &last).contact_points().expect("a posture");
        let close_contacts = close_contacts.map(|point| point.gap_m <= 1e-5);
        assert_eq!(close_contacts, PerContact { palm: palm_is_close, ..active_contacts }, "{letter}");
        let with_palm = PerContact { palm: true, ..active_contacts };
        let closure = checked_closure(&scene, &last, &with_palm, Blocked::Outputs);
        assert_eq!((closure.decision, closure.necessary.is_met()), (Decision::Signs, true), "{letter}");
        assert_eq!(closure.closed, closed, "{letter}: margin {:?}", closure.margin);

        let input_blocked = checked_closure(&scene, &last, &with_palm, Blocked::Input);
        assert!(!input_blocked.closed && !input_blocked.necessary.is_met(), "{letter}");
    }
    let finger = reference_case("c").scene.hand.fingers[0].linkage;
    for (base_m, closed) in [(15.5e-3, true), (17e-3, false)] {
        let disc = PlacedShape::disc(0.02, [-base_m, 0.02]);
        let end = final_posture(&finger.lengths, finger.assembly, disc).expect("a grasp");
        assert_eq!(form_closure(&finger, &end).expect("a decision").closed, closed, "{base_m}");
    }
}
