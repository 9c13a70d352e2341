//! Error of a contact force against the step size: one line per formulation, solid for the curve and faint for the
//! peak.

use super::{ERROR_LEVELS, Formulation, Row, StepSize};
use crate::plot::axis::Axis;
use crate::plot::canvas::{LegendEntry, Marker, THIN_LINE, chart, horizontal_line, line, points};
use crate::plot::theme::{AMBER, Colour, GREEN, ORANGE, SOFT};

const HEIGHT: f64 = 600.0;

impl StepSize {
    /// Draws errors over step size; errors of zero are omitted.
    pub fn picture(&self) -> String {
        let errors = self.rows.iter().flat_map(|row| [row.curve_max_error, row.peak_error]);
        let steps = self.rows.iter().map(|row| row.step_fraction);
        let x = Axis::logarithmic("step, part of the plotted time", steps, 12.0).with_margin();
        let y = Axis::logarithmic("error of the contact force, relative to its peak", errors.chain(ERROR_LEVELS), 12.0);
        chart(&format!("{}: contact force against step size", self.scene), HEIGHT, &x, &y, |svg, frame| {
            for error_level in ERROR_LEVELS {
                horizontal_line(svg, frame, y.coordinate(error_level), THIN_LINE, SOFT);
            }
            let peak_marker = Marker::FaintLine { width: 3.0 };
            let mut entries = Vec::new();
            for formulation in Formulation::ALL {
                let (marker, colour) = style(formulation);
                let error_curve = |error: fn(&Row) -> f64| -> Vec<(f64, f64)> {
                    let rows = self.rows.iter().filter(|row| row.formulation == formulation && error(row) > 0.0);
                    rows.map(|row| (x.coordinate(row.step_fraction), y.coordinate(error(row)))).collect()
                };
                line(svg, frame, error_curve(|row| row.peak_error), peak_marker, colour);
                let max_errors = error_curve(|row| row.curve_max_error);
                line(svg, frame, max_errors.clone(), THIN_LINE, colour);
                points(svg, frame, max_errors, marker, colour);
                entries.push(LegendEntry::new(marker, colour, formulation.name()));
            }
            entries.push(LegendEntry::new(THIN_LINE, SOFT, "60, 10, 1, 0.01 %"));
            entries.push(LegendEntry::new(peak_marker, SOFT, "faint: the peak only"));
            entries
        })
    }
}

fn style(formulation: Formulation) -> (Marker, Colour) {
    match formulation {
        Formulation::EngineLaws => (Marker::Square, GREEN),
        Formulation::EngineRapier => (Marker::Cross, AMBER),
        Formulation::Analytic => (Marker::Circle, ORANGE),
    }
}
