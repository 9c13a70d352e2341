//! The contacts of a run, under the keys of the JSON document.

use std::collections::BTreeMap;

use serde::Serialize;

use super::named::Named;
use crate::criteria::Rebound;
use crate::trace::{ContactSample, ContactSummary, Layout, Outcome, Place, Site};

/// Of a finger, or of bodies by the names of their pairs, such as `hammer-anvil` or `hammer-plane`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Contacts {
    Finger(FingerContacts),
    Pairs(BTreeMap<String, PairReport>),
    Gripper(Named<PlaceReport>),
}

/// A contact of a gripper, by its name, such as `right_distal` or `palm`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PlaceReport {
    Surface(PhalanxReport),
    Limit(LimitReport),
}

/// The three places where a finger can touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FingerContacts {
    pub proximal: PhalanxReport,
    pub distal: PhalanxReport,
    pub limit: LimitReport,
}

/// One phalanx against the object, or two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhalanxReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    pub final_normal_n: f64,
    pub final_tangential_n: f64,
    pub peak_normal_n: f64,
    pub max_penetration_m: f64,
    pub impulse_n_s: f64,
    /// How often friction that holds began to slip; left out where it never did.
    #[serde(skip_serializing_if = "is_none")]
    pub slips: u32,
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

/// A pair of surfaces: the keys of a finger's contact, and its first impact. Forces are on the first disc of the pair's name, along
/// the normal from its partner to it and the tangent to the left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairReport {
    #[serde(flatten)]
    pub surface: PhalanxReport,
    /// Of the first impact: closing speed at the touch-down, parting speed at the lift-off, and their ratio; null where
    /// there was none.
    pub approach_m_s: Option<f64>,
    pub separation_m_s: Option<f64>,
    pub restitution: Option<f64>,
}

impl Contacts {
    /// Of what samples of this layout came to; without rebounds these are left out.
    pub fn new(layout: &Layout, outcome: &Outcome, rebounds: &[Rebound]) -> Self {
        match layout.fingers.len() {
            0 => Contacts::Pairs(pairs(layout, outcome, rebounds)),
            1 => Contacts::Finger(FingerContacts::from(outcome)),
            _ => Contacts::Gripper(places(layout, outcome)),
        }
    }
}

/// Pairs by name, in order.
pub fn pairs(layout: &Layout, outcome: &Outcome, rebounds: &[Rebound]) -> BTreeMap<String, PairReport> {
    let pairs = layout.contacts.iter().zip(&outcome.contacts).zip(&outcome.last.contacts).enumerate();
    pairs
        .map(|(index, ((place, summary), last))| {
            let rebound = rebounds.get(index).copied().unwrap_or_default();
            (place.name.clone(), PairReport::new((summary, last), &rebound))
        })
        .collect()
}

/// All places of a gripper that it has.
fn places(layout: &Layout, outcome: &Outcome) -> Named<PlaceReport> {
    let places = layout.contacts.iter().zip(outcome.contacts.iter().zip(&outcome.last.contacts));
    let there = places.filter(|(_, (_, last))| last.gap_m.is_finite());
    let report = |(place, of): (&Place, (&ContactSummary, &ContactSample))| {
        let report = match place.angular {
            true => PlaceReport::Limit(LimitReport::new(of)),
            false => PlaceReport::Surface(PhalanxReport::new(of)),
        };
        (place.name.clone(), report)
    };
    there.map(report).collect()
}

impl From<&Outcome> for FingerContacts {
    fn from(outcome: &Outcome) -> Self {
        let of = |site: Site| (outcome.site(site), outcome.last.contact(site));
        FingerContacts {
            proximal: PhalanxReport::new(of(Site::Proximal)),
            distal: PhalanxReport::new(of(Site::Distal)),
            limit: LimitReport::new(of(Site::Limit)),
        }
    }
}

fn is_none(count: &u32) -> bool {
    *count == 0
}

impl PhalanxReport {
    fn new((site, last): (&ContactSummary, &ContactSample)) -> Self {
        PhalanxReport {
            first_s: site.first_s,
            touchdowns: site.touchdowns,
            final_normal_n: last.normal_n,
            final_tangential_n: last.tangential_n,
            peak_normal_n: site.peak_normal_n,
            max_penetration_m: site.max_penetration_m,
            impulse_n_s: site.impulse_n_s,
            slips: site.slips,
        }
    }
}

impl LimitReport {
    fn new((limit, last): (&ContactSummary, &ContactSample)) -> Self {
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

impl PairReport {
    fn new(of: (&ContactSummary, &ContactSample), rebound: &Rebound) -> Self {
        PairReport {
            surface: PhalanxReport::new(of),
            approach_m_s: rebound.approach_m_s,
            separation_m_s: rebound.separation_m_s,
            restitution: rebound.restitution(),
        }
    }
}
