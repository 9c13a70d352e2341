//! Points of volumes by grasp state (thesis Tables 3.3–3.5), and their display state for one quantity.
//!
//! Fractions refer to all points of the volume, including points without a finger. Palm force positiveness and form
//! closure are counted in the stable region, as in the tables of the thesis.

use std::cmp::Reverse;

use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::Volume;
use super::point::{GraspState, Quantity};

/// Maximum number of reported reasons for missing fingers per volume.
const MAX_REASONS: usize = 3;

/// Numbers of points by grasp state. They are serialised as percentages of all points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub points: usize,
    /// Number of points with a finger.
    pub fingers: usize,
    /// Number of stable points: F21 ≥ 0 and F22 ≥ 0.
    pub stable: usize,
    /// Number of stable points with PFP ≥ 0.
    pub palm_positive: usize,
    /// Number of stable, form-closed points.
    pub form_closed: usize,
    /// Number of form-closed points, stable or not.
    pub form_closed_total: usize,
}

impl Counts {
    /// Counts the points that are in a state in all volumes, which have the same axes.
    pub fn new(volumes: &[&Volume]) -> Self {
        let points = volumes.first().map_or(0, |volume| volume.points.len());
        let mut counts = Counts { points, ..Counts::default() };
        for index in 0..points {
            let Some(states) = states(volumes, index) else { continue };
            let all = |test: fn(&GraspState) -> bool| usize::from(states.iter().all(|state| test(state)));
            counts.fingers += 1;
            counts.stable += all(GraspState::is_stable);
            counts.palm_positive += all(GraspState::is_palm_positive);
            counts.form_closed += all(GraspState::is_form_closed);
            counts.form_closed_total += all(|state| state.sized.form_closed);
        }
        counts
    }

    /// Returns a count as a percentage of all points.
    pub fn percent(&self, count: usize) -> f64 {
        100.0 * count as f64 / self.points.max(1) as f64
    }
}

impl Serialize for Counts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Counts", 6)?;
        fields.serialize_field("points", &self.points)?;
        fields.serialize_field("fingers", &self.fingers)?;
        fields.serialize_field("stable_percent", &self.percent(self.stable))?;
        fields.serialize_field("palm_positive_percent", &self.percent(self.palm_positive))?;
        fields.serialize_field("form_closed_percent", &self.percent(self.form_closed))?;
        fields.serialize_field("form_closed_anyway_percent", &self.percent(self.form_closed_total))?;
        fields.end()
    }
}

/// Counts of one volume.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct VolumeCounts {
    pub base_m: f64,
    pub mu_static: f64,
    #[serde(flatten)]
    pub counts: Counts,
    /// The largest palm force of the stable region; `None` if no point is stable.
    pub largest_palm_force: Option<LargestPalmForce>,
    /// The most frequent reasons for missing fingers.
    #[serde(rename = "no_finger")]
    pub missing_fingers: Vec<MissingFingers>,
}

/// The largest palm force and its design.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LargestPalmForce {
    pub static_pfp_n: f64,
    pub l21_fraction: f64,
    pub phi22_rad: f64,
    pub arm_ratio: f64,
}

/// A reason for missing fingers, with the message of the first such point.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct MissingFingers {
    pub points: usize,
    pub reason: String,
}

/// Counts of the points that are in a state at every base.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Intersection {
    pub mu_static: f64,
    #[serde(flatten)]
    pub counts: Counts,
}

/// Returns the states of a point in all volumes; `None` if a finger does not exist.
fn states<'a>(volumes: &[&'a Volume], index: usize) -> Option<Vec<&'a GraspState>> {
    volumes.iter().map(|volume| volume.points[index].as_ref().ok()).collect()
}

/// Counts the points of a volume.
pub fn count_volume(volume: &Volume) -> VolumeCounts {
    let stable = volume.points.iter().enumerate().filter_map(|(index, point)| {
        let state = point.as_ref().ok().filter(|state| state.is_stable())?;
        Some((index, state.forces.pfp_n))
    });
    // The first of equal points, so that the result is unique.
    let best = stable.reduce(|best, next| if next.1 > best.1 { next } else { best });
    VolumeCounts {
        base_m: volume.base_m,
        mu_static: volume.mu_static,
        counts: Counts::new(&[volume]),
        largest_palm_force: best.map(|(index, static_pfp_n)| {
            let [l21_fraction, phi22_rad, arm_ratio] = volume.axes.at(index);
            LargestPalmForce { static_pfp_n, l21_fraction, phi22_rad, arm_ratio }
        }),
        missing_fingers: missing_fingers(volume),
    }
}

/// Returns the most frequent reasons for missing fingers. Messages that differ in numbers only count as the same
/// reason.
fn missing_fingers(volume: &Volume) -> Vec<MissingFingers> {
    let mut by_kind: Vec<(String, MissingFingers)> = Vec::new();
    for error in volume.points.iter().filter_map(|point| point.as_ref().err()) {
        let reason = error.to_string();
        let kind = reason.replace(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-'), "");
        match by_kind.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, missing)) => missing.points += 1,
            None => by_kind.push((kind, MissingFingers { points: 1, reason })),
        }
    }
    let mut reasons: Vec<MissingFingers> = by_kind.into_iter().map(|(_, missing)| missing).collect();
    reasons.sort_by_key(|missing| Reverse(missing.points));
    reasons.truncate(MAX_REASONS);
    reasons
}

/// Returns the volumes of all bases for each friction coefficient, in the order of the volumes.
pub fn by_friction(volumes: &[Volume]) -> Vec<Vec<&Volume>> {
    let mut groups: Vec<Vec<&Volume>> = Vec::new();
    for volume in volumes {
        match groups.iter_mut().find(|group| group[0].mu_static == volume.mu_static) {
            Some(group) => group.push(volume),
            None => groups.push(vec![volume]),
        }
    }
    groups
}

/// Returns the intersection over the bases for each friction coefficient, in their order.
pub fn intersections(volumes: &[Volume]) -> Vec<Intersection> {
    let intersection =
        |bases: &Vec<&Volume>| Intersection { mu_static: bases[0].mu_static, counts: Counts::new(bases) };
    by_friction(volumes).iter().map(intersection).collect()
}

/// Display state of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// No finger exists, at least at one base.
    NoFinger,
    /// A contact force would have to be tensile.
    Unstable,
    /// The value of the quantity in SI units.
    Stable(f64),
}

impl Cell {
    pub fn value(self) -> Option<f64> {
        if let Cell::Stable(value) = self { Some(value) } else { None }
    }
}

/// Returns the cells of a volume, or of the intersection of volumes that differ only in their base: stable where all
/// are, with the worst value.
pub fn cells(volumes: &[&Volume], quantity: Quantity) -> Vec<Cell> {
    let worst = if quantity.is_largest_worst() { f64::max } else { f64::min };
    let cell = |index: usize| {
        let Some(states) = states(volumes, index) else { return Cell::NoFinger };
        match states.iter().map(|state| quantity.value(state)).reduce(worst) {
            Some(value) if states.iter().all(|state| state.is_stable()) => Cell::Stable(value),
            _ => Cell::Unstable,
        }
    };
    (0..volumes.first().map_or(0, |volume| volume.points.len())).map(cell).collect()
}
