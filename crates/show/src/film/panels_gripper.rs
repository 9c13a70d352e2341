//! The plots of a gripper.

use super::develop::{Curve, Plan, Scale, plan};
use super::panels::{energies, gaps, of_contacts};
use crate::numeric::plane::turned;
use crate::scene::{GripperScene, ObjectMotion, Place, Side};
use crate::trace::{BodyState, FingerState, Sample, Site};

/// A quantity of a finger, by its name.
type OfFinger = (&'static str, fn(&FingerState) -> f64, Option<fn(&FingerState) -> f64>);

/// Of two fingers and what they grasp; `contacts` are those that are shown, by their names and indices.
pub(super) fn of_gripper(scene: &GripperScene, contacts: &[(String, usize)]) -> Vec<Plan<'static>> {
    let laws = scene.fingers.iter().flat_map(|finger| [finger.contact.proximal, finger.contact.distal]);
    let planes = scene.palm.into_iter().chain(scene.table.map(|table| table.contact));
    let friction = match laws.chain(planes).any(|law| law.friction.is_some()) {
        true => of_contacts(contacts, |contact| contact.tangential_n),
        false => Vec::new(),
    };
    let mut torques = of_fingers(&[("motor", |finger| finger.motor_torque_n_m, None)]);
    for side in Side::BOTH.into_iter().filter(|side| scene.finger(*side).limit.is_some()) {
        let index = index(Place::Finger(side, Site::Limit));
        torques
            .push(Curve::new(format!("{} limit", side.word()), move |sample: &Sample| sample.contacts[index].normal_n));
    }
    let object = |curves: Vec<Curve<'static>>| match scene.object.motion {
        ObjectMotion::Free { .. } => curves,
        ObjectMotion::Fixed => Vec::new(),
    };
    vec![
        plan("Normal force", "N", Scale::Logarithmic, of_contacts(contacts, |contact| contact.normal_n)),
        plan("Friction force", "N", Scale::Logarithmic, friction),
        plan("Gap", "m", Scale::Logarithmic, gaps(contacts)),
        plan(
            "Object",
            "m",
            Scale::Linear,
            object(vec![
                body("x", |body| body.centre_m[0]).with_rate(|sample| sample.bodies[0].velocity_m_s[0]),
                body("y", |body| body.centre_m[1]).with_rate(|sample| sample.bodies[0].velocity_m_s[1]),
            ]),
        ),
        plan(
            "Object velocity",
            "m/s",
            Scale::Linear,
            object(vec![body("vx", |body| body.velocity_m_s[0]), body("vy", |body| body.velocity_m_s[1])]),
        ),
        plan(
            "Object angle",
            "rad",
            Scale::Linear,
            object(vec![body("angle", |body| body.angle_rad).with_rate(|sample| sample.bodies[0].spin_rad_s)]),
        ),
        plan(
            "Joint angle",
            "rad",
            Scale::Linear,
            of_fingers(&[
                ("q11", |finger| turned(finger.q11_rad), Some(|finger| finger.qd11_rad_s)),
                ("q21", |finger| turned(finger.q21_rad), Some(|finger| finger.qd21_rad_s)),
                ("q22", |finger| turned(finger.q22_rad), Some(|finger| finger.qd22_rad_s)),
            ]),
        ),
        plan(
            "Joint rate",
            "rad/s",
            Scale::Linear,
            of_fingers(&[
                ("qd11", |finger| finger.qd11_rad_s, None),
                ("qd21", |finger| finger.qd21_rad_s, None),
                ("qd22", |finger| finger.qd22_rad_s, None),
            ]),
        ),
        energies(),
        plan("Torque", "N·m", Scale::Linear, torques),
    ]
}

/// The same quantities of both fingers.
fn of_fingers(quantities: &[OfFinger]) -> Vec<Curve<'static>> {
    let mut curves = Vec::new();
    for side in Side::BOTH {
        for &(quantity, value, rate) in quantities {
            let index = side as usize;
            let name = format!("{} {quantity}", side.word());
            let curve = Curve::new(name, move |sample: &Sample| value(&sample.fingers[index]));
            curves.push(match rate {
                Some(rate) => curve.with_rate(move |sample| rate(&sample.fingers[index])),
                None => curve,
            });
        }
    }
    curves
}

fn body(name: &str, value: fn(&BodyState) -> f64) -> Curve<'static> {
    Curve::new(name, move |sample: &Sample| value(&sample.bodies[0]))
}

/// Where a place is among the contacts of a sample.
fn index(place: Place) -> usize {
    Place::ALL.iter().position(|known| *known == place).expect("every place is one of all")
}
