//! Report of the positioning errors that a gripper captures: tables, JSON and CSV.

use serde::Serialize;

use super::tables::milliseconds;
use crate::criteria::Travel;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::report::{Report, Table, ToReport};
use crate::study::capture::{Capture, Edge, Placement};
use crate::units::Dimension;

/// Positioning errors that a gripper captures.
#[derive(Clone, Debug, Serialize)]
pub struct CaptureReport {
    /// Name of the scene.
    pub scene: String,
    pub model: &'static str,
    pub palm_width_m: f64,
    /// Largest positioning error for which the gripper is designed.
    pub positioning_error_m: f64,
    /// Lower end of the range about the middle in which the object is captured; null if it is not captured in the
    /// middle.
    pub captured_from_m: Option<f64>,
    /// Upper end of the range of `captured_from_m`; null likewise.
    pub captured_to_m: Option<f64>,
    /// Nearest offset below the range at which it is not captured; null if it is captured up to the requested limit.
    pub lost_left_m: Option<f64>,
    /// Nearest offset above the range at which it is not captured.
    pub lost_right_m: Option<f64>,
    #[serde(rename = "places")]
    pub placements: Vec<PlacementReport>,
}

/// One initial position of the object.
#[derive(Clone, Debug, Serialize)]
pub struct PlacementReport {
    pub offset_m: f64,
    /// Whether a grasp at the initial position is form-closed; null if the fingers cannot reach around the object
    /// there.
    #[serde(rename = "form_closed_there")]
    pub initial_form_closed: Option<bool>,
    /// `held`, `dropped`, `ejected` or `not grasped`; null if the run was not completed.
    pub fate: Option<&'static str>,
    pub tts_s: Option<f64>,
    /// Final position of the object.
    pub x_m: Option<f64>,
    pub y_m: Option<f64>,
    pub angle_rad: Option<f64>,
    pub speed_m_s: Option<f64>,
    /// Slip after the time from which the object is held to the end.
    pub slip: Option<Travel>,
    /// Whether the contacts at the end are form-closed, if the object is held.
    pub form_closed: Option<bool>,
    pub steps: Option<u64>,
    /// Reason why the run was not completed.
    pub reason: Option<String>,
}

impl From<&Capture> for CaptureReport {
    fn from(found: &Capture) -> Self {
        let edge = |index: usize, value: fn(&Edge) -> Option<f64>| {
            found.captured_range.as_ref().and_then(|edges| value(&edges[index]))
        };
        CaptureReport {
            scene: found.scene.clone(),
            model: found.plan.model.name(),
            palm_width_m: found.palm_width_m,
            positioning_error_m: found.plan.error_m,
            captured_from_m: edge(0, |edge| Some(edge.captured_m)),
            captured_to_m: edge(1, |edge| Some(edge.captured_m)),
            lost_left_m: edge(0, |edge| edge.lost_m),
            lost_right_m: edge(1, |edge| edge.lost_m),
            placements: found.placements.iter().map(PlacementReport::from).collect(),
        }
    }
}

impl From<&Placement> for PlacementReport {
    fn from(placement: &Placement) -> Self {
        let found = placement.outcome.as_ref().ok();
        PlacementReport {
            offset_m: placement.offset_m,
            initial_form_closed: placement.geometric_form_closed,
            fate: found.map(|found| found.fate.name()),
            tts_s: found.and_then(|found| found.tts_s),
            x_m: found.map(|found| found.centre_m[0]),
            y_m: found.map(|found| found.centre_m[1]),
            angle_rad: found.map(|found| found.angle_rad),
            speed_m_s: found.map(|found| found.speed_m_s),
            slip: found.and_then(|found| found.slip),
            form_closed: found.and_then(|found| found.form_closed),
            steps: found.map(|found| found.steps),
            reason: placement.outcome.as_ref().err().cloned(),
        }
    }
}

impl ToReport for CaptureReport {
    fn report(&self) -> Report {
        let millimetres = |metres: f64| format_number(zero_below_resolution(metres, Dimension::Length) * 1e3, 4);
        let mut text = Report::from(format!(
            "{}: {} model, palm {} mm wide, designed for errors up to ±{} mm\n\n",
            self.scene,
            self.model,
            millimetres(self.palm_width_m),
            millimetres(self.positioning_error_m)
        ));
        let mut rows = vec![
            row(["start", "form-closed", "fate", "end", "", "speed,", "tts,", "slip,", "form-closed"]),
            row(["x, mm", "at start", "", "x, mm", "y, mm", "mm/s", "ms", "mm", "at the end"]),
        ];
        let or_dash = |value: Option<f64>| value.map_or("–".to_string(), millimetres);
        for placement in &self.placements {
            rows.push(row([
                &signed(placement.offset_m),
                yes_or_no(placement.initial_form_closed),
                placement.fate.unwrap_or("failed"),
                &placement.x_m.map_or("–".to_string(), signed),
                &or_dash(placement.y_m),
                &or_dash(placement.speed_m_s),
                &milliseconds(placement.tts_s),
                &or_dash(placement.slip.map(|slip| slip.displacement_m)),
                yes_or_no(placement.form_closed),
            ]));
        }
        text.push(Table::new(&rows).header_rows(2));
        for line in [captured_range(self), centring(self), form_closure(self)] {
            text.push(Report::paragraph(&format!("\n{line}\n")));
        }
        for placement in &self.placements {
            if let Some(reason) = &placement.reason {
                text.push_str(&format!("at {} mm: {reason}\n", signed(placement.offset_m)));
            }
        }
        text
    }
}

/// Formats a length in mm with its sign.
fn signed(metres: f64) -> String {
    let metres = zero_below_resolution(metres, Dimension::Length);
    let text = format_number(metres.abs() * 1e3, 4);
    match metres {
        metres if metres > 0.0 => format!("+{text}"),
        metres if metres < 0.0 => format!("−{text}"),
        _ => text,
    }
}

fn yes_or_no(flag: Option<bool>) -> &'static str {
    match flag {
        Some(true) => "yes",
        Some(false) => "no",
        None => "–",
    }
}

fn captured_range(report: &CaptureReport) -> String {
    let (Some(from), Some(to)) = (report.captured_from_m, report.captured_to_m) else {
        return "Captured: no range; an object in the middle of the palm is not held.".to_string();
    };
    let end = |captured: f64, lost: Option<f64>| match lost {
        Some(lost) => format!("{} mm (not at {} mm)", signed(captured), signed(lost)),
        None => format!("{} mm (the requested limit)", signed(captured)),
    };
    format!("Captured: from {} to {}.", end(from, report.lost_left_m), end(to, report.lost_right_m))
}

/// Reports how far the held objects are centred.
fn centring(report: &CaptureReport) -> String {
    let held = report.placements.iter().filter(|placement| placement.fate == Some("held"));
    let ends: Vec<(f64, f64)> =
        held.filter_map(|placement| Some((placement.offset_m.abs(), placement.x_m?.abs()))).collect();
    let off_centre: Vec<&(f64, f64)> = ends.iter().filter(|(start, _)| *start > 0.0).collect();
    let Some(worst) = off_centre.iter().map(|(_, end)| *end).max_by(f64::total_cmp) else {
        return "Centred: no object that starts away from the middle is held.".to_string();
    };
    let centring_count = off_centre.iter().filter(|(start, end)| end < start).count();
    format!(
        "Centred: {centring_count} of {} held objects that start away from the middle end closer to it; all end within {} mm of it.",
        off_centre.len(),
        format_number(worst * 1e3, 4)
    )
}

/// Reports whether grasps that are not form-closed become so, which is a question of the thesis.
fn form_closure(report: &CaptureReport) -> String {
    let held: Vec<&PlacementReport> =
        report.placements.iter().filter(|placement| placement.fate == Some("held")).collect();
    let was_open = |placement: &&&PlacementReport| placement.initial_form_closed != Some(true);
    let initially_open = held.iter().filter(was_open).count();
    let became_closed = held.iter().filter(was_open).filter(|placement| placement.form_closed == Some(true));
    let closed = held.iter().filter(|placement| placement.form_closed == Some(true)).count();
    format!(
        "Form closure: {initially_open} of {} held objects start where no form-closed grasp with all phalanges exists; {} of them \
         are form-closed at the end.\nAt the end, {closed} of {} are form-closed.",
        held.len(),
        became_closed.count(),
        held.len()
    )
}

/// Returns all initial positions as CSV, one per line. Unknown values are empty.
pub fn capture_csv(report: &CaptureReport) -> String {
    let mut text =
        "offset_m,form_closed_there,fate,tts_s,x_m,y_m,angle_rad,speed_m_s,slip_m,slip_rad,form_closed,steps,reason\n"
            .to_string();
    for placement in &report.placements {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
        let flag = |value: Option<bool>| value.map_or(String::new(), |value| value.to_string());
        let cells = [
            format!("{:?}", placement.offset_m),
            flag(placement.initial_form_closed),
            placement.fate.unwrap_or_default().to_string(),
            number(placement.tts_s),
            number(placement.x_m),
            number(placement.y_m),
            number(placement.angle_rad),
            number(placement.speed_m_s),
            number(placement.slip.map(|slip| slip.displacement_m)),
            number(placement.slip.map(|slip| slip.rotation_rad)),
            flag(placement.form_closed),
            placement.steps.map_or(String::new(), |steps| steps.to_string()),
            placement.reason.as_ref().map_or(String::new(), |reason| format!("\"{}\"", reason.replace('"', "\"\""))),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
