//! Form closure as plain figures: a certificate by the names of its constraints.

use serde::Serialize;

use super::motion::{FingerMotionReport, MotionReport, RateReport};
use super::words::{motion_words, palm};
use crate::grasp::finger::Palm;
use crate::gripper::Site;
use crate::statics::{Certificate, Decision, FormClosure, GripperRow, Kind, Row, Unknown};

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosureReport {
    pub closed: bool,
    /// Whether the object rests on the palm: "rests", "within", "apart" or "none".
    pub palm: &'static str,
    /// How far the object is above the palm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub palm_gap_m: Option<f64>,
    pub necessary: NecessaryReport,
    pub rank: usize,
    pub unknowns: usize,
    /// Smallest over largest multiplier where these are unique, each for a constraint of one scale.
    pub margin: Option<f64>,
    /// "rank", "signs" or "programme".
    pub decision: &'static str,
    /// Closed: forces and torques in balance, all positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multipliers: Option<Vec<MultiplierReport>>,
    /// Not closed: a motion that breaks no constraint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionReport>,
    /// What the certificate is off by, relative to what it weighs.
    pub residual: f64,
}

/// (1.19): contacts + motors ≥ hand + object + 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NecessaryReport {
    pub contacts: usize,
    pub motors: usize,
    pub hand: usize,
    pub object: usize,
    pub met: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MultiplierReport {
    pub constraint: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_n: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<f64>,
}

impl ClosureReport {
    pub fn new(found: &FormClosure<GripperRow>, resting: &Palm) -> Self {
        let count = found.necessary;
        let (multipliers, motion, residual) = match &found.certificate {
            Certificate::Multipliers { values, residual } => (Some(multipliers(found, values)), None, *residual),
            Certificate::Motion { values, rates, residual } => (None, Some(motion(found, values, rates)), *residual),
        };
        Self {
            closed: found.closed,
            palm: palm(resting),
            palm_gap_m: match resting {
                Palm::Apart { gap_m } => Some(*gap_m),
                Palm::Within { depth_m } => Some(-depth_m),
                Palm::Rests | Palm::None => None,
            },
            necessary: NecessaryReport {
                contacts: count.contacts,
                motors: count.motors,
                hand: count.hand,
                object: count.object,
                met: count.is_met(),
            },
            rank: found.rank,
            unknowns: found.unknowns.len(),
            margin: found.margin,
            decision: match found.decision {
                Decision::Rank => "rank",
                Decision::Signs => "signs",
                Decision::Programme => "programme",
            },
            multipliers,
            motion,
            residual,
        }
    }
}

/// "right", "left", and beyond these a number.
pub(super) fn finger_name(finger: usize) -> String {
    match finger {
        0 => "right".to_string(),
        1 => "left".to_string(),
        more => format!("finger {}", more + 1),
    }
}

fn constraint(row: GripperRow) -> String {
    let GripperRow::Hand(row) = row else { return "input".to_string() };
    match row {
        Row::Contact { finger, site: Site::Proximal } => format!("{} proximal phalanx", finger_name(finger)),
        Row::Contact { finger, .. } => format!("{} tip", finger_name(finger)),
        Row::Palm => "palm".to_string(),
        Row::Motor { finger } => format!("{} motor", finger_name(finger)),
    }
}

fn is_motor(row: GripperRow) -> bool {
    Kind::from(row) == Kind::Motor
}

fn multipliers(found: &FormClosure<GripperRow>, values: &[f64]) -> Vec<MultiplierReport> {
    let report = |(&row, &value): (&GripperRow, &f64)| {
        let is_motor = is_motor(row);
        MultiplierReport {
            constraint: constraint(row),
            force_n: (!is_motor).then_some(value),
            torque_n_m: is_motor.then_some(value),
        }
    };
    found.rows.iter().zip(values).map(report).collect()
}

fn motion(found: &FormClosure<GripperRow>, values: &[f64], rates: &[f64]) -> MotionReport {
    let of = |unknown: Unknown| found.unknowns.iter().position(|&k| k == unknown).map_or(0.0, |i| values[i]);
    let motor = |finger: usize| {
        found.rows.iter().position(|&row| row == GripperRow::Hand(Row::Motor { finger })).map(|i| rates[i])
    };
    let finger = |finger: usize| FingerMotionReport {
        finger: finger_name(finger),
        qd21_rad_s: of(Unknown::Proximal { finger }),
        qd22_rad_s: of(Unknown::Distal { finger }),
        motor_rad_s: motor(finger),
    };
    let rate = |(&row, &rate): (&GripperRow, &f64)| {
        let is_motor = is_motor(row);
        RateReport {
            constraint: constraint(row),
            rate_m_s: (!is_motor).then_some(rate),
            rate_rad_s: is_motor.then_some(rate),
        }
    };
    let fingers = (0..).take_while(|&finger| found.unknowns.contains(&Unknown::Proximal { finger }));
    let mut report = MotionReport {
        words: Vec::new(),
        object_m_s: [of(Unknown::ObjectX), of(Unknown::ObjectY)],
        fingers: fingers.map(finger).collect(),
        rates: found.rows.iter().zip(rates).map(rate).collect(),
    };
    report.words = motion_words(&report);
    report
}
