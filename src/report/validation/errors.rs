//! The worst differences of one setting, a column each: what the table of settings has of them, in every format.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::differences::DifferencesReport;
use super::figures::{number, percent};
use crate::trace::Layout;
use crate::validate::{Differences, largest};

/// The errors of a setting; all null for the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    figures: Vec<(&'static Column, Option<f64>)>,
    /// Of a finger that is alone: where they come from, which stands in the place of all figures but the first.
    differences: Option<Option<DifferencesReport>>,
}

/// One of the errors.
#[derive(Debug)]
struct Column {
    key: &'static str,
    heads: [&'static str; 2],
    unit: Unit,
    of: fn(&Differences) -> Option<f64>,
    /// Whether samples of a layout have it.
    told: fn(&Layout) -> bool,
}

impl PartialEq for Column {
    fn eq(&self, other: &Self) -> bool {
        (self.key, self.heads) == (other.key, other.heads)
    }
}

#[derive(Clone, Copy, Debug)]
enum Unit {
    /// In SI, to be told as so many of a smaller unit.
    Of(f64),
    Percent,
}

const COLUMNS: [Column; 9] = [
    Column {
        key: "angle_max_rad",
        heads: ["angle,", "rad"],
        unit: Unit::Of(1.0),
        of: |found| Some(found.angle_max()),
        told: has_fingers,
    },
    Column {
        key: "position_max_m",
        heads: ["object,", "µm"],
        unit: Unit::Of(1e6),
        of: |found| Some(found.centre_max()),
        told: |layout| has_fingers(layout) && !layout.bodies.is_empty(),
    },
    Column {
        key: "position_max_m",
        heads: ["place,", "µm"],
        unit: Unit::Of(1e6),
        of: |found| Some(found.centre_max()),
        told: has_discs,
    },
    Column {
        key: "first_touch_s",
        heads: ["touch,", "µs"],
        unit: Unit::Of(1e6),
        of: |found| largest(&found.contact_time_s),
        told: |_| true,
    },
    Column {
        key: "impulse",
        heads: ["impulse,", "%"],
        unit: Unit::Percent,
        of: |found| largest(&found.impulse),
        told: |_| true,
    },
    Column {
        key: "final_force",
        heads: ["force,", "%"],
        unit: Unit::Percent,
        of: |found| largest(&found.final_force),
        told: has_fingers,
    },
    Column {
        key: "peak_force",
        heads: ["peak,", "%"],
        unit: Unit::Percent,
        of: |found| largest(&found.peak_force),
        told: has_discs,
    },
    Column {
        key: "loop_gap_m",
        heads: ["gap,", "µm"],
        unit: Unit::Of(1e6),
        of: |found| Some(found.loop_gap_m),
        told: has_fingers,
    },
    Column {
        key: "energy_created",
        heads: ["energy,", "%"],
        unit: Unit::Percent,
        of: |found| Some(found.energy_created),
        told: |_| true,
    },
];

fn has_fingers(layout: &Layout) -> bool {
    !layout.fingers.is_empty()
}

fn has_discs(layout: &Layout) -> bool {
    layout.fingers.is_empty()
}

impl Errors {
    /// `None` for the reference.
    pub(super) fn new(layout: &Layout, found: Option<&Differences>) -> Self {
        let told = COLUMNS.iter().filter(|column| (column.told)(layout));
        let differences = || found.map(|found| DifferencesReport::new(layout, found));
        Errors {
            figures: told.map(|column| (column, found.and_then(column.of))).collect(),
            differences: (layout.fingers.len() == 1).then(differences),
        }
    }

    /// Heads of the columns, in two lines.
    pub(super) fn heads(&self) -> [Vec<String>; 2] {
        [0, 1].map(|line| self.figures.iter().map(|(column, _)| column.heads[line].to_string()).collect())
    }

    /// The cells of a setting that was completed.
    pub(super) fn cells(&self) -> Vec<String> {
        let cell = |(column, value): &(&Column, Option<f64>)| match column.unit {
            Unit::Of(scale) => number(value.map(|value| value * scale), 2),
            Unit::Percent => percent(*value),
        };
        self.figures.iter().map(cell).collect()
    }
}

impl Serialize for Errors {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        let first = if self.differences.is_some() { 1 } else { self.figures.len() };
        for (column, value) in &self.figures[..first] {
            map.serialize_entry(column.key, value)?;
        }
        if let Some(differences) = &self.differences {
            map.serialize_entry("differences", differences)?;
        }
        map.end()
    }
}
