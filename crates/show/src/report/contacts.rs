//! The contacts of a run, by their names, under the keys of the JSON document.

use serde::{Serialize, Serializer};

use super::named::Named;
use crate::criteria::Rebound;
use crate::trace::{ContactSample, ContactSummary, Layout, Outcome};

/// The contacts of a run: `distal`, of two fingers `right_distal`, of discs `hammer-anvil` in the order of their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Contacts {
    pub all: Named<ContactReport>,
    /// Whether there are discs alone, whose names are the scene's own.
    of_discs: bool,
}

/// What touches: two surfaces, or a joint its limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ContactReport {
    Surface(SurfaceReport),
    Limit(LimitReport),
}

/// Two surfaces. Of discs, forces are on the first one of the pair's name, along the normal from its partner to it and the tangent to
/// the left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SurfaceReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    pub final_normal_n: f64,
    pub final_tangential_n: f64,
    pub peak_normal_n: f64,
    /// Null where the surfaces passed through each other unnoticed.
    pub max_penetration_m: Option<f64>,
    /// Whether they did, in steps too long for a fast body; left out where they did not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub passed_through: bool,
    pub impulse_n_s: f64,
    /// How often friction that holds began to slip; left out where it never did.
    #[serde(skip_serializing_if = "is_none")]
    pub slips: u32,
    /// Of discs.
    #[serde(flatten)]
    pub rebound: Option<ReboundReport>,
}

/// The first impact of two surfaces: closing speed at the touch-down, parting speed at the lift-off, and their ratio. Null where there was
/// none; the ratio also where it says nothing of the impact ([`Rebound::restitution`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ReboundReport {
    pub approach_m_s: Option<f64>,
    pub separation_m_s: Option<f64>,
    pub restitution: Option<f64>,
}

/// The joint limit: the same figures for an angle and a torque.
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
    /// Of what samples of this layout came to; of discs with their rebounds, as far as they are there.
    pub fn new(layout: &Layout, outcome: &Outcome, rebounds: &[Rebound]) -> Self {
        let of_discs = layout.fingers.is_empty();
        let report = |index: usize| {
            let (summary, last) = (&outcome.contacts[index], &outcome.last.contacts[index]);
            if layout.contacts[index].angular {
                return ContactReport::Limit(LimitReport::new(summary, last));
            }
            let rebound = of_discs.then(|| rebounds.get(index).map(ReboundReport::from).unwrap_or_default());
            ContactReport::Surface(SurfaceReport { rebound, ..SurfaceReport::new(summary, last) })
        };
        // Of a gripper, only the places that it has: there may be no table.
        let there = |index: &usize| layout.fingers.len() < 2 || outcome.last.contacts[*index].gap_m.is_finite();
        let count = layout.contacts.len().min(outcome.contacts.len()).min(outcome.last.contacts.len());
        let name = |index: usize| layout.contacts[index].name.clone();
        let mut all: Named<_> = (0..count).filter(there).map(|index| (name(index), report(index))).collect();
        if of_discs {
            all.0.sort_by(|a, b| a.0.cmp(&b.0));
        }
        Contacts { all, of_discs }
    }

    /// Contacts between surfaces, called as they are told.
    pub fn surfaces(&self) -> impl Iterator<Item = (String, &SurfaceReport)> {
        self.all.iter().filter_map(|(name, of)| match of {
            ContactReport::Surface(surface) => Some((self.told(name), surface)),
            ContactReport::Limit(_) => None,
        })
    }

    /// Limits of joints, called as they are told.
    pub fn limits(&self) -> impl Iterator<Item = (String, &LimitReport)> {
        self.all.iter().filter_map(|(name, of)| match of {
            ContactReport::Limit(limit) => Some((self.told(name), limit)),
            ContactReport::Surface(_) => None,
        })
    }

    fn told(&self, name: &str) -> String {
        match name {
            _ if self.of_discs => name.to_string(),
            "limit" => "joint limit".to_string(),
            name => name.replace('_', " "),
        }
    }
}

impl Serialize for Contacts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.all.serialize(serializer)
    }
}

fn is_none(count: &u32) -> bool {
    *count == 0
}

impl SurfaceReport {
    fn new(site: &ContactSummary, last: &ContactSample) -> Self {
        SurfaceReport {
            first_s: site.first_s,
            touchdowns: site.touchdowns,
            final_normal_n: last.normal_n,
            final_tangential_n: last.tangential_n,
            peak_normal_n: site.peak_normal_n,
            max_penetration_m: site.depth_m(),
            passed_through: site.passed_through(),
            impulse_n_s: site.impulse_n_s,
            slips: site.slips,
            rebound: None,
        }
    }
}

impl LimitReport {
    fn new(limit: &ContactSummary, last: &ContactSample) -> Self {
        LimitReport {
            first_s: limit.first_s,
            touchdowns: limit.touchdowns,
            final_torque_n_m: last.normal_n,
            peak_torque_n_m: limit.peak_normal_n,
            max_penetration_rad: limit.max_penetration_m,
            impulse_n_m_s: limit.impulse_n_s,
        }
    }
}

impl From<&Rebound> for ReboundReport {
    fn from(rebound: &Rebound) -> Self {
        ReboundReport {
            approach_m_s: rebound.approach_m_s,
            separation_m_s: rebound.separation_m_s,
            restitution: rebound.restitution(),
        }
    }
}
