//! What a gripper captures, as tables, JSON and CSV.

use serde::Serialize;

use super::tables::milliseconds;
use crate::criteria::Travel;
use crate::study::capture::{Capture, Edge, Placed};
use crate::units::Dimension;
use crate::wording::figures::{figure, resolved, row};
use crate::wording::report::{Report, Reported, Table};

/// Which positioning errors a gripper captures.
#[derive(Clone, Debug, Serialize)]
pub struct CaptureReport {
    /// Name of the scene.
    pub scene: String,
    pub model: &'static str,
    pub palm_width_m: f64,
    /// Largest positioning error, for which the gripper is made.
    pub positioning_error_m: f64,
    /// Ends of the range about the middle in which the object is captured; null if it is not captured in the middle.
    pub captured_from_m: Option<f64>,
    pub captured_to_m: Option<f64>,
    /// The nearest offsets outside at which it is not; null where it is captured as far as was asked.
    pub lost_left_m: Option<f64>,
    pub lost_right_m: Option<f64>,
    pub places: Vec<PlaceReport>,
}

/// One place of the object.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceReport {
    pub offset_m: f64,
    /// Whether the grasp would be form-closed if the object stayed there; null where the fingers cannot reach around it.
    pub form_closed_there: Option<bool>,
    /// `held`, `dropped`, `ejected` or `not grasped`; null where the run was not completed.
    pub fate: Option<&'static str>,
    pub tts_s: Option<f64>,
    /// The object at the end.
    pub x_m: Option<f64>,
    pub y_m: Option<f64>,
    pub angle_rad: Option<f64>,
    pub speed_m_s: Option<f64>,
    /// Since it is held for good.
    pub slip: Option<Travel>,
    /// Of the contacts at the end, where it is held.
    pub form_closed: Option<bool>,
    pub steps: Option<u64>,
    /// Why there is nothing.
    pub reason: Option<String>,
}

impl From<&Capture> for CaptureReport {
    fn from(found: &Capture) -> Self {
        let edge = |index: usize, of: fn(&Edge) -> Option<f64>| found.captured.as_ref().and_then(|all| of(&all[index]));
        CaptureReport {
            scene: found.scene.clone(),
            model: found.plan.model.name(),
            palm_width_m: found.palm_width_m,
            positioning_error_m: found.plan.error_m,
            captured_from_m: edge(0, |edge| Some(edge.captured_m)),
            captured_to_m: edge(1, |edge| Some(edge.captured_m)),
            lost_left_m: edge(0, |edge| edge.lost_m),
            lost_right_m: edge(1, |edge| edge.lost_m),
            places: found.placed.iter().map(PlaceReport::from).collect(),
        }
    }
}

impl From<&Placed> for PlaceReport {
    fn from(placed: &Placed) -> Self {
        let found = placed.found.as_ref().ok();
        PlaceReport {
            offset_m: placed.offset_m,
            form_closed_there: placed.closed_there,
            fate: found.map(|found| found.fate.name()),
            tts_s: found.and_then(|found| found.tts_s),
            x_m: found.map(|found| found.centre_m[0]),
            y_m: found.map(|found| found.centre_m[1]),
            angle_rad: found.map(|found| found.angle_rad),
            speed_m_s: found.map(|found| found.speed_m_s),
            slip: found.and_then(|found| found.slip),
            form_closed: found.and_then(|found| found.form_closed),
            steps: found.map(|found| found.steps),
            reason: placed.found.as_ref().err().cloned(),
        }
    }
}

/// A table for people, and what it comes to.
impl Reported for CaptureReport {
    fn report(&self) -> Report {
        let millimetres = |metres: f64| figure(resolved(metres, Dimension::Length) * 1e3, 4);
        let mut text = Report::from(format!(
            "{}: {} model, palm {} mm wide, made for errors up to ±{} mm\n\n",
            self.scene,
            self.model,
            millimetres(self.palm_width_m),
            millimetres(self.positioning_error_m)
        ));
        let mut rows = vec![
            row(["object at", "form-closed", "fate", "ends at", "", "speed,", "tts,", "slip,", "form-closed"]),
            row(["x, mm", "there", "", "x, mm", "y, mm", "mm/s", "ms", "mm", "at the end"]),
        ];
        let or_dash = |value: Option<f64>| value.map_or("–".to_string(), millimetres);
        for place in &self.places {
            rows.push(row([
                &signed(place.offset_m),
                word(place.form_closed_there),
                place.fate.unwrap_or("failed"),
                &place.x_m.map_or("–".to_string(), signed),
                &or_dash(place.y_m),
                &or_dash(place.speed_m_s),
                &milliseconds(place.tts_s),
                &or_dash(place.slip.map(|slip| slip.displacement_m)),
                word(place.form_closed),
            ]));
        }
        text.push(Table::new(&rows).heads(2));
        for line in [range(self), centring(self), closure(self)] {
            text.push(Report::paragraph(&format!("\n{line}\n")));
        }
        for place in &self.places {
            if let Some(reason) = &place.reason {
                text.push_str(&format!("at {} mm: {reason}\n", signed(place.offset_m)));
            }
        }
        text
    }
}

fn signed(metres: f64) -> String {
    let metres = resolved(metres, Dimension::Length);
    let text = figure(metres.abs() * 1e3, 4);
    match metres {
        metres if metres > 0.0 => format!("+{text}"),
        metres if metres < 0.0 => format!("−{text}"),
        _ => text,
    }
}

fn word(flag: Option<bool>) -> &'static str {
    match flag {
        Some(true) => "yes",
        Some(false) => "no",
        None => "–",
    }
}

fn range(report: &CaptureReport) -> String {
    let (Some(from), Some(to)) = (report.captured_from_m, report.captured_to_m) else {
        return "Captured: nothing; even an object in the middle of the palm is not held.".to_string();
    };
    let end = |at: f64, lost: Option<f64>| match lost {
        Some(lost) => format!("{} mm (at {} mm it is not)", signed(at), signed(lost)),
        None => format!("{} mm (as far as was asked)", signed(at)),
    };
    format!("Captured: from {} to {}.", end(from, report.lost_left_m), end(to, report.lost_right_m))
}

/// Where the captured objects end.
fn centring(report: &CaptureReport) -> String {
    let held = report.places.iter().filter(|place| place.fate == Some("held"));
    let ends: Vec<(f64, f64)> = held.filter_map(|place| Some((place.offset_m.abs(), place.x_m?.abs()))).collect();
    let off: Vec<&(f64, f64)> = ends.iter().filter(|(start, _)| *start > 0.0).collect();
    let Some(worst) = off.iter().map(|(_, end)| *end).max_by(f64::total_cmp) else {
        return "Centred: none of those that lay off the middle is held.".to_string();
    };
    let nearer = off.iter().filter(|(start, end)| end < start).count();
    format!(
        "Centred: {nearer} of {} that lay off the middle end nearer to it; all end within {} mm of it.",
        off.len(),
        figure(worst * 1e3, 4)
    )
}

/// The thesis' question: does a grasp that is not form-closed become so?
fn closure(report: &CaptureReport) -> String {
    let held: Vec<&PlaceReport> = report.places.iter().filter(|place| place.fate == Some("held")).collect();
    let not_there = held.iter().filter(|place| place.form_closed_there != Some(true)).count();
    let became = held.iter().filter(|place| place.form_closed_there != Some(true) && place.form_closed == Some(true));
    let closed = held.iter().filter(|place| place.form_closed == Some(true)).count();
    format!(
        "Form closure: {not_there} of {} held objects lay where no form-closed grasp of all phalanges would be; {} of them came into one.\nAt \
         the end {closed} of {} are form-closed.",
        held.len(),
        became.count(),
        held.len()
    )
}

/// All places, one a line; what is unknown is empty.
pub fn capture_csv(report: &CaptureReport) -> String {
    let mut text =
        "offset_m,form_closed_there,fate,tts_s,x_m,y_m,angle_rad,speed_m_s,slip_m,slip_rad,form_closed,steps,reason\n"
            .to_string();
    for place in &report.places {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
        let flag = |value: Option<bool>| value.map_or(String::new(), |value| value.to_string());
        let cells = [
            format!("{:?}", place.offset_m),
            flag(place.form_closed_there),
            place.fate.unwrap_or_default().to_string(),
            number(place.tts_s),
            number(place.x_m),
            number(place.y_m),
            number(place.angle_rad),
            number(place.speed_m_s),
            number(place.slip.map(|slip| slip.displacement_m)),
            number(place.slip.map(|slip| slip.rotation_rad)),
            flag(place.form_closed),
            place.steps.map_or(String::new(), |steps| steps.to_string()),
            place.reason.as_ref().map_or(String::new(), |reason| format!("\"{}\"", reason.replace('"', "\"\""))),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
