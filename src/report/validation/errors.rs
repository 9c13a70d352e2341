//! The worst differences of one setting: the columns of the table of settings, for text and JSON.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::differences::DifferencesReport;
use super::numbers::{number, percent};
use crate::trace::Layout;
use crate::validate::{Differences, largest};

/// The errors of a setting; all null for the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    values: Vec<(&'static Column, Option<f64>)>,
    /// All differences of a single finger. In JSON they replace all values except the first.
    differences: Option<Option<DifferencesReport>>,
}

/// A column of the error table: its key, header, unit and value.
#[derive(Debug)]
struct Column {
    key: &'static str,
    /// Column header in two lines.
    header: [&'static str; 2],
    unit: Unit,
    error: fn(&Differences) -> Option<f64>,
    /// Whether a layout has this column.
    applies_to: fn(&Layout) -> bool,
}

impl PartialEq for Column {
    fn eq(&self, other: &Self) -> bool {
        (self.key, self.header) == (other.key, other.header)
    }
}

/// Unit of a column of the text table.
#[derive(Clone, Copy, Debug)]
enum Unit {
    /// SI value times this factor.
    Scaled(f64),
    Percent,
}

const COLUMNS: [Column; 9] = [
    Column {
        key: "angle_max_rad",
        header: ["angle,", "rad"],
        unit: Unit::Scaled(1.0),
        error: |found| Some(found.angle_max()),
        applies_to: has_fingers,
    },
    Column {
        key: "position_max_m",
        header: ["object,", "µm"],
        unit: Unit::Scaled(1e6),
        error: |found| Some(found.centre_max()),
        applies_to: |layout| has_fingers(layout) && !layout.bodies.is_empty(),
    },
    Column {
        key: "position_max_m",
        header: ["position,", "µm"],
        unit: Unit::Scaled(1e6),
        error: |found| Some(found.centre_max()),
        applies_to: has_discs,
    },
    Column {
        key: "first_touch_s",
        header: ["touch,", "µs"],
        unit: Unit::Scaled(1e6),
        error: |found| largest(&found.contact_time_s),
        applies_to: |_| true,
    },
    Column {
        key: "impulse",
        header: ["impulse,", "%"],
        unit: Unit::Percent,
        error: |found| largest(&found.impulse),
        applies_to: |_| true,
    },
    Column {
        key: "final_force",
        header: ["force,", "%"],
        unit: Unit::Percent,
        error: |found| largest(&found.final_force),
        applies_to: has_fingers,
    },
    Column {
        key: "peak_force",
        header: ["peak,", "%"],
        unit: Unit::Percent,
        error: |found| largest(&found.peak_force),
        applies_to: has_discs,
    },
    Column {
        key: "loop_gap_m",
        header: ["gap,", "µm"],
        unit: Unit::Scaled(1e6),
        error: |found| Some(found.loop_gap_m),
        applies_to: has_fingers,
    },
    Column {
        key: "energy_created",
        header: ["energy,", "%"],
        unit: Unit::Percent,
        error: |found| Some(found.energy_created),
        applies_to: |_| true,
    },
];

fn has_fingers(layout: &Layout) -> bool {
    !layout.fingers.is_empty()
}

fn has_discs(layout: &Layout) -> bool {
    layout.fingers.is_empty()
}

impl Errors {
    /// Creates the errors of a setting. `found` is `None` for the reference.
    pub(super) fn new(layout: &Layout, found: Option<&Differences>) -> Self {
        let columns = COLUMNS.iter().filter(|column| (column.applies_to)(layout));
        let differences = || found.map(|found| DifferencesReport::new(layout, found));
        Errors {
            values: columns.map(|column| (column, found.and_then(column.error))).collect(),
            differences: (layout.fingers.len() == 1).then(differences),
        }
    }

    /// Returns the column headers, in two lines.
    pub(super) fn headers(&self) -> [Vec<String>; 2] {
        [0, 1].map(|line| self.values.iter().map(|(column, _)| column.header[line].to_string()).collect())
    }

    /// Returns the cells of a completed setting.
    pub(super) fn cells(&self) -> Vec<String> {
        let cell = |(column, value): &(&Column, Option<f64>)| match column.unit {
            Unit::Scaled(scale) => number(value.map(|value| value * scale), 2),
            Unit::Percent => percent(*value),
        };
        self.values.iter().map(cell).collect()
    }
}

impl Serialize for Errors {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        let first = if self.differences.is_some() { 1 } else { self.values.len() };
        for (column, value) in &self.values[..first] {
            map.serialize_entry(column.key, value)?;
        }
        if let Some(differences) = &self.differences {
            map.serialize_entry("differences", differences)?;
        }
        map.end()
    }
}
