//! A motion that violates no constraint, in the JSON document.

use serde::Serialize;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionReport {
    #[serde(rename = "words")]
    pub sentences: Vec<String>,
    pub object_m_s: [f64; 2],
    pub fingers: Vec<FingerMotionReport>,
    /// Opening rate of each constraint.
    pub rates: Vec<RateReport>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FingerMotionReport {
    pub finger: String,
    pub qd21_rad_s: f64,
    pub qd22_rad_s: f64,
    pub motor_rad_s: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RateReport {
    pub constraint: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_m_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_rad_s: Option<f64>,
}
