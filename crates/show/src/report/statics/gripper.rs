//! The JSON document of the static analysis of a gripper, with units in the keys.

use serde::Serialize;

use super::closure::ClosureReport;
use crate::criteria::Fate;
use crate::grasp::finger::Palm;
use crate::grasp::gripper::{FrictionCase, GripperGrasp, ObjectContact, PostureSource};
use crate::gripper::FingerContact;
use crate::report::grasp::ForceClosureReport;
use crate::scene::{GripperContact, Side};
use crate::statics::{
    AccelerationLimit, Balance, Blocked, ContactLoad, ContactLocation, ContactMotion, ContactPoint, Drive, FormClosure,
    HandMotion, Limit, StaticsError,
};
use crate::trace::FingerState;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperStaticsReport {
    pub scene: String,
    pub posture: GripperPostureReport,
    /// Motors of both fingers, or of the differential's input.
    pub motors: Vec<MotorReport>,
    pub contacts: Vec<GripperContactReport>,
    /// Form closure with both driven links blocked, and with the input of a differential blocked.
    pub form_closure: Vec<GripperClosureReport>,
    /// One for each requested friction coefficient.
    #[serde(rename = "holds")]
    pub friction_cases: Vec<FrictionCaseReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub svg: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperPostureReport {
    /// "run", "geometric" or "given".
    pub source: &'static str,
    /// Time of the grasp, for a run.
    pub time_s: Option<f64>,
    /// Fate of the object, for a run.
    pub fate: Option<&'static str>,
    pub right: AnglesReport,
    pub left: AnglesReport,
    pub x_m: f64,
    pub y_m: f64,
    pub mass_kg: f64,
    /// Gravity in the palm's frame.
    pub gravity_m_s2: [f64; 2],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnglesReport {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q12_rad: f64,
    pub q22_rad: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotorReport {
    /// "right", "left" or "input".
    pub motor: &'static str,
    pub torque_n_m: f64,
    /// Minimum torque of the brake when blocked; null if unlimited.
    pub brake_min_n_m: Option<f64>,
    /// Maximum torque of the brake when blocked; null if unlimited.
    pub brake_max_n_m: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperContactReport {
    #[serde(rename = "place")]
    pub contact: String,
    /// Contact point on the surface of phalanx or palm.
    pub point_m: [f64; 2],
    /// Unit normal into the object.
    pub normal: [f64; 2],
    pub gap_m: f64,
    pub mu_static: f64,
    /// Normal force in the run.
    pub normal_n: Option<f64>,
    /// Tangential force in the run.
    pub tangential_n: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperClosureReport {
    /// "outputs" or "input".
    pub blocked: &'static str,
    /// Form closure; null if it could not be decided, for the given `reason`.
    pub closure: Option<ClosureReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrictionCaseReport {
    /// Friction coefficient of all contacts; null for those of the scene.
    pub mu_static: Option<f64>,
    pub force_closure: ForceClosureReport,
    pub accelerations: Vec<DirectionReport>,
}

/// Accelerations of the palm along a direction that can be balanced.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DirectionReport {
    /// Angle from x towards y of the palm's frame.
    pub angle_rad: f64,
    pub direction: [f64; 2],
    pub blocked: BalanceReport,
    pub at_torque: BalanceReport,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BalanceReport {
    /// Range of accelerations that can be balanced: "up to", "any" or "nothing".
    pub balanced: &'static str,
    /// Largest balanced acceleration; null unless `balanced` is "up to".
    pub acceleration_m_s2: Option<f64>,
    /// Contacts that slip at the limit.
    pub slips: Vec<String>,
    /// Contacts that separate at the limit.
    pub leaves: Vec<String>,
    /// Brakes that slip at the limit.
    pub brakes_slip: Vec<&'static str>,
    /// Forces that balance the acceleration; they need not be unique.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forces: Vec<ForceReport>,
    /// The motion caused by a larger acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<HandMotionReport>,
    /// Duality gap between forces and motion, relative to the acceleration or to the fixed loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForceReport {
    #[serde(rename = "place")]
    pub contact: String,
    /// Normal force; null for a joint limit, which has a torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_n: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_n: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HandMotionReport {
    pub object_m_s: [f64; 2],
    pub spin_rad_s: f64,
    /// (q̇11, q̇21).
    pub right_rad_s: [f64; 2],
    pub left_rad_s: [f64; 2],
}

impl GripperStaticsReport {
    /// Builds the report with every `stride`-th of the requested directions.
    pub fn new(found: &GripperGrasp, stride: usize) -> Self {
        let [right, left] = [0, 1].map(|side: usize| angles(&found.sample.fingers[side]));
        let [x_m, y_m] = found.sample.bodies[0].centre_m;
        let (source, time_s, fate) = match found.source {
            PostureSource::Run { time_s, fate } => ("run", Some(time_s), Some(Fate::name(fate))),
            PostureSource::Geometric => ("geometric", None, None),
            PostureSource::Explicit => ("given", None, None),
        };
        let (mass_kg, gravity_m_s2) = (found.mass_kg, found.gravity_m_s2);
        let posture = GripperPostureReport { source, time_s, fate, right, left, x_m, y_m, mass_kg, gravity_m_s2 };
        let names = motor_names(found.drives.len());
        let palm = found.contacts.iter().find(|contact| contact.id == GripperContact::Palm);
        GripperStaticsReport {
            scene: found.scene.clone(),
            posture,
            motors: found.drives.iter().zip(names).map(|(drive, name)| motor(drive, name)).collect(),
            contacts: found.contacts.iter().map(contact).collect(),
            form_closure: found
                .closures
                .iter()
                .map(|(blocked, closure)| closure_report(*blocked, closure, palm))
                .collect(),
            friction_cases: found.friction_cases.iter().map(|case| friction_case_report(case, stride, names)).collect(),
            svg: None,
        }
    }
}

/// Names of the motors: of both fingers, or of one input.
fn motor_names(count: usize) -> &'static [&'static str] {
    if count == 1 { &["input"] } else { &["right", "left"] }
}

fn angles(finger: &FingerState) -> AnglesReport {
    let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, .. } = *finger;
    AnglesReport { q11_rad, q21_rad, q12_rad, q22_rad }
}

fn motor(drive: &Drive, name: &'static str) -> MotorReport {
    let [min_n_m, max_n_m] = drive.brake_n_m.map(|bound| Some(bound).filter(|bound| bound.is_finite()));
    MotorReport { motor: name, torque_n_m: drive.torque_n_m, brake_min_n_m: min_n_m, brake_max_n_m: max_n_m }
}

fn contact(contact_id: &ObjectContact) -> GripperContactReport {
    let ObjectContact { id, point: ContactPoint { point_m, normal, gap_m }, mu_static, forces_n } = *contact_id;
    GripperContactReport {
        contact: id.name(),
        point_m,
        normal,
        gap_m,
        mu_static,
        normal_n: forces_n.map(|[normal_n, _]| normal_n),
        tangential_n: forces_n.map(|[_, tangential_n]| tangential_n),
    }
}

fn closure_report(
    blocked: Blocked,
    closure: &Result<FormClosure, StaticsError>,
    palm: Option<&ObjectContact>,
) -> GripperClosureReport {
    // An active contact may penetrate by some micrometres; the object rests on the palm nevertheless.
    let palm = if palm.is_some() { Palm::Resting } else { Palm::None };
    GripperClosureReport {
        blocked: if blocked == Blocked::Outputs { "outputs" } else { "input" },
        closure: closure.as_ref().ok().map(|found| ClosureReport::new(found, &palm)),
        reason: closure.as_ref().err().map(StaticsError::to_string),
    }
}

fn friction_case_report(friction_case: &FrictionCase, stride: usize, motors: &[&'static str]) -> FrictionCaseReport {
    let [blocked, at_torque] = &friction_case.polar;
    let count = blocked.len() as f64;
    let direction = |(index, (blocked, at_torque)): (usize, (&Balance, &Balance))| DirectionReport {
        angle_rad: std::f64::consts::TAU * index as f64 / count,
        direction: blocked.direction,
        blocked: balance(blocked, motors),
        at_torque: balance(at_torque, motors),
    };
    FrictionCaseReport {
        mu_static: friction_case.mu_static,
        force_closure: friction_case.force_closure.into(),
        accelerations: blocked.iter().zip(at_torque).enumerate().step_by(stride.max(1)).map(direction).collect(),
    }
}

fn contact_name(location: ContactLocation) -> String {
    match location {
        ContactLocation::Finger(side, site) => GripperContact::Finger(Side::BOTH[side as usize], site).name(),
        ContactLocation::Palm => GripperContact::Palm.name(),
    }
}

fn balance(balance: &Balance, motors: &[&'static str]) -> BalanceReport {
    let none = |balanced| BalanceReport {
        balanced,
        acceleration_m_s2: None,
        slips: Vec::new(),
        leaves: Vec::new(),
        brakes_slip: Vec::new(),
        forces: Vec::new(),
        motion: None,
        gap: None,
    };
    let Limit { acceleration_m_s2, contacts, brakes, motion, gap } = match &balance.largest {
        AccelerationLimit::Infeasible => return none("nothing"),
        AccelerationLimit::Unlimited => return none("any"),
        AccelerationLimit::Limited(limit) => limit,
    };
    let locations_with = |contact_motion: ContactMotion| {
        contacts
            .iter()
            .filter(|load| load.contact_motion == contact_motion)
            .map(|load| contact_name(load.location))
            .collect::<Vec<_>>()
    };
    let slipping = brakes.iter().zip(motors).filter(|(brake, _)| brake.slips);
    let HandMotion { object_m_s, spin_rad_s, fingers_rad_s: [right_rad_s, left_rad_s] } = *motion;
    BalanceReport {
        acceleration_m_s2: Some(*acceleration_m_s2),
        slips: locations_with(ContactMotion::Slips),
        leaves: locations_with(ContactMotion::Separates),
        brakes_slip: slipping.map(|(_, name)| *name).collect(),
        forces: contacts.iter().map(force).collect(),
        motion: Some(HandMotionReport { object_m_s, spin_rad_s, right_rad_s, left_rad_s }),
        gap: Some(*gap),
        ..none("up to")
    }
}

fn force(load: &ContactLoad) -> ForceReport {
    let ContactLoad { normal_n, tangential_n, .. } = *load;
    let is_torque = matches!(load.location, ContactLocation::Finger(_, FingerContact::Limit));
    ForceReport {
        contact: contact_name(load.location),
        normal_n: (!is_torque).then_some(normal_n),
        tangential_n: (!is_torque).then_some(tangential_n),
        torque_n_m: is_torque.then_some(normal_n),
    }
}
