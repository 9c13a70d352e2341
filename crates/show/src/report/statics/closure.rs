//! Form closure in the JSON document, with a certificate by the names of its constraints.

use serde::Serialize;

use super::motion::{FingerMotionReport, MotionReport, RateReport};
use super::motion_text::{motion_sentences, palm_state};
use crate::grasp::finger::Palm;
use crate::gripper::FingerContact;
use crate::statics::{Certificate, Decision, FormClosure, Row, RowKind, Unknown};

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosureReport {
    pub closed: bool,
    /// Whether the object rests on the palm: "rests", "within", "apart" or "none".
    pub palm: &'static str,
    /// Distance of the object above the palm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub palm_gap_m: Option<f64>,
    pub necessary: NecessaryReport,
    pub rank: usize,
    pub unknowns: usize,
    /// Ratio of the smallest to the largest multiplier of scaled constraints, if the multipliers are unique.
    pub margin: Option<f64>,
    /// "rank", "signs" or "programme".
    pub decision: &'static str,
    /// If closed: forces and torques in equilibrium, all positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multipliers: Option<Vec<MultiplierReport>>,
    /// If not closed: a motion that violates no constraint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionReport>,
    /// Residual of the certificate, relative to its terms.
    pub residual: f64,
}

/// (1.19): contacts + motors ≥ hand + object + 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NecessaryReport {
    pub contacts: usize,
    pub motors: usize,
    pub hand: usize,
    pub object: usize,
    #[serde(rename = "met")]
    pub is_met: bool,
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
    pub fn new(found: &FormClosure, palm_contact: &Palm) -> Self {
        let count = found.necessary;
        let (multipliers, motion, residual) = match &found.certificate {
            Certificate::Multipliers { values, residual } => (Some(multipliers(found, values)), None, *residual),
            Certificate::Motion { values, rates, residual } => (None, Some(motion(found, values, rates)), *residual),
        };
        Self {
            closed: found.closed,
            palm: palm_state(palm_contact),
            palm_gap_m: match palm_contact {
                Palm::Separated { gap_m } => Some(*gap_m),
                Palm::Penetrating { depth_m } => Some(-depth_m),
                Palm::Resting | Palm::None => None,
            },
            necessary: NecessaryReport {
                contacts: count.contacts,
                motors: count.motors,
                hand: count.hand,
                object: count.object,
                is_met: count.is_met(),
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

/// "right", "left", or a number for further fingers.
pub(super) fn finger_name(finger: usize) -> String {
    match finger {
        0 => "right".to_string(),
        1 => "left".to_string(),
        index => format!("finger {}", index + 1),
    }
}

fn constraint(row: Row) -> String {
    match row {
        Row::Contact { finger, site: FingerContact::Proximal } => format!("{} proximal phalanx", finger_name(finger)),
        Row::Contact { finger, .. } => format!("{} tip", finger_name(finger)),
        Row::Palm => "palm".to_string(),
        Row::Motor { finger } => format!("{} motor", finger_name(finger)),
        Row::Input => "input".to_string(),
    }
}

fn is_motor(row: Row) -> bool {
    RowKind::from(row) == RowKind::Motor
}

fn multipliers(found: &FormClosure, values: &[f64]) -> Vec<MultiplierReport> {
    let report = |(&row, &value): (&Row, &f64)| {
        let is_motor = is_motor(row);
        MultiplierReport {
            constraint: constraint(row),
            force_n: (!is_motor).then_some(value),
            torque_n_m: is_motor.then_some(value),
        }
    };
    found.rows.iter().zip(values).map(report).collect()
}

fn motion(found: &FormClosure, values: &[f64], rates: &[f64]) -> MotionReport {
    let value_of = |unknown: Unknown| found.unknowns.iter().position(|&k| k == unknown).map_or(0.0, |i| values[i]);
    let motor = |finger: usize| found.rows.iter().position(|&row| row == Row::Motor { finger }).map(|i| rates[i]);
    let finger = |finger: usize| FingerMotionReport {
        finger: finger_name(finger),
        qd21_rad_s: value_of(Unknown::Proximal { finger }),
        qd22_rad_s: value_of(Unknown::Distal { finger }),
        motor_rad_s: motor(finger),
    };
    let rate = |(&row, &rate): (&Row, &f64)| {
        let is_motor = is_motor(row);
        RateReport {
            constraint: constraint(row),
            rate_m_s: (!is_motor).then_some(rate),
            rate_rad_s: is_motor.then_some(rate),
        }
    };
    let fingers = (0..).take_while(|&finger| found.unknowns.contains(&Unknown::Proximal { finger }));
    let mut report = MotionReport {
        sentences: Vec::new(),
        object_m_s: [value_of(Unknown::ObjectX), value_of(Unknown::ObjectY)],
        fingers: fingers.map(finger).collect(),
        rates: found.rows.iter().zip(rates).map(rate).collect(),
    };
    report.sentences = motion_sentences(&report);
    report
}
