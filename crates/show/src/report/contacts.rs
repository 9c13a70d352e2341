//! The contacts of a run in the JSON document, by their names.

use serde::Serialize;

use super::named::Named;
use crate::criteria::Rebound;
use crate::trace::{Outcome, Schema};

/// The contacts of a run by name, such as `distal` for one finger, `right_distal` for two fingers, or `hammer-anvil`
/// for discs.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Contacts {
    pub all: Named<ContactReport>,
    #[serde(skip)]
    /// Whether names come from the scene, rather than being keys.
    has_own_names: bool,
}

/// A contact between two surfaces, or of a joint with its limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ContactReport {
    Surface(SurfaceReport),
    Limit(LimitReport),
}

/// A contact between two surfaces. For a pair of discs, the forces act on the disc named first: along the normal, which
/// points from the other disc to it, and along the tangent to the left of the normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SurfaceReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    pub final_normal_n: f64,
    pub final_tangential_n: f64,
    pub peak_normal_n: f64,
    /// Largest penetration, m; null if the surfaces passed through each other undetected.
    pub max_penetration_m: Option<f64>,
    /// Whether the surfaces passed through each other because the steps were too long for a fast body; omitted if
    /// false.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub passed_through: bool,
    pub impulse_n_s: f64,
    /// Number of transitions from stiction to slip; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub slips: u32,
    /// First impact of free discs.
    #[serde(flatten)]
    pub rebound: Option<ReboundReport>,
}

/// The first impact of two surfaces: approach speed at touch-down, separation speed at lift-off, and their ratio. All
/// are null without an impact. The ratio is also null if it does not characterise the impact
/// ([`Rebound::restitution`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ReboundReport {
    pub approach_m_s: Option<f64>,
    pub separation_m_s: Option<f64>,
    pub restitution: Option<f64>,
}

/// A joint limit: the same figures as for surfaces, for an angle and a torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LimitReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    pub final_torque_n_m: f64,
    pub peak_torque_n_m: f64,
    pub max_penetration_rad: f64,
    pub impulse_n_m_s: f64,
}

impl Contacts {
    /// Builds the report of the contacts of this schema, including rebounds if there are any.
    pub fn new(schema: &Schema, outcome: &Outcome, rebounds: &[Rebound]) -> Self {
        let report = |index: usize| {
            let (summary, last) = (&outcome.contacts[index], outcome.last.contact(index));
            if schema.contacts[index].is_angular {
                return ContactReport::Limit(LimitReport {
                    first_s: summary.first_s,
                    touchdowns: summary.touchdowns,
                    final_torque_n_m: last.normal_n,
                    peak_torque_n_m: summary.peak_normal_n,
                    max_penetration_rad: summary.max_penetration_m,
                    impulse_n_m_s: summary.impulse_n_s,
                });
            }
            let rebound = rebounds.get(index).map(|rebound| ReboundReport {
                approach_m_s: rebound.approach_m_s,
                separation_m_s: rebound.separation_m_s,
                restitution: rebound.restitution(),
            });
            ContactReport::Surface(SurfaceReport {
                first_s: summary.first_s,
                touchdowns: summary.touchdowns,
                final_normal_n: last.normal_n,
                final_tangential_n: last.tangential_n,
                peak_normal_n: summary.peak_normal_n,
                max_penetration_m: summary.depth_m(),
                passed_through: summary.passed_through(),
                impulse_n_s: summary.impulse_n_s,
                slips: summary.slips,
                rebound,
            })
        };
        let count = schema.contacts.len().min(outcome.contacts.len()).min(outcome.last.counts().contacts);
        let name = |index: usize| schema.contacts[index].name.clone();
        let all = (0..count).map(|index| (name(index), report(index))).collect();
        Contacts { all, has_own_names: schema.is_mechanism() }
    }

    /// Contacts between surfaces, each with its display name.
    pub fn surfaces(&self) -> impl Iterator<Item = (String, &SurfaceReport)> {
        self.all.iter().filter_map(|(name, contact)| match contact {
            ContactReport::Surface(surface) => Some((self.display_name(name), surface)),
            ContactReport::Limit(_) => None,
        })
    }

    /// The contacts that have touched, without those of some indices.
    pub(super) fn touched_without(&self, is_excluded: impl Fn(usize) -> bool) -> Self {
        let is_shown = |(index, (_, contact)): &(usize, &(String, ContactReport))| {
            let has_touched = match contact {
                ContactReport::Surface(surface) => surface.first_s.is_some() || surface.passed_through,
                ContactReport::Limit(limit) => limit.first_s.is_some(),
            };
            has_touched && !is_excluded(*index)
        };
        let shown = self.all.iter().enumerate().filter(is_shown).map(|(_, contact)| contact.clone()).collect();
        Contacts { all: shown, has_own_names: self.has_own_names }
    }

    /// Limits of joints, each with its display name.
    pub fn limits(&self) -> impl Iterator<Item = (String, &LimitReport)> {
        self.all.iter().filter_map(|(name, contact)| match contact {
            ContactReport::Limit(limit) => Some((self.display_name(name), limit)),
            ContactReport::Surface(_) => None,
        })
    }

    pub(super) fn display_name(&self, name: &str) -> String {
        match name {
            _ if self.has_own_names => name.to_string(),
            "limit" => "joint limit".to_string(),
            name => name.replace('_', " "),
        }
    }
}

fn is_zero(count: &u32) -> bool {
    *count == 0
}
