//! The anchor case, design 95 of the thesis, through model, log and criteria at once.

mod synthetic;

use phalanx::criteria::{Class, FinalAngles, Tracker};
use phalanx::gripper::{Circle, bodies, final_posture};
use phalanx::law::{ContactLaw, FrictionLaw, NormalLaw};
use phalanx::scene::{Contacts, Initial, Scene};
use phalanx::trace::run_analytic;
use synthetic::scene;

/// Design 95 as the thesis gives it (its Table 3.2 and §4.3), at rest 25° short of the proximal contact.
fn design95() -> Scene {
    let base = scene();
    let lengths = base.finger.lengths;
    let contact = ContactLaw {
        normal: base.contact.proximal.normal,
        friction: Some(FrictionLaw {
            mu_static: 0.8,
            mu_dynamic: 0.56,
            v_static_m_s: 0.1,
            v_dynamic_m_s: 0.2,
        }),
    };
    let mut design = Scene {
        limit: Some(NormalLaw {
            stiffness_n_per_m_e: 1e11,
            damping_max_n_s_per_m: 1e9,
            ..base.contact.proximal.normal
        }),
        contact: Contacts {
            proximal: contact,
            distal: contact,
        },
        initial: Initial {
            q11_rad: -49.999f64.to_radians(),
            q21_rad: 40.001f64.to_radians(),
            qd11_rad_s: 0.0,
            qd21_rad_s: 0.0,
        },
        ..base
    };
    design.finger.bodies = bodies(&lengths, 1070.0, 40e-3).expect("masses");
    design
}

#[test]
fn design_95_is_stable_when_its_tip_has_landed() {
    let scene = design95();
    let object = scene.object.expect("an object");
    let disc = Circle {
        radius_m: object.radius_m,
        centre_m: object.centre_m,
    };
    let end = final_posture(&scene.finger.lengths, scene.finger.assembly, disc).expect("a grasp");
    for numeric_hz in [1e3, 1e4, 1e6] {
        let mut scene = scene.clone();
        scene.log.numeric_hz = numeric_hz;
        let mut tracker = Tracker::new(FinalAngles {
            q11_rad: end.posture.q11_rad,
            q21_rad: end.posture.q21_rad,
        });
        let outcome = run_analytic(&scene, &mut tracker).expect("completed");
        let criteria = tracker.criteria(true);
        println!("{numeric_hz} {criteria:?} {:?}", outcome.sites);
        // 1-model §1.8: the tip lands at 6.883746 ms, and nothing rebounds.
        let tts = criteria.tts_s.expect("stable");
        assert!((tts - 6.883746e-3).abs() < 1e-6, "{tts}");
        assert_eq!(criteria.rebound_percent, Some(0.0));
        assert_eq!(criteria.class, Class::Stable);
    }
}
