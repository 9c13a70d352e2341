//! Statics of a gripper as plain figures, with units in the names.

use serde::Serialize;

use super::closure::ClosureReport;
use crate::criteria::Fate;
use crate::grasp::finger::Palm;
use crate::grasp::gripper::{GripperGrasp, Holds, Source, Touching};
use crate::gripper::Site;
use crate::report::grasp::ForceClosureReport;
use crate::scene::{Place, Side};
use crate::statics::{
    Balance, Balanced, Blocked, Drive, FormClosure, GripperRow, HandMotion, Held, Limit, MetAt, Spot, StaticsError,
    Yields,
};
use crate::trace::FingerState;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperStaticsReport {
    pub scene: String,
    pub posture: GripperPostureReport,
    /// Of both fingers, or of the differential's input.
    pub motors: Vec<MotorReport>,
    pub contacts: Vec<GripperContactReport>,
    /// With both driven links blocked, and with the input of a differential blocked.
    pub form_closure: Vec<GripperClosureReport>,
    /// One for each friction that was asked for.
    pub holds: Vec<HoldsReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub svg: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperPostureReport {
    /// "run", "geometric" or "given".
    pub source: &'static str,
    /// Of a run.
    pub time_s: Option<f64>,
    pub fate: Option<&'static str>,
    pub right: AnglesReport,
    pub left: AnglesReport,
    pub x_m: f64,
    pub y_m: f64,
    pub mass_kg: f64,
    /// In the palm's frame.
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
    /// What a brake adds at least and at most when it is blocked; null where that is as much as it takes.
    pub brake_min_n_m: Option<f64>,
    pub brake_max_n_m: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperContactReport {
    pub place: String,
    /// On the surface of phalanx or palm.
    pub point_m: [f64; 2],
    /// Into the object.
    pub normal: [f64; 2],
    pub gap_m: f64,
    pub mu_static: f64,
    /// Of the run.
    pub normal_n: Option<f64>,
    pub tangential_n: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperClosureReport {
    /// "outputs" or "input".
    pub blocked: &'static str,
    /// Null where it could not be decided, and then why.
    pub closure: Option<ClosureReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HoldsReport {
    /// Of all contacts; null: those of the scene.
    pub mu_static: Option<f64>,
    pub force_closure: ForceClosureReport,
    pub accelerations: Vec<DirectionReport>,
}

/// What can be balanced of an acceleration of the palm along a direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DirectionReport {
    /// From x towards y of the palm's frame.
    pub angle_rad: f64,
    pub direction: [f64; 2],
    pub blocked: BalanceReport,
    pub at_torque: BalanceReport,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BalanceReport {
    /// "up to", "any" or "nothing".
    pub balanced: &'static str,
    /// Null for the other two.
    pub acceleration_m_s2: Option<f64>,
    /// Contacts and brakes that give way there.
    pub slips: Vec<String>,
    pub leaves: Vec<String>,
    pub brakes_slip: Vec<&'static str>,
    /// Forces that balance it; where they are not the only ones, some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forces: Vec<ForceReport>,
    /// The motion that a larger one drives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<HandMotionReport>,
    /// By how much forces and motion differ, relative to the acceleration or to what is fixed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForceReport {
    pub place: String,
    /// Of a joint limit it is a torque.
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
    /// Of every so many of the directions that were asked for.
    pub fn new(found: &GripperGrasp, every: usize) -> Self {
        let [right, left] = [0, 1].map(|side: usize| angles(&found.sample.fingers[side]));
        let [x_m, y_m] = found.sample.bodies[0].centre_m;
        let (source, time_s, fate) = match found.source {
            Source::Run { time_s, fate } => ("run", Some(time_s), Some(Fate::name(fate))),
            Source::Geometric => ("geometric", None, None),
            Source::Given => ("given", None, None),
        };
        let (mass_kg, gravity_m_s2) = (found.mass_kg, found.gravity_m_s2);
        let posture = GripperPostureReport { source, time_s, fate, right, left, x_m, y_m, mass_kg, gravity_m_s2 };
        let names = motor_names(found.drives.len());
        let palm = found.contacts.iter().find(|touching| touching.place == Place::Palm);
        GripperStaticsReport {
            scene: found.scene.clone(),
            posture,
            motors: found.drives.iter().zip(names).map(|(drive, name)| motor(drive, name)).collect(),
            contacts: found.contacts.iter().map(contact).collect(),
            form_closure: found.closures.iter().map(|(blocked, closure)| closed(*blocked, closure, palm)).collect(),
            holds: found.holds.iter().map(|holds| held(holds, every, names)).collect(),
            svg: None,
        }
    }
}

/// Of as many drives: both fingers', or one input.
fn motor_names(count: usize) -> &'static [&'static str] {
    if count == 1 { &["input"] } else { &["right", "left"] }
}

fn angles(finger: &FingerState) -> AnglesReport {
    let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, .. } = *finger;
    AnglesReport { q11_rad, q21_rad, q12_rad, q22_rad }
}

fn motor(drive: &Drive, name: &'static str) -> MotorReport {
    let [least, most] = drive.brake_n_m.map(|bound| Some(bound).filter(|bound| bound.is_finite()));
    MotorReport { motor: name, torque_n_m: drive.torque_n_m, brake_min_n_m: least, brake_max_n_m: most }
}

fn contact(touching: &Touching) -> GripperContactReport {
    let Touching { place, at: MetAt { point_m, normal, gap_m }, mu_static, forces_n } = *touching;
    GripperContactReport {
        place: place.name(),
        point_m,
        normal,
        gap_m,
        mu_static,
        normal_n: forces_n.map(|[normal_n, _]| normal_n),
        tangential_n: forces_n.map(|[_, tangential_n]| tangential_n),
    }
}

fn closed(
    blocked: Blocked,
    closure: &Result<FormClosure<GripperRow>, StaticsError>,
    palm: Option<&Touching>,
) -> GripperClosureReport {
    // What presses may be some micrometres deep: it rests all the same.
    let palm = if palm.is_some() { Palm::Rests } else { Palm::None };
    GripperClosureReport {
        blocked: if blocked == Blocked::Outputs { "outputs" } else { "input" },
        closure: closure.as_ref().ok().map(|found| ClosureReport::new(found, &palm)),
        reason: closure.as_ref().err().map(StaticsError::to_string),
    }
}

fn held(holds: &Holds, every: usize, motors: &[&'static str]) -> HoldsReport {
    let [blocked, at_torque] = &holds.polar;
    let count = blocked.len() as f64;
    let direction = |(index, (blocked, at_torque)): (usize, (&Balance, &Balance))| DirectionReport {
        angle_rad: std::f64::consts::TAU * index as f64 / count,
        direction: blocked.direction,
        blocked: balance(blocked, motors),
        at_torque: balance(at_torque, motors),
    };
    HoldsReport {
        mu_static: holds.mu_static,
        force_closure: holds.force_closure.into(),
        accelerations: blocked.iter().zip(at_torque).enumerate().step_by(every.max(1)).map(direction).collect(),
    }
}

fn spot(spot: Spot) -> String {
    match spot {
        Spot::Finger(side, site) => Place::Finger(Side::BOTH[side as usize], site).name(),
        Spot::Palm => Place::Palm.name(),
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
        Balanced::Nothing => return none("nothing"),
        Balanced::Any => return none("any"),
        Balanced::UpTo(limit) => limit,
    };
    let which = |yields: Yields| {
        contacts.iter().filter(|held| held.yields == yields).map(|held| spot(held.spot)).collect::<Vec<_>>()
    };
    let slipping = brakes.iter().zip(motors).filter(|(brake, _)| brake.slips);
    let HandMotion { object_m_s, spin_rad_s, fingers_rad_s: [right_rad_s, left_rad_s] } = *motion;
    BalanceReport {
        acceleration_m_s2: Some(*acceleration_m_s2),
        slips: which(Yields::Slips),
        leaves: which(Yields::Leaves),
        brakes_slip: slipping.map(|(_, name)| *name).collect(),
        forces: contacts.iter().map(force).collect(),
        motion: Some(HandMotionReport { object_m_s, spin_rad_s, right_rad_s, left_rad_s }),
        gap: Some(*gap),
        ..none("up to")
    }
}

fn force(held: &Held) -> ForceReport {
    let Held { normal_n, tangential_n, .. } = *held;
    let is_torque = matches!(held.spot, Spot::Finger(_, Site::Limit));
    ForceReport {
        place: spot(held.spot),
        normal_n: (!is_torque).then_some(normal_n),
        tangential_n: (!is_torque).then_some(tangential_n),
        torque_n_m: is_torque.then_some(normal_n),
    }
}
