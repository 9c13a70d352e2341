//! Report of captured offsets: a table along one axis, a map along two.

use serde_json::json;

use super::rows_csv;
use super::tables::milliseconds;
use crate::format::numbers::{format_number, or_dash, row};
use crate::format::report::{Report, Table, ToReport};
use crate::format::{axis_unit, in_axis_unit};
use crate::scene::{Axis, one_line};
use crate::study::hold::axis_name;
use crate::study::offsets::{OffsetEdge, OffsetPlacement, Offsets};

impl ToReport for Offsets {
    fn report(&self) -> Report {
        let range = |(axis, largest): &(Axis, f64)| format!("{} ±{}", axis_name(*axis), size(*axis, *largest));
        let ranges: Vec<String> = self.plan.axes.iter().map(range).collect();
        let mut text = Report::from(format!(
            "{}: {} model, offsets of `{}` in the frame of `{}`: {}\n\n",
            one_line(&self.scene),
            self.plan.model.name(),
            self.object,
            self.base,
            ranges.join(", ")
        ));
        match self.plan.axes[..] {
            [(axis, _)] => {
                text.push(table(self, axis));
                text.push(Report::paragraph(&format!("\n{}\n", captured_range(self, axis))));
            }
            _ => text.push(map(self)),
        }
        let captured = self.placements.iter().filter(|placement| placement.is_captured()).count();
        text.push(Report::paragraph(&format!("\n{captured} of {} offsets are captured.\n", self.placements.len())));
        for placement in &self.placements {
            if let Some(reason) = &placement.reason {
                text.push(Report::paragraph(&format!("at {}: {reason}\n", offset(self, placement))));
            }
        }
        text
    }
}

/// A length in mm or an angle in degrees, with its unit.
fn size(axis: Axis, value: f64) -> String {
    format!("{} {}", format_number(in_axis_unit(axis, value), 4), axis_unit(axis))
}

/// The offsets of a placement along the axes of the study.
fn offset(study: &Offsets, placement: &OffsetPlacement) -> String {
    let along =
        |(axis, _): &(Axis, f64)| format!("{} {}", axis_name(*axis), size(*axis, placement.offset[*axis as usize]));
    study.plan.axes.iter().map(along).collect::<Vec<_>>().join(", ")
}

fn table(study: &Offsets, axis: Axis) -> Table {
    let head = format!("{}, {}", axis_name(axis), axis_unit(axis));
    let mut rows = vec![row([&head, "fate", "end x, mm", "y, mm", "angle, deg", "tts, ms", "slip, mm"])];
    for placement in &study.placements {
        let end = |of: Axis| {
            or_dash(placement.end.map(|end| in_axis_unit(of, end[of as usize])), |value| format_number(value, 4))
        };
        rows.push(row([
            &format_number(in_axis_unit(axis, placement.offset[axis as usize]), 4),
            placement.fate.unwrap_or("not run"),
            &end(Axis::X),
            &end(Axis::Y),
            &end(Axis::Angle),
            &milliseconds(placement.tts_s),
            &or_dash(placement.slip.map(|slip| slip.displacement_m * 1e3), |slip| format_number(slip, 4)),
        ]));
    }
    Table::new(&rows)
}

fn captured_range(study: &Offsets, axis: Axis) -> String {
    let Some(edges) = study.captured_range else {
        return "Captured: no range; the object is not held where the scene places it.".to_string();
    };
    let [from, to] = edges.map(|OffsetEdge { captured, lost }| match lost {
        Some(lost) => format!("{} (not at {})", size(axis, captured), size(axis, lost)),
        None => format!("{} (the requested limit)", size(axis, captured)),
    });
    format!("Captured: from {from} to {to}.")
}

/// Rows from the largest offset of the second axis down to the smallest, columns by the first axis.
fn map(study: &Offsets) -> Table {
    let [(across, _), (up, _)] = study.plan.axes[..] else { return Table::new::<String>(&[]) };
    let count = study.plan.count;
    let at = |column: usize, row: usize| &study.placements[column * count + row];
    let value =
        |axis: Axis, placement: &OffsetPlacement| format_number(in_axis_unit(axis, placement.offset[axis as usize]), 3);
    let corner = format!("{} {} \\ {} {}", axis_name(up), axis_unit(up), axis_name(across), axis_unit(across));
    let mut rows = vec![std::iter::once(corner).chain((0..count).map(|column| value(across, at(column, 0)))).collect()];
    for index in (0..count).rev() {
        let marks = (0..count).map(|column| at(column, index).fate.unwrap_or("–").to_string());
        rows.push(std::iter::once(value(up, at(0, index))).chain(marks).collect::<Vec<String>>());
    }
    Table::new(&rows)
}

/// Returns all offsets as CSV, one per line. Unknown values are empty.
pub(crate) fn offsets_csv(study: &Offsets) -> String {
    const COLUMNS: &str = "offset_x_m offset_y_m offset_angle_rad fate fate_reason tts_s x_m y_m angle_rad \
                           slip_m=slip/displacement_m slip_rad=slip/rotation_rad steps reason";
    rows_csv(study.placements.iter().map(|placement| json!(placement)), COLUMNS)
}
