//! Report of the positioning errors that a gripper captures: tables and CSV.

use serde_json::json;

use super::rows_csv;
use super::tables::milliseconds;
use crate::criteria::GraspCriteria;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::report::{Report, Table, ToReport};
use crate::study::capture::{Capture, Edge, Placement};
use crate::units::Dimension;

impl ToReport for Capture {
    fn report(&self) -> Report {
        let mut text = Report::from(format!(
            "{}: {} model, palm {} mm wide, designed for errors up to ±{} mm\n\n",
            self.scene,
            self.plan.model.name(),
            millimetres(self.palm_width_m),
            millimetres(self.plan.error_m)
        ));
        let mut rows = vec![
            row(["start", "form-closed", "fate", "end", "", "speed,", "tts,", "slip,", "form-closed"]),
            row(["x, mm", "at start", "", "x, mm", "y, mm", "mm/s", "ms", "mm", "at the end"]),
        ];
        let or_dash = |value: Option<f64>| value.map_or("–".to_string(), millimetres);
        for Placement { offset_m, geometric_form_closed, outcome } in &self.placements {
            let found = outcome.as_ref().ok().map(|found| &found.criteria);
            rows.push(row([
                &signed(*offset_m),
                yes_or_no(*geometric_form_closed),
                found.map_or("failed", |found| found.fate.name()),
                &found.map_or("–".to_string(), |found| signed(found.end.centre_m[0])),
                &or_dash(found.map(|found| found.end.centre_m[1])),
                &or_dash(found.map(GraspCriteria::end_speed_m_s)),
                &milliseconds(found.and_then(|found| found.tts_s)),
                &or_dash(found.and_then(|found| Some(found.slip?.displacement_m))),
                yes_or_no(outcome.as_ref().ok().and_then(|found| found.form_closed)),
            ]));
        }
        text.push(Table::new(&rows).header_rows(2));
        for line in [captured_range(self), centring(self), form_closure(self)] {
            text.push(Report::paragraph(&format!("\n{line}\n")));
        }
        for Placement { offset_m, outcome, .. } in &self.placements {
            if let Err(reason) = outcome {
                text.push_str(&format!("at {} mm: {reason}\n", signed(*offset_m)));
            }
        }
        text
    }
}

/// Formats a length in mm; lengths below the resolution are 0.
fn millimetres(metres: f64) -> String {
    format_number(zero_below_resolution(metres, Dimension::Length) * 1e3, 4)
}

/// Formats a length in mm with its sign.
fn signed(metres: f64) -> String {
    let sign = match zero_below_resolution(metres, Dimension::Length) {
        metres if metres > 0.0 => "+",
        metres if metres < 0.0 => "−",
        _ => "",
    };
    format!("{sign}{}", millimetres(metres.abs()))
}

fn yes_or_no(flag: Option<bool>) -> &'static str {
    flag.map_or("–", |flag| if flag { "yes" } else { "no" })
}

fn captured_range(study: &Capture) -> String {
    let Some(edges) = study.captured_range else {
        return "Captured: no range; an object in the middle of the palm is not held.".to_string();
    };
    let [from, to] = edges.map(|Edge { captured_m, lost_m }| match lost_m {
        Some(lost_m) => format!("{} mm (not at {} mm)", signed(captured_m), signed(lost_m)),
        None => format!("{} mm (the requested limit)", signed(captured_m)),
    });
    format!("Captured: from {from} to {to}.")
}

/// Reports how far the held objects are centred.
fn centring(study: &Capture) -> String {
    let held = study.placements.iter().filter(|placement| placement.is_captured() && placement.offset_m != 0.0);
    let ends =
        held.filter_map(|it| Some((it.offset_m.abs(), it.outcome.as_ref().ok()?.criteria.end.centre_m[0].abs())));
    let Some(worst_m) = ends.clone().map(|(_, end)| end).max_by(f64::total_cmp) else {
        return "Centred: no object that starts away from the middle is held.".to_string();
    };
    format!(
        "Centred: {} of {} held objects that start away from the middle end closer to it; all end within {} mm of it.",
        ends.clone().filter(|(start, end)| end < start).count(),
        ends.count(),
        format_number(worst_m * 1e3, 4)
    )
}

/// Reports whether grasps that are not form-closed become so, which is a question of the thesis.
fn form_closure(study: &Capture) -> String {
    let held = study.placements.iter().filter(|placement| placement.is_captured());
    let is_closed = |it: &&Placement| it.outcome.as_ref().is_ok_and(|found| found.form_closed == Some(true));
    let initially_open = held.clone().filter(|placement| placement.geometric_form_closed != Some(true));
    format!(
        "Form closure: {} of {} held objects start where no form-closed grasp with all phalanges exists; {} of them \
         are form-closed at the end.\nAt the end, {} of {} are form-closed.",
        initially_open.clone().count(),
        held.clone().count(),
        initially_open.filter(is_closed).count(),
        held.clone().filter(is_closed).count(),
        held.count()
    )
}

/// Returns all initial positions as CSV, one per line. Unknown values are empty.
pub(crate) fn capture_csv(study: &Capture) -> String {
    let columns = [
        "offset_m",
        "form_closed_there",
        "fate",
        "tts_s",
        "x_m",
        "y_m",
        "angle_rad",
        "speed_m_s",
        "slip_m=slip/displacement_m",
        "slip_rad=slip/rotation_rad",
        "form_closed",
        "steps",
        "reason",
    ];
    rows_csv(study.placements.iter().map(|placement| json!(placement)), &columns)
}
