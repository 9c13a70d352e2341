//! Differences from the reference, under the keys of the JSON document. The joints of a single finger have their own
//! key; those of several fingers are grouped by finger.

use std::collections::BTreeMap;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::super::named::Named;
use crate::trace::Layout;
use crate::validate::{Angle, Differences};

/// All differences of a setting from the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferencesReport {
    /// Differences of the joints of each finger; a single finger has an empty name.
    pub fingers: Named<BTreeMap<&'static str, AngleDifference>>,
    /// Differences of the bodies, sorted by name in scenes without fingers.
    pub bodies: Named<PositionDifference>,
    /// Differences of the contacts between surfaces.
    pub contacts: Named<ContactDifference>,
    pub loop_gap_m: f64,
    pub energy_created_j: f64,
    /// Relative to the work of the motors; for scenes of discs, to the largest energy of the run.
    pub energy_created: f64,
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

/// Differences of one body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PositionDifference {
    pub max_m: f64,
    pub max_at_s: f64,
    pub rms_m: f64,
    pub end_m: f64,
    pub angle_end_rad: f64,
}

/// Differences of one contact; forces and impulses are relative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactDifference {
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    /// Difference of the normal force at the end; only in scenes with fingers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_force: Option<Option<f64>>,
    /// Difference of the peak normal force; only in scenes of discs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_force: Option<Option<f64>>,
}

impl DifferencesReport {
    /// Creates the report of the differences between samples of this layout.
    pub(super) fn new(layout: &Layout, found: &Differences) -> Self {
        let has_discs_only = layout.fingers.is_empty();
        let joints = |(finger, name): (usize, &String)| {
            let first = Angle::ALL.len() * finger;
            let angles = Angle::ALL.into_iter().enumerate();
            (name.clone(), angles.map(|(k, angle)| (angle.name(), angle_difference(found, first + k))).collect())
        };
        let first_body = Angle::ALL.len() * layout.fingers.len();
        let bodies = layout.bodies.iter().enumerate();
        let surfaces = layout.surfaces().enumerate();
        let contact = |k: usize| ContactDifference {
            first_touch_s: found.contact_time_s[k],
            impulse: found.impulse[k],
            final_force: (!has_discs_only).then(|| found.final_force[k]),
            peak_force: has_discs_only.then(|| found.peak_force[k]),
        };
        let mut report = DifferencesReport {
            fingers: layout.fingers.iter().enumerate().map(joints).collect(),
            bodies: bodies
                .map(|(index, name)| (name.clone(), position_difference(found, index, first_body + index)))
                .collect(),
            contacts: surfaces.map(|(k, index)| (layout.contacts[index].name.clone(), contact(k))).collect(),
            loop_gap_m: found.loop_gap_m,
            energy_created_j: found.energy_created_j,
            energy_created: found.energy_created,
        };
        if has_discs_only {
            report.bodies.0.sort_by(|a, b| a.0.cmp(&b.0));
            report.contacts.0.sort_by(|a, b| a.0.cmp(&b.0));
        }
        report
    }
}

impl Serialize for DifferencesReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self.fingers.0.as_slice() {
            [] => {
                map.serialize_entry("discs", &self.bodies)?;
                map.serialize_entry("pairs", &self.contacts)?;
            }
            [(_, joints)] => {
                map.serialize_entry("joints", joints)?;
                for (name, contact) in self.contacts.iter() {
                    map.serialize_entry(name, contact)?;
                }
            }
            _ => {
                map.serialize_entry("fingers", &self.fingers)?;
                map.serialize_entry("object", &self.bodies.first())?;
                map.serialize_entry("contacts", &self.contacts)?;
            }
        }
        if self.fingers.first().is_some() {
            map.serialize_entry("loop_gap_m", &self.loop_gap_m)?;
        }
        map.serialize_entry("energy_created_j", &self.energy_created_j)?;
        map.serialize_entry("energy_created", &self.energy_created)?;
        map.end()
    }
}

/// Returns the difference of an angle, which has index `k` in the path.
fn angle_difference(found: &Differences, k: usize) -> AngleDifference {
    AngleDifference {
        max_rad: found.path[k].max,
        max_at_s: found.path[k].max_at_s,
        rms_rad: found.path[k].rms,
        end_rad: found.path[k].end,
        rate_rms_rad_s: found.rate_rms_rad_s[k],
    }
}

/// Returns the difference of body `index`, whose position has index `k` in the path.
fn position_difference(found: &Differences, index: usize, k: usize) -> PositionDifference {
    PositionDifference {
        max_m: found.path[k].max,
        max_at_s: found.path[k].max_at_s,
        rms_m: found.path[k].rms,
        end_m: found.path[k].end,
        angle_end_rad: found.angle_end_rad[index],
    }
}
