//! Differences from the reference, under the keys of the JSON document.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::named::Named;
use crate::trace::Layout;
use crate::validate::{Angle, Differences, largest};

/// Everything in which the engine differs from the reference, by the kind of scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum DifferencesReport {
    Finger(JointDifferences),
    Discs(DiscDifferences),
    Gripper(GripperDifferences),
}

/// What the table of settings has of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Errors {
    Finger(JointErrors),
    Discs(DiscErrors),
    Gripper(GripperErrors),
}

/// Differences of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AngleDifference {
    pub max_rad: f64,
    pub max_at_s: f64,
    pub rms_rad: f64,
    pub end_rad: f64,
    pub rate_rms_rad_s: f64,
}

/// Differences of the contact of one phalanx; the forces and impulses are relative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactDifference {
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub final_force: Option<f64>,
}

/// Everything in which a setting of a finger differs from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointDifferences {
    pub joints: BTreeMap<&'static str, AngleDifference>,
    pub proximal: ContactDifference,
    pub distal: ContactDifference,
    pub loop_gap_m: f64,
    pub energy_created_j: f64,
    /// Relative to the work of the motor.
    pub energy_created: f64,
}

/// Differences of a finger; null for the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointErrors {
    pub angle_max_rad: Option<f64>,
    pub differences: Option<JointDifferences>,
}

/// Differences of one disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiscDifference {
    pub max_m: f64,
    pub max_at_s: f64,
    pub rms_m: f64,
    pub end_m: f64,
    pub angle_end_rad: f64,
}

/// Differences of one pair; impulse and peak force are relative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairDifference {
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub peak_force: Option<f64>,
}

/// Everything in which the engine differs from the reference in a scene of discs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiscDifferences {
    pub discs: BTreeMap<String, DiscDifference>,
    pub pairs: BTreeMap<String, PairDifference>,
    pub energy_created_j: f64,
    /// Relative to the largest energy of the run.
    pub energy_created: f64,
}

/// Worst differences of a setting over all discs and pairs; null for the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiscErrors {
    pub position_max_m: Option<f64>,
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub peak_force: Option<f64>,
    pub energy_created: Option<f64>,
}

/// Everything in which a gripper differs from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GripperDifferences {
    pub fingers: Named<BTreeMap<&'static str, AngleDifference>>,
    pub object: DiscDifference,
    pub contacts: Named<ContactDifference>,
    pub loop_gap_m: f64,
    pub energy_created_j: f64,
    /// Relative to the work of the motors.
    pub energy_created: f64,
}

/// Worst differences of a setting of a gripper; null for the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GripperErrors {
    pub angle_max_rad: Option<f64>,
    pub position_max_m: Option<f64>,
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub final_force: Option<f64>,
    pub loop_gap_m: Option<f64>,
    pub energy_created: Option<f64>,
}

impl DifferencesReport {
    /// Of samples of this layout.
    pub(super) fn new(layout: &Layout, found: &Differences) -> Self {
        match layout.fingers.len() {
            0 => DifferencesReport::Discs(DiscDifferences::new(layout, found)),
            1 => DifferencesReport::Finger(JointDifferences::from(found)),
            _ => DifferencesReport::Gripper(GripperDifferences::new(layout, found)),
        }
    }
}

impl Errors {
    /// `None` for the reference.
    pub(super) fn new(layout: &Layout, found: Option<&Differences>) -> Self {
        match layout.fingers.len() {
            1 => Errors::Finger(JointErrors {
                angle_max_rad: found.map(Differences::path_max),
                differences: found.map(JointDifferences::from),
            }),
            2.. => Errors::Gripper(GripperErrors {
                angle_max_rad: found.map(Differences::angle_max),
                position_max_m: found.map(Differences::centre_max),
                first_touch_s: found.and_then(|found| largest(&found.contact_time_s)),
                impulse: found.and_then(|found| largest(&found.impulse)),
                final_force: found.and_then(|found| largest(&found.final_force)),
                loop_gap_m: found.map(|found| found.loop_gap_m),
                energy_created: found.map(|found| found.energy_created),
            }),
            0 => Errors::Discs(DiscErrors {
                position_max_m: found.map(Differences::path_max),
                first_touch_s: found.and_then(|found| largest(&found.contact_time_s)),
                impulse: found.and_then(|found| largest(&found.impulse)),
                peak_force: found.and_then(|found| largest(&found.peak_force)),
                energy_created: found.map(|found| found.energy_created),
            }),
        }
    }
}

fn angle(found: &Differences, k: usize) -> AngleDifference {
    AngleDifference {
        max_rad: found.path[k].max,
        max_at_s: found.path[k].max_at_s,
        rms_rad: found.path[k].rms,
        end_rad: found.path[k].end,
        rate_rms_rad_s: found.rate_rms_rad_s[k],
    }
}

fn contact(found: &Differences, k: usize) -> ContactDifference {
    ContactDifference {
        first_touch_s: found.contact_time_s[k],
        impulse: found.impulse[k],
        final_force: found.final_force[k],
    }
}

/// The body `index`, the place of which is number `k` of the path.
fn disc(found: &Differences, index: usize, k: usize) -> DiscDifference {
    DiscDifference {
        max_m: found.path[k].max,
        max_at_s: found.path[k].max_at_s,
        rms_m: found.path[k].rms,
        end_m: found.path[k].end,
        angle_end_rad: found.angle_end_rad[index],
    }
}

impl From<&Differences> for JointDifferences {
    fn from(found: &Differences) -> Self {
        let joints = Angle::ALL.into_iter().enumerate();
        JointDifferences {
            joints: joints.map(|(k, of)| (of.name(), angle(found, k))).collect(),
            proximal: contact(found, 0),
            distal: contact(found, 1),
            loop_gap_m: found.loop_gap_m,
            energy_created_j: found.energy_created_j,
            energy_created: found.energy_created,
        }
    }
}

impl GripperDifferences {
    fn new(layout: &Layout, found: &Differences) -> Self {
        let angles = Angle::ALL.len();
        let joints = |finger: usize| {
            let of = Angle::ALL.into_iter().enumerate();
            of.map(|(k, of)| (of.name(), angle(found, angles * finger + k))).collect()
        };
        let fingers = layout.fingers.iter().enumerate().map(|(index, name)| (name.clone(), joints(index)));
        let surfaces = layout.surfaces().enumerate().map(|(k, index)| (layout.contacts[index].name.clone(), k));
        GripperDifferences {
            fingers: fingers.collect(),
            object: disc(found, 0, angles * layout.fingers.len()),
            contacts: surfaces.map(|(name, k)| (name, contact(found, k))).collect(),
            loop_gap_m: found.loop_gap_m,
            energy_created_j: found.energy_created_j,
            energy_created: found.energy_created,
        }
    }
}

impl DiscDifferences {
    fn new(layout: &Layout, found: &Differences) -> Self {
        let pair = |k: usize| PairDifference {
            first_touch_s: found.contact_time_s[k],
            impulse: found.impulse[k],
            peak_force: found.peak_force[k],
        };
        DiscDifferences {
            discs: layout.bodies.iter().enumerate().map(|(k, name)| (name.clone(), disc(found, k, k))).collect(),
            pairs: layout.contacts.iter().enumerate().map(|(k, place)| (place.name.clone(), pair(k))).collect(),
            energy_created_j: found.energy_created_j,
            energy_created: found.energy_created,
        }
    }
}
