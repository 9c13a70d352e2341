//! History of each pair, and its forces at the end.

use super::pose::RelativePose;
use crate::mechanism::ContactPair;
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, dot, perp, rotate, scale, sub};
use crate::statics::{FrictionContact, GraspPair};
use crate::trace::{BodyState, ContactSample, Sample};
use serde::Serialize;

/// A point of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairPoint {
    /// Index among the contacts of a sample.
    pub contact: usize,
    /// Sign of the normal of a sample for the direction into the object, and of its force for that on the object.
    sign: f64,
    pub mu: f64,
}

impl PairPoint {
    pub fn new(object: usize, contact: usize, pair: &ContactPair) -> Self {
        let reported = if pair.is_reported_on_face { pair.face } else { pair.points };
        let sign = if reported.body == Some(object) { 1.0 } else { -1.0 };
        PairPoint { contact, sign, mu: pair.law.friction.map_or(0.0, |friction| friction.mu_static) }
    }

    /// Unit normal into the object.
    pub fn push(&self, contact: &ContactSample) -> [f64; 2] {
        scale(contact.normal, self.sign)
    }

    pub fn friction_contact(&self, contact: &ContactSample) -> FrictionContact {
        FrictionContact { point_m: contact.point_m, push: self.push(contact), mu: self.mu }
    }
}

/// History of one pair up to the present. A loss that is shorter than the threshold is none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairHistory {
    pub first_s: Option<f64>,
    /// Start of the current active interval, and the pose of the object at this time.
    pub active_since: Option<(f64, RelativePose)>,
    was_active: bool,
    inactive_since_s: Option<f64>,
    pub times_lost: u32,
    pub lost_s: f64,
}

impl PairHistory {
    /// Adds the part of the run from `from_s` to `to_s`; `pose` is the pose of the object at `from_s`.
    pub fn add(
        &mut self,
        (has_touched, is_active): (bool, bool),
        [from_s, to_s]: [f64; 2],
        pose: RelativePose,
        loss_time_s: f64,
    ) {
        if has_touched {
            self.first_s.get_or_insert(from_s);
        }
        if is_active {
            (self.was_active, self.inactive_since_s) = (true, None);
            self.active_since.get_or_insert((from_s, pose));
        } else if self.was_active {
            let inactive_since_s = *self.inactive_since_s.get_or_insert(from_s);
            match self.active_since {
                Some(_) if to_s - inactive_since_s < loss_time_s => {}
                Some(_) => {
                    self.active_since = None;
                    self.times_lost += 1;
                    self.lost_s += to_s - inactive_since_s;
                }
                None => self.lost_s += to_s - from_s,
            }
        }
    }
}

/// A pair at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairCriteria {
    #[serde(skip)]
    pub name: String,
    /// Whether the other body belongs to the hand; otherwise it belongs to the surroundings.
    #[serde(rename = "role", serialize_with = "role")]
    pub is_hand: bool,
    /// Time of the first touch of any point of the pair, s; `None` without one.
    #[serde(rename = "first_touch_s")]
    pub first_s: Option<f64>,
    /// Start of the active interval that lasts to the end, s; `None` if the pair is not active at the end.
    #[serde(rename = "presses_since_s")]
    pub active_since_s: Option<f64>,
    /// Number of losses after the pair was first active.
    pub times_lost: u32,
    /// Total duration of these losses, s.
    pub lost_s: f64,
    /// Smallest gap of the points of the pair at the end, m; `None` if no point is near the object.
    pub gap_m: Option<f64>,
    /// Sum of the normal forces, N.
    pub normal_n: f64,
    /// Component of the force on the object perpendicular to the sum of the normal forces, N; positive to the left of
    /// this sum, which points into the object.
    pub friction_n: f64,
    /// Σ |F_t| / Σ μ_s F_n over the points of the pair; `None` without friction or without a force.
    pub friction_used: Option<f64>,
    /// Centre of pressure in the frame of the object, m; `None` without a force.
    pub pressure_centre_m: Option<[f64; 2]>,
    /// Indices of the points of the pair among the contacts of a sample.
    #[serde(skip)]
    pub points: Vec<usize>,
    /// Whether the pair slides faster than the speed that counts as slow, over the last `held_time`.
    #[serde(rename = "slips")]
    pub is_sliding: bool,
}

fn role<S: serde::Serializer>(is_hand: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *is_hand { "hand" } else { "surroundings" })
}

/// Returns a pair in a sample.
pub(super) fn pair_at_end(
    (pair, history): (&GraspPair, &PairHistory),
    points: &[PairPoint],
    (sample, object): (&Sample, &BodyState),
    is_sliding: bool,
) -> PairCriteria {
    let contacts: Vec<(&PairPoint, ContactSample)> =
        points.iter().map(|point| (point, sample.contact(point.contact))).collect();
    let sum = |of: &dyn Fn(&PairPoint, &ContactSample) -> f64| -> f64 {
        contacts.iter().map(|(point, contact)| of(point, contact)).sum()
    };
    let normal_n = sum(&|_, contact| contact.normal_n);
    let (mut normals, mut force) = ([0.0; 2], [0.0; 2]);
    let mut pressure = [0.0; 2];
    for (point, contact) in &contacts {
        normals = add(normals, scale(point.push(contact), contact.normal_n));
        force = add(force, scale(contact.force_n(), point.sign));
        pressure = add(pressure, scale(contact.point_m, contact.normal_n));
    }
    let length = hypot(normals[0], normals[1]);
    let friction_n = if length > 0.0 { dot(force, perp(scale(normals, 1.0 / length))) } else { 0.0 };
    let limit_n = sum(&|point, contact| point.mu * contact.normal_n);
    let (sin, cos) = sin_cos(object.angle_rad);
    let centre = |pressure: [f64; 2]| rotate(sub(scale(pressure, 1.0 / normal_n), object.centre_m), [cos, -sin]);
    let gap_m = contacts.iter().map(|(_, contact)| contact.gap_m).fold(f64::INFINITY, f64::min);
    PairCriteria {
        name: pair.name.clone(),
        is_hand: pair.is_hand,
        first_s: history.first_s,
        active_since_s: history.active_since.map(|(since_s, _)| since_s),
        times_lost: history.times_lost,
        lost_s: history.lost_s,
        gap_m: gap_m.is_finite().then_some(gap_m),
        normal_n,
        friction_n,
        friction_used: (limit_n > 0.0).then(|| sum(&|_, contact| contact.tangential_n.abs()) / limit_n),
        pressure_centre_m: (normal_n > 0.0).then(|| centre(pressure)),
        points: pair.points.clone(),
        is_sliding,
    }
}
