//! Figures of differences from the reference: keys of the JSON document and columns of text tables.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::super::named::Named;
use crate::format::numbers::format_number;
use crate::format::report::{Report, table};
use crate::trace::Schema;
use crate::validate::{Angle, Differences, largest};

/// One figure of a component.
pub(super) struct Figure {
    /// Key in the document.
    key: &'static str,
    /// Header in tables, with the displayed unit.
    pub header: &'static str,
    /// Displayed value per SI value.
    scale: f64,
    digits: usize,
    /// Value for the component with an index; the angles of fingers and the centres of bodies have the indices of
    /// [`Differences::path`].
    value: fn(&Differences, usize) -> Option<f64>,
}

const fn figure(
    (key, header): (&'static str, &'static str),
    (scale, digits): (f64, usize),
    value: fn(&Differences, usize) -> Option<f64>,
) -> Figure {
    Figure { key, header, scale, digits, value }
}

/// Figures of a joint.
const JOINT: [Figure; 5] = [
    figure(("max_rad", "max, rad"), (1.0, 3), |found, k| Some(found.path[k].max)),
    figure(("max_at_s", "at, ms"), (1e3, 5), |found, k| Some(found.path[k].max_at_s)),
    figure(("rms_rad", "RMS, rad"), (1.0, 3), |found, k| Some(found.path[k].rms)),
    figure(("end_rad", "at the end, rad"), (1.0, 3), |found, k| Some(found.path[k].end)),
    figure(("rate_rms_rad_s", "rate RMS, rad/s"), (1.0, 3), |found, k| Some(found.rate_rms_rad_s[k])),
];
/// Figures of a body.
const BODY: [Figure; 5] = [
    figure(("max_m", "max, µm"), (1e6, 3), |found, k| Some(found.path[k].max)),
    figure(("max_at_s", "at, ms"), (1e3, 5), |found, k| Some(found.path[k].max_at_s)),
    figure(("rms_m", "RMS, µm"), (1e6, 3), |found, k| Some(found.path[k].rms)),
    figure(("end_m", "at the end, µm"), (1e6, 3), |found, k| Some(found.path[k].end)),
    figure(("angle_end_rad", "angle at the end, rad"), (1.0, 3), |found, k| {
        Some(found.angle_end_rad[k - found.rate_rms_rad_s.len()])
    }),
];
/// Figures of a contact between surfaces; forces and impulses are relative.
const CONTACT: [Figure; 4] = [
    figure(("first_touch_s", "first contact, µs"), (1e6, 3), |found, k| found.contact_time_s[k]),
    figure(("impulse", "impulse, %"), (100.0, 2), |found, k| found.impulse[k]),
    figure(("final_force", "final force, %"), (100.0, 2), |found, k| found.final_force[k]),
    figure(("peak_force", "peak force, %"), (100.0, 2), |found, k| found.peak_force[k]),
];
/// Largest errors of a setting.
pub(super) const TOTAL: [Figure; 8] = [
    figure(("angle_max_rad", "angle, rad"), (1.0, 2), |found, _| Some(found.angle_max())),
    figure(("position_max_m", "position, µm"), (1e6, 2), |found, _| Some(found.centre_max())),
    figure(("first_touch_s", "touch, µs"), (1e6, 2), |found, _| largest(&found.contact_time_s)),
    figure(("impulse", "impulse, %"), (100.0, 2), |found, _| largest(&found.impulse)),
    figure(("final_force", "force, %"), (100.0, 2), |found, _| largest(&found.final_force)),
    figure(("peak_force", "peak, %"), (100.0, 2), |found, _| largest(&found.peak_force)),
    figure(("loop_gap_m", "gap, µm"), (1e6, 2), |found, _| Some(found.loop_gap_m)),
    figure(("energy_created", "energy, %"), (100.0, 2), |found, _| Some(found.energy_created)),
];

impl Figure {
    /// Whether scenes of this layout have the figure: final forces only with fingers, peak forces only without.
    fn applies_to(&self, layout: &Schema) -> bool {
        match self.key {
            "angle_max_rad" | "final_force" | "loop_gap_m" => !layout.fingers.is_empty(),
            "position_max_m" => !layout.bodies.is_empty(),
            "peak_force" => layout.fingers.is_empty(),
            _ => true,
        }
    }

    /// Formats the value; a missing value is a dash.
    pub fn cell(&self, value: Option<f64>) -> String {
        value.map_or("–".to_string(), |value| format_number(value * self.scale, self.digits))
    }
}

/// Returns the figures that scenes of this layout have, with their values; none has a value without differences.
pub(super) fn figures<'a>(
    all: &'a [Figure],
    layout: &'a Schema,
    found: Option<&'a Differences>,
    index: usize,
) -> impl Iterator<Item = (&'a Figure, Option<f64>)> {
    let figures = all.iter().filter(|figure| figure.applies_to(layout));
    figures.map(move |figure| (figure, found.and_then(|found| (figure.value)(found, index))))
}

/// The same under their keys.
pub(super) fn by_key<'a>(figures: impl Iterator<Item = (&'a Figure, Option<f64>)>) -> Named<Option<f64>> {
    figures.map(|(figure, value)| (figure.key.to_string(), value)).collect()
}

/// All differences of a setting, with the names of the components.
#[derive(Clone, Copy, Debug)]
pub(super) struct NamedDifferences<'a> {
    pub layout: &'a Schema,
    pub found: &'a Differences,
}

impl NamedDifferences<'_> {
    /// Index of the first body among the coordinates of the path.
    fn first_body(&self) -> usize {
        Angle::ALL.len() * self.layout.fingers.len()
    }

    /// Names of components with their indices, sorted by name in scenes without fingers.
    fn sorted(&self, names: impl Iterator<Item = String>, first: usize) -> Vec<(String, usize)> {
        let mut names: Vec<_> = names.zip(first..).collect();
        if self.layout.fingers.is_empty() {
            names.sort();
        }
        names
    }

    fn bodies(&self) -> Vec<(String, usize)> {
        self.sorted(self.layout.bodies.iter().cloned(), self.first_body())
    }

    fn contacts(&self) -> Vec<(String, usize)> {
        self.sorted(self.layout.surfaces().map(|index| self.layout.contacts[index].name.clone()), 0)
    }

    /// Returns the figures of named components as a document.
    fn document(&self, all: &[Figure], names: Vec<(String, usize)>) -> Named<Named<Option<f64>>> {
        let figures = |index| by_key(figures(all, self.layout, Some(self.found), index));
        names.into_iter().map(|(name, index)| (name, figures(index))).collect()
    }

    /// Returns a table for joints, bodies and contacts.
    pub(super) fn tables(&self) -> Report {
        let joints =
            self.layout.fingers.iter().flat_map(|finger| {
                Angle::ALL.map(|angle| format!("{finger} {}", angle.name()).trim_start().to_string())
            });
        let joints = joints.zip(0..).collect();
        let tables = [(&JOINT[..], joints), (&BODY, self.bodies()), (&CONTACT, self.contacts())];
        let reports = tables.into_iter().filter(|(_, names)| !names.is_empty()).map(|(all, names)| {
            let figures = |index| figures(all, self.layout, Some(self.found), index);
            let headers = figures(names[0].1).map(|(figure, _)| figure.header.to_string());
            let mut rows = vec![std::iter::once("difference".to_string()).chain(headers).collect::<Vec<_>>()];
            let occurs = |index| figures(index).any(|(_, value)| value.is_some());
            rows.extend(names.into_iter().filter(|(_, index)| occurs(*index)).map(|(name, index)| {
                std::iter::once(name).chain(figures(index).map(|(figure, value)| figure.cell(value))).collect()
            }));
            table(&rows)
        });
        Report::join(reports)
    }
}

impl Serialize for NamedDifferences<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        let joints = |finger: usize| {
            let names = Angle::ALL.iter().map(|angle| angle.name().to_string());
            self.document(&JOINT, names.zip(Angle::ALL.len() * finger..).collect())
        };
        let [bodies, contacts] = [self.document(&BODY, self.bodies()), self.document(&CONTACT, self.contacts())];
        match self.layout.fingers.as_slice() {
            [] => {
                map.serialize_entry("discs", &bodies)?;
                map.serialize_entry("pairs", &contacts)?;
            }
            [_] => {
                map.serialize_entry("joints", &joints(0))?;
                contacts.iter().try_for_each(|(name, contact)| map.serialize_entry(name, contact))?;
            }
            fingers => {
                let fingers: Named<_> = fingers.iter().cloned().zip((0..).map(joints)).collect();
                map.serialize_entry("fingers", &fingers)?;
                map.serialize_entry("object", &bodies.first())?;
                map.serialize_entry("contacts", &contacts)?;
            }
        }
        if !self.layout.fingers.is_empty() {
            map.serialize_entry("loop_gap_m", &self.found.loop_gap_m)?;
        }
        map.serialize_entry("energy_created_j", &self.found.energy_created_j)?;
        map.serialize_entry("energy_created", &self.found.energy_created)?;
        map.end()
    }
}
