//! Figures of five-bar hands: what a study of fingers or of grippers reports of each run, with the names of the columns.

use std::sync::LazyLock;

use crate::criteria::{Criteria, Fate, ObjectCriteria, StaticGrasp, is_form_closed};
use crate::gripper::{Lengths, total_mass};
use crate::scene::{HandContact, HandFinger, Profile, Scene, Side};
use crate::statics::{Equilibrium, palm_force_with_mu};
use crate::study::constant_spring;
use crate::table::Value;
use crate::trace::{FingerContact, Outcome};

/// A figure of a run: the name of its column, and its value.
pub(super) struct Figure<Reader: ?Sized> {
    pub name: String,
    pub value: Box<Reader>,
}

/// Figures in the order of their columns: those of the design precede the status of the run.
pub(super) struct HandFigures<Reader: ?Sized> {
    pub design: Vec<Figure<Reader>>,
    pub run: Vec<Figure<Reader>>,
}

impl<Reader: ?Sized> HandFigures<Reader> {
    pub fn all(&self) -> impl Iterator<Item = &Figure<Reader>> {
        self.design.iter().chain(&self.run)
    }
}

/// Statics of a grasp by a finger, or the reasons why they cannot be computed.
pub(super) struct Statics {
    pub grasp: Result<StaticGrasp, String>,
    pub form_closed: Result<bool, String>,
}

/// A run of a finger.
pub(super) struct FingerRun<'a> {
    pub scene: &'a Scene,
    pub statics: &'a Statics,
    /// Criteria and outcome of the closing; `None` before the closing has been simulated, or without a grasp.
    pub closing: Option<(Criteria, &'a Outcome)>,
}

impl FingerRun<'_> {
    fn finger(&self) -> &HandFinger {
        self.scene.finger()
    }

    fn lengths(&self) -> &Lengths {
        &self.finger().linkage.lengths
    }

    fn grasp(&self) -> Option<&StaticGrasp> {
        self.statics.grasp.as_ref().ok()
    }

    fn static_forces(&self) -> Option<&Equilibrium> {
        self.grasp()?.forces.as_ref().ok()
    }

    fn criteria(&self) -> Option<&Criteria> {
        self.closing.as_ref().map(|(criteria, _)| criteria)
    }

    /// Normal force of a phalanx at the end.
    fn normal_n(&self, contact: FingerContact) -> Option<f64> {
        self.closing.as_ref().map(|(_, outcome)| outcome.last.finger_contact(contact).normal_n)
    }

    fn peak_n(&self, contact: FingerContact) -> Option<f64> {
        self.closing.as_ref().map(|(_, outcome)| outcome.finger_contact(contact).peak_normal_n)
    }

    /// Palm force of the grasp with the forces at the end.
    fn palm_n(&self) -> Option<f64> {
        let grasp = self.grasp()?;
        let forces_n = [self.normal_n(FingerContact::Proximal)?, self.normal_n(FingerContact::Distal)?];
        Some(palm_force_with_mu(&grasp.end, forces_n, grasp.mu_static))
    }
}

type OfFinger = dyn Fn(&FingerRun<'_>) -> Value + Send + Sync;

fn finger<V: Into<Value>>(name: &str, value: impl Fn(&FingerRun<'_>) -> V + Send + Sync + 'static) -> Figure<OfFinger> {
    Figure { name: name.to_string(), value: Box::new(move |run| value(run).into()) }
}

/// Figures of fingers: dimensions, statics; class and forces.
pub(super) static FINGER_FIGURES: LazyLock<HandFigures<OfFinger>> = LazyLock::new(|| HandFigures {
    design: vec![
        finger("l12_m", |run| run.lengths().l12_m),
        finger("l21_m", |run| run.lengths().l21_m),
        finger("l22_m", |run| run.lengths().l22_m),
        finger("t22_m", |run| run.lengths().t22_m),
        finger("mass_kg", |run| total_mass(&run.finger().linkage.bodies)),
        finger("trajectory_rad", |run| {
            run.grasp().map(|grasp| grasp.end.posture.q11_rad - run.finger().initial.q11_rad)
        }),
        // Like the static analysis, this uses the torque at the end of the run.
        finger("motor_n_m", |run| run.finger().motor.actuation.at(run.scene.duration_s).0),
        finger("spring_n_m", |run| constant_spring(run.finger())),
        finger("static_f21_n", |run| run.static_forces().map(|forces| forces.f21_n)),
        finger("static_f22_n", |run| run.static_forces().map(|forces| forces.f22_n)),
        finger("static_pfp_n", |run| run.static_forces().map(|forces| forces.pfp_n)),
        finger("force_positive", |run| run.static_forces().map(Equilibrium::is_force_positive)),
        finger("form_closed", |run| run.statics.form_closed.as_ref().ok().copied()),
    ],
    run: vec![
        finger("t_geo_s", |run| run.criteria().map(|criteria| criteria.t_geo_s)),
        finger("tts_s", |run| run.criteria().map(|criteria| criteria.tts_s)),
        finger("rebound_percent", |run| run.criteria().map(|criteria| criteria.rebound_percent)),
        finger("class", |run| run.criteria().map(|criteria| criteria.class.name())),
        finger("class_reason", |run| run.criteria().map(|criteria| criteria.class_reason.to_string())),
        finger("f21_n", |run| run.normal_n(FingerContact::Proximal)),
        finger("f22_n", |run| run.normal_n(FingerContact::Distal)),
        finger("pfp_n", |run| run.palm_n()),
        finger("peak_f21_n", |run| run.peak_n(FingerContact::Proximal)),
        finger("peak_f22_n", |run| run.peak_n(FingerContact::Distal)),
    ],
});

/// A run of a gripper.
pub(super) struct GripperRun<'a> {
    pub scene: &'a Scene,
    /// Criteria, largest overlap of links, and outcome; `None` before the run has been simulated.
    pub grasp: Option<(ObjectCriteria, f64, &'a Outcome)>,
}

impl GripperRun<'_> {
    /// Driving torque of a finger at the end of the run, with its half of the differential's input.
    fn motor_n_m(&self, side: Side) -> f64 {
        let hand = &self.scene.hand;
        let torque_n_m = |actuation: &Profile| actuation.at(self.scene.duration_s).0;
        let input_n_m = hand.differential.as_ref().map_or(0.0, |input| torque_n_m(&input.motor.actuation));
        torque_n_m(&hand.finger(side).motor.actuation) + 0.5 * input_n_m
    }

    fn criteria<V: Into<Value>>(&self, value: impl Fn(&ObjectCriteria) -> V) -> Value {
        self.grasp.as_ref().map(|(criteria, ..)| value(criteria)).into()
    }

    fn form_closed(&self) -> Option<bool> {
        let (criteria, ..) = self.grasp.as_ref()?;
        is_form_closed(self.scene, &criteria.end).filter(|_| criteria.fate == Fate::Held)
    }

    /// A value of a contact that exists in this gripper.
    fn contact<V: Into<Value>>(&self, contact: HandContact, value: impl Fn(&Outcome, usize) -> V) -> Value {
        let index = self.scene.hand.contact_index(contact);
        self.grasp.as_ref().zip(index).map(|((.., outcome), index)| value(outcome, index)).into()
    }
}

type OfGripper = dyn Fn(&GripperRun<'_>) -> Value + Send + Sync;

fn gripper<V: Into<Value>>(
    name: impl Into<String>,
    value: impl Fn(&GripperRun<'_>) -> V + Send + Sync + 'static,
) -> Figure<OfGripper> {
    Figure { name: name.into(), value: Box::new(move |run| value(run).into()) }
}

/// The same figure of both fingers.
fn of_sides<V: Into<Value>>(
    quantity: &str,
    value: impl Fn(&GripperRun<'_>, Side) -> V + Copy + Send + Sync + 'static,
) -> impl Iterator<Item = Figure<OfGripper>> {
    Side::BOTH.map(|side| gripper(format!("{}_{quantity}", side.name()), move |run| value(run, side))).into_iter()
}

/// Figures of grippers: dimensions and torques; fate and final position of the object, and forces.
pub(super) static GRIPPER_FIGURES: LazyLock<HandFigures<OfGripper>> = LazyLock::new(|| {
    let surfaces = HandContact::ALL.into_iter().filter(|contact| !contact.is_stop());
    let phalanges = [FingerContact::Proximal, FingerContact::Distal];
    let first_touches = phalanges.into_iter().flat_map(|phalanx| Side::BOTH.map(|side| (side, phalanx)));
    HandFigures {
        design: [gripper("palm_width_m", |run| run.scene.hand.palm_width_m)]
            .into_iter()
            .chain(of_sides("l21_m", |run, side| run.scene.hand.finger(side).linkage.lengths.l21_m))
            .chain(of_sides("motor_n_m", |run, side| run.motor_n_m(side)))
            .chain(of_sides("spring_n_m", |run, side| constant_spring(run.scene.hand.finger(side))))
            .collect(),
        run: [
            gripper("grasp", |run| run.criteria(|criteria| criteria.fate.name())),
            gripper("grasped_s", |run| run.criteria(|criteria| criteria.grasped_s)),
            gripper("tts_s", |run| run.criteria(|criteria| criteria.tts_s)),
            gripper("until_s", |run| run.criteria(|criteria| criteria.fate.lost_at_s())),
            gripper("form_closed", |run| run.form_closed()),
            gripper("x_start_m", |run| run.scene.hand.grasped().centre_m[0]),
            gripper("x_m", |run| run.criteria(|criteria| criteria.last.centre_m[0])),
            gripper("y_m", |run| run.criteria(|criteria| criteria.last.centre_m[1])),
            gripper("angle_rad", |run| run.criteria(|criteria| criteria.last.angle_rad)),
            gripper("offset_ratio", |run| run.criteria(ObjectCriteria::offset_ratio)),
            gripper("speed_m_s", |run| run.criteria(ObjectCriteria::end_speed_m_s)),
            gripper("slip_m", |run| run.criteria(|criteria| criteria.slip.map(|slip| slip.displacement_m))),
            gripper("slip_rad", |run| run.criteria(|criteria| criteria.slip.map(|slip| slip.rotation_rad))),
            gripper("contacts_lost", |run| run.criteria(|criteria| i64::from(criteria.contacts_lost()))),
            gripper("link_overlap_m", |run| run.grasp.as_ref().map(|(_, overlap_m, _)| *overlap_m)),
        ]
        .into_iter()
        .chain(first_touches.map(|(side, phalanx)| {
            let contact = HandContact::Finger(side, phalanx);
            let first_s = |outcome: &Outcome, index: usize| outcome.contacts[index].first_s;
            gripper(format!("{}_first_s", contact.name()), move |run| run.contact(contact, first_s))
        }))
        .chain(surfaces.clone().map(|contact| {
            let normal_n = |outcome: &Outcome, index| outcome.last.contact(index).normal_n;
            gripper(format!("{}_n", contact.name()), move |run| run.contact(contact, normal_n))
        }))
        .chain(surfaces.filter(|contact| *contact != HandContact::Table).map(|contact| {
            let peak_n = |outcome: &Outcome, index: usize| outcome.contacts[index].peak_normal_n;
            gripper(format!("peak_{}_n", contact.name()), move |run| run.contact(contact, peak_n))
        }))
        .collect(),
    }
});
